"""Arrays as users hand them over."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def as_numbers(value: object) -> NDArray[np.float64]:
    """Return a value as an array of float64 in C order; a single NaN if it is none of numbers.

    So who checks for shape and finite numbers refuses in one sentence what is no number at all.

    Examples
    --------
    >>> as_numbers([1, 2]).tolist(), as_numbers("a"), as_numbers([[1], [1, 2]])
    ([1.0, 2.0], array(nan), array(nan))
    """
    try:
        array = np.asarray(value)
        if array.dtype.kind in "biufO":  # "1.5" is a text, though NumPy would read it
            return np.asarray(array, dtype=np.float64, order="C")
    except Exception:  # rows of different lengths, 10**400, whatever an object's __array__ raises
        pass
    return np.array(math.nan)


def real_array(value: object) -> NDArray[np.float64]:
    """Return numbers as an array of float64 in C order, of one dimension at least.

    Raises
    ------
    ValueError
        If they are none, such as texts and complex numbers, of which NumPy would make some.
    """
    array = np.asarray(value)
    if value is None or array.dtype.kind not in "biufO":
        raise ValueError(f"a {type(value).__name__} of {array.dtype} is not made of real numbers")
    return np.ascontiguousarray(array, dtype=np.float64)
