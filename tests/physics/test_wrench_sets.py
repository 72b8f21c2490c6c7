"""Force, moment and wrench sets against closed forms, corners of the box, and linear programs."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from tests.physics.small_vehicles import (
    build_star,
    build_tilting_star,
    build_vehicle,
    random_vehicle,
)

import omnimorph as om
from omnimorph.analysis import force_set, moment_set, wrench_set
from omnimorph.analysis.polytope import Polytope
from omnimorph.design import Vehicle
from omnimorph.errors import OmnimorphError, VehicleError
from omnimorph.protocols import FloatArray

OMNIMORPH = om.load_vehicle("omnimorph")
F_MAX = float(OMNIMORPH.thrust_max[0])
seeds = st.integers(0, 2**32 - 1)


def any_vehicle(seed: int, most: int = 10) -> Vehicle:
    """A random vehicle: both ways round, one way round with a least speed, or with symmetries."""
    numbers = np.random.default_rng(seed)
    n = int(numbers.integers(3, most + 1))
    vehicle = random_vehicle(numbers, n)
    if seed % 3 == 1:
        vehicle = vehicle.replace(speed_min=0.2 * vehicle.speed_max)
    if seed % 3 == 2:
        lattice = numbers.integers(-1, 2, (2, n, 3)).astype(float)
        lattice[1][~lattice[1].any(axis=1)] = [0.0, 0.0, 1.0]
        lattice[1] /= np.linalg.norm(lattice[1], axis=1, keepdims=True)
        vehicle = vehicle.replace(rotor_position=0.2 * lattice[0], rotor_axis=lattice[1])
    return vehicle


def corners(vehicle: Vehicle) -> FloatArray:
    """All 2ⁿ corners of the box of thrusts."""
    ends = zip(vehicle.thrust_min, vehicle.thrust_max, strict=True)
    return np.array(list(itertools.product(*ends)))


def support_by_program(vehicle: Vehicle, d: FloatArray, held: FloatArray | None) -> float:
    """max d·force over thrusts, with a moment held or free; −inf if there are none."""
    A = om.allocation_matrix(vehicle, 0.0)
    limits = np.column_stack([vehicle.thrust_min, vehicle.thrust_max])
    equal = {} if held is None else {"A_eq": 10.0 * A[3:], "b_eq": 10.0 * held}
    found = linprog(-d @ A[:3], bounds=limits, **equal)
    return -float(found.fun) if found.status == 0 else -math.inf


def assert_is_a_solid(solid: Polytope) -> None:
    """Euler's formula, outward facets, halfspaces and corners that say the same."""
    edges = sum(len(polygon) for polygon in solid.facets) / 2
    assert len(solid.vertices) - edges + len(solid.facets) == 2
    size = float(np.abs(solid.vertices).max())
    beyond = solid.vertices @ solid.normals.T - solid.offsets
    assert beyond.max() < 1e-9 * size
    assert ((np.abs(beyond) < 1e-8 * size).sum(axis=0) >= 3).all()
    for polygon, normal in zip(solid.facets, solid.normals, strict=True):
        a, b, c = solid.vertices[polygon[:3]]
        assert np.cross(b - a, c - a) @ normal > 0.0


# --- closed forms -------------------------------------------------------------------------------


@pytest.mark.parametrize("degrees", [*range(1, 90, 4), 54.7356103172])
def test_free_moment_radius_in_closed_form(degrees: float) -> None:
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    forces = force_set(OMNIMORPH, math.radians(degrees), zero_moment=False, beyond_limits=True)
    expected = min(4.0 * s, 8.0 * s * c / math.sqrt(1.0 + c * c))
    assert forces.inscribed_radius == pytest.approx(expected * F_MAX, rel=1e-12)
    assert forces.reach([0.0, 0.0, 1.0]) == pytest.approx(8.0 * c * F_MAX, rel=1e-12)
    assert_is_a_solid(forces)


