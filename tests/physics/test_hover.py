"""Hovering with the least power or norm: published numbers, proofs of optimality, feasibility."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from tests.physics.small_vehicles import (
    build_star,
    build_tilting_star,
    random_vehicle,
)

from omnimorph.analysis import force_set, hover, hover_map, sphere_directions
from omnimorph.analysis.effort import Effort, LeastEffort, drag_power, least_effort
from omnimorph.design import Vehicle, load_vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

OMNIMORPH = load_vehicle("omnimorph")
NO_TILT = np.zeros(0)
BOTH: tuple[Effort, Effort] = ("power", "norm")


def price_slope(vehicle: Vehicle, thrust: FloatArray, effort: Effort) -> FloatArray:
    """Return what the next newton of each rotor costs: W/N, or N for ½ Σ f²."""
    if effort == "norm":
        return thrust
    c_f, c_tau = vehicle.thrust_coefficient, vehicle.drag_coefficient
    return np.asarray(1.5 * c_tau * np.sign(thrust) * np.sqrt(np.abs(thrust) / c_f) / c_f)


def cost(vehicle: Vehicle, thrust: FloatArray, effort: Effort) -> FloatArray:
    """Return Σ c_tau |w|³ or ½ Σ f² of each row."""
    if effort == "norm":
        return np.asarray(0.5 * np.sum(thrust**2, axis=-1))
    speed = np.sqrt(np.abs(thrust) / vehicle.thrust_coefficient)
    return np.asarray(speed**3 @ vehicle.drag_coefficient)


def check_optimal(
    vehicle: Vehicle, A: FloatArray, wrench: FloatArray, found: LeastEffort, effort: Effort
) -> None:
    """Check limits, wrench and the conditions of Karush, Kuhn and Tucker for each wrench."""
    low, high = vehicle.thrust_min, vehicle.thrust_max
    f = found.thrust
    size = np.abs(A).max() * np.maximum(-low, high).max()
    assert found.feasible.all()
    assert (f >= low).all()
    assert (f <= high).all()
    np.testing.assert_allclose(f @ A.T, wrench, atol=1e-10 * size)
    slope, price = price_slope(vehicle, f, effort), found.multiplier @ A
    surplus = slope - price  # > 0: less would be cheaper; < 0: more would be worth its price
    surplus = np.where(f == low, np.minimum(surplus, 0.0), surplus)
    surplus = np.where(f == high, np.maximum(surplus, 0.0), surplus)
    np.testing.assert_allclose(surplus / max(np.abs(slope).max(), 1e-9), 0.0, atol=1e-8)


# --- published numbers -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("degrees", "speed_Hz", "paper", "watts"),
    [(0.0, 93.01, 17.730, 111.40), (60.0, 131.54, 50.148, 315.09)],
)
@pytest.mark.parametrize("least", BOTH)
def test_hovering_level(
    degrees: float, speed_Hz: float, paper: float, watts: float, least: Effort
) -> None:
    point = hover(OMNIMORPH, math.radians(degrees), least=least)
    assert point.feasible
    np.testing.assert_allclose(point.speed / (2.0 * math.pi), speed_Hz, atol=5e-3)
    assert point.power_paper == pytest.approx(paper, abs=5e-4)
    assert point.power == pytest.approx(watts, abs=5e-3)
    # 8 f cos α = m g, P = 8 c_tau w³
    f = 1.315 * 9.81 / (8.0 * math.cos(math.radians(degrees)))
    np.testing.assert_allclose(point.thrust, f, rtol=1e-11)
    np.testing.assert_array_equal(point.up, [0.0, 0.0, 1.0])


def test_upside_down_and_on_its_side() -> None:
    """Rotors that turn both ways hover upside down at the same power, α = 0 on its side not."""
    down = hover(OMNIMORPH, 0.0, Rotation.from_euler("x", 180, degrees=True).as_matrix())
    assert down.power == pytest.approx(hover(OMNIMORPH, 0.0).power, rel=1e-12)
    assert (down.speed < 0.0).all()
    side = hover(OMNIMORPH, 0.0, Rotation.from_euler("x", 90, degrees=True).as_matrix())
    assert not side.feasible
    assert math.isinf(side.power)
    np.testing.assert_array_equal(side.thrust, 0.0)
    np.testing.assert_array_equal(side.speed, 0.0)


@pytest.mark.parametrize("least", BOTH)
def test_the_thrusts_hold_the_weight_in_the_world(least: Effort) -> None:
    """R_WB A f = (0, 0, m g), without a moment, in attitudes without any symmetry."""
    for seed, rotvec in enumerate([[0.7, 0.2, -1.9], [-2.0, 1.0, 0.4], [0.1, -0.2, 3.0]]):
        R_WB = Rotation.from_rotvec(rotvec).as_matrix()
        vehicle = random_vehicle(np.random.default_rng(seed), 12, mass=0.3)
        point = hover(vehicle, [], R_WB, least=least)
        wrench = allocation_matrix(vehicle, []) @ point.thrust
        np.testing.assert_allclose(R_WB @ wrench[:3], [0.0, 0.0, 0.3 * 9.81], atol=1e-10)
        np.testing.assert_allclose(wrench[3:], 0.0, atol=1e-10)


@pytest.mark.parametrize("least", BOTH)
def test_power_goes_with_mass_to_the_three_halves(least: Effort) -> None:
    """The same thrusts, scaled, as long as no limit is met."""
    R_WB = Rotation.from_rotvec([0.4, -0.3, 1.0]).as_matrix()
    light, heavy = (
        hover(OMNIMORPH.replace(mass=mass), 0.9, R_WB, least=least) for mass in (0.3, 0.9)
    )
    np.testing.assert_allclose(heavy.thrust, 3.0 * light.thrust, rtol=1e-9, atol=1e-9)
    assert heavy.power / light.power == pytest.approx(3.0**1.5, rel=1e-9)


# --- proofs of optimality ----------------------------------------------------------------------


@pytest.mark.parametrize("effort", BOTH)
@pytest.mark.parametrize("degrees", [20.0, 30.0, 45.0, 54.7356, 60.0])
def test_every_attitude_of_omnimorph_is_optimal(degrees: float, effort: Effort) -> None:
    tilt = np.radians([degrees])
    A = allocation_matrix(OMNIMORPH, tilt)
    weight = OMNIMORPH.mass * GRAVITY
    wrench = np.pad(weight * sphere_directions(200), ((0, 0), (0, 3)))
    found = least_effort(OMNIMORPH, tilt, wrench, effort)
    held = found.feasible
    assert held.all() == (degrees >= 45.0)
    one = LeastEffort(found.thrust[held], found.multiplier[held], held[held])
    check_optimal(OMNIMORPH, A, wrench[held], one, effort)


def random_problem(
    seed: int, speed_min: float | None = None, at_limits: float = 0.0
) -> tuple[Vehicle, FloatArray, FloatArray, FloatArray]:
    """Return a random vehicle, its A, thrusts with a share at their limits, and their wrenches."""
    generator = np.random.default_rng(seed)
    n = int(generator.integers(1, 13))
    changes = {} if speed_min is None else {"speed_min": speed_min}
    vehicle = random_vehicle(generator, n, **changes)
    A = allocation_matrix(vehicle, NO_TILT)
    low, high = vehicle.thrust_min, vehicle.thrust_max
    inside = generator.uniform(low, high, (10, n))
    ends = np.where(generator.random((10, n)) < 0.5, low, high)
    f = np.where(generator.random((10, n)) < at_limits, ends, inside)
    return vehicle, A, f, f @ A.T


@pytest.mark.parametrize("effort", BOTH)
@pytest.mark.parametrize("speed_min", [None, 0.0, 150.0])
def test_random_wrenches_are_met_at_the_least_effort(
    speed_min: float | None, effort: Effort
) -> None:
    """Images of random thrusts, from all inside to all at a limit: on the boundary, too."""
    for seed in range(60):
        at_limits = (0.0, 0.6, 1.0)[seed % 3]
        vehicle, A, f, wrench = random_problem(seed, speed_min, at_limits)
        found = least_effort(vehicle, NO_TILT, wrench, effort)
        check_optimal(vehicle, A, wrench, found, effort)
        assert (cost(vehicle, found.thrust, effort) <= cost(vehicle, f, effort) + 1e-9).all()


@pytest.mark.parametrize("degrees", [1.0, 20.0, 37.0, 54.7356, 60.0, 80.0])
@pytest.mark.parametrize("effort", BOTH)
def test_on_the_boundary_of_omnimorph(degrees: float, effort: Effort) -> None:
    """Thrusts at all limits but a few: symmetric axes make many facets meet there."""
    generator = np.random.default_rng(2)
    tilt = np.radians([degrees])
    A, top = allocation_matrix(OMNIMORPH, tilt), OMNIMORPH.thrust_max[0]
    f = top * generator.choice([-1.0, 0.0, 0.5, 1.0], (400, 8), p=[0.4, 0.1, 0.1, 0.4])
    found = least_effort(OMNIMORPH, tilt, f @ A.T, effort)
    check_optimal(OMNIMORPH, A, f @ A.T, found, effort)


@pytest.mark.parametrize("effort", BOTH)
@pytest.mark.parametrize("degrees", [1e-6, 1e-4, 0.01, 89.99, 89.9999])
def test_nearly_singular_tilts(degrees: float, effort: Effort) -> None:
    """On the boundary rounding decides there; but what is called feasible is, and all inside is."""
    generator = np.random.default_rng(3)
    tilt = np.radians([degrees])
    A, top = allocation_matrix(OMNIMORPH, tilt), OMNIMORPH.thrust_max[0]
    f = top * generator.choice([-1.0, 0.0, 0.5, 1.0], (400, 8))
    found = least_effort(OMNIMORPH, tilt, f @ A.T, effort)
    np.testing.assert_allclose((found.thrust @ A.T - f @ A.T)[found.feasible], 0.0, atol=1e-7)
    assert least_effort(OMNIMORPH, tilt, 0.99 * f @ A.T, effort).feasible.all()


def test_no_other_thrusts_are_cheaper() -> None:
    """Convexity: any thrusts g within limits cost at least P* + λ·(A g − w)."""
    for seed in range(40):
        vehicle, A, _, wrench = random_problem(seed, at_limits=0.3)
        found = least_effort(vehicle, NO_TILT, wrench, "power")
        best = cost(vehicle, found.thrust, "power")
        generator = np.random.default_rng(seed)
        g = generator.uniform(vehicle.thrust_min, vehicle.thrust_max, (500, vehicle.n_rotors))
        for power, multiplier, w in zip(best, found.multiplier, wrench, strict=True):
            floor = power + (g @ A.T - w) @ multiplier
            assert (cost(vehicle, g, "power") >= floor - 1e-7 * np.abs(floor).max()).all()


def test_a_general_solver_finds_nothing_better() -> None:
    """SciPy's SLSQP from three starts, on 100 vehicles of 7 to 9 rotors."""
    agreed = 0
    for seed in range(100):
        generator = np.random.default_rng(1000 + seed)
        vehicle = random_vehicle(generator, 7 + seed % 3)
        A = allocation_matrix(vehicle, NO_TILT)
        low, high = vehicle.thrust_min, vehicle.thrust_max
        wrench = A @ generator.uniform(low, high)
        found = least_effort(vehicle, NO_TILT, wrench[None], "power")
        best, scale = drag_power(vehicle, found.thrust[0]), np.abs(A).max(axis=1)
        starts = (found.thrust[0], 0.5 * (low + high), generator.uniform(low, high))
        for start in starts:
            other = minimize(
                lambda f, v=vehicle: float(cost(v, f, "power")) / 100.0,
                start,
                jac=lambda f, v=vehicle: price_slope(v, f, "power") / 100.0,
                bounds=np.column_stack([low, high]),
                constraints={
                    "type": "eq",
                    "fun": lambda f, A=A, w=wrench, s=scale: (A @ f - w) / s,
                    "jac": lambda f, A=A, s=scale: A / s[:, None],
                },
                method="SLSQP",
                options={"ftol": 1e-10, "maxiter": 100},
            )
            missing = A @ other.x - wrench
            if np.abs(missing).max() < 1e-7:
                credit = found.multiplier[0] @ missing
                assert 100.0 * other.fun >= best + credit - 1e-9 * best
                agreed += int(100.0 * other.fun <= best * (1.0 + 1e-6))
    assert agreed > 200


