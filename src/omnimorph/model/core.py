"""From a `Vehicle` to the core's own record of it, made once and kept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.arrays import as_numbers
from omnimorph.design.keys import OF_VEHICLES
from omnimorph.design.vehicle import Vehicle
from omnimorph.design.vehicle_fields import fields_of
from omnimorph.errors import ScenarioError, VehicleError
from omnimorph.protocols import FloatArray

_LARGEST_TILT = OF_VEHICLES["angle_max_deg"].in_SI("deg").most
_made: WeakKeyDictionary[Vehicle, _core.Vehicle] = WeakKeyDictionary()


def as_core(vehicle: Vehicle) -> _core.Vehicle:
    """Return the core's record of a vehicle."""
    if vehicle not in _made:
        _made[vehicle] = _core.make_vehicle(core_fields(vehicle))
    return _made[vehicle]


def core_fields(vehicle: Vehicle) -> dict[str, Any]:
    """Return the fields of the core's vehicle, by their names there, in SI.

    They are those that `Vehicle` declares to be in the core, and what follows from its axes.

    Examples
    --------
    >>> from omnimorph.design import load_vehicle
    >>> fields = core_fields(load_vehicle("quadrotor"))
    >>> fields["mass"], fields["servo"].tolist(), fields["axis"].shape
    (1.28, [0, 0, 0, 0], (4, 3))
    """
    fields = {
        field.short: getattr(vehicle, field.name)
        for field in fields_of(type(vehicle)).values()
        if field.in_core
    }
    z0, zC, zS = vehicle.thrust_axis_parts
    # A rotor that does not tilt has zC = zS = 0, so that any servo's angle leaves it as it is.
    servo = np.maximum(vehicle.rotor_servo, 0)
    return fields | {"axis": z0, "axis_cosine": zC, "axis_sine": zS, "servo": servo}


def in_float64(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return fields of the core with every array in float64: whole numbers of Python are not.

    Examples
    --------
    >>> in_float64({"lag": {"up": np.full(2, 1), "steps": 3}})
    {'lag': {'up': array([1., 1.]), 'steps': 3}}
    """
    return {name: _in_float64(value) for name, value in fields.items()}


def _in_float64(value: Any) -> Any:
    if isinstance(value, Mapping):
        return in_float64(value)
    return value.astype(np.float64, copy=False) if isinstance(value, np.ndarray) else value


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


def as_thrust(
    vehicle: Vehicle, thrust: ArrayLike, place: str = "", name: str = "thrust"
) -> FloatArray:
    """Return one thrust for each rotor, N; a refusal says where it stands and what it is called.

    Raises
    ------
    VehicleError
        If they are not that many finite numbers; ScenarioError with a place.
    """
    thrusts = as_numbers(thrust)
    if thrusts.shape != (vehicle.n_rotors,) or not np.isfinite(thrusts).all():
        n = vehicle.n_rotors
        allowed = f"{n} finite numbers of newtons, one for each of the {n} rotors"
        error = ScenarioError if place else VehicleError
        raise error.at(place or f"vehicle {vehicle.name}", name, thrust, allowed)
    return thrusts


def state_row(*parts: ArrayLike) -> FloatArray:
    """Return the parts of a state or of a desired motion as one row of numbers."""
    return np.concatenate([as_numbers(part).reshape(-1) for part in parts])
