"""`ManyMetrics`: the numbers of `Metrics` for many flights at once, made of sums of their rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from omnimorph.protocols import FloatArray
from omnimorph.results.metrics import METRICS, Metrics, metrics_of_row, values_of
from omnimorph.results.record import Outcome
from omnimorph.results.sums import FlightSums

_NAMES = tuple(metric.name for metric in METRICS)


class ManyMetrics:
    """The metrics of n flights: each attribute of `Metrics` as an (n,) array.

    Parameters
    ----------
    columns : mapping of str to (n,) array
        Every number of `Metrics` by its name.
    outcomes : sequence of Outcome
        How each flight ended.

    Examples
    --------
    >>> import omnimorph as om
    >>> flights = om.fly_many(om.load_scenario("hover"), 3)
    >>> flights.metrics.duration_s.tolist(), flights.metrics[2].outcome
    ([5.0, 5.0, 5.0], 'completed')
    """

    def __init__(self, columns: Mapping[str, FloatArray], outcomes: Sequence[Outcome]) -> None:
        self._columns = {name: columns[name] for name in _NAMES}
        for column in self._columns.values():
            column.flags.writeable = False
        self.outcome = tuple(outcome.name.lower() for outcome in outcomes)

    def __len__(self) -> int:
        return len(self.outcome)

    def __getattr__(self, name: str) -> FloatArray:
        if name in _NAMES:
            return self._columns[name]
        raise AttributeError(f"ManyMetrics has no {name}; it has {', '.join(_NAMES)} and outcome")

    def __dir__(self) -> list[str]:
        return [*_NAMES, "outcome", "as_dict"]

    def __getitem__(self, row: int) -> Metrics:
        """Return the metrics of the flight in one row."""
        return metrics_of_row(self._columns, row, self.outcome[row])

    def as_dict(self) -> dict[str, Any]:
        """Return all columns by name, as pandas, polars and pyarrow take them."""
        return dict(self._columns) | {"outcome": list(self.outcome)}


def metrics_from_sums(
    sums: Mapping[str, FloatArray],
    outcomes: Sequence[Outcome],
    *,
    physics_step: float,
    n_servos: int,
) -> ManyMetrics:
    """Compute the metrics of many flights from the sums over their rows: see `FlightSums`."""
    return ManyMetrics(values_of(FlightSums(sums, outcomes, physics_step, n_servos)), outcomes)
