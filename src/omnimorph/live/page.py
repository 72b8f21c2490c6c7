"""The page of a flight while it runs, with what a demonstration needs."""

from __future__ import annotations

import html
import math
import textwrap
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from omnimorph.errors import InputError
from omnimorph.live.pilot import PUSH_SECONDS, Pilot
from omnimorph.results.run import Outcome, Run
from omnimorph.simulation.loop import SteppedFlight
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import list_scenarios, load_scenario
from omnimorph.viewer.charts import add_plots, charts_of
from omnimorph.viewer.flight_page import Rhythm, notices, numbers_of
from omnimorph.viewer.frames import Flight, Frame, blade_turns, can_be_shown, frame_of
from omnimorph.viewer.stage import Actor, set_stage
from omnimorph.viewer.tables import number_table
from omnimorph.viewer.vehicle_solid import reach_of

_PICTURES = 30.0  # a second
_CHARTS = 1.0  # a second
_NUMBERS = 10.0  # a second
_EVENTS_SHOWN = 5
_PIECE = 0.02  # s flown before the clock is looked at again
_PACES = {"real time": 1.0, "half": 0.5, "a tenth": 0.1, "as fast as possible": None}
_DIRECTIONS = {
    "+x": (1.0, 0.0, 0.0),
    "−x": (-1.0, 0.0, 0.0),
    "+y": (0.0, 1.0, 0.0),
    "−y": (0.0, -1.0, 0.0),
    "up": (0.0, 0.0, 1.0),
    "down": (0.0, 0.0, -1.0),
}


