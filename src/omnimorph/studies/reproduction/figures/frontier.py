"""How much thrust may be lost before flights are: shares that survive, with their uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.report.style import (
    LIMIT,
    VEIL,
    Look,
    legend_above,
    legend_entries,
    new_figure,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["FrontierPanel", "PhysicalLimit", "Survival", "frontier"]

_APART = 1.4  # of neighbouring curves, points


@dataclass(frozen=True)
class Survival:
    """The share of flights that survive, over something: (K,) arrays.

    Attributes
    ----------
    label : str
        What was flown.
    look : Look
        Of its curve and its marks.
    over : array
        The thrust that is lost, as a share from 0 to 1; or the number of the dead rotor, from 0.
    share : array
        Of the flights that survive, from 0 to 1.
    low, high : array
        Ends of its confidence interval.
    """

    label: str
    look: Look
    over: FloatArray
    share: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True)
class PhysicalLimit:
    """The loss, a share from 0 to 1, beyond which no controller could fly, and its name."""

    loss: float
    label: str


@dataclass(frozen=True)
class FrontierPanel:
    """One kind of loss.

    Attributes
    ----------
    title : str
        Which rotors lose thrust.
    curves : sequence of Survival
        Over the share of the thrust that is lost.
    limits : sequence of PhysicalLimit
        Drawn as dotted lines.
    """

    title: str
    curves: Sequence[Survival]
    limits: Sequence[PhysicalLimit] = ()


@styled
def frontier(panels: Sequence[FrontierPanel], dead_rotor: Sequence[Survival] = ()) -> Figure:
    """Draw the share of flights that survive (%) over the thrust lost (%), a panel a kind of loss.

    Panels stand in rows of two. Marks are where flights were flown, bars their confidence
    intervals. Curves are set a little apart, up and to the right, so that none hides another.
    Below, if it was flown, the share that survives the death of one rotor, for each.
    """
    from matplotlib.gridspec import GridSpec

    columns, rows = min(len(panels), 2), -(-len(panels) // 2)
    heights = rows * [1.6] + ([1.0] if dead_rotor else [])
    figure = new_figure(0.6 + 1.7 * sum(heights), 0)[0]
    grid = GridSpec(len(heights), columns, figure=figure, height_ratios=heights)
    drawn: list[Axes] = []
    for i, panel in enumerate(panels):
        axis = figure.add_subplot(grid[i // 2, i % 2])
        _draw_panel(axis, panel)
        axis.tick_params(labelleft=i % 2 == 0)
        drawn.append(axis)
    if dead_rotor:
        drawn.append(figure.add_subplot(grid[-1, :]))
        _draw_dead_rotor(drawn[-1], dead_rotor)
    for axis in drawn:
        axis.set_ylim(-5.0, 105.0)
        axis.set_yticks([0, 25, 50, 75, 100])
    for axis in (*drawn[: len(panels) : 2], *drawn[len(panels) :]):
        axis.set_ylabel("share of flights (%)")
    legend_above(figure, *legend_entries(drawn), columns=2)
    return figure


def _draw_panel(axis: Axes, panel: FrontierPanel) -> None:
    for k, curve in enumerate(panel.curves):
        lost = 100.0 * np.asarray(curve.over)
        apart = _APART * (k - 0.5 * (len(panel.curves) - 1))
        _draw_survival(axis, curve, lost, linestyle=curve.look.line, apart=apart)
    last = max((limit.loss for limit in panel.limits), default=0.0)
    for limit in panel.limits:
        axis.axvline(100.0 * limit.loss, **LIMIT)
        side, align = (2.0, "left") if limit.loss == last else (-2.0, "right")
        words: dict[str, Any] = {"rotation": 90.0, "ha": align, "va": "center", "bbox": VEIL}
        at: dict[str, Any] = {"textcoords": "offset points", "xycoords": ("data", "axes fraction")}
        axis.annotate(limit.label, (100.0 * limit.loss, 0.5), (side, 0.0), **words, **at)
    shown = [*(x for one in panel.curves for x in one.over), *(one.loss for one in panel.limits)]
    low, high = min(shown, default=0.0), max(shown, default=1.0)
    room = 0.08 * ((high - low) or 1.0)
    axis.set_xlim(100.0 * (low - room), 100.0 * (high + room))
    axis.set_title(panel.title, loc="left")
    axis.set_xlabel("thrust lost (%)")


def _draw_dead_rotor(axis: Axes, dead_rotor: Sequence[Survival]) -> None:
    """Draw what was flown side by side for each rotor, as points without a curve."""
    apart = 0.6 / len(dead_rotor)
    for k, one in enumerate(dead_rotor):
        beside = apart * (k - 0.5 * (len(dead_rotor) - 1))
        _draw_survival(axis, one, np.asarray(one.over) + beside, linestyle="none")
    rotors = sorted({int(rotor) for one in dead_rotor for rotor in one.over})
    axis.set_xticks(rotors)
    axis.set_xlim(rotors[0] - 0.6, rotors[-1] + 0.6)
    axis.grid(visible=False, axis="x")
    axis.set_title("one rotor dead", loc="left")
    axis.set_xlabel("dead rotor (number)")


def _draw_survival(
    axis: Axes, one: Survival, x: FloatArray, *, linestyle: Any, apart: float = 0.0
) -> None:
    """Draw shares over x, all of it moved up and to the right by `apart` points."""
    from matplotlib.transforms import offset_copy

    figure = axis.get_figure(root=True)
    moved = offset_copy(axis.transData, figure, apart, apart, units="points")
    share, low, high = (100.0 * np.asarray(value) for value in (one.share, one.low, one.high))
    axis.errorbar(
        x,
        share,
        yerr=np.maximum([share - low, high - share], 0.0),  # rounding may cross the ends
        color=one.look.colour,
        linestyle=linestyle,
        marker=one.look.mark,
        markersize=4.2,
        elinewidth=0.8,
        label=one.label,
        transform=moved,
    )
