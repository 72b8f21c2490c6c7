"""Fly a scenario: in the compiled core, or with parts of the loop written in Python."""

from __future__ import annotations

import json
import operator
from collections.abc import Callable
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from omnimorph import _core
from omnimorph.control.controller import core_settings
from omnimorph.design.files import vehicle_text
from omnimorph.errors import ScenarioError
from omnimorph.model.core import as_core, state_row
from omnimorph.model.dynamics import hover_thrust
from omnimorph.protocols import (
    Allocator,
    Command,
    Controller,
    Disturbance,
    FloatArray,
    Reference,
)
from omnimorph.reference.rows import desired_from_row
from omnimorph.reference.segments import SegmentReference
from omnimorph.results.run import COLUMNS, Outcome, Performance, Provenance, Run
from omnimorph.simulation.plant import as_state, control_steps, send
from omnimorph.simulation.scenario import Scenario, described

__all__ = ["MOST_STEPS", "empty_columns", "fly", "measurement_noise", "whole_number"]

Progress = Callable[[float, float], None]
_STEPS_BETWEEN_REPORTS = 2000
MOST_STEPS = 2**31
"""How many physics steps a flight has at most; no flight draws the noise of a later one."""
_NO_DISTURBANCE = np.zeros(6)
_UNKNOWN = np.full(6, np.nan)
_OUTCOMES = {
    _core.FlightStatus.COMPLETED: Outcome.COMPLETED,
    _core.FlightStatus.LOST: Outcome.LOST,
    _core.FlightStatus.DIVERGED: Outcome.DIVERGED,
    _core.FlightStatus.NOT_FINITE: Outcome.NOT_FINITE,
}


def fly(
    scenario: Scenario,
    *,
    seed: int = 0,
    flight: int = 0,
    plant: str | None = None,
    controller: Controller | None = None,
    allocator: Allocator | None = None,
    reference: Reference | None = None,
    disturbance: Disturbance | None = None,
    progress: Progress | None = None,
) -> Run:
    """Fly a scenario once.

    Parts of the loop can be objects written in Python: a `controller` or an `allocator` is called
    once a control step, a `disturbance` once a physics step, a `reference` for every physics step
    before the flight. What is left out runs in the core.

    Parameters
    ----------
    scenario : Scenario
        What is flown.
    seed, flight : int
        Which noise: flight k of seed s is the same wherever and beside whatever it is flown.
    plant : str, optional
        Name or file of another plant, such as ``perfect``.
    controller, allocator, reference, disturbance : optional
        See `omnimorph.protocols`. An allocator gets its accelerations from the scenario's tracking.
    progress : callable, optional
        Called now and then with the time flown and the duration, s.

    Returns
    -------
    Run
        Complete, or up to the step at which the flight ended; `Run.outcome` tells.

    Raises
    ------
    ScenarioError
        If a part does not fit: both a controller and an allocator, a reference that is not finite.

    Examples
    --------
    >>> import omnimorph as om
    >>> run = om.fly(om.load_scenario("hover"), plant="perfect")
    >>> run.outcome.name, run.metrics.position_error_max_m < 1e-6
    ('COMPLETED', True)
    """
    if controller is not None and allocator is not None:
        raise ScenarioError(
            "fly takes a controller or an allocator, not both: a controller allocates."
        )
    if plant is not None:
        from omnimorph.simulation.scenario_files import load_plant

        scenario = replace(scenario, plant=load_plant(plant))
    if reference is not None:
        scenario = replace(scenario, reference=reference)
    parts = {"controller": controller, "allocator": allocator, "disturbance": disturbance}
    written = {name: described(part) for name, part in parts.items() if part is not None}
    loop = _Loop(scenario, seed, flight, written)
    began = perf_counter()
    if controller is None and allocator is None and disturbance is None:
        outcome = loop.fly_in_core(progress)
    else:
        outcome = loop.fly_in_python(controller, allocator, disturbance, progress)
    return loop.as_run(outcome, perf_counter() - began)


def measurement_noise(seed: int, flight: int, steps: int) -> FloatArray:
    """Return the (steps, 12) standard normal numbers behind a flight's white measurement noise.

    Columns: position, velocity, attitude, body rate. They depend on nothing but the arguments.
    """
    return _core.measurement_normals(seed, flight, 0, steps)


