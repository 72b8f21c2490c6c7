"""Solids as triangles: what a vehicle, an arrow or a set of forces is drawn with."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph.analysis.polytope import Polytope
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.geometry import propeller_radius
from omnimorph.protocols import FloatArray


class Mesh(NamedTuple):
    """Triangles.

    Attributes
    ----------
    vertices : (V, 3) array
        In the unit and frame of the solid.
    faces : (F, 3) array of int
        Rows of `vertices`, counter-clockwise seen from outside.
    """

    vertices: FloatArray
    faces: NDArray[np.int64]


def joined(meshes: list[Mesh]) -> Mesh:
    """Return several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(faces))


def sphere(radius: float, centre: ArrayLike = (0.0, 0.0, 0.0), rings: int = 10) -> Mesh:
    """Return a sphere; `rings` circles of latitude, twice as many of longitude."""
    turn = np.linspace(0.0, np.pi, rings + 1)
    profile = radius * np.column_stack([np.sin(turn), -np.cos(turn)])
    return _revolved(profile, 2 * rings, np.eye(3), np.asarray(centre, dtype=np.float64))


def rod(begin: FloatArray, end: FloatArray, radius: float, sides: int = 12) -> Mesh:
    """Return a cylinder from one (3,) point to another, closed at both ends."""
    along = end - begin
    length = float(np.linalg.norm(along))
    profile = np.array([[0.0, 0.0], [radius, 0.0], [radius, length], [0.0, length]])
    return _revolved(profile, sides, turned_to(along / length), begin)


def disc(radius: float, height: float, sides: int = 32) -> Mesh:
    """Return a flat cylinder about z, in the middle of its height at zero."""
    up = np.array([0.0, 0.0, 0.5 * height])
    return rod(-up, up, radius, sides)


def ring(inner: float, outer: float, height: float, sides: int = 32) -> Mesh:
    """Return a flat ring about z, in the middle of its height at zero."""
    low, high = -0.5 * height, 0.5 * height
    corners = [(inner, low), (outer, low), (outer, high), (inner, high), (inner, low)]
    return _revolved(np.array(corners), sides, np.eye(3), np.zeros(3))


def tile(radius: float, sides: int = 6) -> Mesh:
    """Return a flat polygon at z = 0 that is seen from above."""
    turn = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    rim = radius * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(sides)])
    return Mesh(rim, _fan(np.arange(sides)))


def blades(radius: float) -> Mesh:
    """Return a propeller of two blades about z: pitched as one that lifts counter-clockwise."""
    chord, pitch = 0.14 * radius, 0.35
    edge = 0.5 * chord * np.array([np.cos(pitch), np.sin(pitch)])
    thick = 0.025 * radius
    root, tip = 0.08 * radius, 0.96 * radius
    corners = [
        (along, side * edge[0] * width, side * edge[1] * width + up)
        for along, width in ((root, 1.0), (tip, 0.6))
        for side, up in ((-1.0, -thick), (1.0, -thick), (1.0, thick), (-1.0, thick))
    ]
    blade = Mesh(np.array(corners), _BOX)
    other = Mesh(blade.vertices * np.array([-1.0, -1.0, 1.0]), _BOX)
    return joined([blade, other, disc(0.1 * radius, 0.1 * radius, 16)])


def frame_of(vehicle: Vehicle) -> Mesh:
    """Return what carries the rotors: a hub in the middle, an arm to each, a motor at its end."""
    hubs, radius = vehicle.rotor_position, propeller_radius(vehicle)
    middle = np.zeros(3)
    parts = [sphere(0.34 * radius)]
    parts += [rod(middle, hub, 0.055 * radius) for hub in hubs if np.linalg.norm(hub) > 1e-9]
    parts += [sphere(0.13 * radius, hub, rings=6) for hub in hubs]
    return joined(parts)


def polytope_mesh(polytope: Polytope, thickness: float) -> Mesh:
    """Return a set of R³ as a solid; a plane, a line or a point gets a little thickness.

    Parameters
    ----------
    polytope : Polytope
        Of any dimension, not empty.
    thickness : float
        In the unit of the set.
    """
    corners = polytope.vertices
    if polytope.dimension == 3:
        fans = [_fan(polygon) for polygon in polytope.facets]
        return Mesh(corners, np.vstack(fans))
    if polytope.dimension == 2:
        return _plate(polytope, thickness)
    if polytope.dimension == 1:
        return rod(corners[0], corners[-1], thickness)
    return sphere(2.0 * thickness, corners[0], rings=6)


def turned_to(axis: FloatArray) -> FloatArray:
    """Return a rotation matrix, (3, 3), that turns z to a unit vector, and others with it."""
    first = across(axis)
    return np.column_stack([first, np.cross(axis, first), axis])


def across(axis: FloatArray) -> FloatArray:
    """Return unit vectors at right angles to unit vectors: (…, 3)."""
    helper = np.eye(3)[np.abs(axis).argmin(axis=-1)]
    side = np.cross(axis, helper)
    out: FloatArray = side / np.linalg.norm(side, axis=-1, keepdims=True)
    return out


def wxyz_of(R: FloatArray) -> FloatArray:
    """Return rotation matrices, (…, 3, 3), as unit quaternions, (…, 4) with the scalar first."""
    from scipy.spatial.transform import Rotation

    flat = Rotation.from_matrix(R.reshape(-1, 3, 3)).as_quat(scalar_first=True)
    wxyz: FloatArray = flat.reshape(*R.shape[:-2], 4)
    return wxyz


_BOX = np.array(
    [
        *([0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]),
        *([0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5]),
        *([2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]),
    ]
)


def _revolved(profile: FloatArray, sides: int, R: FloatArray, origin: FloatArray) -> Mesh:
    """Return a profile of (radius, height) turned about z, then rotated by R and moved."""
    turn = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    radius, height = profile[:, 0], profile[:, 1]
    points = np.empty((len(profile), sides, 3))
    points[..., :2] = radius[:, None, None] * ring
    points[..., 2] = height[:, None]
    k = np.arange(len(profile) - 1)[:, None] * sides
    here, beside = np.arange(sides), (np.arange(sides) + 1) % sides
    quads = np.stack([k + here, k + beside, k + sides + beside, k + sides + here], axis=-1)
    quads = quads.reshape(-1, 4)
    faces = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return Mesh(points.reshape(-1, 3) @ R.T + origin, faces)


def _fan(polygon: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return a convex polygon as triangles."""
    first = np.full(len(polygon) - 2, polygon[0])
    return np.column_stack([first, polygon[1:-1], polygon[2:]])


def _plate(polytope: Polytope, thickness: float) -> Mesh:
    """Return a plane set with its two sides apart."""
    rim, count = polytope.vertices, len(polytope.vertices)
    across_flat = np.cross(rim, np.roll(rim, -1, axis=0)).sum(axis=0)  # the rim goes round it
    half = 0.5 * thickness * across_flat / np.linalg.norm(across_flat)
    k = np.arange(count)
    after = (k + 1) % count
    top = np.column_stack([np.full(count - 2, 0), k[1:-1], k[2:]])
    sides = np.column_stack([k + count, after + count, after, k])
    faces = np.vstack([top, top[:, ::-1] + count, sides[:, :3], sides[:, [0, 2, 3]]])
    return Mesh(np.vstack([rim + half, rim - half]), faces)
