"""Fly many scenarios, on all cores, keeping each flight as it finishes.

The core lets go of the interpreter while it flies, so threads share the cores; what a flight gives
does not depend on which thread flies it, or beside what.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from typing import NamedTuple

from omnimorph.errors import OmnimorphError, ScenarioError, TooLargeError
from omnimorph.machine.memory import available_bytes
from omnimorph.results.run import Run
from omnimorph.simulation.fly import fly
from omnimorph.simulation.recording import bytes_of_flights
from omnimorph.simulation.scenario import Scenario
from omnimorph.studies.flight_log import FlightLog, FlightResult, flight_keys

_PATIENCE = 0.2  # s between two looks at whether the user wants to stop


class Job(NamedTuple):
    """One flight to be flown: what, and with which noise."""

    scenario: Scenario
    seed: int


def fly_jobs(
    jobs: Sequence[Job], log: FlightLog, next_step: Callable[[], None] = lambda: None
) -> list[FlightResult]:
    """Fly what is not in the log yet; return what came of each job, in their order.

    Parameters
    ----------
    jobs : sequence of Job
        The same flight may stand there more than once; it is flown once.
    log : FlightLog
        Where finished flights are kept.
    next_step : callable
        Called once for each job that is done, from this thread.

    Notes
    -----
    A flight that is refused is an answer (`FlightResult.failure`), not the end, unless it is memory
    that lacks: as many are in the air as there are cores, or as memory holds. A Ctrl-C waits for
    the flights that are in the air, a few hundredths of a second each, and keeps them.
    """
    keys = flight_keys([job.scenario for job in jobs], [job.seed for job in jobs])
    todo = {key: job for key, job in zip(keys, jobs, strict=True) if log.get(key) is None}
    for _ in range(len(jobs) - len(todo)):
        next_step()
    pool = ThreadPoolExecutor(_at_once(jobs))
    try:
        waiting = {pool.submit(_fly, key, job, log) for key, job in todo.items()}
        while waiting:
            done, waiting = wait(waiting, _PATIENCE, FIRST_COMPLETED)
            _tell(done, next_step)
    finally:
        pool.shutdown(cancel_futures=True)
    return [_kept(log, key) for key in keys]


def fly_runs(jobs: Sequence[Job]) -> list[Run]:
    """Fly jobs whose traces are needed; they are not kept in a log."""
    with ThreadPoolExecutor(_at_once(jobs)) as pool:
        return list(pool.map(lambda job: fly(job.scenario, seed=job.seed), jobs))


def _at_once(jobs: Sequence[Job]) -> int:
    """Return how many flights are in the air: one on each core, or as many as memory holds."""
    largest = 1
    for scenario in {id(job.scenario): job.scenario for job in jobs}.values():
        with suppress(ScenarioError):  # it cannot be flown, as the answer to it will tell
            largest = max(largest, bytes_of_flights(scenario, 1))
    return max(min(os.cpu_count() or 1, available_bytes() // largest), 1)


def _fly(key: str, job: Job, log: FlightLog) -> None:
    try:
        flown = FlightResult(fly(job.scenario, seed=job.seed).metrics)
    except TooLargeError:  # on this machine, now
        raise
    except OmnimorphError as refused:
        flown = FlightResult(None, str(refused))
    log.add(key, flown)


def _tell(done: set[Future[None]], next_step: Callable[[], None]) -> None:
    for future in done:
        future.result()  # what went wrong with the log is raised here
        next_step()


def _kept(log: FlightLog, key: str) -> FlightResult:
    flown = log.get(key)
    assert flown is not None
    return flown
