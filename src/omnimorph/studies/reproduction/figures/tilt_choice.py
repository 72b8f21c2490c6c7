"""Methods to choose the tilt set side by side: what they choose, what it costs, what it spends."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.report.figures import mark_time, tilt_panel
from omnimorph.report.style import (
    BLACK,
    INTERLEAVED,
    Flight,
    Look,
    legend_above,
    legend_entries,
    new_figure,
    plain,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["ChoiceEnergy", "CostGap", "cost_gaps", "energy_by_choice", "tilt_by_choice"]

_POINTS = 300
_BOUND: dict[str, Any] = {"linewidth": 0.9, "zorder": 1}
_WIDEST, _NARROWER = 3.4, 1.1  # of the first curve, and how much less the next ones, points


@dataclass(frozen=True)
class CostGap:
    """How much more than the best the chosen tilt costs.

    Attributes
    ----------
    label : str
        Which choice is set beside which best.
    look : Look
        Of its curve.
    gap : (K,) array
        One a control step: (cost − least cost) / least cost.
    """

    label: str
    look: Look
    gap: FloatArray


@dataclass(frozen=True)
class ChoiceEnergy:
    """Rotor drag energy of flights with one method to choose the tilt, in the paper's count.

    Attributes
    ----------
    label : str
        The method.
    energy : mapping of str to sequence of float
        Case -> one value a seed.
    """

    label: str
    energy: Mapping[str, Sequence[float]]


@styled
def tilt_by_choice(cases: Mapping[str, Sequence[Flight]]) -> Figure:
    """Draw the tilt (degrees) over time, one panel a case, one curve a method to choose it.

    Each curve is narrower than the one below it, so that both show where they coincide.
    """
    figure, axes = new_figure(0.8 + 1.9 * len(cases), len(cases), sharex=True)
    panels = axes[:, 0]
    for panel, (case, flights) in zip(panels, cases.items(), strict=True):
        widths = [max(_WIDEST - _NARROWER * k, 1.2) for k in range(len(flights))]
        looks = [replace(one.look, width=w) for one, w in zip(flights, widths, strict=True)]
        tilt_panel(panel, [replace(f, look=look) for f, look in zip(flights, looks, strict=True)])
        panel.set_ylabel(f"{case}\ntilt (°)")
    mark_time(panels, [flight for flights in cases.values() for flight in flights])
    legend_above(figure, *legend_entries(panels), columns=3)
    return figure


@styled
def cost_gaps(gaps: Sequence[CostGap], smallest: float = 1e-6) -> Figure:
    """Draw the share of control steps (%) whose cost gap exceeds a value (%), over that value.

    Parameters
    ----------
    gaps : sequence of CostGap
        One that never exceeds `smallest` has no curve; its label says so.
    smallest : float
        Gaps below this share of the cost are not distinguished.
    """
    figure, axes = new_figure(3.0)
    panel = axes[0, 0]
    for one in gaps:
        ordered = np.sort(one.gap)
        largest = float(ordered[-1])
        look: dict[str, Any] = {"color": one.look.colour, "linestyle": one.look.line}
        if largest <= smallest:
            panel.plot([], [], **look, label=f"{one.label}: none")
            continue
        x = np.geomspace(smallest, largest, _POINTS)[:-1]  # none exceeds the largest
        share = 1.0 - np.searchsorted(ordered, x, side="right") / len(ordered)
        panel.plot(100.0 * x, 100.0 * share, **look, label=one.label)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xlim(left=100.0 * smallest)
    panel.set_ylim(top=130.0)
    panel.yaxis.set_major_formatter(plain)
    panel.xaxis.set_major_formatter(plain)
    panel.set_xlabel("gap to the least cost (% of it)")
    panel.set_ylabel("control steps with a larger gap (%)")
    legend_above(figure, *legend_entries([panel]), columns=2)
    return figure


@styled
def energy_by_choice(
    rows: Sequence[ChoiceEnergy], least: Mapping[str, float], looks: Mapping[str, Look]
) -> Figure:
    """Draw rotor drag energy in the paper's count, one row a method: mean and range.

    Beside each mean is the energy relative to the lower bound.

    Parameters
    ----------
    rows : sequence of ChoiceEnergy
        From top to bottom.
    least : mapping of str to float
        Case -> the lower bound of the energy, drawn as a dashed line: one line, in black, for cases
        with the same bound.
    looks : mapping of str to Look
        Case -> its colour and its mark.
    """
    figure, axes = new_figure(0.85 + 0.42 * len(rows))
    panel = axes[0, 0]
    for i, row in enumerate(rows):
        for k, (case, look) in enumerate(looks.items()):
            level = i + 0.44 * (k - 0.5 * (len(looks) - 1))
            _draw_energy(panel, row.energy[case], level, look, least[case], case)
    for k, (value, cases) in enumerate(_by_value(least).items()):
        colour = looks[cases[0]].colour if len(cases) == 1 else BLACK
        words = f"lower bound, {' and '.join(cases)}"
        panel.axvline(value, color=colour, label=words, linestyle=INTERLEAVED[k % 2], **_BOUND)
    panel.set_yticks(range(len(rows)), [row.label for row in rows])
    panel.set_ylim(len(rows) - 0.5, -0.5)
    _make_room(
        panel, [*least.values(), *(v for r in rows for seeds in r.energy.values() for v in seeds)]
    )
    panel.grid(visible=False, axis="y")
    panel.set_xlabel("rotor drag energy in the paper's count, speeds in Hz (“J”; times 2π: joules)")
    legend_above(figure, *legend_entries([panel]), columns=2)
    return figure


def _by_value(numbers: Mapping[str, float]) -> dict[float, list[str]]:
    """Return the names that each number has; numbers identical to rounding are one."""
    found: dict[float, list[str]] = {}
    for name, value in numbers.items():
        same = next((one for one in found if math.isclose(one, value, rel_tol=1e-9)), value)
        found.setdefault(same, []).append(name)
    return found


def _make_room(panel: Axes, values: Sequence[float]) -> None:
    """Let the axis hold some values, with room for words to the right of each."""
    low, high = min(values), max(values)
    room = (high - low) or 1.0
    panel.set_xlim(low - 0.05 * room, high + 0.17 * room)


def _draw_energy(
    panel: Axes, values: Sequence[float], level: float, look: Look, least: float, case: str
) -> None:
    if not len(values):
        return  # all of its flights were lost
    mean, ends = float(np.mean(values)), [min(values), max(values)]
    panel.plot(ends, [level, level], color=look.colour, linewidth=4.0, alpha=0.4, zorder=2)
    mark: dict[str, Any] = {"linestyle": "none", "markersize": 5.0, "zorder": 4}
    panel.plot([mean], [level], look.mark, color=look.colour, label=f"{case}: mean, range", **mark)
    words = f"{100.0 * (mean / least - 1.0):+.1f} %".replace("-", "−")
    at: dict[str, Any] = {"textcoords": "offset points", "va": "center", "color": look.colour}
    panel.annotate(words, (ends[1], level), (7.0, 0.0), **at)
