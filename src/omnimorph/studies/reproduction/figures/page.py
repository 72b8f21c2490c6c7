"""Every figure of the page: its name, what it shows, and how it is drawn; drawn on all cores."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import as_completed
from pathlib import Path
from typing import TYPE_CHECKING

from omnimorph.report import analysis_figures, figures, style
from omnimorph.report.geometry_figure import geometry
from omnimorph.report.page import Picture
from omnimorph.report.style import Flight
from omnimorph.studies.processes import busy_pool
from omnimorph.studies.reproduction.figures import summary
from omnimorph.studies.reproduction.figures.ablation import draw_ablation
from omnimorph.studies.reproduction.figures.flights import (
    degraded_flights,
    energy_rows,
    paper_means,
    variant_flights,
)
from omnimorph.studies.reproduction.figures.frontier import frontier
from omnimorph.studies.reproduction.figures.line_styles import LINE_STYLES
from omnimorph.studies.reproduction.figures.stand import stand
from omnimorph.studies.reproduction.figures.tilt_choice import (
    cost_gaps,
    energy_by_choice,
    tilt_by_choice,
)
from omnimorph.studies.reproduction.flights import FIXED_A, FIXED_B, A, B
from omnimorph.studies.reproduction.results import Results
from omnimorph.studies.reproduction.wording import FLIGHT_LABELS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

N_PICTURES = 20
"""How many figures there are."""

_Drawing = tuple[str, Callable[[], "Figure"]]

_drawings: dict[str, _Drawing] = {}  # of a process that draws


def draw_pictures(
    results: Results, folder: Path, next_step: Callable[[str], None], *, draft: bool
) -> dict[str, Picture]:
    """Draw every figure into a new folder, as SVG and PDF; return them by their names.

    Parameters
    ----------
    results : Results
        What is drawn.
    folder : Path
        Made here.
    next_step : callable
        Called with a few words for each figure.
    draft : bool
        Whether it may be done more quickly, see `save_figure`.
    """
    drawings = _design_drawings(results) | _flight_drawings(results) | _study_drawings(results)
    assert len(drawings) == N_PICTURES
    folder.mkdir()
    drawn = {}
    for name, svg in _drawn(drawings, folder, draft):
        next_step(f"drawing {name.replace('_', ' ')}")
        drawn[name] = Picture(svg, drawings[name][0])
    return drawn


def _drawn(drawings: dict[str, _Drawing], folder: Path, draft: bool) -> Iterator[tuple[str, str]]:
    """Draw everything; give each figure's name and SVG as they come."""
    import matplotlib.figure  # once, before there are several processes

    assert matplotlib.figure
    pool = busy_pool(None, _share, drawings)
    try:
        for done in as_completed([pool.submit(_draw, name, folder, draft) for name in drawings]):
            yield done.result()
    finally:
        pool.shutdown(cancel_futures=True)


def _share(drawings: dict[str, _Drawing]) -> None:
    _drawings.clear()
    _drawings.update(drawings)


def _draw(name: str, folder: Path, draft: bool) -> tuple[str, str]:
    return name, style.save_figure(_drawings[name][1](), folder, name, draft=draft)


# --- what there is to draw ------------------------------------------------------------------------


def _design_drawings(results: Results) -> dict[str, _Drawing]:
    analysis = results.design.analysis
    return {
        "geometry": (
            "The vehicle untilted and omnidirectional, with its axes and spins",
            lambda: geometry(analysis.vehicle, (0.0, math.atan(math.sqrt(2.0)))),
        ),
        "force_sets": (
            "Sets of forces at zero moment over the tilt",
            lambda: analysis_figures.force_sets(analysis),
        ),
        "radius_over_tilt": (
            "Inscribed radii of both sets of forces over the tilt, beside the weight",
            lambda: analysis_figures.radius_over_tilt(analysis),
        ),
        "mass_break_even": (
            "Mass of a tilt mechanism that just pays, over the tilt it is compared with",
            lambda: analysis_figures.mass_break_even(analysis),
        ),
    }


def _flight_drawings(results: Results) -> dict[str, _Drawing]:
    flights = results.flights
    a, b, fixed_a, fixed_b = (
        Flight(FLIGHT_LABELS[name], flights.runs[name], LINE_STYLES[name])
        for name in (A, B, FIXED_A, FIXED_B)
    )
    pair = (a, b)
    return {
        "rotor_speeds": (
            "Speed of each of the rotors over time with its limits",
            lambda: figures.rotor_speeds(pair),
        ),
        "overview": (
            "The vehicle at three tilts; tilt and power of both cases over time",
            lambda: summary.overview(pair),
        ),
        "trajectory": (
            "Position and rotation over time, desired and flown",
            lambda: figures.trajectory(pair),
        ),
        "errors": (
            "Position and attitude errors over time, with the paper's means",
            lambda: figures.errors(pair, paper_means()),
        ),
        "tilt": ("Tilt over time with its limits", lambda: figures.tilt(pair)),
        "power_and_energy": (
            "Power and accumulated energy over time",
            lambda: figures.power_and_energy(pair, [fixed_b]),
        ),
        "fixed_tilt": (
            "Power and accumulated energy at a fixed tilt, with both sets of weights",
            lambda: figures.power_and_energy((fixed_a, fixed_b)),
        ),
        "energies": (
            "Rotor drag energy of each flight beside the paper's",
            lambda: summary.energies(energy_rows(flights)),
        ),
    }


def _study_drawings(results: Results) -> dict[str, _Drawing]:
    return {
        "ablation": (
            "Tilt, energy and errors of both cases, one imperfection at a time",
            lambda: draw_ablation(results.ablation),
        ),
        "degraded": (
            "Errors over time with less thrust, beside the healthy flights",
            lambda: figures.errors(degraded_flights(results)),
        ),
        "frontier": (
            "Share of flights that survive over the loss of thrust",
            lambda: frontier(results.degraded),
        ),
        "tilt_by_plant": (
            "Case A's tilt over time in plants without imperfection",
            lambda: summary.tilt_by_plant(variant_flights(results.flights)),
        ),
        "stand": (
            "Speeds and forces of the experiment on interference, over time",
            lambda: stand(results.experiment),
        ),
        "tilt_choice": (
            "Tilt over time by how it is chosen",
            lambda: tilt_by_choice(results.tilt_choice),
        ),
        "energy_by_choice": (
            "Energy by how the tilt is chosen, beside the least possible",
            lambda: energy_by_choice(results.tilt_choice),
        ),
        "cost_gap": (
            "Share of control steps over the excess cost of the chosen tilt",
            lambda: cost_gaps(results.tilt_choice.gaps),
        ),
    }
