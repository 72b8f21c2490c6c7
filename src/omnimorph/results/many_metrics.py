"""`ManyMetrics`: the numbers of `Metrics` for many flights at once, made of sums of their rows."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.results.metrics import Metrics
from omnimorph.results.run import Outcome

__all__ = ["FlightSums", "ManyMetrics", "metrics_from_sums"]

_TURN = 2.0 * math.pi
_NAMES = tuple(field.name for field in dataclasses.fields(Metrics) if field.name != "outcome")


class FlightSums(NamedTuple):
    """Sums over the rows of each of n flights, (n,) each, in the order of the core's record.

    Over all finite rows: how many, ‖p − p_d‖ (m), its square and maximum, the angle between R and
    R_d (rad) likewise, ‖e_R‖, drag power (W, without the first row), kinetic energy that the rotors
    gained (J), tilt (rad, over servos too) with its extremes, rows with a thrust at a limit, the
    largest speed (rad/s) and KKT residual, control steps that were not proven; of the last second:
    rows, ‖p − p_d‖ and the angle.
    """

    rows: FloatArray
    distance: FloatArray
    distance_squared: FloatArray
    distance_max: FloatArray
    angle: FloatArray
    angle_squared: FloatArray
    angle_max: FloatArray
    sine: FloatArray
    drag_power: FloatArray
    energy_gained: FloatArray
    tilt: FloatArray
    tilt_min: FloatArray
    tilt_max: FloatArray
    saturated_rows: FloatArray
    speed_max: FloatArray
    kkt_residual_max: FloatArray
    unproven_steps: FloatArray
    last_rows: FloatArray
    last_distance: FloatArray
    last_angle: FloatArray


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
        numbers = {name: column[row].item() for name, column in self._columns.items()}
        return Metrics(**numbers, outcome=self.outcome[row])

    def as_dict(self) -> dict[str, Any]:
        """Return all columns by name, as pandas, polars and pyarrow take them."""
        return dict(self._columns) | {"outcome": list(self.outcome)}


def metrics_from_sums(
    sums: FlightSums, outcomes: Sequence[Outcome], *, physics_step: float, n_servos: int
) -> ManyMetrics:
    """Compute the metrics of many flights from the sums over their rows.

    Parameters
    ----------
    sums : FlightSums
        Of n flights.
    outcomes : sequence of Outcome
        One for each.
    physics_step : float, s
        Between two rows.
    n_servos : int
        Over which the tilts are summed.
    """
    completed = np.array([outcome is Outcome.COMPLETED for outcome in outcomes])
    with np.errstate(all="ignore"):  # a flight without a finite row has no mean
        rows = np.where(sums.rows > 0, sums.rows, np.nan)
        duration = np.where(sums.rows > 0, physics_step * (sums.rows - 1), 0.0)
        last_rows = np.where(completed, sums.last_rows, np.nan)
        drag = physics_step * sums.drag_power + 0.0 * rows
        spin_up = sums.energy_gained + 0.0 * rows
        tilts = rows * n_servos if n_servos else np.full(len(rows), np.nan)
        columns = {
            "position_error_mean_m": sums.distance / rows,
            "position_error_rms_m": np.sqrt(sums.distance_squared / rows),
            "position_error_max_m": sums.distance_max + 0.0 * rows,
            "attitude_error_mean_rad": sums.angle / rows,
            "attitude_error_rms_rad": np.sqrt(sums.angle_squared / rows),
            "attitude_error_max_rad": sums.angle_max + 0.0 * rows,
            "attitude_error_paper": sums.sine / rows,
            "drag_energy_J": drag,
            "drag_energy_paper": drag / _TURN,
            "acceleration_energy_J": spin_up,
            "acceleration_energy_paper": spin_up / _TURN**2,
            "tilt_mean_deg": np.rad2deg(sums.tilt / tilts),
            "tilt_max_deg": np.rad2deg(sums.tilt_max) + 0.0 * tilts,
            "tilt_min_deg": np.rad2deg(sums.tilt_min) + 0.0 * tilts,
            "saturated_share": sums.saturated_rows / rows,
            "speed_max_Hz": sums.speed_max / _TURN + 0.0 * rows,
            "power_mean_W": np.where(duration > 0, drag / duration, np.nan),
            "kkt_residual_max": sums.kkt_residual_max + 0.0 * rows,
            "unproven_steps": sums.unproven_steps.astype(np.int64),
            "position_error_last_second_m": sums.last_distance / last_rows,
            "attitude_error_last_second_rad": sums.last_angle / last_rows,
            "duration_s": duration,
        }
    return ManyMetrics(columns, outcomes)
