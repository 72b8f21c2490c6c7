"""Which imperfection does what: the perfect plant with one more, the realistic one less or more.

Each plant flies Case A and Case B over a few seeds. The question is what makes the tilt of Case A
climb, and what brings errors to the size that the paper reports.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.simulation.effects import (
    CommandDelay,
    DeadBand,
    Effect,
    Effectiveness,
    Interference,
    MeasurementNoise,
    ModelMismatch,
    RotorLag,
    RotorMomentum,
    ServoLag,
    ServoRateLimit,
    SpeedLimits,
)
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import load_plant, load_scenario
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.many_flights import Job
from omnimorph.studies.reproduction.flights import CASES, A, pose_only, with_effects
from omnimorph.studies.reproduction.plan import FlyJobs, Plan
from omnimorph.studies.reproduction.spread import Spread, spread_of

PERFECT, LESS = "perfect plant, plus one", "realistic plant, less one"
MORE, REFERENCE = "realistic plant, plus one", "realistic plant, another reference"
METRICS = (
    "tilt_mean_deg",
    "drag_energy_paper",
    "acceleration_energy_paper",
    "position_error_mean_m",
    "position_error_rms_m",
    "attitude_error_paper",
)
"""What is compared."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Condition:
    """One way to fly, and what came of it."""

    group: str  # what it is compared with
    label: str  # what is different
    flown: Mapping[str, list[FlightResult]]  # scenario -> one for each seed

    def spread(self, scenario: str, metric: str) -> Spread:
        """Return a metric over the seeds."""
        return spread_of(self.flown[scenario], metric)


@dataclass(frozen=True, kw_only=True)
class Lag:
    """The closed form of a reference without feed-forward: gain ratio × path length / duration.

    Attributes
    ----------
    attitude_time, position_time : float, s
        Gain of the rate over that of the attitude, and of the velocity over that of the position.
    turned, path_length : float, rad and m
        How far the trajectory turns and goes in all.
    duration : float, s
    """

    attitude_time: float
    position_time: float
    turned: float
    path_length: float
    duration: float

    @property
    def attitude_error(self) -> float:
        """Mean angle by which the attitude lags, rad: near ‖e_R‖, its sine."""
        return self.attitude_time * self.turned / self.duration

    @property
    def position_error(self) -> float:
        """Mean distance by which the position lags, m."""
        return self.position_time * self.path_length / self.duration

    def duration_for(self, attitude_error: float) -> float:
        """Return how long a flight that turns as far takes for a mean attitude error, s."""
        return self.attitude_time * self.turned / attitude_error


@dataclass(frozen=True, kw_only=True, eq=False)
class Ablation:
    """All conditions, in the order of every table, and the closed form."""

    conditions: list[Condition]
    lag: Lag

    def as_dict(self) -> dict[str, Any]:
        """Return what ``results.json`` holds of it."""
        rows = [
            {
                "group": condition.group,
                "label": condition.label,
                **{
                    scenario: {
                        metric: condition.spread(scenario, metric)._asdict() for metric in METRICS
                    }
                    for scenario in CASES
                },
            }
            for condition in self.conditions
        ]
        lag = vars(self.lag) | {
            "attitude_error": self.lag.attitude_error,
            "position_error_m": self.lag.position_error,
        }
        return {"conditions": rows, "lag": lag}


def count_ablation(plan: Plan) -> int:
    """Return how many flights `fly_ablation` hands out."""
    return sum(
        len(_seeds(one, plan)) for name in CASES for one in _ways(load_scenario(name)).values()
    )


def fly_ablation(plan: Plan, fly_jobs: FlyJobs) -> Ablation:
    """Fly both cases in every way."""
    scenarios = {name: load_scenario(name) for name in CASES}
    ways = {(name, *way): one for name in CASES for way, one in _ways(scenarios[name]).items()}
    jobs = [Job(one, seed) for one in ways.values() for seed in _seeds(one, plan)]
    flown = iter(fly_jobs(jobs, "one imperfection at a time"))
    found = {way: [next(flown) for _ in _seeds(one, plan)] for way, one in ways.items()}
    conditions = [
        Condition(
            group=group, label=label, flown={name: found[name, group, label] for name in CASES}
        )
        for group, label in _ways(scenarios[A])
    ]
    return Ablation(conditions=conditions, lag=_lag(scenarios[A]))


def _seeds(scenario: Scenario, plan: Plan) -> range:
    """Return the seeds of a scenario: one is enough where nothing is drawn at random."""
    noisy = any(isinstance(effect, MeasurementNoise) for effect in scenario.plant.effects)
    return plan.first_seeds(plan.repeats if noisy else 1)


# --- ways to fly ----------------------------------------------------------------------------------

_Ways = dict[tuple[str, str], Scenario]


def _ways(scenario: Scenario) -> _Ways:
    """Return every way to fly a scenario by its group and label."""
    return (
        _perfect_plus(scenario) | _realistic_less(scenario) | _realistic_plus(scenario)
    ) | _other_references(scenario)


