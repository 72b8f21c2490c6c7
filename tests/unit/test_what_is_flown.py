"""What stands under a label of the reproduction is what was flown: each flight is known by its job.

Nothing is flown here; jobs are answered with their number.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.unit.reproduction_parts import LIMITS, W3, A, B, flown

import omnimorph as om
from omnimorph.reference.pose_only import PoseOnly
from omnimorph.simulation.scenario import Scenario
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.many_flights import Job
from omnimorph.studies.reproduction import ablation, degraded, frontier, hypotheses, lost_thrust
from omnimorph.studies.reproduction.lost_thrust import KINDS, NOT_LOST, POSE_KEPT
from omnimorph.studies.reproduction.plan import Plan

PLAN = Plan(range(3, 5), 2, 2, 6, quick=True)
PAPER = {name: om.load_scenario(name) for name in (A, B, W3)}
TURN = 2.0 * np.pi


class Asked:
    """Answers jobs with their number, and keeps them."""

    def __init__(self) -> None:
        self.jobs: list[Job] = []

    def __call__(self, jobs: Sequence[Job], words: str) -> list[FlightResult]:
        begin = len(self.jobs)
        self.jobs += jobs
        return [FlightResult(None, f"{k}") for k in range(begin, len(self.jobs))]

    def of(self, flights: Sequence[FlightResult], seeds: range) -> Scenario:
        """Return the scenario of some flights, which are one for each seed."""
        jobs = [self.jobs[int(one.failure)] for one in flights]
        assert [job.seed for job in jobs] == list(seeds)
        assert len({repr(job.scenario.plant) for job in jobs}) == 1
        return jobs[-1].scenario


def effects_of(scenario: Scenario) -> dict[str, Any]:
    return {effect.kind: effect for effect in scenario.plant.effects}


def is_of(scenario: Scenario, name: str) -> bool:
    """Tell a case by what distinguishes it, its weights."""
    weights = (PAPER[name].allocator.W1, PAPER[name].allocator.W3)
    return bool(np.all([np.array_equal(x, y) for x, y in zip(
        (scenario.allocator.W1, scenario.allocator.W3), weights, strict=True)]))  # fmt: skip


def test_the_cases_can_be_distinguished() -> None:
    for name in PAPER:
        assert [is_of(PAPER[other], name) for other in PAPER] == [one == name for one in PAPER]


# --- hypotheses -----------------------------------------------------------------------------------


def test_hypotheses_fly_what_they_are_called() -> None:
    asked = Asked()
    found = hypotheses.fly_hypotheses(PLAN, asked)
    assert len(found) == 8
    assert hypotheses.count_hypotheses(PLAN) == len(asked.jobs)
    verdicts = [one.verdict and one.verdict.value for one in found]
    assert verdicts == [None, None, *5 * ["conjectured"], "calibrated"]
    for one in found:
        assert bool(one.against) == (one.verdict is not None), "nothing speaks against the text"
        assert ("fitted" in one.against) == (one.label.endswith("24"))
        assert ("prints a position gain of 300" in one.against) == ("position gain" in one.label)
        for name in PAPER:
            scenario = asked.of(one.flown[name], PLAN.seeds)
            assert is_of(scenario, name)
            effects = effects_of(scenario)
            assert ("rotor-momentum" in effects) == ("no rotor momentum" not in one.label)
            assert ("interference" in effects) == ("interference" in one.label)
            steady = isinstance(scenario.reference, PoseOnly)
            assert steady == ("without velocity and acceleration feed-forward" in one.label)
            *_, gain = one.label.split("position gain ")
            expected = float(gain) if gain != one.label else 300.0
            np.testing.assert_allclose(scenario.gains.axes("position"), expected)


# --- ablation -------------------------------------------------------------------------------------

TWO = ("interference", "rotor-momentum")
# What a label adds to a plant, and the number by which it does.
ADDED: dict[str, dict[str, dict[str, Any]]] = {
    "nothing": {},
    "rotor lag": {"rotor-lag": {}},
    "rotor lag 10 ms": {"rotor-lag": {"up": 0.010}},
    "rotor lag 50 ms": {"rotor-lag": {"up": 0.050}},
    "rotor speed limits": {"speed-limits": {}},
    "servo rate limit": {"servo-rate-limit": {}},
    "servo lag, 100 ms": {"servo-lag": {"time_constant": 0.1}},
    "noise": {"measurement-noise": {"filtered": False}},
    "noise, filtered": {"measurement-noise": {"filtered": True}},
    "noise × 3": {"measurement-noise": {"position": 3e-3, "velocity": 0.03}},
    "delay 8 ms": {"command-delay": {"time": 0.008}},
    "delay 16 ms": {"command-delay": {"time": 0.016}},
    "inertia + 20 %": {"model-mismatch": {"inertia": 1.2, "mass": 1.0}},
    "mass + 5 %": {"model-mismatch": {"mass": 1.05, "inertia": 1.0}},
    "thrust − 10 %": {"effectiveness": {"share": 0.9}},
    "interference": {"interference": {}},
    "dead band 30 Hz": {"dead-band": {"smallest": 30.0 * TURN}},
    "rotor momentum": {"rotor-momentum": {}},
    "interference and rotor momentum": {kind: {} for kind in TWO},
    "no feed-forward, interference": {"interference": {}},
}
PERIODS = {"control every 1 ms": 1e-3, "control every 4 ms": 4e-3, "control every 8 ms": 8e-3}


def test_an_ablation_flies_what_it_is_called() -> None:
    asked = Asked()
    found = ablation.fly_ablation(PLAN, asked)
    assert ablation.count_ablation(PLAN) == len(asked.jobs)
    perfect = {kind for kind in effects_of(PAPER[A]) if kind == "none"}
    for one in found.conditions:
        base = perfect if one.group == ablation.PERFECT else set(effects_of(PAPER[A]))
        for name in (A, B):
            flights = one.flown[name]
            noisy = one.group != ablation.PERFECT or "noise" in one.label
            noisy = noisy and one.label != "no measurement noise"
            scenario = asked.of(flights, range(3, 5) if noisy else range(3, 4))
            assert is_of(scenario, name)
            effects = effects_of(scenario)
            if one.group == ablation.LESS and one.label.startswith("no "):
                assert set(effects) == base - {one.label.removeprefix("no ").replace(" ", "-")}
                continue
            added = ADDED.get(one.label, {})
            assert set(effects) == base | set(added), one.label
            for kind, numbers in added.items():
                for key, value in numbers.items():
                    shown = np.asarray(getattr(effects[kind], key))
                    np.testing.assert_allclose(shown, value, err_msg=one.label)
            period = PERIODS.get(one.label, 4e-3 if one.group != ablation.PERFECT else None)
            if period is not None:
                assert scenario.plant.control_period == pytest.approx(period)
            rate = 10.0 if one.label == "servo rate 10 °/s" else 100.0
            assert np.degrees(scenario.vehicle.servo_rate_max[0]) == pytest.approx(rate)
            check_reference(one.label, scenario)


@cache
def begin_of_moving() -> float:
    """Return when the paper's trajectory leaves its start, s."""
    moves = PAPER[A].reference
    start = moves(0.0).p_WB
    times: list[float] = np.arange(0.0, 20.0, 0.1).tolist()
    return next(t for t in times if np.any(moves(t).p_WB != start)) - 0.1


