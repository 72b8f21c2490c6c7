"""How a metric is declared: once, where `Metrics` lists it.

::

    speed_max_Hz: float = metric(
        "Largest |w| of any rotor.",
        Measure("fastest rotor", 1.0, "Hz"),
        lambda sums: sums.flown(sums.speed_max) / TURN,
        speed_max=lambda rows: np.abs(rows.column("speed")).max(),
    )

It is made of sums over the rows of a flight. The core adds up those of batches while it flies them,
each under the name it has here (``core/include/omnimorph/flight/sums``); for a run they are added
up from its columns, as the keywords say. What follows from the sums is said once for both.
"""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from omnimorph.protocols import FloatArray
from omnimorph.results.sums import FlightSums, MeasuredRows

__all__ = ["Measure", "Metric", "described", "metric", "metrics_of"]


class Measure(NamedTuple):
    """How a metric is shown: its words, the factor from the metric to the unit, and that unit."""

    words: str
    factor: float
    unit: str


@dataclasses.dataclass(frozen=True, kw_only=True)
class Metric:
    """One metric, as it was declared.

    Attributes
    ----------
    name : str
        The attribute of `Metrics` and the key of ``metrics.json``, with its unit.
    meaning : str
        What it is, in sentences.
    shown : Measure
        How people read it.
    of_sums : callable
        From the `FlightSums` of n flights to its (n,) values.
    sums : mapping of str to callable
        What it adds up, if no other metric does, by the names of the core: from the `MeasuredRows`
        of a run to the sum.
    is_count : bool
        Whether it is a whole number.
    """

    name: str = ""
    meaning: str
    shown: Measure
    of_sums: Callable[[FlightSums], FloatArray]
    sums: Mapping[str, Callable[[MeasuredRows], Any]]
    is_count: bool


def metric(
    meaning: str,
    shown: Measure,
    of_sums: Callable[[FlightSums], FloatArray],
    *,
    is_count: bool = False,
    **sums: Callable[[MeasuredRows], Any],
) -> Any:
    """Declare a metric: see `Metric` for what the arguments say of it."""
    declared = Metric(meaning=meaning, shown=shown, of_sums=of_sums, sums=sums, is_count=is_count)
    return dataclasses.field(metadata={"metric": declared})


def metrics_of(metrics: Any) -> tuple[Metric, ...]:
    """Return the declared metrics of a class, in their order."""
    return tuple(
        dataclasses.replace(field.metadata["metric"], name=field.name)
        for field in dataclasses.fields(metrics)
        if "metric" in field.metadata
    )


def described(metric: Metric) -> str:
    """Return the entry of a metric in the documentation of the attributes."""
    indent = 8 * " "
    said = textwrap.fill(metric.meaning, 100, initial_indent=indent, subsequent_indent=indent)
    return f"    {metric.name} : float\n{said}\n"
