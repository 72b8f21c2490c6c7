"""The paper's numbers and claims beside what was flown here, each with a verdict.

The paper's numbers stand in ``paper_values.toml``. A verdict says how far agreement counts: what
was chosen so that it agrees proves nothing by agreeing.
"""

from __future__ import annotations

import enum
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.results.metrics import Metrics
from omnimorph.results.run import Run

__all__ = ["NEAR", "Claim", "Comparison", "Verdict", "judge_claims", "judge_values", "paper_values"]

NEAR = 0.10
"""As a share of the paper's value: near enough to say that it comes out."""
_FAR = 0.20  # farther than this, even what was calibrated is not explained


class Verdict(enum.Enum):
    """How a number or claim of the paper stands; the value is the word a reader sees."""

    REPRODUCED = "reproduced"
    CALIBRATED = "calibrated"
    ASSUMED = "rests on assumptions"
    PARTLY = "partly reproduced"
    NOT_REPRODUCED = "not reproduced"
    NOT_EXPLAINED = "not explained"


@dataclass(frozen=True)
class Comparison:
    """One number of the paper beside ours.

    Attributes
    ----------
    scenario, metric : str
        Which flight, and which of its metrics; a ratio names both flights, ``a / b``.
    where : str
        Where in the paper it stands.
    paper : float
        Its value there, in the metric's unit.
    here, low, high : float
        Ours: mean, smallest and largest over the seeds.
    verdict : Verdict
        What the agreement, or its lack, is worth.
    """

    scenario: str
    metric: str
    where: str
    paper: float
    here: float
    low: float
    high: float
    verdict: Verdict

    @property
    def difference(self) -> float:
        """How far ours lies above the paper's, as a share of the paper's."""
        return self.here / self.paper - 1.0


@dataclass(frozen=True)
class Claim:
    """One claim of the paper in words: where it stands, what was seen here, and the verdict."""

    key: str
    text: str
    where: str
    here: str
    verdict: Verdict


def paper_values() -> dict[str, Any]:
    """Return the content of ``paper_values.toml``: tables ``paper``, ``value`` and ``claim``."""
    file = resources.files("omnimorph.studies") / "paper_values.toml"
    return tomllib.loads(file.read_text(encoding="utf-8"))


def judge_values(flown: Mapping[str, Sequence[Metrics]]) -> list[Comparison]:
    """Compare every number of the paper, and two ratios of its energies, with flights.

    Parameters
    ----------
    flown : mapping of scenario name to metrics
        Of the same seeds for every scenario, in the realistic plant.
    """
    found = [_judge_value(entry, flown) for entry in paper_values()["value"]]
    return found + _judge_ratios(found, flown)


def _judge_value(entry: Mapping[str, Any], flown: Mapping[str, Sequence[Metrics]]) -> Comparison:
    metric, paper = entry["metric"], float(entry["value"])
    ours = np.array([getattr(metrics, metric) for metrics in flown[entry["scenario"]]])
    verdict = _verdict(metric, float(ours.mean()) / paper - 1.0)
    return Comparison(
        entry["scenario"], metric, entry["where"], paper, *_spread(ours), verdict=verdict
    )


def _verdict(metric: str, difference: float) -> Verdict:
    """Return the verdict on a number: what was put in decides what agreement is worth."""
    if metric == "acceleration_energy_paper":
        return Verdict.ASSUMED  # noise and rotor lag decide it, and both are assumed
    if metric == "drag_energy_paper":
        # The 45 s of the flight were chosen because of the paper's energies.
        return Verdict.CALIBRATED if abs(difference) <= _FAR else Verdict.NOT_EXPLAINED
    return Verdict.REPRODUCED if abs(difference) <= NEAR else Verdict.NOT_EXPLAINED


