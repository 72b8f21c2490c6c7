"""Curves thinned to what the eye can see, with every spike kept.

Curves are evenly spaced in time, and thinned to so many columns of pixels, at least one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from omnimorph.protocols import FloatArray


class Band(NamedTuple):
    """A noisy curve in columns of equal length: (columns,) arrays."""

    time: FloatArray  # s, the middle of each column
    low: FloatArray  # the smallest value within it
    mean: FloatArray
    high: FloatArray


def thin(time: FloatArray, values: FloatArray, columns: int) -> tuple[FloatArray, FloatArray]:
    """Keep the smallest and the largest value of each column, and both ends of the curve, (K,).

    Drawn with lines between the points, the result looks like the whole curve as long as there are
    at least as many columns as pixels.

    Examples
    --------
    >>> spike = np.zeros(45001)
    >>> spike[31415] = 1.0
    >>> t, v = thin(np.arange(45001) * 1e-3, spike, 100)
    >>> len(t) <= 202, float(v.max()), float(t[v.argmax()])
    (True, 1.0, 31.415)
    """
    rows = len(values)
    if rows <= 2 * columns + 2:
        return time, values
    blocks, starts = _blocks(values, columns)
    last = rows - 1
    kept = np.concatenate(
        [[0, last], starts + blocks.argmin(axis=1), starts + blocks.argmax(axis=1)]
    )
    kept = np.unique(np.minimum(kept, last))
    return time[kept], values[kept]


def envelope(time: FloatArray, values: FloatArray, columns: int) -> tuple[FloatArray, FloatArray]:
    """Return several curves, (S, K), thinned to the same times, the extremes of each kept.

    Each column becomes two points: at its beginning the smallest value within it, in its middle the
    largest. Drawn with lines, that covers what the whole curves would cover. Curves of no more
    points than that are returned as they are.

    Examples
    --------
    >>> t, v = envelope(np.arange(6.0), np.array([[0.0, 5.0, 1.0, 2.0, 9.0, 3.0]]), 2)
    >>> t.tolist(), v.tolist()
    ([0.0, 1.0, 3.0, 4.0], [[0.0, 5.0, 2.0, 9.0]])
    """
    if len(time) <= 2 * columns:
        return time, values
    blocks = np.array([_blocks(curve, columns)[0] for curve in values])
    times, _ = _blocks(time, columns)
    low_high = np.stack([blocks.min(axis=2), blocks.max(axis=2)], axis=2)
    at = times[:, [0, times.shape[1] // 2]]
    return at.ravel(), low_high.reshape(len(values), -1)


def band(time: FloatArray, values: FloatArray, columns: int) -> Band:
    """Return the smallest value, the mean and the largest value of each column of a curve, (K,).

    There are no more columns than rows.

    Examples
    --------
    >>> shown = band(np.arange(4.0), np.array([1.0, 3.0, -2.0, 0.0]), 2)
    >>> shown.low.tolist(), shown.mean.tolist(), shown.high.tolist()
    ([1.0, -2.0], [2.0, -1.0], [3.0, 0.0])
    """
    columns = min(columns, len(values))
    blocks, _ = _blocks(values, columns)
    middle = _blocks(time, columns)[0].mean(axis=1)
    return Band(middle, blocks.min(axis=1), blocks.mean(axis=1), blocks.max(axis=1))


def _blocks(values: FloatArray, columns: int) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return the values in rows of equal length, the last value repeated, and where each begins."""
    length = -(-len(values) // columns)
    count = -(-len(values) // length)
    padded: FloatArray = np.pad(values, (0, count * length - len(values)), mode="edge")
    return padded.reshape(count, length), length * np.arange(count, dtype=np.int64)
