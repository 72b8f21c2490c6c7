"""The pictures and the page of the reproduction: from what was flown to ``report.html``."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.report import figures, style, summary_figures
from omnimorph.report.page import Picture, render_page
from omnimorph.report.style import Flight, Look
from omnimorph.report.tables import (
    Table,
    metrics_table,
    number,
    plant_table,
    source_table,
    trajectory_table,
)
from omnimorph.results.atomic import write_text
from omnimorph.results.measures import MEASURES, Measure
from omnimorph.results.metrics import Metrics
from omnimorph.studies.paper_comparison import (
    NEAR,
    Claim,
    Comparison,
    judge_claims,
    judge_values,
    paper_values,
)
from omnimorph.studies.paper_flights import SCENARIOS, Flown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["N_PICTURES", "draw_pictures", "write_page"]

A, B, W3, FIXED_A, FIXED_B = SCENARIOS
N_PICTURES = 8

_TITLE = "OmniMorph flown again: Case A beside Case B"
_WORDS = {
    A: "Case A",
    B: "Case B",
    W3: "Case B, W3 × 10",
    FIXED_A: "fixed 45°, A's weights",
    FIXED_B: "fixed 45°, B's weights",
}
_DASHED = (0, (4.0, 1.2))
_LOOKS = {
    A: Look(style.VERMILLION),
    B: Look(style.BLUE, _DASHED),
    W3: Look(style.PURPLE),
    FIXED_A: Look(style.GREEN, "-."),
    FIXED_B: Look(style.GREEN, "-."),
}
_VARIANT_LOOKS = (
    Look(style.BLACK),
    Look(style.VERMILLION),
    Look(style.PURPLE, _DASHED),
    Look(style.GREEN, "-."),
    Look(style.BLUE, (0, (1.2, 1.0))),
)


# --- pictures -------------------------------------------------------------------------------------


def draw_pictures(
    flown: Flown, folder: Path, next_step: Callable[[str], None]
) -> dict[str, Picture]:
    """Draw every figure into a new folder, as SVG and PDF; return them by their names.

    `next_step` is called with a few words before each.
    """
    a, b = (Flight(_WORDS[name], flown.runs[name], _LOOKS[name]) for name in (A, B))
    fixed = Flight(_WORDS[FIXED_B], flown.runs[FIXED_B], _LOOKS[FIXED_B])
    pair = (a, b)
    drawings: dict[str, tuple[str, Callable[[], Figure]]] = {
        "overview": (
            "The vehicle at three tilts; tilt and power of both cases over time",
            lambda: summary_figures.overview(pair),
        ),
        "energies": (
            "Energy against drag of each flight beside the paper's",
            lambda: summary_figures.energies(_energy_rows(flown)),
        ),
        "trajectory": (
            "Position and rotation over time, desired and flown",
            lambda: figures.trajectory(pair),
        ),
        "errors": (
            "Position and attitude errors over time, with the paper's means",
            lambda: figures.errors(pair, _paper_means()),
        ),
        "tilt": ("Tilt over time with its limits", lambda: figures.tilt(pair)),
        "rotor_speeds": (
            "Speed of each of the rotors over time with its limits",
            lambda: figures.rotor_speeds(pair),
        ),
        "power_and_energy": (
            "Power and accumulated energy over time",
            lambda: figures.power_and_energy(pair, [fixed]),
        ),
        "tilt_by_plant": (
            "Case A's tilt over time in five plants without imperfection",
            lambda: summary_figures.tilt_by_plant(_variant_flights(flown)),
        ),
    }
    assert len(drawings) == N_PICTURES
    folder.mkdir()
    pictures = {}
    for name, (title, draw) in drawings.items():
        next_step(f"drawing {name.replace('_', ' ')}")
        pictures[name] = Picture(style.save_figure(draw(), folder, name), title)
    return pictures


def _energy_rows(flown: Flown) -> list[summary_figures.EnergyRow]:
    paper = _paper_by_metric("drag_energy_paper")
    return [
        summary_figures.EnergyRow(
            label=_WORDS[name],
            values=[metrics.drag_energy_paper for metrics in flown.spread[name]],
            perfect=flown.perfect[name].drag_energy_paper,
            paper=paper.get(name),
            look=_LOOKS[name],
        )
        for name in (B, W3, FIXED_B, FIXED_A, A)
    ]


def _paper_means() -> list[tuple[str, float, float, Look]]:
    distance = _paper_by_metric("position_error_mean_m")
    sine = _paper_by_metric("attitude_error_paper")
    return [
        (f"the paper's mean, {_WORDS[name]}", 1e3 * distance[name], sine[name], _LOOKS[name])
        for name in (A, B)
    ]


def _variant_flights(flown: Flown) -> list[Flight]:
    return [
        Flight(
            f"{1e3 * variant.step:g} ms" + (", noise" if variant.noise else ""), variant.run, look
        )
        for variant, look in zip(flown.variants, _VARIANT_LOOKS, strict=True)
    ]


def _paper_by_metric(metric: str) -> dict[str, float]:
    entries = paper_values()["value"]
    return {row["scenario"]: row["value"] for row in entries if row["metric"] == metric}


# --- page -----------------------------------------------------------------------------------------


def write_page(
    path: Path, flown: Flown, pictures: Mapping[str, Picture], run_files: Sequence[str]
) -> None:
    """Write the report: one HTML file with everything in it."""
    run = flown.runs[A]
    vehicle = run.vehicle
    # The limit of the speed has a source, but its source says that it is calibrated.
    chosen = [name for name, source in vehicle.sources.items() if source.assumed] + ["speed_max"]
    stated = [name for name in vehicle.sources if name not in chosen]
    content = {
        "title": _TITLE,
        "version": run.provenance.version,
        "paper": paper_values()["paper"],
        "seeds": flown.seeds,
        "duration": number(run.metrics.duration_s),
        "near_percent": number(100 * NEAR),
        "band_seconds": number(run.metrics.duration_s / figures.BANDS, 2),
        "speed_limit": number(float(vehicle.speed_max.max()) / (2 * math.pi)),
        "points": _key_points(flown),
        "joules": _paper_in_joules(),
        "artefact": _artefact(flown),
        "pictures": pictures,
        "values": _value_table(judge_values(flown.spread)),
        "claims": _claim_table(judge_claims(flown.spread, flown.runs)),
        "energy": _energy_table(flown),
        "variants": _variant_table(flown),
        "metrics": metrics_table(
            "Every metric of both flights.",
            {_WORDS[name]: flown.runs[name].metrics for name in (A, B)},
        ),
        "trajectory": trajectory_table(run),
        "plant": plant_table(run),
        "assumed": source_table(vehicle, "Assumed, or calibrated.", chosen),
        "sources": source_table(vehicle, "Stated somewhere, or derived.", stated),
        "provenance": _provenance_table(flown),
        "command": _command(flown.seeds),
        "run_files": run_files,
    }
    write_text(path, render_page("reproduction.html.j2", **content))


def _key_points(flown: Flown) -> dict[str, Any]:
    energy = {
        name: np.array([metrics.drag_energy_paper for metrics in flown.spread[name]])
        for name in SCENARIOS
    }
    fixed = np.concatenate([energy[FIXED_A], energy[FIXED_B]])
    paper = _paper_by_metric("drag_energy_paper")
    paper_error = _paper_by_metric("position_error_mean_m")
    return {
        "energy_a": number(float(energy[A].mean())),
        "energy_b": number(float(energy[B].mean())),
        "energy_fixed": number(float(fixed.mean())),
        "paper_a": number(paper[A], 5),
        "paper_b": number(paper[B], 5),
        "paper_fixed": number(paper[FIXED_B]),
        "order_holds": bool(energy[B].max() < fixed.min() and fixed.max() < energy[A].min()),
        "tilt_a": number(_mean(flown.spread[A], "tilt_mean_deg"), 2),
        "tilt_b": number(_mean(flown.spread[B], "tilt_mean_deg"), 2),
        "error_a": number(1e3 * _mean(flown.spread[A], "position_error_mean_m"), 2),
        "error_b": number(1e3 * _mean(flown.spread[B], "position_error_mean_m"), 2),
        "paper_error_a": number(1e3 * paper_error[A]),
        "paper_error_b": number(1e3 * paper_error[B]),
    }


def _mean(metrics: Sequence[Metrics], name: str) -> float:
    return float(np.mean([getattr(one, name) for one in metrics]))


def _paper_in_joules() -> dict[str, str]:
    """Return the paper's own energies in joules, if its count left the speeds in hertz."""
    turn = 2.0 * math.pi
    drag = {key: value * turn for key, value in _paper_by_metric("drag_energy_paper").items()}
    spin_up = {
        key: value * turn**2 for key, value in _paper_by_metric("acceleration_energy_paper").items()
    }
    return {
        "drag_a": number(drag[A]),
        "drag_b": number(drag[B]),
        "spin_up_a": number(spin_up[A]),
        "spin_up_b": number(spin_up[B]),
        "total_a": number(drag[A] + spin_up[A]),
        "total_b": number(drag[B] + spin_up[B]),
    }


