"""The plots beside a flight: errors, tilt, rotor speeds with their limits, power; and now."""

from __future__ import annotations

import html
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.results.columns import Column
from omnimorph.results.logged import as_columns
from omnimorph.results.record import COLUMN, COLUMNS
from omnimorph.results.thinning import envelope
from omnimorph.viewer import colours
from omnimorph.viewer.frames import Flight

PIECES = 180
"""Each curve is drawn with the least and the largest value in so many pieces of time."""

_HEIGHT, _WIDTH = 132, 380
_FAR_TILT = 100.0  # degrees; a limit farther than that would flatten the curve
_SHADES = (
    colours.BLUE,
    colours.VERMILLION,
    colours.GREEN,
    colours.PURPLE,
    colours.ORANGE,
    colours.SKY,
    colours.INK,
    colours.GREY,
)
_DASHES: tuple[list[int], ...] = ([], [6, 4])
_FITTED = {"min": {"pad": 0.0, "soft": 0.0, "mode": 1}, "max": {"pad": 0.04}}  # from 0 or below
_LIMIT = {"stroke": colours.css(colours.GREY), "dash": [2, 4], "width": 1}
_LIMIT_KEY = (("dotted: limits", colours.GREY),)
_NOW = {
    "stroke": colours.css(colours.INK),
    "width": 1.5,
    "label": "now",
    "points": {"show": False},
    "auto": False,  # it is as high as the axis, so the axis must not ask it
}


class Curve(NamedTuple):
    """One line of a chart.

    Attributes
    ----------
    label : str
        Its name in the chart.
    time, values : (K,) arrays
        In s, and in the chart's unit.
    style : dict
        How uPlot draws it.
    """

    label: str
    time: FloatArray
    values: FloatArray
    style: dict[str, Any]


class Chart(NamedTuple):
    """One plot over time.

    Attributes
    ----------
    title : str
        With the unit.
    curves : tuple of Curve
        At least one.
    limits : tuple of float
        Drawn across, in the unit.
    key : tuple of (word, colour)
        What its colours stand for, where that does not go without saying.
    """

    title: str
    curves: tuple[Curve, ...]
    limits: tuple[float, ...] = ()
    key: tuple[tuple[str, colours.Colour], ...] = ()


def charts_of(flights: Sequence[Flight]) -> list[Chart]:
    """Return the plots of one flight, or of two on the same axes (the second one dashed)."""
    p, tilt = COLUMN["p_WB"], COLUMN["tilt_actual"]
    charts = [
        _chart(flights, "position error, mm", p.colour, lambda f: [("", f.position_error_mm)]),
        _chart(flights, "attitude error, °", tilt.colour, lambda f: [("", f.attitude_error_deg)]),
    ]
    if any(flight.vehicle.n_servos for flight in flights):
        charts.append(_of_column(flights, "tilt", tilt))
    charts.append(_of_column(flights, "rotor speeds", COLUMN["speed"]))
    charts.append(_of_column(flights, "rotor drag power", COLUMN["drag_power"]))
    logged = {(c.name, c.units): c for flight in flights for c in as_columns(flight.run.logged)}
    return charts + [_of_column(flights, column.name, column) for column in logged.values()]


def add_plots(server: Any, flights: Sequence[Flight]) -> Charts:
    """Add the plots of one or two flights on the left of a page, its controls on the right."""
    panel = server.gui.add_panel()
    with panel.add_tab("Plots over time, s"):
        charts = Charts(server, charts_of(flights))
    server.gui.main_panel.dock_right()
    panel.dock_left()
    panel.set_width(_WIDTH)
    return charts


