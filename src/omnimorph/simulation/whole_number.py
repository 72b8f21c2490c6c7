"""Whole numbers as users hand them over: counts, seeds, steps and rotors."""

from __future__ import annotations

import operator

from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError


def whole_number(place: str, name: str, value: object, bits: int) -> int:
    """Return an integer that fits in so many bits; refuse anything else."""
    return _below(2**bits, place, name, value, f"an integer from 0 to 2**{bits} - 1")


def rotor_index(vehicle: Vehicle, rotor: object, place: str = "the thrust stand") -> int:
    """Return the index of a rotor, from 0; refuse one that the vehicle does not have."""
    n = vehicle.n_rotors
    allowed = f"a rotor of vehicle {vehicle.name}, a number from 0 to {n - 1}"
    return _below(n, place, "rotor", rotor, allowed)


def _below(end: int, place: str, name: str, value: object, allowed: str) -> int:
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        number = -1
    if isinstance(value, bool) or not 0 <= number < end:
        raise ScenarioError.at(place, name, value, allowed)
    return number
