"""The bench experiment: the force of one rotor while the others spin up around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from omnimorph.protocols import FloatArray
from omnimorph.report.figures import BANDS
from omnimorph.report.style import (
    BLUE,
    COLUMNS,
    LIMIT,
    VEIL,
    VERMILLION,
    Look,
    legend_above,
    legend_entries,
    new_figure,
    styled,
)
from omnimorph.report.tables import degrees
from omnimorph.results.thinning import band, thin
from omnimorph.units import from_SI

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Level", "StandSpeeds", "StandTest", "stand"]

_ALONE, _TOGETHER = Look(BLUE), Look(VERMILLION, (0, (5.0, 1.2)))


@dataclass(frozen=True)
class StandSpeeds:
    """How fast the rotors turned during every test, (K,) arrays.

    Attributes
    ----------
    time : array, s
        Evenly spaced.
    measured : array, rad/s
        Of the rotor on the force sensor.
    others : array, rad/s
        Of all others.
    """

    time: FloatArray
    measured: FloatArray
    others: FloatArray


@dataclass(frozen=True)
class Level:
    """A force (N) that someone else reports, and what it is in a few words."""

    force: float
    label: str


@dataclass(frozen=True)
class StandTest:
    """The force of the rotor on the sensor at one tilt, alone and among the others.

    Attributes
    ----------
    tilt : float, rad
        Of all rotors.
    time : (K,) array, s
        Evenly spaced.
    alone, together : (K,) arrays, N
        With the other rotors at rest, and with them spinning.
    levels : sequence of Level
        To compare with.
    """

    tilt: float
    time: FloatArray
    alone: FloatArray
    together: FloatArray
    levels: Sequence[Level] = ()


@styled
def stand(speeds: StandSpeeds, tests: Sequence[StandTest]) -> Figure:
    """Draw the speeds (Hz) over time and, below, the force (N) at each tilt to one scale.

    The force is drawn as a band from its smallest to its largest value in each short piece of time,
    with the mean as a line.
    """
    from matplotlib.gridspec import GridSpec

    figure = new_figure(5.0, 0)[0]
    grid = GridSpec(2, len(tests), figure=figure, height_ratios=[1.0, 1.5])
    top = figure.add_subplot(grid[0, :])
    _draw_speeds(top, speeds)
    panels: list[Axes] = []
    for i, test in enumerate(tests):
        shared = {"sharey": panels[0]} if panels else {}
        panel = figure.add_subplot(grid[1, i], **shared)
        _draw_test(panel, test, BANDS // len(tests))
        panel.set_title(f"tilt {degrees(test.tilt)}", loc="left")
        panel.tick_params(labelleft=i == 0)
        panels.append(panel)
    panels[0].locator_params(axis="y", nbins=6)  # whatever its height while it is laid out
    panels[0].set_ylabel("force of the rotor (N)")
    legend_above(figure, *legend_entries([top, *panels]))
    return figure


def _draw_speeds(panel: Axes, speeds: StandSpeeds) -> None:
    for values, look, label in (
        (speeds.measured, _ALONE, "rotor on the sensor; its force alone"),
        (speeds.others, _TOGETHER, "the other rotors; its force while they spin"),
    ):
        t, v = thin(speeds.time, from_SI(values, "Hz"), COLUMNS)
        panel.plot(t, v, color=look.colour, linestyle=look.line, label=label)
    panel.set_xlim(speeds.time[0], speeds.time[-1])
    panel.set_ylim(
        0.0, 1.08 * from_SI(float(max(speeds.measured.max(), speeds.others.max())), "Hz")
    )
    panel.set_ylabel("speed (Hz)")
    panel.set_xlabel("time (s)")


def _draw_test(panel: Axes, test: StandTest, columns: int) -> None:
    for values, look in ((test.alone, _ALONE), (test.together, _TOGETHER)):
        t, low, mean, high = band(test.time, values, columns)
        panel.fill_between(t, low, high, color=look.colour, alpha=0.25, linewidth=0)
        panel.plot(t, mean, color=look.colour, linestyle=look.line)
    for level in test.levels:
        panel.axhline(level.force, **LIMIT | {"color": "#222222", "zorder": 4})
        at: dict[str, Any] = {"textcoords": "offset points", "va": "bottom", "bbox": VEIL}
        across = panel.get_yaxis_transform()
        panel.annotate(level.label, (0.02, level.force), (0.0, 3.0), xycoords=across, **at)
    panel.set_xlim(test.time[0], test.time[-1])
    panel.set_xlabel("time (s)")
