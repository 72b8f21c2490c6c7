"""Whole numbers as users hand them over: counts, seeds and steps."""

from __future__ import annotations

import operator

from omnimorph.errors import ScenarioError

__all__ = ["whole_number"]


def whole_number(place: str, name: str, value: object, bits: int) -> int:
    """Return an integer that fits in so many bits; refuse anything else."""
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        number = -1
    if isinstance(value, bool) or not 0 <= number < 2**bits:
        raise ScenarioError.at(place, name, value, f"an integer from 0 to 2**{bits} - 1")
    return number
