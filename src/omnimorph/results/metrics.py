"""`Metrics`: the numbers one flight is judged by, with their definitions.

Files and people read them, so the names carry units; they are the keys of ``metrics.json``.
"""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.results.atomic import write_text

if TYPE_CHECKING:
    from omnimorph.results.run import Run

__all__ = ["Metrics", "metrics_from_run"]

PROOF, PROOF_IN_SINGLE_PRECISION = 1e-9, 1e-4
"""An allocation whose KKT residual is not larger proves itself."""
LAST_SECOND = 1.0
"""Over which the end of a flight is judged, s."""

_TURN = 2.0 * math.pi
_BLOCK = 2048  # rows worked on at once: small enough to stay in the cache


@dataclasses.dataclass(frozen=True, kw_only=True)
class Metrics:
    """The numbers of one flight.

    Means are over the rows of the run, every physics step counted alike. A flight that ended with
    numbers that are not finite is measured up to the row before the first of them.

    Attributes
    ----------
    position_error_mean_m, position_error_rms_m, position_error_max_m : float
        Mean, root mean square and maximum of ‖p − p_d‖.
    attitude_error_mean_rad, attitude_error_rms_rad, attitude_error_max_rad : float
        Mean, root mean square and maximum of the geodesic angle θ between R and R_d, from
        tan θ = ‖e_R‖ / ((tr(Rᵀ R_d) − 1)/2): exact from 0 to π.
    attitude_error_paper : float
        Mean of ‖e_R‖ = sin θ, e_R = ½ (Rᵀ R_d − R_dᵀ R)^∨, which the paper calls attitude error.
    drag_energy_J : float
        Σ h Σ_i c_tau |w_i|³ over rows 1 … K−1 (the speed at the end of each step acted over it):
        the rotor drag energy; w is the actual speed.
    drag_energy_paper : float
        The same with w in Hz and the torque per Hz², as the paper counts: `drag_energy_J` / 2π.
    acceleration_energy_J : float
        Σ max(0, ½ I (w_{k+1}² − w_k²)) over steps and rotors: what it took to speed the rotors up;
        nothing is won back when they slow down.
    acceleration_energy_paper : float
        The same with w in Hz: `acceleration_energy_J` / 4π².
    tilt_mean_deg, tilt_max_deg, tilt_min_deg : float
        Of the actual tilt, over time and servos; not a number for a vehicle without servos.
    saturated_share : float
        Share of the rows in which at least one rotor was commanded to a limit of its thrust, 0 … 1.
    speed_max_Hz : float
        Largest |w| of any rotor.
    power_mean_W : float
        `drag_energy_J` / `duration_s`; not a number if nothing was flown.
    kkt_residual_max : float
        Largest KKT residual of the allocation; not a number if the allocator gives none.
    unproven_steps : int
        How many control steps the core's allocation did not prove: their KKT residual is larger
        than 1e-9, or 1e-4 in single precision. Not a number if the allocator gives none.
    position_error_last_second_m, attitude_error_last_second_rad : float
        Mean of ‖p − p_d‖ and of θ over the last second; not a number if the flight ended before.
    duration_s : float
        Time flown.
    outcome : str
        Name of the `Outcome`, in lower case.
    """

    position_error_mean_m: float
    position_error_rms_m: float
    position_error_max_m: float
    attitude_error_mean_rad: float
    attitude_error_rms_rad: float
    attitude_error_max_rad: float
    attitude_error_paper: float
    drag_energy_J: float
    drag_energy_paper: float
    acceleration_energy_J: float
    acceleration_energy_paper: float
    tilt_mean_deg: float
    tilt_max_deg: float
    tilt_min_deg: float
    saturated_share: float
    speed_max_Hz: float
    power_mean_W: float
    kkt_residual_max: float
    unproven_steps: float
    position_error_last_second_m: float
    attitude_error_last_second_rad: float
    duration_s: float
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


def metrics_from_run(run: Run) -> Metrics:
    """Compute the metrics of a run.

    Parameters
    ----------
    run : Run

    Returns
    -------
    Metrics

    Examples
    --------
    Eight rotors of OmniMorph at 131.54 Hz, as in hover at 60° tilt, spend 8 c_tau w³ = 315.09 W, or
    50.148 as the paper counts.
    """
    # A flight that diverged may hold numbers whose squares are too large: they become infinite.
    with np.errstate(over="ignore", invalid="ignore"):
        rows = _finite_rows(run)
        return _measured(run, rows) if rows else _nothing(run)


