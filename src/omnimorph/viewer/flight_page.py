"""The page of one run, or of two side by side: played, scrubbed, and read off."""

from __future__ import annotations

import html
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray
from omnimorph.viewer.charts import add_plots
from omnimorph.viewer.frames import Flight, Frame, Playback
from omnimorph.viewer.stage import MISSED, Actor, camera_for, set_stage
from omnimorph.viewer.tables import Row, number_table
from omnimorph.viewer.vehicle_solid import reach_of

_PICTURES = 30.0  # a second
_NUMBERS = 8.0
_CHARTS = 2.5  # each time their curves are sent again
_SPEEDS = {"0.1 ×": 0.1, "0.25 ×": 0.25, "0.5 ×": 0.5, "1 ×": 1.0, "2 ×": 2.0, "5 ×": 5.0}
_TRAIL_SECONDS = 3.0


class Rhythm:
    """Says whether it is time again for what is done so often a second."""

    def __init__(self, per_second: float) -> None:
        self._period, self._last = 1.0 / per_second, -1e9

    def is_due(self, now: float) -> bool:
        """Return whether a period has passed at a time, s, since it last had."""
        due = now - self._last >= self._period
        self._last = now if due else self._last
        return due


class FlightScene:
    """One or two runs in the scene of a server.

    Parameters
    ----------
    server : viser.ViserServer
        Whose scene.
    flights : sequence of Flight
        One, or two that are seen side by side at the same time.
    """

    def __init__(self, server: Any, flights: Sequence[Flight]) -> None:
        self.flights = flights
        self.duration = max(flight.duration for flight in flights)
        paths = [flight.path for flight in flights]
        reach = max(reach_of(flight.vehicle) for flight in flights)
        width = max(float(np.ptp(path[:, 0])) for path in paths) + 2.6 * reach
        besides = [np.array([width * k, 0.0, 0.0]) for k in range(len(flights))]
        shifted = [path + beside for path, beside in zip(paths, besides, strict=True)]
        ground, self.camera = set_stage(server, shifted, reach)
        self.actors = [
            Actor(
                server,
                f"/flight{k}",
                flight.vehicle,
                besides[k],
                ground,
                paths[k],
                flight.name if len(flights) > 1 else "",
            )
            for k, flight in enumerate(flights)
        ]
        self.show(0.0)

    def close_up(self, frames: Sequence[Frame]) -> tuple[FloatArray, FloatArray]:
        """Return a camera that looks at the vehicles as they are, without the whole path."""
        at = [actor.middle(frame) for actor, frame in zip(self.actors, frames, strict=True)]
        middle = np.mean(at, axis=0)
        reach = max(reach_of(flight.vehicle) for flight in self.flights)
        apart = max(float(np.linalg.norm(place - middle)) for place in at)
        return camera_for(middle, 1.1 * reach + apart)

    def show(self, seconds: float) -> list[Frame]:
        """Show all vehicles at a time, s; return what is shown."""
        frames = []
        for flight, actor in zip(self.flights, self.actors, strict=True):
            row = flight.row_at(seconds)
            frame = flight.frame(row)
            actor.show(frame, _trail(flight, row))
            frames.append(frame)
        return frames


class FlightPage:
    """A server's page with a flight, its controls, numbers and plots.

    Parameters
    ----------
    server : viser.ViserServer
        Whose page it becomes.
    flights : sequence of Flight
        One or two.
    """

    def __init__(self, server: Any, flights: Sequence[Flight]) -> None:
        self._server, self._flights = server, flights
        self._lock = threading.RLock()
        self.playback = Playback(max(flight.duration for flight in flights))
        self._followed: FloatArray | None = None
        self._add_controls()
        self._charts = add_plots(server, flights)
        self._closed = threading.Event()
        self.scene = FlightScene(server, flights)  # last: what can be read is there before it
        self._show()

    def play(self) -> None:
        """Keep the page alive, and play when it is asked to, until `close` or Ctrl-C."""
        before = time.monotonic()
        numbers, charts = Rhythm(_NUMBERS), Rhythm(_CHARTS)
        while not self._closed.wait(1.0 / _PICTURES):
            now = time.monotonic()
            with self._lock:
                if self.playback.is_playing:
                    try:
                        self.playback.advance(now - before)
                        ends = not self.playback.is_playing
                        self._show(numbers.is_due(now) or ends, charts.is_due(now) or ends)
                    except Exception as error:
                        self.playback.pause()  # or it would be set 30 times a second
                        self._server.guard.fault(error)
            before = now

    def close(self) -> None:
        """End `play`."""
        self._closed.set()

    def _add_controls(self) -> None:
        gui = self._server.gui
        gui.set_panel_label(" and ".join(flight.name for flight in self._flights))
        self._button = gui.add_button("Play")
        self._slider = gui.add_slider(
            "time, s", 0.0, max(self.playback.duration, 1e-3), self._step(), 0.0
        )
        self._speed = gui.add_dropdown("speed", tuple(_SPEEDS), initial_value="1 ×")
        self._camera = gui.add_dropdown("camera", ("free", "follow"), initial_value="free")
        with gui.add_folder("Show", expand_by_default=False):
            self._ghost = gui.add_checkbox("desired pose", True)
            self._arrows = gui.add_checkbox("thrusts", True)
            self._trail = gui.add_checkbox("trail", True)
        self._notice = gui.add_html("")
        self._numbers = gui.add_html("")
        self._button.on_click(lambda _: self._play_or_pause())
        self._slider.on_update(self._scrub)
        self._speed.on_update(lambda _: self._change_speed())
        self._camera.on_update(lambda _: self._forget_followed())
        for box in (self._ghost, self._arrows, self._trail):
            box.on_update(lambda _: self._change_shown())

    def _step(self) -> float:
        return min(flight.run.provenance.physics_step for flight in self._flights)

    def _play_or_pause(self) -> None:
        with self._lock:
            if self.playback.is_playing:
                self.playback.pause()
                self._show()
            else:
                self.playback.play()

    def _scrub(self, event: Any) -> None:
        if event.client is None:  # moved by the playback itself
            return
        with self._lock:
            self.playback.move_to(float(self._slider.value))
            self._show()

    def _change_speed(self) -> None:
        with self._lock:
            self.playback.speed = _SPEEDS[self._speed.value]

    def _forget_followed(self) -> None:
        with self._lock:
            self._followed = None
            self._show(numbers=False, charts=False)  # the time stays, which may be on its way here

    def _change_shown(self) -> None:
        with self._lock, self._server.atomic():
            for actor in self.scene.actors:
                actor.ghost_shown = self._ghost.value
                actor.solid.arrows_are_shown = self._arrows.value
                actor.show_trail(self._trail.value)
            self.scene.show(self.playback.time)

    def _show(self, numbers: bool = True, charts: bool = True) -> None:
        with self._server.atomic():
            frames = self.scene.show(self.playback.time)
            self._follow(frames)
        if numbers:
            self._button.label = "Pause" if self.playback.is_playing else "Play"
            self._slider.value = self.playback.time
            names = [flight.name for flight in self._flights]
            self._numbers.content = number_table(numbers_of(self._flights, frames), names)
            self._notice.content = notices(self._flights, frames)
        if charts:
            self._charts.show_time(self.playback.time)

    def _follow(self, frames: list[Frame]) -> None:
        """Move every camera as far as the first vehicle has moved, if it is to be followed."""
        if self._camera.value != "follow":
            return
        middle = self.scene.actors[0].middle(frames[0])
        moved = 0.0 if self._followed is None else middle - self._followed
        for client in self._server.get_clients().values():
            client.camera.position = client.camera.position + moved
            with suppress(ValueError):  # a camera in the very middle sees it in no direction
                client.camera.look_at = middle
        self._followed = middle


