"""The main figures of a vehicle over a row of tilts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph.analysis.hover import hover
from omnimorph.analysis.scaling import checked_tilt, rank_of, whitened
from omnimorph.analysis.wrench_set import force_set
from omnimorph.arrays import as_numbers
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.protocols import FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class TiltSweep:
    """Figures at K tilts, each common to all servos; (K,) arrays.

    Attributes
    ----------
    tilt : rad
    rank_thrust : rank of A(α)
    condition_number : of A in whitened units; inf where its rank is below 6
    radius_free_moment, radius_zero_moment : N, inscribed radii of the force sets
    largest_lift : N, straight up in the body, at zero moment
    level_power : W, the least that hovering level takes; inf where it cannot
    """

    tilt: FloatArray
    rank_thrust: NDArray[np.int64]
    condition_number: FloatArray
    radius_free_moment: FloatArray
    radius_zero_moment: FloatArray
    largest_lift: FloatArray
    level_power: FloatArray


def tilt_sweep(vehicle: VehicleLike, tilts: ArrayLike, *, beyond_limits: bool = False) -> TiltSweep:
    """Return ranks, condition, both radii, lift and hover power at each of K tilts.

    Parameters
    ----------
    vehicle : Vehicle
        Any.
    tilts : (K,) array, rad
        Each common to all servos.
    beyond_limits : bool
        Allow tilts that the servos cannot reach.

    Raises
    ------
    VehicleError
        If a tilt cannot be used.
    """
    vehicle = as_vehicle(vehicle)
    angles = np.atleast_1d(as_numbers(tilts))
    ranks = np.empty(len(angles), dtype=np.int64)
    columns = np.empty((5, len(angles)))
    for k, tilt in enumerate(angles):
        each = checked_tilt(vehicle, tilt, beyond_limits)
        S = np.linalg.svd(whitened(vehicle, each), compute_uv=False)
        ranks[k] = rank_of(S)
        free = force_set(vehicle, each, zero_moment=False, beyond_limits=True)
        zero = force_set(vehicle, each, zero_moment=True, beyond_limits=True)
        columns[:, k] = (
            S[0] / S[5] if ranks[k] == 6 else np.inf,
            free.inscribed_radius,
            zero.inscribed_radius,
            zero.reach([0.0, 0.0, 1.0]),
            hover(vehicle, each, beyond_limits=True).power,
        )
    condition, radius_free, radius_zero, lift, power = columns
    return TiltSweep(
        tilt=angles,
        rank_thrust=ranks,
        condition_number=condition,
        radius_free_moment=radius_free,
        radius_zero_moment=radius_zero,
        largest_lift=lift,
        level_power=power,
    )