def _artefact(flown: Flown) -> dict[str, Any]:
    perfect = flown.perfect[A].drag_energy_paper
    noise = max(variant.noise for variant in flown.variants)
    near = abs(perfect / _paper_by_metric("drag_energy_paper")[A] - 1.0) < 0.01
    return {"perfect": number(perfect), "near": near, "noise": f"{noise:.0e}".replace("e-0", "e−")}


def _value_table(values: Sequence[Comparison]) -> Table:
    rows = []
    for value in values:
        is_ratio = "/" in value.scenario
        measure = MEASURES[value.metric]
        if value.metric == "attitude_error_paper":
            measure = Measure("attitude error ‖e_R‖", 1e3, "10⁻³")
        factor = 1.0 if is_ratio else measure.factor
        unit = "" if is_ratio or measure.unit == "–" else f" ({measure.unit})"
        words = "ratio of drag energies" if is_ratio else measure.words.split(",")[0] + unit
        names = [_WORDS[name] for name in value.scenario.split(" / ")]
        flight = " / ".join(name.split(",")[0] for name in names) if is_ratio else names[0]
        here = _spread(*(factor * v for v in (value.here, value.low, value.high)))
        paper = number(factor * value.paper, 4 if is_ratio else 5)
        rows.append(
            [words, flight, paper, here, _difference(value.difference), value.verdict.value]
        )
    head = ["", "flight", "the paper", "here", "difference", "verdict"]
    return Table(
        "Every number the paper gives for these flights.", head, rows, frozenset({2, 3, 4})
    )