def test_power_against_norm() -> None:
    """Each is the least of its own; where all rotors are alike and none stops they may agree."""
    for seed in range(40):
        vehicle, _, _, wrench = random_problem(seed, at_limits=0.4)
        power, norm = (least_effort(vehicle, NO_TILT, wrench, effort).thrust for effort in BOTH)
        watts = cost(vehicle, power, "power"), cost(vehicle, norm, "power")
        assert (watts[0] <= watts[1] * (1.0 + 1e-9)).all()
        assert (cost(vehicle, norm, "norm") <= cost(vehicle, power, "norm") * (1.0 + 1e-9)).all()


def test_least_norm_is_the_pseudo_inverse_or_a_quadratic_program() -> None:
    import daqp

    within = beyond = 0
    for seed in range(80):
        vehicle, A, _, wrench = random_problem(seed, at_limits=0.7 * (seed % 2))
        low, high = vehicle.thrust_min, vehicle.thrust_max
        n = vehicle.n_rotors
        found = least_effort(vehicle, NO_TILT, wrench, "norm").thrust
        rows = np.linalg.qr(A.T)[0].T  # orthonormal rows of the same span
        for f, w in zip(found, wrench, strict=True):
            plain = np.linalg.pinv(A) @ w
            if ((plain >= low) & (plain <= high)).all():
                np.testing.assert_allclose(f, plain, atol=1e-9)
                within += 1
                continue
            made = rows @ f
            upper, lower = np.concatenate([high, made]), np.concatenate([low, made])
            sense = np.repeat(np.array([0, 5], dtype=np.int32), [n, len(rows)])
            program = (np.eye(n), np.zeros(n), rows, upper, lower, sense)
            x, _, flag, _ = daqp.solve(*program, primal_tol=1e-10, dual_tol=1e-10)
            assert flag > 0
            np.testing.assert_allclose(f, x, atol=1e-7)
            beyond += 1
    assert min(within, beyond) > 100


