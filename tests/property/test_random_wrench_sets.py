"""Exact sets of random and symmetric vehicles: polygons that fit together, and linear programs."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from tests.physics.small_vehicles import random_vehicle
from tests.unit.random_vehicles import (
    Programs,
    any_vehicles,
    general_vehicles,
    lattice_vehicles,
    thrust_within,
)

import omnimorph as om
from omnimorph.analysis.polytope import Polytope, Zonotope
from omnimorph.analysis.wrench_set import force_set, moment_set, wrench_set
from omnimorph.design import Vehicle
from omnimorph.protocols import FloatArray

OMNIMORPH = om.load_vehicle("omnimorph").replace(servo_angle_max=[math.pi / 2])
FORCE, TORQUE = slice(0, 3), slice(3, 6)
seeds = st.integers(0, 2**32 - 1)


def sets_of(vehicle: Vehicle, seed: int) -> list[tuple[Polytope, Programs]]:
    """Forces and moments, free and with the other held at zero, inside, and at a limit."""
    generator = np.random.default_rng(seed)
    A = om.allocation_matrix(vehicle, 0.0)
    inside = A @ thrust_within(vehicle, generator)
    at_limit = A @ np.where(generator.random(A.shape[1]) < 0.5, *vehicle_limits(vehicle))
    sets: list[tuple[Polytope, Programs]] = [
        (force_set(vehicle, 0.0, zero_moment=False), Programs(vehicle, 0.0, None, [])),
        (
            moment_set(vehicle, 0.0, force=inside[FORCE]),
            Programs(vehicle, 0.0, FORCE, inside[FORCE]),
        ),
    ]
    for moment in (np.zeros(3), inside[TORQUE], at_limit[TORQUE]):
        forces = force_set(vehicle, 0.0, zero_moment=True, moment=moment)
        sets.append((forces, Programs(vehicle, 0.0, TORQUE, moment)))
    return sets


def vehicle_limits(vehicle: Vehicle) -> tuple[FloatArray, FloatArray]:
    return vehicle.thrust_min, vehicle.thrust_max


def volume_of_generators(generators: FloatArray) -> float:
    """P. McMullen's sum over all triples of generators."""
    triples = generators.T[np.array(list(combinations(range(generators.shape[1]), 3)))]
    return 8.0 * float(np.abs(np.linalg.det(triples)).sum())


def assert_fits_together(found: Polytope) -> None:
    """Halfspaces, corners and polygons say the same, whatever the dimension."""
    corners, normals, offsets = found.vertices, found.normals, found.offsets
    assert np.isfinite(corners).all()
    assert np.isfinite(offsets).all()
    if found.is_empty:
        assert_is_empty(found)
        return
    size = float(np.abs(corners).max()) or 1.0
    beyond = corners @ normals.T - offsets
    assert beyond.max() <= 1e-9 * size
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0.0, atol=1e-12)
    assert all(found.contains(corner) for corner in corners)
    assert (found.volume > 0.0) == (found.dimension == 3)
    if found.dimension == 3:
        assert_is_a_closed_surface(found)
        assert found.volume == pytest.approx(ConvexHull(corners).volume, rel=1e-9)
    else:
        assert len(found.facets) == (found.dimension == 2)
        least = {0: 1, 1: 2, 2: 3}[found.dimension]
        assert len(corners) == least if found.dimension < 2 else len(corners) >= least


def assert_is_a_closed_surface(solid: Polytope) -> None:
    """Each edge belongs to two polygons that run along it in opposite directions."""
    corners = solid.vertices
    edges = [
        (int(start), int(end))
        for polygon in solid.facets
        for start, end in zip(polygon, np.roll(polygon, -1), strict=True)
    ]
    assert len(set(edges)) == len(edges)
    assert {(end, start) for start, end in edges} == set(edges)
    assert len(corners) - len(edges) // 2 + len(solid.facets) == 2
    assert len(solid.facets) == len(solid.normals)
    assert min(len(polygon) for polygon in solid.facets) >= 3
    assert np.bincount(np.concatenate(solid.facets)).min() >= 3
    for polygon, normal in zip(solid.facets, solid.normals, strict=True):
        spokes = corners[polygon] - corners[polygon].mean(axis=0)
        assert np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0) @ normal > 0.0


def assert_is_empty(nothing: Polytope) -> None:
    assert (nothing.dimension, nothing.volume, nothing.inscribed_radius) == (-1, 0.0, 0.0)
    assert (len(nothing.vertices), len(nothing.facets)) == (0, 0)
    assert nothing.support([1.0, 0.0, 0.0]) == -math.inf
    assert nothing.reach([1.0, 0.0, 0.0]) == 0.0
    assert not nothing.contains([0.0, 0.0, 0.0])


# --- corners, edges and polygons ----------------------------------------------------------------


@given(any_vehicles, seeds)
@settings(max_examples=60)
def test_the_polygons_of_any_set_fit_together(vehicle: Vehicle, seed: int) -> None:
    for found, _ in sets_of(vehicle, seed):
        assert_fits_together(found)
    assert_fits_together(moment_set(vehicle, 0.0))


