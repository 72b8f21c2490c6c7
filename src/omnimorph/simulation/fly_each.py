"""Fly a scenario many times where parts of its loop are one's own: each flight by itself."""

from __future__ import annotations

import copy
from collections.abc import Callable, Collection
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from omnimorph.errors import ScenarioError
from omnimorph.results.flights import BatchPerformance, Flights
from omnimorph.results.many_metrics import ManyMetrics
from omnimorph.results.metrics import METRICS, Metrics
from omnimorph.results.run import Outcome, Run
from omnimorph.simulation.instruction_sets import INSTRUCTION_SET
from omnimorph.simulation.loop import SteppedFlight
from omnimorph.simulation.own_parts import PythonObject
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.variation import VARIABLE, Variation

__all__ = ["fly_each"]


_OF_PARTS = {
    "controller": ("controller.",),
    "allocator": ("controller.allocator.",),
    "plant": ("truth.", "plant.physics_step", "plant.control_period"),
}
"""What of a scenario is not flown where an object stands in; one that is named is built of it."""


@dataclass(frozen=True)
class _Flown:
    """What is kept of a flight: its run only if it was asked for."""

    metrics: Metrics
    outcome: Outcome
    rows: int
    run: Run | None


def fly_each(
    scenario: Scenario,
    variation: Variation,
    *,
    seed: int,
    first: int,
    kept: Collection[int],
    threads: int,
    progress: Callable[[int, int], None] | None,
) -> Flights:
    """Fly each flight of a variation by itself, each with a copy of the parts that are one's own.

    A Ctrl-C returns the flights that are finished.

    Raises
    ------
    ScenarioError
        If flights differ in what only the core's batches can vary, if a part cannot be copied or
        fails in its very first step.
    """
    for name in variation.drawn:
        if name in VARIABLE:
            allowed = "a path such as truth.mass, as parts of the loop are written in Python"
            raise ScenarioError.at("fly_many", "vary", name, allowed)
        for kind, part in scenario.own.given().items():
            if name.startswith(_OF_PARTS.get(kind, ())) and not isinstance(part, PythonObject):
                allowed = f"a number that is flown; the {kind} is an object that does not read it"
                raise ScenarioError.at("fly_many", "vary", name, allowed)
    numbers = range(first, first + variation.flights)
    began, interrupted = perf_counter(), False
    flown: dict[int, _Flown] = {}

    def fly(number: int) -> _Flown:
        mine = _with_copies(variation.scenario_of(number - first))
        flight = SteppedFlight(mine, seed=seed, flight=number)
        if variation.drawn:
            flight.notes["vary"] = variation.of_flight(number - first)
        flight.fly()
        run = flight.as_run()
        return _Flown(run.metrics, run.outcome, len(run.time), run if number in kept else None)

    pool = ThreadPoolExecutor(min(threads, variation.flights))
    try:
        under_way: dict[Future[_Flown], int] = {pool.submit(fly, one): one for one in numbers}
        for done in as_completed(under_way):
            flown[under_way[done]] = done.result()
            if progress is not None:
                progress(len(flown), variation.flights)
    except KeyboardInterrupt:
        interrupted = True
    finally:
        pool.shutdown(cancel_futures=True)
    return _as_flights(scenario, variation, flown, seed, first, interrupted, threads, began)


def _with_copies(scenario: Scenario) -> Scenario:
    """Return a scenario with copies of what may remember something."""
    try:
        own, reference = copy.deepcopy((scenario.own, scenario.reference))
    except ScenarioError:
        raise
    except Exception as error:
        why = f"{type(error).__name__}: {error}"
        raise ScenarioError(
            f"the reference cannot be copied for another flight, because {why}."
        ) from error
    return replace(scenario, own=own, reference=reference)


def _as_flights(
    scenario: Scenario,
    variation: Variation,
    flown: dict[int, _Flown],
    seed: int,
    first: int,
    interrupted: bool,
    threads: int,
    began: float,
) -> Flights:
    finished = sorted(flown)
    rows = np.array(finished, dtype=np.int64) - first
    columns: dict[str, Any] = {
        one.name: np.array([getattr(flown[number].metrics, one.name) for number in finished])
        for one in METRICS
    }
    runs = {number: run for number in finished if (run := flown[number].run) is not None}
    return Flights(
        number=first + rows,
        metrics=ManyMetrics(columns, [flown[number].outcome for number in finished]),
        varied={name: values[rows] for name, values in variation.drawn.items()},
        runs=runs,
        scenario_name=scenario.name,
        seed=seed,
        precision="float64",
        interrupted=interrupted,
        performance=BatchPerformance(
            wall_time=perf_counter() - began,
            vehicle_steps=sum(one.rows - 1 for one in flown.values()),
            threads=min(threads, variation.flights),
            lanes=1,
            instruction_set=INSTRUCTION_SET,
        ),
    )
