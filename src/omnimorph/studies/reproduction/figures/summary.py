"""Figures that sum a comparison up: the overview, energies as dots, one curve from many plants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.report.figures import mark_time, power_panel, tilt_panel
from omnimorph.report.style import (
    BLACK,
    COLUMNS,
    Flight,
    LineStyle,
    legend_above,
    legend_entries,
    new_figure,
    styled,
)
from omnimorph.report.vehicle_drawing import draw_vehicle
from omnimorph.results.record import COLUMN
from omnimorph.results.thinning import thin

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_OURS: Any = {"marker": "o", "markersize": 5.5, "linestyle": "none"}
_PERFECT: Any = {"marker": "x", "markersize": 5.5, "linestyle": "none", "markeredgewidth": 1.2}
_PAPER: Any = {"marker": "D", "markersize": 7.0, "linestyle": "none", "markerfacecolor": "white"}


@dataclass(frozen=True)
class EnergyRow:
    """The rotor drag energy of one flight, in the paper's count."""

    label: str
    values: Sequence[float]  # with several seeds
    perfect: float | None  # in the perfect plant
    paper: float | None  # what the paper reports
    line_style: LineStyle


@styled
def overview(flights: Sequence[Flight], tilts_deg: Sequence[float] = (0.0, 30.0, 60.0)) -> Figure:
    """Draw the vehicle at a few tilts and, below it, tilt and power of the flights over time."""
    from matplotlib.gridspec import GridSpec

    figure = new_figure(6.0, 0)[0]
    grid = GridSpec(3, len(tilts_deg), figure=figure, height_ratios=[1.75, 1.0, 1.0])
    for i, degrees in enumerate(tilts_deg):
        panel = figure.add_subplot(grid[0, i])
        draw_vehicle(panel, flights[0].run.vehicle, float(np.radians(degrees)))
        panel.set_title(f"tilt {degrees:g}°", y=-0.03, pad=0.0)
    tilt = figure.add_subplot(grid[1, :])
    power = figure.add_subplot(grid[2, :], sharex=tilt)
    tilt_panel(tilt, flights)
    power_panel(power, flights)
    mark_time([tilt, power], flights)
    tilt.tick_params(labelbottom=False)
    legend_above(figure, *legend_entries([tilt, power]), where="outside lower left")
    return figure


@styled
def energies(rows: Sequence[EnergyRow]) -> Figure:
    """Draw drag energy in the paper's count, one row a flight: ours, perfect plant, paper."""
    figure, axes = new_figure(0.75 + 0.34 * len(rows))
    panel = axes[0, 0]
    for i, row in enumerate(rows):
        low, high = min(row.values), max(row.values)
        colour = row.line_style.colour
        panel.plot([low, high], [i, i], color=colour, linewidth=5.0, alpha=0.4, zorder=2)
        mean = [float(np.mean(row.values))]
        panel.plot(mean, [i], color=colour, zorder=4, **_OURS)
        if row.perfect is not None:
            panel.plot([row.perfect], [i], color=colour, zorder=5, **_PERFECT)
        if row.paper is not None:
            panel.plot([row.paper], [i], color=BLACK, zorder=3, **_PAPER)
    panel.set_yticks(range(len(rows)), [row.label for row in rows])
    panel.set_ylim(len(rows) - 0.5, -0.5)
    panel.set_xlim(left=0.0)
    panel.grid(visible=False, axis="y")
    panel.set_xlabel("rotor drag energy in the paper's count, speeds in Hz (“J”; times 2π: joules)")
    legend_above(figure, *_kinds_of_marks())
    return figure


@styled
def tilt_by_plant(flights: Sequence[Flight]) -> Figure:
    """Draw the tilt of the first servo for one scenario flown in several plants."""
    figure, axes = new_figure(2.6)
    panel, column = axes[0, 0], COLUMN["tilt_actual"]
    for flight in flights:
        t, v = thin(flight.run.time, column.as_read(flight.run.tilt_actual[:, 0]), COLUMNS)
        panel.plot(
            t,
            v,
            color=flight.line_style.colour,
            linestyle=flight.line_style.line,
            label=flight.label,
        )
    panel.set_ylabel(f"tilt ({column.unit_read})")
    mark_time([panel], flights)
    legend_above(figure, *legend_entries([panel]))
    return figure


def _kinds_of_marks() -> tuple[list[Any], list[str]]:
    """Return marks without a flight's colour, which says which flight, and what they mean."""
    from matplotlib.lines import Line2D

    marks = [Line2D([], [], color="#444444", **mark) for mark in (_OURS, _PERFECT, _PAPER)]
    labels = [
        "here, realistic plant: mean and range over seeds",
        "here, perfect plant",
        "the paper",
    ]
    return marks, labels
