"""The plant: what it is made of (`PlantModel`), and one to fly step by step (`SimulatedPlant`).

Within a physics step the actuators move first, then the body: with semi-implicit Euler the new
actuators give the wrench, the new velocities give the pose; fourth-order Runge-Kutta takes the
actuators at the start, middle and end of the step.
"""

from __future__ import annotations

import operator
import os
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.arrays import as_numbers
from omnimorph.design.documents import record_or_file
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.ranges import Range
from omnimorph.design.records import Record, quantity
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import OmnimorphError, ScenarioError
from omnimorph.model.core import as_core, as_tilt, in_float64, state_row
from omnimorph.model.dynamics import hover_thrust
from omnimorph.protocols import Command, FloatArray, State
from omnimorph.reference.rows import ROTATION, are_rotations
from omnimorph.simulation.effects import ConstantWrench, Effect, PlantBuild
from omnimorph.simulation.whole_number import whole_number

__all__ = [
    "INTEGRATORS",
    "NOT_ASKED",
    "TIME_STEPS",
    "PlantLike",
    "PlantModel",
    "SimulatedPlant",
    "as_plant",
    "control_steps",
    "core_motion",
]

INTEGRATORS = ("semi-implicit-euler", "runge-kutta-4")
_NO_WRENCH = np.zeros(6)
NOT_ASKED = np.full(6, np.nan)
"""The wrench asked for by what gives commands alone."""
_POSITIVE = "a positive number of milliseconds"

PARTS_OF_STATE = {"p": slice(0, 3), "R": slice(3, 12), "v": slice(12, 15), "w": slice(15, 18)}
"""Of the 18 numbers of a state, by the core's names."""

TIME_STEPS = Range(1e-3, 1e4)
"""Of physics step and control period, ms."""


@dataclass(frozen=True, kw_only=True)
class PlantModel(Record):
    """How the vehicle really behaves: time steps, integrator, and a list of imperfections.

    Attributes
    ----------
    name : str
        What reports call it.
    physics_step, control_period : float, s
        The period is a multiple of the step.
    integrator : str
        ``semi-implicit-euler`` or ``runge-kutta-4`` (on SO(3)).
    effects : tuple of Effect
        Each kind once, but for constant wrenches, which add up.

    Raises
    ------
    ScenarioError
        If the period is no multiple of the step, or an effect stands twice.
    """

    kind: ClassVar[str] = "plant"
    physics_step: float = quantity("ms", TIME_STEPS, _POSITIVE, default=1e-3)
    control_period: float = quantity("ms", TIME_STEPS, _POSITIVE, default=1e-3)
    integrator: Literal["semi-implicit-euler", "runge-kutta-4"] = "semi-implicit-euler"
    effects: tuple[Effect, ...] = ()
    name: str = "own"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.integrator not in INTEGRATORS:
            allowed = " or ".join(INTEGRATORS)
            raise ScenarioError.at("plant", "integrator", self.integrator, allowed)
        control_steps(self)
        if not isinstance(self.effects, tuple):
            raise ScenarioError.at("plant", "effects", self.effects, "a sequence of effects")
        seen: set[str] = set()
        for effect in self.effects:
            if not isinstance(effect, Effect):
                raise ScenarioError.at("plant", "effects", effect, "a sequence of effects")
            if effect.kind in seen and not isinstance(effect, ConstantWrench):
                raise ScenarioError.at("plant", "effect", effect.kind, "there only once")
            seen.add(effect.kind)

    def true_vehicle(self, vehicle: Vehicle) -> Vehicle:
        """Return the vehicle that really flies when the controller believes in `vehicle`."""
        known: tuple[Vehicle | None, Vehicle] = vars(self).get("_last_truth", (None, vehicle))
        believed, truth = known
        if believed is not vehicle:  # the same one is asked for again and again
            truth = vehicle
            for effect in self.effects:
                truth = effect.true_vehicle(truth)
            vars(self)["_last_truth"] = vehicle, truth
        return truth

    def core_fields(self, vehicle: Vehicle) -> dict[str, Any]:
        """Return the fields of the core's loop that a plant says, for a controller's vehicle."""
        truth = self.true_vehicle(vehicle)
        plant: dict[str, Any] = {
            "vehicle": as_core(truth),
            "command_coefficient": vehicle.thrust_coefficient,
            "effectiveness": np.ones(vehicle.n_rotors),
            "step": self.physics_step,
            "integrator": self.integrator,
        }
        sensors: dict[str, Any] = {}
        build = PlantBuild(plant, sensors, truth, self.control_period, self.physics_step)
        for effect in self.effects:
            effect.add_to(build)
        sensors.setdefault("estimator", ("low-pass", {"cutoff": np.zeros(4)}))  # which passes all
        periods = {
            "control_every": control_steps(self),
            "control_period": self.control_period,
        }
        return in_float64({"plant": plant} | sensors | periods)


