"""How hard a vehicle can push sideways beside its weight: what position-first flight needs."""

from __future__ import annotations

import math

import numpy as np

from omnimorph.analysis.omnidirectional import inscribed_radius
from omnimorph.analysis.platform import lateral_reach, lateral_reach_over_tilts
from omnimorph.analysis.scaling import searched_range
from omnimorph.control.allocators import AllocationRule
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

__all__ = ["lateral_force", "usable_lateral_force"]

_SHARE = 0.8  # of what it can push; the rest is left to the controller
_TILTS = 31  # over the range of the servos


def lateral_force(vehicle: Vehicle, tilt: float | FloatArray) -> float:
    """Return `lateral_reach`, N; inf if the vehicle hovers in every attitude at this tilt."""
    if inscribed_radius(vehicle, tilt, zero_moment=True) >= vehicle.mass * GRAVITY:
        return math.inf
    return lateral_reach(vehicle, tilt)


def usable_lateral_force(vehicle: Vehicle, rule: AllocationRule, tilt: FloatArray) -> float:
    """Return the sideways force, N, that position-first flight counts on: four fifths of it all.

    At the tilt at which a rule keeps the servos, or at the best of the range that it searches; with
    the best tilts for each side where several servos turn.
    """
    if not rule.turns_servos or vehicle.n_servos == 0:
        return _SHARE * lateral_force(vehicle, tilt)
    if vehicle.n_servos > 1:
        return _SHARE * lateral_reach_over_tilts(vehicle)
    low, high = searched_range(vehicle, False)
    return _SHARE * max(lateral_force(vehicle, one) for one in np.linspace(low, high, _TILTS))
