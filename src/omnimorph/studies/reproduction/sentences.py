"""What the page says in sentences, from what was found."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

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
from omnimorph.studies.reproduction.lost_thrust import CASES, KINDS, POSE_KEPT
from omnimorph.studies.reproduction.tilt_choice import THREE, TiltChoice
from omnimorph.studies.reproduction.verdicts import Judged, Verdict
from omnimorph.studies.reproduction.words import FLIGHT_WORDS
from omnimorph.units import from_SI

__all__ = ["KeyPoint", "key_points", "reasons", "tilt_points"]


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
        KeyPoint("The tilt.", tilt_points(findings.tilt_choice)[0]),
    ]


def _mean(flights: PaperFlights, scenario: str, metric: str) -> float:
    return float(flights.values(scenario, metric).mean())


def _energies(flights: PaperFlights) -> str:
    ours = [number(_mean(flights, name, "drag_energy_paper")) for name in (B, A)]
    theirs = [paper.claims()[f"drag_energy_{key}"].value or 0.0 for key in ("b", "a")]
    joules = [number(_mean(flights, name, "drag_energy_J")) for name in (B, A)]
    return (
        f"In the paper's count {ours[0]} in Case B and {ours[1]} in Case A (the paper: "
        f"{number(theirs[0], 5)} and {number(theirs[1], 5)}); the sizes are partly calibrated, as "
        f"the length of the flight was chosen from them. In joules they are {joules[0]} and "
        f"{joules[1]}: the paper's count leaves speeds in hertz."
    )


def _errors(findings: Findings) -> str:
    flights = findings.flights
    position = [1e3 * _mean(flights, name, "position_error_mean_m") for name in (A, B)]
    theirs = [paper.claims()[f"position_error_{key}"].value or 0.0 for key in ("a", "b")]
    best = [one for one in findings.hypotheses if one.verdict is Verdict.CONJECTURED]
    most = max(best, key=lambda one: one.explained)
    fitted = next(one for one in findings.hypotheses if one.verdict is Verdict.CALIBRATED)
    return (
        f"Flown as stated, {number(position[0], 2)} and {number(position[1], 2)} mm in Cases A and "
        f"B where the paper has {number(theirs[0])} and {number(theirs[1])}. Of the paper's six "
        f"mean errors, a conjecture explains {most.explained} ({most.label}), a fit "
        f"{fitted.explained} ({fitted.label})."
    )


def _less_thrust(findings: Findings) -> str:
    parts = []
    for one in findings.degraded.frontiers:
        if (one.kind, one.criterion) == (KINDS[0], POSE_KEPT):
            low, high = (100.0 * end for end in one.bracket)
            parts.append(
                f"{FLIGHT_WORDS[one.scenario]} {low:.0f}–{high:.0f} % at "
                f"±{from_SI(one.speed_limit, 'Hz'):.0f} Hz"
            )
    limits = sorted({100.0 * one.physical_limit for one in findings.degraded.frontiers})
    return (
        f"Pose kept up to a loss of {listed(parts)}; the weight can be held up to "
        f"{limits[0]:.0f} % and {limits[-1]:.0f} %."
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


# --- choosing the tilt ----------------------------------------------------------------------------


def tilt_points(found: TiltChoice) -> list[str]:
    """Return what the ways to choose the tilt come to."""
    above = {
        choice.label: [100.0 * found.excess(choice, name) for name in CASES]
        for choice in found.choices
    }
    sentences = [
        "Above the least possible energy, in Cases A and B: "
        + "; ".join(f"{label} {a:.1f} % and {b:.1f} %" for label, (a, b) in above.items())
        + f". The oracle spends {number(found.oracle.energy_paper)} in the paper's count."
    ]
    for one in found.gaps:
        dearer = 100.0 * float((one.gap > 0.01).mean())
        sentences.append(
            f"{FLIGHT_WORDS[one.scenario]}, {THREE} against {one.span}: the median step is "
            f"{number(100.0 * float(np.median(one.gap)), 2)} % dearer, {dearer:.1f} % of the steps "
            "more than 1 %."
        )
    return sentences
