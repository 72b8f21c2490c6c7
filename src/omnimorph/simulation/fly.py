"""Fly a scenario: in the compiled core, or with parts of the loop written in Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from omnimorph import _core
from omnimorph.errors import ScenarioError
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.model.core import as_core
from omnimorph.protocols import (
    Allocator,
    Command,
    Controller,
    Disturbance,
    FloatArray,
    Reference,
)
from omnimorph.reference.rows import desired_from_row
from omnimorph.results.run import Run
from omnimorph.simulation.parts_in_flight import in_flight
from omnimorph.simulation.plant import NOT_ASKED, PlantLike, as_plant, as_state, send
from omnimorph.simulation.scenario import described
from omnimorph.simulation.scenario_files import ScenarioLike, as_scenario
from omnimorph.simulation.stepped_flight import NO_PUSH, SteppedFlight
from omnimorph.simulation.whole_number import whole_number

__all__ = ["fly", "measurement_noise"]

Progress = Callable[[float, float], None]
_STEPS_BETWEEN_REPORTS = 2000


def fly(
    scenario: ScenarioLike,
    *,
    seed: int = 0,
    flight: int = 0,
    plant: PlantLike | None = None,
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
    scenario : Scenario, str or path
        What is flown, or its name or file.
    seed, flight : int
        Which noise: flight k of seed s is the same wherever and beside whatever it is flown.
    plant : PlantModel, str or path, optional
        Another plant, or its name or file, such as ``perfect``.
    controller, allocator, reference, disturbance : optional
        See `omnimorph.protocols`. An allocator gets its accelerations from the scenario's tracking.
        One that may remember something, as any may but plain functions and frozen records, flies
        once at a time.
    progress : callable, optional
        Called now and then with the time flown and the duration, s.

    Returns
    -------
    Run
        Complete, or up to the step at which the flight ended; see `Run.outcome`.

    Raises
    ------
    ScenarioError
        If a part does not fit: both a controller and an allocator, a reference that is not finite;
        if a part is flying in another thread.
    TooLargeError
        If the flight has more rows than memory holds.

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
    scenario = as_scenario(scenario)
    if plant is not None:
        scenario = replace(scenario, plant=as_plant(plant))
    if reference is not None:
        scenario = replace(scenario, reference=reference)
    parts = {"controller": controller, "allocator": allocator, "disturbance": disturbance}
    written = {name: described(part) for name, part in parts.items() if part is not None}
    with in_flight(parts):
        loop = _Loop(scenario, seed=seed, flight=flight)
        loop.notes |= written
        if controller is None and allocator is None and disturbance is None:
            loop.fly_in_core(progress)
        else:
            loop.fly_in_python(controller, allocator, disturbance, progress)
    return loop.as_run()


def measurement_noise(seed: int, flight: int, steps: int) -> FloatArray:
    """Return the (steps, 12) standard normal numbers behind a flight's white measurement noise.

    Columns: position, velocity, attitude, body rate. They depend on nothing but the arguments.

    Raises
    ------
    ScenarioError
        If an argument is not a whole number that a flight can have.
    TooLargeError
        If they are more than memory holds.
    """
    for name, value, bits in (("seed", seed, 64), ("flight", flight, 32), ("steps", steps, 32)):
        whole_number("measurement_noise", name, value, bits)
    refuse_more_than_memory(f"{steps} rows of noise", 96 * steps, "ask for fewer")
    return _core.measurement_normals(seed, flight, 0, steps)


class _Loop(SteppedFlight):
    """One flight flown to its end, by the core alone or with parts written in Python."""

    reported = 0

    def fly_in_core(self, progress: Progress | None) -> None:
        """Let the core fly, stopping now and then to report and to notice an interrupt."""
        while self.core.status == _core.FlightStatus.FLYING:
            self.core.advance(_STEPS_BETWEEN_REPORTS)
            self._report(progress)

    def fly_in_python(
        self,
        controller: Controller | None,
        allocator: Allocator | None,
        disturbance: Disturbance | None,
        progress: Progress | None,
    ) -> None:
        """Fly one control step at a time."""
        core, self.last = self.core, self.start_command
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

    def _integrate(self, disturbance: Disturbance | None) -> None:
        """Fly one control period, or what is left; the last row is recorded without a push."""
        if disturbance is None:
            self.core.integrate(self.control_every, NO_PUSH)
            return
        for _ in range(min(self.control_every, self.steps - self.core.step)):
            push = _numbers("the disturbance", disturbance(self.time, as_state(self.core.motion())))
            if push.shape != (6,):
                allowed = "six numbers, force in W and torque in B"
                raise ScenarioError.at("the disturbance", "shape", push.shape, allowed)
            self.core.integrate(1, push)
        if self.core.step == self.steps:
            self.core.integrate(1, NO_PUSH)

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
            return controller(self.time, state, desired_from_row(desired_numbers)), NOT_ASKED
        assert allocator is not None
        wanted = _core.reference_acceleration(self.settings, state_numbers, desired_numbers)
        asked = _core.wrench_for(as_core(self.scenario.vehicle), state_numbers, wanted)
        self.last = allocator(wanted, state, self.last)
        return self.last, asked

    def _report(self, progress: Progress | None) -> None:
        self.reported = self.core.step
        if progress is not None:
            progress(self.time, self.duration)


def _numbers(what: str, answer: Any) -> FloatArray:
    """Return what a part written in Python answered as an array of float64."""
    try:
        return np.asarray(answer, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ScenarioError.at(what, "answer", answer, "numbers") from None
