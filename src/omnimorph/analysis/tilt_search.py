"""Where a function of the tilt is lowest, and where it is not negative.

The functions here (singular values, inscribed radii) are continuous with kinks, so nothing is asked
of their derivatives: samples half a degree apart, then a search between them. What happens in less
than that may be missed.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from omnimorph.protocols import FloatArray

_STEP = math.radians(0.5)
_Curve = Callable[[float], float]


def lowest_points(curve: _Curve, low: float, high: float) -> list[float]:
    """Return where a curve has its local minima, the ends of the range included, in order.

    To about 1e-10 rad for a minimum of the form |α − α0|, which is what a root of a singular value
    looks like; to 1e-8 for a smooth one.
    """
    tilts, values = _sampled(curve, low, high)
    left = np.r_[np.inf, values[:-1]]
    right = np.r_[values[1:], np.inf]
    found = []
    for k in np.flatnonzero((values <= left) & (values < right)).tolist():
        begin, end = tilts[max(k - 1, 0)], tilts[min(k + 1, len(tilts) - 1)]
        found.append(_lowest_between(curve, float(begin), float(end)))
    return found


def highest_point(curve: _Curve, low: float, high: float) -> float:
    """Return where a curve is highest, the ends included; of equal peaks the one nearest to 0."""
    found = lowest_points(lambda tilt: -curve(tilt), low, high)
    heights = [curve(tilt) for tilt in found]
    level = max(heights) - 1e-9 * abs(max(heights))
    peaks = [tilt for tilt, height in zip(found, heights, strict=True) if height >= level]
    return min(peaks, key=lambda tilt: (round(abs(tilt), 6), -tilt))


def intervals_above_zero(curve: _Curve, low: float, high: float) -> FloatArray:
    """Return the intervals in which a curve is not negative: (K, 2) array, their ends to 1e-12.

    Ends are roots, or the ends of the range. A peak or a dip that crosses zero between two samples
    is found too, as long as it is the only one there.
    """
    from scipy.optimize import brentq

    tilts, values = _sampled(curve, low, high)
    inserted = []
    for sign in (1.0, -1.0):  # dips below zero between samples above it, then the other way round
        left, right = sign * values[:-2], sign * values[2:]
        middle = sign * values[1:-1]
        for k in 1 + np.flatnonzero((middle >= 0.0) & (middle <= left) & (middle < right)):
            extreme = _lowest_between(
                lambda tilt, s=sign: s * curve(tilt),  # type: ignore[misc]
                float(tilts[k - 1]),
                float(tilts[k + 1]),
            )
            inserted.append((extreme, curve(extreme)))
    tilts = np.r_[tilts, [tilt for tilt, _ in inserted]]
    values = np.r_[values, [value for _, value in inserted]]
    order = np.argsort(tilts, kind="stable")
    tilts, inside = tilts[order], values[order] >= 0.0
    ends = [float(tilts[0])] if inside[0] else []
    for k in np.flatnonzero(inside[1:] != inside[:-1]):
        ends.append(float(brentq(curve, tilts[k], tilts[k + 1], xtol=1e-13)))
    if inside[-1]:
        ends.append(float(tilts[-1]))
    return np.array(ends).reshape(-1, 2)


def _sampled(curve: _Curve, low: float, high: float) -> tuple[FloatArray, FloatArray]:
    count = max(math.ceil((high - low) / _STEP), 1) + 1 if high > low else 1
    tilts = np.linspace(low, high, count)
    return tilts, np.array([curve(float(tilt)) for tilt in tilts])


def _lowest_between(curve: _Curve, begin: float, end: float) -> float:
    from scipy.optimize import minimize_scalar

    if begin == end:
        return begin
    found = minimize_scalar(
        curve, bounds=(begin, end), method="bounded", options={"xatol": 1e-12, "maxiter": 200}
    )
    best = float(found.x)
    for reach in (1e-4, 1e-6, 1e-8):
        # where the two sides of |α − α0| meet; for any other shape it changes nothing that counts
        left, right = max(best - reach, begin), min(best + reach, end)
        heights = curve(left), curve(right)
        if sum(heights) > 0.0 and min(heights) >= 0.0:
            meeting = (left * heights[1] + right * heights[0]) / sum(heights)
            best = min(best, meeting, key=curve)
    return min(best, begin, end, key=curve)
