"""How far agreement with the paper counts: what was chosen so that it agrees proves nothing."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Any

from omnimorph.report.tables import number
from omnimorph.studies.reproduction.paper import PaperClaim

__all__ = ["FAR", "NEAR", "Judged", "Verdict", "range_words"]

NEAR = 0.10
"""As a share of the paper's value: near enough to say that it comes out."""
FAR = 0.20
"""Farther than this, even what was chosen to agree is not explained."""


class Verdict(enum.Enum):
    """How a claim of the paper stands; the value is the word a reader sees."""

    PREDICTED = "predicted"
    CALIBRATED = "calibrated"
    CONJECTURED = "conjectured"
    ASSUMED = "rests on assumptions"
    CONTRADICTED = "contradicted"
    NOT_EXPLAINED = "not explained"

    @property
    def meaning(self) -> str:
        """What the word stands for, in a sentence."""
        return _MEANINGS[self]


_MEANINGS = {
    Verdict.PREDICTED: (
        f"It comes out, a number within {100 * NEAR:g} %, and nothing was fitted to it."
    ),
    Verdict.CALIBRATED: (
        "A parameter, or the flight, was chosen from it. That it comes out proves little."
    ),
    Verdict.CONJECTURED: (
        "It does not follow from what the paper states, but comes out under one further "
        "assumption, which is named. Nothing was fitted."
    ),
    Verdict.ASSUMED: (
        "The number follows from what the paper does not publish and we assumed: noise, rotor lag, "
        "the length of the way. Near or far, it decides nothing."
    ),
    Verdict.CONTRADICTED: "It does not hold; the reason is a proof, a closed form or a flight.",
    Verdict.NOT_EXPLAINED: "It differs, and nothing that we tried accounts for it.",
}


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
    """

    claim: PaperClaim
    found: str
    verdict: Verdict
    why: str
    command: str
    here: float | None = None
    low: float | None = None
    high: float | None = None

    @property
    def difference(self) -> float | None:
        """How far ours lies above the paper's number, as a share of it; None in words."""
        if self.here is None or self.claim.value is None or not math.isfinite(self.here):
            return None
        return self.here / self.claim.value - 1.0

    @property
    def in_words(self) -> str:
        """The claim's number and ours, or what was found, in a sentence."""
        unit = f" {self.claim.unit}" if self.claim.unit else ""
        if self.claim.value is None:
            return f"Here: {self.found}."
        told = f"The paper: {number(self.claim.value, 5)}{unit}. Here: {self.here_in_words}{unit}"
        return f"{told}; {self.found}." if self.found else f"{told}."

    @property
    def here_in_words(self) -> str:
        """Our number with its range over the seeds; empty for a claim in words."""
        if self.here is None or self.low is None or self.high is None:
            return ""
        return range_words(self.here, self.low, self.high)

    def as_dict(self) -> dict[str, Any]:
        """Return the row as ``results.json`` has it."""
        claim = self.claim
        return {
            "key": claim.key,
            "text": claim.text,
            "where": claim.where,
            "unit": claim.unit,
            "paper": claim.value,
            "here": self.here,
            "low": self.low,
            "high": self.high,
            "difference": self.difference,
            "found": self.found,
            "verdict": self.verdict.value,
            "why": self.why,
            "command": self.command,
        }


def range_words(mean: float, low: float, high: float) -> str:
    """Return a mean with the smallest and largest in brackets, if these differ.

    Examples
    --------
    >>> range_words(1736.5, 1708.8, 1764.3), range_words(4.0, 4.0, 4.0)
    ('1736 (1709 … 1764)', '4')
    >>> range_words(0.4686, 0.4635, 0.4736)
    '0.47 (0.46 … 0.47)'
    """
    if low == high or not math.isfinite(mean):
        return number(mean)
    digits = max(-math.floor(math.log10(high - low)), 0)
    shown = [f"{value:.{digits}f}".replace("-", "−") for value in (mean, low, high)]
    return f"{shown[0]} ({shown[1]} … {shown[2]})"
