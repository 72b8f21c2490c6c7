"""The figures of an analysis over the attitude: hover power, best tilt; and the moments left.

Attitudes are drawn on two discs, as `attitudes` lays them out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from omnimorph.analysis.attitude_share import single_attitudes
from omnimorph.analysis.hover import hover_power
from omnimorph.analysis.overview import VehicleAnalysis
from omnimorph.analysis.polytope import Polytope
from omnimorph.protocols import FloatArray
from omnimorph.report.attitudes import (
    AttitudeGrid,
    attitude_grid,
    best_tilt_on,
    few_attitudes,
    grown,
    softened,
    weight_inside,
)
from omnimorph.report.polytope_drawing import (
    SphereLook,
    draw_polytope,
    picture_panel,
    set_legend,
    stage_for,
)
from omnimorph.report.style import GREY, PURPLE, VEIL, VERMILLION, WIDTH, new_figure, styled
from omnimorph.report.tables import number, tilt_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

_CANNOT = "#d2d2d2"
_FINE, _COARSE = 41, 31  # points along a side of the grid
_BEST_TILTS = 25
_ROW = 3.12  # height of a row of discs, inches


class Shades(NamedTuple):
    """Colours of a map, and the levels between them."""

    colours: ScalarMappable
    levels: FloatArray


# --- hover power --------------------------------------------------------------------------------


@styled
def hover_map(analysis: VehicleAnalysis) -> Figure:
    """Draw the least hover power (W) over the attitude at the tilt asked for; below, the best tilt.

    The best tilt (degrees) is that of least power within the limits; it is left out if the tilt
    cannot be varied. Grey is where it cannot hover. The attitudes of a degenerate set
    (line, plane), which have no area, are drawn as a line or as points.
    """
    low, high = analysis.limits
    rows = 2 if high > low else 1
    figure = new_figure(_ROW * rows, 0)[0]
    figure.set_layout_engine(None)
    _power_row(figure, analysis, _ROW * (rows - 1))
    if rows == 2:
        _best_tilt_row(figure, analysis, np.linspace(low, high, _BEST_TILTS))
    return figure


def _power_row(figure: Figure, analysis: VehicleAnalysis, bottom: float) -> None:
    vehicle, asked = analysis.vehicle, analysis.asked
    grid = attitude_grid(_FINE)
    up = grid.up.reshape(-1, 3)
    inside = weight_inside(vehicle, asked.force_zero, up)
    alone = single_attitudes(vehicle, asked.force_zero)
    power = hover_power(vehicle, asked.tilt, np.vstack([up, alone]))
    # a point of the grid may hit the one attitude of a flat set, which has no area
    power[: len(up)][np.isneginf(inside)] = np.inf
    tilt = tilt_text(asked.tilt)
    panels = _discs(figure, bottom, f"hover power at a tilt of {tilt}" if tilt else "hover power")
    finite = power[np.isfinite(power)]
    if not len(finite):
        panels[0].text(0.0, 0.0, "cannot hover", ha="center", va="center", zorder=7)
        return
    shades = _shades(finite, "viridis_r")
    values = np.where(np.isfinite(power), power, np.nan)
    _fill(panels, grid, values[: len(up)], inside, shades)
    dots = alone, values[len(up) :]
    if not len(alone):
        dots = few_attitudes(up, values)
    _draw_dots(panels, shades, *dots, " W")
    if len(dots[0]) not in (1, 2):
        _colour_bar(figure, shades, bottom, "least power to hover (W)")


def _best_tilt_row(figure: Figure, analysis: VehicleAnalysis, tilts: FloatArray) -> None:
    vehicle = analysis.vehicle
    grid = attitude_grid(_COARSE)
    up = grid.up.reshape(-1, 3)
    best = np.degrees(best_tilt_on(vehicle, tilts, up))
    panels = _discs(figure, 0.0, "best tilt in each attitude")
    finite = best[np.isfinite(best)]
    if not len(finite):
        panels[0].text(0.0, 0.0, "cannot hover", ha="center", va="center", zorder=7)
        return
    shades = _shades(finite, "YlGnBu")
    _fill(panels, grid, best, softened(grid, np.isfinite(best)), shades)
    dots = few_attitudes(up, best)
    _draw_dots(panels, shades, *dots, "°")
    if not len(dots[0]):
        _colour_bar(figure, shades, 0.0, "tilt of least power (°)")


def _draw_dots(
    panels: Sequence[Axes], shades: Shades, up: FloatArray, values: FloatArray, unit: str
) -> None:
    """Draw single attitudes; one or two with their numbers, more as the points of a line."""
    for panel, sign in zip(panels, (1.0, -1.0), strict=True):
        half = sign * up[:, 2] >= 0.0
        x, y = (up[half, :2] / np.sqrt(1.0 + np.abs(up[half, 2:]))).T
        size = 30.0 if len(up) < 3 else 5.0
        panel.scatter(x, y, c=shades.colours.to_rgba(values[half]), s=size, zorder=6)
        if len(up) < 3:
            for at, value in zip(np.column_stack([x, y]), values[half], strict=True):
                shown: dict[str, Any] = {"textcoords": "offset points", "zorder": 7}
                panel.annotate(f"{number(value, 3)}{unit}", tuple(at), (6.0, 3.0), **shown)


def _discs(figure: Figure, bottom: float, title: str) -> list[Axes]:
    """Return the two panels of a row, all grey, with rings at 30° and 60° from their middles."""
    from matplotlib.patches import Circle

    panels = []
    for k, text in enumerate(("upright: z up in the middle", "upside down: z down in the middle")):
        panel = picture_panel(figure, 0.1 + 2.95 * k, bottom + 0.28, 2.85, 2.55)
        panel.set_xlim(-1.285, 1.285)
        panel.set_ylim(-1.15, 1.15)
        panel.set_aspect("equal")
        panel.add_artist(Circle((0.0, 0.0), 1.0, facecolor=_CANNOT, zorder=0))
        panel.add_artist(Circle((0.0, 0.0), 1.0, fill=False, linewidth=0.9, zorder=5))
        for lean in (30.0, 60.0):
            rho = math.sqrt(2.0) * math.sin(math.radians(0.5 * lean))
            ring: dict[str, Any] = {"edgecolor": "white", "linewidth": 0.7, "alpha": 0.9}
            panel.add_artist(Circle((0.0, 0.0), rho, fill=False, zorder=4, **ring))
            aside = -rho * math.sqrt(0.5)
            shown = f"{lean if k == 0 else 180.0 - lean:g}°"
            panel.text(aside, aside, shown, ha="center", va="center", zorder=5, bbox=VEIL)
        for x, y, name, align in (
            (1.04, 0.0, "x", "left"),
            (-1.04, 0.0, "−x", "right"),
            (0.0, 1.08, "y", "center"),
            (0.0, -1.08, "−y", "center"),
        ):
            panel.text(x, y, name, ha=align, va="center", style="italic")
        panel.text(0.0, -1.17, text, ha="center", va="top")
        panels.append(panel)
    across, high = figure.get_size_inches()
    figure.text(0.08 / across, (bottom + 3.02) / high, title, fontsize=9.0, va="top")
    return panels


def _shades(values: FloatArray, colours: str) -> Shades:
    """Return about ten shades of colour over round numbers that hold some values."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm
    from matplotlib.ticker import MaxNLocator

    low, high = float(values.min()), float(values.max())
    if high - low <= 1e-6 * abs(high):
        low, high = 0.99 * low, 1.01 * high or 1.0
    levels = np.asarray(MaxNLocator(12, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high))
    cmap = colormaps[colours].resampled(len(levels) - 1)
    return Shades(ScalarMappable(BoundaryNorm(levels, cmap.N), cmap), levels)


