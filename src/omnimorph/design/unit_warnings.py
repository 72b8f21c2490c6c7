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
        likely = _likeness(doubt, name) or "check its unit"
        sentence = f"{where} is {shown(value)}: {doubt.why}; {likely}."
        warnings.warn(legible(sentence, _LONGEST), UnlikelyUnitWarning, stacklevel=4)


def _likeness(doubt: UnitDoubt, name: Callable[[str], str]) -> str:
    """Return what the number looks like, and others with it; one way or another."""
    ways = doubt.explanations
    if all(len(way) == 1 and way[0][0] == doubt.attribute for way in ways):
        likeness = " or ".join(likeness for ((_, likeness),) in ways)
        return f"it looks {likeness}" if likeness else ""
    return ", or ".join(_explained(doubt.attribute, way, name) for way in ways)


def _explained(attribute: str, way: Explanation, name: Callable[[str], str]) -> str:
    (first, likeness), *others = way
    parts = [f"{'it' if first == attribute else name(first)} looks {likeness}"]
    parts += [f"{name(other)} {likeness}" for other, likeness in others]
    return " and ".join(filter(None, [", ".join(parts[:-1]), parts[-1]]))
