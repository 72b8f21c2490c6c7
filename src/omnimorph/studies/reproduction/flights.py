"""The paper's flights: every scenario over the seeds, in both plants, and what it says of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.reference.pose_only import PoseOnly
from omnimorph.reference.samples import SampledReference
from omnimorph.reference.segments import SegmentReference
from omnimorph.results.metrics import MEASURES
from omnimorph.results.run import Run
from omnimorph.simulation.effects import Interference, MeasurementNoise
from omnimorph.simulation.plant import PlantModel
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import load_plant, load_scenario
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.many_flights import Job, fly_runs
from omnimorph.studies.reproduction.plan import FlyJobs, Plan, fly_over_seeds, runs_of
from omnimorph.studies.reproduction.spread import spread_of

A, B, W3 = "paper-case-a", "paper-case-b", "paper-case-b-w3"
FIXED_A, FIXED_B = "paper-fixed-45-a", "paper-fixed-45-b"
SCENARIOS = (A, B, W3, FIXED_A, FIXED_B)
"""What the paper flew, in the order of every table."""
CASES = (A, B)
"""Its two cases, which all further studies fly."""

_STEPS = (0.5e-3, 1e-3, 2e-3, 4e-3)  # s, of the perfect plants that ought to agree
_TINY_NOISE = 1e-5  # m, m/s, rad and rad/s, 1σ


@dataclass(frozen=True)
class Variant:
    """Case A and Case B in a plant without imperfection, but for its step or a tiny noise."""

    step: float  # s, of physics and control
    noise: float  # m, m/s, rad and rad/s, 1σ of every measurement
    run: Run  # of Case A
    b: FlightResult  # of Case B in the same plant


@dataclass(frozen=True, kw_only=True)
class PaperFlights:
    """What came of the paper's flights, by the name of the scenario: one result for each seed.

    Without momentum (the plant ``realistic-1``) the spinning rotors carry no angular momentum, and
    so with the pose only, a reference without velocity and acceleration feed-forward; in wakes
    rotors blow on one another.
    """

    seeds: range
    runs: Mapping[str, Run]  # the first seed in the realistic plant, for the figures
    realistic: Mapping[str, list[FlightResult]]
    perfect: Mapping[str, FlightResult]  # needs no seed
    without_momentum: Mapping[str, list[FlightResult]]
    pose_only: Mapping[str, list[FlightResult]]
    in_wakes: Mapping[str, list[FlightResult]]
    variants: list[Variant]  # perfect plants that ought to agree

    def values(self, scenario: str, metric: str) -> FloatArray:
        """Return a metric of the completed realistic flights of a scenario."""
        flown = self.realistic[scenario]
        return np.array([getattr(one.metrics, metric) for one in flown if one.completed])

    def as_dict(self) -> dict[str, Any]:
        """Return what ``results.json`` holds of them."""
        groups = {
            "realistic": self.realistic,
            "without_momentum": self.without_momentum,
            "pose_only": self.pose_only,
            "in_wakes": self.in_wakes,
            "perfect": {name: [one] for name, one in self.perfect.items()},
        }
        found: dict[str, Any] = {
            group: {name: _over_metrics(flown) for name, flown in by_name.items()}
            for group, by_name in groups.items()
        }
        found["content_hash"] = {name: run.content_hash for name, run in self.runs.items()}
        found["variants"] = [
            {
                "step_s": variant.step,
                "noise": variant.noise,
                A: variant.run.metrics.as_dict(),
                B: variant.b.metrics and variant.b.metrics.as_dict(),
            }
            for variant in self.variants
        ]
        return found


def _over_metrics(flown: list[FlightResult]) -> dict[str, Any]:
    return {metric: spread_of(flown, metric)._asdict() for metric in MEASURES}


def count_flights(plan: Plan) -> int:
    """Return how many flights `fly_paper` hands out."""
    return len(SCENARIOS) * (4 * len(plan.seeds) + 1) + len(_STEPS) + 1


def fly_paper(plan: Plan, fly_jobs: FlyJobs) -> PaperFlights:
    """Fly the paper's scenarios over the seeds, in the realistic and in the perfect plant."""
    scenarios = {name: load_scenario(name) for name in SCENARIOS}
    perfect, no_momentum = load_plant("perfect"), load_plant("realistic-1")
    ideal = {name: replace(one, plant=perfect) for name, one in scenarios.items()}
    without_momentum = {name: replace(one, plant=no_momentum) for name, one in scenarios.items()}
    without_rates = {name: pose_only(one) for name, one in without_momentum.items()}
    in_wakes = {name: with_effects(one, Interference()) for name, one in scenarios.items()}
    once = fly_over_seeds(ideal, [0], fly_jobs, "the perfect plant")

    def over_seeds(flown: Mapping[str, Scenario], purpose: str) -> dict[str, list[FlightResult]]:
        return fly_over_seeds(flown, plan.seeds, fly_jobs, purpose)

    return PaperFlights(
        seeds=plan.seeds,
        runs=runs_of(scenarios, plan.seeds[0]),
        realistic=over_seeds(scenarios, "the paper's flights"),
        perfect={name: flown for name, (flown,) in once.items()},
        without_momentum=over_seeds(without_momentum, "rotors without momentum"),
        pose_only=over_seeds(without_rates, "references without feed-forward"),
        in_wakes=over_seeds(in_wakes, "rotors in one another's wakes"),
        variants=_fly_variants(scenarios, fly_jobs),
    )


def pose_only(scenario: Scenario) -> Scenario:
    """Return the scenario with a reference without velocity and acceleration feed-forward."""
    reference = scenario.reference
    assert isinstance(reference, SegmentReference | SampledReference)
    return replace(scenario, reference=PoseOnly(reference))


def with_effects(scenario: Scenario, *effects: Any) -> Scenario:
    """Return the scenario in its plant with more effects; one of a kind there gives way."""
    kinds = {effect.kind for effect in effects}
    kept = tuple(effect for effect in scenario.plant.effects if effect.kind not in kinds)
    return replace(scenario, plant=replace(scenario.plant, effects=(*kept, *effects)))


def _fly_variants(scenarios: Mapping[str, Scenario], fly_jobs: FlyJobs) -> list[Variant]:
    plants = [(step, 0.0) for step in _STEPS] + [(1e-3, _TINY_NOISE)]
    pairs = []
    for step, noise in plants:
        tiny = MeasurementNoise(position=noise, velocity=noise, attitude=noise, rate=noise)
        plant = PlantModel(
            physics_step=step, control_period=step, effects=(tiny,) if noise else (), name="variant"
        )
        pairs.append(tuple(replace(scenarios[name], plant=plant) for name in (A, B)))
    of_a = fly_runs([Job(a, 0) for a, _ in pairs])
    of_b = fly_jobs([Job(b, 0) for _, b in pairs], "plants that ought to agree")
    return [
        Variant(step, noise, run, flown)
        for (step, noise), run, flown in zip(plants, of_a, of_b, strict=True)
    ]
