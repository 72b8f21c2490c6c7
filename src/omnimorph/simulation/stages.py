"""The stages of the closed loop in one control period, each the core's or one's own."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np

from omnimorph import _core
from omnimorph.arrays import as_numbers, real_array
from omnimorph.errors import ScenarioError
from omnimorph.model.core import as_core, state_row
from omnimorph.protocols import Command, FloatArray, Log, Plant, State
from omnimorph.reference.rows import desired_from_row
from omnimorph.simulation.core_settings import CoreSettings
from omnimorph.simulation.own_parts import FAILURES, OwnParts, PartFailed, check_plant, named
from omnimorph.simulation.scenario import Scenario

NO_PUSH = np.zeros(6)
NO_PUSH.flags.writeable = False  # every flight hands out this one
_NOT_ASKED = np.full(6, np.nan)
_IDENTITY = np.eye(3)
_ORTHONORMAL = 1e-3  # which an engine that integrates a matrix may drift away from
_UNKNOWN = np.zeros(0)  # thrusts that a plant does not say


class Stages:
    """What happens in a control period: sense, estimate, track, allocate; then the plant moves.

    Parameters
    ----------
    core : omnimorph._core.Flight
        The flight, which records each row and does what is not one's own.
    settings : CoreSettings
        Of the flight.
    scenario : Scenario
        Of the flight.
    own : OwnParts
        Parts of the loop that are one's own, built.
    """

    def __init__(
        self, core: _core.Flight, settings: CoreSettings, scenario: Scenario, own: OwnParts
    ) -> None:
        self._core, self._settings = core, settings
        self._controller, self._vehicle = settings.controller, as_core(scenario.vehicle)
        self._physics_step = scenario.plant.physics_step
        self._n_rotors, self._n_servos = scenario.vehicle.n_rotors, scenario.vehicle.n_servos
        self._own: dict[str, Any] = own.given()
        self._engine: Any = self._own.get("plant")
        self._names = {kind: named(kind, part) for kind, part in self._own.items()}
        self._decides_in_core = not self._own.keys() - {"plant", "disturbance"}
        self._moves_in_core = not self._own.keys() & {"plant", "disturbance"}
        self._steps_of_engine = steps_of(self._engine) if self._engine is not None else None

    @property
    def are_of_core(self) -> bool:
        """Whether no stage is one's own."""
        return not self._own

    @property
    def time(self) -> float:
        """Time flown, s."""
        return self._core.step * self._physics_step

    def begin(self, seed: int, flight: int) -> None:
        """Let an engine of one's own begin where the scenario does."""
        if self._engine is None:
            return
        start, tilt, thrust = self._settings.start, self._settings.tilt, self._settings.thrust
        try:
            self._ask_engine("reset", _state(start), tilt, thrust, seed | flight << 64)
            check_plant(self._engine)
            self._place(NO_PUSH, 0)
        except PartFailed as failed:
            failed.refuse()

    def change_controller(self, controller: _core.ControllerSettings) -> None:
        """Go on with another controller of the core, in place of one of one's own, too."""
        self._controller = controller
        for kind in ("controller", "allocator"):
            self._own.pop(kind, None)
        self._decides_in_core = not self._own.keys() - {"plant", "disturbance"}

    def true_state(self) -> State:
        """Return the motion, speeds, tilt and acceleration as they are.

        Raises
        ------
        ScenarioError
            If an engine of one's own fails to say its acceleration.
        """
        try:
            return self._true_state()
        except PartFailed as failed:
            raise ScenarioError(f"{failed.part} failed with {failed.what}.") from failed

    def _true_state(self) -> State:
        all_of_it, n = self._core.truth(), self._n_rotors
        acceleration = all_of_it[18:24]
        own = self._read("acceleration")
        if own is not None:
            acceleration = as_numbers(own).copy()
            if acceleration.shape != (6,):
                allowed = "six numbers, linear in W and angular in B"
                refused = ScenarioError.at("the plant", "acceleration", own, allowed)
                raise PartFailed(self._names["plant"], refused)
        return _state(all_of_it, all_of_it[24 : 24 + n], all_of_it[24 + n :], acceleration)

    # --- sense, estimate, track, allocate --------------------------------------------------------

    def decide(self, command: Command | None, demand: FloatArray | None) -> list[tuple[str, Log]]:
        """Decide what the actuators shall do, unless it is given; return what is to be logged.

        Raises
        ------
        PartFailed
            If a part of one's own raises, or its answer cannot be used.
        """
        core, own = self._core, self._own
        if self._decides_in_core and command is None and demand is None:
            self._pass_on(core.control(core.measure(), core.desired()))
            return []
        logs: list[tuple[str, Log]] = []
        row, known = self._estimate(logs)
        if command is not None:
            self._send(command, _wrench_of(command, _NOT_ASKED))
        elif demand is None and "controller" in own:
            desired = desired_from_row(core.desired())
            self._take(
                "controller", self._ask("controller", self.time, known, desired), _NOT_ASKED, logs
            )
        elif "allocator" in own:
            if demand is None:
                demand = _core.reference_acceleration(self._controller, row, core.desired())
            asked = _core.wrench_for(self._vehicle, row, demand)
            answer = self._ask("allocator", demand, known, self._last_command())
            self._take("allocator", answer, asked, logs)
        elif demand is not None:
            self._pass_on(core.answer(row, demand))
        else:
            self._pass_on(core.control(row, core.desired()))
        return logs

    def checked(self, command: Command) -> Command:
        """Return a command that is given, as arrays; `decide` takes no other.

        Raises
        ------
        ScenarioError
            If it cannot be sent.
        """
        if not isinstance(command, tuple) or len(command) != 2:
            raise ScenarioError.at("the flight", "command", command, "an omnimorph.Command")
        thrust, tilt = (np.atleast_1d(as_numbers(part)) for part in command)
        if not (np.isfinite(thrust).all() and np.isfinite(tilt).all()):
            raise ScenarioError.at("the flight", "command", command, "of finite numbers")
        counts = (self._n_rotors, self._n_servos)
        for name, part, count in zip(("thrust", "tilt"), (thrust, tilt), counts, strict=True):
            if part.size != count:
                raise ScenarioError(
                    f"the command cannot be used, because {name} has {part.size} numbers, "
                    f"not {count}."
                )
        asked = _wrench_of(command, _NOT_ASKED)
        return Command(thrust, tilt, asked, getattr(command, "log", None))

    def _estimate(self, logs: list[tuple[str, Log]]) -> tuple[FloatArray, State]:
        """Return the estimated motion, as 18 numbers and as a state."""
        core, true = self._core, self._true_state()
        extras = true.speed, true.tilt, true.acceleration
        if not self._own.keys() & {"sensors", "estimator"}:
            row = core.measure()
            return row, _state(row, *extras)
        if "sensors" in self._own:
            measured = self._ask("sensors", self.time, true)
            row = self._row("sensors", measured)
            logs.append((self._names["sensors"], getattr(measured, "log", {})))
        else:
            row = core.measured()
            measured = _state(row, *extras)
        if "estimator" not in self._own:
            row = core.estimate_from(row)
            names = ("speed", "tilt", "acceleration")
            return row, _state(row, *(getattr(measured, name, None) for name in names))
        known = self._ask("estimator", self.time, measured, self._last_command())
        row = self._row("estimator", known)
        logs.append((self._names["estimator"], getattr(known, "log", {})))
        return row, known if isinstance(known, State) else _state(row, *extras)

    def _row(self, kind: str, state: Any) -> FloatArray:
        """Return what a part of one's own says of the motion as 18 numbers."""
        parts = [as_numbers(part) for part in state] if isinstance(state, tuple) else []
        if [part.size for part in parts] != [3, 9, 3, 3]:
            refused = ScenarioError.at(f"the {kind}", "answer", state, "an omnimorph.State")
            raise PartFailed(self._names[kind], refused)
        return state_row(*parts, ())

    def _last_command(self) -> Command:
        decided = self._core.decided()
        return Command(decided.thrust, decided.tilt)

    def _take(self, kind: str, answer: Any, asked: FloatArray, logs: list[tuple[str, Log]]) -> None:
        """Send what a part of one's own decided."""
        try:
            self._send(answer, _wrench_of(answer, asked), f"{kind}'s ")
            logs.append((self._names[kind], getattr(answer, "log", {})))
        except PartFailed:  # the plant, which it is sent to
            raise
        except FAILURES as error:
            raise PartFailed(self._names[kind], error) from None

    def _send(self, command: Any, asked: FloatArray, whose: str = "") -> None:
        """Send a command to the plant; one that is not finite ends the flight.

        Raises
        ------
        ScenarioError
            If it does not have one thrust for each rotor and one tilt for each servo.
        """
        try:
            thrust, tilt = command
            try:
                self._core.decide(thrust, tilt, asked)
            except TypeError:  # not yet arrays of float64
                thrust, tilt = real_array(thrust), real_array(tilt)
                self._core.decide(thrust, tilt, asked)
        except (TypeError, ValueError, OverflowError) as problem:
            allowed = "a pair of thrusts, one for each rotor, and tilts, one for each servo"
            raise ScenarioError(
                f"the {whose}command cannot be used, because {problem}; it must be {allowed}."
            ) from None
        if self._engine is not None:
            self._pass_on(self._core.decided())  # not the arrays of who decided

    def _pass_on(self, decided: Any) -> None:
        """Send what was decided to an engine of one's own, too."""
        if self._engine is not None and self._core.status == _core.FlightStatus.FLYING:
            self._ask_engine("send", Command(decided.thrust, decided.tilt))

    # --- act -------------------------------------------------------------------------------------

    def move(self, push: FloatArray) -> None:
        """Let the plant go on for a control period, or to the end; each row is recorded.

        Raises
        ------
        PartFailed
            If a part of one's own raises, or its answer cannot be used.
        """
        core, left = self._core, self._settings.steps - self._core.step
        if self._moves_in_core:
            core.integrate(self._settings.control_every, push)
            return
        self._check_engine()
        for _ in range(min(self._settings.control_every, left)):
            self._advance(push + self._disturbance() if "disturbance" in self._own else push)
            if core.status != _core.FlightStatus.FLYING:
                return
        if core.step == self._settings.steps:
            core.finish_row()  # the last one

    def _advance(self, push: FloatArray) -> None:
        """Record a row; then one physics step."""
        if self._engine is None:
            self._core.integrate(1, push)
        elif self._core.finish_row():
            self._ask_engine("step_physics", 1, push)
            self._place(push, 1)

    def _disturbance(self) -> FloatArray:
        answer = self._ask("disturbance", self.time, self._true_state())
        push = as_numbers(answer)
        if push.shape != (6,) or not (self._engine is None or np.isfinite(push).all()):
            allowed = "six finite numbers, force in W and torque in B"
            refused = ScenarioError.at("the disturbance", "answer", answer, allowed)
            raise PartFailed(self._names["disturbance"], refused)
        return push

    # --- what is one's own -----------------------------------------------------------------------

    def _ask(self, kind: str, *arguments: Any) -> Any:
        try:
            return self._own[kind](*arguments)
        except FAILURES as error:
            raise PartFailed(self._names[kind], error) from error

    def _read(self, name: str) -> Any:
        """Return what an engine of one's own may have, and None where it has none."""
        try:
            return getattr(self._engine, name, None)
        except FAILURES as error:
            raise PartFailed(self._names["plant"], error) from error

    def _ask_engine(self, method: str, *arguments: Any) -> None:
        try:
            getattr(self._engine, method)(*arguments)
        except FAILURES as error:
            raise PartFailed(self._names["plant"], error) from error

    def _check_engine(self) -> None:
        """Refuse an engine that has other time steps than at first, or no rotation as attitude."""
        if self._engine is None:
            return
        try:
            steps = steps_of(self._engine)
            if steps != self._steps_of_engine:
                allowed = f"{self._steps_of_engine}, as when the flight began"
                raise ScenarioError.at("the plant", "steps in seconds", steps, allowed)
            R = self._core.truth()[3:12].reshape(3, 3)
            if not abs(R @ R.T - _IDENTITY).max() < _ORTHONORMAL:
                allowed = f"a rotation, orthonormal to {_ORTHONORMAL:g}"
                raise ScenarioError.at("the plant", "attitude", R, allowed)
        except FAILURES as error:
            raise PartFailed(self._names["plant"], error) from error

    def _place(self, push: FloatArray, steps_later: int) -> None:
        """Take over where the engine is; what is not finite ends the flight with this row."""
        engine, place = self._engine, cast(Any, self._core.place)
        try:
            thrust = getattr(engine, "thrust", None)
            p, R, v, w = engine.motion
            its: list[Any] = [p, R, v, w, engine.speed, engine.tilt, engine.wrench]
            its += [_UNKNOWN if thrust is None else thrust, push]
            try:
                finite = place(*its, steps_later)
            except TypeError:  # not yet arrays of float64
                finite = place(*map(real_array, its), steps_later)
        except (TypeError, ValueError, OverflowError) as problem:
            allowed = "a State, (n,) speeds, (m,) tilts and a (6,) wrench"
            text = f"the plant cannot be flown, because {problem}; it must give {allowed}."
            raise PartFailed(self._names["plant"], ScenarioError(text)) from None
        except FAILURES as error:
            raise PartFailed(self._names["plant"], error) from error
        if not finite:
            self._core.end_here(_core.FlightStatus.DIVERGED)