def numbers_of(flights: Sequence[Flight], frames: Sequence[Frame]) -> list[Row]:
    """Return the numbers beside the picture: key, label, unit, and one value for each flight."""

    def row(key: str, label: str, unit: str, value: Any) -> Row:
        return Row(key, label, unit, [value(*pair) for pair in zip(flights, frames, strict=True)])

    rows = [
        row("time", "time", "s", lambda _, frame: f"{frame.time:.3f}"),
        row("position-error", "position error", "mm", lambda _, f: f"{f.position_error_mm:.3f}"),
        row("attitude-error", "attitude error", "°", lambda _, f: f"{f.attitude_error_deg:.3f}"),
    ]
    if any(flight.vehicle.n_servos for flight in flights):
        rows.append(row("tilt", "tilt", "°", lambda _, f: _angles(f.tilt)))
    return [
        *rows,
        row("fastest-rotor", "fastest rotor", "Hz", lambda _, f: f"{_fastest(f):.2f}"),
        row("largest-thrust", "largest thrust", "N", lambda _, f: _decimals(_strongest(f), 3)),
        row("power", "rotor drag power", "W", lambda _, f: _decimals(f.power, 1)),
        row(
            "missed-force", "force not achieved", "N", lambda _, f: _decimals(_norm(f.missed_W), 3)
        ),
    ]


def notices(
    flights: Sequence[Flight], frames: Sequence[Frame], at_the_end: bool | None = None
) -> str:
    """Return what deserves attention now: rotors at their limit, a force that is not made.

    `at_the_end` says whether the flights are over; by default they are in their last row.
    """
    lines = []
    for flight, frame in zip(flights, frames, strict=True):
        name = f"{html.escape(flight.name)}: " if len(flights) > 1 else ""
        at_limit = [str(i) for i in np.flatnonzero(frame.active)]
        if at_limit:
            lines.append(f"{name}at the limit: rotor {', '.join(at_limit)}")
        if _norm(frame.missed_W) > MISSED * flight.vehicle.mass * GRAVITY:
            lines.append(f"{name}force not achieved: {_norm(frame.missed_W):.2f} N")
        if frame.time >= flight.duration if at_the_end is None else at_the_end:
            lines.append(f"{name}{html.escape(flight.run.outcome_sentence)}")
    shade = "background:#fdf1e3;border-left:3px solid #d55e00;padding:4px 8px;margin:4px 8px"
    style = f' style="{shade}"' if lines else ""
    return f'<div id="notices"{style}>{"<br>".join(lines)}</div>'


def _trail(flight: Flight, row: int) -> FloatArray:
    """Return the path of the last seconds, thinned to what the eye can see."""
    length = round(_TRAIL_SECONDS / flight.run.provenance.physics_step)
    rows = np.unique(np.linspace(max(row - length, 0), row, 60).astype(np.int64))
    return flight.run.p_WB[rows]


def _angles(tilt: FloatArray) -> str:
    return ", ".join(f"{angle:.2f}" for angle in np.degrees(tilt)) or "—"


def _fastest(frame: Frame) -> float:
    return float(np.abs(frame.speed).max()) / (2.0 * np.pi)


def _strongest(frame: Frame) -> float:
    return float(np.abs(frame.thrust).max())


def _decimals(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}" if np.isfinite(value) else "—"


def _norm(vector: FloatArray) -> float:
    return float(np.linalg.norm(vector))
