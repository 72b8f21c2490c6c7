"""What the page says in sentences, from what was found."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from omnimorph.report.analysis_words import listed
from omnimorph.report.tables import number
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.ablation import (
    LESS,
    MORE,
    PERFECT,
    Ablation,
    Condition,
)
from omnimorph.studies.reproduction.findings import Findings
from omnimorph.studies.reproduction.flights import A, B, PaperFlights
from omnimorph.studies.reproduction.hypotheses import (
    MOMENTUM_AND_WAKES,
    WITH_MOMENTUM,
    Hypothesis,
)
from omnimorph.studies.reproduction.lost_thrust import CASES
from omnimorph.studies.reproduction.spread import spread_of
from omnimorph.studies.reproduction.tilt_choice import TiltChoice
from omnimorph.studies.reproduction.verdicts import NEAR, Judged, Verdict, is_near

__all__ = ["KeyPoint", "key_points", "reasons"]


class KeyPoint(NamedTuple):
    """One line of the summary: what it is about, and what was found."""

    head: str
    text: str


def key_points(findings: Findings, judged: Sequence[Judged]) -> list[KeyPoint]:
    """Return the summary of the page."""
    counts = Counter(row.verdict for row in judged)
    verdicts = listed([f"{counts[one]} {one.value}" for one in Verdict if counts[one]])
    contradicted = [f"“{row.claim.text}”" for row in judged if row.verdict is Verdict.CONTRADICTED]
    return [
        KeyPoint("Verdicts.", f"Of {len(judged)} claims: {verdicts}."),
        KeyPoint("What does not hold.", " · ".join(contradicted)),
        KeyPoint("Energies.", _energies(findings.flights)),
        KeyPoint("Errors.", _errors(findings)),
        KeyPoint("Less thrust.", _less_thrust(findings)),
        KeyPoint("The tilt.", _tilt(findings.tilt_choice)),
    ]


def _energies(flights: PaperFlights) -> str:
    claimed = [paper.claims()[f"drag_energy_{key}"].value or 0.0 for key in ("a", "b")]
    means = [spread_of(flights.realistic[name], "drag_energy_paper").mean for name in (A, B)]
    near = sum(map(is_near, means, claimed))
    return (
        f"Of the rotor drag energies of Cases A and B, {near} of 2 come out within "
        f"{100 * NEAR:g} %; the sizes are partly calibrated, as the length of the flight was "
        "chosen from them. The paper's count leaves speeds in hertz: joules are 2π times as many."
    )


def _errors(findings: Findings) -> str:
    best = [one for one in findings.hypotheses if one.verdict is Verdict.CONJECTURED]
    most = max(best, key=lambda one: one.explained)
    fitted = next(one for one in findings.hypotheses if one.verdict is Verdict.CALIBRATED)
    return (
        "Flown as stated, position errors are smaller than the paper's by far. Of the paper's six "
        f"mean errors, a conjecture explains {most.explained} ({most.label}), a fit "
        f"{fitted.explained} ({fitted.label})."
    )


def _less_thrust(findings: Findings) -> str:
    return (
        "The largest loss with which the pose is kept depends on the limit of the rotor speeds, "
        "which the paper does not state: both that come into question stand in the table."
    )


def _tilt(found: TiltChoice) -> str:
    spread = [
        max(excess) - min(excess)
        for excess in ([found.excess(one, name) for one in found.choices] for name in CASES)
    ]
    return (
        "Searching all tilts instead of three changes the energy relative to the lower bound by "
        f"{100.0 * max(spread):.1f} percentage points at most."
    )


# --- why ------------------------------------------------------------------------------------------


def reasons(ablation: Ablation, hypotheses: Sequence[Hypothesis]) -> list[str]:
    """Return what the ablation shows: what moves the tilt, what makes errors, and which errors."""
    return [
        _why_the_tilt_climbs(ablation),
        *_what_makes_errors(ablation),
        _what_makes_case_b_worse(hypotheses),
    ]


def _find(ablation: Ablation, group: str, label: str) -> Condition:
    return next(one for one in ablation.conditions if (one.group, one.label) == (group, label))


def _why_the_tilt_climbs(ablation: Ablation) -> str:
    def tilt(group: str, label: str) -> str:
        return f"{_find(ablation, group, label).spread(A, 'tilt_mean_deg').mean:.0f}°"

    return (
        f"White noise makes the tilt of Case A climb: {tilt(PERFECT, 'nothing')} on average in the "
        f"perfect plant, {tilt(PERFECT, 'noise')} with noise alone, "
        f"{tilt(LESS, 'no measurement noise')} in the realistic plant without it. Filtered, the "
        f"same noise gives {tilt(MORE, 'noise, filtered')}: the weight on changing the inputs far "
        "outweighs that on the inputs, and at a larger tilt smaller changes follow a reference "
        "that jitters."
    )


def _what_makes_errors(ablation: Ablation) -> list[str]:
    own = [one for one in ablation.conditions if one.group in (MORE, LESS)]
    sentences = []
    for metric, words, factor, unit, digits in (
        ("position_error_mean_m", "position error", 1e3, " mm", 2),
        ("attitude_error_paper", "attitude error", 1.0, "", 2),
    ):
        worst = sorted(own, key=lambda one: -one.spread(B, metric).mean)[:3]
        shown = listed(
            [
                f"{one.label} ("
                + " and ".join(
                    number(factor * one.spread(name, metric).mean, digits) for name in CASES
                )
                + f"{unit})"
                for one in worst
            ]
        )
        sentences.append(f"Single imperfections with the largest {words} in A and B: {shown}.")
    return sentences


def _what_makes_case_b_worse(hypotheses: Sequence[Hypothesis]) -> str:
    """Return Case B's position error over Case A's: momentum alone, and with interference."""
    momentum = next(one for one in hypotheses if one.label == WITH_MOMENTUM)
    both = next(one for one in hypotheses if one.label == MOMENTUM_AND_WAKES)
    claims = paper.claims()
    ours = [number(one.ratio_of_position_errors, 2) for one in (momentum, both)]
    theirs = (claims["position_error_b"].value or 0.0) / (claims["position_error_a"].value or 1.0)
    return (
        f"Case B's position error is {ours[0]} times Case A's with rotor momentum, and {ours[1]} "
        f"times with interference as well (the paper: {number(theirs, 2)}). No single imperfection "
        "brings both this ratio and the paper's attitude errors."
    )