@pytest.mark.parametrize("effort", BOTH)
def test_multiplier_is_how_the_effort_grows(effort: Effort) -> None:
    """Central differences, where six rotors or more are free so that there is a derivative."""
    checked = 0
    for seed in range(40):
        generator = np.random.default_rng(300 + seed)
        vehicle = random_vehicle(generator, 9)
        A = allocation_matrix(vehicle, NO_TILT)
        low, high = vehicle.thrust_min, vehicle.thrust_max
        wrench = A @ generator.uniform(low, high)
        found = least_effort(vehicle, NO_TILT, wrench[None], effort)
        f = found.thrust[0]
        span = high - low
        inside = (f > low + 1e-3 * span) & (f < high - 1e-3 * span) & (np.abs(f) > 1e-3 * span)
        if inside.sum() < 6:
            continue
        step = 1e-6 * span.max()
        either = least_effort(
            vehicle,
            NO_TILT,
            np.vstack([wrench + step * np.eye(6), wrench - step * np.eye(6)]),
            effort,
        )
        efforts = cost(vehicle, either.thrust, effort)
        slope = (efforts[:6] - efforts[6:]) / (2.0 * step)
        assert either.feasible.all()
        largest = np.abs(found.multiplier[0]).max()
        np.testing.assert_allclose(found.multiplier[0], slope, atol=1e-5 * largest)
        checked += 1
    assert checked > 15