class Charts:
    """The plots on the page, in the container that is open, with a line where the time stands.

    Parameters
    ----------
    server : viser.ViserServer
        Whose page.
    charts : sequence of Chart
        From top to bottom.
    """

    def __init__(self, server: Any, charts: Sequence[Chart]) -> None:
        self._plots = [_Plot(server, chart) for chart in charts]

    def replace(self, charts: Sequence[Chart]) -> None:
        """Draw the same charts with more of their curves."""
        for plot, chart in zip(self._plots, charts, strict=False):  # what is logged later: not yet
            plot.take(chart)

    def show_time(self, time: float) -> None:
        """Move the line of the time shown, s."""
        for plot in self._plots:
            plot.show_time(time)


class _Plot:
    """One uPlot; its last curve is a vertical line at the time shown, as high as the axis.

    The axis fits what is drawn by itself: a plot whose scales are set anew is built anew in the
    browser, and then keeps to the times that it had shown before.
    """

    _span: tuple[float, float]

    def __init__(self, server: Any, chart: Chart) -> None:
        self.take(chart)
        series = [
            {},
            *({"label": curve.label, **curve.style} for curve in chart.curves),
            *({"label": f"limit {limit:.4g}", **_LIMIT} for limit in chart.limits),
            _NOW,
        ]
        self._handle = server.gui.add_uplot(
            data=self._data(0.0),
            series=tuple(series),
            title=chart.title,
            scales={"x": {"time": False}, "y": {"range": _FITTED}},
            axes=({"size": 26, "space": 44}, {"size": 48, "space": 26}),
            legend={"show": False},
            cursor={"sync": {"key": "omnimorph"}},
            height=_HEIGHT,
            padding=(4, 12, 0, 0),
        )
        if chart.key:
            server.gui.add_html(_key_text(chart.key))

    def take(self, chart: Chart) -> None:
        """Take the curves of a chart, and the span of its axis."""
        self._time, self._values = _on_common_times(chart)
        finite = self._values[np.isfinite(self._values)]
        low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
        low, high = min(low, 0.0), high if high > low else low + 1.0
        self._span = (low, high + 0.04 * (high - low))

    def show_time(self, time: float) -> None:
        self._handle.data = self._data(time)

    def _data(self, time: float) -> tuple[FloatArray, ...]:
        """Return the curves with two points more, in which only the line of the time is drawn."""
        at = int(np.searchsorted(self._time, time))
        here = np.array([np.interp(time, self._time, row) for row in self._values])
        both = np.repeat(here[:, None], 2, axis=1)
        values = np.concatenate([self._values[:, :at], both, self._values[:, at:]], axis=1)
        times = np.concatenate([self._time[:at], [time, time], self._time[at:]])
        now = np.full(len(times), np.nan)
        now[at : at + 2] = self._span
        return (times, *values, now)


def _on_common_times(chart: Chart) -> tuple[FloatArray, FloatArray]:
    """Return the curves and limits of a chart thinned to times they share: (P,), (S, P)."""
    time = _shared_time([curve.time for curve in chart.curves])
    rows = np.full((len(chart.curves) + len(chart.limits), len(time)), np.nan)
    for row, curve in zip(rows, chart.curves, strict=False):
        inside = time <= curve.time[-1]
        row[inside] = np.interp(time[inside], curve.time, curve.values)
    rows[len(chart.curves) :] = np.array(chart.limits)[:, None]
    return envelope(time, rows, PIECES)


def _shared_time(times: Sequence[FloatArray]) -> FloatArray:
    """Return times as fine as the finest, until the end of the longest; those of all, if alike."""
    if all(np.array_equal(time, times[0]) for time in times):
        return times[0]
    step = min(time[1] - time[0] for time in times if len(time) > 1)
    longest = max(times, key=lambda time: float(time[-1]))
    shared: FloatArray = np.arange(round(longest[-1] / step) + 1) * step
    return shared


