"""Solids are closed, the right way out, and as large as what they stand for."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

import omnimorph as om
from omnimorph.viewer import shapes
from omnimorph.viewer.shapes import Mesh

OMNIMORPH = om.load_vehicle("omnimorph")


def volume(mesh: Mesh) -> float:
    """By the divergence theorem; positive if the faces look outwards."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def is_closed(mesh: Mesh) -> bool:
    """Every edge between points at different places is walked once each way."""
    places = np.unique(mesh.vertices.round(9), axis=0, return_inverse=True)[1].ravel()
    faces = places[mesh.faces]
    edges = Counter((a, b) for face in faces for a, b in zip(face, np.roll(face, -1), strict=True))
    return all(edges[b, a] == count for (a, b), count in edges.items() if a != b)


def polygon_area(sides: int) -> float:
    return 0.5 * sides * math.sin(2 * math.pi / sides)


def test_a_rod_is_a_closed_cylinder() -> None:
    rod = shapes.rod(np.array([1.0, 2.0, 3.0]), np.array([1.0, 4.0, 3.0]), 0.5, sides=40)
    assert is_closed(rod)
    assert volume(rod) == pytest.approx(0.25 * polygon_area(40) * 2.0)


def test_a_ball_is_a_ball() -> None:
    ball = shapes.sphere(2.0, (1.0, 0.0, 0.0), rings=60)
    assert is_closed(ball)
    assert volume(ball) == pytest.approx(4 / 3 * np.pi * 8.0, rel=2e-3)
    np.testing.assert_allclose(np.linalg.norm(ball.vertices - (1.0, 0.0, 0.0), axis=1), 2.0)


def test_blades_lift_when_they_turn_counter_clockwise() -> None:
    """The leading edge of a blade, where it goes counter-clockwise about z, is the higher one."""
    vertices = shapes.blades(1.0).vertices
    leading = vertices[(vertices[:, 0] > 0.8) & (vertices[:, 1] > 0.0)]
    trailing = vertices[(vertices[:, 0] > 0.8) & (vertices[:, 1] < 0.0)]
    assert leading[:, 2].mean() > trailing[:, 2].mean()
    assert is_closed(shapes.blades(1.0))
    assert volume(shapes.blades(1.0)) > 0.0


@pytest.mark.parametrize("name", om.list_vehicles())
def test_the_frame_of_every_vehicle_reaches_its_rotors(name: str) -> None:
    vehicle = om.load_vehicle(name)
    frame = shapes.frame_of(vehicle)
    assert is_closed(frame)
    for hub in vehicle.rotor_position:
        assert np.linalg.norm(frame.vertices - hub, axis=1).min() < 0.05


@pytest.mark.parametrize("tilt", [0.3, 0.8, 1.0])
def test_a_solid_set_has_its_own_volume(tilt: float) -> None:
    for polytope in (
        om.analysis.force_set(OMNIMORPH, tilt, zero_moment=True),
        om.analysis.moment_set(OMNIMORPH, tilt),
    ):
        mesh = shapes.polytope_mesh(polytope, 1.0)
        assert is_closed(mesh)
        assert volume(mesh) == pytest.approx(polytope.volume, rel=1e-9)


def test_flat_sets_get_a_thickness() -> None:
    rod = om.analysis.force_set(OMNIMORPH, 0.0, zero_moment=True)
    plate = om.analysis.force_set(
        OMNIMORPH.replace(servo_angle_max=np.array([2.0])), np.pi / 2, zero_moment=True
    )
    assert (rod.dimension, plate.dimension) == (1, 2)
    for polytope in (rod, plate):
        mesh = shapes.polytope_mesh(polytope, 0.1)
        assert is_closed(mesh)
        assert volume(mesh) > 0.0
        far = np.abs(mesh.vertices).max()
        assert far == pytest.approx(np.abs(polytope.vertices).max(), abs=0.11)


def test_rotations_turn_z_to_the_axis_and_quaternions_agree() -> None:
    axes = np.random.default_rng(1).normal(size=(50, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    R = np.array([shapes.turned_to(axis) for axis in axes])
    np.testing.assert_allclose(R @ np.swapaxes(R, 1, 2), np.tile(np.eye(3), (50, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(R[:, :, 2], axes, atol=1e-12)
    w, x, y, z = shapes.wxyz_of(R).T
    third = np.column_stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    np.testing.assert_allclose(third, axes, atol=1e-12)


def test_discs_and_rings_are_whole_and_in_the_middle_of_their_height() -> None:
    for mesh, area, radius in (
        (shapes.disc(2.0, 0.5, sides=40), 4.0, 2.0),
        (shapes.ring(1.5, 2.0, 0.5, sides=40), 4.0 - 2.25, 2.0),
    ):
        assert is_closed(mesh)
        assert volume(mesh) == pytest.approx(area * polygon_area(40) * 0.5)
        np.testing.assert_allclose(mesh.vertices.max(axis=0), (radius, radius, 0.25))
        np.testing.assert_allclose(mesh.vertices.min(axis=0), (-radius, -radius, -0.25))
    tile = shapes.tile(2.0, sides=40)
    a, b, c = (tile.vertices[tile.faces[:, k]] for k in range(3))
    areas = 0.5 * np.cross(b - a, c - a)
    np.testing.assert_allclose(areas.sum(axis=0), (0.0, 0.0, 4.0 * polygon_area(40)), atol=1e-12)
    assert (areas[:, 2] > 0.0).all()
