"""What can be plugged in: records that pass between the parts of a flight, and their protocols.

Frames: W is the world (z up), B the body at its centre of mass. Units are SI. Any object with the
right methods is a part of the loop; nothing is subclassed::

    measured = sensors(time, state)                     what the vehicle measures
    known = estimator(time, measured, command)          what the controller knows
    desired = reference(time)                           where to be
    command = controller(time, known, desired)          what the actuators shall do
    plant.send(command)
    plant.step_physics(steps, push)                     what then happens
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
"""An array of float64; the shape is in the documentation of each use."""


Log = Mapping[str, Any]
"""What a part of the loop wants recorded: numbers by name, or pairs of numbers and their unit."""


class _Motion(NamedTuple):
    p_WB: FloatArray
    R_WB: FloatArray
    v_WB: FloatArray
    w_WB_B: FloatArray


class State(_Motion):
    """Motion of the body at one instant, and what else is known then.

    It is a tuple of four, ``p, R, v, w = state``; the rest are attributes, None where nobody says.

    Attributes
    ----------
    p_WB : (3,) array, m, in W
        Position of the centre of mass.
    R_WB : (3, 3) array
        Attitude: columns are the axes of B in W.
    v_WB : (3,) array, m/s, in W
        Velocity of the centre of mass.
    w_WB_B : (3,) array, rad/s, in B
        Angular velocity of B relative to W.
    speed : (n,) array, rad/s, or None
        Speed of each rotor.
    tilt : (m,) array, rad, or None
        Angle of each servo.
    acceleration : (6,) array or None
        Of the centre of mass (m/s², in W), then angular (rad/s², in B).
    """

    speed: FloatArray | None = None
    tilt: FloatArray | None = None
    acceleration: FloatArray | None = None

    def __new__(
        cls,
        p_WB: FloatArray,
        R_WB: FloatArray,
        v_WB: FloatArray,
        w_WB_B: FloatArray,
        speed: FloatArray | None = None,
        tilt: FloatArray | None = None,
        acceleration: FloatArray | None = None,
    ) -> Self:
        """Return a state; what is None stays an attribute of the class."""
        state = super().__new__(cls, p_WB, R_WB, v_WB, w_WB_B)
        if speed is not None:
            state.speed = speed
        if tilt is not None:
            state.tilt = tilt
        if acceleration is not None:
            state.acceleration = acceleration
        return state

    def _replace(self, **changes: Any) -> Self:
        return type(self)(**self._asdict() | vars(self) | changes)


class Estimate(State):
    """What an estimator knows of the motion: a `State`, and what it wants recorded.

    Attributes
    ----------
    log : mapping of str to array, or to (array, unit)
        Numbers that become columns of the run; the same names and shapes in every control step.

    Examples
    --------
    >>> import numpy as np
    >>> rest = State(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))
    >>> known = Estimate(*rest, log={"wind": (np.zeros(3), "m/s")})
    >>> known.p_WB.tolist(), list(known.log)
    ([0.0, 0.0, 0.0], ['wind'])
    """

    log: Log = {}  # noqa: RUF012 (never written to)

    def __new__(
        cls,
        p_WB: FloatArray,
        R_WB: FloatArray,
        v_WB: FloatArray,
        w_WB_B: FloatArray,
        speed: FloatArray | None = None,
        tilt: FloatArray | None = None,
        acceleration: FloatArray | None = None,
        log: Log | None = None,
    ) -> Self:
        """Return an estimate."""
        estimate = super().__new__(cls, p_WB, R_WB, v_WB, w_WB_B, speed, tilt, acceleration)
        if log is not None:
            estimate.log = log
        return estimate


class Desired(NamedTuple):
    """One point of a reference: the motion that is wanted at one instant.

    Attributes
    ----------
    p_WB : (3,) array, m, in W
        Position of the centre of mass.
    R_WB : (3, 3) array
        Attitude: columns are the axes of the desired B in W.
    v_WB : (3,) array, m/s, in W
        Velocity.
    w_WB_B : (3,) array, rad/s, in the desired B
        Angular velocity.
    a_WB : (3,) array, m/s², in W
        Acceleration of the centre of mass.
    dw_WB_B : (3,) array, rad/s², in the desired B
        Time derivative of `w_WB_B`.
    """

    p_WB: FloatArray
    R_WB: FloatArray
    v_WB: FloatArray
    w_WB_B: FloatArray
    a_WB: FloatArray
    dw_WB_B: FloatArray


class _ThrustAndTilt(NamedTuple):
    thrust: FloatArray
    tilt: FloatArray


class Command(_ThrustAndTilt):
    """What the actuators are asked to do until the next command.

    It is a pair, ``thrust, tilt = command``; the rest are attributes that the run records.

    Attributes
    ----------
    thrust : (n,) array, N
        Signed thrust of each rotor along its axis.
    tilt : (m,) array, rad
        Angle of each servo.
    wrench_asked : (6,) array or None
        The wrench it shall make: force (N), torque (N m), in B; None if its author says none.
    log : mapping of str to array, or to (array, unit)
        Numbers that become columns of the run; the same names and shapes in every control step.

    Examples
    --------
    >>> import numpy as np
    >>> command = Command(np.ones(8), np.zeros(1), log={"lift": (8.0, "N")})
    >>> thrust, tilt = command
    >>> command.wrench_asked is None, command.log["lift"]
    (True, (8.0, 'N'))
    """

    wrench_asked: FloatArray | None = None
    log: Log = {}  # noqa: RUF012 (never written to)

    def __new__(
        cls,
        thrust: FloatArray,
        tilt: FloatArray,
        wrench_asked: FloatArray | None = None,
        log: Log | None = None,
    ) -> Self:
        """Return a command; what is None stays an attribute of the class."""
        command = super().__new__(cls, thrust, tilt)
        if wrench_asked is not None:
            command.wrench_asked = wrench_asked
        if log is not None:
            command.log = log
        return command

    def _replace(self, **changes: Any) -> Self:
        return type(self)(**self._asdict() | vars(self) | changes)


class Reference(Protocol):
    """Where the vehicle shall be, as a function of time."""

    @property
    def duration(self) -> float:
        """Length of the reference in s; after it the last point is held."""

    def __call__(self, time: float) -> Desired:
        """Return the desired motion at `time` (s, from 0 to `duration`)."""


class Controller(Protocol):
    """From motion and wish to actuator commands; called once a control step."""

    def __call__(self, time: float, state: State, desired: Desired) -> Command:
        """Return the command for the control step that begins at `time` (s)."""


class Allocator(Protocol):
    """From a wanted acceleration to actuator commands that respect the limits."""

    def __call__(self, acceleration: FloatArray, state: State, previous: Command) -> Command:
        """Return the command that comes nearest to `acceleration`.

        Parameters
        ----------
        acceleration : (6,) array
            Linear acceleration (m/s², in W), then angular acceleration (rad/s², in B).
        state : State
            Measured motion.
        previous : Command
            The command of the control step before.
        """


class Disturbance(Protocol):
    """A wrench from outside, at the centre of mass; called once a physics step."""

    def __call__(self, time: float, state: State) -> FloatArray:
        """Return the (6,) wrench at `time` (s): force (N, in W), then torque (N m, in B)."""


class Sensors(Protocol):
    """From the true motion to what is measured of it; called once a control step."""

    def __call__(self, time: float, state: State) -> State:
        """Return what is measured at `time` (s) of the true `state`."""


class Estimator(Protocol):
    """From what is measured to what the controller knows; called once a control step."""

    def __call__(self, time: float, measured: State, previous: Command) -> State:
        """Return what is known of the motion at `time` (s).

        Parameters
        ----------
        time : float, s
        measured : State
            By the sensors; `State.speed`, `State.tilt` and `State.acceleration` are exact.
        previous : Command
            The command of the control step before.

        Returns
        -------
        State
            Or an `Estimate`, which can hold numbers to be recorded.
        """


class Plant(Protocol):
    """The vehicle that flies: an engine of one's own, or `omnimorph.SimulatedPlant`.

    A plant may also have a ``thrust``, the (n,) N that its rotors give along their axes, and an
    ``acceleration``, (6,) as `State.acceleration`. Where it has none, they are those of the
    scenario's own plant in the same motion.
    """

    @property
    def physics_step(self) -> float:
        """Time that one step of `step_physics` takes, s."""

    @property
    def control_period(self) -> float:
        """Time between two commands, s: a multiple of the physics step."""

    @property
    def motion(self) -> State:
        """The true motion now."""

    @property
    def speed(self) -> FloatArray:
        """Actual rotor speeds, (n,) rad/s."""

    @property
    def tilt(self) -> FloatArray:
        """Actual servo angles, (m,) rad."""

    @property
    def wrench(self) -> FloatArray:
        """The (6,) wrench that the rotors make now: force (N), torque (N m), in B."""

    def reset(self, state: State, tilt: FloatArray, thrust: FloatArray, seed: int) -> None:
        """Begin anew.

        Parameters
        ----------
        state : State
            The motion.
        tilt, thrust : (m,) rad, (n,) N
            What the servos and rotors begin with.
        seed : int
            Of all that is drawn, not negative and of any size: flights of one seed have their own.
        """

    def send(self, command: Command) -> None:
        """Put a command on its way to the actuators, at the beginning of a control period."""

    def step_physics(self, steps: int, push: FloatArray, /) -> object:
        """Go on by physics steps under a (6,) push: force (N, in W), torque (N m, in B)."""
