"""What could explain the sizes of the paper's errors: hypotheses, each flown over all the seeds.

Flown as stated, errors come out far smaller than the paper's. A hypothesis adds what the vehicle
has anyway (momentum of its rotors, interference between them) or changes one thing that is printed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from omnimorph.results.metrics import MEASURES
from omnimorph.simulation.effects import Interference
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import load_plant, load_scenario
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.flights import W3, A, B, pose_only, with_effects
from omnimorph.studies.reproduction.plan import FlyJobs, Plan, fly_over_seeds
from omnimorph.studies.reproduction.spread import Spread, spread_of
from omnimorph.studies.reproduction.verdicts import Verdict, is_near

CASES = (A, B, W3)
ERRORS = ("position_error_mean_m", "attitude_error_paper")
"""What is to be explained: three numbers of each."""
GAIN_WITHOUT_A_ZERO, FITTED_GAIN = 30.0, 24.0
"""Position gains, 1/s²: the printed 300 with one zero less; fitted to the paper's 11/44/41.2 mm."""


WITH_MOMENTUM, MOMENTUM_AND_WAKES = (
    "as stated, with rotor momentum",
    "rotor momentum and interference",
)
"""Labels of two of them."""


class _Change(NamedTuple):
    label: str
    verdict: Verdict | None  # if it explains a number; None: flown as the paper states it
    apply: Callable[[Scenario], Scenario]
    against: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class Hypothesis:
    """One way to read the paper, and what came of it."""

    label: str  # what is different from the paper's text
    verdict: Verdict | None  # of what it explains; None: flown as the paper states it
    against: str  # what speaks against it beside its numbers; may be empty
    flown: Mapping[str, list[FlightResult]]  # scenario -> one for each seed

    def spread(self, scenario: str, metric: str) -> Spread:
        """Return a metric over the seeds, in the unit of the paper's claims."""
        return spread_of(self.flown[scenario], metric, MEASURES[metric].factor)

    def explains(self, claim: paper.PaperClaim) -> bool:
        """Return whether the number of a claim comes out under it."""
        assert claim.value is not None
        here = self.spread(claim.about["scenario"], claim.about["metric"]).mean
        return is_near(here, claim.value)

    @property
    def explained(self) -> int:
        """How many of the paper's six errors come out."""
        return sum(self.explains(claim) for claim in error_claims())

    @property
    def ratio_of_position_errors(self) -> float:
        """Case B's mean position error over Case A's."""
        b, a = (self.spread(name, ERRORS[0]).mean for name in (B, A))
        return b / a

    def energy_difference(self, scenario: str) -> float:
        """How far the drag energy lies from the paper's, as a share of it."""
        claimed = next(
            claim.value
            for claim in paper.claims().values()
            if claim.about.get("metric") == "drag_energy_paper"
            and claim.about["scenario"] == scenario
        )
        assert claimed is not None
        return self.spread(scenario, "drag_energy_paper").mean / claimed - 1.0

    @property
    def objections(self) -> list[str]:
        """What speaks against it, in sentences without a full stop."""
        found = [self.against] if self.against else []
        third, second = (self.spread(name, ERRORS[1]).mean for name in (W3, B))
        if third > second:
            found.append("‖e_R‖ of the third flight is above Case B's, and the paper's is below")
        energies = [self.energy_difference(name) for name in (A, B)]
        if all(map(math.isfinite, energies)):
            a, b = (f"{100.0 * one:+.0f} %".replace("-", "−") for one in energies)
            found.append(f"energies {a} and {b} off the paper's in Cases A and B")
        return found

    def as_dict(self) -> dict[str, Any]:
        """Return what ``results.json`` holds of it."""
        metrics = (*ERRORS, "drag_energy_paper")
        return {
            "label": self.label,
            "verdict": self.verdict and self.verdict.value,
            "explained": self.explained,
            "ratio_of_position_errors": self.ratio_of_position_errors,
            "objections": self.objections,
            **{
                name: {metric: self.spread(name, metric)._asdict() for metric in metrics}
                for name in CASES
            },
        }


def error_claims() -> Iterator[paper.PaperClaim]:
    """Return the paper's six mean errors."""
    return (claim for claim in paper.claims().values() if claim.about.get("metric") in ERRORS)


def count_hypotheses(plan: Plan) -> int:
    """Return how many flights `fly_hypotheses` hands out."""
    return len(_changes()) * len(CASES) * len(plan.seeds)


def fly_hypotheses(plan: Plan, fly_jobs: FlyJobs) -> list[Hypothesis]:
    """Fly the paper's three flights under every hypothesis, over all the seeds."""
    scenarios = {name: load_scenario(name) for name in CASES}
    changed = {
        (change.label, name): change.apply(scenarios[name])
        for change in _changes()
        for name in CASES
    }
    purpose = "hypotheses on the sizes of the errors"
    flown = fly_over_seeds(changed, plan.seeds, fly_jobs, purpose)
    return [
        Hypothesis(
            label=change.label,
            verdict=change.verdict,
            against=change.against,
            flown={name: flown[change.label, name] for name in CASES},
        )
        for change in _changes()
    ]


def _changes() -> tuple[_Change, ...]:
    """Return what is flown, what is stated first and what is fitted last."""
    printed = load_scenario(A).gains.axes("position")[0]
    both = MOMENTUM_AND_WAKES
    in_robustness = "the paper speaks of interference only in its part on robustness"
    other_gain = f"{in_robustness}; it prints a position gain of {printed:g}"
    no_rates = "reference without velocity and acceleration feed-forward"
    return (
        _Change("as stated, no rotor momentum", None, _without_momentum),
        _Change(WITH_MOMENTUM, None, lambda one: one),
        _Change(
            "interference, no rotor momentum",
            Verdict.CONJECTURED,
            lambda one: _in_wakes(_without_momentum(one)),
            in_robustness,
        ),
        _Change(both, Verdict.CONJECTURED, _in_wakes, in_robustness),
        _Change(
            f"{no_rates}, no rotor momentum",
            Verdict.CONJECTURED,
            lambda one: pose_only(_without_momentum(one)),
            "the paper's controller uses both; its vehicle has rotor momentum",
        ),
        _Change(no_rates, Verdict.CONJECTURED, pose_only, "the paper's controller uses both"),
        _Change(
            f"{both}, position gain {GAIN_WITHOUT_A_ZERO:g}",
            Verdict.CONJECTURED,
            lambda one: _with_gain(_in_wakes(one), GAIN_WITHOUT_A_ZERO),
            other_gain,
        ),
        _Change(
            f"{both}, position gain {FITTED_GAIN:g}",
            Verdict.CALIBRATED,
            lambda one: _with_gain(_in_wakes(one), FITTED_GAIN),
            f"{other_gain}; the gain was fitted",
        ),
    )


def _without_momentum(scenario: Scenario) -> Scenario:
    return replace(scenario, plant=load_plant("realistic-1"))


def _in_wakes(scenario: Scenario) -> Scenario:
    return with_effects(scenario, Interference())


def _with_gain(scenario: Scenario, position: float) -> Scenario:
    return replace(scenario, gains=replace(scenario.gains, position=position))
