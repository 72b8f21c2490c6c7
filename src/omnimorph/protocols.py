"""What can be plugged in: records that pass between the parts of a flight, and their protocols.

Frames: W is the world (z up), B the body at its centre of mass. Units are SI. Any object with the
right method is a controller, allocator, reference, disturbance or plant; nothing is subclassed::

    desired = reference(time)                           where to be
    command = controller(time, state, desired)          what the actuators shall do
    state = plant.step(command)                         what then happens
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Allocator",
    "Command",
    "Controller",
    "Desired",
    "Disturbance",
    "FloatArray",
    "Plant",
    "Reference",
    "State",
]

FloatArray = NDArray[np.float64]
"""An array of float64; the shape is in the documentation of each use."""


class State(NamedTuple):
    """Motion of the body at one instant.

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
    """

    p_WB: FloatArray
    R_WB: FloatArray
    v_WB: FloatArray
    w_WB_B: FloatArray


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


class Command(NamedTuple):
    """What the actuators are asked to do until the next command.

    Attributes
    ----------
    thrust : (n,) array, N
        Signed thrust of each rotor along its axis.
    tilt : (m,) array, rad
        Angle of each servo.
    """

    thrust: FloatArray
    tilt: FloatArray


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


class Plant(Protocol):
    """The vehicle that flies, real or simulated, one control step at a time."""

    def measure(self) -> State:
        """Return the motion as the sensors report it now."""

    def step(self, command: Command) -> State:
        """Apply `command` for one step and return the motion as measured after it."""
