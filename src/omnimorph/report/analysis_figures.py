"""The figures of an analysis over the tilt: force sets, radii, hover power, wakes, mass.

Each is a function from a `VehicleAnalysis` to a matplotlib figure. What cannot be done at a tilt
has no point there: a power or a condition number that is not finite leaves a gap.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.analysis.morphing import mass_break_even_of
from omnimorph.analysis.overview import Trade, VehicleAnalysis
from omnimorph.analysis.polytope import Polytope
from omnimorph.analysis.wrench_set import force_set
from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import FloatArray
from omnimorph.report.polytope_drawing import (
    SphereLook,
    Stage,
    draw_polytope,
    picture_panel,
    set_legend,
    stage_for,
)
from omnimorph.report.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    VEIL,
    VERMILLION,
    WIDTH,
    legend_above,
    legend_entries,
    new_figure,
    plain,
    styled,
)
from omnimorph.report.tables import degrees, number
from omnimorph.report.vehicle_drawing import draw_vehicle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PAPER_TILTS = (20.0, 30.0, 37.0)
"""Fixed tilts, in degrees, for which the paper weighs the mass of the mechanism."""

_WIDTH_OF_RANK = 0.14  # of a panel: words about ranks that are nearer would run together
_DASHED = (0, (4.0, 1.4))
_ZERO: dict[str, Any] = {"color": BLUE, "label": "radius at zero moment"}
_FREE: dict[str, Any] = {"color": GREEN, "linestyle": _DASHED, "label": "radius, moments free"}
_STILL: dict[str, Any] = {"color": BLUE, "label": "still air"}
_IN_WAKES: dict[str, Any] = {"color": VERMILLION, "linestyle": _DASHED, "label": "in the wakes"}
_OF_WEIGHT: dict[str, Any] = {"color": BLACK, "linewidth": 0.9, "linestyle": (0, (3.5, 2.0))}


# --- sets ---------------------------------------------------------------------------------------


@styled
def force_sets(analysis: VehicleAnalysis) -> Figure:
    """Draw the set of forces (N, in B) at zero moment at up to six tilts, all to one scale.

    Each with the vehicle above it, the weight sphere and the inscribed sphere. If the tilt
    cannot be varied, the one set, and beside it that with free moments.
    """
    tilts = shown_tilts(analysis)
    if len(tilts) == 1:
        return _both_sets(analysis, float(tilts[0]))
    return _sets_over_tilt(analysis, tilts)


def shown_tilts(analysis: VehicleAnalysis) -> FloatArray:
    """Return the tilts of `force_sets`, rad: six from limit to limit, or the only one there is."""
    low, high = analysis.limits
    return np.linspace(low, high, 6) if high > low else np.array([low])


def _sets_over_tilt(analysis: VehicleAnalysis, tilts: FloatArray) -> Figure:
    vehicle = analysis.vehicle
    sets = [force_set(vehicle, tilt, zero_moment=True) for tilt in tilts]
    stage = stage_for(sets, [analysis.weight], "N")
    slender = stage.slenderness
    columns = 6 if slender > 1.3 else 3
    width = WIDTH / columns
    heights = (min(0.74 * width, 1.1), min(slender * width, 2.8))
    block = sum(heights) + 0.5
    height = len(tilts) // columns * block + 0.28
    figure = new_figure(height, 0)[0]
    figure.set_layout_engine(None)  # pictures of a known size need none
    largest = max(one.inscribed_radius for one in sets)
    for k, (tilt, one) in enumerate(zip(tilts, sets, strict=True)):
        left, top = k % columns * width, height - 0.22 - k // columns * block
        above = picture_panel(figure, left, top - heights[0], width, heights[0])
        draw_vehicle(above, vehicle, tilt)
        above.set_title(f"tilt {degrees(tilt)}", pad=1.0)
        panel = picture_panel(figure, left, top - sum(heights), width, heights[1])
        _force_set(panel, one, stage, BLUE, analysis.weight, scale_bar=k == 0)
        label = f"radius {_alike(one.inscribed_radius, largest)} N"
        panel.text(0.5, -0.01, label, ha="center", va="top", transform=panel.transAxes)
    set_legend(figure, {"forces at zero moment": BLUE}, _spheres(largest, analysis.weight))
    return figure


def _alike(value: float, largest: float) -> str:
    """Return a number with as many decimals as give the largest of its kind three digits."""
    if value == 0.0:
        return "0"
    decimals = max(2 - math.floor(math.log10(largest)), 0) if largest > 0.0 else 0
    return f"{value:.{decimals}f}"


def _both_sets(analysis: VehicleAnalysis, tilt: float) -> Figure:
    vehicle = analysis.vehicle
    zero, free = (force_set(vehicle, tilt, zero_moment=held) for held in (True, False))
    stage = stage_for([zero, free], [analysis.weight], "N")
    widths = (1.6, 2.7, 2.7)
    tall = min(widths[1] * stage.slenderness, 3.2)
    figure = new_figure(tall + 0.65, 0)[0]
    figure.set_layout_engine(None)
    beside = picture_panel(figure, 0.0, 0.35, widths[0], tall)
    draw_vehicle(beside, vehicle, tilt)
    for k, (one, label, colour) in enumerate(
        ((zero, "at zero moment", BLUE), (free, "moments free", GREEN))
    ):
        panel = picture_panel(figure, widths[0] + k * widths[1], 0.35, widths[1], tall)
        _force_set(panel, one, stage, colour, analysis.weight, scale_bar=k == 0)
        panel.set_title(f"{label}: radius {number(one.inscribed_radius, 3)} N", pad=2.0)
    names = {"forces at zero moment": BLUE, "forces, moments free": GREEN}
    set_legend(figure, names, _spheres(free.inscribed_radius, analysis.weight))
    return figure


def _force_set(
    panel: Axes, one: Polytope, stage: Stage, colour: str, weight: float, *, scale_bar: bool
) -> None:
    spheres = _spheres(one.inscribed_radius, weight)
    draw_polytope(panel, one, stage, colour=colour, spheres=spheres, scale_bar=scale_bar)


def _spheres(radius: float, weight: float) -> list[SphereLook]:
    return [SphereLook(radius, VERMILLION, filled=True), SphereLook(weight, BLACK, filled=False)]


# --- curves over the tilt -----------------------------------------------------------------------


@styled
def radius_over_tilt(analysis: VehicleAnalysis) -> Figure:
    """Draw both inscribed radii (N) over the tilt (degrees) beside the weight.

    Above them the tilts at which every attitude can hover, as bars: strong within the limits of the
    servos, pale beyond. Along the bottom the tilts at which the rank of A falls.
    """
    sweep = analysis.sweep
    anywhere = analysis.omnidirectional
    with_bars = len(anywhere.free_moment_beyond) + len(anywhere.zero_moment_beyond) > 0
    if with_bars:
        figure, axes = new_figure(3.5, 2, sharex=True, gridspec_kw={"height_ratios": [0.2, 1.0]})
        _omnidirectional_bars(axes[0, 0], analysis)
    else:
        figure, axes = new_figure(2.9)
    panel = axes[-1, 0]
    _line(panel, sweep.tilt, sweep.radius_zero_moment, _ZERO)
    _line(panel, sweep.tilt, sweep.radius_free_moment, _FREE)  # dashed: shows the one below
    panel.axhline(analysis.weight, **_OF_WEIGHT)
    panel.annotate(
        f"weight, {number(analysis.weight)} N",
        (0.006, analysis.weight),
        (0.0, 3.0),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
    )
    panel.set_ylim(0.0, 1.12 * max(analysis.weight, float(sweep.radius_free_moment.max())))
    panel.set_ylabel("inscribed radius (N)")
    _mark_ranks(panel, analysis)
    _mark_limits([*axes[:, 0]], analysis)
    legend_above(figure, *legend_entries([panel]))
    return figure


def _omnidirectional_bars(panel: Axes, analysis: VehicleAnalysis) -> None:
    found = analysis.omnidirectional
    low, high = math.degrees(analysis.sweep.tilt[0]), math.degrees(analysis.sweep.tilt[-1])
    rows = (
        (0.0, found.zero_moment_beyond, found.zero_moment, BLUE),
        (1.0, found.free_moment_beyond, found.free_moment, GREEN),
    )
    for level, beyond, within, colour in rows:
        for intervals, alpha in ((beyond, 0.3), (within, 1.0)):
            for begin, end in np.degrees(intervals):
                bar = [max(begin, low), min(end, high)]
                if bar[0] < bar[1]:
                    bar_look: dict[str, Any] = {
                        "color": colour,
                        "alpha": alpha,
                        "solid_capstyle": "butt",
                    }
                    panel.plot(bar, [level, level], linewidth=5.0, **bar_look)
        seen = [bar for bar in np.degrees(beyond).tolist() if bar[0] < high and bar[1] > low]
        for begin, end in seen if len(seen) < 3 else []:  # more numbers would run together
            for angle, side, align in ((begin, -4.0, "right"), (end, 4.0, "left")):
                if low < angle < high:
                    at: dict[str, Any] = {
                        "textcoords": "offset points",
                        "va": "center",
                        "ha": align,
                    }
                    panel.annotate(
                        f"{angle:.2f}°".replace("-", "−"), (angle, level), (side, 0.0), **at
                    )
    panel.set_yticks([0.0, 1.0], ["zero moment", "moments free"])
    panel.set_ylim(-0.7, 1.7)
    panel.tick_params(bottom=False, labelbottom=False, left=False)
    panel.grid(visible=False, axis="y")
    panel.spines[["left", "bottom"]].set_visible(False)
    panel.set_title("omnidirectional", loc="left")


def _mark_ranks(panel: Axes, analysis: VehicleAnalysis) -> None:
    """Mark where the rank of A falls; of tilts that are near one another every other one higher."""
    first, last = analysis.sweep.tilt[0], analysis.sweep.tilt[-1]
    shown = [one for one in analysis.singular if first - 1e-6 <= one.tilt <= last + 1e-6]
    before, raised = -math.inf, True
    for one in sorted(shown, key=lambda one: one.tilt):
        share = (one.tilt - first) / (last - first)
        raised = not raised and share - before < _WIDTH_OF_RANK
        _tick(panel, one.tilt, share, f"rank {one.rank}", 16.0 if raised else 5.0)
        before = share


def _tick(panel: Axes, tilt: float, share: float, label: str, up: float) -> None:
    """Mark a tilt, at a share of the width, at the bottom of a panel; the words keep inside."""
    align = "left" if share < 0.08 else "right" if share > 0.92 else "center"
    angle = math.degrees(tilt)
    mark: dict[str, Any] = {"marker": "^", "color": BLACK, "markersize": 4.5, "clip_on": False}
    panel.plot([angle], [0.0], linestyle="none", zorder=5, **mark)
    shift = {"left": 17.0, "right": -17.0, "center": 0.0}[align]
    at: dict[str, Any] = {"textcoords": "offset points", "ha": align, "bbox": VEIL}
    panel.annotate(label, (angle, 0.0), (shift, up), **at)


@styled
def level_hover(analysis: VehicleAnalysis) -> Figure:
    """Draw over the tilt (degrees): the power of hovering level (W), and the condition number of A.

    The power in still air and, for rotors in line, in one another's wakes. A panel without any
    finite number is left out; there must be one.
    """
    sweep, wakes_too = analysis.sweep, analysis.wakes
    with_power = bool(np.isfinite(sweep.level_power).any())
    with_condition = bool(np.isfinite(sweep.condition_number).any())
    count = int(with_power) + int(with_condition)
    figure, axes = new_figure(2.7, 1, count)
    panels = list(axes[0])
    if with_power:
        alone = {"color": BLUE}  # a curve that has its panel for itself needs no name
        _line(panels[0], sweep.tilt, sweep.level_power, alone if wakes_too is None else _STILL)
        if wakes_too is not None:
            _line(panels[0], wakes_too.tilt, wakes_too.power, _IN_WAKES)
        panels[0].set_ylabel("power to hover level (W)")
        panels[0].set_ylim(bottom=0.0)
    if with_condition:
        conditions = np.where(np.isfinite(sweep.condition_number), sweep.condition_number, np.nan)
        panel = panels[-1]
        _line(panel, sweep.tilt, conditions, {"color": BLACK})
        best = float(np.nanmin(conditions))
        panel.set_yscale("log")
        panel.set_ylim(0.8 * best, min(1.3 * float(np.nanmax(conditions)), 300.0 * best))
        panel.yaxis.set_major_formatter(plain)
        panel.yaxis.set_minor_formatter("")
        panel.set_ylabel("condition number of A (–)")
    _mark_limits(panels, analysis)
    entries = legend_entries(panels)
    if entries[0]:
        legend_above(figure, *entries)
    return figure


@styled
def wakes(analysis: VehicleAnalysis) -> Figure:
    """Draw what wakes cost over the tilt (degrees): power ratio (–), and the radius left (N).

    For a vehicle with rotors in line, whose tilt can be varied. The first panel is left out if it
    cannot hover level at any tilt.
    """
    effect = analysis.wakes
    assert effect is not None
    with np.errstate(invalid="ignore"):
        ratio = effect.power / effect.power_still
    with_power = bool(np.isfinite(ratio).any())
    figure, axes = new_figure(2.7, 1, 2 if with_power else 1)
    left, right = axes[0, 0], axes[0, -1]
    if with_power:
        _line(left, effect.tilt, ratio, {"color": VERMILLION})
        left.axhline(1.0, color=GREY, linewidth=0.9)
        left.set_ylabel("power to hover level,\nin the wakes over still air (–)")
    kept = _IN_WAKES | {"label": "left for certain in the wakes"}
    _line(right, effect.tilt, effect.radius_still, _STILL)
    _line(right, effect.tilt, effect.radius, kept)
    right.axhline(analysis.weight, **_OF_WEIGHT, label="weight")
    right.set_ylim(bottom=0.0)
    right.set_ylabel("inscribed radius\nat zero moment (N)")
    for panel in axes[0]:
        panel.set_xlabel("tilt (°)")
        panel.set_xlim(*np.degrees(effect.tilt[[0, -1]]))
    legend_above(figure, *legend_entries([right]), where="outside upper right")
    return figure


def _line(panel: Axes, tilt: FloatArray, values: FloatArray, options: dict[str, Any]) -> None:
    panel.plot(np.degrees(tilt), np.where(np.isfinite(values), values, np.nan), **options)


def _mark_limits(panels: Sequence[Axes], analysis: VehicleAnalysis) -> None:
    """Shade the tilts that the servos cannot reach; name the axis of the last row."""
    first, last = (math.degrees(tilt) for tilt in analysis.sweep.tilt[[0, -1]])
    limit = math.degrees(analysis.limits[1])
    for panel in panels:
        panel.set_xlim(first, last)
        if last > limit + 1e-6:
            panel.axvspan(limit, last, color="#ebebeb", zorder=0, label="beyond the limit")
        place = panel.get_subplotspec()
        if place is None or place.is_last_row():
            panel.set_xlabel("tilt (°)")


# --- mass ---------------------------------------------------------------------------------------


@styled
def mass_break_even(analysis: VehicleAnalysis) -> Figure:
    """Draw the relative mass (%) of a mechanism that just pays over the tilt (°) of the other.

    With the values at the tilts that the paper names, and this vehicle's own mechanism if its mass
    is known.
    """
    trade = analysis.trade
    assert trade is not None
    figure, axes = new_figure(3.2)
    panel = axes[0, 0]
    _line(panel, trade.tilt_fixed, 100.0 * trade.share, _STILL)
    if analysis.wakes is not None:
        _line(panel, trade.tilt_fixed, 100.0 * trade.share_in_wakes, _IN_WAKES)
    _mark_paper_tilts(panel, analysis.vehicle, trade)
    if trade.own is not None:
        _mark_own(panel, trade, trade.own)
    panel.set_xlim(*np.degrees(trade.tilt_fixed[[0, -1]]))
    panel.set_xlabel("tilt of the vehicle without a mechanism (°)")
    panel.set_ylabel("mass of a mechanism that just\npays (% of the mass of the rest)")
    legend_above(figure, *legend_entries([panel]))
    return figure


def _mark_paper_tilts(panel: Axes, vehicle: Vehicle, trade: Trade) -> None:
    shares = 100.0 * mass_break_even_of(vehicle, np.radians(PAPER_TILTS))
    for tilt, share in zip(PAPER_TILTS, shares, strict=True):
        if math.isfinite(share):
            panel.plot([tilt], [share], "o", color=BLUE, markersize=4.0)
            label = f"{number(share, 3)} % at {tilt:g}°"
            at: dict[str, Any] = {"textcoords": "offset points", "ha": "right"}
            panel.annotate(label, (tilt, share), (-5.0, 6.0), color=BLUE, **at)


def _mark_own(panel: Axes, trade: Trade, own: float) -> None:
    panel.axhline(100.0 * own, **_OF_WEIGHT)
    panel.annotate(
        f"its own, {number(100.0 * own, 3)} %",
        (0.994, 100.0 * own),
        (0.0, 3.0),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        ha="right",
    )
    before = -math.inf
    for tilt, colour in ((trade.break_even, BLUE), (trade.break_even_in_wakes, VERMILLION)):
        if tilt is not None and tilt <= trade.tilt_fixed[-1]:
            angle = math.degrees(tilt)
            panel.plot([angle], [100.0 * own], "D", color=colour, markersize=5.0, zorder=5)
            at: dict[str, Any] = {"textcoords": "offset points", "va": "top", "bbox": VEIL}
            down = -16.0 if angle - before < 4.0 else -5.0
            panel.annotate(f"{angle:.1f}°", (angle, 100.0 * own), (4.0, down), color=colour, **at)
            before = angle