def _judge_ratios(
    found: Sequence[Comparison], flown: Mapping[str, Sequence[Metrics]]
) -> list[Comparison]:
    """Compare ratios of energies: the length of the flight hardly enters them."""
    metric, b = "drag_energy_paper", "paper-case-b"
    paper = {row.scenario: row.paper for row in found if row.metric == metric}
    ours = {name: np.array([m.drag_energy_paper for m in flown[name]]) for name in paper}
    ratios = []
    for a in ("paper-case-a", "paper-fixed-45-b"):
        reported, here = paper[a] / paper[b], ours[a] / ours[b]
        near = abs(float(here.mean()) / reported - 1.0) <= NEAR
        # Noise, which is assumed, decides how far the tilt climbs in Case A.
        far = Verdict.ASSUMED if a == "paper-case-a" else Verdict.NOT_EXPLAINED
        where = "from the two energies above"
        verdict = Verdict.REPRODUCED if near else far
        ratio = Comparison(f"{a} / {b}", metric, where, reported, *_spread(here), verdict=verdict)
        ratios.append(ratio)
    return ratios


def _spread(values: FloatArray) -> tuple[float, float, float]:
    return float(values.mean()), float(values.min()), float(values.max())


# --- claims in words ------------------------------------------------------------------------------


def judge_claims(flown: Mapping[str, Sequence[Metrics]], runs: Mapping[str, Run]) -> list[Claim]:
    """Judge every claim of the paper in words.

    Parameters
    ----------
    flown : mapping of scenario name to metrics
        As for `judge_values`.
    runs : mapping of scenario name to Run
        One flight of Case A and of Case B, for how the tilt moves.
    """
    judges = {
        "energy_order": lambda: _energy_order(flown),
        "fixed_tilt_alike": lambda: _fixed_tilt_alike(flown),
        "tilt_of_case_a": lambda: _tilt_of_case_a(runs["paper-case-a"]),
        "tilt_of_case_b": lambda: _tilt_of_case_b(runs["paper-case-b"]),
        "tracking_order": lambda: _tracking_order(flown),
        "acceleration_order": lambda: _acceleration_order(flown),
        "weight_on_change": lambda: _weight_on_change(flown),
        "acceleration_is_minor": lambda: _acceleration_is_minor(flown),
    }
    claims = []
    for entry in paper_values()["claim"]:
        here, verdict = judges[entry["key"]]()
        claims.append(Claim(entry["key"], entry["text"], entry["where"], here, verdict))
    return claims


Judged = tuple[str, Verdict]


def _if_true(holds: bool) -> Verdict:
    return Verdict.REPRODUCED if holds else Verdict.NOT_REPRODUCED


def _all(flown: Mapping[str, Sequence[Metrics]], scenario: str, metric: str) -> FloatArray:
    return np.array([getattr(metrics, metric) for metrics in flown[scenario]])


def _energy_order(flown: Mapping[str, Sequence[Metrics]]) -> Judged:
    a, b, fixed_a, fixed_b = (
        _all(flown, f"paper-{name}", "drag_energy_paper")
        for name in ("case-a", "case-b", "fixed-45-a", "fixed-45-b")
    )
    fixed = np.concatenate([fixed_a, fixed_b])
    holds = bool(b.max() < fixed.min() and fixed.max() < a.min())
    text = f"{b.mean():.0f} < {fixed.mean():.0f} < {a.mean():.0f} in the paper's count"
    return f"{text}, for every seed" if holds else f"B, fixed, A: {text}", _if_true(holds)


def _fixed_tilt_alike(flown: Mapping[str, Sequence[Metrics]]) -> Judged:
    a = float(_all(flown, "paper-fixed-45-a", "drag_energy_paper").mean())
    b = float(_all(flown, "paper-fixed-45-b", "drag_energy_paper").mean())
    apart = abs(a / b - 1.0)
    return f"{a:.0f} and {b:.0f}: {100 * apart:.1f} % apart", _if_true(apart <= 0.02)


