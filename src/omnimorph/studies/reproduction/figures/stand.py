"""The bench experiment: the force of one rotor while the others spin up around it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.report.figures import BANDS
from omnimorph.report.style import (
    BLUE,
    COLUMNS,
    LIMIT,
    VEIL,
    VERMILLION,
    LineStyle,
    legend_above,
    legend_entries,
    new_figure,
    styled,
)
from omnimorph.report.tables import degrees
from omnimorph.results.thinning import band, thin
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.interference import Experiment, StandTest
from omnimorph.units import from_SI

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ALONE, _TOGETHER = LineStyle(BLUE), LineStyle(VERMILLION, (0, (5.0, 1.2)))
_TURNING = 0.5  # s, when rotors that start from rest are at speed


@styled
def stand(experiment: Experiment) -> Figure:
    """Draw the speeds (Hz) over time and, below, the force (N) at each tilt to one scale.

    The force is drawn as a band from its smallest to its largest value in each short piece of time,
    with the mean as a line; beside it, dotted, what the paper reports.
    """
    from matplotlib.gridspec import GridSpec

    figure = new_figure(5.0, 0)[0]
    tests = experiment.tests
    grid = GridSpec(2, len(tests), figure=figure, height_ratios=[1.0, 1.5])
    top = figure.add_subplot(grid[0, :])
    _draw_speeds(top, experiment)
    panels: list[Axes] = []
    for i, (test, reported) in enumerate(zip(tests, _reported_forces(), strict=True)):
        shared = {"sharey": panels[0]} if panels else {}
        panel = figure.add_subplot(grid[1, i], **shared)
        _draw_test(panel, test, reported, BANDS // len(tests))
        panel.set_title(f"tilt {degrees(test.tilt)}", loc="left")
        panel.tick_params(labelleft=i == 0)
        panels.append(panel)
    panels[0].locator_params(axis="y", nbins=6)  # whatever its height while it is laid out
    panels[0].set_ylabel("force of the rotor (N)")
    legend_above(figure, *legend_entries([top, *panels]))
    return figure


def _reported_forces() -> tuple[dict[str, float], dict[str, float]]:
    """Return the forces that the paper reports at each tilt, N, by what is written there."""
    alone, together, loss = (
        paper.claims()[key].value for key in ("force_alone", "force_together", "loss_at_50")
    )
    assert alone is not None
    assert together is not None
    assert loss is not None
    left = alone * (1.0 - loss / 100.0)
    first = {f"the paper: {alone:g} N": alone}
    return (
        first | {f"the paper: {together:g} N": together},
        first | {f"the paper: {loss:g} % less": left},
    )


def _draw_speeds(panel: Axes, experiment: Experiment) -> None:
    """Draw the speeds of the first test; those of the others are the same."""
    reading = experiment.tests[0].together
    others = np.delete(reading.speed, experiment.rotor, axis=1).max(axis=1)
    measured = reading.speed[:, experiment.rotor]
    for values, line_style, label in (
        (measured, _ALONE, "rotor on the sensor; its force alone"),
        (others, _TOGETHER, "the other rotors; its force while they spin"),
    ):
        t, v = thin(reading.time, from_SI(values, "Hz"), COLUMNS)
        panel.plot(t, v, color=line_style.colour, linestyle=line_style.line, label=label)
    panel.set_xlim(reading.time[0], reading.time[-1])
    panel.set_ylim(0.0, 1.08 * from_SI(float(max(measured.max(), others.max())), "Hz"))
    panel.set_ylabel("speed (Hz)")
    panel.set_xlabel("time (s)")


def _draw_test(panel: Axes, test: StandTest, reported: dict[str, float], columns: int) -> None:
    turning = test.together.time >= _TURNING
    time = test.together.time[turning]
    for reading, line_style in ((test.alone, _ALONE), (test.together, _TOGETHER)):
        t, low, mean, high = band(time, reading.thrust[turning], columns)
        panel.fill_between(t, low, high, color=line_style.colour, alpha=0.25, linewidth=0)
        panel.plot(t, mean, color=line_style.colour, linestyle=line_style.line)
    for label, force in reported.items():
        panel.axhline(force, **LIMIT | {"color": "#222222", "zorder": 4})
        at: dict[str, Any] = {"textcoords": "offset points", "va": "bottom", "bbox": VEIL}
        across = panel.get_yaxis_transform()
        panel.annotate(label, (0.02, force), (0.0, 3.0), xycoords=across, **at)
    panel.set_xlim(time[0], time[-1])
    panel.set_xlabel("time (s)")
