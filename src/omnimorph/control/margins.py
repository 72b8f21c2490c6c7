"""How far a pose loop is from oscillating, with the rotors' lag and the delay in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph.control.capability import capability
from omnimorph.control.tracking import GainsLike, TrackingGains
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.ranges import Range
from omnimorph.design.records import record_of
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.protocols import FloatArray

AXES = ("x", "y", "z", "roll", "pitch", "yaw")
"""The six axes: positions along those of W, attitudes about those of B."""

_PERIODS, _DELAYS = Range(1e-9, 10.0), Range(0.0, 1e3)  # s
_FREQUENCIES = 20_001
_Response = NDArray[np.complex128]


@dataclass(frozen=True, eq=False, kw_only=True)
class StabilityMargins:
    """Margins of the six loops: x, y, z, roll, pitch, yaw.

    Attributes
    ----------
    crossover : (6,) array, rad/s
        Where the open loop has gain 1; 0 for an axis without gains, whose margins are inf.
    phase_margin : (6,) array, rad
        What phase is left there; not positive if the loop is unstable.
    gain_margin : (6,) array
        The factor on the gains at which it oscillates; below 1 if the loop is unstable, 0 if it is
        at any gain.
    delay_margin : (6,) array, s
        The further delay at which it oscillates, phase margin over crossover; an axis that moves by
        leaning has no more than the attitude has.
    """

    crossover: FloatArray
    phase_margin: FloatArray
    gain_margin: FloatArray
    delay_margin: FloatArray

    @property
    def stable(self) -> bool:
        """Whether every loop is stable."""
        return bool((self.phase_margin > 0.0).all())


def rotor_lag(vehicle: Vehicle) -> float:
    """Return the slowest rotor's time constant, up or down, s.

    Around a speed the thrust c_f w|w| follows with the lag of the speed itself.
    """
    return float(max(vehicle.time_constant_up.max(), vehicle.time_constant_down.max()))


def check_times(control_period: float, delay: float) -> None:
    """Refuse a control period that is not positive, or a negative delay, or what is not finite."""
    if control_period not in _PERIODS:
        allowed = f"a positive number of seconds, {_PERIODS}"
        raise ScenarioError.at("the loop", "control_period", control_period, allowed)
    if delay not in _DELAYS:
        allowed = f"a number of seconds, not negative, {_DELAYS}"
        raise ScenarioError.at("the loop", "delay", delay, allowed)


def stability_margins(
    gains: GainsLike,
    vehicle: VehicleLike,
    control_period: float = 0.004,
    delay: float = 0.0,
    start_tilt: ArrayLike = 0.0,
) -> StabilityMargins:
    """Return the margins of the pose loops of a vehicle, linear and axis by axis.

    ::

        L(s) = (k_p + k_v s) / s² · 1 / (τ s + 1) · exp(−s (delay + period / 2))

    A command that is held for a period is late by half of it on average. Where the vehicle moves
    sideways only by leaning, the acceleration comes through the closed attitude loop (the slower of
    roll and pitch, with gains k and r), position first::

        L(s) = (k_p + k_v s) / s² · k P / (s² + (k + r s) P)
        P(s) = 1 / (τ s + 1) · exp(−s (delay + period / 2))

    The loops are those of small errors within the limits; neither saturation nor the allocation's
    own weights nor the servos are in them.

    Parameters
    ----------
    gains : TrackingGains
        Of the pose controller; or what holds them, a scenario or a proposed controller.
    vehicle : Vehicle
        For its rotors' lag τ, and whether it leans.
    control_period, delay : float, s
        Time between two commands, and delay anywhere in the loop.
    start_tilt : float or (m,) array, rad
        The tilt of servos that the controller does not move.

    Returns
    -------
    StabilityMargins
        Six of each.

    Raises
    ------
    ScenarioError, VehicleError
        If a time cannot be used, or the vehicle cannot hover.

    Examples
    --------
    The paper's attitude gains on OmniMorph, 20 ms of lag at 4 ms:

    >>> import omnimorph as om
    >>> found = stability_margins(om.TrackingGains(), om.load_vehicle("omnimorph"))
    >>> [round(float(one), 1) for one in (found.crossover[3], 1e3 * found.delay_margin[3])]
    [33.4, 25.2]
    """
    vehicle = as_vehicle(vehicle)
    gains = record_of("the loop", "gains", gains, TrackingGains)
    check_times(control_period, delay)
    tau, late = rotor_lag(vehicle), delay + control_period / 2.0
    stiffness = np.concatenate([gains.axes("position"), gains.axes("attitude")])
    damping = np.concatenate([gains.axes("velocity"), gains.axes("rate")])
    rates = np.concatenate([damping, np.sqrt(stiffness), [1.0 / late]])
    w = np.geomspace(1e-3 * rates[rates > 0.0].min(), 10.0 * rates.sum(), _FREQUENCIES)
    s = 1j * w
    actuator = np.exp(-s * late) / (tau * s + 1.0)
    errors = (stiffness[:, None] + damping[:, None] * s) / s**2
    found = np.array([_margins(w, error * actuator) for error in errors])
    if capability(vehicle, start_tilt).leans:
        slow = 3 + int(np.argmin(found[3:5, 0]))
        closed = stiffness[slow] * actuator / (s**2 + errors[slow] * s**2 * actuator)
        for axis in (0, 1):
            found[axis] = _margins(w, errors[axis] * closed)
            found[axis, 1:] = np.minimum(found[axis, 1:], _at_most(found[slow, 1:]))
    columns = ("crossover", "phase_margin", "gain_margin", "delay_margin")
    return StabilityMargins(**dict(zip(columns, found.T.copy(), strict=True)))


def _at_most(inner: FloatArray) -> FloatArray:
    """Return what bounds the margins of a loop around another: all of them if that is unstable."""
    return inner if inner[0] <= 0.0 else np.array([np.inf, np.inf, inner[2]])


def _margins(w: FloatArray, L: _Response) -> tuple[float, float, float, float]:
    """Return crossover, phase, gain and delay margin of an open loop known at frequencies."""
    if not L.any():
        return 0.0, np.inf, np.inf, np.inf
    size, phase = np.log(np.abs(L)), np.unwrap(np.angle(L))
    phase += 2.0 * np.pi * np.round((-np.pi - phase[0]) / (2.0 * np.pi))  # begins near −180°
    x = np.log(w)
    crossover = float(np.exp(_first_fall(x, size, x)))
    left = float(np.interp(np.log(crossover), x, phase)) + np.pi
    above = phase + np.pi > 0.0
    gain = float(np.exp(-_first_fall(x, phase + np.pi, size))) if above.any() else 0.0
    return crossover, left, gain, left / crossover


def _first_fall(x: FloatArray, y: FloatArray, value: FloatArray) -> float:
    """Return `value` where y first falls through zero, linear between the points x."""
    k = int(np.flatnonzero((y[:-1] > 0.0) & (y[1:] <= 0.0))[0])
    share = y[k] / (y[k] - y[k + 1])
    return float(value[k] + share * (value[k + 1] - value[k]))