# --- what is feasible --------------------------------------------------------------------------


def test_feasible_is_membership_in_the_force_set() -> None:
    """2400 pairs of tilt and attitude, of OmniMorph and of one that can only push."""
    weight = OMNIMORPH.mass * GRAVITY
    pushing = OMNIMORPH.replace(speed_min=np.zeros(8), mass=0.6)
    up, outcomes = sphere_directions(40), set()
    for vehicle in (OMNIMORPH, pushing):
        weight = vehicle.mass * GRAVITY
        for degrees in range(3, 90, 3):
            tilt = math.radians(degrees)
            forces = force_set(vehicle, tilt, zero_moment=True, beyond_limits=True)
            wrench = np.pad(weight * up, ((0, 0), (0, 3)))
            for effort in BOTH:
                feasible = least_effort(vehicle, np.array([tilt]), wrench, effort).feasible
                margin = np.array([forces.margin(weight * one) for one in up])
                assert np.abs(margin).min() > 1e-7 * weight
                np.testing.assert_array_equal(feasible, margin > 0.0)
                outcomes |= set(feasible.tolist())
    assert outcomes == {True, False}


def test_the_largest_lift_is_where_hovering_ends() -> None:
    """As much mass as the force set carries hovers; a billionth more does not."""
    for degrees in (0.0, 15.0, 60.0, 72.0):
        tilt = math.radians(degrees)
        lift = force_set(OMNIMORPH, tilt, zero_moment=True, beyond_limits=True).reach([0, 0, 1])
        assert lift == pytest.approx(8.0 * 5.3587 * math.cos(tilt), rel=1e-9)
        for share, feasible in ((1.0 - 1e-8, True), (1.0 + 1e-8, False)):
            vehicle = OMNIMORPH.replace(mass=share * lift / GRAVITY)
            assert hover(vehicle, tilt, beyond_limits=True).feasible is feasible