class _Loop:
    """One flight under way: the core's flight, the columns it writes, and where it came from."""

    def __init__(self, scenario: Scenario, seed: int, flight: int, written: dict[str, Any]) -> None:
        self.scenario, self.written = scenario, written
        self.seed = whole_number("fly", "seed", seed, 64)
        self.flight = whole_number("fly", "flight", flight, 32)
        self.reported = 0
        vehicle, plant = scenario.vehicle, scenario.plant
        steps = scenario.reference.duration / plant.physics_step
        if not 0.5 < steps <= MOST_STEPS:
            allowed = f"from one physics step to {MOST_STEPS} of them"
            raise ScenarioError.at(scenario.name, "duration", scenario.reference.duration, allowed)
        self.steps = round(steps)
        self.control_every = control_steps(plant)
        self.columns = empty_columns(self.steps + 1, vehicle.n_rotors, vehicle.n_servos)
        self.settings = core_settings(
            vehicle,
            scenario.gains,
            scenario.allocator,
            plant.control_period,
            scenario.lateral_force,
        )
        start = scenario.reference(0.0)
        tilt = scenario.tilt
        self.last = Command(hover_thrust(vehicle, tilt), tilt)
        self.core = _core.new_flight(
            plant=plant.build_settings(vehicle),
            model=as_core(vehicle),
            controller=self.settings,
            reference=_core_reference(scenario, self.steps),
            start=state_row(start.p_WB, start.R_WB, np.zeros(6)),
            thrust=self.last.thrust,
            tilt=tilt,
            steps=self.steps,
            control_every=self.control_every,
            lost_beyond=scenario.lost_beyond,
            seed=self.seed,
            flight=self.flight,
            columns=self.columns,
        )

    def fly_in_core(self, progress: Progress | None) -> Outcome:
        """Let the core fly, stopping now and then to report and to notice an interrupt."""
        while self.core.status == _core.FlightStatus.FLYING:
            self.core.advance(_STEPS_BETWEEN_REPORTS)
            self._report(progress)
        return _OUTCOMES[self.core.status]

    def fly_in_python(
        self,
        controller: Controller | None,
        allocator: Allocator | None,
        disturbance: Disturbance | None,
        progress: Progress | None,
    ) -> Outcome:
        """Fly one control step at a time."""
        core = self.core
        while core.status == _core.FlightStatus.FLYING:
            if core.step < self.steps:
                state, desired = core.measure(), core.desired()
                if controller is None and allocator is None:
                    core.control(state, desired)
                else:
                    command, asked = self._ask(controller, allocator, state, desired)
                    if not send(core, command, asked):
                        break
            self._integrate(disturbance)
            if core.step - self.reported >= _STEPS_BETWEEN_REPORTS:
                self._report(progress)
        return _OUTCOMES[core.status]

    def _integrate(self, disturbance: Disturbance | None) -> None:
        """Fly one control period, or what is left; the last row is recorded without a push."""
        if disturbance is None:
            self.core.integrate(self.control_every, _NO_DISTURBANCE)
            return
        for _ in range(min(self.control_every, self.steps - self.core.step)):
            time = self.core.step * self.scenario.plant.physics_step
            push = _numbers("the disturbance", disturbance(time, as_state(self.core.motion())))
            if push.shape != (6,):
                allowed = "six numbers, force in W and torque in B"
                raise ScenarioError.at("the disturbance", "shape", push.shape, allowed)
            self.core.integrate(1, push)
        if self.core.step == self.steps:
            self.core.integrate(1, _NO_DISTURBANCE)

    def _ask(
        self,
        controller: Controller | None,
        allocator: Allocator | None,
        state_numbers: FloatArray,
        desired_numbers: FloatArray,
    ) -> tuple[Command, FloatArray]:
        """Ask the part written in Python; return its command and the wrench it was asked for."""
        state = as_state(state_numbers)
        if controller is not None:
            time = self.core.step * self.scenario.plant.physics_step
            return controller(time, state, desired_from_row(desired_numbers)), _UNKNOWN
        assert allocator is not None
        wanted = _core.reference_acceleration(self.settings, state_numbers, desired_numbers)
        asked = _core.wrench_for(as_core(self.scenario.vehicle), state_numbers, wanted)
        self.last = allocator(wanted, state, self.last)
        return self.last, asked

    def _report(self, progress: Progress | None) -> None:
        self.reported = self.core.step
        if progress is not None:
            step = self.scenario.plant.physics_step
            progress(self.core.step * step, self.steps * step)

    def as_run(self, outcome: Outcome, wall_time: float) -> Run:
        """Return the rows flown so far as a run."""
        scenario = self.scenario
        plant = scenario.plant
        rows = self.core.step + 1
        time = np.arange(rows, dtype=np.float64) * plant.physics_step
        columns = {name: column[:rows] for name, column in self.columns.items()}
        with np.errstate(all="ignore"):  # a flight that diverged holds what overflows
            speed = np.abs(columns["speed"])
            drag = plant.true_vehicle(scenario.vehicle).drag_coefficient
            columns["drag_power"] = (speed * speed * speed) @ drag
        return Run(
            time=time,
            **columns,
            outcome=outcome,
            vehicle=scenario.vehicle,
            provenance=Provenance(
                scenario_name=scenario.name,
                scenario_text=json.dumps(scenario.as_file() | self.written, sort_keys=True),
                vehicle_text=vehicle_text(scenario.vehicle),
                plant_name=plant.name,
                seed=self.seed,
                flight=self.flight,
                control_period=plant.control_period,
                physics_step=plant.physics_step,
                version=_version(),
            ),
            performance=Performance(
                wall_time=wall_time, real_time_factor=float(time[-1]) / max(wall_time, 1e-9)
            ),
        )


