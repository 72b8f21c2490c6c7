"""A plant to fly step by step (`SimulatedPlant`); what it is made of is a `PlantModel`."""

from __future__ import annotations

import operator

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.arrays import as_numbers
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.errors import OmnimorphError, ScenarioError
from omnimorph.model.core import as_tilt, state_row
from omnimorph.model.dynamics import hover_thrust
from omnimorph.protocols import Command, FloatArray, State
from omnimorph.reference.rows import ROTATION, are_rotations
from omnimorph.simulation.plant_files import PlantLike, as_plant
from omnimorph.simulation.plant_model import INTEGRATORS, PlantModel, control_steps
from omnimorph.simulation.whole_number import whole_number

__all__ = [
    "INTEGRATORS",
    "NOT_ASKED",
    "PlantLike",
    "PlantModel",
    "SimulatedPlant",
    "as_plant",
    "control_steps",
    "core_motion",
]

_NO_WRENCH = np.zeros(6)
NOT_ASKED = np.full(6, np.nan)
"""The wrench asked for by what gives commands alone."""

PARTS_OF_STATE = {"p": slice(0, 3), "R": slice(3, 12), "v": slice(12, 15), "w": slice(15, 18)}
"""Of the 18 numbers of a state, by the core's names."""


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
