"""Units: the doors between what people read and write and the SI inside.

Files, displays and metrics name their unit at the end of the key (``mass_kg``, ``speed_max_Hz``,
``angle_max_deg``); inside the package everything is SI and has no suffix. `UNITS` holds the factor
of every suffix, `unit_of` finds the suffix of a key, `to_SI` and `from_SI` pass the door.

A rotation of 1 Hz is 2π rad/s, so a coefficient of 1 N/Hz² is 1/(2π)² N s²/rad².
"""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

__all__ = ["UNITS", "from_SI", "to_SI", "unit_of"]

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
    """Convert a value in SI to `unit`: the inverse of `to_SI`, but for rounding.

    Parameters
    ----------
    value : float or array
        In SI.
    unit : str
        A key of `UNITS`.

    Returns
    -------
    float or array of float64
        In `unit`: ``value / UNITS[unit]``.

    Raises
    ------
    ValueError
        If the unit is not in `UNITS`.
    """
    factor = _factor(unit)
    return value / factor if isinstance(value, np.ndarray) else float(value) / factor


def _factor(unit: str) -> float:
    try:
        return UNITS[unit]
    except KeyError:
        known = ", ".join(name for name in UNITS if name)
        raise ValueError(f"the unit {unit!r} is not known; known are {known}.") from None
