"""What the paper says of its flights, judged."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from omnimorph.results.measures import MEASURES
from omnimorph.results.run import Run
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.flights import FIXED_A, FIXED_B, W3, A, B, PaperFlights
from omnimorph.studies.reproduction.spread import spread_of
from omnimorph.studies.reproduction.verdicts import FAR, NEAR, Judged, Verdict

__all__ = ["judge_flights"]

_FIRST_CLIMB = 5.0  # s in which the tilt of Case A may rise before it is judged
_ALIKE = 0.02  # two energies nearer than that are nearly the same

_Answer = tuple[str, Verdict, str]


def judge_flights(flights: PaperFlights) -> list[Judged]:
    """Judge every number and every claim in words on the paper's flights."""
    numbers = [
        _judge_number(flights, claim)
        for claim in paper.claims().values()
        if "metric" in claim.about
    ]
    return numbers + [_judge_words(flights, key, judge) for key, judge in _JUDGES.items()]


# --- numbers --------------------------------------------------------------------------------------


def _judge_number(flights: PaperFlights, claim: paper.PaperClaim) -> Judged:
    scenario, metric = claim.about["scenario"], claim.about["metric"]
    factor = MEASURES[metric].factor
    spread = spread_of(flights.realistic[scenario], metric, factor)
    assert claim.value is not None
    difference = spread.mean / claim.value - 1.0
    if metric == "drag_energy_paper":
        verdict, why = _judge_energy(difference)
    elif metric == "acceleration_energy_paper":
        verdict = Verdict.ASSUMED
        why = "Measurement noise and rotor lag decide it, and the paper gives neither."
    else:
        verdict, why = _judge_error(flights, claim, difference)
    return Judged(
        claim=claim,
        found=f"{spread.completed} of {spread.flights} flights completed",
        verdict=verdict,
        why=why,
        command=f"omnimorph fly {scenario}",
        here=spread.mean,
        low=spread.low,
        high=spread.high,
    )


def _judge_energy(difference: float) -> tuple[Verdict, str]:
    if abs(difference) > FAR:
        return Verdict.NOT_EXPLAINED, "Too far, although the flight's length was chosen to fit."
    return Verdict.CALIBRATED, "The length of the flight was chosen because of the energies."


def _judge_error(
    flights: PaperFlights, claim: paper.PaperClaim, difference: float
) -> tuple[Verdict, str]:
    """Judge an error: as flown, or under the conjecture that the reference told no rates."""
    scenario, metric = claim.about["scenario"], claim.about["metric"]
    if abs(difference) <= NEAR:
        return Verdict.PREDICTED, "It comes out as flown."
    told_no_rates = spread_of(flights.pose_only[scenario], metric, MEASURES[metric].factor).mean
    assert claim.value is not None
    left = told_no_rates / claim.value - 1.0
    where = f"{told_no_rates:.3g} {claim.unit}".strip()
    if abs(left) <= NEAR and metric == "attitude_error_paper":
        return Verdict.CONJECTURED, (
            f"If the reference told the attitude but not its rate, it would be {where}, whatever "
            "the weights, plant and noise."
        )
    if abs(left) <= FAR:
        return Verdict.ASSUMED, (
            f"If the reference told no velocity, it would be {where} for the way of our "
            "trajectory, whose length the paper does not give."
        )
    return Verdict.NOT_EXPLAINED, (
        f"A reference without velocity gives {where}; nothing that we tried gives the rest without "
        "spoiling the attitude."
    )


# --- words ----------------------------------------------------------------------------------------


def _judge_words(
    flights: PaperFlights, key: str, judge: Callable[[PaperFlights], _Answer]
) -> Judged:
    found, verdict, why = judge(flights)
    return Judged(
        claim=paper.claims()[key],
        found=found,
        verdict=verdict,
        why=why,
        command="omnimorph reproduce",
    )


