"""What a reader wants first, in one table: both cases beside the paper."""

from __future__ import annotations

from omnimorph.report.tables import Table, number
from omnimorph.results.metrics import MEASURES
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.findings import Findings
from omnimorph.studies.reproduction.flights import A, B
from omnimorph.studies.reproduction.lost_thrust import KINDS, POSE_KEPT
from omnimorph.studies.reproduction.spread import spread_of
from omnimorph.studies.reproduction.words import FLIGHT_WORDS
from omnimorph.units import from_SI

__all__ = ["key_table"]

_CASES = ((A, "a"), (B, "b"))
_MEASURED = (
    ("rotor drag energy (“J”)", "drag_energy_paper", "drag_energy"),
    ("energy to accelerate the rotors (“J”)", "acceleration_energy_paper", "acceleration_energy"),
    ("position error, mean (mm)", "position_error_mean_m", "position_error"),
    ("‖e_R‖, mean", "attitude_error_paper", "attitude_error"),
)


def key_table(findings: Findings) -> Table:
    """Return the numbers behind the summary: means over the seeds, in the realistic plant."""
    rows = []
    for words, metric, claim in _MEASURED:
        row = [words]
        for name, key in _CASES:
            flown = spread_of(findings.flights.realistic[name], metric, MEASURES[metric].factor)
            row += [number(flown.mean, 3), number(paper.claims()[f"{claim}_{key}"].value, 5)]
        rows.append(row)
    for choice in findings.tilt_choice.choices:
        above = [f"{100.0 * findings.tilt_choice.excess(choice, name):+.1f}" for name, _ in _CASES]
        words = f"energy relative to the lower bound, {choice.label} (%)"
        rows.append([words, *(cell for one in above for cell in (one.replace("-", "−"), "—"))])
    return Table(
        "The two cases in numbers, ours beside the paper's: means over the seeds, realistic plant.",
        [
            "",
            *(word for name, _ in _CASES for word in (f"{FLIGHT_WORDS[name]}, here", "the paper")),
        ],
        rows + _losses(findings),
        frozenset(range(1, 5)),
    )


def _losses(findings: Findings) -> list[list[str]]:
    """Return how much thrust may be lost with the pose kept, at each limit of the rotor speed."""
    kept = [
        one
        for one in findings.degraded.frontiers
        if (one.kind, one.criterion) == (KINDS[0], POSE_KEPT)
    ]
    rows = []
    for limit in sorted({one.speed_limit for one in kept}):
        row = [f"largest loss of thrust with the pose kept, at ±{from_SI(limit, 'Hz'):.0f} Hz (%)"]
        for name, _ in _CASES:
            one = next(o for o in kept if (o.scenario, o.speed_limit) == (name, limit))
            row += [f"{100 * one.bracket[0]:.1f} to {100 * one.bracket[1]:.1f}", "—"]
        rows.append(row)
    return rows
