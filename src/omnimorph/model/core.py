"""From a `Vehicle` to the core's own record of it, made once and kept."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.arrays import as_numbers
from omnimorph.design.ranges import OF_VEHICLES
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import VehicleError
from omnimorph.protocols import FloatArray

__all__ = ["as_core", "as_tilt", "state_row"]

_LARGEST_TILT = OF_VEHICLES["angle_max_deg"].in_SI("deg").most
_made: WeakKeyDictionary[Vehicle, _core.Vehicle] = WeakKeyDictionary()


def as_core(vehicle: Vehicle) -> _core.Vehicle:
    """Return the core's record of a vehicle."""
    if vehicle not in _made:
        z0, zC, zS = vehicle.thrust_axis_parts
        _made[vehicle] = _core.make_vehicle(core_fields(vehicle))
    return _made[vehicle]


def core_fields(vehicle: Vehicle) -> dict[str, object]:
    """Return every field of the core's record of a vehicle, by its name there."""
    z0, zC, zS = vehicle.thrust_axis_parts
    return {
        "mass": vehicle.mass,
        "inertia": vehicle.inertia,
        "position": vehicle.rotor_position,
        "axis": z0,
        "axis_cosine": zC,
        "axis_sine": zS,
        "servo": np.maximum(vehicle.rotor_servo, 0),
        "spin": vehicle.rotor_spin,
        "thrust_coefficient": vehicle.thrust_coefficient,
        "drag_coefficient": vehicle.drag_coefficient,
        "speed_min": vehicle.speed_min,
        "speed_max": vehicle.speed_max,
        "spin_inertia": vehicle.spin_inertia,
        "angle_min": vehicle.servo_angle_min,
        "angle_max": vehicle.servo_angle_max,
        "rate_max": vehicle.servo_rate_max,
    }


def as_tilt(vehicle: Vehicle, tilt: ArrayLike) -> FloatArray:
    """Return one angle for each servo; a single number is the angle of all of them.

    Raises
    ------
    VehicleError
        If they are not that many, or beyond what any servo turns, 1e5 degrees.
    """
    angles = as_numbers(tilt)
    if angles.ndim == 0:
        angles = np.full(vehicle.n_servos, float(angles))
    if angles.shape != (vehicle.n_servos,) or not (np.abs(angles) <= _LARGEST_TILT).all():
        allowed = f"one finite angle in rad, or one for each of the {vehicle.n_servos} servos"
        allowed += f", at most {_LARGEST_TILT:g}"
        raise VehicleError.at(f"vehicle {vehicle.name}", "tilt", tilt, allowed)
    return angles


def state_row(*parts: ArrayLike) -> FloatArray:
    """Return the parts of a state or of a desired motion as one row of numbers."""
    return np.concatenate([as_numbers(part).reshape(-1) for part in parts])
