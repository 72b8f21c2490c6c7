"""Whether a vehicle can fly at all, and if not, why."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from omnimorph.analysis.scaling import common_limits, rank_of, whitened
from omnimorph.analysis.wrench_set import force_set
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

_LEAST_RANK = 4  # lift and three torques
_TILTS = 13  # over the range that all servos share


def check_it_can_fly(vehicle: Vehicle) -> None:
    """Refuse a vehicle that cannot hold itself in the air.

    Raises
    ------
    VehicleError
        With the reason, `why_it_cannot_fly`.
    """
    if reason := why_it_cannot_fly(vehicle):
        place = f"vehicle {vehicle.name}"
        raise VehicleError(f"{place} cannot fly: {reason}", file=place)


def why_it_cannot_fly(vehicle: Vehicle) -> str:
    """Return why a vehicle cannot hold itself in the air, in a sentence; empty if it can.

    It must be able to change lift and all three torques (rank A ≥ 4), and hold its weight at zero
    moment, at a tilt that all its servos can take; and its least lift must not exceed its weight.

    Parameters
    ----------
    vehicle : Vehicle
        Any; its dead band is ignored.

    Examples
    --------
    >>> import omnimorph as om
    >>> vehicle = om.load_vehicle("quadrotor")
    >>> why_it_cannot_fly(vehicle)
    ''
    >>> why_it_cannot_fly(vehicle.replace(mass=3.0))
    'its rotors lift at most 26 N without a moment, and it weighs 29.43 N.'
    """
    tilts = _tilts(vehicle)
    spectra = (np.linalg.svd(whitened(vehicle, tilt), compute_uv=False) for tilt in tilts)
    rank = _largest(map(rank_of, spectra), _LEAST_RANK)
    if rank < _LEAST_RANK:
        return (
            f"its rotors change the wrench in {rank:g} independent directions, and flying "
            f"takes {_LEAST_RANK}: lift and three torques."
        )
    weight = vehicle.mass * GRAVITY
    forces = (force_set(vehicle, tilt, zero_moment=True) for tilt in tilts)
    lift = _largest((at_tilt.reach([0.0, 0.0, 1.0]) for at_tilt in forces), weight)
    if lift <= 1e-9 * weight:
        return "its rotors cannot push it upwards without turning it."
    if lift < weight:
        return (
            f"its rotors lift at most {lift:.4g} N without a moment, and it weighs {weight:.4g} N."
        )
    if vehicle.n_servos > 1 or (vehicle.thrust_min <= 0.0).all():
        return ""  # several servos lift less at unequal tilts, and rotors that may stop do not lift
    forces = (force_set(vehicle, tilt, zero_moment=True) for tilt in tilts)
    least = -_largest((at_tilt.support([0.0, 0.0, -1.0]) for at_tilt in forces), -weight)
    if least > weight:
        return (
            f"its rotors lift at least {least:.4g} N at their lowest speeds, and it weighs "
            f"{weight:.4g} N."
        )
    return ""


def _largest(values: Iterable[float], enough: float) -> float:
    """Return the largest of some values, or the first that is enough."""
    largest = -math.inf
    for value in values:
        largest = max(largest, value)
        if largest >= enough:
            break
    return largest


def _tilts(vehicle: Vehicle) -> list[FloatArray]:
    if vehicle.n_servos == 0:
        return [np.empty(0)]
    low, high = common_limits(vehicle)
    upright = np.clip(0.0, low, high)  # where most vehicles lift most
    each = np.append(upright, np.linspace(low, high, _TILTS))
    return [np.full(vehicle.n_servos, tilt) for tilt in each]