def _fill(
    panels: Sequence[Axes],
    grid: AttitudeGrid,
    values: FloatArray,
    inside: FloatArray,
    shades: Shades,
) -> None:
    """Colour the discs by values, and grey where the weight is not inside the set of forces."""
    from matplotlib.patches import Circle

    levels = shades.levels
    edge = np.where(np.isfinite(inside), inside, np.nan)
    for panel, square, margin in zip(
        panels, grid.on_discs(values), grid.on_discs(edge), strict=True
    ):
        if not np.isfinite(square).any():
            continue
        full = np.clip(grown(square), levels[0], levels[-1])
        options: dict[str, Any] = {"cmap": shades.colours.cmap, "norm": shades.colours.norm}
        areas = [panel.contourf(grid.side, grid.side, full, levels=levels, zorder=1, **options)]
        areas[0].set_edgecolor("face")
        areas[0].set_linewidth(0.4)
        if np.nanmin(margin) < 0.0:
            bounds = [2.0 * np.nanmin(margin), 0.0]
            areas.append(
                panel.contourf(
                    grid.side, grid.side, margin, levels=bounds, colors=[_CANNOT], zorder=2
                )
            )
        for area in areas:
            area.set_clip_path(Circle((0.0, 0.0), 1.0, transform=panel.transData))


