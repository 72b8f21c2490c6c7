"""What every analysis starts with: a tilt that the vehicle has, and units in which sizes compare.

Forces and torques have different units, so a rank or a condition number of A means something only
after they are made comparable. *Whitened* is the wrench ``(f, τ/ℓ)`` per share of the thrust range:
ℓ = √(tr J / 3m), the vehicle's radius of gyration, and half the range of each rotor as its unit of
thrust. Neither depends on the frame, on the size of the vehicle or on the choice of units.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.core import as_tilt
from omnimorph.protocols import FloatArray

RANK_TOLERANCE = 1e-9
"""A singular value below this share of the largest counts as zero."""

_SLACK = 1e-9  # rad: 60° in radians may be a last digit beyond a limit that was read in degrees


class ThrustBox(NamedTuple):
    """The limits of the thrusts as centre and half range: two (n,) arrays, N."""

    centre: FloatArray
    half: FloatArray


def thrust_box(vehicle: Vehicle) -> ThrustBox:
    """Return the middle and half the range of each rotor's thrust; the dead band is ignored."""
    low, high = vehicle.thrust_min, vehicle.thrust_max
    return ThrustBox(0.5 * (low + high), 0.5 * (high - low))


def radius_of_gyration(vehicle: Vehicle) -> float:
    """Return ℓ = √(tr J / 3m) in m; OmniMorph: 0.0931 m."""
    return math.sqrt(float(np.trace(vehicle.inertia)) / (3.0 * vehicle.mass))


def whitened(vehicle: Vehicle, tilt: FloatArray) -> FloatArray:
    """Return A(α) in whitened units, N: (6, n), torques over ℓ, thrusts in half ranges."""
    A = allocation_matrix(vehicle, tilt) * thrust_box(vehicle).half
    A[3:] /= radius_of_gyration(vehicle)
    return A


def rank_of(singular_values: NDArray[np.floating[Any]]) -> int:
    """Return how many singular values, largest first, are more than 1e-9 of the largest."""
    return int((RANK_TOLERANCE * singular_values[0] < singular_values).sum())


def checked_tilt(vehicle: Vehicle, tilt: ArrayLike, beyond_limits: bool = False) -> FloatArray:
    """Return one angle for each servo, (m,), rad, after a check against the servos' limits.

    Raises
    ------
    VehicleError
        If the tilt is not finite or has another shape; if it is beyond a limit, unless
        `beyond_limits` allows it.
    """
    angles = as_tilt(vehicle, tilt)
    if beyond_limits:
        return angles
    low, high = vehicle.servo_angle_min, vehicle.servo_angle_max
    outside = (angles < low - _SLACK) | (angles > high + _SLACK)
    if outside.any():
        j = int(outside.argmax())
        found, least, most = (
            f"{round(math.degrees(angle), 6):g}°" for angle in (angles[j], low[j], high[j])
        )
        allowed = f"from {least} to {most}, as far as servo {vehicle.servo_name[j]} turns"
        raise VehicleError(
            f"vehicle {vehicle.name}: tilt is {found}, but it must be {allowed}; beyond_limits "
            "(--beyond-limits) analyses it all the same.",
            file=f"vehicle {vehicle.name}",
            key="tilt",
            value=float(angles[j]),
            allowed=allowed,
        )
    return angles


def common_limits(vehicle: Vehicle) -> tuple[float, float]:
    """Return the least and the largest tilt, rad, that all servos can take together.

    Both are 0 for a vehicle without servos.

    Raises
    ------
    VehicleError
        If no angle is within the limits of all servos.
    """
    if vehicle.n_servos == 0:
        return 0.0, 0.0
    low, high = float(vehicle.servo_angle_min.max()), float(vehicle.servo_angle_max.min())
    if low > high:
        raise VehicleError(
            f"vehicle {vehicle.name}: no tilt is within the limits of all {vehicle.n_servos} "
            "servos, so it cannot be varied for all of them together; give one angle for each."
        )
    return low, high


def searched_range(vehicle: Vehicle, beyond_limits: bool) -> tuple[float, float]:
    """Return the range of common tilts to search: the whole turn, −π to π, or `common_limits`."""
    return (-math.pi, math.pi) if beyond_limits and vehicle.n_servos else common_limits(vehicle)
