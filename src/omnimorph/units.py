"""Units: the doors between what people read and write and the SI inside.

Files, displays and metrics name their unit at the end of the key (``mass_kg``, ``speed_max_Hz``,
``angle_max_deg``); inside the package everything is SI and has no suffix. `UNITS` holds the factor
of every suffix, `unit_of` finds the suffix of a key, `to_SI` and `from_SI` pass the door.

A rotation of 1 Hz is 2π rad/s, so a coefficient of 1 N/Hz² is 1/(2π)² N s²/rad².
"""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import Any, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

_TURN = 2.0 * math.pi
_DEGREE = math.pi / 180.0

UNITS: MappingProxyType[str, float] = MappingProxyType(
    {
        "": 1.0,
        # length, time, mass
        "m": 1.0,
        "cm": 1e-2,
        "mm": 1e-3,
        "s": 1.0,
        "ms": 1e-3,
        "kg": 1.0,
        "g": 1e-3,
        "kg_m2": 1.0,
        # angle
        "rad": 1.0,
        "mrad": 1e-3,
        "deg": _DEGREE,
        # rates
        "m_per_s": 1.0,
        "cm_per_s": 1e-2,
        "mm_per_s": 1e-3,
        "m_per_s2": 1.0,
        "rad_per_s": 1.0,
        "mrad_per_s": 1e-3,
        "rad_per_s2": 1.0,
        "deg_per_s": _DEGREE,
        "Hz": _TURN,
        "rpm": _TURN / 60.0,
        # force, torque, power, energy
        "N": 1.0,
        "Nm": 1.0,
        "W": 1.0,
        "J": 1.0,
        "N_per_Hz2": 1.0 / _TURN**2,
        "Nm_per_Hz2": 1.0 / _TURN**2,
        "percent": 1e-2,
        # gains and weights of controllers
        "per_s": 1.0,
        "per_s2": 1.0,
        "per_Hz4": 1.0 / _TURN**4,
        "s4_per_m2": 1.0,
        "s4_per_rad2": 1.0,
    }
)
"""Suffix -> factor: a value in that unit times the factor is the value in SI."""

SPEED_UNITS = MappingProxyType({"Hz": "Hz", "rad_per_s": "rad/s", "rpm": "rpm"})
"""Suffix of a speed of rotation -> how its unit is written."""


class SpeedSlip(NamedTuple):
    """A place that says one unit of speed and holds another.

    Attributes
    ----------
    said, meant : str
        Keys of `SPEED_UNITS`.
    factor : float
        By which the speeds come out too large.
    words : str
        The same, as people write it.
    of_coefficient : str
        By which coefficients per squared speed come out too large: the inverse square.
    """

    said: str
    meant: str
    factor: float
    words: str
    of_coefficient: str


SPEED_SLIPS = (
    SpeedSlip("Hz", "rad_per_s", _TURN, "2π", "1/(2π)²"),
    SpeedSlip("rad_per_s", "Hz", 1.0 / _TURN, "1/2π", "(2π)²"),
    SpeedSlip("Hz", "rpm", 60.0, "60", "1/60²"),
    SpeedSlip("rpm", "Hz", 1.0 / 60.0, "1/60", "60²"),
    SpeedSlip("rad_per_s", "rpm", 60.0 / _TURN, "60/2π", "(2π/60)²"),
    SpeedSlip("rpm", "rad_per_s", _TURN / 60.0, "2π/60", "(60/2π)²"),
)
"""Each unit of speed taken for each other one."""


def unit_of(key: str) -> str:
    """Return the unit at the end of a key, the longest that fits, "" if there is none.

    Examples
    --------
    >>> unit_of("rate_max_deg_per_s"), unit_of("inertia_kg_m2"), unit_of("name")
    ('deg_per_s', 'kg_m2', '')
    """
    fitting = [unit for unit in UNITS if unit and key.endswith("_" + unit)]
    return max(fitting, key=len, default="")


@overload
def to_SI(value: float, unit: str) -> float: ...
@overload
def to_SI(value: NDArray[Any], unit: str) -> NDArray[np.float64]: ...
def to_SI(value: float | NDArray[Any], unit: str) -> float | NDArray[np.float64]:
    """Convert a value in `unit` to SI.

    Parameters
    ----------
    value : float or array
        In `unit`.
    unit : str
        A key of `UNITS`.

    Returns
    -------
    float or array of float64
        In SI: ``value * UNITS[unit]``.

    Raises
    ------
    ValueError
        If the unit is not in `UNITS`.

    Examples
    --------
    >>> round(to_SI(1.0, "Hz"), 6), to_SI(20.0, "ms")
    (6.283185, 0.02)
    """
    factor = _factor(unit)
    return value * factor if isinstance(value, np.ndarray) else float(value) * factor


@overload
def from_SI(value: float, unit: str) -> float: ...
@overload
def from_SI(value: NDArray[Any], unit: str) -> NDArray[np.float64]: ...
def from_SI(value: float | NDArray[Any], unit: str) -> float | NDArray[np.float64]:
    """Convert a value in SI to `unit`, ``value / UNITS[unit]``: the inverse of `to_SI`."""
    factor = _factor(unit)
    return value / factor if isinstance(value, np.ndarray) else float(value) / factor


def _factor(unit: str) -> float:
    try:
        return UNITS[unit]
    except KeyError:
        known = ", ".join(name for name in UNITS if name)
        raise ValueError(f"the unit {unit!r} is not known; known are {known}.") from None
