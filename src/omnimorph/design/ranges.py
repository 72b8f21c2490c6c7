"""Ranges: how small and how large a number may be, and how a message states it.

Every number of a file has one, generous to anything that can be built: what lies beyond is a slip
of the pen or of a unit, and would end in numbers that cannot be computed with.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from numbers import Real
from typing import Any, NamedTuple

from omnimorph.design.keys import FILE_KEYS, FILTER_KEYS
from omnimorph.units import UNITS, unit_of

__all__ = ["OF_VEHICLES", "UNIT_VECTOR", "Range", "limits_in_SI", "numbers_in"]


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


def numbers_in(value: Any) -> Iterator[float]:
    """Yield the numbers of a value that is one, or rows of them; none of None."""
    if isinstance(value, list | tuple):
        for item in value:
            yield from numbers_in(item)
    elif value is not None:
        yield value


def limits_in_SI(attribute: str) -> Range | None:
    """Return the range, in SI, of an attribute of a vehicle; None if it has none of its own.

    Examples
    --------
    >>> limits_in_SI("time_constant_up"), limits_in_SI("rotor_spin")
    (Range(least=0.0, most=1000.0, or_zero=False), None)
    """
    key = FILTER_KEYS[0] if attribute == "filter_cutoff" else FILE_KEYS[attribute]
    name = key.rpartition(".")[2]
    return OF_VEHICLES[name].in_SI(unit_of(name)) if name in OF_VEHICLES else None


def _written(number: float) -> str:
    """Write a number as people do: 1e6, not 1e+06."""
    mantissa, e, exponent = f"{number:g}".partition("e")
    return f"{mantissa}e{int(exponent)}" if e else mantissa


UNIT_VECTOR = Range(-1.01, 1.01)
"""Of the parts of a vector within 1 % of unit length."""

_SPEED = Range(-1e5, 1e5)
_THRUST = Range(-1e9, 1e9)
_TIME = Range(0.0, 1e6)
_CUTOFF = Range(0.0, 1e6)
_ANGLE = Range(-1e5, 1e5)

OF_VEHICLES: Mapping[str, Range] = {
    "mass_kg": Range(1e-6, 1e6),
    "tilt_mechanism_mass_kg": Range(0.0, 1e6),
    "inertia_kg_m2": Range(-1e9, 1e9),
    "position_m": Range(-1e4, 1e4),
    "thrust_coefficient_N_per_Hz2": Range(1e-15, 1e6),
    "drag_coefficient_Nm_per_Hz2": Range(1e-30, 1e6),
    "speed_min_Hz": _SPEED,
    "speed_max_Hz": Range(1e-3, 1e5),
    "thrust_min_N": _THRUST,
    "thrust_max_N": Range(1e-9, 1e9),
    "dead_band_Hz": Range(0.0, 1e5),
    "time_constant_up_ms": _TIME,
    "time_constant_down_ms": _TIME,
    "spin_inertia_kg_m2": Range(0.0, 1e6),
    "angle_min_deg": _ANGLE,
    "angle_max_deg": _ANGLE,
    "rate_max_deg_per_s": Range(1e-3, 1e6),
    "time_constant_ms": _TIME,
    "position_cutoff_Hz": _CUTOFF,
    "velocity_cutoff_Hz": _CUTOFF,
    "attitude_cutoff_Hz": _CUTOFF,
    "rate_cutoff_Hz": _CUTOFF,
}
"""Key of a vehicle file -> the range of its numbers, in the unit at its end."""