def test_a_quadrotor_hovers_level_alone() -> None:
    star = build_star(4, mass=0.8)
    level = hover(star, [])
    np.testing.assert_allclose(level.thrust, 0.2 * GRAVITY, rtol=1e-12)
    for angle in (1e-3, 0.3, math.pi / 2, math.pi):
        R_WB = Rotation.from_rotvec([angle, 0.0, 0.0]).as_matrix()
        assert not hover(star, [], R_WB).feasible
    turned = hover(star, [], Rotation.from_rotvec([0.0, 0.0, 2.0]).as_matrix())
    assert turned.power == pytest.approx(level.power, rel=1e-12)
    assert not hover(star.replace(mass=1.5), []).feasible  # 14.4 N of lift


def test_rotors_that_cannot_turn_slowly() -> None:
    """Six rotors of 0.5 N or more each cannot hold 2 N; with 4 N they share."""
    star = build_star(6, speed_min=math.sqrt(0.5 / 1e-5), mass=2.0 / GRAVITY)
    assert not hover(star, []).feasible
    np.testing.assert_allclose(hover(star.replace(mass=4.0 / GRAVITY), []).thrust, 4.0 / 6.0)
    least = hover(star.replace(mass=3.0 / GRAVITY), [])  # all at their limit
    assert least.feasible
    np.testing.assert_allclose(least.thrust, 0.5, rtol=1e-12)


def test_each_rotor_by_its_own_servo() -> None:
    """Arms that lean alike yaw the vehicle; leaning against their spins they do not."""
    star = build_tilting_star(4)
    assert not hover(star, 0.2).feasible
    level = hover(star, [0.2, -0.2, 0.2, -0.2])
    np.testing.assert_allclose(level.thrust, 0.25 * 9.81 / math.cos(0.2), rtol=1e-9)
    # leaning rotors yaw a little less by drag than upright ones: nothing balances that
    assert not hover(star, [0.2, 0.0, -0.2, 0.0]).feasible


def test_refused() -> None:
    with pytest.raises(VehicleError, match='least is "speed", but it must be "power" or "norm"'):
        hover(OMNIMORPH, 0.0, least="speed")  # type: ignore[arg-type]
    for matrix in (np.eye(2), 2.0 * np.eye(3), -np.eye(3), np.full((3, 3), math.nan)):
        with pytest.raises(VehicleError, match=r"R_WB is .* 3 x 3, orthonormal"):
            hover(OMNIMORPH, 0.0, matrix)
    for up in ([0.0, 0.0, 1.0], [[0.0, 0.0, 0.0]], [[1.0, 2.0]], [[0.0, math.inf, 1.0]]):
        with pytest.raises(VehicleError, match=r"up is .* rows of three finite numbers"):
            hover_map(OMNIMORPH, up, [0.0])
    with pytest.raises(VehicleError, match="tilt is 70°"):
        hover_map(OMNIMORPH, [[0.0, 0.0, 1.0]], np.radians([10.0, 70.0]))
