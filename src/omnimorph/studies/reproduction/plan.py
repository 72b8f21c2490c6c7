"""How much is flown: the whole reproduction, or a quick one with fewer seeds."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import NamedTuple, Self, TypeVar

from omnimorph.results.run import Run
from omnimorph.simulation.scenario import Scenario
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.many_flights import Job, fly_runs

FlyJobs = Callable[[Sequence[Job], str], list[FlightResult]]
"""Flies jobs and returns what came of them, in their order; the text says what they are for."""
Name = TypeVar("Name", bound=Hashable)


class Plan(NamedTuple):
    """How many flights each question gets."""

    seeds: range  # of each of the paper's flights; the figures show the first
    repeats: int  # seeds of each plant of the ablation, and of each way to choose the tilt
    loss_seeds: int  # at each loss of thrust
    loss_rounds: int  # halvings of the interval in which the limit lies
    quick: bool  # whether this is the quick one

    @classmethod
    def whole(cls, first_seed: int = 0, seeds: int = 20) -> Self:
        """Return the plan of the whole reproduction."""
        return cls(range(first_seed, first_seed + seeds), 5, 10, 7, quick=False)

    @classmethod
    def quickly(cls, first_seed: int = 0, seeds: int = 2) -> Self:
        """Return a plan that answers the same questions with fewer seeds."""
        return cls(range(first_seed, first_seed + seeds), 1, 1, 4, quick=True)

    def first_seeds(self, count: int) -> range:
        """Return so many seeds, from the first on."""
        return range(self.seeds[0], self.seeds[0] + count)


def fly_over_seeds(
    scenarios: Mapping[Name, Scenario], seeds: Sequence[int], fly_jobs: FlyJobs, purpose: str
) -> dict[Name, list[FlightResult]]:
    """Fly each scenario with every seed; return what came of it, one result a seed, by its name."""
    jobs = [Job(scenario, seed) for scenario in scenarios.values() for seed in seeds]
    flown = iter(fly_jobs(jobs, purpose))
    return {name: [next(flown) for _ in seeds] for name in scenarios}


def runs_of(scenarios: Mapping[Name, Scenario], seed: int) -> dict[Name, Run]:
    """Fly each scenario with one seed; return its run, for the figures, by its name."""
    runs = fly_runs([Job(scenario, seed) for scenario in scenarios.values()])
    return dict(zip(scenarios, runs, strict=True))
