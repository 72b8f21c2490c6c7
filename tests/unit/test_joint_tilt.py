"""Joint allocation: its optimality by NumPy's own derivatives, against SciPy, and in one step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.physics.small_vehicles import build_star, build_tilting_star, random_tilting_vehicle
from tests.unit.joint_parts import Problem, Situation, build_arms, random_situation, vehicle_named
from tests.unit.tilt_searches import (
    EPSILON,
    WEIGHTS,
    answer_of_rule,
    random_step,
    steps_of,
    window_of,
)

import omnimorph as om
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError

PERIOD = 0.004  # s
PROVEN = 1e-9
VEHICLES = ["omnimorph", "arms", "pairs", "random-5-2", "random-7-3", "random-8-8", "random-18-18"]


def joint(case: str, **changes: Any) -> om.JointTilt:
    """Return the rule with the weights of a case."""
    return om.JointTilt(**(WEIGHTS[case] | changes))


def answer_at_kept_tilts(vehicle: Vehicle, case: str, step: Situation) -> Any:
    """Return the best thrusts at the tilts as they are: where the rule starts with many servos."""
    rule = om.FixedTilt(**WEIGHTS[case])
    gains = om.TrackingGains()
    controller = om.PoseController(vehicle, gains, rule, PERIOD, step.tilt, step.thrust)
    return controller.allocate(step.acceleration, step.state)


@pytest.mark.parametrize("case", ["a", "b"])
@pytest.mark.parametrize("name", VEHICLES)
def test_the_answer_is_stationary_and_within_its_limits(name: str, case: str) -> None:
    vehicle, rule = vehicle_named(name), joint(case)
    generator = np.random.default_rng(1)
    for _ in range(40):
        problem = Problem(vehicle, rule, PERIOD, random_situation(generator, vehicle))
        answer = problem.answer(PERIOD)
        z = problem.point(answer)
        assert answer.cost == pytest.approx(problem.J(z), rel=1e-9)
        assert answer.kkt_residual <= PROVEN
        assert problem.residual(z) <= PROVEN
        slack = 1e-15  # of an addition
        assert (z >= problem.lower - slack).all()
        assert (z <= problem.upper + slack).all()
        x, low, high = z[: problem.n], problem.lower[: problem.n], problem.upper[: problem.n]
        np.testing.assert_allclose(x[answer.active < 0], low[answer.active < 0], atol=1e-15)
        np.testing.assert_allclose(x[answer.active > 0], high[answer.active > 0], atol=1e-15)


@pytest.mark.parametrize("name", VEHICLES)
def test_the_derivative_of_J_by_finite_differences(name: str) -> None:
    """The complex steps above, and with them the answer's residual, against plain differences."""
    vehicle = vehicle_named(name)
    generator = np.random.default_rng(2)
    problem = Problem(vehicle, joint("b", W4=3.0), PERIOD, random_situation(generator, vehicle))
    z = problem.start + generator.uniform(-1e-3, 1e-3, len(problem.start))
    h = 1e-6 * np.eye(len(z))
    differences = np.array([(problem.J(z + e) - problem.J(z - e)) / 2e-6 for e in h])
    exact = problem.gradient(z)
    np.testing.assert_allclose(differences, exact, rtol=1e-5, atol=1e-6 * np.abs(exact).max())


@pytest.mark.parametrize("case", ["a", "b"])
@pytest.mark.parametrize("name", VEHICLES)
def test_it_never_costs_more_than_keeping_the_tilts(name: str, case: str) -> None:
    vehicle, gained = vehicle_named(name), 0
    generator = np.random.default_rng(3)
    for _ in range(20):
        step = random_situation(generator, vehicle)
        ours = Problem(vehicle, joint(case), PERIOD, step).answer(PERIOD).cost
        kept = answer_at_kept_tilts(vehicle, case, step).cost
        assert ours <= kept * (1.0 + 1e-12)
        gained += ours < 0.999 * kept
    assert gained >= 15


