"""Choosing the tilt: three candidates, exhaustive searches, and a lower bound."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from omnimorph.analysis.effort import drag_power, least_effort
from omnimorph.control.allocators import ExhaustiveTilt
from omnimorph.control.tilt_cost import cost_over_tilt
from omnimorph.model.core import state_row
from omnimorph.model.dynamics import GRAVITY, hover_thrust, wrench_for
from omnimorph.protocols import Command, Desired, FloatArray, State
from omnimorph.results.run import Run
from omnimorph.simulation.fly import fly
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import load_scenario
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction.flights import CASES, A
from omnimorph.studies.reproduction.plan import FlyJobs, Plan, fly_over_seeds, runs_of
from omnimorph.studies.reproduction.spread import spread_of

THREE, WINDOW, RANGE = "three candidates", "exhaustive, window", "exhaustive, range"
_IN_WINDOW, _IN_RANGE = 21, 61
_BOUND_TILTS, _BOUND_PERIOD = 121, 0.04  # half a degree apart; s
_TURN = 2.0 * math.pi


@dataclass(frozen=True, kw_only=True, eq=False)
class Choice:
    """One method to choose the tilt; mappings are by the name of the scenario."""

    label: str
    runs: Mapping[str, Run]  # the first seed, for the figure
    flown: Mapping[str, list[FlightResult]]  # one for each seed


@dataclass(frozen=True, kw_only=True, eq=False)
class Gap:
    """How much more each step of the paper's rule costs than the best there is."""

    scenario: str
    span: str  # the best of what: `WINDOW` or `RANGE`
    gap: FloatArray  # (S,): (cost − least) / least at each control step of a flight

    @property
    def median(self) -> float:
        """The excess that half of the steps stay below."""
        return float(np.median(self.gap))

    @property
    def share_above_1_percent(self) -> float:
        """How many of the steps cost over 1 % more, as a share."""
        return float((self.gap > 0.01).mean())


@dataclass(frozen=True, kw_only=True, eq=False)
class LowerBound:
    """The least power with which the trajectory's exact wrench can be made, at K instants."""

    time: FloatArray  # (K,), s
    tilt: FloatArray  # (K,), rad: the best there
    power: FloatArray  # (K,), W

    @property
    def energy(self) -> float:
        """Over the flight, J."""
        return float(self.power.mean() * (self.time[-1] - self.time[0]))

    @property
    def energy_paper(self) -> float:
        """The same in the paper's count."""
        return self.energy / _TURN


@dataclass(frozen=True, kw_only=True, eq=False)
class TiltChoice:
    """All methods to choose the tilt, the gaps of the paper's, and the lower bound."""

    choices: list[Choice]
    gaps: list[Gap]
    lower_bound: LowerBound

    def excess(self, choice: Choice, scenario: str) -> float:
        """Return the energy of a method relative to the lower bound, less one."""
        mean = spread_of(choice.flown[scenario], "drag_energy_paper").mean
        return mean / self.lower_bound.energy_paper - 1.0

    def as_dict(self) -> dict[str, Any]:
        """Return what ``results.json`` holds of it."""
        metrics = ("drag_energy_paper", "tilt_mean_deg", "position_error_mean_m")
        return {
            "choices": [
                {
                    "label": choice.label,
                    **{
                        name: {
                            metric: spread_of(choice.flown[name], metric)._asdict()
                            for metric in metrics
                        }
                        | {"relative_to_lower_bound": self.excess(choice, name)}
                        for name in CASES
                    },
                }
                for choice in self.choices
            ],
            "gaps": [
                {
                    "scenario": one.scenario,
                    "span": one.span,
                    "median": one.median,
                    "mean": float(one.gap.mean()),
                    "share_above_1_percent": one.share_above_1_percent,
                    "largest": float(one.gap.max()),
                }
                for one in self.gaps
            ],
            "lower_bound": {
                "drag_energy_J": self.lower_bound.energy,
                "drag_energy_paper": self.lower_bound.energy_paper,
                "tilt_mean_deg": float(np.degrees(self.lower_bound.tilt.mean())),
            },
        }


def count_choices(plan: Plan) -> int:
    """Return how many flights `fly_choices` hands out."""
    return 3 * len(CASES) * plan.repeats


def fly_choices(plan: Plan, fly_jobs: FlyJobs) -> list[Choice]:
    """Fly both cases with each method to choose the tilt."""
    scenarios = {name: load_scenario(name) for name in CASES}
    seeds = plan.first_seeds(plan.repeats)
    choices = []
    for label in (THREE, WINDOW, RANGE):
        searches = {name: _searching(scenario, label) for name, scenario in scenarios.items()}
        flown = fly_over_seeds(searches, seeds, fly_jobs, "the choice of the tilt")
        choices.append(Choice(label=label, runs=runs_of(searches, seeds[0]), flown=flown))
    return choices


