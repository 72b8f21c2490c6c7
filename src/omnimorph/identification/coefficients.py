"""One coefficient of a rotor: the c in y = c w|w|, from noisy measurements of w and y.

1. A first c that few wrong rows do not move: the one of least Σ|y − c w|w||, which is a weighted
   median of y/w|w|.
2. Outliers: rows whose residual is beyond 5 robust standard deviations, 1.4826 times the median
   size of the residuals, over all rows or over the 31 of the most similar speed, whichever is
   larger. Of Gaussian noise that is one row in two million.
3. Least squares over the others. The interval allows for noise that is not the same at all speeds:
   each residual stands for its own row's variance (the sandwich of White, with each residual over
   1 − leverage, known as HC3), and Student's t.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from omnimorph.protocols import FloatArray

_BEYOND = 5.0
_NEIGHBOURS = 31
_OF_GAUSSIAN = 1.4826  # standard deviation over median absolute deviation
_ROUNDING = 1e-9


class Estimate(NamedTuple):
    """A number with its 95 % confidence interval.

    Attributes
    ----------
    value, low, high : float
        In the unit of the number; the interval is `low` to `high`.
    """

    value: float
    low: float
    high: float

    def holds(self, value: float) -> bool:
        """Return whether a value lies within the interval."""
        return self.low <= value <= self.high


@dataclass(frozen=True, eq=False, kw_only=True)
class CoefficientFit:
    """A coefficient fitted to the rows of one run.

    Attributes
    ----------
    both : Estimate
        From all rows.
    forward, reverse : Estimate or None
        From the rows of one sense of rotation; None if there are too few.
    separate : bool
        Whether the two differ more than chance explains (99 %).
    residual : (K,) array
        Measured less fitted, of every row; the fit is that of its own side if they are separate.
    outlier : (K,) array of bool
        Rows left out.
    noise : float
        Standard deviation of the residuals of the rows kept.
    """

    both: Estimate
    forward: Estimate | None
    reverse: Estimate | None
    separate: bool
    residual: FloatArray
    outlier: NDArray[np.bool_]
    noise: float

    @property
    def value(self) -> Estimate:
        """What a vehicle file is given: forward if the sides are separate, else both."""
        return self.forward if self.separate and self.forward is not None else self.both


def fit_coefficient(
    square: FloatArray, measured: FloatArray, sides: tuple[NDArray[np.bool_], ...]
) -> CoefficientFit:
    """Fit ``measured = c · square``: force (N) or torque (N m) to w|w| (rad²/s²), (K,) arrays.

    The sides, forward and reverse, say which rows turn which way; one without a row is not fitted.
    """
    moving = sides[0] | sides[1]
    outlier = np.zeros(len(square), dtype=bool)
    for side in (*sides, ~moving):  # each by its own line: they may differ
        outlier[side] = _outliers(square[side], measured[side])
    kept = ~outlier
    both = _estimate(square[kept], measured[kept])
    ways = [
        _estimate(square[side & kept], measured[side & kept]) if (side & kept).any() else None
        for side in sides
    ]
    forward, reverse = ways
    separate = forward is not None and reverse is not None and differ(forward, reverse)
    coefficient = np.full(len(square), both.value)
    if separate and forward is not None and reverse is not None:
        coefficient = np.where(square >= 0.0, forward.value, reverse.value)
    residual = measured - coefficient * square
    noise = float(np.sqrt(np.mean(residual[kept] ** 2)))
    return CoefficientFit(
        both=both,
        forward=forward,
        reverse=reverse,
        separate=separate,
        residual=residual,
        outlier=outlier,
        noise=noise,
    )


def differ(first: Estimate, second: Estimate) -> bool:
    """Return whether two estimates differ more than chance explains, at 99 %."""
    halves = [0.5 * (one.high - one.low) for one in (first, second)]
    return abs(first.value - second.value) > (2.576 / 1.960) * math.hypot(*halves)


def spread_of(residual: FloatArray) -> float:
    """Return the standard deviation of residuals, of which few may be wrong."""
    return _OF_GAUSSIAN * float(np.median(np.abs(residual))) if residual.size else 0.0


def _outliers(square: FloatArray, measured: FloatArray) -> NDArray[np.bool_]:
    """Return which rows are too far from the line that most of them are on."""
    if not square.size:
        return np.zeros(0, dtype=bool)
    residual = measured - _median_slope(square, measured) * square
    order = np.argsort(np.abs(square), kind="stable")
    windows = np.abs(residual)[order]
    if len(windows) > _NEIGHBOURS:
        half = _NEIGHBOURS // 2
        padded = np.pad(windows, half, mode="reflect")
        windows = np.median(np.lib.stride_tricks.sliding_window_view(padded, _NEIGHBOURS), axis=1)
    else:
        windows = np.full(len(windows), np.median(windows))
    local = np.empty(len(windows))
    local[order] = _OF_GAUSSIAN * windows
    limit = _BEYOND * np.maximum(local, spread_of(residual))
    far: NDArray[np.bool_] = np.abs(residual) > limit + _ROUNDING * np.abs(measured).max()
    return far


def _median_slope(square: FloatArray, measured: FloatArray) -> float:
    """Return the c of least Σ|measured − c square|: the median of the ratios, weighted."""
    weighty = square != 0.0
    if not weighty.any():
        return 0.0
    ratio, weight = measured[weighty] / square[weighty], np.abs(square[weighty])
    order = np.argsort(ratio)
    total = np.cumsum(weight[order])
    return float(ratio[order][np.searchsorted(total, 0.5 * total[-1])])


def _estimate(square: FloatArray, measured: FloatArray) -> Estimate:
    """Return the least-squares slope through the origin and its interval."""
    from scipy.special import stdtrit

    size = float(square @ square)
    slope = float(square @ measured) / size
    leverage = square**2 / size
    residual = (measured - slope * square) / np.maximum(1.0 - leverage, _ROUNDING)
    error = math.sqrt(float((square**2) @ residual**2)) / size
    half = float(stdtrit(max(int((square != 0.0).sum()) - 1, 1), 0.975)) * error
    return Estimate(slope, slope - half, slope + half)
