"""In which share of all attitudes a vehicle can hover at one tilt.

The weight, seen from the body, is a point of a sphere; where the zero-moment force set holds it,
the vehicle can hover. A set with an interior cuts out an area, whose share is counted on points
spread evenly over the sphere. A degenerate set (line, plane) meets the sphere in single points or
in a curve: these have no area, whatever a grid that happens to hold one of them would count.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from omnimorph.analysis.hover import sphere_directions
from omnimorph.analysis.polytope import Polytope
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

_SAMPLED = 10_000
_TURN = 2.0 * math.pi


class AttitudeShare(NamedTuple):
    """Of all attitudes, those in which a vehicle can hover.

    Attributes
    ----------
    share : float
        Of the sphere of the vertical seen from the body, 0 to 1, to about 1e-4; 0 where they have
        no area.
    words : str
        The same to be read: ``12.3 %``, ``all``, ``level only``, ``none``.
    """

    share: float
    words: str


def attitude_share(vehicle: Vehicle, forces: Polytope) -> AttitudeShare:
    """Return in which share of all attitudes a vehicle can hover.

    Parameters
    ----------
    vehicle : Vehicle
        Its mass counts.
    forces : Polytope
        Its force set at zero moment, N, at some tilt.

    Examples
    --------
    Parallel rotors hold the weight level and nowhere else.

    >>> import omnimorph as om
    >>> vehicle = om.load_vehicle("quadrotor")
    >>> attitude_share(vehicle, om.analysis.force_set(vehicle, 0.0, zero_moment=True))
    AttitudeShare(share=0.0, words='level only')
    """
    if forces.dimension < 3:
        return AttitudeShare(0.0, _words_of_few(single_attitudes(vehicle, forces), forces))
    weight = vehicle.mass * GRAVITY
    inside = (weight * _DIRECTIONS @ forces.normals.T <= forces.offsets).all(axis=1)
    share = float(inside.mean())
    if 0.0 < share < 1.0:
        return AttitudeShare(share, f"{100.0 * share:.3g} %")
    if share == 1.0:
        all_of_them = forces.inscribed_radius >= (1.0 - 1e-9) * weight
        return AttitudeShare(share, "all" if all_of_them else "all but less than 0.01 %")
    farthest = float(np.linalg.norm(forces.vertices, axis=1).max())
    meets = _least_force(forces) <= weight <= farthest
    return AttitudeShare(share, "less than 0.01 %" if meets else "none")


def _least_force(forces: Polytope) -> float:
    """Return the distance of a set of forces from zero, N; 0 if it holds zero.

    C. L. Lawson, R. J. Hanson, "Solving Least Squares Problems", 1974, chapter 23 (LDP).
    """
    from scipy.optimize import nnls

    constraints = np.vstack([-forces.normals.T, -forces.offsets])
    goal = np.append(np.zeros(3), 1.0)
    multipliers, _ = nnls(constraints, goal)
    residual = constraints @ multipliers - goal
    return float(np.linalg.norm(residual[:3]) / -residual[3])


_DIRECTIONS = sphere_directions(_SAMPLED)


def single_attitudes(vehicle: Vehicle, one: Polytope) -> FloatArray:
    """Return the attitudes, (D, 3), in which a degenerate set of forces holds the weight.

    Up to two for a line; for a plane the points of a circle half a degree apart.
    """
    weight = vehicle.mass * GRAVITY
    if one.dimension not in (1, 2):
        return np.empty((0, 3))
    middle = one.vertices.mean(axis=0)
    along = np.linalg.svd(one.vertices - middle)[2][: one.dimension]
    foot = middle - along.T @ (along @ middle)
    rest = weight**2 - float(foot @ foot)
    if rest < 0.0:
        return np.empty((0, 3))
    turn = np.linspace(0.0, _TURN, 720, endpoint=False)
    ways = [[1.0], [-1.0]] if len(along) == 1 else np.column_stack([np.cos(turn), np.sin(turn)])
    points = foot + math.sqrt(rest) * np.asarray(ways) @ along
    return np.array([point / weight for point in points if one.contains(point)]).reshape(-1, 3)


def _words_of_few(up: FloatArray, forces: Polytope) -> str:
    """Return which attitudes those are that have no area."""
    if not len(up):
        return "none"
    if forces.dimension == 2:
        return "single ones about one axis"
    names = [_name(float(z)) for z in up[:, 2]]
    if names == ["one leaning"] * 2:
        return "two leaning only"
    return f"{' and '.join(sorted(names))} only"


def _name(height: float) -> str:
    """Return what an attitude is called by the height of the vertical along z of the body."""
    if abs(height) < 1.0 - 1e-9:
        return "one leaning"
    return "level" if height > 0.0 else "upside down"
