"""How each claim of the paper is judged: by a rule for its kind, and by what our answer rests on.

What kind a claim is of stands beside it in ``paper.toml``; the rule of that kind decides whether it
holds, `verdict_of` what that is worth. What was chosen so that it agrees proves nothing.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.report.tables import number
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.paper import PaperClaim
from omnimorph.studies.reproduction.wording import with_unit

NEAR = 0.10
"""As a share of the paper's value: near enough to say that it comes out."""

RULES = ("exact", "number", "bound", "order", "survival")
"""The kinds of claims; ``templates/rules.j2`` says when one of a kind holds."""


class Verdict(enum.Enum):
    """How a claim of the paper stands; ``templates/rules.j2`` says what each stands for."""

    PREDICTED = "predicted"
    CALIBRATED = "calibrated"
    CONJECTURED = "conjectured"
    ASSUMED = "rests on assumptions"
    CONTRADICTED = "contradicted"
    NOT_EXPLAINED = "not explained"


class Basis(enum.Enum):
    """What our answer to a claim rests on."""

    DERIVED = "mathematics, or what the paper states"
    FLOWN = "flights in a plant whose lag and noise are our assumptions"
    CHOSEN = "a parameter that was chosen from the claim"
    ASSUMED = "what the paper does not publish"


def verdict_of(
    rule: str, holds: bool | None, basis: Basis, explained: Verdict | None = None
) -> Verdict:
    """Return how a claim stands.

    Parameters
    ----------
    rule : str
        Of `RULES`.
    holds : bool or None
        What the rule says; None where it does not settle it.
    basis : Basis
    explained : Verdict, optional
        What it is called if it does not hold, but does under an assumption.
    """
    if holds is None or basis is Basis.ASSUMED:
        return explained or Verdict.ASSUMED
    if holds:
        return Verdict.CALIBRATED if basis is Basis.CHOSEN else Verdict.PREDICTED
    if explained is not None:
        return explained
    by_size = rule == "number" and basis is not Basis.DERIVED
    return Verdict.NOT_EXPLAINED if by_size else Verdict.CONTRADICTED


# --- rules ----------------------------------------------------------------------------------------


def is_near(here: float, claimed: float) -> bool:
    """Return whether a number is near enough to the paper's.

    Examples
    --------
    >>> is_near(1.09, 1.0), is_near(0.89, 1.0), is_near(math.nan, 1.0)
    (True, False, False)
    """
    return abs(here - claimed) <= NEAR * abs(claimed)


def bound_holds(here: float, claimed: float) -> bool:
    """Return whether what "up to `claimed`" allows is allowed, to the last digit that is printed.

    Examples
    --------
    >>> bound_holds(6.6, 7.0), bound_holds(6.42, 7.0), bound_holds(8.0, 7.0)
    (True, False, True)
    """
    digits = len(str(claimed).rstrip("0").partition(".")[2])
    return round(here, digits) >= claimed


def order_holds(*pairs: tuple[ArrayLike, ArrayLike]) -> bool | None:
    """Return whether all of the first lie below all of the second, in each pair.

    None if one pair is neither so nor all the other way round, or has no numbers to compare.

    Examples
    --------
    >>> order_holds(([1, 2], [3, 4])), order_holds(([3, 4], [1, 2])), order_holds(([1, 3], [2, 4]))
    (True, False, None)
    >>> order_holds(([], [3, 4])) is None
    True
    """
    answers = [_below(np.asarray(low), np.asarray(high)) for low, high in pairs]
    return False if False in answers else None if None in answers else True


def _below(low: Any, high: Any) -> bool | None:
    if not low.size or not high.size:
        return None
    if low.max() < high.min():
        return True
    return False if high.max() < low.min() else None


def survival_holds(intervals: Sequence[tuple[float, float]], *, fails: bool) -> bool | None:
    """Return whether most flights survive (or fail), from intervals of shares, by each criterion.

    None where one criterion says yes and another no, or the seeds do not settle it.

    Examples
    --------
    >>> survival_holds([(0.84, 1.0), (0.0, 0.16)], fails=False) is None
    True
    >>> survival_holds([(0.0, 0.2), (0.0, 0.16)], fails=True)
    True
    """
    answers = [None if low <= 0.5 <= high else (high < 0.5) == fails for low, high in intervals]
    return answers[0] if len(set(answers)) == 1 else None