@pytest.mark.parametrize("case", ["a", "b"])
def test_along_a_flight_no_step_costs_more_than_with_three_candidates(case: str) -> None:
    """Every control step of the paper's flight, from the same states and commands."""
    scenario = om.load_scenario(f"paper-case-{case}")
    vehicle = scenario.vehicle
    steps = steps_of(om.fly(scenario), scenario, every=1)
    assert len(steps) == 11_249
    three = om.cost_over_tilt(
        vehicle,
        scenario.allocator,
        [step.row for step in steps],
        [step.acceleration for step in steps],
        [step.thrust for step in steps],
        np.array([window_of(vehicle, step.tilt, EPSILON, 3) for step in steps]),
    ).min(axis=1)
    answers = [answer_of_rule(vehicle, joint(case), PERIOD, step) for step in steps]
    ours = np.array([answer.cost for answer in answers])
    assert (ours <= three * (1.0 + 1e-12)).all()
    assert np.sum(ours < three * (1.0 - 1e-9)) > 500
    assert max(answer.kkt_residual for answer in answers) <= PROVEN
    before, after = [step.tilt for step in steps], [answer.tilt[0] for answer in answers]
    assert np.abs(np.subtract(after, before)).max() <= EPSILON + 1e-15


def test_with_one_servo_a_fine_search_finds_nothing_cheaper_nearby() -> None:
    """Of 361 tilts in the window, none between the answer and the candidate it came from."""
    vehicle, generator = om.load_vehicle("omnimorph"), np.random.default_rng(4)
    found = 0
    for _ in range(50):
        step = random_step(generator, vehicle)
        ours = answer_of_rule(vehicle, joint("b"), PERIOD, step)
        search = om.ExhaustiveTilt(span="window", candidates=361, **WEIGHTS["b"])
        finest = answer_of_rule(vehicle, search, PERIOD, step)
        found += ours.cost <= finest.cost * (1.0 + 1e-12)
    assert found >= 48


@pytest.mark.slow
def test_against_a_general_nonlinear_solver() -> None:
    """SciPy's SLSQP from the thrusts where the rule starts: 200 steps of seven vehicles.

    J has several minima, so that two ways down may end in two of them: they do in one of these
    steps, where a rotor near rest may turn either way and SLSQP finds the lower end.
    """
    generator = np.random.default_rng(5)
    excess = []
    for k in range(200):
        vehicle, case = vehicle_named(VEHICLES[k % len(VEHICLES)]), "ab"[k % 2]
        step = random_situation(generator, vehicle)
        problem = Problem(vehicle, joint(case), PERIOD, step)
        ours = problem.answer(PERIOD)
        assert problem.residual(problem.point(ours)) <= PROVEN
        start = problem.point(answer_at_kept_tilts(vehicle, case, step))
        size = problem.J(start)
        reported = minimize(
            lambda z, p=problem, size=size: p.J(z) / size,
            start,
            jac=lambda z, p=problem, size=size: p.gradient(z) / size,
            bounds=np.column_stack([problem.lower, problem.upper]),
            method="SLSQP",
            options={"maxiter": 2000, "ftol": 1e-15},
        )
        best = problem.J(np.clip(reported.x, problem.lower, problem.upper))
        excess.append((ours.cost - best) / best)
    assert np.sum(np.array(excess) > 1e-6) <= 1
    assert max(excess) < 1e-3


# --- the servos ---------------------------------------------------------------------------------


def test_each_servo_has_its_own_rate_and_range() -> None:
    rate = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    vehicle = build_arms(
        servo_rate_max=rate,
        servo_angle_min=-np.linspace(0.5, 1.0, 6),
        servo_angle_max=np.linspace(0.5, 1.0, 6),
    )
    generator, reached = np.random.default_rng(6), np.zeros(6, dtype=int)
    for _ in range(100):
        step = random_situation(generator, vehicle)
        tilt = Problem(vehicle, joint("b"), PERIOD, step).answer(PERIOD).tilt
        moved = np.abs(tilt - step.tilt)
        assert (moved <= rate * PERIOD + 1e-15).all()
        assert (tilt >= vehicle.servo_angle_min).all()
        assert (tilt <= vehicle.servo_angle_max).all()
        reached += moved >= rate * PERIOD * (1.0 - 1e-12)
    assert (reached > 10).all()