def check_reference(label: str, scenario: Scenario) -> None:
    reference = scenario.reference
    assert isinstance(reference, PoseOnly) == label.startswith("no feed-forward")
    speed = {"twice as fast": 2.0, "half as fast": 0.5}.get(label, 1.0)
    assert reference.duration == pytest.approx(PAPER[A].reference.duration / speed)
    first = begin_of_moving()
    soon = reference((first + 0.2) / speed).p_WB - reference(0.0).p_WB
    assert (float(np.linalg.norm(soon)) > 0.05) == label.endswith("moves as steps")


def test_the_closed_form_of_the_lag_is_of_the_papers_flight() -> None:
    lag = ablation._lag(PAPER[A])
    gains, reference = PAPER[A].gains, PAPER[A].reference
    assert lag.attitude_time == pytest.approx((gains.axes("rate") / gains.axes("attitude")).mean())
    ratio = (gains.axes("velocity") / gains.axes("position")).mean()
    assert lag.position_time == pytest.approx(ratio)
    time = np.linspace(0.0, reference.duration, 4001)
    poses = [reference(float(t)) for t in time]
    steps = np.diff([pose.p_WB for pose in poses], axis=0)
    assert lag.path_length == pytest.approx(np.linalg.norm(steps, axis=1).sum(), rel=1e-3)
    R = np.array([pose.R_WB for pose in poses])
    cosine = 0.5 * (np.einsum("kij,kij->k", R[1:], R[:-1]) - 1.0)
    assert lag.turned == pytest.approx(np.arccos(np.clip(cosine, -1.0, 1.0)).sum(), rel=2e-3)
    assert lag.duration == reference.duration