# --- rows -----------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Judged:
    """A claim of the paper beside what was found here.

    Attributes
    ----------
    claim : PaperClaim
        What the paper says.
    found : str
        What was found, in words.
    verdict : Verdict
        How the claim stands.
    why : str
        The reason for the verdict, in a sentence.
    command : str
        What shows it.
    here, low, high : float or None
        Our number, in the unit of the claim: mean, smallest and largest over seeds, or all the
        same; None for a claim in words.
    explained : bool
        Whether the verdict is that of an assumption, which `why` names: what stands here does not
        hold.
    """

    claim: PaperClaim
    found: str
    verdict: Verdict
    why: str
    command: str
    here: float | None = None
    low: float | None = None
    high: float | None = None
    explained: bool = False

    @property
    def difference(self) -> float | None:
        """How far ours lies above the paper's number, as a share of it; None in words."""
        if self.here is None or self.claim.value is None or not math.isfinite(self.here):
            return None
        return self.here / self.claim.value - 1.0

    @property
    def sentence(self) -> str:
        """The claim's number and ours, or what was found, in a sentence."""
        unit = self.claim.unit
        if self.claim.value is None:
            return f"Here: {self.found}."
        theirs, ours = with_unit(number(self.claim.value, 5), unit), self.here_text
        both = f"The paper: {theirs}. Here: {with_unit(ours, unit)}"
        return f"{both}; {self.found}." if self.found else f"{both}."

    @property
    def here_text(self) -> str:
        """Our number with its range over the seeds; empty for a claim in words."""
        if self.here is None or self.low is None or self.high is None:
            return ""
        return range_text(self.here, self.low, self.high)

    def as_dict(self) -> dict[str, Any]:
        """Return the row as ``results.json`` has it."""
        claim = self.claim
        return {
            "key": claim.key,
            "text": claim.text,
            "where": claim.where,
            "rule": claim.rule,
            "unit": claim.unit,
            "paper": claim.value,
            "here": self.here,
            "low": self.low,
            "high": self.high,
            "difference": self.difference,
            "found": self.found,
            "verdict": self.verdict.value,
            "explained": self.explained,
            "why": self.why,
            "command": self.command,
        }


def judge(
    key: str,
    *,
    basis: Basis,
    why: str,
    command: str,
    found: str = "",
    here: float | None = None,
    low: float | None = None,
    high: float | None = None,
    holds: bool | None = None,
    explained: Verdict | None = None,
) -> Judged:
    """Judge a claim: a number or a bound from `here`, anything else from `holds`.

    `low` and `high` are `here` unless given; `explained` is as in `verdict_of`.
    """
    claim = paper.claims()[key]
    if claim.value is not None:
        assert here is not None
        value = float(here)
        here, low, high = value, value if low is None else low, value if high is None else high
        decide = {"exact": _is_same, "number": is_near, "bound": bound_holds}[claim.rule]
        holds = decide(value, claim.value) if math.isfinite(value) else None
    verdict = verdict_of(claim.rule, holds, basis, explained)
    return Judged(
        claim=claim,
        found=found,
        verdict=verdict,
        why=why,
        command=command,
        here=here,
        low=low,
        high=high,
        explained=explained is not None and holds is not True,
    )


def _is_same(here: float, claimed: float) -> bool:
    return here == claimed


def range_text(mean: float, low: float, high: float) -> str:
    """Return a mean with the smallest and largest in brackets, if these differ.

    Examples
    --------
    >>> range_text(1736.5, 1708.8, 1764.3), range_text(4.0, 4.0, 4.0)
    ('1736 (1709 … 1764)', '4')
    >>> range_text(0.4686, 0.4635, 0.4736)
    '0.47 (0.46 … 0.47)'
    """
    if low == high or not math.isfinite(mean):
        return number(mean)
    digits = max(-math.floor(math.log10(high - low)), 0)
    shown = [f"{value:.{digits}f}".replace("-", "−") for value in (mean, low, high)]
    return f"{shown[0]} ({shown[1]} … {shown[2]})"
