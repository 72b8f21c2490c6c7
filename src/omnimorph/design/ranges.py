"""Ranges: how small and how large a number may be, and how a message states it.

Every number of a file has one, generous to anything that can be built: what lies beyond is a slip
of the pen or of a unit, and would end in numbers that cannot be computed with.
"""

from __future__ import annotations

from numbers import Real
from typing import Any, NamedTuple

from omnimorph.units import UNITS


class Range(NamedTuple):
    """From the least to the largest number that is allowed, in whatever unit they are stated.

    Attributes
    ----------
    least, most : float
        Both are allowed.
    or_zero : bool
        Whether 0 is allowed too, below the least.

    Examples
    --------
    >>> str(Range(1e-6, 1e6)), str(Range(1e-3, 10.0, or_zero=True)), 0.0 in Range(-1.0, 1.0)
    ('from 1e-6 to 1e6', '0 or from 0.001 to 10', True)
    """

    least: float
    most: float
    or_zero: bool = False

    def __contains__(self, number: object) -> bool:
        """Return whether a number is allowed; nothing else is, nor what is not finite."""
        if isinstance(number, bool) or not isinstance(number, Real):
            return False
        value: Any = number
        return self.least <= value <= self.most or (self.or_zero and value == 0)

    def __str__(self) -> str:
        ends = f"from {_written(self.least)} to {_written(self.most)}"
        return f"0 or {ends}" if self.or_zero else ends

    def in_SI(self, unit: str) -> Range:
        """Return the same range for numbers in SI, if this one is for numbers in `unit`."""
        factor = UNITS[unit]
        return Range(self.least * factor, self.most * factor, self.or_zero)


def _written(number: float) -> str:
    """Write a number as people do: 1e6, not 1e+06."""
    mantissa, e, exponent = f"{number:g}".partition("e")
    return f"{mantissa}e{int(exponent)}" if e else mantissa


UNIT_VECTOR = Range(-1.01, 1.01)
"""Of the parts of a vector within 1 % of unit length."""
