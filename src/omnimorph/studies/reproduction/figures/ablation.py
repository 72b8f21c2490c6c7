"""What each part of a plant does to a flight: one row a condition, one column a measure."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.report.style import (
    BLUE,
    INTERLEAVED,
    VERMILLION,
    LineStyle,
    legend_above,
    new_figure,
    plain,
    styled,
)
from omnimorph.report.tables import number
from omnimorph.results.metrics import MEASURES
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.ablation import Ablation, Condition
from omnimorph.studies.reproduction.figures.line_styles import DASHED
from omnimorph.studies.reproduction.flights import CASES, A, B
from omnimorph.studies.reproduction.wording import FLIGHT_LABELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW = 0.18  # height of a row, inches: two dots above each other, letters of 8 pt
_APART = 0.4  # of the marks within a row
_LINE = 11.0  # of a number above a panel, points
_TICKS = 14.0  # of the ticks above a panel, points
_DOT: dict[str, Any] = {"linestyle": "none", "markersize": 4.2, "zorder": 4}
_LOST: dict[str, Any] = {"linestyle": "none", "markersize": 4.6, "markeredgewidth": 1.4}
_PAPER: dict[str, Any] = {"linewidth": 0.9, "zorder": 2}
_NEAR_END = 0.12  # of the width of a panel: labels of ticks so near its end turn inwards


@dataclass(frozen=True)
class AblationRow:
    """What was flown under one condition.

    Values, in the unit of the panel, are by measure and case, one a seed. One that is not finite is
    a flight that was lost; what is missing is not drawn.
    """

    label: str  # the condition, in a few words
    group: str  # the heading above it and its neighbours of the same group; "" for none
    values: Mapping[str, Mapping[str, Sequence[float]]]


@dataclass(frozen=True)
class AblationPanel:
    """One column of the figure."""

    measure: str  # which of the values of each row are drawn
    title: str  # what they are, with their unit; may have two lines
    logarithmic: bool = False  # all values are then positive
    paper: Mapping[str, float] = field(default_factory=dict)  # case -> what the paper reports


@styled
def ablation(
    rows: Sequence[AblationRow],
    panels: Sequence[AblationPanel],
    line_styles: Mapping[str, LineStyle],
) -> Figure:
    """Draw what was flown under many conditions: mean and range over the seeds, and lost flights.

    Parameters
    ----------
    rows : sequence of AblationRow
        From top to bottom; about 45 fill a page. Neighbours of one group stand under its name.
    panels : sequence of AblationPanel
        From left to right.
    line_styles : mapping of str to LineStyle
        Case -> how it is drawn: its colour and its mark.
    """
    levels, ticks, names = _places(rows)
    reported = max(len(panel.paper) for panel in panels)
    height = 1.4 + _ROW * (len(ticks) + 1)
    figure, axes = new_figure(height, 1, len(panels), sharey=True)
    for axis, panel in zip(axes[0], panels, strict=True):
        _shade(axis, levels)
        _limit(axis, panel, rows)
        for k, (case, line_style) in enumerate(line_styles.items()):
            ys = np.asarray(levels) + _APART * (k - 0.5 * (len(line_styles) - 1))
            _draw_case(axis, case, line_style, panel.measure, rows, ys)
        _draw_paper(axis, panel, line_styles)
        _name_ticks(axis)
        axis.set_xlabel(panel.title)
        axis.set_title(panel.title, fontsize=8.5, pad=_TICKS + 4.0 + _LINE * reported)
        axis.grid(visible=False, axis="y")
        axis.tick_params(axis="y", length=0.0)
    first = axes[0, 0]
    first.set_yticks(ticks, names)
    first.set_ylim(len(ticks) - 0.4, -0.6)
    headings = set(ticks) - set(levels)
    for tick, text in zip(ticks, first.get_yticklabels(), strict=True):
        text.set_fontweight("bold" if tick in headings else "normal")
    legend_above(figure, *_entries(rows, panels, line_styles))
    return figure


def _places(rows: Sequence[AblationRow]) -> tuple[list[int], list[int], list[str]]:
    """Return the level of every row, and all levels with their names, headings included."""
    levels: list[int] = []
    names: list[str] = []
    for group, members in itertools.groupby(rows, key=lambda row: row.group):
        names += [group] if group else []
        for row in members:
            levels.append(len(names))
            names.append(row.label)
    return levels, list(range(len(names))), names


def _shade(axis: Axes, levels: Sequence[int]) -> None:
    for level in levels[::2]:
        axis.axhspan(level - 0.5, level + 0.5, color="#f4f4f4", zorder=0, linewidth=0)


def _draw_case(
    axis: Axes,
    case: str,
    line_style: LineStyle,
    measure: str,
    rows: Sequence[AblationRow],
    ys: FloatArray,
) -> None:
    """Draw one case of a panel at the heights of its rows, few artists for all of them."""
    dots, ranges, lost = [], [], []
    for row, y in zip(rows, ys.tolist(), strict=True):
        values = np.asarray(row.values.get(measure, {}).get(case, ()), dtype=np.float64)
        flown = values[np.isfinite(values)]
        if len(flown):
            dots.append([flown.mean(), y])
            ranges += [[flown.min(), y], [flown.max(), y], [math.nan, y]]
        if len(flown) < len(values):
            lost.append([0.97, y])
    if dots:
        axis.plot(
            *np.transpose(ranges), color=line_style.colour, linewidth=2.6, alpha=0.4, zorder=3
        )
        axis.plot(*np.transpose(dots), line_style.mark, color=line_style.colour, **_DOT)
    if lost:
        edge: dict[str, Any] = {"transform": axis.get_yaxis_transform(), "zorder": 5}
        axis.plot(*np.transpose(lost), "x", color=line_style.colour, **_LOST, **edge)


def _limit(axis: Axes, panel: AblationPanel, rows: Sequence[AblationRow]) -> None:
    """Let an axis hold all finite values, with room at its right edge for lost flights."""
    cases = [row.values.get(panel.measure, {}) for row in rows]
    values = np.array(
        [*panel.paper.values(), *(v for one in cases for seeds in one.values() for v in seeds)],
        dtype=np.float64,
    )
    values = values[np.isfinite(values)]
    low, high = values.min(), values.max()
    if not panel.logarithmic:
        room = (high - low) or 1.0
        axis.set_xlim(low - 0.06 * room, high + 0.12 * room)
        axis.locator_params(axis="x", nbins=3)
        return
    decades = math.log10(high / low) or 1.0
    axis.set_xscale("log")
    axis.set_xlim(low * 10 ** (-0.06 * decades), high * 10 ** (0.12 * decades))
    _label_decades(axis, decades)


def _label_decades(axis: Axes, decades: float) -> None:
    """Name 1, 2 and 5 of each decade where there is room, and the decades alone where not."""
    from matplotlib.ticker import LogLocator

    parts = (1.0, 2.0, 5.0) if decades < 1.3 else (1.0, 3.0) if decades < 2.2 else (1.0,)
    axis.xaxis.set_major_locator(LogLocator(subs=parts))
    axis.xaxis.set_minor_formatter("")


def _name_ticks(axis: Axes) -> None:
    """Name the ticks below a panel and above it; no name reaches into the panel beside it."""
    low, high = axis.get_xlim()
    ticks = [tick for tick in axis.get_xticks() if low <= tick <= high]
    axis.tick_params(axis="x", which="both", top=True)
    axis.tick_params(axis="x", which="major", labeltop=True)
    axis.set_xticks(ticks, [plain(tick) for tick in ticks])
    for tick, place in zip(axis.xaxis.get_major_ticks(), ticks, strict=True):
        share = _share(axis, place)
        align = "left" if share < _NEAR_END else "right" if share > 1.0 - _NEAR_END else "center"
        for label in (tick.label1, tick.label2):
            label.set(horizontalalignment=align)


def _share(axis: Axes, value: float) -> float:
    """Return how far to the right in a panel a value lies, from 0 to 1."""
    return float(axis.transLimits.transform(axis.transScale.transform((value, 0.0)))[0])


def _draw_paper(axis: Axes, panel: AblationPanel, line_styles: Mapping[str, LineStyle]) -> None:
    """Draw the paper's values as lines, each with its number above the panel."""
    reported = [case for case in line_styles if case in panel.paper]
    for k, case in enumerate(reported):
        value, colour = panel.paper[case], line_styles[case].colour
        axis.axvline(value, color=colour, linestyle=INTERLEAVED[k % 2], **_PAPER)
        share = _share(axis, value)
        align = "left" if share < 0.2 else "right" if share > 0.8 else "center"
        at: dict[str, Any] = {"textcoords": "offset points", "ha": align, "va": "bottom"}
        up = _TICKS + 3.0 + _LINE * (len(reported) - 1 - k)
        across = axis.get_xaxis_transform()
        axis.annotate(number(value), (value, 1.0), (0.0, up), xycoords=across, color=colour, **at)


