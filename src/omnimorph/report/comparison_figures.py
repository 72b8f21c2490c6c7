"""Figures that set platforms beside one another: drawn to one scale, and their numbers as dots."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.design.vehicle import Vehicle
from omnimorph.model.geometry import propeller_radius
from omnimorph.report.style import BLACK, BLUE, GREY, LIMIT, new_figure, styled
from omnimorph.report.tables import number
from omnimorph.report.vehicle_drawing import draw_vehicle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PER_ROW = 4
_ROW = 0.3  # height of a row of dots, inches
_DOT: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 5.0, "color": BLUE}


@dataclass(frozen=True)
class Column:
    """One number of every platform.

    Attributes
    ----------
    title : str
        What it is, with its unit; may have two lines.
    values : sequence of float
        One a platform; not finite where there is none.
    level : float or None
        Drawn as a dotted line, such as 1 where a radius is the weight.
    """

    title: str
    values: Sequence[float]
    level: float | None = None


@styled
def to_one_scale(vehicles: Sequence[Vehicle], tilts: Sequence[float]) -> Figure:
    """Draw vehicles to one scale, each at a tilt (rad) of all its servos, with a bar of 0.5 m."""
    rows = math.ceil(len(vehicles) / _PER_ROW)
    figure, axes = new_figure(2.0 * rows + 0.2, rows, min(len(vehicles), _PER_ROW))
    reach = max(_reach(vehicle) for vehicle in vehicles)
    panels = axes.ravel()
    for panel in panels[len(vehicles) :]:
        panel.set_visible(False)
    for panel, vehicle, tilt in zip(panels, vehicles, tilts, strict=False):
        draw_vehicle(panel, vehicle, tilt)
        panel.set_xlim(-reach, reach)
        panel.set_ylim(-0.8 * reach, 0.8 * reach)
        panel.set_title(vehicle.name, pad=1.0)
        panel.text(0.5, 0.0, _described(vehicle), ha="center", va="top", transform=panel.transAxes)
    _draw_bar(panels[0], reach)
    return figure


@styled
def numbers_of_platforms(names: Sequence[str], columns: Sequence[Column]) -> Figure:
    """Draw the numbers of platforms, a row a platform and a panel a number."""
    figure, axes = new_figure(0.9 + _ROW * len(names), 1, len(columns), sharey=True)
    rows = np.arange(len(names))
    for panel, column in zip(axes[0], columns, strict=True):
        values = np.asarray(column.values, dtype=np.float64)
        panel.hlines(rows, 0.0, np.nan_to_num(values, posinf=0.0), color=GREY, linewidth=0.8)
        finite = np.isfinite(values)
        panel.plot(values[finite], rows[finite], **_DOT)
        if column.level is not None:
            panel.axvline(column.level, **LIMIT)
        for row in rows[~finite]:
            panel.text(0.0, row, " —", va="center", color=BLACK)
        panel.set_xlim(0.0, 1.15 * max(values[finite].max(initial=0.0), column.level or 0.0) or 1.0)
        panel.set_xlabel(column.title)
        panel.locator_params(axis="x", nbins=3)
        panel.grid(visible=False, axis="y")
    axes[0, 0].set_yticks(rows, names)
    axes[0, 0].set_ylim(len(names) - 0.5, -0.5)
    return figure


def _reach(vehicle: Vehicle) -> float:
    """Return how far from the centre of mass a drawing goes, m."""
    hubs = np.linalg.norm(vehicle.rotor_position, axis=1)
    return 1.02 * (float(hubs.max()) + propeller_radius(vehicle))


def _described(vehicle: Vehicle) -> str:
    servos = {0: "no servo", 1: "1 servo"}.get(vehicle.n_servos, f"{vehicle.n_servos} servos")
    return f"{vehicle.n_rotors} rotors, {servos}\n{number(vehicle.mass, 3)} kg"


def _draw_bar(panel: Axes, reach: float) -> None:
    left, low = -0.95 * reach, 0.72 * reach
    panel.plot([left, left + 0.5], [low, low], color=BLACK, linewidth=2.0, solid_capstyle="butt")
    panel.text(left, low, "0.5 m ", va="bottom", ha="left")
