"""How far it goes: the largest loss of thrust that a case survives, beside what physics allows.

The physical limit is the largest loss at which some tilt within the limits still holds the weight
at zero moment in every attitude of the trajectory.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np

from omnimorph.analysis import hover_map
from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects import Effectiveness
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import load_scenario
from omnimorph.studies.reproduction.flights import CASES, A, with_effects
from omnimorph.studies.reproduction.lost_thrust import (
    KINDS,
    NOT_LOST,
    POSE_KEPT,
    Share,
    count_met,
    degrade,
    speed_limits,
    with_speed_limit,
)
from omnimorph.studies.reproduction.plan import FlyJobs, Plan, fly_over_seeds

PhysicalLimits = dict[tuple[str, float], float]
"""A share of the thrust, by the kind of loss and the limit of rotor speed, rad/s."""

_LARGEST_LOSS = {"all rotors": 0.9, "lower rotors": 0.98}  # where nothing flies any more


@dataclass(frozen=True, kw_only=True, eq=False)
class Frontier:
    """How the share of flights that survive falls with the loss of thrust, a share as well.

    The bracket is the largest loss tried at which at least half of them do, and the next one tried,
    that fewer do.
    """

    scenario: str
    kind: str  # which rotors lose thrust
    criterion: str  # what counts: `NOT_LOST` or `POSE_KEPT`
    speed_limit: float  # rad/s, of every rotor, for the controller and the plant
    survived: Mapping[float, Share]  # at every loss that was tried
    bracket: tuple[float, float]
    physical_limit: float  # the largest loss at which the weight can be held


def count_frontiers(plan: Plan) -> int:
    """Return how many flights `search_frontiers` and `fly_dead_rotors` hand out."""
    vehicle = load_scenario(A).vehicle
    searches = len(CASES) * len(KINDS) * 2 * len(speed_limits(vehicle))
    return (searches * plan.loss_rounds + len(CASES) * vehicle.n_rotors) * plan.loss_seeds


# --- how far it goes ------------------------------------------------------------------------------


def search_frontiers(plan: Plan, fly_jobs: FlyJobs, physical: PhysicalLimits) -> list[Frontier]:
    """Halve, for all cases at once, the interval in which half of the flights begin to be lost."""
    scenarios = {name: load_scenario(name) for name in CASES}
    limits = speed_limits(scenarios[A].vehicle)
    searches = list(product(CASES, KINDS, (NOT_LOST, POSE_KEPT), limits))
    intervals = [(0.0, _LARGEST_LOSS[kind]) for _, kind, _, _ in searches]
    survived: list[dict[float, Share]] = [{} for _ in searches]
    seeds = plan.first_seeds(plan.loss_seeds)
    for _ in range(plan.loss_rounds):
        tried = [0.5 * (low + high) for low, high in intervals]
        weakened = {
            i: degrade(with_speed_limit(scenarios[name], limit), tried[i], kind)
            for i, (name, kind, _, limit) in enumerate(searches)
        }
        flown = fly_over_seeds(weakened, seeds, fly_jobs, "the largest loss that is survived")
        for i, (loss, (low, high)) in enumerate(zip(tried, intervals, strict=True)):
            survived[i][loss] = count_met(flown[i], searches[i][2])
            intervals[i] = (loss, high) if survived[i][loss].at_least_half else (low, loss)
    return [
        Frontier(
            scenario=name,
            kind=kind,
            criterion=criterion,
            speed_limit=limit,
            survived=found,
            bracket=bracket,
            physical_limit=physical[kind, limit],
        )
        for (name, kind, criterion, limit), found, bracket in zip(
            searches, survived, intervals, strict=True
        )
    ]


def physical_limits() -> PhysicalLimits:
    """Return the largest loss that physics allows, by which rotors lose thrust and their limit."""
    scenario = load_scenario(A)
    up = _attitudes(scenario)
    return {
        (kind, limit): _physical_limit(with_speed_limit(scenario, limit).vehicle, kind, up)
        for kind in KINDS
        for limit in speed_limits(scenario.vehicle)
    }


def _physical_limit(vehicle: Vehicle, kind: str, up: FloatArray) -> float:
    """Return the largest loss at which each attitude is held by some tilt within the limits."""
    tilts = np.linspace(vehicle.servo_angle_min[0], vehicle.servo_angle_max[0], 61)
    lower = vehicle.rotor_position[:, 2] < 0.0
    loses = lower if kind == "lower rotors" else np.ones(len(lower), dtype=bool)

    def holds(loss: float) -> bool:
        # thrust falls for the same speed and drag, so drag per thrust rises
        weaker = vehicle.thrust_coefficient * np.where(loses, 1.0 - loss, 1.0)
        return bool(hover_map(vehicle.replace(thrust_coefficient=weaker), up, tilts).feasible.all())

    return _last_true(holds, 0.0, 0.999)


def _last_true(holds: Callable[[float], bool], low: float, high: float) -> float:
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def _attitudes(scenario: Scenario) -> FloatArray:
    """Return each vertical seen from the body along the trajectory once, (D, 3)."""
    reference = scenario.reference
    times = np.arange(0.0, reference.duration, 0.2)
    return np.unique([reference(float(t)).R_WB[2].round(3) for t in times], axis=0)


def fly_dead_rotors(plan: Plan, fly_jobs: FlyJobs) -> dict[tuple[str, str], list[Share]]:
    """Stop each rotor in turn, in both cases; return the shares by case and criterion."""
    found = {}
    seeds = plan.first_seeds(plan.loss_seeds)
    for name in CASES:
        scenario = load_scenario(name)
        n = scenario.vehicle.n_rotors
        dead = {
            k: with_effects(scenario, Effectiveness(share=tuple(float(i != k) for i in range(n))))
            for k in range(n)
        }
        flown = fly_over_seeds(dead, seeds, fly_jobs, "a dead rotor")
        for criterion in (NOT_LOST, POSE_KEPT):
            found[name, criterion] = [count_met(part, criterion) for part in flown.values()]
    return found
