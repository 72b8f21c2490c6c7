"""Methods to choose the tilt set side by side: what they choose, what it costs, what it spends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.report.figures import mark_time, tilt_panel
from omnimorph.report.style import (
    BLACK,
    INTERLEAVED,
    Flight,
    legend_above,
    legend_entries,
    new_figure,
    plain,
    styled,
)
from omnimorph.studies.reproduction.figures.line_styles import DASHED, LINE_STYLES, ORDER
from omnimorph.studies.reproduction.flights import CASES
from omnimorph.studies.reproduction.tilt_choice import WINDOW, Gap, TiltChoice
from omnimorph.studies.reproduction.wording import FLIGHT_LABELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_POINTS, _SMALLEST = 300, 1e-6  # of a curve; the least gap that is distinguished from none
_BOUND: dict[str, Any] = {"linewidth": 0.9, "zorder": 1}
_WIDEST, _NARROWER = 3.4, 1.1  # of the first curve, and how much less the next ones, points


@styled
def tilt_by_choice(found: TiltChoice) -> Figure:
    """Draw the tilt (degrees) over time, one panel a case, one curve a method to choose it.

    Each curve is narrower than the one below it, so that both show where they coincide. The one on
    top is the lower bound's.
    """
    figure, axes = new_figure(0.8 + 1.9 * len(CASES), len(CASES), sharex=True)
    panels, shown = axes[:, 0], []
    for panel, name in zip(panels, CASES, strict=True):
        flights = _flights(found, name)
        tilt_panel(panel, flights)
        panel.set_ylabel(f"{FLIGHT_LABELS[name]}\ntilt (°)")
        shown += flights
    mark_time(panels, shown)
    legend_above(figure, *legend_entries(panels), columns=3)
    return figure


def _flights(found: TiltChoice, name: str) -> list[Flight]:
    """Return a case's flights, one a method, and one at the tilts of the lower bound."""
    run = found.choices[0].runs[name]
    best = np.interp(run.time, found.lower_bound.time, found.lower_bound.tilt)
    bound = replace(run, tilt_actual=best[:, None])
    runs = [(one.label, one.runs[name]) for one in found.choices] + [("lower bound", bound)]
    line_styles = [*ORDER[1 : len(runs)], ORDER[0]]
    return [
        Flight(label, run, replace(line_style, width=max(_WIDEST - _NARROWER * k, 1.2)))
        for k, ((label, run), line_style) in enumerate(zip(runs, line_styles, strict=True))
    ]


@styled
def cost_gaps(gaps: Sequence[Gap]) -> Figure:
    """Draw the share of control steps (%) whose cost gap exceeds a value (%), over that value.

    One that never exceeds `_SMALLEST` has no curve; its label says so.
    """
    figure, axes = new_figure(3.0)
    panel = axes[0, 0]
    for one in gaps:
        ordered = np.sort(one.gap)
        largest = float(ordered[-1])
        line = "-" if one.span == WINDOW else DASHED
        options: dict[str, Any] = {"color": LINE_STYLES[one.scenario].colour, "linestyle": line}
        label = f"{FLIGHT_LABELS[one.scenario]}: to {one.span}"
        if largest <= _SMALLEST:
            panel.plot([], [], **options, label=f"{label}: none")
            continue
        x = np.geomspace(_SMALLEST, largest, _POINTS)[:-1]  # none exceeds the largest
        share = 1.0 - np.searchsorted(ordered, x, side="right") / len(ordered)
        panel.plot(100.0 * x, 100.0 * share, **options, label=label)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xlim(left=100.0 * _SMALLEST)
    panel.set_ylim(top=130.0)
    panel.yaxis.set_major_formatter(plain)
    panel.xaxis.set_major_formatter(plain)
    panel.set_xlabel("gap to the least cost (% of it)")
    panel.set_ylabel("control steps with a larger gap (%)")
    legend_above(figure, *legend_entries([panel]), columns=2)
    return figure


@styled
def energy_by_choice(found: TiltChoice) -> Figure:
    """Draw rotor drag energy in the paper's count, one row a method: mean and range.

    Beside each mean is the energy relative to the lower bound, which is drawn as a dashed line.
    """
    figure, axes = new_figure(0.85 + 0.42 * len(found.choices))
    panel = axes[0, 0]
    least = found.lower_bound.energy_paper
    shown = [least]
    for i, choice in enumerate(found.choices):
        for name, mark, aside in zip(CASES, "os", (-0.22, 0.22), strict=True):
            values = [
                one.metrics.drag_energy_paper
                for one in choice.flown[name]
                if one.metrics is not None and one.completed
            ]
            _draw_energy(panel, values, i + aside, mark, least, name)
            shown += values
    text = f"lower bound, {' and '.join(FLIGHT_LABELS[name] for name in CASES)}"
    panel.axvline(least, color=BLACK, label=text, linestyle=INTERLEAVED[0], **_BOUND)
    panel.set_yticks(range(len(found.choices)), [choice.label for choice in found.choices])
    panel.set_ylim(len(found.choices) - 0.5, -0.5)
    _make_room(panel, shown)
    panel.grid(visible=False, axis="y")
    panel.set_xlabel("rotor drag energy in the paper's count, speeds in Hz (“J”; times 2π: joules)")
    legend_above(figure, *legend_entries([panel]), columns=2)
    return figure


def _make_room(panel: Axes, values: Sequence[float]) -> None:
    """Let the axis hold some values, with room for words to the right of each."""
    low, high = min(values), max(values)
    room = (high - low) or 1.0
    panel.set_xlim(low - 0.05 * room, high + 0.17 * room)


def _draw_energy(
    panel: Axes, values: Sequence[float], level: float, mark: str, least: float, name: str
) -> None:
    if not len(values):
        return  # all of its flights were lost
    mean, ends = float(np.mean(values)), [min(values), max(values)]
    colour, label = LINE_STYLES[name].colour, f"{FLIGHT_LABELS[name]}: mean, range"
    panel.plot(ends, [level, level], color=colour, linewidth=4.0, alpha=0.4, zorder=2)
    dot: dict[str, Any] = {"linestyle": "none", "markersize": 5.0, "zorder": 4}
    panel.plot([mean], [level], mark, color=colour, label=label, **dot)
    text = f"{100.0 * (mean / least - 1.0):+.1f} %".replace("-", "−")
    at: dict[str, Any] = {"textcoords": "offset points", "va": "center", "color": colour}
    panel.annotate(text, (ends[1], level), (7.0, 0.0), **at)
