"""A flight at one moment, read off a run; and the clock by which it is played."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import RunFileError
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.protocols import FloatArray
from omnimorph.results.curves import attitude_error, attitude_error_between, position_error_mm
from omnimorph.results.run import Run
from omnimorph.viewer.shapes import wxyz_of

_FARTHEST = 1e6  # m
_MOST_ROWS_OF_PATH = 600
_BYTES_OF_A_MOMENT = 64  # errors and what finds the rows that can be shown
# A second, of the fastest rotor: what an eye, and 30 pictures a second, can follow.
_TURNS_SHOWN = 1.0


class Frame(NamedTuple):
    """What is seen of a vehicle at one moment; n rotors, m servos.

    Attributes
    ----------
    time : float
        s.
    p_WB, wxyz : (3,) array, m, and (4,) array
        Pose: position, and attitude as a quaternion.
    desired_p_WB, desired_wxyz : arrays
        The desired pose, likewise.
    tilt : (m,) array, rad
        Actual angles.
    speed : (n,) array, rad/s
        Actual, signed.
    turns : (n,) array, rad
        How far the blades have turned about their thrust axes, slowed down for the eye.
    thrust : (n,) array, N
        Actual, signed; not a number if the run does not say.
    active : (n,) array
        −1 or 1 where the commanded thrust is at its lower or upper limit.
    missed_W : (3,) array, N
        Force asked for that the rotors do not make, in W; not a number if nobody asked for one.
    power : float
        Rotor drag power, W.
    position_error_mm, attitude_error_deg : float
        Distance and angle between the actual and the desired pose.
    """

    time: float
    p_WB: FloatArray
    wxyz: FloatArray
    desired_p_WB: FloatArray
    desired_wxyz: FloatArray
    tilt: FloatArray
    speed: FloatArray
    turns: FloatArray
    thrust: FloatArray
    active: FloatArray
    missed_W: FloatArray
    power: float
    position_error_mm: float
    attitude_error_deg: float


class Flight:
    """A run to be looked at: its curves, and what is seen at any time.

    Parameters
    ----------
    run : Run
        The flight.
    name : str
        What the page calls it.

    Attributes
    ----------
    run : Run
        Of it what can be shown: a flight that diverged ends in rows that cannot.
    vehicle : Vehicle
        What flew.
    duration : float, s

    Raises
    ------
    RunFileError
        If not even the first row can be shown.
    TooLargeError
        If its curves are more than memory holds.
    """

    def __init__(self, run: Run, name: str) -> None:
        rows = len(run.time)
        needed = rows * (_BYTES_OF_A_MOMENT + 24 * run.vehicle.n_rotors)  # 24: turns of the blades
        refuse_more_than_memory(f"{name}: the curves of {rows} rows", needed, "show a shorter one")
        shown = can_be_shown(vars(run), slice(None))
        if not shown[0]:
            raise RunFileError(f"{name}: no moment of the run can be shown: it is not finite.")
        if not shown.all():
            run = run.first_rows(int(shown.argmin()))
        self.run, self.name = run, name
        self.vehicle = run.vehicle
        self.duration = float(run.time[-1])

    @property
    def path(self) -> FloatArray:
        """The whole path, thinned for the screen: (K, 3) m."""
        return self.run.p_WB[:: max(len(self.run.time) // _MOST_ROWS_OF_PATH, 1)]

    @cached_property
    def position_error_mm(self) -> FloatArray:
        """Distance from the desired position, (K,) mm."""
        return position_error_mm(self.run)

    @cached_property
    def attitude_error_deg(self) -> FloatArray:
        """Angle between the actual and the desired attitude, (K,) degrees."""
        return attitude_error(self.run).angle_deg

    def row_at(self, time: float) -> int:
        """Return the row of the run that is nearest to a time, s."""
        row = round(time / self.run.provenance.physics_step)
        return min(max(row, 0), len(self.run.time) - 1)

    def frame(self, row: int) -> Frame:
        """Return what is seen in a row of the run."""
        run = self.run
        return frame_of(vars(run), row, float(run.time[row]), self._turns[row], run.drag_power[row])

    @cached_property
    def _turns(self) -> FloatArray:
        step = self.run.provenance.physics_step
        return np.cumsum(blade_turns(self.vehicle, self.run.speed, step), axis=0)


def can_be_shown(columns: Mapping[str, Any], rows: slice) -> NDArray[np.bool_]:
    """Return which of some rows of a run's columns can be shown: finite, and within sight."""
    p = columns["p_WB"][rows]
    seen = (p, columns["R_WB"][rows], columns["speed"][rows], columns["tilt_actual"][rows])
    finite = [np.isfinite(part.reshape(len(p), -1)).all(axis=1) for part in seen]
    near = (np.abs(p) < _FARTHEST).all(axis=1)
    return np.asarray(np.all(finite, axis=0) & near)