def steps_of(engine: Plant) -> tuple[float, float]:
    """Return the physics step and the control period of a plant, s.

    Raises
    ------
    ScenarioError
        If they are no positive numbers.
    """
    steps = []
    for name in ("physics_step", "control_period"):
        number = as_numbers(getattr(engine, name))
        if number.shape != () or not (np.isfinite(number) and number > 0.0):
            given = getattr(engine, name)
            raise ScenarioError.at("the plant", name, given, "a positive number of seconds")
        steps.append(float(number))
    return steps[0], steps[1]


def at_steps_of(engine: Any, scenario: Scenario) -> Scenario:
    """Return a scenario at the time steps of an engine of one's own, if there is one."""
    if engine is None:
        return scenario
    physics_step, control_period = steps_of(engine)
    plant = replace(scenario.plant, physics_step=physics_step, control_period=control_period)
    return replace(scenario, plant=plant)


def six_numbers(place: str, name: str, value: object) -> FloatArray:
    """Return six finite numbers: a wrench or an acceleration; refuse anything else."""
    numbers = as_numbers(value).copy()
    if numbers.shape != (6,) or not np.isfinite(numbers).all():
        allowed = "six finite numbers, linear in W and angular in B"
        raise ScenarioError.at(place, name, value, allowed)
    numbers.flags.writeable = False  # a part of one's own is given it
    return numbers


def _wrench_of(command: Any, otherwise: FloatArray) -> FloatArray:
    """Return the wrench that a command shall make, if it says it."""
    own = getattr(command, "wrench_asked", None)
    if own is None:
        return otherwise
    asked = as_numbers(own)
    if asked.shape != (6,):
        allowed = "six numbers, force and torque in B"
        raise ScenarioError.at("the command", "wrench_asked", own, allowed)
    return asked


def _state(
    row: FloatArray,
    speed: FloatArray | None = None,
    tilt: FloatArray | None = None,
    acceleration: FloatArray | None = None,
) -> State:
    """Return the first 18 numbers as a state, and what else is known."""
    return State(
        row[:3], row[3:12].reshape(3, 3), row[12:15], row[15:18], speed, tilt, acceleration
    )