def _perfect_plus(scenario: Scenario) -> _Ways:
    perfect = replace(scenario, plant=load_plant("perfect"))
    noise = _noise(scenario)
    one_more: dict[str, tuple[Effect, ...]] = {
        "rotor lag": (RotorLag(),),
        "rotor speed limits": (SpeedLimits(),),
        "servo rate limit": (ServoRateLimit(),),
        "servo lag, 100 ms": (ServoLag(time_constant=0.1),),
        "noise": (noise,),
        "noise, filtered": (replace(noise, filtered=True),),
        **_common_effects(),
        "rotor momentum": (RotorMomentum(),),
        "interference and rotor momentum": (Interference(), RotorMomentum()),
    }
    ways = {"nothing": perfect, "control every 4 ms": _sampled(perfect, 0.004)}
    ways |= {label: with_effects(perfect, *effects) for label, effects in one_more.items()}
    return {(PERFECT, label): one for label, one in ways.items()}


def _realistic_less(scenario: Scenario) -> _Ways:
    ways = {
        "nothing": scenario,
        "control every 1 ms": _sampled(scenario, scenario.plant.physics_step),
    }
    for effect in scenario.plant.effects:
        others = tuple(other for other in scenario.plant.effects if other is not effect)
        without = f"no {effect.kind.replace('-', ' ')}"
        ways[without] = replace(scenario, plant=replace(scenario.plant, effects=others))
    return {(LESS, label): one for label, one in ways.items()}


def _realistic_plus(scenario: Scenario) -> _Ways:
    noise = _noise(scenario)
    louder = replace(
        noise,
        position=3 * noise.position,
        velocity=3 * noise.velocity,
        attitude=3 * noise.attitude,
        rate=3 * noise.rate,
    )
    slow = np.radians([10.0])
    ways = {
        "control every 8 ms": _sampled(scenario, 0.008),
        "rotor lag 10 ms": with_effects(scenario, RotorLag(up=0.010)),
        "rotor lag 50 ms": with_effects(scenario, RotorLag(up=0.050)),
        "servo lag, 100 ms": with_effects(scenario, ServoLag(time_constant=0.1)),
        "servo rate 10 °/s": replace(
            scenario, vehicle=scenario.vehicle.replace(servo_rate_max=slow)
        ),
        "noise × 3": with_effects(scenario, louder),
        "noise, filtered": with_effects(scenario, replace(noise, filtered=True)),
        **{label: with_effects(scenario, *more) for label, more in _common_effects().items()},
    }
    return {(MORE, label): one for label, one in ways.items()}


def _common_effects() -> dict[str, tuple[Effect, ...]]:
    """Return what both plants are given, one at a time."""
    return {
        "delay 8 ms": (CommandDelay(time=0.008),),
        "delay 16 ms": (CommandDelay(time=0.016),),
        "inertia + 20 %": (ModelMismatch(inertia=1.2),),
        "mass + 5 %": (ModelMismatch(mass=1.05),),
        "thrust − 10 %": (Effectiveness(share=0.9),),
        "interference": (Interference(),),
        "dead band 30 Hz": (DeadBand(smallest=2.0 * math.pi * 30.0),),
    }


def _other_references(scenario: Scenario) -> _Ways:
    reference = scenario.reference
    assert isinstance(reference, SegmentReference)
    in_steps = replace(scenario, reference=_moves_as_steps(reference))
    ways = {
        "twice as fast": replace(scenario, reference=_at_speed(reference, 2.0)),
        "half as fast": replace(scenario, reference=_at_speed(reference, 0.5)),
        "no feed-forward": pose_only(scenario),
        "no feed-forward, moves as steps": pose_only(in_steps),
        "no feed-forward, interference": with_effects(pose_only(scenario), Interference()),
    }
    return {(REFERENCE, label): one for label, one in ways.items()}


def _noise(scenario: Scenario) -> MeasurementNoise:
    """Return the noise of a realistic plant."""
    found = [one for one in scenario.plant.effects if isinstance(one, MeasurementNoise)]
    return found[0]


def _sampled(scenario: Scenario, period: float) -> Scenario:
    return replace(scenario, plant=replace(scenario.plant, control_period=period))


def _at_speed(reference: SegmentReference, speed: float) -> SegmentReference:
    """Return the same way, flown so many times as fast."""
    segments = [
        Segment(one.duration / speed, one.move_W, one.rotation_axis_W, one.rotation_angle)
        for one in reference.segments
    ]
    return SegmentReference(reference.start_p_WB, reference.start_R_WB, segments)


def _moves_as_steps(reference: SegmentReference) -> SegmentReference:
    """Return a reference that jumps where the other moves; turns stay as they are."""
    jump = 1e-3  # s: one physics step
    segments = []
    for one in reference.segments:
        if one.move_W.any():
            segments += [Segment(jump, one.move_W), Segment(one.duration - jump)]
        else:
            segments.append(one)
    return SegmentReference(reference.start_p_WB, reference.start_R_WB, segments)


def _lag(scenario: Scenario) -> Lag:
    gains, reference = scenario.gains, scenario.reference
    assert isinstance(reference, SegmentReference)
    return Lag(
        attitude_time=float(np.mean(gains.axes("rate") / gains.axes("attitude"))),
        position_time=float(np.mean(gains.axes("velocity") / gains.axes("position"))),
        turned=sum(abs(one.rotation_angle) for one in reference.segments),
        path_length=sum(float(np.linalg.norm(one.move_W)) for one in reference.segments),
        duration=reference.duration,
    )
