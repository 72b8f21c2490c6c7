"""All measurements, one after the other; those that are compared take turns."""

from __future__ import annotations

import time
from collections.abc import Callable

from omnimorph.bench.analysis import time_analysis, time_radii
from omnimorph.bench.batches import time_batches
from omnimorph.bench.flights import (
    time_control_steps,
    time_joint_steps,
    time_loops,
    time_python_loop,
)
from omnimorph.bench.measurement import BenchReport
from omnimorph.bench.processes import (
    cost_of_analysis_page,
    cost_of_flight,
    cost_of_help,
    cost_of_import,
)
from omnimorph.bench.provenance import provenance_of_machine
from omnimorph.bench.rows import Round, rows_of

Progress = Callable[[int, int], None]


def measure(progress: Progress | None = None, *, rounds: int = 7) -> BenchReport:
    """Measure everything on this machine; about half a minute.

    Parameters
    ----------
    progress : callable, optional
        Called after each round with the number done and the number of all.
    rounds : int
        How often each number is measured.

    Returns
    -------
    BenchReport
        Every number with its spread and target, and what it depends on.

    Raises
    ------
    RuntimeError
        If a process that is timed fails.
    """
    provenance = provenance_of_machine()
    began = time.perf_counter()
    time_loops()
    warm_up = time.perf_counter() - began
    time_radii(seed=0, turns=1)  # loads what they all need
    done: list[Round] = []
    for _ in range(rounds):
        done.append(
            Round(
                time_loops(),
                time_batches(),
                time_control_steps(),
                time_joint_steps(),
                time_python_loop(),
                time_radii(seed=len(done)),
                time_analysis(),
                cost_of_flight(),
                cost_of_analysis_page(),
                cost_of_import(),
                cost_of_help(),
            )
        )
        if progress is not None:
            progress(len(done), rounds)
    return BenchReport(measurements=rows_of(done, warm_up), provenance=provenance)
