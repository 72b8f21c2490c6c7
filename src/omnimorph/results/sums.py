"""Sums over the rows of flights, of which their metrics are made."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from omnimorph.protocols import FloatArray

if TYPE_CHECKING:
    from omnimorph.results.run import Run

__all__ = ["LAST_SECOND", "PROOF", "PROOF_IN_SINGLE_PRECISION", "FlightSums", "MeasuredRows"]

PROOF, PROOF_IN_SINGLE_PRECISION = 1e-9, 1e-4
"""An allocation whose KKT residual is not larger proves itself."""
LAST_SECOND = 1.0
"""Over which the end of a flight is judged, s."""

_BLOCK = 2048  # rows worked on at once: small enough to stay in the cache


class FlightSums:
    """Sums over the rows of each of n flights: each an (n,) array, an attribute by its name.

    Parameters
    ----------
    sums : mapping of str to (n,) array
        By name; among them ``rows`` and ``last_rows``, how many rows count, in all and of the last
        second.
    completed : (n,) array of bool
        Whether the flight was completed.
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
    """

    def __init__(
        self,
        sums: Mapping[str, FloatArray],
        completed: NDArray[np.bool_],
        physics_step: float,
        n_servos: int,
    ) -> None:
        self._sums = sums
        self.physics_step = physics_step
        self.rows = np.where(sums["rows"] > 0, sums["rows"], np.nan)
        self.tilts = self.rows * (n_servos or np.nan)
        self.last_rows = np.where(completed, sums["last_rows"], np.nan)
        self.duration = np.where(sums["rows"] > 0, physics_step * (sums["rows"] - 1), 0.0)

    def __getattr__(self, name: str) -> FloatArray:
        if name.startswith("_") or name not in self._sums:
            raise AttributeError(f"nothing adds up {name}; there are {', '.join(self._sums)}")
        return self._sums[name]

    def flown(self, values: FloatArray) -> FloatArray:
        """Return values as they are, but NaN for a flight without a row that counts."""
        return values + 0.0 * self.rows


class _Errors(NamedTuple):
    """Distance (m), angle (rad) and its sine between motion and wish, each (K,)."""

    distance: FloatArray
    angle: FloatArray
    sine: FloatArray


class MeasuredRows:
    """The rows of a run that are measured: those before the first that is not finite.

    Parameters
    ----------
    run : Run

    Attributes
    ----------
    count : int
        How many there are.
    last : slice
        Those of the last second, of a flight that came to its end; none otherwise.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.count = _finite_rows(run)
        left = run.provenance.physics_step * np.arange(self.count - 1, -1, -1)
        in_last_second = int(np.count_nonzero(left < LAST_SECOND))
        whole = run.outcome.name == "COMPLETED" and self.count == len(run.time)
        self.last = slice(self.count - in_last_second if whole else self.count, self.count)

    def column(self, name: str) -> NDArray[Any]:
        """Return the measured rows of a column of the run."""
        values: NDArray[Any] = getattr(self.run, name)[: self.count]
        return values

    @property
    def distance(self) -> FloatArray:
        """‖p − p_d‖, (K,) m."""
        return self._errors.distance

    @property
    def angle(self) -> FloatArray:
        """The geodesic angle between R and R_d, (K,) rad."""
        return self._errors.angle

    @property
    def sine(self) -> FloatArray:
        """‖e_R‖, its sine, (K,)."""
        return self._errors.sine

    @cached_property
    def _errors(self) -> _Errors:
        run = self.run
        distance, angle, sine = np.empty((3, self.count))
        for block in self._blocks():
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
        return _Errors(distance, angle, sine)

    def kinetic_energy_gained(self) -> float:
        """Return Σ max(0, ½ I (w_{k+1}² − w_k²)) over steps and rotors, J."""
        gained = 0.0
        for block in self._blocks():
            # With the row before the block in front, each step belongs to exactly one block.
            speed = np.abs(self.run.speed[max(block.start - 1, 0) : block.stop])
            square = speed * speed
            gain = np.maximum(square[1:] - square[:-1], 0.0)
            gained += float(np.sum(gain @ self.run.vehicle.spin_inertia))
        return 0.5 * gained

    def unproven_steps(self) -> float:
        """Return how many control steps were not proven; NaN where nothing was decided."""
        run = self.run
        flown = run.provenance
        every = max(round(min(flown.control_period / flown.physics_step, len(run.time))), 1)
        decided = self.count - 1 if run.outcome.name == "COMPLETED" else self.count
        single = '"precision": "float32"' in flown.scenario_text
        proof = PROOF_IN_SINGLE_PRECISION if single else PROOF
        residual = run.kkt_residual[:decided:every]
        failed = run.outcome.name == "NOT_FINITE"  # the last decision, if it was one
        if len(residual) > failed and np.isnan(residual).all():
            return np.nan
        return float(np.count_nonzero(residual > proof))

    def _blocks(self) -> list[slice]:
        starts = range(0, self.count, _BLOCK)
        return [slice(start, min(start + _BLOCK, self.count)) for start in starts]


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
