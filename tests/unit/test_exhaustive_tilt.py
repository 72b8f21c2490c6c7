"""The exhaustive search of the tilt: against brute force by NumPy and DAQP, and in flight."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.physics.small_vehicles import random_tilting_vehicle
from tests.unit.tilt_searches import (
    CASE_B,
    EPSILON,
    WEIGHTS,
    ControlStep,
    answer_of_rule,
    costs_shown,
    flown_by_textbook,
    random_step,
    range_of,
    steps_of,
    window_of,
)

import omnimorph as om
from omnimorph.control.allocators import Span
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.results.run import COLUMNS
from omnimorph.simulation.scenario import Scenario

PERIOD = 0.004  # s
CLEAR = 1e-9  # relative: costs that lie closer are the same to rounding


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return om.load_vehicle("omnimorph")


def searched(case: str, span: Span, candidates: int) -> om.ExhaustiveTilt:
    """Return the rule with the weights of a case."""
    return om.ExhaustiveTilt(span=span, candidates=candidates, **WEIGHTS[case])


def scenario_of(case: str, span: Span, candidates: int) -> Scenario:
    """Return a case of the paper, flown with the rule."""
    scenario = om.load_scenario(f"paper-case-{case}")
    return replace(scenario, allocator=searched(case, span, candidates))


def test_three_in_a_window_fly_the_paper_s_rule_to_the_last_bit() -> None:
    ours = om.fly(scenario_of("a", "window", 3))
    reported = om.fly(om.load_scenario("paper-case-a"))
    assert len(ours.time) == 45_001
    for column in COLUMNS:
        np.testing.assert_array_equal(getattr(ours, column.name), getattr(reported, column.name))


# --- one control step ---------------------------------------------------------------------------


@pytest.mark.parametrize("case", ["a", "b"])
@pytest.mark.parametrize("candidates", [3, 9, 21])
def test_a_window_chooses_what_brute_force_chooses(
    vehicle: Vehicle, case: str, candidates: int
) -> None:
    generator, clear = np.random.default_rng(candidates), 0
    for _ in range(25):
        step = random_step(generator, vehicle)
        chosen = answer_of_rule(vehicle, searched(case, "window", candidates), PERIOD, step)
        tilts = window_of(vehicle, step.tilt, EPSILON, candidates)
        costs = costs_shown(vehicle, case, step, tilts)
        assert chosen.cost == pytest.approx(costs.min(), rel=CLEAR)
        assert abs(tilts - chosen.tilt[0]).min() < 1e-12
        if np.sum(costs <= costs.min() * (1.0 + CLEAR)) == 1:
            assert chosen.tilt[0] == pytest.approx(tilts[costs.argmin()], abs=1e-12)
            clear += 1
    assert clear >= 15


@pytest.mark.parametrize("case", ["a", "b"])
@pytest.mark.parametrize("period", [PERIOD, 0.25])
def test_over_the_range_the_tilt_goes_towards_what_brute_force_chooses(
    vehicle: Vehicle, case: str, period: float
) -> None:
    """In 4 ms the aim is seldom reached, in 0.25 s (25 degrees) often."""
    generator, reach = np.random.default_rng(5), float(vehicle.servo_rate_max[0]) * period
    reached = 0
    for _ in range(25):
        step = random_step(generator, vehicle)
        chosen = answer_of_rule(vehicle, searched(case, "range", 31), period, step)
        tilts = range_of(vehicle, step.tilt, 31)
        aim = tilts[costs_shown(vehicle, case, step, tilts).argmin()]
        expected = step.tilt + np.clip(aim - step.tilt, -reach, reach)
        assert chosen.tilt[0] == pytest.approx(expected, abs=1e-12)
        reported = flown_by_textbook(vehicle, case, step, float(chosen.tilt[0]))
        assert chosen.cost == pytest.approx(reported.cost, rel=CLEAR)
        np.testing.assert_allclose(chosen.thrust, reported.thrust, rtol=0.0, atol=1e-6)
        reached += bool(abs(aim - step.tilt) <= reach)
    assert (reached < 5) if period == PERIOD else (5 < reached < 25)


@pytest.mark.parametrize("n", [5, 6, 12])
@pytest.mark.parametrize("span", ["window", "range"])
def test_other_numbers_of_rotors(n: int, span: Span) -> None:
    generator = np.random.default_rng(n)
    vehicle = random_tilting_vehicle(generator, n)
    for _ in range(5):
        step = random_step(generator, vehicle)
        chosen = answer_of_rule(vehicle, searched("b", span, 9), 10.0, step)  # reaches everything
        window = window_of(vehicle, step.tilt, 10.0, 9)
        tilts = window if span == "window" else range_of(vehicle, step.tilt, 9)
        costs = costs_shown(vehicle, "b", step, tilts)
        assert chosen.cost == pytest.approx(costs.min(), rel=1e-8)


@pytest.mark.parametrize("tilt", [0.0, 0.3, np.pi / 3.0])
@pytest.mark.parametrize("span", ["window", "range"])
def test_a_tie_stays(vehicle: Vehicle, span: Span, tilt: float) -> None:
    """Falling freely costs nothing at any tilt, if the rotors rested before."""
    falls = np.array([0.0, 0.0, -9.81, 0.0, 0.0, 0.0])
    zero = np.zeros(3)
    step = ControlStep(om.State(zero, np.eye(3), zero, zero), falls, np.zeros(8), tilt)
    chosen = answer_of_rule(vehicle, searched("b", span, 61), PERIOD, step)
    assert chosen.cost == 0.0
    assert chosen.tilt[0] == tilt


# --- in flight ----------------------------------------------------------------------------------


@pytest.mark.parametrize("case", ["a", "b"])
def test_along_a_flight_no_step_costs_more_than_with_three_candidates(case: str) -> None:
    scenario = om.load_scenario(f"paper-case-{case}")
    vehicle = scenario.vehicle
    steps = steps_of(om.fly(scenario), scenario, every=25)
    assert len(steps) == 450
    tilts = np.array([window_of(vehicle, step.tilt, EPSILON, 21) for step in steps])
    costs = om.cost_over_tilt(
        vehicle,
        scenario.allocator,
        [step.row for step in steps],
        [step.acceleration for step in steps],
        [step.thrust for step in steps],
        tilts,
    )
    exhaustive, three = searched(case, "window", 21), scenario.allocator
    ours = np.array([answer_of_rule(vehicle, exhaustive, PERIOD, step).cost for step in steps])
    paper = np.array([answer_of_rule(vehicle, three, PERIOD, step).cost for step in steps])
    np.testing.assert_allclose(ours, costs.min(axis=1), rtol=CLEAR)
    np.testing.assert_allclose(paper, costs[:, [0, 1, 20]].min(axis=1), rtol=CLEAR)
    assert (ours <= paper).all()
    assert (ours < paper).any()


@pytest.mark.parametrize("case", ["a", "b"])
@pytest.mark.parametrize(("span", "candidates"), [("window", 21), ("range", 61)])
def test_the_paper_s_flight_is_completed(case: str, span: Span, candidates: int) -> None:
    scenario = scenario_of(case, span, candidates)
    run, paper = om.fly(scenario), om.fly(om.load_scenario(f"paper-case-{case}"))
    assert run.outcome is om.Outcome.COMPLETED
    assert run.metrics.kkt_residual_max < 1e-9
    assert run.metrics.position_error_mean_m < 1e-3
    energy = paper.metrics.drag_energy_paper
    assert run.metrics.drag_energy_paper == pytest.approx(energy, rel=0.02)
    moved = np.abs(np.diff(run.tilt_command[:-1, 0]))
    assert moved.max() <= EPSILON * (1.0 + 1e-12)
    assert moved.max() > 0.5 * EPSILON
    assert run.tilt_command.min() >= 0.0
    assert run.tilt_command.max() <= scenario.vehicle.servo_angle_max[0]


# --- what is refused (in files: see test_scenario_files.py) ---------------------------------------


@pytest.mark.parametrize("candidates", [0, 1, 2, 4, -3, 363, 1000, 5.0, "21", None, True])
def test_another_number_of_candidates_is_refused(candidates: Any) -> None:
    with pytest.raises(ScenarioError) as caught:
        om.ExhaustiveTilt(span="window", candidates=candidates, **CASE_B)
    assert str(caught.value).startswith("exhaustive-tilt: candidates is ")
    assert str(caught.value).endswith(", but it must be an odd whole number from 3 to 361.")


@pytest.mark.parametrize("span", ["whole", "", None, 1, ("window",)])
def test_another_span_is_refused(span: Any) -> None:
    with pytest.raises(ScenarioError) as caught:
        om.ExhaustiveTilt(span=span, candidates=21, **CASE_B)
    assert str(caught.value).startswith("exhaustive-tilt: span is ")
    assert str(caught.value).endswith(', but it must be "window" or "range".')


@pytest.mark.parametrize("servos", [0, 2])
@pytest.mark.parametrize("span", ["window", "range"])
def test_a_vehicle_without_its_one_servo_is_refused(servos: int, span: Span) -> None:
    generator = np.random.default_rng(0)
    several = random_tilting_vehicle(generator, 8, 2)
    names = ("angle_min", "angle_max", "rate_max", "time_constant")
    none = several.replace(
        hinge_axis=np.zeros((8, 3)),
        rotor_servo=np.full(8, -1),
        servo_name=(),
        **{f"servo_{name}": np.zeros(0) for name in names},
    )
    vehicle = several if servos == 2 else none
    with pytest.raises(ScenarioError) as caught:
        om.PoseController(vehicle, om.TrackingGains(), searched("b", span, 3), PERIOD)
    allowed = "joint-tilt or fixed-tilt" if servos else "fixed-tilt"
    assert str(caught.value) == (
        f'vehicle small with {servos} servos: controller.allocator is "exhaustive-tilt", '
        f"but it must be {allowed}."
    )