def _colour_bar(figure: Figure, shades: Shades, bottom: float, text: str) -> None:
    width, height = figure.get_size_inches()
    place = (6.12 / width, (bottom + 0.5) / height, 0.14 / width, 2.1 / height)
    bar = figure.colorbar(shades.colours, cax=figure.add_axes(place))
    bar.set_label(text)
    bar.ax.grid(visible=False)
    bar.outline.set_linewidth(0.6)


# --- moments ------------------------------------------------------------------------------------


@styled
def moments(analysis: VehicleAnalysis) -> Figure:
    """Draw the set of moments (N m, in B) while hovering level at the tilt asked for.

    Beside it how far it reaches about each axis. For a vehicle that can hover level there.
    """
    one = analysis.asked.moment
    stage = stage_for([one], [], "N m")
    wide = 3.3
    tall = min(max(wide * stage.slenderness, 1.9), 3.0)
    figure = new_figure(tall + 0.5, 0)[0]
    figure.set_layout_engine(None)
    sphere = SphereLook(one.inscribed_radius, VERMILLION, filled=True)
    picture = picture_panel(figure, 0.0, 0.3, wide, tall)
    draw_polytope(picture, one, stage, colour=PURPLE, spheres=[sphere])
    set_legend(figure, {"moments while hovering level": PURPLE}, [sphere])
    place = (4.35 / WIDTH, 0.75 / (tall + 0.5), 2.5 / WIDTH, (tall - 0.55) / (tall + 0.5))
    _reach_bars(figure.add_axes(place), one)
    return figure


def _reach_bars(panel: Axes, one: Polytope) -> None:
    for k, axis in enumerate(np.eye(3)):
        ends = [-one.reach(-axis), one.reach(axis)]
        panel.barh([k, k], ends, height=0.5, color=PURPLE, alpha=0.6)
        for end, align, shift in zip(ends, ("right", "left"), (-3.0, 3.0), strict=True):
            at: dict[str, Any] = {"textcoords": "offset points", "va": "center", "ha": align}
            panel.annotate(number(abs(end), 3), (end, k), (shift, 0.0), **at)
    if one.inscribed_radius > 0.0:
        for side in (-1.0, 1.0):
            panel.axvline(side * one.inscribed_radius, color=VERMILLION, linewidth=1.1)
    panel.axvline(0.0, color=GREY, linewidth=0.8)
    panel.set_yticks([0, 1, 2], ["roll, about x", "pitch, about y", "yaw, about z"])
    panel.set_ylim(2.6, -0.6)
    panel.margins(x=0.3)
    panel.grid(visible=False, axis="y")
    panel.set_xlabel("largest moment about the axis alone (N m)")