def control_steps(plant: PlantModel) -> int:
    """Return the number of physics steps in a control period; refuse a broken number."""
    ratio = plant.control_period / plant.physics_step
    steps = round(ratio)
    if steps < 1 or abs(ratio - steps) > 1e-9 * ratio:
        allowed = f"a multiple of the physics step, {plant.physics_step * 1e3:g} ms"
        raise ScenarioError.at("plant", "control_period_ms", plant.control_period * 1e3, allowed)
    return steps


PlantLike = PlantModel | str | os.PathLike[str]
"""A plant, or the name or file of one."""


def as_plant(plant: PlantLike) -> PlantModel:
    """Return a plant that may be given as a name of the catalogue or as a file.

    Raises
    ------
    ScenarioError
        As `omnimorph.load_plant` does, and if it is anything else.
    """
    return record_or_file(plant, PlantModel, "plant", _load, ScenarioError)


def _load(name_or_path: str | os.PathLike[str]) -> PlantModel:
    from omnimorph.simulation.scenario_files import load_plant  # which imports this file

    return load_plant(name_or_path)


class SimulatedPlant:
    """A plant that is stepped from Python (satisfies `omnimorph.protocols.Plant`).

    Parameters
    ----------
    vehicle : Vehicle
        The vehicle as its controller knows it; the plant's effects make the true one of it.
    plant : PlantModel
        How it behaves.
    start : State, optional
        At rest at the origin, upright, by default.
    start_tilt : float or (m,), rad
        The servos' angles.
    start_thrust : (n,), optional, N
        Hovering by default.
    seed, flight : int
        Which noise.

    Examples
    --------
    >>> import numpy as np, omnimorph as om
    >>> plant = om.SimulatedPlant(om.load_vehicle("omnimorph"), om.PlantModel())
    >>> rest = om.Command(np.zeros(8), np.zeros(1))
    >>> state = plant.step(rest)                       # one control step, here 1 ms, of free fall
    >>> round(float(state.v_WB[2]), 6)
    -0.00981
    """

    def __init__(
        self,
        vehicle: VehicleLike,
        plant: PlantLike,
        *,
        start: State | None = None,
        start_tilt: ArrayLike = 0.0,
        start_thrust: FloatArray | None = None,
        seed: int = 0,
        flight: int = 0,
    ) -> None:
        vehicle, plant = as_vehicle(vehicle), as_plant(plant)
        if start is None:
            start = State(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))
        tilt = as_tilt(vehicle, start_tilt)
        self.plant = plant
        self._steps_of_control = control_steps(plant)
        thrust = hover_thrust(vehicle, tilt)
        if start_thrust is not None:
            thrust = as_numbers(start_thrust)
        if thrust.shape != (vehicle.n_rotors,) or not np.isfinite(thrust).all():
            allowed = f"{vehicle.n_rotors} finite numbers of newtons"
            raise ScenarioError.at("plant", "start_thrust", start_thrust, allowed)
        parts = [as_numbers(part) for part in start] if isinstance(start, tuple) else []
        row = state_row(*parts, ())
        if [part.size for part in parts] != [3, 9, 3, 3] or not np.isfinite(row).all():
            raise ScenarioError.at("plant", "start", start, "a State of finite numbers")
        if not are_rotations(row[3:12].reshape(1, 3, 3)).all():
            raise ScenarioError.at("plant", "attitude of the start", start[1], ROTATION)
        begins = {"motion": core_motion(row), "command": {"thrust": thrust, "tilt": tilt}}
        settings = _core.LoopSettings(plant.core_fields(vehicle) | {"start": begins})
        seed = whole_number("plant", "seed", seed, 64)
        flight = whole_number("plant", "flight", flight, 32)
        self._plant = _core.new_plant(settings=settings, seed=seed, flight=flight)
        self._counts = vehicle.n_rotors, vehicle.n_servos

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self._plant.step * self.plant.physics_step

    @property
    def state(self) -> State:
        """The true motion."""
        return as_state(self._plant.motion())

    @property
    def speed(self) -> FloatArray:
        """Actual rotor speeds, (n,) rad/s."""
        return self._plant.speed()

    @property
    def tilt(self) -> FloatArray:
        """Actual servo angles, (m,) rad."""
        return self._plant.tilt()

    @property
    def wrench(self) -> FloatArray:
        """The (6,) wrench that the rotors make now, N and N m, in B."""
        return self._plant.wrench()

    def hub_load(self, rotor: int) -> FloatArray:
        """Return what a rotor loads its hub with now: force (N) and torque (N m), (6,), in B.

        Its thrust, as much of it as effectiveness and wakes leave, and its drag torque, both along
        its axis z(α) and about its hub; not the torques of spinning up and of turning its axis.

        Raises
        ------
        ScenarioError
            If there is no such rotor; they are counted from 0.
        """
        n_rotors = self._counts[0]
        try:
            index = operator.index(rotor)
        except TypeError:
            index = -1
        if isinstance(rotor, bool) or not 0 <= index < n_rotors:
            raise ScenarioError.at("plant", "rotor", rotor, f"a number from 0 to {n_rotors - 1}")
        return self._plant.hub_load(index)

    def measure(self) -> State:
        """Return the motion as the controller measures it, with this control step's noise."""
        return as_state(self._plant.measure())

    def send(self, command: Command) -> None:
        """Put a command on its way to the actuators; at the beginning of a control period."""
        if self._plant.step % self._steps_of_control:
            allowed = f"a multiple of the control period, {self.plant.control_period:g} s"
            raise ScenarioError.at("plant", "time of the command", self.time, allowed)
        try:
            parts = [as_numbers(part) for part in command]
        except TypeError as problem:  # no parts
            raise _unfit_command(problem) from None
        if not all(np.isfinite(part).all() for part in parts):
            raise ScenarioError.at("plant", "command", tuple(command), "finite numbers")
        if tuple(part.size for part in parts) != self._counts:
            sizes = ", ".join(str(part.size) for part in parts)
            raise _unfit_command(ValueError(f"its parts are of so many numbers: {sizes}"))
        self._plant.send(*parts)

    def step_physics(self, steps: int = 1, disturbance: FloatArray = _NO_WRENCH) -> State:
        """Go on by physics steps under the commands sent; return the true motion.

        `disturbance` is a (6,) wrench held over the steps: force (N, in W), torque (N m, in B).
        """
        push, steps = as_numbers(disturbance), whole_number("plant", "steps", steps, 31)
        if push.shape != (6,) or not np.isfinite(push).all():
            raise ScenarioError.at("plant", "disturbance", disturbance, "six finite numbers")
        self._integrate(steps, push)
        return self.state

    def step(self, command: Command) -> State:
        """Apply a command for one control period; return the motion as measured after it."""
        self.send(command)
        self._integrate(self._steps_of_control, _NO_WRENCH)
        return self.measure()

    def _integrate(self, steps: int, disturbance: FloatArray) -> None:
        self._plant.advance(steps, disturbance)
        if not np.isfinite(self._plant.motion()).all():
            raise OmnimorphError("The plant cannot go on: its motion is no longer finite.")


