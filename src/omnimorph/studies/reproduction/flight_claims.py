"""What the paper says of its flights, judged."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from omnimorph.report.analysis_text import listed
from omnimorph.report.tables import number
from omnimorph.results.metrics import MEASURES
from omnimorph.results.run import Run
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.flights import (
    FIXED_A,
    FIXED_B,
    SCENARIOS,
    W3,
    A,
    B,
    PaperFlights,
)
from omnimorph.studies.reproduction.hypotheses import ERRORS, Hypothesis
from omnimorph.studies.reproduction.spread import spread_of
from omnimorph.studies.reproduction.verdicts import (
    Basis,
    Judged,
    Verdict,
    is_near,
    judge,
    order_holds,
)
from omnimorph.studies.reproduction.wording import FLIGHT_LABELS

_LOST = "What is not flown to the end cannot be compared."
_FIRST_CLIMB = 5.0  # s in which the tilt of Case A may rise before it is judged
_COMPARABLE = 1.1  # an error is comparable if it is no larger by more than 10 %


class _Answer(NamedTuple):
    """What was found of a claim in words, whether it holds, why, and what that rests on."""

    found: str
    holds: bool | None
    why: str
    basis: Basis = Basis.FLOWN


def judge_flights(flights: PaperFlights, hypotheses: Sequence[Hypothesis]) -> list[Judged]:
    """Judge every number and every claim in words on the paper's flights."""
    numbers = [
        _judge_number(flights, claim, hypotheses)
        for claim in paper.claims().values()
        if "metric" in claim.about
    ]
    return numbers + [_judge_statement(flights, key, answer) for key, answer in _ANSWERS.items()]


# --- numbers --------------------------------------------------------------------------------------


def _judge_number(
    flights: PaperFlights, claim: paper.PaperClaim, hypotheses: Sequence[Hypothesis]
) -> Judged:
    scenario, metric = claim.about["scenario"], claim.about["metric"]
    spread = spread_of(flights.realistic[scenario], metric, MEASURES[metric].factor)
    explained = None
    if metric == "drag_energy_paper":
        basis = Basis.CHOSEN
        why = (
            "The length of the flight was chosen from the energies; one length cannot fit them all."
        )
    elif metric == "acceleration_energy_paper":
        basis = Basis.ASSUMED
        why = "Measurement noise and rotor lag decide it, and the paper gives neither."
    else:
        assert metric in ERRORS
        basis = Basis.FLOWN
        explained, why = _explanation(claim, hypotheses)
    return judge(
        claim.key,
        basis=basis,
        found=f"{spread.completed} of {spread.flights} flights completed",
        why=why,
        command=f"omnimorph fly {scenario}",
        here=spread.mean,
        low=spread.low,
        high=spread.high,
        explained=explained,
    )


def _explanation(
    claim: paper.PaperClaim, hypotheses: Sequence[Hypothesis]
) -> tuple[Verdict | None, str]:
    """Return what explains an error: of conjectures the one that comes nearest, else a fit."""
    assert claim.value is not None
    found: list[tuple[float, float, Hypothesis]] = []
    for one in hypotheses:
        if one.verdict is not None:
            here = one.spread(claim.about["scenario"], claim.about["metric"]).mean
            if math.isfinite(here):
                found.append((abs(here - claim.value), here, one))
    found.sort(key=lambda row: row[0])
    for verdict in (Verdict.CONJECTURED, Verdict.CALIBRATED):
        for _, here, one in found:
            if one.verdict is verdict and is_near(here, claim.value):
                unit = f" {claim.unit}" if claim.unit else ""
                return verdict, f"With {one.label}: {number(here, 3)}{unit}."
    if not found:
        return None, "No flight under any hypothesis was completed."
    _, here, one = found[0]
    return None, f"The nearest that was tried is {number(here, 3)}, with {one.label}."


# --- words ----------------------------------------------------------------------------------------


def _judge_statement(
    flights: PaperFlights, key: str, answer: Callable[[PaperFlights], _Answer]
) -> Judged:
    lost = [name for name in SCENARIOS if not len(flights.values(name, "duration_s"))]
    if lost:
        none = listed([FLIGHT_LABELS[name] for name in lost])
        found, holds, why, basis = _Answer(f"no flight of {none} was completed", None, _LOST)
    else:
        found, holds, why, basis = answer(flights)
    return judge(key, holds=holds, basis=basis, found=found, why=why, command="omnimorph reproduce")


def _energy_order(flights: PaperFlights) -> _Answer:
    a, b, fixed_a, fixed_b = (
        flights.values(name, "drag_energy_paper") for name in (A, B, FIXED_A, FIXED_B)
    )
    fixed = np.concatenate([fixed_a, fixed_b])
    holds = order_holds((b, fixed), (fixed, a))
    reported = [paper.claims()[f"drag_energy_{key}"].value or math.nan for key in ("a", "b")]
    text = (
        f"B {b.mean():.0f}, fixed {fixed.mean():.0f}, A {a.mean():.0f} in the paper's count"
        f"{', for every seed' if holds else ''}; A over B is {a.mean() / b.mean():.2f} (the paper: "
        f"{reported[0] / reported[1]:.2f})"
    )
    return _Answer(text, holds, "The length of the flight hardly enters an order or a ratio.")