# --- less thrust ----------------------------------------------------------------------------------


def lost_of(scenario: Scenario) -> np.ndarray:
    share = effects_of(scenario)["effectiveness"].share
    return 1.0 - np.broadcast_to(np.asarray(share, dtype=np.float64), 8)


def test_the_papers_losses_are_flown_at_both_limits() -> None:
    asked = Asked()
    found = degraded.fly_paper_losses(PLAN, asked)
    expected = [(A, 0.35), (B, 0.35), (B, 0.3)]
    assert [(one.scenario, one.loss) for one in found[::2]] == expected
    for one in found:
        scenario = asked.of(one.flown, PLAN.seeds)
        assert is_of(scenario, one.scenario)
        np.testing.assert_allclose(lost_of(scenario), one.loss)
        np.testing.assert_allclose(scenario.vehicle.speed_max, one.speed_limit)
        np.testing.assert_allclose(scenario.vehicle.speed_min, -one.speed_limit)
    later = om.load_vehicle("omnimorph-2026").speed_max[0]
    limits = [PAPER[A].vehicle.speed_max[0], later]
    assert [one.speed_limit for one in found] == pytest.approx(3 * limits)


def test_a_search_ends_where_half_of_the_flights_are_lost() -> None:
    """Flights that keep the pose up to a loss of 0.2, and are lost beyond one of 0.4."""
    held = flown(position_error_max_m=0.05, attitude_error_max_rad=0.1)
    astray, lost = flown(position_error_max_m=0.2), flown("lost")
    asked = Asked()

    def fly(jobs: Sequence[Job], words: str) -> list[FlightResult]:
        asked(jobs, words)
        most = [lost_of(job.scenario).max() for job in jobs]
        return [held if one < 0.2 else astray if one < 0.4 else lost for one in most]

    limits = lost_thrust.speed_limits(PAPER[A].vehicle)
    physical = {(kind, limit): 0.1 * k + 0.01 * i for k, kind in enumerate(KINDS)
                for i, limit in enumerate(limits)}  # fmt: skip
    found = frontier.search_frontiers(PLAN, fly, physical)
    assert len({(o.scenario, o.kind, o.criterion, o.speed_limit) for o in found}) == 16
    for one in found:
        edge = 0.4 if one.criterion == NOT_LOST else 0.2
        low, high = one.bracket
        assert low <= edge <= high
        assert high - low == pytest.approx((0.9 if one.kind == KINDS[0] else 0.98) / 2**6)
        assert all(share == ((2, 2) if x < edge else (0, 2)) for x, share in one.survived.items())
        assert one.physical_limit == physical[one.kind, one.speed_limit]
    upper = PAPER[A].vehicle.rotor_position[:, 2] > 0.0
    of_lower = [job for job in asked.jobs if not np.allclose(lost_of(job.scenario), lost_of(
        job.scenario)[0])]  # fmt: skip
    assert len(of_lower) == len(asked.jobs) // 2
    for job in of_lower:
        assert (lost_of(job.scenario)[upper] == 0.0).all()
        assert (lost_of(job.scenario)[~upper] > 0.0).all()
    dead = Asked()
    shares = frontier.fly_dead_rotors(PLAN, dead)
    assert list(shares) == [(n, c) for n in (A, B) for c in (NOT_LOST, POSE_KEPT)]
    assert frontier.count_frontiers(PLAN) == len(asked.jobs) + len(dead.jobs)
    for k, job in enumerate(dead.jobs):
        assert is_of(job.scenario, A if k < 16 else B)
        np.testing.assert_array_equal(lost_of(job.scenario), np.eye(8)[k % 16 // 2])


@pytest.mark.slow
def test_limits_of_physics_are_those_of_hovering() -> None:
    """In the level attitude alone the weight is held by what is left of the largest lift."""
    vehicle = PAPER[A].vehicle
    for limit in LIMITS:
        fast = lost_thrust.with_speed_limit(PAPER[A], limit).vehicle
        found = frontier._physical_limit(fast, KINDS[0], np.array([[0.0, 0.0, 1.0]]))
        lift = float((vehicle.thrust_coefficient * limit**2).sum())
        assert found == pytest.approx(1.0 - vehicle.mass * 9.81 / lift, abs=2e-3)
    both = frontier._physical_limit(vehicle, KINDS[1], np.array([[0.0, 0.0, 1.0]]))
    assert both > frontier._physical_limit(vehicle, KINDS[0], np.array([[0.0, 0.0, 1.0]]))