@pytest.mark.parametrize("name", ["omnimorph", "arms"])
def test_a_tilt_that_gains_nothing_stays(name: str) -> None:
    """Falling freely costs nothing at any tilt, if the rotors rested before."""
    vehicle, zero = vehicle_named(name), np.zeros(3)
    falls = np.array([0.0, 0.0, -9.81, 0.0, 0.0, 0.0])
    tilt = np.full(vehicle.n_servos, 0.3)
    state = om.State(zero, np.eye(3), zero, zero)
    step = Situation(state, falls, np.zeros(vehicle.n_rotors), tilt)
    answer = Problem(vehicle, joint("b"), PERIOD, step).answer(PERIOD)
    assert answer.cost == 0.0
    np.testing.assert_array_equal(answer.tilt, tilt)


def test_motion_of_the_tilts_has_its_price() -> None:
    vehicle, generator = build_arms(), np.random.default_rng(7)
    step = random_situation(generator, vehicle)
    moves = []
    for W4 in (0.0, 1e2, 1e4, 1e9):
        problem = Problem(vehicle, joint("b", W4=W4), PERIOD, step)
        answer = problem.answer(PERIOD)
        assert answer.cost == pytest.approx(problem.J(problem.point(answer)), rel=1e-9)
        assert problem.residual(problem.point(answer)) <= PROVEN
        moves.append(float(np.linalg.norm((answer.tilt - step.tilt) / problem.epsilon)))
    assert (np.diff(moves) <= 0.0).all()
    assert moves[-1] < 1e-3 < moves[0]


def test_a_rotor_that_does_not_tilt_flies_beside_those_that_do() -> None:
    star = build_tilting_star(6)
    servo = np.array([0, -1, 1, -1, 2, -1])
    hinge = np.where(servo[:, None] < 0, 0.0, star.hinge_axis)
    names = ("angle_min", "angle_max", "rate_max", "time_constant")
    three = {f"servo_{name}": getattr(star, f"servo_{name}")[:3] for name in names}
    vehicle = star.replace(
        rotor_servo=servo, hinge_axis=hinge, servo_name=star.servo_name[:3], **three
    )
    generator = np.random.default_rng(8)
    for _ in range(20):
        problem = Problem(vehicle, joint("b"), PERIOD, random_situation(generator, vehicle))
        assert problem.residual(problem.point(problem.answer(PERIOD))) <= PROVEN


# --- what is refused (in files: see test_scenario_files.py) ---------------------------------------


@pytest.mark.parametrize("W4", [-1.0, float("nan"), float("inf"), "1", None, True, [1.0]])
def test_another_weight_on_motion_is_refused(W4: Any) -> None:
    with pytest.raises(ScenarioError) as caught:
        joint("b", W4=W4)
    assert str(caught.value).startswith("joint-tilt: W4 is ")
    assert str(caught.value).endswith(
        ", but it must be a number, not negative, 0 or from 1e-30 to 1e30."
    )


def test_a_vehicle_without_servos_is_refused() -> None:
    with pytest.raises(ScenarioError) as caught:
        om.PoseController(build_star(6), om.TrackingGains(), joint("b"), PERIOD)
    assert str(caught.value) == (
        'vehicle small with 0 servos: controller.allocator is "joint-tilt", '
        "but it must be fixed-tilt."
    )


def test_a_search_over_one_tilt_names_the_rule_for_several() -> None:
    vehicle = random_tilting_vehicle(np.random.default_rng(0), 8, 2)
    rule = om.ThreeCandidates(**WEIGHTS["b"])
    with pytest.raises(ScenarioError) as caught:
        om.PoseController(vehicle, om.TrackingGains(), rule, PERIOD)
    assert str(caught.value).endswith("but it must be joint-tilt or fixed-tilt.")


@pytest.mark.parametrize("thrust", [np.nan, np.inf])
def test_numbers_that_are_not_finite_end_the_search(thrust: float) -> None:
    vehicle = build_arms()
    step = random_situation(np.random.default_rng(9), vehicle)
    wrong = step._replace(acceleration=np.full(6, thrust))
    answer = Problem(vehicle, joint("b"), PERIOD, wrong).answer(PERIOD)
    assert not answer.kkt_residual <= PROVEN
