"""Hovering: with which thrusts, at what power, in which attitudes and at which tilts.

Only the direction of gravity in the body counts: an attitude is represented by *up*, the vertical
seen from the body, ``R_WBᵀ e3``. Level is (0, 0, 1), upside down (0, 0, −1).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph.analysis.effort import Effort, drag_power, least_effort
from omnimorph.analysis.scaling import checked_tilt
from omnimorph.arrays import as_numbers
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import InputError, VehicleError
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.model.allocation import rotor_speed
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray
from omnimorph.reference.rows import ROTATION, are_rotations

_TURN = 2.0 * math.pi


@dataclass(frozen=True, eq=False, kw_only=True)
class HoverPoint:
    """How a vehicle hovers in one attitude at one tilt.

    Attributes
    ----------
    tilt : (m,) array, rad
        Of each servo.
    up : (3,) array
        The vertical seen from the body, R_WBᵀ e3.
    feasible : bool
        Whether any thrusts within the limits hold the weight without a moment.
    thrust : (n,) array, N
        The best of them; zeros if there are none.
    speed : (n,) array, rad/s
        Of the rotors, signed.
    power : float
        Σ c_tau |w|³, W, the rotor drag power; inf if it is not feasible.
    """

    tilt: FloatArray
    up: FloatArray
    feasible: bool
    thrust: FloatArray
    speed: FloatArray
    power: float

    @property
    def power_paper(self) -> float:
        """The power as the paper counts it: speeds in Hz, so 2π times smaller and not in watts."""
        return self.power / _TURN


@dataclass(frozen=True, eq=False, kw_only=True)
class HoverMap:
    """The least hover power over attitude and tilt.

    Attributes
    ----------
    up : (D, 3) array
        Attitudes: the vertical seen from the body.
    tilt : (K,) array, rad
        Common to all servos.
    power : (D, K) array, W
        inf where it cannot hover.
    """

    up: FloatArray
    tilt: FloatArray
    power: FloatArray

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """Whether there is a tilt of the map at which it can hover: (D,) array of bool."""
        return np.asarray(np.isfinite(self.power).any(axis=1))

    @property
    def best_tilt(self) -> FloatArray:
        """The tilt of the map with the least power, rad, (D,); the first one if none is feasible.

        Ties go to the smaller tilt.
        """
        return np.asarray(self.tilt[np.argmin(self.power, axis=1)])

    @property
    def least_power(self) -> FloatArray:
        """The power at the best tilt, W, (D,); inf if there is none."""
        return np.asarray(self.power.min(axis=1))


def hover(
    vehicle: VehicleLike,
    tilt: ArrayLike,
    R_WB: ArrayLike | None = None,
    *,
    least: Effort = "power",
    beyond_limits: bool = False,
) -> HoverPoint:
    """Return the thrusts that hold a vehicle in the air in an attitude, with the least effort.

    They solve: minimise Σ c_tau |w|³ (or Σ f²) over A(α) f = (m g R_WBᵀ e3, 0) within the limits.

    Parameters
    ----------
    vehicle : Vehicle
        Any; its dead band is ignored.
    tilt : float or (m,) array, rad
        Of each servo.
    R_WB : (3, 3) array, optional
        The attitude; level by default.
    least : "power" or "norm"
        Of what the least is wanted. The paper takes the norm, by the pseudo-inverse.
    beyond_limits : bool
        Allow a tilt that the servos cannot reach.

    Returns
    -------
    HoverPoint
        `feasible` says whether it can hover at all.

    Raises
    ------
    VehicleError
        If the tilt, the attitude or `least` cannot be used.

    Examples
    --------
    OmniMorph level at α = 60°: eight times 3.225 N, 131.54 Hz, 315.09 W.
    """
    vehicle = as_vehicle(vehicle)
    angles = checked_tilt(vehicle, tilt, beyond_limits)
    up = np.array([0.0, 0.0, 1.0]) if R_WB is None else _as_attitude(vehicle, R_WB)[2].copy()
    found = least_effort(vehicle, angles, _weight(vehicle, up[None]), least)
    thrust = found.thrust[0]
    feasible = bool(found.feasible[0])
    return HoverPoint(
        tilt=angles,
        up=up,
        feasible=feasible,
        thrust=thrust,
        speed=rotor_speed(vehicle, thrust),
        power=float(drag_power(vehicle, thrust)) if feasible else math.inf,
    )


def hover_map(
    vehicle: VehicleLike,
    up: ArrayLike,
    tilts: ArrayLike,
    *,
    beyond_limits: bool = False,
    progress: Callable[[float, float], None] | None = None,
) -> HoverMap:
    """Return the least hover power for each of D attitudes at each of K tilts.

    Parameters
    ----------
    vehicle : Vehicle
        Any; its dead band is ignored.
    up : (D, 3) array
        Attitudes: the vertical seen from the body, R_WBᵀ e3; see `sphere_directions`.
    tilts : (K,) array, rad
        Common to all servos.
    beyond_limits : bool
        Allow tilts that the servos cannot reach.
    progress : callable, optional
        Called with the tilts done and all of them.

    Raises
    ------
    VehicleError
        If a tilt or a direction cannot be used.
    TooLargeError
        If the map has more points than memory holds.
    """
    vehicle = as_vehicle(vehicle)
    directions = _as_directions(vehicle, up)
    angles = np.atleast_1d(as_numbers(tilts))
    points = len(directions) * len(angles)
    refuse_more_than_memory(f"a hover map: {points} points", 8 * points, "ask for fewer")
    power = np.empty((len(directions), len(angles)))
    for k, tilt in enumerate(angles):
        power[:, k] = hover_power(vehicle, checked_tilt(vehicle, tilt, beyond_limits), directions)
        if progress is not None:
            progress(k + 1, len(angles))
    return HoverMap(up=directions, tilt=angles, power=power)


def hover_power(vehicle: Vehicle, tilt: FloatArray, up: FloatArray) -> FloatArray:
    """Return the least hover power in each of D attitudes at one tilt: (D,) array, W.

    Parameters
    ----------
    vehicle : Vehicle
        Any; its dead band is ignored.
    tilt : (m,) array, rad
        Of each servo, not checked against limits.
    up : (D, 3) array
        Attitudes, unit vectors: the vertical seen from the body.

    Returns
    -------
    (D,) array, W
        inf where it cannot hover.
    """
    found = least_effort(vehicle, tilt, _weight(vehicle, up), "power")
    return np.where(found.feasible, drag_power(vehicle, found.thrust), np.inf)


def sphere_directions(count: int) -> FloatArray:
    """Return unit vectors spread evenly over the sphere: (count, 3), from top to bottom.

    A Fibonacci lattice: heights in equal steps, each turned on by the golden angle (R. Swinbank,
    R. J. Purser, "Fibonacci grids", Q. J. R. Meteorol. Soc. 132, 2006). Each stands for the same
    solid angle, 4π/count.

    Raises
    ------
    InputError
        If it is not a whole number of them; `TooLargeError` if memory does not hold them.
    """
    if not isinstance(count, int | np.integer) or not 1 <= count <= 2**53:
        raise InputError.at("sphere_directions", "count", count, "a whole number from 1 to 2**53")
    refuse_more_than_memory(f"{count} directions", 80 * count, "ask for fewer")
    k = np.arange(count)
    height = 1.0 - (2.0 * k + 1.0) / count
    angle = k * math.pi * (3.0 - math.sqrt(5.0))
    level = np.sqrt(1.0 - height**2)
    return np.column_stack([level * np.cos(angle), level * np.sin(angle), height])


def _weight(vehicle: Vehicle, up: FloatArray) -> FloatArray:
    """Return the wrenches that hold the weight: (D, 6)."""
    return np.hstack([vehicle.mass * GRAVITY * up, np.zeros_like(up)])


def _as_attitude(vehicle: Vehicle, R_WB: ArrayLike) -> FloatArray:
    R = as_numbers(R_WB)
    if R.shape == (3, 3) and np.isfinite(R).all() and are_rotations(R[None]).all():
        return R
    raise VehicleError.at(f"vehicle {vehicle.name}", "R_WB", R_WB, ROTATION)


def _as_directions(vehicle: Vehicle, up: ArrayLike) -> FloatArray:
    directions = as_numbers(up)
    if directions.ndim == 2 and directions.shape[1] == 3 and np.isfinite(directions).all():
        length = np.linalg.norm(directions, axis=1)
        if (length > 0.0).all():
            return np.asarray(directions / length[:, None])
    allowed = "rows of three finite numbers, none of them all zero"
    raise VehicleError.at(f"vehicle {vehicle.name}", "up", up, allowed)
