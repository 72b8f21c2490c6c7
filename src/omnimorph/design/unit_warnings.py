"""What is said of numbers that look like those of another unit: a warning of one sentence each."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from typing import Any

from omnimorph.design.unit_doubts import Explanation, UnitDoubt
from omnimorph.errors import UnlikelyUnitWarning, legible, shown

__all__ = ["question_units"]

_LONGEST = 1000  # characters


def question_units(
    doubts: Iterable[UnitDoubt],
    place: Callable[[str, int | None], tuple[str, Any]],
    name: Callable[[str], str],
) -> None:
    """Warn of numbers that are in doubt.

    Parameters
    ----------
    doubts : iterable of UnitDoubt
        What `unit_doubts` found.
    place : callable
        Returns where an attribute, of a rotor or servo, stands, and what is written there.
    name : callable
        Returns what an attribute is called in the sentence.
    """
    for doubt in doubts:
        where, value = place(doubt.attribute, doubt.number)
        likely = _told(doubt, name) or "check its unit"
        sentence = f"{where} is {shown(value)}: {doubt.why}; {likely}."
        warnings.warn(legible(sentence, _LONGEST), UnlikelyUnitWarning, stacklevel=4)


def _told(doubt: UnitDoubt, name: Callable[[str], str]) -> str:
    """Return what the number looks like, and others with it; one way or another."""
    ways = doubt.explanations
    if all(len(way) == 1 and way[0][0] == doubt.attribute for way in ways):
        looks = " or ".join(looks for ((_, looks),) in ways)
        return f"it looks {looks}" if looks else ""
    return ", or ".join(_way_told(doubt.attribute, way, name) for way in ways)


def _way_told(attribute: str, way: Explanation, name: Callable[[str], str]) -> str:
    (first, looks), *others = way
    parts = [f"{'it' if first == attribute else name(first)} looks {looks}"]
    parts += [f"{name(other)} {looks}" for other, looks in others]
    return " and ".join(filter(None, [", ".join(parts[:-1]), parts[-1]]))