def _entries(
    rows: Sequence[AblationRow],
    panels: Sequence[AblationPanel],
    line_styles: Mapping[str, LineStyle],
) -> tuple[list[Any], list[str]]:
    """Return what the legend shows: the cases, the paper's values, and lost flights if any were."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], marker=line_style.mark, color=line_style.colour, **_DOT)
        for line_style in line_styles.values()
    ]
    labels = [f"{case}: mean and range" for case in line_styles]
    if any(panel.paper for panel in panels):
        handles.append(Line2D([], [], color="#444444", linestyle=INTERLEAVED[0], **_PAPER))
        labels.append("the paper's values")
    measured = [v for row in rows for cases in row.values.values() for v in cases.values()]
    if not all(np.isfinite(values).all() for values in measured):
        handles.append(Line2D([], [], marker="x", color="#444444", **_LOST))
        labels.append("lost flights")
    return handles, labels


# --- what the page shows --------------------------------------------------------------------------


def draw_ablation(found: Ablation) -> Figure:
    """Draw tilt, energy and errors of both cases, a row a condition."""
    reported = {
        metric: {
            FLIGHT_LABELS[claim.about["scenario"]]: claim.value
            for claim in paper.claims().values()
            if claim.about.get("metric") == metric
            and claim.about["scenario"] in CASES
            and claim.value is not None
        }
        for metric in ("drag_energy_paper", "position_error_mean_m", "attitude_error_paper")
    }
    panels = [
        AblationPanel(metric, title, logarithmic, reported.get(metric, {}))
        for metric, title, logarithmic in (
            ("tilt_mean_deg", "tilt,\nmean (°)", False),
            ("drag_energy_paper", "drag energy\n(“J”)", False),
            ("position_error_mean_m", "position error,\nmean (mm)", True),
            ("attitude_error_paper", "‖e_R‖,\nmean (–)", True),
        )
    ]
    rows = [
        AblationRow(one.label, one.group, {panel.measure: _by_case(one, panel) for panel in panels})
        for one in found.conditions
    ]
    line_styles = {
        FLIGHT_LABELS[A]: LineStyle(VERMILLION),
        FLIGHT_LABELS[B]: LineStyle(BLUE, DASHED, "s"),
    }
    return ablation(rows, panels, line_styles)


def _by_case(condition: Condition, panel: AblationPanel) -> dict[str, list[float]]:
    factor = MEASURES[panel.measure].factor
    return {
        FLIGHT_LABELS[name]: [factor * _value(one, panel.measure) for one in condition.flown[name]]
        for name in CASES
    }


def _value(flown: FlightResult, metric: str) -> float:
    return float(getattr(flown.metrics, metric)) if flown.completed else math.nan
