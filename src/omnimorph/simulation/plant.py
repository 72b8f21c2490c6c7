"""A plant that is stepped from Python (`SimulatedPlant`); `PlantModel` is what it is made of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.arrays import as_numbers
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.errors import OmnimorphError, ScenarioError
from omnimorph.model.core import as_thrust, as_tilt, state_row
from omnimorph.model.dynamics import hover_thrust
from omnimorph.model.stored_state import Copyable
from omnimorph.protocols import Command, FloatArray, State
from omnimorph.reference.rows import ROTATION, are_rotations
from omnimorph.simulation.plant_files import PlantLike, as_plant
from omnimorph.simulation.plant_model import INTEGRATORS, PlantModel, control_steps
from omnimorph.simulation.whole_number import rotor_index, whole_number

__all__ = [
    "INTEGRATORS",
    "PlantLike",
    "PlantModel",
    "SimulatedPlant",
    "as_plant",
    "control_steps",
    "core_motion",
]

_NO_WRENCH = np.zeros(6)
_AT_ORIGIN = State(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))

PARTS_OF_STATE = {"p": slice(0, 3), "R": slice(3, 12), "v": slice(12, 15), "w": slice(15, 18)}
"""Of the 18 numbers of a state, by the core's names."""


class SimulatedPlant(Copyable):
    """A plant that is stepped from Python (satisfies `omnimorph.protocols.Plant`).

    It can be copied and pickled in the middle of a flight, and goes on the same to the last bit.

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

    kind: ClassVar[str] = "plant"
    _in_core: _core.Plant

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
        self.vehicle, self.plant = as_vehicle(vehicle), as_plant(plant)
        self._steps_of_control = control_steps(self.plant)
        tilt = as_tilt(self.vehicle, start_tilt)
        if start_thrust is None:
            start_thrust = hover_thrust(self.vehicle, tilt)
        seed = whole_number("plant", "seed", seed, 64)
        flight = whole_number("plant", "flight", flight, 32)
        self.reset(_AT_ORIGIN if start is None else start, tilt, start_thrust, flight << 64 | seed)

    def reset(self, state: State, tilt: ArrayLike, thrust: ArrayLike, seed: int) -> None:
        """Begin anew, the same to the last bit as a new plant.

        Parameters
        ----------
        state : State
            Where it is, and how it moves.
        tilt : float or (m,), rad
            The servos' angles.
        thrust : (n,), N
            What the rotors give, and are asked for until the first command.
        seed : int
            Which noise: the lower 64 bits are the seed, the 32 above them the number of the flight.

        Raises
        ------
        InputError
            If one of them is of another shape or not finite.

        Examples
        --------
        >>> import numpy as np, omnimorph as om
        >>> plant = om.SimulatedPlant("omnimorph", om.PlantModel())
        >>> start = plant.motion
        >>> fallen = plant.step_physics(100, np.array([0.0, 0.0, -5.0, 0.0, 0.0, 0.0]))
        >>> plant.reset(start, 0.0, np.full(8, 1.6), seed=0)
        >>> plant.time, float(plant.motion.p_WB[2])
        (0.0, 0.0)
        """
        command = {
            "thrust": as_thrust(self.vehicle, thrust, "plant", "start_thrust"),
            "tilt": as_tilt(self.vehicle, tilt),
        }
        motion = core_motion(_start_row(state))
        self._seed = whole_number("plant", "seed", seed, 96)
        self._in_core = self._new_core({"motion": motion, "command": command})

    def _new_core(self, start: Mapping[str, Any] | None = None) -> _core.Plant:
        if start is None:
            n, m = self.vehicle.n_rotors, self.vehicle.n_servos
            nothing = {"thrust": np.zeros(n), "tilt": np.zeros(m)}
            start = {"motion": core_motion(_start_row(_AT_ORIGIN)), "command": nothing}
        settings = _core.LoopSettings(self.plant.core_fields(self.vehicle) | {"start": start})
        flight, seed = divmod(self._seed, 2**64)
        return _core.new_plant(settings=settings, seed=seed, flight=flight)

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self._in_core.step * self.plant.physics_step

    @property
    def physics_step(self) -> float:
        """Time that one step of `step_physics` takes, s."""
        return self.plant.physics_step

    @property
    def control_period(self) -> float:
        """Time between two commands, s."""
        return self.plant.control_period

    @property
    def motion(self) -> State:
        """The true motion, with the speeds, tilts and accelerations as they are."""
        return State(*self.state, self.speed, self.tilt, self.acceleration)

    @property
    def state(self) -> State:
        """The true motion."""
        return as_state(self._in_core.motion())

    @property
    def speed(self) -> FloatArray:
        """Actual rotor speeds, (n,) rad/s."""
        return self._in_core.speed()

    @property
    def tilt(self) -> FloatArray:
        """Actual servo angles, (m,) rad."""
        return self._in_core.tilt()

    @property
    def thrust(self) -> FloatArray:
        """What the rotors give along their axes now, (n,) N, less what wakes and damage take."""
        return self._in_core.thrust()

    @property
    def acceleration(self) -> FloatArray:
        """The (6,) acceleration now: linear (m/s², in W), then angular (rad/s², in B).

        By the true mass and inertia, of the rotors, gravity, all effects and the last push; with
        the actuators held, so without the torques of spinning rotors up and turning their axes.
        """
        return self._in_core.acceleration()

    @property
    def wrench(self) -> FloatArray:
        """The (6,) wrench that the rotors make now, N and N m, in B."""
        return self._in_core.wrench()

    def hub_load(self, rotor: int) -> FloatArray:
        """Return what a rotor loads its hub with now: force (N) and torque (N m), (6,), in B.

        Its thrust, as much of it as effectiveness and wakes leave, and its drag torque, both along
        its axis z(α) and about its hub; not the torques of spinning up and of turning its axis.

        Raises
        ------
        ScenarioError
            If there is no such rotor; they are counted from 0.
        """
        return self._in_core.hub_load(rotor_index(self.vehicle, rotor, "plant"))

    def measure(self) -> State:
        """Return the motion as the controller measures it, with this control step's noise."""
        return as_state(self._in_core.measure())

    def send(self, command: Command) -> None:
        """Put a command on its way to the actuators; at the beginning of a control period."""
        if self._in_core.step % self._steps_of_control:
            allowed = f"a multiple of the control period, {self.plant.control_period:g} s"
            raise ScenarioError.at("plant", "time of the command", self.time, allowed)
        try:
            parts = [as_numbers(part) for part in command]
        except TypeError as problem:  # no parts
            raise _unfit_command(problem) from None
        if not all(np.isfinite(part).all() for part in parts):
            raise ScenarioError.at("plant", "command", tuple(command), "finite numbers")
        if [part.size for part in parts] != [self.vehicle.n_rotors, self.vehicle.n_servos]:
            sizes = ", ".join(str(part.size) for part in parts)
            raise _unfit_command(ValueError(f"its parts are of so many numbers: {sizes}"))
        self._in_core.send(*parts)

    def step_physics(self, steps: int = 1, push: FloatArray = _NO_WRENCH) -> State:
        """Go on by physics steps under the commands sent; return the true motion.

        `push` is a (6,) wrench held over the steps: force (N, in W), torque (N m, in B).
        """
        wrench, steps = as_numbers(push), whole_number("plant", "steps", steps, 31)
        if wrench.shape != (6,) or not np.isfinite(wrench).all():
            raise ScenarioError.at("plant", "push", push, "six finite numbers")
        self._integrate(steps, wrench)
        return self.state

    def step(self, command: Command) -> State:
        """Apply a command for one control period; return the motion as measured after it."""
        self.send(command)
        self._integrate(self._steps_of_control, _NO_WRENCH)
        return self.measure()

    def _integrate(self, steps: int, push: FloatArray) -> None:
        self._in_core.advance(steps, push)
        if not np.isfinite(self._in_core.motion()).all():
            raise OmnimorphError("The plant cannot go on: its motion is no longer finite.")


def _start_row(state: State) -> FloatArray:
    """Return the 18 numbers of a state that a plant can begin with."""
    parts = [as_numbers(part) for part in state] if isinstance(state, tuple) else []
    row = state_row(*parts, ())
    if [part.size for part in parts] != [3, 9, 3, 3] or not np.isfinite(row).all():
        raise ScenarioError.at("plant", "start", state, "a State of finite numbers")
    if not are_rotations(row[3:12].reshape(1, 3, 3)).all():
        raise ScenarioError.at("plant", "attitude of the start", state[1], ROTATION)
    return row


def core_motion(row: FloatArray) -> dict[str, FloatArray]:
    """Return the 18 numbers of a state as the core's fields of a motion."""
    return {name: row[part] for name, part in PARTS_OF_STATE.items()}


def as_state(row: FloatArray) -> State:
    """Return the 18 numbers of a state of the core as a `State`."""
    return State(row[:3], row[3:12].reshape(3, 3), row[12:15], row[15:18])


def _unfit_command(problem: Exception) -> ScenarioError:
    allowed = "a pair of thrusts, one for each rotor, and tilts, one for each servo"
    place = "the controller's command"
    return ScenarioError(f"{place} cannot be used, because {problem}; it must be {allowed}.")
