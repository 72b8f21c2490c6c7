"""Sums over the rows of flights, of which their metrics are made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from omnimorph import _core
from omnimorph.model.core import as_core
from omnimorph.protocols import FloatArray
from omnimorph.results.record import COLUMNS, Outcome, RunRecord

LAST_SECOND = _core.LAST_SECOND
"""Over which the end of a flight is judged, s."""


class FlightSums:
    """Sums over the rows of each of n flights: each an (n,) array, an attribute by its name.

    Parameters
    ----------
    sums : mapping of str to (n,) array
        By name; among them ``rows`` and ``last_rows``, how many rows count, in all and of the last
        second.
    outcomes : sequence of Outcome
        How each flight ended.
    physics_step : float, s
        Between two rows.
    n_servos : int
        Over which tilts are summed.

    Attributes
    ----------
    rows, last_rows : (n,) array
        How many rows count, in all and of the last second; NaN where there is none, so that
        whatever is divided by them is. Only a completed flight has a last second.
    tilts : (n,) array
        How many tilts are summed: rows times servos; NaN if there is none.
    duration : (n,) array, s
        Time flown.
    has_no_residual : (n,) array of bool
        Whether a controller decided, other than to end the flight, and gave no KKT residual.
    """

    def __init__(
        self,
        sums: Mapping[str, FloatArray],
        outcomes: Sequence[Outcome],
        physics_step: float,
        n_servos: int,
    ) -> None:
        self._sums = sums
        self.physics_step = physics_step
        self.rows = np.where(sums["rows"] > 0, sums["rows"], np.nan)
        self.tilts = self.rows * (n_servos or np.nan)
        completed = np.array([outcome is Outcome.COMPLETED for outcome in outcomes], dtype=bool)
        self.last_rows = np.where(completed, sums["last_rows"], np.nan)
        failed = np.array([outcome is Outcome.NOT_FINITE for outcome in outcomes], dtype=bool)
        decided = sums["control_steps"] > failed  # a last decision that failed has no residual
        self.has_no_residual = decided & (sums["steps_with_residual"] == 0)
        self.duration = np.where(sums["rows"] > 0, physics_step * (sums["rows"] - 1), 0.0)

    def __getattr__(self, name: str) -> FloatArray:
        if name.startswith("_") or name not in self._sums:
            raise AttributeError(f"nothing adds up {name}; there are {', '.join(self._sums)}")
        return self._sums[name]

    def flown(self, values: FloatArray) -> FloatArray:
        """Return values as they are, but NaN for a flight without a row that counts."""
        return values + 0.0 * self.rows


def sums_of_run(run: RunRecord) -> dict[str, float]:
    """Return what the core adds up over the rows of a run, before the first that is not finite."""
    flown = run.provenance
    every = max(round(min(flown.control_period / flown.physics_step, len(run.time))), 1)
    return _core.sums_of_run(
        model=as_core(run.vehicle),
        columns={one.name: np.ascontiguousarray(run[one.name]) for one in COLUMNS},
        drag_power=np.ascontiguousarray(run.drag_power),
        is_completed=run.outcome is Outcome.COMPLETED,
        physics_step=flown.physics_step,
        control_every=every,
        single_precision='"precision": "float32"' in flown.scenario_text,
    )
