"""How a metric is declared: once, where `Metrics` lists it.

::

    speed_max_Hz: float = metric(
        "Largest |w| of any rotor.",
        Measure("fastest rotor", 1.0, "Hz"),
        lambda sums: sums.flown(sums.speed_max) / TURN,
    )

It is made of sums over the rows of a flight, which the core adds up under the names that they have
here (``core/include/omnimorph/flight/sums``): while it flies a batch, or from the columns of a run.
"""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Callable
from typing import Any, NamedTuple

from omnimorph.protocols import FloatArray
from omnimorph.results.sums import FlightSums


class Measure(NamedTuple):
    """how a metric is shown: its label, the factor from the metric to the unit, and that unit."""

    label: str
    factor: float
    unit: str


@dataclasses.dataclass(frozen=True, kw_only=True)
class Metric:
    """One metric, as it was declared."""

    name: str = ""  # the attribute of `Metrics` and key of ``metrics.json``, with its unit
    meaning: str  # what it is, in sentences
    shown: Measure  # how people read it
    of_sums: Callable[[FlightSums], FloatArray]  # its (n,) values for n flights
    is_count: bool  # whether it is a whole number


def metric(
    meaning: str,
    shown: Measure,
    of_sums: Callable[[FlightSums], FloatArray],
    *,
    is_count: bool = False,
) -> Any:
    """Declare a metric: see `Metric` for what the arguments say of it."""
    declared = Metric(meaning=meaning, shown=shown, of_sums=of_sums, is_count=is_count)
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