def _tilt_of_case_a(run: Run) -> Judged:
    """Judge the tilt once it has had 5 s to climb."""
    tilt = np.degrees(run.tilt[run.time >= 5.0])
    top = math.degrees(float(run.vehicle.servo_angle_max[0]))
    mean = float(tilt.mean())
    verdict = Verdict.REPRODUCED if mean > 0.98 * top else Verdict.PARTLY
    verdict = verdict if mean > 0.75 * top else Verdict.NOT_REPRODUCED
    return (
        f"after the first 5 s it wanders between {tilt.min():.0f}° and {tilt.max():.0f}°, "
        f"{mean:.0f}° on average, of the {top:.0f}° allowed",
        verdict,
    )


def _tilt_of_case_b(run: Run) -> Judged:
    """Judge the mean tilt in level vertical motion, level sideways motion, and not level."""
    level = run.desired_R_WB[:, 2, 2] > math.cos(math.radians(1.0))
    speed = np.abs(run.desired_v_WB)
    settled = run.time >= 1.0
    vertical = level & settled & (speed[:, 2] > 1e-3)
    sideways = level & settled & (speed[:, :2].max(axis=1) > 1e-3)
    tilt = np.degrees(run.tilt[:, 0])
    low, side, rest = (float(tilt[rows].mean()) for rows in (vertical, sideways, ~level))
    return (
        f"{low:.0f}° on average while it only moves vertically, {side:.0f}° while it "
        f"moves sideways level, {rest:.0f}° while it is not level",
        _if_true(low < 0.6 * rest),
    )


def _tracking_order(flown: Mapping[str, Sequence[Metrics]]) -> Judged:
    names = ("paper-case-a", "paper-case-b")
    a, b = (1e3 * _all(flown, name, "position_error_mean_m") for name in names)
    angle_a, angle_b = (1e3 * _all(flown, name, "attitude_error_paper") for name in names)
    return (
        f"{a.mean():.2f} against {b.mean():.2f} mm, ‖e_R‖ {angle_a.mean():.1f}e-3 against "
        f"{angle_b.mean():.1f}e-3; the sizes are not the paper's",
        _if_true(bool(a.max() < b.min() and angle_a.max() < angle_b.min())),
    )


def _acceleration_order(flown: Mapping[str, Sequence[Metrics]]) -> Judged:
    a = _all(flown, "paper-case-a", "acceleration_energy_paper")
    b = _all(flown, "paper-case-b", "acceleration_energy_paper")
    return f"{b.mean():.0f} against {a.mean():.0f}", _if_true(bool(a.max() < b.min()))


def _weight_on_change(flown: Mapping[str, Sequence[Metrics]]) -> Judged:
    names = ("paper-case-b", "paper-case-b-w3")
    before, after = (_all(flown, name, "acceleration_energy_paper") for name in names)
    errors = [1e3 * float(_all(flown, name, "position_error_mean_m").mean()) for name in names]
    saved = 1.0 - float(after.mean()) / float(before.mean())
    paper = {
        row["scenario"]: row["value"]
        for row in paper_values()["value"]
        if row["metric"] == "acceleration_energy_paper"
    }
    reported = 1.0 - paper[names[1]] / paper[names[0]]
    return (
        f"{100 * saved:.0f} % less (the paper: {100 * reported:.0f} %), "
        f"{errors[0]:.2f} mm become {errors[1]:.2f} mm",
        Verdict.NOT_REPRODUCED
        if saved <= 0
        else Verdict.REPRODUCED
        if saved > 0.8 * reported
        else Verdict.PARTLY,
    )


def _acceleration_is_minor(flown: Mapping[str, Sequence[Metrics]]) -> Judged:
    """Judge in joules: the paper's count makes drag 2π and acceleration 4π² times too small."""
    shares = []
    for name in ("paper-case-a", "paper-case-b"):
        drag = float(_all(flown, name, "drag_energy_J").mean())
        spin_up = float(_all(flown, name, "acceleration_energy_J").mean())
        shares.append(spin_up / (drag + spin_up))
    return (
        f"in joules it is {100 * shares[0]:.0f} % of both energies together in Case A and "
        f"{100 * shares[1]:.0f} % in Case B; in the paper's count it only looks minor",
        _if_true(max(shares) < 0.2),
    )