def frame_of(
    columns: Mapping[str, Any], row: int, time: float, turns: FloatArray, power: float
) -> Frame:
    """Return what is seen in a row of a run's columns.

    Parameters
    ----------
    columns : mapping of str to array
        By name; rows after `row` need not be flown yet.
    row : int
        Which.
    time : float, s
    turns : (n,) array, rad
        See `Frame`.
    power : float, W
        Rotor drag power.
    """

    def at(name: str) -> Any:
        return columns[name][row]

    R = np.stack([at("R_WB"), at("desired_R_WB")])
    missed = at("wrench_asked")[:3] - at("wrench_achieved")[:3]
    wxyz, desired_wxyz = wxyz_of(R)
    return Frame(
        time=time,
        p_WB=at("p_WB"),
        wxyz=wxyz,
        desired_p_WB=at("desired_p_WB"),
        desired_wxyz=desired_wxyz,
        tilt=at("tilt_actual"),
        speed=at("speed"),
        turns=turns,
        thrust=at("thrust_actual"),
        active=at("active").astype(np.float64),
        missed_W=R[0] @ missed,
        power=float(power),
        position_error_mm=1e3 * float(np.linalg.norm(at("p_WB") - at("desired_p_WB"))),
        attitude_error_deg=float(attitude_error_between(R[:1], R[1:]).angle_deg[0]),
    )


class Playback:
    """Which time is shown: played at a speed, stopped, or moved by hand.

    Parameters
    ----------
    duration : float
        Of the longest flight, s.

    Examples
    --------
    >>> playback = Playback(2.0)
    >>> playback.play()
    >>> playback.speed = 0.5
    >>> playback.advance(1.0)
    >>> playback.time
    0.5
    """

    def __init__(self, duration: float) -> None:
        self.duration = duration
        self.time = 0.0
        self.speed = 1.0
        self.is_playing = False

    def play(self) -> None:
        """Go on; from the beginning, if the end is reached."""
        if self.time >= self.duration:
            self.time = 0.0
        self.is_playing = True

    def pause(self) -> None:
        """Stop where it is."""
        self.is_playing = False

    def move_to(self, time: float) -> None:
        """Show another time, s, within the flight."""
        self.time = min(max(time, 0.0), self.duration)

    def advance(self, seconds: float) -> None:
        """Let so much time pass for who looks, s; the end stops it."""
        if self.is_playing:
            self.move_to(self.time + self.speed * seconds)
            self.is_playing = self.time < self.duration


def blade_turns(vehicle: Vehicle, speed: FloatArray, seconds: float) -> FloatArray:
    """Return by how much the blades turn on the screen, rad, in their true sense, slowed down.

    The sense about the thrust axis is that of the rotor, k sign(w).

    Parameters
    ----------
    vehicle : Vehicle
        Whose spins k and largest speeds count.
    speed : (…, n) array, rad/s
        Of the rotors, signed.
    seconds : float
        How long.
    """
    fastest = np.maximum(np.abs(vehicle.speed_max), np.abs(vehicle.speed_min)).max()
    slowed = 2.0 * np.pi * _TURNS_SHOWN / fastest
    turns: FloatArray = slowed * seconds * vehicle.rotor_spin * speed
    return turns