@pytest.mark.parametrize("zero_moment", [False, True])
def test_at_every_tilt_of_omnimorph(zero_moment: bool) -> None:
    for degrees in range(91):
        forces = force_set(OMNIMORPH, math.radians(degrees), zero_moment=zero_moment)
        assert forces.dimension == {0: 1, 90: 2}.get(degrees, 3)
        assert_fits_together(forces)
        assert forces.reach([0.0, 0.0, 1.0]) == pytest.approx(
            8.0 * OMNIMORPH.thrust_max[0] * math.cos(math.radians(degrees)), rel=1e-12, abs=1e-12
        )


@pytest.mark.parametrize("angle", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("singular", [0.0, math.pi / 2])
def test_thin_solids(angle: float, singular: float) -> None:
    """Next to the tilts at which it is a rod or a plate, the set is a solid as thin as it is."""
    forces = force_set(OMNIMORPH, abs(singular - angle), zero_moment=False)
    assert isinstance(forces, Zonotope)
    assert forces.dimension == 3
    assert forces.volume == pytest.approx(volume_of_generators(forces.generators), rel=1e-9)
    assert_fits_together(forces)


@pytest.mark.parametrize("angle", [1e-4, 1e-6, 1e-8])
def test_thin_solids_at_zero_moment(angle: float) -> None:
    """Twice as far from the rod it has four times the volume, twice as far from the plate twice."""
    for singular, times in ((0.0, 4.0), (math.pi / 2, 2.0)):
        thin, thicker = (
            force_set(OMNIMORPH, abs(singular - tilt), zero_moment=True)
            for tilt in (angle, 2.0 * angle)
        )
        assert_is_a_closed_surface(thin)
        assert thicker.volume == pytest.approx(times * thin.volume, rel=10.0 * angle + 1e-6)


@given(lattice_vehicles(), st.integers(2, 6), seeds)
@settings(max_examples=80)
def test_vehicles_that_are_nearly_symmetric(vehicle: Vehicle, digits: int, seed: int) -> None:
    """As if the axes were written with so many digits."""
    generator = np.random.default_rng(seed)
    axis = vehicle.rotor_axis + 10.0**-digits * generator.standard_normal((vehicle.n_rotors, 3))
    rough = vehicle.replace(rotor_axis=axis / np.linalg.norm(axis, axis=1, keepdims=True))
    for found, _ in sets_of(rough, seed):
        if found.dimension == 3:
            assert_is_a_closed_surface(found)


def test_the_one_force_that_can_be_made_belongs_to_the_set() -> None:
    """A point has no size that a rounding error could be compared with."""
    generator = np.random.default_rng(0)
    for _ in range(20):
        vehicle = random_vehicle(generator, 2)
        point = force_set(vehicle, 0.0, zero_moment=True)
        assert point.dimension == 0
        assert point.contains([0.0, 0.0, 0.0])
        assert point.margin([0.0, 0.0, 0.0]) == pytest.approx(0.0, abs=1e-12)


@given(seeds, st.integers(4, 8))
@settings(max_examples=40)
def test_rotors_of_very_different_strength(seed: int, n: int) -> None:
    """Long thin sets: rotors that differ by up to 10⁴ in thrust."""
    generator = np.random.default_rng(seed)
    strength = 10.0 ** generator.uniform(-8.0, -4.0, n)
    vehicle = random_vehicle(generator, n, thrust_coefficient=strength, questioned=False)
    forces = force_set(vehicle, 0.0, zero_moment=False)
    assert isinstance(forces, Zonotope)
    assert forces.volume == pytest.approx(volume_of_generators(forces.generators), rel=1e-6)
    assert len(forces.vertices) == 2 * sum(math.comb(n - 1, i) for i in range(3))


# --- against linear programs --------------------------------------------------------------------


@given(any_vehicles, seeds)
@settings(max_examples=25)
def test_every_facet_is_touched_and_every_corner_can_be_made(vehicle: Vehicle, seed: int) -> None:
    """Which proves that the set is neither too large nor too small."""
    generator = np.random.default_rng(seed)
    for found, programs in sets_of(vehicle, seed):
        if found.is_empty:
            assert programs.support(np.array([1.0, 0.0, 0.0])) == -math.inf
            continue
        for k in generator.choice(len(found.normals), min(4, len(found.normals)), replace=False):
            expected = programs.support(found.normals[k])
            assert found.offsets[k] == pytest.approx(expected, abs=1e-7 * programs.size)
        for corner in generator.permutation(found.vertices)[:4]:
            slack = programs.least_slack(corner)
            assert slack >= -1e-7 * programs.thrust
            if found.dimension > 0:  # whichever thrusts make a corner, one is at a limit
                assert slack <= 1e-7 * programs.thrust


@given(general_vehicles(), seeds)
@settings(max_examples=25)
def test_support_and_reach_along_any_direction(vehicle: Vehicle, seed: int) -> None:
    directions = np.random.default_rng(seed).standard_normal((3, 3))
    for found, programs in sets_of(vehicle, seed):
        for direction in directions / np.linalg.norm(directions, axis=1, keepdims=True):
            far = programs.support(direction)
            assert found.support(direction) == pytest.approx(far, abs=1e-7 * programs.size)
            if found.dimension == 3:
                expected = programs.reach(direction)
                assert found.reach(direction) == pytest.approx(expected, abs=1e-6 * programs.size)


@given(any_vehicles, seeds)
def test_what_thrusts_make_is_inside_and_what_is_beyond_is_not(vehicle: Vehicle, seed: int) -> None:
    generator = np.random.default_rng(seed)
    wrench = om.allocation_matrix(vehicle, 0.0) @ thrust_within(vehicle, generator)
    force, moment = wrench[FORCE], wrench[TORQUE]
    direction = generator.standard_normal(3)
    for found, point in (
        (force_set(vehicle, 0.0, zero_moment=False), force),
        (force_set(vehicle, 0.0, zero_moment=True, moment=moment), force),
        (moment_set(vehicle, 0.0), moment),
        (moment_set(vehicle, 0.0, force=force), moment),
    ):
        assert found.contains(point)
        corner = found.vertices[int((found.vertices @ direction).argmax())]
        outside = corner + 1e-3 * max(1.0, found.support(direction)) * direction
        assert not found.contains(outside)
        assert found.margin(outside) < 0.0


@given(general_vehicles())
@settings(max_examples=40)
def test_where_the_ball_touches_some_rotor_is_at_its_limit(vehicle: Vehicle) -> None:
    """All thrusts that make that force have one: there is no slack to share out."""
    radius, direction = force_set(vehicle, 0.0, zero_moment=True).inscribed_sphere()
    if radius > 0.0:
        slack = Programs(vehicle, 0.0, TORQUE, np.zeros(3)).least_slack(radius * direction)
        assert slack == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("degrees", [20.0, 45.0, 60.0, 70.0])
def test_where_the_ball_of_omnimorph_touches(degrees: float) -> None:
    tilt = math.radians(degrees)
    radius, direction = force_set(OMNIMORPH, tilt, zero_moment=True).inscribed_sphere()
    programs = Programs(OMNIMORPH, tilt, TORQUE, np.zeros(3))
    assert programs.least_slack(radius * direction) == pytest.approx(0.0, abs=1e-9)
    assert programs.least_slack(0.999 * radius * direction) > 1e-4


# --- invariance ---------------------------------------------------------------------------------


@given(any_vehicles, seeds)
@settings(max_examples=50)
def test_the_corners_turn_with_the_vehicle(vehicle: Vehicle, seed: int) -> None:
    R = Rotation.random(random_state=seed).as_matrix()
    turned = vehicle.replace(
        rotor_position=vehicle.rotor_position @ R.T,
        rotor_axis=vehicle.rotor_axis @ R.T,
        inertia=R @ vehicle.inertia @ R.T,
    )
    pairs = zip(sets_of(vehicle, seed), sets_of(turned, seed), strict=True)
    for (one, programs), (two, _) in pairs:
        assert two.dimension == one.dimension
        assert len(two.vertices) == len(one.vertices)
        assert len(two.facets) == len(one.facets)
        for corner in one.vertices @ R.T:
            nearest = np.linalg.norm(two.vertices - corner, axis=1).min()
            assert nearest <= 1e-7 * programs.size


@given(any_vehicles, seeds)
@settings(max_examples=50)
def test_a_vehicle_a_hundred_times_larger_makes_the_same_forces(
    vehicle: Vehicle, seed: int
) -> None:
    """Arms and drag a hundred times larger, also those of inertia: the torques are so, too."""
    large = vehicle.replace(
        rotor_position=100.0 * vehicle.rotor_position,
        drag_coefficient=100.0 * vehicle.drag_coefficient,
        inertia=1e4 * vehicle.inertia,
    )
    pairs = list(zip(sets_of(vehicle, seed), sets_of(large, seed), strict=True))
    for k, ((small, _), (great, _)) in enumerate(pairs):
        scale = 100.0 if k == 1 else 1.0  # the moments at a force
        assert great.dimension == small.dimension
        assert len(great.vertices) == len(small.vertices)
        assert great.volume == pytest.approx(scale**3 * small.volume, rel=1e-9)
    assert wrench_set(large, 0.0).dimension == wrench_set(vehicle, 0.0).dimension


# --- moments on and beyond the boundary ---------------------------------------------------------


@given(lattice_vehicles(), seeds)
@settings(max_examples=60)
def test_the_largest_moment_leaves_a_face_and_a_larger_one_nothing(
    vehicle: Vehicle, seed: int
) -> None:
    moments, direction = moment_set(vehicle, 0.0), np.random.default_rng(seed).standard_normal(3)
    corner = moments.vertices[int((moments.vertices @ direction).argmax())]
    face = force_set(vehicle, 0.0, zero_moment=True, moment=corner)
    assert 0 <= face.dimension <= force_set(vehicle, 0.0, zero_moment=False).dimension
    assert_fits_together(face)
    beyond = corner + 1e-3 * direction
    assert_is_empty(force_set(vehicle, 0.0, zero_moment=True, moment=beyond))