@pytest.mark.parametrize(
    ("degrees", "shares"),
    [(20, 1.3439), (30, 1.9537), (37, 2.3446), (45, 2.7478), (54.7356, 3.1543), (60, 3.0041)],
)
def test_zero_moment_radius(degrees: float, shares: float) -> None:
    forces = force_set(OMNIMORPH, math.radians(degrees), zero_moment=True)
    assert round(forces.inscribed_radius / F_MAX, 4) == shares
    assert_is_a_solid(forces)


@pytest.mark.parametrize(("lost", "free", "zero"), [(0.35, 12.07, 11.73), (0.30, 12.99, 12.63)])
def test_sideways_with_thrust_and_drag_lost(lost: float, free: float, zero: float) -> None:
    worn = OMNIMORPH.replace(
        thrust_coefficient=(1.0 - lost) * OMNIMORPH.thrust_coefficient,
        drag_coefficient=(1.0 - lost) * OMNIMORPH.drag_coefficient,
    )
    reach = [
        force_set(worn, math.radians(60.0), zero_moment=held).reach([1.0, 0.0, 0.0])
        for held in (False, True)
    ]
    assert np.round(reach, 2).tolist() == [free, zero]


# --- against all corners ------------------------------------------------------------------------


@given(seeds)
def test_the_free_set_is_the_hull_of_all_corners(seed: int) -> None:
    vehicle = any_vehicle(seed)
    Z = om.allocation_matrix(vehicle, 0.0)[:3]
    forces = force_set(vehicle, 0.0, zero_moment=False)
    points = corners(vehicle) @ Z.T
    for d in np.random.default_rng(seed).standard_normal((5, 3)):
        assert forces.support(d) == pytest.approx(float((points @ d).max()), rel=1e-10, abs=1e-9)
    if forces.dimension < 3:
        assert np.linalg.matrix_rank(Z, tol=1e-9) == forces.dimension
        return
    hull = ConvexHull(points)
    assert forces.volume == pytest.approx(hull.volume, rel=1e-9)
    half = Z * 0.5 * (vehicle.thrust_max - vehicle.thrust_min)
    minors = [
        abs(np.linalg.det(half[:, list(c)])) for c in itertools.combinations(range(len(half.T)), 3)
    ]
    assert forces.volume == pytest.approx(8.0 * sum(minors), rel=1e-9)
    depth = float(-hull.equations[:, 3].max())
    assert forces.inscribed_radius == pytest.approx(max(depth, 0.0), rel=1e-9, abs=1e-9)
    assert_is_a_solid(forces)
    if seed % 3 == 0:  # in general position
        n = vehicle.n_rotors
        assert len(forces.vertices) == 2 * sum(math.comb(n - 1, i) for i in range(3))


@given(seeds)
def test_wrench_set_is_the_hull_of_all_corners(seed: int) -> None:
    vehicle = any_vehicle(seed, most=8)
    A = om.allocation_matrix(vehicle, 0.0)
    wrenches = wrench_set(vehicle, 0.0)
    numbers = np.random.default_rng(seed)
    points = corners(vehicle) @ A.T
    for d in numbers.standard_normal((5, 6)):
        assert wrenches.support(d) == pytest.approx(float((points @ d).max()), rel=1e-10)
    inside = numbers.uniform(vehicle.thrust_min, vehicle.thrust_max)
    assert wrenches.contains(A @ inside)
    d = numbers.standard_normal(6)
    farthest = points[int((points @ d).argmax())]
    assert wrenches.contains(farthest)
    assert not wrenches.contains(farthest + 1e-3 * d)


def test_six_dimensions_have_no_list_of_vertices() -> None:
    wrenches = wrench_set(OMNIMORPH, 0.7)
    assert wrenches.dimension == 6
    with pytest.raises(OmnimorphError, match="at most three dimensions"):
        _ = wrenches.vertices


# --- against linear programs --------------------------------------------------------------------


