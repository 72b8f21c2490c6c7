"""What a case is: a claim, where its answer comes from, and how it is measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True, kw_only=True)
class Result:
    """What came out of a case.

    Attributes
    ----------
    value, expected, tolerance : float
        What was measured, what it should be, and by how much it may differ.
    unit : str
        Of all three; "" for none.
    name, claim, source : str
        Of the case; filled in by `Case.run`.
    """

    value: float
    expected: float = 0.0
    tolerance: float
    unit: str = ""
    name: str = ""
    claim: str = ""
    source: str = ""

    @property
    def passed(self) -> bool:
        """Whether the value is as expected; a value that is not a number never is."""
        return bool(abs(self.value - self.expected) <= self.tolerance)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A claim with a known answer.

    Attributes
    ----------
    name : str
        Short, unique, words joined by hyphens.
    claim : str
        One sentence: what is true if the case passes.
    source : str
        Where the answer comes from.
    check : callable
        Measures; takes nothing, returns a `Result`.
    """

    name: str
    claim: str
    source: str
    check: Callable[[], Result]

    def run(self) -> Result:
        """Measure, and return the result with the case's name, claim and source on it."""
        return replace(self.check(), name=self.name, claim=self.claim, source=self.source)


def case(source: str) -> Callable[[Callable[[], Result]], Case]:
    """Make a case of a function: its name is the function's, its claim the docstring's summary."""

    def build(check: Callable[[], Result]) -> Case:
        claim = " ".join((check.__doc__ or "").strip().split("\n\n")[0].split())
        return Case(name=check.__name__.replace("_", "-"), claim=claim, source=source, check=check)

    return build


def largest(difference: ArrayLike) -> float:
    """Return the largest magnitude in an array: NaN if one is in it, zero if it is empty."""
    return float(np.max(np.abs(np.asarray(difference, dtype=np.float64)), initial=0.0))


def order_of(answers: Sequence[ArrayLike]) -> float:
    """Return the observed order of convergence of three answers, each with half the step before.

    ``log2(‖a₁ − a₂‖ / ‖a₂ − a₃‖)``: Richardson's estimate, which needs no exact answer.
    """
    first, second, third = (np.asarray(answer, dtype=np.float64) for answer in answers)
    change = float(np.linalg.norm(first - second)), float(np.linalg.norm(second - third))
    return float(np.log2(change[0] / change[1]))
