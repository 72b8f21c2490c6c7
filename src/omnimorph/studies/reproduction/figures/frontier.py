"""How much thrust may be lost before flights are: shares that survive, with their uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.report.style import (
    LIMIT,
    VEIL,
    LineStyle,
    legend_above,
    legend_entries,
    new_figure,
    styled,
)
from omnimorph.studies.reproduction.degraded import Degraded
from omnimorph.studies.reproduction.figures.line_styles import DASHED, LINE_STYLES
from omnimorph.studies.reproduction.frontier import Frontier
from omnimorph.studies.reproduction.lost_thrust import KINDS, NOT_LOST, POSE_KEPT, Share
from omnimorph.studies.reproduction.spread import share_interval
from omnimorph.studies.reproduction.wording import FLIGHT_LABELS
from omnimorph.units import from_SI

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_APART = 1.4  # of neighbouring curves, points


@styled
def frontier(degraded: Degraded) -> Figure:
    """Draw the share of flights that survive (%) over the thrust lost (%).

    A row is a kind of loss, a column a criterion. Marks are where flights were flown, bars their
    confidence intervals. Curves are set a little apart, up and to the right, so that none hides
    another. Below, if it was flown, the share that survives the death of one rotor, for each.
    """
    from matplotlib.gridspec import GridSpec

    heights = len(KINDS) * [1.6] + ([1.0] if degraded.dead else [])
    figure = new_figure(0.6 + 1.7 * sum(heights), 0)[0]
    grid = GridSpec(len(heights), 2, figure=figure, height_ratios=heights)
    drawn: list[Axes] = []
    for i, kind in enumerate(KINDS):
        for j, criterion in enumerate((NOT_LOST, POSE_KEPT)):
            axis = figure.add_subplot(grid[i, j])
            _draw_panel(
                axis, [o for o in degraded.frontiers if (o.kind, o.criterion) == (kind, criterion)]
            )
            axis.set_title(f"{kind}: {criterion}", loc="left")
            axis.tick_params(labelleft=j == 0)
            drawn.append(axis)
    left = drawn[::2]
    if degraded.dead:
        drawn.append(figure.add_subplot(grid[-1, :]))
        left.append(drawn[-1])
        _draw_dead_rotor(drawn[-1], degraded)
    for axis in drawn:
        axis.set_ylim(-5.0, 105.0)
        axis.set_yticks([0, 25, 50, 75, 100])
    for axis in left:
        axis.set_ylabel("share of flights (%)")
    legend_above(figure, *legend_entries(drawn), columns=2)
    return figure


def _draw_panel(axis: Axes, found: Sequence[Frontier]) -> None:
    for k, one in enumerate(found):
        losses, speed = sorted(one.survived), from_SI(one.speed_limit, "Hz")
        _draw_shares(
            axis,
            100.0 * np.array(losses),
            [one.survived[loss] for loss in losses],
            f"{FLIGHT_LABELS[one.scenario]}, ±{speed:.0f} Hz",
            LineStyle(LINE_STYLES[one.scenario].colour, "-" if speed < 200.0 else DASHED),
            apart=_APART * (k - 0.5 * (len(found) - 1)),
        )
    limits = {one.speed_limit: one.physical_limit for one in found}
    last = max(limits.values(), default=0.0)
    for speed, loss in limits.items():
        axis.axvline(100.0 * loss, **LIMIT)
        side, align = (2.0, "left") if loss == last else (-2.0, "right")
        text: dict[str, Any] = {"rotation": 90.0, "ha": align, "va": "center", "bbox": VEIL}
        at: dict[str, Any] = {"textcoords": "offset points", "xycoords": ("data", "axes fraction")}
        label = f"±{from_SI(speed, 'Hz'):.0f} Hz"
        axis.annotate(label, (100.0 * loss, 0.5), (side, 0.0), **text, **at)
    shown = [*(loss for one in found for loss in one.survived), *limits.values()]
    low, high = min(shown, default=0.0), max(shown, default=1.0)
    room = 0.08 * ((high - low) or 1.0)
    axis.set_xlim(100.0 * (low - room), 100.0 * (high + room))
    axis.set_xlabel("thrust lost (%)")


def _draw_dead_rotor(axis: Axes, degraded: Degraded) -> None:
    """Draw what was flown side by side for each rotor, as points without a curve."""
    count = len(degraded.dead)
    for k, ((name, criterion), shares) in enumerate(degraded.dead.items()):
        beside = 0.6 / count * (k - 0.5 * (count - 1))
        line_style = LineStyle(
            LINE_STYLES[name].colour, "none", "o" if criterion == NOT_LOST else "D"
        )
        label = f"{FLIGHT_LABELS[name]}, {criterion}"
        _draw_shares(axis, np.arange(float(len(shares))) + beside, shares, label, line_style)
    rotors = len(next(iter(degraded.dead.values())))
    axis.set_xticks(range(rotors))
    axis.set_xlim(-0.6, rotors - 0.4)
    axis.grid(visible=False, axis="x")
    axis.set_title("one rotor dead", loc="left")
    axis.set_xlabel("dead rotor (number)")


def _draw_shares(
    axis: Axes,
    x: FloatArray,
    shares: Sequence[Share],
    label: str,
    line_style: LineStyle,
    *,
    apart: float = 0.0,
) -> None:
    """Draw shares over x, all of it moved up and to the right by `apart` points."""
    from matplotlib.transforms import offset_copy

    figure = axis.get_figure(root=True)
    moved = offset_copy(axis.transData, figure, apart, apart, units="points")
    share = np.array([100.0 * met / flown for met, flown in shares])
    low, high = 100.0 * np.array([share_interval(*one) for one in shares]).T
    axis.errorbar(
        x,
        share,
        yerr=np.maximum([share - low, high - share], 0.0),  # rounding may cross the ends
        color=line_style.colour,
        linestyle=line_style.line,
        marker=line_style.mark,
        markersize=4.2,
        elinewidth=0.8,
        label=label,
        transform=moved,
    )
