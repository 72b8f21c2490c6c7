"""What rotors that blow on one another cost: hover power, and the limits that are left.

The loss (`omnimorph.model.interference`) depends on the thrusts themselves, so that neither the
least power is a convex problem any more nor the force set a zonotope. The power is therefore a
local minimum, searched from the thrusts that would be best in still air; the force set is bounded,
from below by limits that hold whatever the partner does, from above by still air.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.analysis.effort import drag_power
from omnimorph.analysis.hover import HoverPoint, hover
from omnimorph.analysis.scaling import checked_tilt, radius_of_gyration, rank_of
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.core import as_core
from omnimorph.model.dynamics import GRAVITY
from omnimorph.model.interference import WakeModel, thrust_lost
from omnimorph.protocols import FloatArray

_EXACT = 1e-7  # of the weight: how well the wrench must be met
_STEP = 1e-6  # of the largest speed, for difference quotients


def hover_in_wakes(
    vehicle: VehicleLike,
    tilt: ArrayLike,
    R_WB: ArrayLike | None = None,
    *,
    model: WakeModel = "published",
    beyond_limits: bool = False,
) -> HoverPoint:
    """Return the thrusts that hold a vehicle whose rotors blow on one another, at low power.

    They solve, for the speeds w: minimise Σ c_tau |w|³ over ``A f − B (loss · f) = (m g Rᵀe3, 0)``
    within the limits, f = c_f w|w|, B the part of A that thrust makes (drag goes on with the
    speed). Sequential quadratic programming (SciPy's SLSQP) from two starts: a local minimum.

    Parameters
    ----------
    vehicle, tilt, R_WB, beyond_limits
        As of `omnimorph.analysis.hover`.
    model : "published" or "blade-element"
        What a wake costs, see `omnimorph.model.interference.thrust_lost`.

    Returns
    -------
    HoverPoint
        Its thrusts are c_f w|w|, before any loss. Not feasible if the search finds none.

    Raises
    ------
    VehicleError
        If tilt, attitude or model cannot be used.

    Examples
    --------
    OmniMorph level at α = 0: each lower rotor loses a third, so all turn as fast as if the vehicle
    were 2/(2 − 0.333) times as heavy: 1.1998^1.5 of the power, 146.4 W instead of 111.4 W.
    """
    vehicle = as_vehicle(vehicle)
    still = hover(vehicle, tilt, R_WB, beyond_limits=beyond_limits)
    disturbed = thrust_lost(vehicle, still.tilt, np.ones(vehicle.n_rotors), model).any()
    if not disturbed or not still.feasible:
        return still
    problem = _Problem(vehicle, still.tilt, still.up, model)
    spread = np.copysign(np.abs(still.speed).max(), still.speed)
    tried = [problem.solved(start) for start in (1.1 * still.speed, spread)]
    power = [
        math.inf if speed is None else float(drag_power(vehicle, problem.thrust(speed)))
        for speed in tried
    ]
    best = power.index(min(power))
    found = tried[best]
    speed = np.zeros(vehicle.n_rotors) if found is None else found
    return replace(
        still,
        feasible=found is not None,
        thrust=problem.thrust(speed),
        speed=speed,
        power=power[best],
    )


def vehicle_in_wakes(
    vehicle: VehicleLike,
    tilt: ArrayLike,
    *,
    model: WakeModel = "published",
    beyond_limits: bool = False,
) -> Vehicle:
    """Return a vehicle whose thrust limits are what is left in the wakes, at one tilt.

    The limit of a rotor falls to what it gives at full speed while those that blow on it turn at
    full speed too. A force within these limits can be made whatever the partners do, so the force
    set of this vehicle lies inside the true one, and that of the vehicle in still air around it.
    Drag torques per thrust are left as they are: they are understated for the rotors that lose.

    Parameters
    ----------
    vehicle, tilt, beyond_limits
        As of `omnimorph.analysis.force_set`.
    model : "published" or "blade-element"
        What a wake costs.

    Examples
    --------
    OmniMorph at α = 0: the lower rotors keep 0.667 · 5.3587 N = 3.5743 N upwards, the upper ones as
    much downwards.
    """
    vehicle = as_vehicle(vehicle)
    angles = checked_tilt(vehicle, tilt, beyond_limits)
    kept = [
        np.sqrt(1.0 - thrust_lost(vehicle, angles, limit, model))
        for limit in (vehicle.thrust_min, vehicle.thrust_max)
    ]
    # A limit of zero speed cannot fall, and a least speed upwards is no thrust that wakes take.
    low = np.where(vehicle.speed_min < 0.0, kept[0], 1.0) * vehicle.speed_min
    return vehicle.replace(speed_min=low, speed_max=kept[1] * vehicle.speed_max)


class _Problem:
    """The search for speeds x, in shares of the largest, and its constraint."""

    def __init__(
        self, vehicle: Vehicle, tilt: FloatArray, up: FloatArray, model: WakeModel
    ) -> None:
        self._vehicle, self._tilt, self._blade = vehicle, tilt, model == "blade-element"
        self._core = as_core(vehicle)
        self._unit = float(np.maximum(-vehicle.speed_min, vehicle.speed_max).max())
        A = allocation_matrix(vehicle, tilt)
        B = A.copy()
        B[3:] += vehicle.rotor_spin * vehicle.kappa * A[:3]
        weight = vehicle.mass * GRAVITY
        scale = weight * np.repeat([1.0, radius_of_gyration(vehicle)], 3)
        # only the directions in which there is anything: SLSQP wants independent constraints
        U, S, _ = np.linalg.svd(np.hstack([A, B]) / scale[:, None])
        rows = U[:, : rank_of(S)].T / scale
        self._A, self._B = rows @ A, rows @ B
        self._asked = rows @ np.concatenate([weight * up, np.zeros(3)])
        self._price = vehicle.drag_coefficient * self._unit**3
        self._size = float(self._price.sum())

    def thrust(self, speed: FloatArray) -> FloatArray:
        thrust: FloatArray = self._vehicle.thrust_coefficient * speed * np.abs(speed)
        return thrust

    def missing(self, x: FloatArray) -> FloatArray:
        """Return what is missing from the wrench, in shares of the weight."""
        speed = self._unit * x
        f = self.thrust(speed)
        loss = _core.thrust_lost(self._core, self._tilt, speed, self._blade)
        missing: FloatArray = self._A @ f - self._B @ (loss * f) - self._asked
        return missing

    def slope(self, x: FloatArray) -> FloatArray:
        columns = [
            (self.missing(x + step) - self.missing(x - step)) / (2.0 * _STEP)
            for step in _STEP * np.eye(len(x))
        ]
        return np.column_stack(columns)

    def solved(self, speed: FloatArray) -> FloatArray | None:
        """Return the speeds at a local minimum near some others; None if the search finds none."""
        from scipy.optimize import minimize

        low, high = self._vehicle.speed_min / self._unit, self._vehicle.speed_max / self._unit
        found = minimize(
            lambda x: float(self._price @ np.abs(x) ** 3) / self._size,
            np.clip(speed / self._unit, low, high),
            jac=lambda x: 3.0 * self._price * x * np.abs(x) / self._size,
            bounds=np.column_stack([low, high]),
            constraints={"type": "eq", "fun": self.missing, "jac": self.slope},
            method="SLSQP",
            options={"ftol": 1e-12, "maxiter": 200},
        )
        met = bool(np.abs(self.missing(found.x)).max() <= _EXACT)
        return self._unit * found.x if met else None