def _fixed_tilt_alike(flights: PaperFlights) -> _Answer:
    a, b = (float(flights.values(name, "drag_energy_paper").mean()) for name in (FIXED_A, FIXED_B))
    apart = abs(a / b - 1.0)
    why = "At one tilt the least thrusts for a wrench are nearly the same, whatever the weights."
    return _Answer(f"{a:.0f} and {b:.0f}, {100 * apart:.1f} % apart", is_near(a, b), why)


def _tilt_of_case_a(flights: PaperFlights) -> _Answer:
    run = flights.runs[A]
    tilt = np.degrees(run.tilt_actual[run.time >= _FIRST_CLIMB])
    top = math.degrees(float(run.vehicle.servo_angle_max[0]))
    low, mean, high = float(tilt.min()), float(tilt.mean()), float(tilt.max())
    text = (
        f"after {_FIRST_CLIMB:g} s it wanders between {low:.0f}° and {high:.0f}°, "
        f"{mean:.0f}° on average, of the {top:.0f}° allowed"
    )
    why = (
        "Its cost is nearly flat in the tilt: which way it drifts is decided by noise, which the "
        "paper does not give. It is raised, but not kept at the highest value."
    )
    return _Answer(text, bool(low == top), why, Basis.ASSUMED)


def _tilt_of_case_b(flights: PaperFlights) -> _Answer:
    low, side, rest = _tilt_by_task(flights.runs[B])
    text = (
        f"{low:.0f}° on average while it only moves vertically, {side:.0f}° while it moves "
        f"sideways level, {rest:.0f}° while it is not level"
    )
    why = "Its weights price effort, which a small tilt saves."
    return _Answer(text, order_holds((low, rest)), why)


def _tilt_by_task(run: Run) -> tuple[float, float, float]:
    """Return the mean tilt (°) in level vertical motion, level sideways motion, and not level."""
    level = run.desired_R_WB[:, 2, 2] > math.cos(math.radians(1.0))
    speed = np.abs(run.desired_v_WB)
    settled = run.time >= 1.0
    vertical = level & settled & (speed[:, 2] > 1e-3)
    sideways = level & settled & (speed[:, :2].max(axis=1) > 1e-3)
    tilt = np.degrees(run.tilt_actual[:, 0])
    low, side, rest = (float(tilt[rows].mean()) for rows in (vertical, sideways, ~level))
    return low, side, rest


def _tracking_order(flights: PaperFlights) -> _Answer:
    a, b = (1e3 * flights.values(name, "position_error_mean_m") for name in (A, B))
    angle_a, angle_b = (1e3 * flights.values(name, "attitude_error_paper") for name in (A, B))
    text = (
        f"{a.mean():.2f} against {b.mean():.2f} mm, ‖e_R‖ {angle_a.mean():.1f}e−3 against "
        f"{angle_b.mean():.1f}e−3"
    )
    why = "The order is the paper's for every seed; the sizes are not."
    return _Answer(text, order_holds((a, b), (angle_a, angle_b)), why)


def _acceleration_order(flights: PaperFlights) -> _Answer:
    a, b = (flights.values(name, "acceleration_energy_paper") for name in (A, B))
    why = "At a small tilt Case B follows noise with larger changes of thrust."
    return _Answer(f"{b.mean():.0f} against {a.mean():.0f}", order_holds((a, b)), why)


def _weight_on_change(flights: PaperFlights) -> _Answer:
    before, after = (flights.values(name, "acceleration_energy_paper") for name in (B, W3))
    error, error_after = (1e3 * flights.values(name, "position_error_mean_m") for name in (B, W3))
    saved = 1.0 - float(after.mean() / before.mean())
    reported = [
        paper.claims()[f"acceleration_energy_{key}"].value or math.nan for key in ("b", "w3")
    ]
    text = (
        f"{100 * saved:.0f} % less (the paper: {100 * (1 - reported[1] / reported[0]):.0f} %), "
        f"{error.mean():.2f} mm become {error_after.mean():.2f} mm"
    )
    why = "The direction is the paper's; how much is saved depends on the noise."
    holds = order_holds((after, before), (error_after, _COMPARABLE * error))
    return _Answer(text, holds, why)


def _acceleration_is_minor(flights: PaperFlights) -> _Answer:
    """Judge in joules: the paper's count makes drag 2π and acceleration 4π² times too small."""
    shares, pairs = [], []
    for name in (A, B):
        drag = flights.values(name, "drag_energy_J")
        spin_up = flights.values(name, "acceleration_energy_J")
        pairs.append((spin_up, drag))
        shares.append(100.0 * float((spin_up / (drag + spin_up)).mean()))
    text = (
        f"in joules it is {shares[0]:.0f} % of both energies together in Case A, {shares[1]:.0f} % "
        "in Case B"
    )
    why = (
        "The paper leaves speeds in Hz, so drag comes out 2π times too small and acceleration 4π² "
        "times; only so it looks minor."
    )
    return _Answer(text, order_holds(*pairs), why)


_ANSWERS = {
    "energy_order": _energy_order,
    "fixed_tilt_alike": _fixed_tilt_alike,
    "tilt_of_case_a": _tilt_of_case_a,
    "tilt_of_case_b": _tilt_of_case_b,
    "tracking_order": _tracking_order,
    "acceleration_order": _acceleration_order,
    "weight_on_change": _weight_on_change,
    "acceleration_is_minor": _acceleration_is_minor,
}