def _difference(share: float) -> str:
    """Return a difference in per cent, or as a factor where it is large."""
    if share < -0.5:
        return f"{1 / (1 + share):.0f} × smaller"
    if share > 1.0:
        return f"{1 + share:.1f} × larger"
    return f"{100 * share:+.1f} %".replace("-", "−")


def _claim_table(claims: Sequence[Claim]) -> Table:
    rows = [[claim.text, claim.here, claim.verdict.value] for claim in claims]
    return Table("What the paper says in words.", ["the paper", "here", "verdict"], rows)


def _energy_table(flown: Flown) -> Table:
    rows = []
    for name in (B, W3, FIXED_B, FIXED_A, A):
        row = [_WORDS[name]]
        for metric in ("drag_energy_paper", "acceleration_energy_paper"):
            values = [getattr(metrics, metric) for metrics in flown.spread[name]]
            row.append(_spread(float(np.mean(values)), min(values), max(values)))
            row.append(number(getattr(flown.perfect[name], metric)))
        rows.append(row)
    head = ["", "drag", "perfect plant", "acceleration", "perfect plant"]
    caption = "Energy against drag and to accelerate the rotors, in the paper's count (“J”)."
    return Table(caption, head, rows, frozenset({1, 2, 3, 4}))


def _spread(mean: float, low: float, high: float) -> str:
    """Return a mean with the smallest and largest in brackets, all to the same decimal place."""
    digits = max(2 - math.floor(math.log10(abs(mean))), 0) if mean else 0
    shown = [f"{value:.{digits}f}" for value in (mean, low, high)]
    return f"{shown[0]} ({shown[1]} … {shown[2]})"


def _variant_table(flown: Flown) -> Table:
    rows = []
    for variant in flown.variants:
        metrics = variant.run.metrics
        words = f"step {1e3 * variant.step:g} ms" + (", tiny noise" if variant.noise else "")
        numbers = (metrics.drag_energy_paper, metrics.tilt_mean_deg, variant.b.drag_energy_paper)
        rows.append([words, *(number(value) for value in numbers)])
    head = ["perfect plant", "Case A (“J”)", "its mean tilt (°)", "Case B (“J”)"]
    caption = "Energy against drag in five plants that ought to agree."
    return Table(caption, head, rows, frozenset({1, 2, 3}))


def _provenance_table(flown: Flown) -> Table:
    rows = [["omnimorph", flown.runs[A].provenance.version]]
    vehicle_text = flown.runs[A].provenance.vehicle_text
    for name in (A, B):
        run = flown.runs[name]
        origin = run.provenance
        where = f"scenario {name}, plant {origin.plant_name}, seed {origin.seed}"
        rows.append([_WORDS[name], where])
        rows.append([f"{_WORDS[name]}, by itself", f"omnimorph fly {name} --seed {origin.seed}"])
        rows.append([f"{_WORDS[name]}, content hash", run.content_hash])
        rows.append([f"{_WORDS[name]}, scenario hash", _sha256(origin.scenario_text)])
    rows.append(["vehicle hash", _sha256(vehicle_text)])
    return Table("Where these flights come from.", ["", ""], rows)


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _command(seeds: range) -> str:
    """Return the command that makes the page again."""
    more = "" if len(seeds) == 5 else f" --seeds {len(seeds)}"
    more += "" if seeds[0] == 0 else f" --seed {seeds[0]}"
    return f"omnimorph reproduce --out reproduction{more}"