class LivePage:
    """A server's page on which a scenario is flown.

    Parameters
    ----------
    server : viser.ViserServer
        Whose page it becomes.
    scenario : Scenario
        What is flown.
    seed : int
        Which noise.
    """

    def __init__(self, server: Any, scenario: Scenario, seed: int = 0) -> None:
        self._server, self.scenario = server, scenario
        self.flight = SteppedFlight(scenario, seed=seed)
        self.pilot = Pilot(self.flight)
        self._truth = scenario.plant.true_vehicle(scenario.vehicle)
        self._turns = np.zeros(scenario.vehicle.n_rotors)
        self._is_running, self._is_faulty = True, False
        server.guard.on_fault(self._end_by_fault)
        self.flight.step()  # so that there is something to be seen
        way = np.array([scenario.reference(t).p_WB for t in np.linspace(0, self.flight.duration)])
        ground, _ = set_stage(server, [way], reach_of(scenario.vehicle))
        self._actor = Actor(server, "/flight", scenario.vehicle, np.zeros(3), ground, way)
        self._add_controls()
        self._charts = add_plots(server, [self._as_flight()])

    @property
    def is_over(self) -> bool:
        """Whether the flight has ended, one way or another."""
        return self._is_faulty or self.flight.is_over

    def fly(self) -> Run:
        """Fly from the moment somebody looks until the flight is over; return the run.

        An exception, here or in what a control does, ends the flight, and what it was is noted in
        the provenance of the run.
        """
        for act in (self._fly, self.show):
            try:
                act()
            except Exception as error:
                self._server.guard.fault(error)
        return self.as_run()

    def as_run(self) -> Run:
        """Return what has been flown so far as a run."""
        with self.pilot.lock:
            run, goes_on = self.flight.as_run(), not self.flight.is_over
        return replace(run, outcome=Outcome.PAGE_FAULT) if self._is_faulty and goes_on else run

    def _fly(self) -> None:
        while not self._server.get_clients():
            time.sleep(0.02)
        before = time.monotonic()
        numbers, charts = Rhythm(_NUMBERS), Rhythm(_CHARTS)
        while not self.is_over:
            time.sleep(max(before + 1.0 / _PICTURES - time.monotonic(), 0.0))
            now = time.monotonic()
            if self._is_running:
                self._advance(min(now - before, 0.2))
            if numbers.is_due(now):  # while it is paused, too: they may be behind what was flown
                self._show_numbers()
            if charts.is_due(now):
                self._show_charts()
            before = now

    def _end_by_fault(self, error: Exception) -> None:
        with self.pilot.lock:
            if not self.is_over:
                fault = textwrap.shorten(f"{type(error).__name__}: {error}", 200)
                self.flight.note("fault", error=fault)
                self._is_faulty = True

    def show(self) -> None:
        """Show all of it as it is now."""
        self._show_scene(0.0)
        self._show_numbers()
        self._show_charts()

    def _advance(self, seconds: float) -> None:
        """Fly for what has passed for who looks, or for as much as can be computed meanwhile."""
        pace, began = _PACES[self._pace_choice.value], self.flight.time
        if pace is None:
            ends = time.monotonic() + 1.0 / _PICTURES
            while time.monotonic() < ends and not self.flight.is_over:
                self.pilot.advance(self.flight.time + _PIECE)
        else:
            self.pilot.advance(began + pace * seconds)
        self._show_scene(min(seconds, self.flight.time - began))

    def serve(self) -> None:
        """Keep the page until the last browser leaves it."""
        while self._server.get_clients():
            time.sleep(0.2)

    def _add_controls(self) -> None:
        gui, vehicle = self._server.gui, self.scenario.vehicle
        gui.set_panel_label(self.scenario.name)
        self._button = gui.add_button("Pause")
        self._button.on_click(lambda _: self._pause_or_go_on())
        self._pace_choice = gui.add_dropdown("pace", tuple(_PACES), initial_value="real time")
        with gui.add_folder("Disturb it"):
            weight = round(self.pilot.weight, 1)
            strength = gui.add_slider("push, N", 0.0, 3.0 * weight, 0.1, weight)
            pushes = gui.add_button_group(f"for {PUSH_SECONDS:g} s", tuple(_DIRECTIONS))
            rotors = tuple(f"rotor {i}" for i in range(vehicle.n_rotors))
            rotor = gui.add_dropdown("rotor", rotors)
            cut = gui.add_button("Cut its thrust")
            restore = gui.add_button("Restore all rotors")
            names = self._controllers()
            controller = gui.add_dropdown("controller", names, initial_value=names[0])
        pushes.on_click(
            lambda event: self.pilot.push(
                float(strength.value) * np.array(_DIRECTIONS[event.target.value])
            )
        )
        cut.on_click(lambda _: self._try(lambda: self.pilot.cut(rotors.index(rotor.value))))
        restore.on_click(lambda _: self._try(self.pilot.restore))
        controller.on_update(lambda _: self._try(lambda: self._take_controller(controller.value)))
        self._notice = gui.add_html("")
        self._numbers = gui.add_html("")

    def _controllers(self) -> tuple[str, ...]:
        """Return the scenarios whose controllers fit the vehicle, this one first."""
        mine = self.scenario
        others = []
        for name in list_scenarios():
            try:
                fits = load_scenario(name).vehicle.name == mine.vehicle.name
            except InputError:
                continue
            if fits and name != mine.name:
                others.append(name)
        return (mine.name, *others)

    def _take_controller(self, name: str) -> None:
        mine = self.scenario
        self.pilot.take_controller_of(mine if name == mine.name else load_scenario(name))

    def _try(self, change: Callable[[], None]) -> None:
        """Change the flight, or say why it cannot be."""
        try:
            change()
        except InputError as mistake:
            self._notice.content = f'<div id="notices">{html.escape(str(mistake))}</div>'

    def _pause_or_go_on(self) -> None:
        self._is_running = not self._is_running
        self._button.label = "Pause" if self._is_running else "Go on"

    def _frame(self) -> Frame:
        row, columns = self._row_shown(), self.flight.columns
        power = float(np.abs(columns["speed"][row]) ** 3 @ self._truth.drag_coefficient)
        time_then = row * self.scenario.plant.physics_step
        return frame_of(columns, row, time_then, self._turns, power)

    def _row_shown(self) -> int:
        """Return the last row that can be shown: a flight that diverged ends in one that cannot."""
        row = self.flight.row
        while row > 0 and not can_be_shown(self.flight.columns, slice(row, row + 1)).all():
            row -= 1
        return row

    def _as_flight(self) -> Flight:
        return Flight(self.as_run(), self.scenario.name)

    def _show_scene(self, seconds: float) -> None:
        """Show the vehicle, its blades turned on for so many seconds."""
        with self.pilot.lock:
            speed = self.flight.columns["speed"][self._row_shown()]
            self._turns = self._turns + blade_turns(self.scenario.vehicle, speed, seconds)
            frame = self._frame()
        with self._server.atomic():
            self._actor.show(frame)

    def _show_numbers(self) -> None:
        with self.pilot.lock:
            frame, flight = self._frame(), self._as_flight()
        self._numbers.content = number_table(numbers_of([flight], [frame]))
        self._notice.content = notices([flight], [frame], self.is_over) + self._done_to_it()

    def _done_to_it(self) -> str:
        """Return what was done to the flight lately, and when."""
        lines = [
            f"{event['time_s']:.2f} s: {_sentence_of(event)}"
            for event in self.flight.notes.get("events", [])[-_EVENTS_SHOWN:]
        ]
        style = "padding:2px 12px;font-size:0.8rem;color:#555"
        return f'<div id="done" style="{style}">{"<br>".join(lines)}</div>'

    def _show_charts(self) -> None:
        flight = self._as_flight()
        self._charts.replace(charts_of([flight]))
        self._charts.show_time(flight.duration)


def _sentence_of(event: dict[str, Any]) -> str:
    """Return in words what was done to a flight."""
    if event["kind"] == "push":
        return f"pushed with {math.hypot(*event['force_N']):.1f} N"
    if event["kind"] == "fault":
        return html.escape(event["error"])
    if event["kind"] == "failure":
        return html.escape(f"{event['part']} failed with {event['error']}")
    if event["kind"] == "controller":
        return f"controller of {html.escape(event['scenario'])}"
    if event["kind"] != "effectiveness":
        return html.escape(event["kind"])
    cut = [str(rotor) for rotor in np.flatnonzero(np.array(event["share"]) == 0.0)]
    return f"without thrust: rotor {', '.join(cut)}" if cut else "all rotors restored"
