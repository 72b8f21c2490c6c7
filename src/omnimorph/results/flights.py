"""`Flights`: what is left of many flights of one scenario."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from omnimorph.protocols import FloatArray
from omnimorph.results.many_metrics import ManyMetrics
from omnimorph.results.run import Run

Precision = Literal["float64", "float32"]


@dataclass(frozen=True, kw_only=True)
class BatchPerformance:
    """How fast a batch was flown; depends on the machine, so it is kept apart.

    Attributes
    ----------
    wall_time : float, s
        From the first step to the last, setting up left out.
    vehicle_steps : int
        Physics steps of all flights together.
    threads, lanes : int
        Threads, and vehicles that each of them flew at once.
    instruction_set : str
        Such as ``x86-64-v3``.
    """

    wall_time: float
    vehicle_steps: int
    threads: int
    lanes: int
    instruction_set: str

    @property
    def vehicle_steps_per_s(self) -> float:
        """Physics steps of one vehicle in a second."""
        return self.vehicle_steps / max(self.wall_time, 1e-9)


@dataclass(frozen=True, eq=False, kw_only=True)
class Flights:
    """Many flights of one scenario: metrics of all, traces of those asked for.

    Row k of every array belongs to flight ``number[k]``; flights that an interrupt cut off are not
    among them.

    Attributes
    ----------
    number : (n,) array of int
        Which flights: flight j of a seed is the same wherever and beside whatever it is flown.
    metrics : ManyMetrics
        Each metric as an (n,) array.
    varied : mapping of str to array
        The numbers in which the flights differ, (n,) or (n, width) each, by their names.
    runs : mapping of int to Run
        The flights that were kept, by number.
    scenario_name : str
        What was flown.
    seed : int
        Of the noise and of `varied`.
    precision : "float64" or "float32"
        In which the flights were computed.
    interrupted : bool
        Whether flights are missing.
    performance : BatchPerformance
        How fast.
    """

    number: NDArray[np.int64]
    metrics: ManyMetrics
    varied: Mapping[str, FloatArray]
    runs: Mapping[int, Run]
    scenario_name: str
    seed: int
    precision: Precision
    interrupted: bool
    performance: BatchPerformance

    def __len__(self) -> int:
        return len(self.number)

    @property
    def completed(self) -> NDArray[np.bool_]:
        """Whether each flight was completed, (n,)."""
        return np.array([outcome == "completed" for outcome in self.metrics.outcome], dtype=bool)

    def __repr__(self) -> str:
        counted = Counter(self.metrics.outcome)
        outcomes = ", ".join(f"{count} {outcome}" for outcome, count in counted.most_common())
        cut = ", interrupted" if self.interrupted else ""
        return f"Flights({self.scenario_name!r}, {outcomes or 'none'}, {self.precision}{cut})"