def _searching(scenario: Scenario, label: str) -> Scenario:
    """Return the scenario with another search over the tilt, and the same weights."""
    if label == THREE:
        return scenario
    rule = scenario.allocator
    return replace(
        scenario,
        allocator=ExhaustiveTilt(
            span="window" if label == WINDOW else "range",
            candidates=_IN_WINDOW if label == WINDOW else _IN_RANGE,
            W1=rule.W1,
            W2_position=rule.W2_position,
            W2_attitude=rule.W2_attitude,
            W3=rule.W3,
        ),
    )


# --- the gap at each step -------------------------------------------------------------------------


class _Witness:
    """The scenario's own controller, and a record of what it was given and what it decided."""

    def __init__(self, scenario: Scenario) -> None:
        self.controller = scenario.build_controller()
        self.thrust = hover_thrust(scenario.vehicle, scenario.tilt)
        self.tilt = float(scenario.tilt[0])
        self.seen: list[tuple[FloatArray, FloatArray, FloatArray, float, float]] = []

    def __call__(self, time: float, state: State, desired: Desired) -> Command:
        given = state_row(*state)
        decided = self.controller.step(given, state_row(*desired))
        self.seen.append(
            (given, decided.wrench_asked.copy(), self.thrust, self.tilt, float(decided.cost))
        )
        self.thrust, self.tilt = decided.thrust.copy(), float(decided.tilt[0])
        return Command(self.thrust, decided.tilt)


def measure_gaps(seed: int) -> list[Gap]:
    """Return the gaps of the paper's rule to the best of its window and of the whole range."""
    return [gap for name in CASES for gap in _gaps(load_scenario(name), seed)]


def _gaps(scenario: Scenario, seed: int) -> list[Gap]:
    witness = _Witness(scenario)
    fly(scenario, seed=seed, controller=witness)
    given, asked, before, tilt, cost = (
        np.array(column) for column in zip(*witness.seen, strict=True)
    )
    vehicle, rule = scenario.vehicle, scenario.allocator
    low, high = float(vehicle.servo_angle_min[0]), float(vehicle.servo_angle_max[0])
    reach = float(vehicle.servo_rate_max[0]) * scenario.plant.control_period
    window = tilt[:, None] + np.linspace(-reach, reach, _IN_WINDOW)
    tilts = {
        WINDOW: np.clip(window, low, high),
        RANGE: np.broadcast_to(np.linspace(low, high, _IN_RANGE), (len(tilt), _IN_RANGE)),
    }
    acceleration = _acceleration(scenario, given, asked)
    found = []
    for span, tried in tilts.items():
        least = cost_over_tilt(vehicle, rule, given, acceleration, before, tried).min(axis=1)
        least = np.minimum(least, cost)  # the grid may miss the tilt that was chosen
        found.append(Gap(scenario=scenario.name, span=span, gap=cost / least - 1.0))
    return found


def _acceleration(scenario: Scenario, given: FloatArray, asked: FloatArray) -> FloatArray:
    """Return the accelerations behind the wrenches that were asked for: (S, 6)."""
    vehicle = scenario.vehicle
    R, w = given[:, 3:12].reshape(-1, 3, 3), given[:, 15:18]
    linear = np.einsum("sij,sj->si", R, asked[:, :3]) / vehicle.mass - [0.0, 0.0, GRAVITY]
    torque = asked[:, 3:] - np.cross(w, w @ vehicle.inertia)
    return np.hstack([linear, np.linalg.solve(vehicle.inertia, torque.T).T])


# --- the lower bound ------------------------------------------------------------------------------


def find_lower_bound() -> LowerBound:
    """Return at each instant the tilt at which the desired motion takes the least power.

    Both cases have the same vehicle and the same trajectory, so that one bound serves both.
    """
    scenario = load_scenario(A)
    vehicle, reference = scenario.vehicle, scenario.reference
    time = np.arange(0.0, reference.duration, _BOUND_PERIOD)
    wanted = [reference(float(t)) for t in time]
    wrenches = np.array(
        [wrench_for(vehicle, State(*one[:4]), np.concatenate([one[4], one[5]])) for one in wanted]
    )
    low, high = float(vehicle.servo_angle_min[0]), float(vehicle.servo_angle_max[0])
    tilts = np.linspace(low, high, _BOUND_TILTS)
    power = np.full((len(tilts), len(time)), np.inf)
    for k, tilt in enumerate(tilts):
        found = least_effort(vehicle, np.array([tilt]), wrenches, "power")
        power[k] = np.where(found.feasible, drag_power(vehicle, found.thrust), np.inf)
    return LowerBound(time=time, tilt=tilts[power.argmin(axis=0)], power=power.min(axis=0))