def core_motion(row: FloatArray) -> dict[str, FloatArray]:
    """Return the 18 numbers of a state as the core's fields of a motion."""
    return {name: row[part] for name, part in PARTS_OF_STATE.items()}


def as_state(row: FloatArray) -> State:
    """Return the 18 numbers of a state of the core as a `State`."""
    return State(row[:3], row[3:12].reshape(3, 3), row[12:15], row[15:18])


def send(flight: _core.Flight, command: Command, wrench_asked: FloatArray) -> bool:
    """Send a command made in Python to a flight of the core; False if it is not finite.

    Raises
    ------
    ScenarioError
        If it does not have one thrust for each rotor and one tilt for each servo.
    """
    try:
        thrust, tilt = command
        try:
            return flight.decide(thrust, tilt, wrench_asked)
        except TypeError:  # not yet arrays of float64
            thrust, tilt = (np.ascontiguousarray(part, dtype=np.float64) for part in command)
            return flight.decide(thrust, tilt, wrench_asked)
    except (TypeError, ValueError, OverflowError) as problem:
        raise _unfit_command(problem) from None


def _unfit_command(problem: Exception) -> ScenarioError:
    allowed = "a pair of thrusts, one for each rotor, and tilts, one for each servo"
    place = "the controller's command"
    return ScenarioError(f"{place} cannot be used, because {problem}; it must be {allowed}.")
