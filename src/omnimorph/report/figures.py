"""The figures of a flight report, each a function from flights to a matplotlib figure.

All flights of a figure share one vehicle and one reference; the first one's are drawn. Noisy curves
are drawn as a band from the smallest to the largest value of each short piece of time, with the
mean as a line.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.report.style import (
    COLUMNS,
    LIMIT,
    SILVER,
    Flight,
    legend_above,
    legend_entries,
    new_figure,
    plain,
    styled,
)
from omnimorph.results import curves
from omnimorph.results.record import COLUMN
from omnimorph.results.thinning import band, thin

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TURN = 2.0 * math.pi
BANDS = 240
"""Pieces of time of a band: at 7 inches each is about 0.6 mm wide."""


@styled
def trajectory(flights: Sequence[Flight]) -> Figure:
    """Draw desired and flown position (m, in W) and rotation about x (degrees) over time."""
    figure, axes = new_figure(5.0, 4, sharex=True)
    panels = axes[:, 0]
    first = flights[0].run
    for i, name in enumerate("xyz"):
        _desired(panels[i], first.time, first.desired_p_WB[:, i])
        for flight in flights:
            _line(panels[i], flight, flight.run.p_WB[:, i])
        panels[i].set_ylabel(f"{name} (m)")
    _desired(panels[3], first.time, curves.rotation_about_x_deg(first.desired_R_WB))
    for flight in flights:
        _line(panels[3], flight, curves.rotation_about_x_deg(flight.run.R_WB))
    panels[3].set_ylabel("rotation\nabout x (°)")
    panels[3].set_yticks([0, 90, 180, 270, 360])
    for panel in panels[:3]:
        _widen(panel, 0.2)
    mark_time(panels, flights)
    legend_above(figure, *legend_entries(panels))
    return figure


@styled
def errors(
    flights: Sequence[Flight], means_elsewhere: Sequence[tuple[str, float, float, Any]] = ()
) -> Figure:
    """Draw position error (mm), geodesic attitude error (degrees) and the paper's ‖e_R‖ over time.

    Parameters
    ----------
    flights : sequence of Flight
        What was flown.
    means_elsewhere : sequence of (label, position error in mm, ‖e_R‖, Look)
        Means reported by someone else, drawn as level lines.
    """
    figure, axes = new_figure(5.4, 3, sharex=True)
    panels = axes[:, 0]
    for flight in flights:
        attitude = curves.attitude_error(flight.run)
        values = (curves.position_error_mm(flight.run), attitude.angle_deg, attitude.sine)
        for panel, value in zip(panels, values, strict=True):
            _band(panel, flight, value)
    for label, distance, sine, line_style in means_elsewhere:
        levels = (distance, math.degrees(math.asin(min(sine, 1.0))), sine)
        for panel, level in zip(panels, levels, strict=True):
            panel.axhline(level, color=line_style.colour, linestyle=(0, (1.2, 1.6)), label=label)
    for panel, name in zip(
        panels,
        ("position error (mm)", "attitude error (°)", "attitude error ‖e_R‖ (–)"),
        strict=True,
    ):
        panel.set_yscale("log")
        panel.yaxis.set_major_formatter(plain)
        panel.yaxis.set_minor_formatter("")
        panel.set_ylabel(name)
    _floors(panels, flights)
    mark_time(panels, flights)
    legend_above(figure, *legend_entries(panels))
    return figure


@styled
def tilt(flights: Sequence[Flight]) -> Figure:
    """Draw the actual tilt of every servo with the limits of the first one, degrees over time."""
    figure, axes = new_figure(2.6)
    tilt_panel(axes[0, 0], flights)
    mark_time([axes[0, 0]], flights)
    legend_above(figure, *legend_entries([axes[0, 0]]))
    return figure


def tilt_panel(panel: Axes, flights: Sequence[Flight]) -> None:
    """Draw the tilt of flights and its limits into a panel."""
    vehicle, column = flights[0].run.vehicle, COLUMN["tilt_actual"]
    for flight in flights:
        for servo in column.as_read(flight.run.tilt_actual).T:
            _line(panel, flight, servo)
    if vehicle.n_servos:
        low, high = (float(limits[0]) for limits in column.limits_of(vehicle))
        panel.axhline(low, **LIMIT)
        panel.axhline(high, **LIMIT, label="limits")
        room = 0.06 * (high - low)
        panel.set_yticks(np.linspace(low, high, 5))
        panel.set_ylim(low - room, high + room)
    panel.set_ylabel(f"tilt ({column.unit_read})")


@styled
def rotor_speeds(flights: Sequence[Flight]) -> Figure:
    """Draw the actual speed of every rotor (Hz, signed) with its limits, one panel a rotor."""
    vehicle, column = flights[0].run.vehicle, COLUMN["speed"]
    columns = 2 if vehicle.n_rotors > 1 else 1
    rows = -(-vehicle.n_rotors // columns)
    figure, axes = new_figure(0.5 + 1.25 * rows, rows, columns, sharex=True, sharey=True)
    panels = axes.T.ravel()  # down the left side first: one layer of rotors on each side
    low, high = column.limits_of(vehicle)
    for i, panel in enumerate(panels):
        if i >= vehicle.n_rotors:
            panel.set_visible(False)
            continue
        for flight in flights:
            _line(panel, flight, column.as_read(flight.run.speed[:, i]), COLUMNS // columns)
        panel.axhline(high[i], **LIMIT, label="limits")
        panel.axhline(low[i], **LIMIT)
        panel.set_title(_rotor_title(i, vehicle.rotor_position[i]), loc="left", pad=2.5)
    reach = 1.1 * max(float(high.max()), -float(low.min()))
    panels[0].set_ylim(min(-0.05 * reach, 1.1 * float(low.min())), reach)
    for panel in axes[:, 0]:
        panel.set_ylabel(f"speed ({column.unit_read})")
    mark_time(panels, flights, labels=False)
    for panel in axes[-1]:
        panel.set_xlabel("time (s)")
    legend_above(figure, *legend_entries(panels[:1]))
    return figure


@styled
def power_and_energy(flights: Sequence[Flight], others: Sequence[Flight] = ()) -> Figure:
    """Draw the rotor drag power (W) and the energy it took so far, in both counts, over time.

    `others` are flights of which the energy is drawn only.
    """
    figure, axes = new_figure(4.6, 2, sharex=True)
    power, energy = axes[:, 0]
    power_panel(power, flights)
    for flight in (*flights, *others):
        _line(energy, flight, 1e-3 * curves.drag_energy_J(flight.run), 200)
    energy.set_ylabel("rotor drag energy\nso far (kJ)")
    mark_time([power, energy], flights)
    energy.set_ylim(bottom=0.0)
    paper = energy.secondary_yaxis("right", functions=(_as_paper, _from_paper))
    paper.set_ylabel("in the paper's count,\nspeeds in Hz (“J”)")
    paper.spines["right"].set_visible(True)
    legend_above(figure, *legend_entries([power, energy]))
    return figure


def power_panel(panel: Axes, flights: Sequence[Flight]) -> None:
    """Draw the rotor drag power of flights into a panel."""
    for flight in flights:
        _band(panel, flight, flight.run.drag_power)
    panel.set_ylabel(f"rotor drag\npower ({COLUMN['drag_power'].unit_read})")
    panel.set_ylim(bottom=0.0)


def mark_time(panels: Sequence[Axes], flights: Sequence[Flight], *, labels: bool = True) -> None:
    """Set the time axis and mark the phases of the flight, named above the first panel."""
    end = max(float(flight.run.time[-1]) for flight in flights) or 1.0
    found = curves.phases(flights[0].run)
    for panel in panels:
        panel.set_xlim(0.0, end)
        panel.grid(visible=False, axis="x")
        for phase in found[1::2]:
            panel.axvspan(phase.begin, phase.end, color="#f3f3f3", zorder=0, linewidth=0)
    if not labels:
        return
    panels[-1].set_xlabel("time (s)")
    across = panels[0].get_xaxis_transform()
    style: dict[str, Any] = {"ha": "center", "va": "bottom", "fontsize": 8.0, "color": "#444444"}
    for phase in found:
        seen = min(phase.end, end) - phase.begin
        if seen > 0.04 * end:  # else there is no room for its name
            panels[0].text(phase.begin + 0.5 * seen, 1.02, phase.label, transform=across, **style)


# --- parts --------------------------------------------------------------------------------------


def _as_paper(kilojoules: FloatArray) -> FloatArray:
    return np.asarray(kilojoules) * 1e3 / _TURN


def _from_paper(count: FloatArray) -> FloatArray:
    return np.asarray(count) * 1e-3 * _TURN


def _desired(panel: Axes, time: FloatArray, values: FloatArray) -> None:
    t, v = thin(time, values, COLUMNS)
    panel.plot(t, v, color=SILVER, linewidth=4.0, label="desired", solid_capstyle="butt")


def _line(panel: Axes, flight: Flight, values: FloatArray, columns: int = COLUMNS) -> None:
    t, v = thin(flight.run.time, values, columns)
    line_style = flight.line_style
    style: dict[str, Any] = {"linestyle": line_style.line, "linewidth": line_style.width}
    panel.plot(t, v, color=line_style.colour, label=flight.label, **style)


def _band(panel: Axes, flight: Flight, values: FloatArray) -> None:
    """Draw a noisy curve: its range in each piece of time as a band, its mean as a line."""
    t, low, mean, high = band(flight.run.time, values, BANDS)
    line_style = flight.line_style
    panel.fill_between(t, low, high, color=line_style.colour, alpha=0.22, linewidth=0)
    panel.plot(t, mean, color=line_style.colour, linestyle=line_style.line, label=flight.label)


def _floors(panels: Sequence[Axes], flights: Sequence[Flight]) -> None:
    """End logarithmic axes below at what matters: a tenth of the smallest mean error."""
    metrics = [flight.run.metrics for flight in flights]
    means = (
        1e3 * min(m.position_error_mean_m for m in metrics),
        math.degrees(min(m.attitude_error_mean_rad for m in metrics)),
        min(m.attitude_error_paper for m in metrics),
    )
    for panel, mean in zip(panels, means, strict=True):
        if mean > 0:
            panel.set_ylim(bottom=mean / 10.0)


def _widen(panel: Axes, least: float) -> None:
    """Let an axis span at least `least`, so that a straight line does not show its noise only."""
    low, high = panel.get_ylim()
    if high - low < least:
        middle = 0.5 * (low + high)
        panel.set_ylim(middle - least / 2, middle + least / 2)


def _rotor_title(i: int, position: FloatArray) -> str:
    """Return a rotor's number and where it sits: the signs of its coordinates."""
    signs = ", ".join("+" if c > 1e-9 else "−" if c < -1e-9 else "0" for c in position)
    return f"rotor {i}  ({signs})"
