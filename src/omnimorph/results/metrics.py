"""`Metrics`: the numbers one flight is judged by, with their definitions.

Files and people read them, so the names carry units; they are the keys of ``metrics.json``.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.results.atomic import write_text
from omnimorph.results.metric import Measure, Metric, described, metric, metrics_of
from omnimorph.results.record import RunRecord
from omnimorph.results.sums import FlightSums, sums_of_run

_TURN = 2.0 * math.pi
_DEGREE = math.degrees(1.0)


def _drag_energy(sums: FlightSums) -> FloatArray:
    return sums.physics_step * sums.flown(sums.drag_power)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Metrics:
    """The numbers of one flight.

    Means are over the rows of the run, every physics step counted alike. A flight that ended with
    numbers that are not finite is measured up to the row before the first of them. What each metric
    is stands in its declaration below, from which its documentation follows.

    Attributes
    ----------
    outcome : str
        Name of the `Outcome`, in lower case.
    """

    position_error_mean_m: float = metric(
        "Mean of ‖p − p_d‖.",
        Measure("position error, mean", 1e3, "mm"),
        lambda sums: sums.distance / sums.rows,
    )
    position_error_rms_m: float = metric(
        "Root mean square of ‖p − p_d‖.",
        Measure("position error, root mean square", 1e3, "mm"),
        lambda sums: np.sqrt(sums.distance_squared / sums.rows),
    )
    position_error_max_m: float = metric(
        "Largest ‖p − p_d‖.",
        Measure("position error, largest", 1e3, "mm"),
        lambda sums: sums.flown(sums.distance_max),
    )
    attitude_error_mean_rad: float = metric(
        "Mean of the geodesic angle θ between R and R_d, from tan θ = ‖e_R‖ / ((tr(Rᵀ R_d) − 1)/2):"
        " exact from 0 to π.",
        Measure("attitude error, mean angle", _DEGREE, "°"),
        lambda sums: sums.angle / sums.rows,
    )
    attitude_error_rms_rad: float = metric(
        "Root mean square of θ.",
        Measure("attitude error, root mean square angle", _DEGREE, "°"),
        lambda sums: np.sqrt(sums.angle_squared / sums.rows),
    )
    attitude_error_max_rad: float = metric(
        "Largest θ.",
        Measure("attitude error, largest angle", _DEGREE, "°"),
        lambda sums: sums.flown(sums.angle_max),
    )
    attitude_error_paper: float = metric(
        "Mean of ‖e_R‖ = sin θ, e_R = ½ (Rᵀ R_d − R_dᵀ R)^∨, which the paper calls attitude error.",
        Measure("attitude error, mean ‖e_R‖ (the paper's)", 1.0, "–"),
        lambda sums: sums.sine / sums.rows,
    )
    drag_energy_J: float = metric(
        "Σ h Σ_i c_tau |w_i|³ over rows 1 … K−1 (the speed at the end of each step acted over it): "
        "the rotor drag energy; w is the actual speed.",
        Measure("rotor drag energy", 1.0, "J"),
        _drag_energy,
    )
    drag_energy_paper: float = metric(
        "The same with w in Hz and the torque per Hz², as the paper counts: `drag_energy_J` / 2π.",
        Measure("rotor drag energy, the paper's count", 1.0, "“J”"),
        lambda sums: _drag_energy(sums) / _TURN,
    )
    acceleration_energy_J: float = metric(
        "Σ max(0, ½ I (w_{k+1}² − w_k²)) over steps and rotors: what it took to speed the rotors "
        "up, by the controller's vehicle; nothing is won back when they slow down.",
        Measure("energy to accelerate the rotors", 1.0, "J"),
        lambda sums: sums.flown(sums.kinetic_energy_gained),
    )
    acceleration_energy_paper: float = metric(
        "The same with w in Hz: `acceleration_energy_J` / 4π².",
        Measure("energy to accelerate the rotors, the paper's count", 1.0, "“J”"),
        lambda sums: sums.flown(sums.kinetic_energy_gained) / _TURN**2,
    )
    tilt_mean_deg: float = metric(
        "Mean of the actual tilt, over time and servos; not a number for a vehicle without servos.",
        Measure("tilt, mean", 1.0, "°"),
        lambda sums: np.rad2deg(sums.tilt / sums.tilts),
    )
    tilt_max_deg: float = metric(
        "Largest actual tilt, likewise.",
        Measure("tilt, largest", 1.0, "°"),
        lambda sums: np.rad2deg(sums.tilt_max) + 0.0 * sums.tilts,
    )
    tilt_min_deg: float = metric(
        "Smallest actual tilt, likewise.",
        Measure("tilt, smallest", 1.0, "°"),
        lambda sums: np.rad2deg(sums.tilt_min) + 0.0 * sums.tilts,
    )
    saturated_share: float = metric(
        "Share of the rows in which at least one rotor was commanded to a limit of its thrust, "
        "0 … 1.",
        Measure("share of time with a rotor at its limit", 100.0, "%"),
        lambda sums: sums.saturated_rows / sums.rows,
    )
    speed_max_Hz: float = metric(
        "Largest |w| of any rotor.",
        Measure("fastest rotor", 1.0, "Hz"),
        lambda sums: sums.flown(sums.speed_max / _TURN),
    )
    power_mean_W: float = metric(
        "`drag_energy_J` / `duration_s`; not a number if nothing was flown.",
        Measure("rotor drag power, mean", 1.0, "W"),
        lambda sums: np.where(sums.duration > 0, _drag_energy(sums) / sums.duration, np.nan),
    )
    kkt_residual_max: float = metric(
        "Largest KKT residual of the allocation; not a number if the allocator gives none.",
        Measure("largest KKT residual of the allocation", 1.0, "–"),
        lambda sums: sums.flown(sums.kkt_residual_max),
    )
    unproven_steps: float = metric(
        "How many control steps the core's allocation did not prove: their KKT residual is larger "
        "than 1e-9, or 1e-4 in single precision. Not a number if the allocator gives none.",
        Measure("control steps whose allocation is not proven", 1.0, "–"),
        lambda sums: np.where(sums.has_no_residual, np.nan, sums.unproven_steps),
        is_count=True,
    )
    position_error_last_second_m: float = metric(
        "Mean of ‖p − p_d‖ over the last second; not a number if the flight ended before.",
        Measure("position error over the last second", 1e3, "mm"),
        lambda sums: sums.last_distance / sums.last_rows,
    )
    attitude_error_last_second_rad: float = metric(
        "Mean of θ over the last second, likewise.",
        Measure("attitude error over the last second", _DEGREE, "°"),
        lambda sums: sums.last_angle / sums.last_rows,
    )
    duration_s: float = metric(
        "Time flown.", Measure("time flown", 1.0, "s"), lambda sums: sums.duration
    )
    outcome: str

    def as_dict(self) -> dict[str, float | str | None]:
        """Return the metrics by name, as JSON knows them: None where there is no finite number."""
        return {
            key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in vars(self).items()
        }

    def write_json(self, path: str | Path) -> None:
        """Write ``metrics.json``, as a whole or not at all; null where there is no finite number.

        Raises
        ------
        RunFileError
            If the file cannot be written.
        """
        write_text(path, json.dumps(self.as_dict(), indent=2) + "\n")


METRICS: tuple[Metric, ...] = metrics_of(Metrics)
"""Every metric but the outcome, in the order in which files and people read them."""
MEASURES: Mapping[str, Measure] = {one.name: one.shown for one in METRICS}
"""What people call each metric, and the unit they read it in: for screens and reports."""

if Metrics.__doc__ is not None:  # as under python -OO
    Metrics.__doc__ = Metrics.__doc__.rstrip() + "\n" + "".join(map(described, METRICS))


def values_of(sums: FlightSums) -> dict[str, Any]:
    """Return every metric of n flights by its name, an (n,) array each, from their sums."""
    values = {}
    with np.errstate(all="ignore"):  # a flight without a finite row has no mean
        for one in METRICS:
            value: FloatArray = one.of_sums(sums)
            is_whole = one.is_count and bool(np.isfinite(value).all())
            values[one.name] = value.astype(np.int64) if is_whole else value
    return values


def metrics_of_row(values: Mapping[str, Any], row: int, outcome: str) -> Metrics:
    """Return the metrics of one flight of many: equal to themselves even where they are NaN."""
    numbers = {name: column[row].item() for name, column in values.items()}
    return Metrics(
        **{name: math.nan if number != number else number for name, number in numbers.items()},
        outcome=outcome,
    )


def metrics_from_run(run: RunRecord) -> Metrics:
    """Compute the metrics of a run.

    Examples
    --------
    Eight rotors of OmniMorph at 131.54 Hz, as in hover at 60° tilt, spend 8 c_tau w³ = 315.09 W, or
    50.148 as the paper counts.
    """
    sums = {name: np.array([value]) for name, value in sums_of_run(run).items()}
    step, n_servos = run.provenance.physics_step, run.vehicle.n_servos
    values = values_of(FlightSums(sums, [run.outcome], step, n_servos))
    return metrics_of_row(values, 0, run.outcome.name.lower())