def _of_column(flights: Sequence[Flight], name: str, column: Column) -> Chart:
    """Return the chart of a column with its limits; of a logged one the first entries only."""
    title = name if column.unit_read in ("", "1") else f"{name}, {column.unit_read}"
    count = max(map(len, (_entries(flight, column) for flight in flights)))
    shown = count if column in COLUMNS else min(count, len(_SHADES))
    if shown < count:
        title += f" (the first {shown} of {count})"

    def curves_of(flight: Flight) -> list[tuple[str, FloatArray]]:
        entries = _entries(flight, column)[:shown]
        if not entries:
            return []
        values = column.as_read(flight.run[column.name])
        return list(zip(entries, values.reshape(len(values), -1).T, strict=False))

    limits = {limit for flight in flights for limit in _limits(flight, column)}
    return _chart(flights, title, column.colour, curves_of, tuple(sorted(limits)))


def _chart(
    flights: Sequence[Flight],
    title: str,
    colour: str,
    curves_of: Callable[[Flight], Sequence[tuple[str, FloatArray]]],
    limits: tuple[float, ...] = (),
) -> Chart:
    """Return a chart with the curves of each flight, which have names.

    Colours stand for the names, or for the flights, where each has one curve; a single curve has
    the `colour` of what it shows.
    """
    curves, entries = [], [""]
    for k, flight in enumerate(flights):
        found = curves_of(flight)
        entries = max(entries, [entry for entry, _ in found], key=len)
        for j, (entry, values) in enumerate(found):
            shade = _SHADES[(j if len(found) > 1 else k) % len(_SHADES)]
            if len(found) == len(flights) == 1:
                shade = colours.of_css(colour)
            label = f"{flight.name} {entry}".rstrip()
            curves.append(Curve(label, flight.run.time, values, _curve_style(shade, k)))
    names = [flight.name for flight in flights] if len(flights) > 1 else []
    key = _key(names)
    if len(entries) > 1:
        key = _key([entry.removeprefix("rotor ") for entry in entries]) + _lines(names)
    return Chart(title, tuple(curves), limits, key + (_LIMIT_KEY if limits else ()))


def _entries(flight: Flight, column: Column) -> list[str]:
    """Return what the entries of a column are called; none, if the flight does not have it."""
    if column not in COLUMNS:
        logged = flight.run.logged.get(column.name)
        if logged is None or logged.unit != column.units:
            return []
        return [", ".join(map(str, index)) for index in np.ndindex(logged.values.shape[1:])]
    vehicle = flight.vehicle
    rotors = [f"rotor {i}" for i in range(vehicle.n_rotors)]
    return {"rotor": rotors, "servo": list(vehicle.servo_name)}.get("".join(column.dims), [""])


def _limits(flight: Flight, column: Column) -> list[float]:
    """Return the limits of a column that do not flatten its curves."""
    if not column.limits:
        return []
    ends = np.unique(np.concatenate(column.limits_of(flight.vehicle)).round(6))
    farthest = _FAR_TILT if column.read_in == "deg" else np.inf
    return [float(end) for end in ends if abs(end) <= farthest]


def _key(labels: Sequence[str]) -> tuple[tuple[str, colours.Colour], ...]:
    """Return words with the colours of the curves in their order."""
    return tuple((word, _SHADES[k % len(_SHADES)]) for k, word in enumerate(labels))


def _lines(names: Sequence[str]) -> tuple[tuple[str, colours.Colour], ...]:
    """Return which line is whose, where colours already stand for rotors or servos."""
    return tuple(
        (f"{line}: {name}", colours.INK)
        for line, name in zip(("solid", "dashed"), names, strict=False)
    )


def _key_text(key: tuple[tuple[str, colours.Colour], ...]) -> str:
    one = "margin:0 5px;display:inline-block"
    labels = "".join(
        f'<span style="color:{colours.css(shade)};{one}">{html.escape(word)}</span>'
        for word, shade in key
    )
    style = "font-size:0.7rem;font-weight:600;text-align:center;line-height:1.2"
    return f'<div style="{style}">{labels}</div>'


def _curve_style(shade: colours.Colour, flight: int) -> dict[str, Any]:
    style: dict[str, Any] = {"stroke": colours.css(shade), "width": 1.3, "points": {"show": False}}
    return style | ({"dash": _DASHES[flight]} if flight else {})
