"""Distributions, and the numbers that each flight of a batch draws from them.

Each flight draws its own numbers from (seed, name of the parameter, number of the flight) alone, so
that it is the same however many fly beside it.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.arrays import as_numbers
from omnimorph.errors import ScenarioError
from omnimorph.protocols import FloatArray


class Distribution(Protocol):
    """Anything with the inverse of a distribution function, such as those of ``scipy.stats``."""

    def ppf(self, q: FloatArray) -> ArrayLike:
        """Return the values below which the shares q, in (0, 1), of all numbers are."""
        ...


@dataclass(frozen=True)
class Uniform(Distribution):
    """Every number from `low` to `high` alike.

    Examples
    --------
    >>> Uniform(0.9, 1.1).ppf(np.array([0.25])).tolist()
    [0.9500000000000001]
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        limits = as_numbers((self.low, self.high))
        if limits.shape != (2,) or not np.isfinite(limits).all() or limits[0] > limits[1]:
            raise ScenarioError.at("Uniform", "limits", (self.low, self.high), "finite, in order")

    def ppf(self, q: FloatArray) -> FloatArray:
        """Return the value at each share q."""
        return self.low + q * (self.high - self.low)


@dataclass(frozen=True)
class Normal(Distribution):
    """The normal distribution.

    Examples
    --------
    >>> Normal(1.0, 0.1).ppf(np.array([0.5])).tolist()
    [1.0]
    """

    mean: float
    deviation: float

    def __post_init__(self) -> None:
        numbers = as_numbers((self.mean, self.deviation))
        if numbers.shape != (2,) or not np.isfinite(numbers).all() or numbers[1] < 0.0:
            allowed = "a finite mean and a deviation that is not negative"
            raise ScenarioError.at("Normal", "numbers", (self.mean, self.deviation), allowed)

    def ppf(self, q: FloatArray) -> FloatArray:
        """Return the value at each share q."""
        from scipy.special import ndtri

        return np.asarray(self.mean + self.deviation * ndtri(q))


def numbers_drawn(
    name: str,
    wanted: Distribution | ArrayLike,
    seed: int,
    first: int,
    shape: tuple[int, ...],
    one_for_all: bool = False,
) -> FloatArray:
    """Return the numbers of a parameter for flights first … first + n − 1, drawn or as they stand.

    Their shape is n, then that of one flight's numbers; with `one_for_all` an array may hold a
    single number for each flight as well.

    Raises
    ------
    ScenarioError
        If what is wanted is neither a distribution nor an array of this shape.
    """
    ppf = getattr(wanted, "ppf", None)
    try:
        found = wanted if ppf is None else ppf(_shares(name, seed, first, shape))
    except (TypeError, ValueError, OverflowError):  # no distribution
        found = None
    values = as_numbers(found).copy()
    n, of_a_flight = shape[0], shape[1:]
    if values.shape == shape or (one_for_all and values.shape == (n,) and ppf is None):
        return values
    what = "a distribution (om.Uniform, om.Normal, scipy.stats)"
    rows = f"{n} numbers" if not of_a_flight else f"{n} rows of {of_a_flight[0]} numbers"
    if len(of_a_flight) > 1:
        rows = f"{n} arrays of shape {of_a_flight}"
    given = f"of shape {values.shape}" if values.ndim else wanted
    raise ScenarioError.at("vary", name, given, f"{what} or an array of {rows}")


def _shares(name: str, seed: int, first: int, shape: tuple[int, ...]) -> FloatArray:
    """Return numbers in (0, 1), each flight's own."""
    width = math.prod(shape[1:])
    bits = np.random.Philox(key=[seed, zlib.crc32(name.encode())])
    skipped = first * width  # one number each, four of them to a count of the generator
    bits.advance(skipped // 4)
    generator = np.random.Generator(bits)
    numbers = generator.random(skipped % 4 + math.prod(shape))[skipped % 4 :]
    return np.maximum(numbers, 2.0**-54).reshape(shape)