def _energy_order(flights: PaperFlights) -> _Answer:
    a, b, fixed_a, fixed_b = (
        flights.values(name, "drag_energy_paper") for name in (A, B, FIXED_A, FIXED_B)
    )
    fixed = np.concatenate([fixed_a, fixed_b])
    holds = bool(b.max() < fixed.min() and fixed.max() < a.min())
    reported = [paper.claims()[f"drag_energy_{key}"].value or math.nan for key in ("a", "b")]
    text = (
        f"B {b.mean():.0f}, fixed {fixed.mean():.0f}, A {a.mean():.0f} in the paper's count"
        f"{', for every seed' if holds else ''}; A over B is {a.mean() / b.mean():.2f} (the paper: "
        f"{reported[0] / reported[1]:.2f})"
    )
    why = "The length of the flight hardly enters an order or a ratio."
    return text, _if_true(holds), why


def _fixed_tilt_alike(flights: PaperFlights) -> _Answer:
    a, b = (float(flights.values(name, "drag_energy_paper").mean()) for name in (FIXED_A, FIXED_B))
    apart = abs(a / b - 1.0)
    why = "At one tilt the least thrusts for a wrench are nearly the same, whatever the weights."
    return f"{a:.0f} and {b:.0f}, {100 * apart:.1f} % apart", _if_true(apart <= _ALIKE), why


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
    return text, Verdict.PREDICTED if mean > 0.98 * top else Verdict.ASSUMED, why


def _tilt_of_case_b(flights: PaperFlights) -> _Answer:
    low, side, rest = _tilt_by_task(flights.runs[B])
    text = (
        f"{low:.0f}° on average while it only moves vertically, {side:.0f}° while it moves "
        f"sideways level, {rest:.0f}° while it is not level"
    )
    return text, _if_true(low < 0.6 * rest), "Its weights price effort, which a small tilt saves."


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
    holds = bool(a.max() < b.min() and angle_a.max() < angle_b.min())
    return text, _if_true(holds), "The order is the paper's for every seed; the sizes are not."


def _acceleration_order(flights: PaperFlights) -> _Answer:
    a, b = (flights.values(name, "acceleration_energy_paper") for name in (A, B))
    why = "At a small tilt Case B follows noise with larger changes of thrust."
    return f"{b.mean():.0f} against {a.mean():.0f}", _if_true(bool(a.max() < b.min())), why


def _weight_on_change(flights: PaperFlights) -> _Answer:
    before, after = (
        float(flights.values(name, "acceleration_energy_paper").mean()) for name in (B, W3)
    )
    errors = [1e3 * float(flights.values(name, "position_error_mean_m").mean()) for name in (B, W3)]
    saved = 1.0 - after / before
    reported = [
        paper.claims()[f"acceleration_energy_{key}"].value or math.nan for key in ("b", "w3")
    ]
    text = (
        f"{100 * saved:.0f} % less (the paper: {100 * (1 - reported[1] / reported[0]):.0f} %), "
        f"{errors[0]:.2f} mm become {errors[1]:.2f} mm"
    )
    why = "The direction is the paper's; how much is saved depends on the noise."
    return text, _if_true(saved > 0.0), why


def _acceleration_is_minor(flights: PaperFlights) -> _Answer:
    """Judge in joules: the paper's count makes drag 2π and acceleration 4π² times too small."""
    shares = []
    for name in (A, B):
        drag = float(flights.values(name, "drag_energy_J").mean())
        spin_up = float(flights.values(name, "acceleration_energy_J").mean())
        shares.append(100.0 * spin_up / (drag + spin_up))
    text = (
        f"in joules it is {shares[0]:.0f} % of both energies together in Case A, {shares[1]:.0f} % "
        "in Case B"
    )
    why = (
        "The paper leaves speeds in Hz, so drag comes out 2π times too small and acceleration 4π² "
        "times; only so it looks minor."
    )
    return text, Verdict.CONTRADICTED if max(shares) >= 20.0 else Verdict.PREDICTED, why


def _if_true(holds: bool) -> Verdict:
    return Verdict.PREDICTED if holds else Verdict.CONTRADICTED


_JUDGES = {
    "energy_order": _energy_order,
    "fixed_tilt_alike": _fixed_tilt_alike,
    "tilt_of_case_a": _tilt_of_case_a,
    "tilt_of_case_b": _tilt_of_case_b,
    "tracking_order": _tracking_order,
    "acceleration_order": _acceleration_order,
    "weight_on_change": _weight_on_change,
    "acceleration_is_minor": _acceleration_is_minor,
}