def _measured(run: Run, rows: int) -> Metrics:
    distance, angle, sine = _errors(run, rows)
    drag, spin_up, speed_max = _rotor_energies(run, rows)
    tilt = np.rad2deg(run.tilt_actual[:rows])
    tilts = (tilt.mean(), tilt.max(), tilt.min()) if tilt.size else 3 * (math.nan,)
    duration = float(run.time[rows - 1] - run.time[0])
    return Metrics(
        position_error_mean_m=float(distance.mean()),
        position_error_rms_m=float(np.sqrt(np.mean(distance**2))),
        position_error_max_m=float(distance.max()),
        attitude_error_mean_rad=float(angle.mean()),
        attitude_error_rms_rad=float(np.sqrt(np.mean(angle**2))),
        attitude_error_max_rad=float(angle.max()),
        attitude_error_paper=float(sine.mean()),
        drag_energy_J=drag,
        drag_energy_paper=drag / _TURN,
        acceleration_energy_J=spin_up,
        acceleration_energy_paper=spin_up / _TURN**2,
        tilt_mean_deg=float(tilts[0]),
        tilt_max_deg=float(tilts[1]),
        tilt_min_deg=float(tilts[2]),
        saturated_share=float(run.active[:rows].any(axis=1).mean()),
        speed_max_Hz=speed_max / _TURN,
        power_mean_W=drag / duration if duration > 0 else math.nan,
        kkt_residual_max=float(run.kkt_residual[:rows].max()),
        unproven_steps=_unproven_steps(run, rows),
        position_error_last_second_m=_mean_of_last_second(run, distance),
        attitude_error_last_second_rad=_mean_of_last_second(run, angle),
        duration_s=duration,
        outcome=run.outcome.name.lower(),
    )


def _errors(run: Run, rows: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return distance (m), angle (rad) and its sine between motion and wish, each (K,)."""
    distance, angle, sine = np.empty((3, rows))
    for block in _blocks(rows):
        offset = run.p_WB[block] - run.desired_p_WB[block]
        distance[block] = np.sqrt(np.einsum("ki,ki->k", offset, offset))
        # With time as the last axis every sum runs over neighbours in memory.
        R, R_d = (
            np.ascontiguousarray(np.moveaxis(attitude[block], 0, -1))
            for attitude in (run.R_WB, run.desired_R_WB)
        )
        E = np.einsum("ijk,ilk->jlk", R, R_d)  # Rᵀ R_d
        x, y, z = E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]
        sine[block] = 0.5 * np.sqrt(x * x + y * y + z * z)
        cosine = 0.5 * (E[0, 0] + E[1, 1] + E[2, 2] - 1.0)
        angle[block] = np.arctan2(sine[block], cosine)
    return distance, angle, sine


def _mean_of_last_second(run: Run, values: FloatArray) -> float:
    """Return the mean over the last second of a flight that came to its end."""
    if run.outcome.name != "COMPLETED" or len(values) < len(run.time):
        return math.nan
    left = run.provenance.physics_step * np.arange(len(values) - 1, -1, -1)
    return float(values[left < LAST_SECOND].mean())


def _unproven_steps(run: Run, rows: int) -> float:
    """Return how many control steps were not proven; where nothing was decided there is none."""
    flown = run.provenance
    every = max(round(min(flown.control_period / flown.physics_step, len(run.time))), 1)
    decided = rows - 1 if run.outcome.name == "COMPLETED" else rows
    single = '"precision": "float32"' in flown.scenario_text
    proof = PROOF_IN_SINGLE_PRECISION if single else PROOF
    residual = run.kkt_residual[:decided:every]
    failed = run.outcome.name == "NOT_FINITE"  # the last decision, if it was one
    if len(residual) > failed and np.isnan(residual).all():
        return math.nan
    return int(np.count_nonzero(residual > proof))


def _rotor_energies(run: Run, rows: int) -> tuple[float, float, float]:
    """Return drag energy (J), acceleration energy (J) and the largest speed (rad/s)."""
    drag = float(run.drag_power[1:rows].sum())
    spin_up, speed_max = 0.0, 0.0
    for block in _blocks(rows):
        # With the row before the block in front, each step belongs to exactly one block.
        speed = np.abs(run.speed[max(block.start - 1, 0) : block.stop])
        square = speed * speed
        gain = np.maximum(square[1:] - square[:-1], 0.0)
        spin_up += float(np.sum(gain @ run.vehicle.spin_inertia))
        speed_max = max(speed_max, float(speed.max()))
    return run.provenance.physics_step * drag, 0.5 * spin_up, speed_max


def _finite_rows(run: Run) -> int:
    """Return how many rows there are before the first with a number that is not finite."""
    rows = len(run.time)
    for column in (
        run.p_WB,
        run.R_WB,
        run.desired_p_WB,
        run.desired_R_WB,
        run.speed,
        run.tilt_actual,
    ):
        # A sum is finite only if all its terms are: the usual case needs no array of answers.
        if np.isfinite(column[:rows].sum()):
            continue
        finite = np.all(np.isfinite(column[:rows].reshape(rows, -1)), axis=1)
        rows = rows if finite.all() else int(np.argmin(finite))
    return rows


def _blocks(rows: int) -> list[slice]:
    return [slice(start, min(start + _BLOCK, rows)) for start in range(0, rows, _BLOCK)]


def _nothing(run: Run) -> Metrics:
    """Return the metrics of a run without one finite row."""
    names = [field.name for field in dataclasses.fields(Metrics)]
    values = dict.fromkeys(names, math.nan)
    values |= {"duration_s": 0.0, "unproven_steps": 0}
    return Metrics(**values | {"outcome": run.outcome.name.lower()})  # type: ignore[arg-type]
