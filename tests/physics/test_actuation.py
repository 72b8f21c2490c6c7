"""What rotors and servos can move: ranks, conditions on the thrusts, classes, singular tilts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from tests.physics.small_vehicles import (
    build_star,
    build_tilting_star,
    build_vehicle,
    random_tilting_vehicle,
    random_vehicle,
)

from omnimorph.analysis import actuation, singular_tilts
from omnimorph.analysis.actuation import ActuationKind, ThrustKind
from omnimorph.analysis.scaling import radius_of_gyration
from omnimorph.design import Vehicle, load_vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.allocation import allocation_matrix, full_allocation_matrix
from omnimorph.protocols import FloatArray

OMNIMORPH = load_vehicle("omnimorph")
LAYERED = OMNIMORPH.replace(rotor_spin=np.repeat([1.0, -1.0], 4))
RIGHT_ANGLE = 0.5 * math.pi


def rank_of(vehicle: Vehicle, matrix: FloatArray) -> int:
    """Return the rank of a matrix of wrenches, torques divided by a length of the vehicle."""
    arm = np.repeat([1.0, radius_of_gyration(vehicle)], 3)
    return int(np.linalg.matrix_rank(matrix / arm[:, None], rtol=1e-9))


def rank_F(vehicle: Vehicle, tilt: ArrayLike, thrust: ArrayLike) -> int:
    """Return the rank of F(f, α) as NumPy finds it."""
    return rank_of(vehicle, full_allocation_matrix(vehicle, thrust, tilt))


# --- OmniMorph ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["omnimorph", "omnimorph-2026"])
def test_ranks_over_the_whole_turn(name: str) -> None:
    """Rank A is 4 at 0° and 180°, 5 at ±90°, 6 elsewhere; the tilt adds one where it is missing."""
    vehicle = load_vehicle(name)
    low = {-180: (4, 5), -90: (5, 6), 0: (4, 5), 90: (5, 6), 180: (4, 5)}
    for degrees in range(-180, 181, 2):
        found = actuation(vehicle, math.radians(degrees), beyond_limits=True)
        assert (found.rank_thrust, found.rank_full) == low.get(degrees, (6, 6)), degrees
        assert math.isinf(found.condition_number) == (degrees in low)


ALTERNATING = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0]
ZERO_SUM = [3.0, -1.0, -1.5, -0.5, 2.0, -4.0, 1.0, 1.0]
ONE = [0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("degrees", "thrust", "rank"),
    [
        # at 0° the leanings h may cancel: rotors 0, 1, 2, 3 and 6, 7, 4, 5 lean the same ways
        (0, [1.0] * 8, 4),
        (0, [1.0] * 4 + [2.0] * 4, 4),  # not all equal, and still 4
        (0, [1.0, 2.0, 1.0, 2.0, 3.0, 4.0, 3.0, 4.0], 4),
        (0, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], 4),  # no two equal
        (0, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.5, 8.0], 5),
        (0, ONE, 5),
        (0, [1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 4),
        (0, [1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 5),
        (0, [0.0] * 8, 4),
        (180, [1.0] * 4 + [2.0] * 4, 4),
        (180, ONE, 5),
        (90, [1.0] * 8, 6),
        (90, ONE, 6),
        (90, ALTERNATING, 5),
        (90, ZERO_SUM, 5),  # not zero, and still 5
        (90, [0.0] * 8, 5),
        (-90, ZERO_SUM, 5),
        (-90, ONE, 6),
        (45, [0.0] * 8, 6),
    ],
)
def test_when_the_tilt_adds_a_direction(degrees: int, thrust: list[float], rank: int) -> None:
    tilt = math.radians(degrees)
    assert actuation(OMNIMORPH, tilt, thrust, beyond_limits=True).rank_full == rank
    assert rank_F(OMNIMORPH, tilt, thrust) == rank
    # what matters is the direction of f, not its size
    tiny = 1e-12 * np.array(thrust)
    assert actuation(OMNIMORPH, tilt, tiny, beyond_limits=True).rank_full == rank


def test_at_90_degrees_drag_plays_no_role() -> None:
    """Roll and pitch come from lever arms there: rank 5 and 6 with hardly any drag too."""
    without = OMNIMORPH.replace(drag_coefficient=1e-12 * OMNIMORPH.drag_coefficient)
    for thrust, rank in ((None, 6), (ZERO_SUM, 5), (ONE, 6)):
        found = actuation(without, RIGHT_ANGLE, thrust, beyond_limits=True)
        assert (found.rank_thrust, found.rank_full) == (5, rank)
    # at 0° yaw comes from drag alone
    assert actuation(without, 0.0).rank_thrust == 3


def test_conditions_of_omnimorph() -> None:
    """At 0° both parts of Σ f h, h = ±x, ±y; at 90° Σ f; elsewhere nothing to ask."""
    (at_0,) = actuation(OMNIMORPH, 0.0).conditions
    along_x, along_y = [1, 0, -1, 0, -1, 0, 1, 0], [0, 1, 0, -1, 0, -1, 0, 1]
    np.testing.assert_allclose(at_0, [along_x, along_y], atol=1e-12)
    (at_90,) = actuation(OMNIMORPH, RIGHT_ANGLE, beyond_limits=True).conditions
    np.testing.assert_allclose(at_90, [[1.0] * 8], atol=1e-12)
    (at_45,) = actuation(OMNIMORPH, 0.25 * math.pi).conditions
    assert at_45.shape == (0, 8)


@pytest.mark.parametrize(
    ("vehicle", "tilt"),
    [
        (OMNIMORPH, 0.0),
        (OMNIMORPH, RIGHT_ANGLE),
        (LAYERED, 0.0),
        (LAYERED, float(np.arctan(LAYERED.kappa[0] / 0.1062))),
        (build_tilting_star(4), 0.0),
        (build_tilting_star(6), 0.0),
        (build_tilting_star(6), RIGHT_ANGLE),
        (build_tilting_star(4), 0.6),
    ],
)
def test_conditions_say_when_a_servo_adds_a_direction(vehicle: Vehicle, tilt: float) -> None:
    """For random thrusts, and for those put onto the null space of the conditions."""
    generator = np.random.default_rng(1)
    found = actuation(vehicle, tilt, beyond_limits=True)
    A = allocation_matrix(vehicle, tilt)
    assert found.rank_thrust == rank_of(vehicle, A)
    for rows, j in zip(found.conditions, range(vehicle.n_servos), strict=True):
        for _ in range(20):
            free = generator.normal(size=vehicle.n_rotors)
            held = free - np.linalg.pinv(rows) @ (rows @ free) if len(rows) else free
            for thrust in (free, held):
                column = full_allocation_matrix(vehicle, thrust, tilt)[:, [vehicle.n_rotors + j]]
                added = rank_of(vehicle, np.hstack([A, column])) - found.rank_thrust
                assert added == int(len(rows) > 0 and thrust is free)


# --- what it returns ---------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 3, 5, 6, 8, 13, 18])
def test_null_space_and_what_is_lost(n: int) -> None:
    """A N = 0 and Nᵀ N = 1 whatever the limits; what is lost is across every column of A."""
    vehicle = random_vehicle(np.random.default_rng(n), n)
    found = actuation(vehicle, [])
    A = allocation_matrix(vehicle, [])
    rank = min(n, 6)
    assert (found.rank_thrust, found.rank_full) == (rank, rank)
    assert found.null_space.shape == (n, n - rank)
    np.testing.assert_allclose(A @ found.null_space, 0.0, atol=1e-14)
    np.testing.assert_allclose(found.null_space.T @ found.null_space, np.eye(n - rank), atol=1e-13)
    arm = np.repeat([1.0, radius_of_gyration(vehicle)], 3)
    assert found.lost.shape == (6, 6 - rank)
    np.testing.assert_allclose(found.lost.T @ (A / arm[:, None]), 0.0, atol=1e-13)
    np.testing.assert_allclose(found.lost.T @ found.lost, np.eye(6 - rank), atol=1e-13)
    assert found.conditions == ()


def test_what_a_quadrotor_loses() -> None:
    """Sideways forces, in whitened units."""
    found = actuation(build_star(4), [])
    np.testing.assert_allclose(found.lost[2:], 0.0, atol=1e-12)
    # lift, roll, pitch and yaw take all four thrusts: no others cancel
    assert found.null_space.shape == (4, 0)


def test_null_space_of_a_hexarotor() -> None:
    found = actuation(build_star(6), [])
    A = allocation_matrix(build_star(6), [])
    assert found.null_space.shape == (6, 2)
    np.testing.assert_allclose(A @ found.null_space, 0.0, atol=1e-14)


UNDER, FULLY = ActuationKind.UNDER_ACTUATED, ActuationKind.FULLY_ACTUATED
ONE_LINE, MANY = ThrustKind.UNI_DIRECTIONAL, ThrustKind.MULTI_DIRECTIONAL
EVERYWHERE = ThrustKind.OMNIDIRECTIONAL


@pytest.mark.parametrize(
    ("vehicle", "tilt", "rank", "kind", "thrust_kind"),
    [
        (build_star(4), [], 4, UNDER, ONE_LINE),
        (build_star(6), [], 4, UNDER, ONE_LINE),
        (build_star(4, cant=0.4), [], 4, UNDER, ONE_LINE),
        (build_star(6, cant=0.4), [], 6, FULLY, MANY),
        (build_vehicle([[0.1, 0.0, 0.0]]), [], 1, UNDER, ThrustKind.NONE),
        (build_tilting_star(4), 0.0, 4, FULLY, ONE_LINE),
        (OMNIMORPH, 0.0, 4, UNDER, ONE_LINE),
        (OMNIMORPH, math.radians(20.0), 6, ActuationKind.REDUNDANT, MANY),
        (OMNIMORPH, math.radians(45.0), 6, ActuationKind.REDUNDANT, EVERYWHERE),
        (OMNIMORPH, RIGHT_ANGLE, 5, FULLY, MANY),
        (OMNIMORPH.replace(mass=2.0), math.radians(45.0), 6, ActuationKind.REDUNDANT, MANY),
    ],
)
def test_kinds(
    vehicle: Vehicle, tilt: ArrayLike, rank: int, kind: ActuationKind, thrust_kind: ThrustKind
) -> None:
    found = actuation(vehicle, tilt, beyond_limits=True)
    assert (found.rank_thrust, found.kind, found.thrust_kind) == (rank, kind, thrust_kind)


# --- singular tilts ----------------------------------------------------------------------------


def test_singular_tilts_of_omnimorph() -> None:
    """Where the smallest singular value of A, sampled each 0.02°, dips to zero."""
    found = singular_tilts(OMNIMORPH, beyond_limits=True)
    np.testing.assert_allclose(
        np.degrees([one.tilt for one in found]), [-90, 0, 90, 180], atol=1e-7
    )
    assert [one.rank for one in found] == [5, 4, 5, 4]
    assert [(round(one.tilt, 9), one.rank) for one in singular_tilts(OMNIMORPH)] == [(0.0, 4)]
    tilts = np.radians(np.arange(-179.99, 180.01, 0.02))
    A = np.array([allocation_matrix(OMNIMORPH, tilt) for tilt in tilts])
    least = np.linalg.svd(A, compute_uv=False)[:, -1]
    lowest = (least <= np.roll(least, 1)) & (least < np.roll(least, -1))
    dips = np.degrees(tilts[lowest & (least < 1e-3)])
    np.testing.assert_allclose(dips, [-90.0, 0.0, 90.0, 180.0], atol=0.011)


@pytest.mark.parametrize(
    ("vehicle", "expected"),
    [(LAYERED, [(0.0, 4), (7.92, 5)]), (LAYERED.replace(servo_angle_min=[0.1]), [(7.92, 5)])],
)
def test_spins_by_layer_are_singular_once_more(
    vehicle: Vehicle, expected: list[tuple[float, int]]
) -> None:
    """tan α = κ / l, where lever arm and drag cancel."""
    found = singular_tilts(vehicle)
    assert [(round(math.degrees(one.tilt), 2) + 0.0, one.rank) for one in found] == expected
    assert found[-1].tilt == pytest.approx(math.atan(LAYERED.kappa[0] / 0.1062), abs=1e-9)


def test_singular_tilts_of_six_rotors_are_sign_changes_of_the_determinant() -> None:
    """A is square: det A(α) has simple roots, found here by a scan of its sign."""
    number = 0
    for seed in range(8):
        vehicle = random_tilting_vehicle(np.random.default_rng(seed), 6)
        tilts = np.linspace(-math.pi, math.pi, 721)
        det = [np.linalg.det(allocation_matrix(vehicle, tilt)) for tilt in tilts]
        roots = [
            brentq(
                lambda tilt, v=vehicle: np.linalg.det(allocation_matrix(v, tilt)),
                *tilts[k : k + 2],
                xtol=1e-13,
            )
            for k in np.flatnonzero(np.diff(np.sign(det)))
        ]
        found = singular_tilts(vehicle, beyond_limits=True)
        np.testing.assert_allclose([one.tilt for one in found], roots, atol=1e-8)
        assert {one.rank for one in found} <= {5}
        within = [one.tilt for one in singular_tilts(vehicle)]
        expected = [root for root in roots if abs(root) <= 1.0]
        np.testing.assert_allclose(within, expected, atol=1e-8)
        number += len(roots)
    assert number > 20


def test_no_servos_or_no_common_tilt() -> None:
    assert singular_tilts(build_star(4)) == ()
    apart = build_tilting_star(4, servo_angle_min=[-1.0, 0.5, -1.0, -1.0], servo_angle_max=0.6)
    apart = apart.replace(servo_angle_max=np.array([0.4, 0.6, 0.6, 0.6]))
    with pytest.raises(VehicleError, match="no tilt is within the limits of all 4 servos"):
        singular_tilts(apart)
    assert len(singular_tilts(apart, beyond_limits=True)) > 0


# --- units, frames, sizes ----------------------------------------------------------------------


@pytest.mark.parametrize("tilt", [0.0, 0.3, 0.95, RIGHT_ANGLE])
def test_size_units_and_frame_do_not_matter(tilt: float) -> None:
    """100 times the length, 30 times the mass, 7 times the thrust, and turned."""
    before = actuation(OMNIMORPH, tilt, beyond_limits=True)
    R = Rotation.from_rotvec([0.3, -2.0, 1.1]).as_matrix()
    other = OMNIMORPH.replace(
        mass=30.0 * OMNIMORPH.mass,
        inertia=3e5 * R @ OMNIMORPH.inertia @ R.T,
        rotor_position=100.0 * OMNIMORPH.rotor_position @ R.T,
        rotor_axis=OMNIMORPH.rotor_axis @ R.T,
        hinge_axis=OMNIMORPH.hinge_axis @ R.T,
        thrust_coefficient=7.0 * OMNIMORPH.thrust_coefficient,
        drag_coefficient=700.0 * OMNIMORPH.drag_coefficient,
    )
    after = actuation(other, tilt, beyond_limits=True)
    assert (after.rank_thrust, after.rank_full) == (before.rank_thrust, before.rank_full)
    assert after.kind is before.kind
    np.testing.assert_allclose(
        after.singular_values, 7.0 * before.singular_values, rtol=1e-12, atol=1e-13
    )
    assert after.condition_number == pytest.approx(before.condition_number, rel=1e-9)
    np.testing.assert_allclose(after.conditions[0], before.conditions[0], atol=1e-9)
    assert len(singular_tilts(other)) == 1


def test_condition_number_of_a_vehicle_worked_out_by_hand() -> None:
    """Six rotors in pairs on the axes, a force and a torque along each: σ = √2 and √2 (l+κ)/ℓ.

    The pair at ±l y thrusts along x: alike it pushes, unlike it turns about z, and κ adds to l.
    """
    push = np.repeat(np.eye(3), 2, axis=0)
    arm = np.repeat(np.roll(np.eye(3), -1, axis=0), 2, axis=0)
    position = 0.3 * np.tile([1.0, -1.0], 3)[:, None] * arm
    vehicle = build_vehicle(position, push, inertia=0.02 * np.eye(3), drag_coefficient=1e-18)
    found = actuation(vehicle, [])
    alike, unlike = math.sqrt(2.0) * 3.6, math.sqrt(2.0) * 3.6 * 0.3 / math.sqrt(0.02)
    np.testing.assert_allclose(found.singular_values, [unlike] * 3 + [alike] * 3, rtol=1e-12)
    assert found.condition_number == pytest.approx(unlike / alike, rel=1e-12)


# --- several servos ----------------------------------------------------------------------------


@pytest.mark.parametrize("n", [3, 4, 6])
def test_independent_tilts(n: int) -> None:
    """Rank F with random thrusts at random tilts, and at none, is what NumPy finds."""
    generator = np.random.default_rng(n)
    star = build_tilting_star(n)
    for tilts in (np.zeros(n), *generator.uniform(-1.0, 1.0, (10, n))):
        thrust = generator.uniform(0.0, 3.6, n)
        found = actuation(star, tilts, thrust)
        assert found.rank_full == rank_F(star, tilts, thrust) == min(6, 2 * n)
        assert found.rank_full == actuation(star, tilts).rank_full
        assert found.rank_thrust == rank_of(star, allocation_matrix(star, tilts))
        idle = np.where(np.arange(n) < 1, thrust, 0.0)  # only one rotor turns
        assert actuation(star, tilts, idle).rank_full == rank_F(star, tilts, idle)


def test_one_servo_may_add_what_the_others_do_not() -> None:
    """A rotor at rest adds nothing by tilting."""
    found = actuation(build_tilting_star(4), 0.0)
    for j, rows in enumerate(found.conditions):
        np.testing.assert_allclose(rows, [np.eye(4)[j]], atol=1e-12)


def test_refused() -> None:
    with pytest.raises(VehicleError, match="thrust is"):
        actuation(OMNIMORPH, 0.5, [1.0] * 7)
    with pytest.raises(VehicleError, match=r"tilt is 75°, but it must be from 0° to 60°"):
        actuation(OMNIMORPH, math.radians(75.0))