@given(seeds)
def test_sections_against_linear_programs(seed: int) -> None:
    vehicle, numbers = any_vehicle(seed), np.random.default_rng(seed)
    A = om.allocation_matrix(vehicle, 0.0)
    thrust = numbers.uniform(vehicle.thrust_min, vehicle.thrust_max)
    held = A[3:] @ thrust
    forces = force_set(vehicle, 0.0, zero_moment=True, moment=held)
    assert forces.contains(A[:3] @ thrust)
    for d in numbers.standard_normal((3, 3)):
        expected = support_by_program(vehicle, d, held)
        assert forces.support(d) == pytest.approx(expected, rel=1e-6, abs=1e-6)
        farthest = forces.vertices[int((forces.vertices @ d).argmax())]
        assert not forces.contains(farthest + 1e-3 * d)
    moments = moment_set(vehicle, 0.0, force=A[:3] @ thrust)
    assert moments.contains(held)
    assert moments.dimension >= 0


@pytest.mark.parametrize("degrees", [20.0, 45.0, 60.0])
def test_on_the_boundary_some_thrust_is_at_its_limit(degrees: float) -> None:
    """The least slack of any thrusts that make the force where the ball touches is zero."""
    tilt = math.radians(degrees)
    radius, direction = force_set(OMNIMORPH, tilt, zero_moment=True).inscribed_sphere()
    A = np.column_stack([om.allocation_matrix(OMNIMORPH, tilt), np.zeros(6)])
    wrench = np.concatenate([radius * direction, np.zeros(3)])
    upper = np.column_stack([np.eye(8), np.ones(8)])
    lower = np.column_stack([-np.eye(8), np.ones(8)])
    found = linprog(
        [*np.zeros(8), -1.0],
        A_ub=np.vstack([upper, lower]),
        b_ub=np.full(16, F_MAX),
        A_eq=A,
        b_eq=wrench,
        bounds=(None, None),
    )
    assert abs(found.x[8]) < 1e-7


# --- invariance ---------------------------------------------------------------------------------


@given(seeds)
def test_neither_frame_nor_numbering_matters(seed: int) -> None:
    vehicle, numbers = any_vehicle(seed), np.random.default_rng(seed)
    R = Rotation.random(random_state=seed).as_matrix()
    turned = vehicle.replace(
        rotor_position=vehicle.rotor_position @ R.T, rotor_axis=vehicle.rotor_axis @ R.T
    )
    order = numbers.permutation(vehicle.n_rotors)
    per_rotor = ["rotor_position", "rotor_axis", "rotor_spin", "thrust_coefficient"]
    per_rotor += ["drag_coefficient", "speed_min", "speed_max"]
    renumbered = vehicle.replace(**{name: getattr(vehicle, name)[order] for name in per_rotor})
    for zero_moment in (False, True):
        one, two, three = (
            force_set(each, 0.0, zero_moment=zero_moment) for each in (vehicle, turned, renumbered)
        )
        assert one.dimension == two.dimension == three.dimension
        assert two.inscribed_radius == pytest.approx(one.inscribed_radius, rel=1e-9, abs=1e-9)
        assert three.inscribed_radius == pytest.approx(one.inscribed_radius, rel=1e-9, abs=1e-9)
        assert two.volume == pytest.approx(one.volume, rel=1e-8, abs=1e-9)
        assert three.volume == pytest.approx(one.volume, rel=1e-8, abs=1e-9)


# --- flat, thin and empty sets ------------------------------------------------------------------


def test_a_rod_a_plate_and_thin_solids() -> None:
    for zero_moment in (False, True):
        rod = force_set(OMNIMORPH, 0.0, zero_moment=zero_moment)
        assert (rod.dimension, rod.inscribed_radius, rod.volume, rod.facets) == (1, 0.0, 0.0, ())
        assert np.allclose(np.sort(rod.vertices[:, 2]), [-8 * F_MAX, 8 * F_MAX])
        assert rod.contains([0.0, 0.0, 40.0])
        assert not rod.contains([0.0, 1e-3, 40.0])
        plate = force_set(OMNIMORPH, math.pi / 2, zero_moment=zero_moment, beyond_limits=True)
        assert (plate.dimension, plate.inscribed_radius, plate.volume) == (2, 0.0, 0.0)
        assert np.allclose(np.abs(plate.inscribed_sphere().direction), [0.0, 0.0, 1.0])
        assert plate.reach([0.0, 0.0, 1.0]) == 0.0
    for tilt in (1e-3, 1e-6):
        thin = force_set(OMNIMORPH, tilt, zero_moment=False)
        assert (thin.dimension, len(thin.vertices), len(thin.facets)) == (3, 14, 12)
        assert thin.inscribed_radius == pytest.approx(4.0 * F_MAX * math.sin(tilt), rel=1e-9)