def empty_columns(rows: int, n: int, m: int) -> dict[str, Any]:
    """Return the columns of a run, not yet filled, for n rotors and m servos."""
    sizes = {"axis": 3, "axis_W": 3, "axis_B": 3, "wrench": 6, "rotor": n, "servo": m}
    return {
        column.name: np.empty(
            (rows, *(sizes[dim] for dim in column.dims)),
            dtype=np.int8 if column.name == "active" else np.float64,
        )
        for column in COLUMNS
    }


def _core_reference(scenario: Scenario, steps: int) -> _core.Reference:
    """Return the reference as the core flies it: segments as they are, anything else sampled."""
    reference = scenario.reference
    nothing = np.zeros(0)
    if isinstance(reference, SegmentReference):
        return _core.Reference(reference.as_table(), nothing)
    times = np.arange(steps + 1) * scenario.plant.physics_step
    sample = getattr(reference, "sample", None)
    rows = sample(times) if sample else np.array([_row(reference, t) for t in times.tolist()])
    if not np.isfinite(rows).all():
        at = times[np.argmin(np.isfinite(rows).all(axis=1))]
        raise ScenarioError.at(scenario.name, f"reference at {at:g} s", "not finite", "finite")
    return _core.Reference(nothing, np.ascontiguousarray(rows))


def whole_number(place: str, name: str, value: object, bits: int) -> int:
    """Return an integer that fits in so many bits; refuse anything else."""
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        number = -1
    if isinstance(value, bool) or not 0 <= number < 2**bits:
        raise ScenarioError.at(place, name, value, f"an integer from 0 to 2**{bits} - 1")
    return number


def _row(reference: Reference, time: float) -> FloatArray:
    """Return the 24 numbers of a point of a reference written in Python."""
    point = reference(time)
    row = state_row(*point) if isinstance(point, tuple) else np.zeros(0)
    if row.shape != (24,):
        allowed = "an omnimorph.Desired: position, attitude and their first two derivatives"
        raise ScenarioError.at("the reference", f"the point at {time:g} s", point, allowed)
    return row


def _numbers(what: str, answer: Any) -> FloatArray:
    """Return what a part written in Python answered as an array of float64."""
    try:
        return np.asarray(answer, dtype=np.float64)
    except (TypeError, ValueError):
        raise ScenarioError.at(what, "answer", answer, "numbers") from None


def _version() -> str:
    from omnimorph import __version__

    return __version__
