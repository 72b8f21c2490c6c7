"""A number over the seeds: its mean with an interval, its range, and how many flights gave none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from omnimorph.studies.flight_log import FlightResult


class Spread(NamedTuple):
    """One metric over the seeds of one flight; not numbers if none was completed."""

    mean: float
    low: float
    high: float
    half_width: float  # of Student's 95 % interval of the mean; not a number for a single flight
    flights: int
    completed: int  # how many of them were flown to the end


def spread_of(flown: Sequence[FlightResult], metric: str, factor: float = 1.0) -> Spread:
    """Return a metric over flights, times a factor."""
    values = factor * np.array(
        [getattr(one.metrics, metric) for one in flown if one.completed], dtype=np.float64
    )
    k = len(values)
    if k == 0:
        return Spread(math.nan, math.nan, math.nan, math.nan, len(flown), 0)
    half_width = math.nan
    if k > 1:
        from scipy.stats import t

        half_width = float(t.ppf(0.975, k - 1) * values.std(ddof=1) / math.sqrt(k))
    mean, low, high = float(values.mean()), float(values.min()), float(values.max())
    return Spread(mean, low, high, half_width, len(flown), k)


def share_interval(successes: int, trials: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share.

    Examples
    --------
    >>> [round(end, 3) for end in share_interval(10, 10)]
    [0.722, 1.0]
    """
    z = 1.959963984540054
    share, n = successes / trials, trials
    middle = (share + z * z / (2 * n)) / (1 + z * z / n)
    reach = z * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    return max(middle - reach, 0.0), min(middle + reach, 1.0)