def test_a_moment_at_its_largest_leaves_a_face_and_beyond_it_nothing() -> None:
    moments = moment_set(OMNIMORPH, 0.7)
    largest = moments.reach([0.0, 0.0, 1.0]) * np.array([0.0, 0.0, 1.0])
    face = force_set(OMNIMORPH, 0.7, zero_moment=True, moment=largest)
    assert 0 <= face.dimension < 3
    assert face.volume == 0.0
    nothing = force_set(OMNIMORPH, 0.7, zero_moment=True, moment=1.01 * largest)
    assert (nothing.dimension, nothing.is_empty, nothing.volume) == (-1, True, 0.0)
    assert len(nothing.vertices) == len(nothing.facets) == 0
    assert nothing.support([1.0, 0.0, 0.0]) == -math.inf
    assert (nothing.inscribed_radius, nothing.reach([1.0, 0.0, 0.0])) == (0.0, 0.0)
    assert not nothing.contains([0.0, 0.0, 0.0])


@pytest.mark.parametrize("tilt", [-1.0, 1.0])
def test_a_point_reaches_nothing_however_it_is_rounded(tilt: float) -> None:
    """At one tilt of four tilting rotors every thrust turns the vehicle."""
    forces = force_set(build_tilting_star(4), tilt, zero_moment=True)
    assert forces.dimension == 0
    assert [forces.reach(k * axis) for k in (1.0, 1e9) for axis in np.eye(3)] == [0.0] * 6


@pytest.mark.parametrize(
    ("vehicle", "free", "zero"),
    [
        (build_star(4), 1, 1),
        (build_vehicle([[0.0, 0.0, 0.0]]), 1, 0),
        (build_vehicle([[0.1, 0.1, 0.0]] * 4), 1, 0),
        (build_vehicle([[0.2, 0.0, 0.0], [-0.2, 0.0, 0.0]], rotor_spin=[1.0, -1.0]), 1, 1),
        (build_vehicle(np.zeros((3, 3)), np.eye(3)), 3, 0),
    ],
)
def test_vehicles_that_can_do_little(vehicle: Vehicle, free: int, zero: int) -> None:
    assert force_set(vehicle, 0.0, zero_moment=False).dimension == free
    held = force_set(vehicle, 0.0, zero_moment=True)
    assert held.dimension == zero
    assert held.inscribed_radius == 0.0
    assert wrench_set(vehicle, 0.0).contains(np.zeros(6))


def test_eighteen_rotors() -> None:
    vehicle = random_vehicle(np.random.default_rng(5), 18)
    forces = force_set(vehicle, 0.0, zero_moment=True)
    assert_is_a_solid(forces)
    d = np.array([0.3, -0.5, 0.8])
    assert forces.support(d) == pytest.approx(support_by_program(vehicle, d, np.zeros(3)), rel=1e-7)


# --- mistakes -----------------------------------------------------------------------------------


def test_mistakes_are_reported() -> None:
    with pytest.raises(VehicleError, match="tilt is 75°, but it must be from 0° to 60°"):
        force_set(OMNIMORPH, math.radians(75.0), zero_moment=True)
    with pytest.raises(VehicleError, match="it must be left out where moments are free"):
        force_set(OMNIMORPH, 0.5, zero_moment=False, moment=[0.0, 0.0, 0.1])
    with pytest.raises(VehicleError, match="three finite numbers, in N m"):
        force_set(OMNIMORPH, 0.5, zero_moment=True, moment=[0.0, math.nan, 0.1])
    with pytest.raises(VehicleError, match="three finite numbers, in N"):
        moment_set(OMNIMORPH, 0.5, force=[1.0])
    with pytest.raises(OmnimorphError, match="not a vector of 3 numbers"):
        force_set(OMNIMORPH, 0.5, zero_moment=True).margin([1.0, 2.0])
