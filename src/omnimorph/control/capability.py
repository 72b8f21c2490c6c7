"""What a vehicle has to spare beside its weight: what its controller can count on."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.analysis.hover import hover
from omnimorph.analysis.omnidirectional import inscribed_radius
from omnimorph.analysis.platform import lateral_reach, lateral_reach_over_tilts
from omnimorph.analysis.scaling import checked_tilt, searched_range
from omnimorph.analysis.wrench_set import force_set, moment_set
from omnimorph.control.allocators import AllocationRule
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.core import as_tilt
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

_TILTS = 31  # over the range of the servo
_SHARE = 0.8  # of what it can push sideways; the rest is left to the controller
_NONE = 1e-6  # × g: an acceleration that counts as none


@dataclass(frozen=True, eq=False, kw_only=True)
class Capability:
    """The accelerations that a vehicle can add to its weight, level, at one tilt.

    `sideways` is to every side without a moment; where several servos turn, with the best tilts for
    each side, so that their rate limits come in.
    """

    tilt: FloatArray  # (m,) rad
    sideways: float  # m/s²
    turns: bool  # whether several servos turn to push sideways
    vertical: float  # m/s², both up and down, without a moment
    angular: FloatArray  # (3,) rad/s², about each axis of B either way, while it holds its weight
    effort: float  # (rad/s)⁴, ‖u‖² of hovering, u = w|w|, at the tilt at which it is least

    @property
    def leans(self) -> bool:
        """Whether it moves sideways only by leaning."""
        return self.sideways <= _NONE * GRAVITY


def flown_tilts(vehicle: Vehicle, start_tilt: ArrayLike = 0.0) -> list[FloatArray]:
    """Return the tilts, rad, that the proposed rule lets a vehicle take.

    One servo is moved over its range (31 tilts of it). Several hover near `start_tilt`.
    """
    start = as_tilt(vehicle, start_tilt)
    if vehicle.n_servos != 1:
        return [checked_tilt(vehicle, start)]
    return [np.array([tilt]) for tilt in np.linspace(*searched_range(vehicle, False), _TILTS)]


def capability(vehicle: Vehicle, start_tilt: ArrayLike = 0.0) -> Capability:
    """Return what a vehicle can do at the flown tilt at which it pushes hardest sideways.

    Between tilts that push alike the one with the largest vertical acceleration is taken. All from
    the exact sets of forces and moments.

    Raises
    ------
    VehicleError
        If it cannot hover level, has no thrust to spare, or no moment about an axis.

    Examples
    --------
    A quadrotor has nothing sideways; OmniMorph, between 46° and 48°, 8.9 m/s².

    >>> import omnimorph as om
    >>> found = capability(om.load_vehicle("omnimorph"))
    >>> round(found.sideways, 1), found.leans
    (8.9, False)
    """
    points = [hover(vehicle, tilt, least="norm") for tilt in flown_tilts(vehicle, start_tilt)]
    hovering = [point for point in points if point.feasible]
    if not hovering:
        raise _grounded(vehicle, "it cannot hover level, so there is nothing to control it by")
    spare = [(lateral_reach(vehicle, one.tilt), _vertical(vehicle, one.tilt)) for one in hovering]
    (sideways, vertical), tilt = max(
        zip(spare, (one.tilt for one in hovering), strict=True), key=lambda pair: pair[0]
    )
    by_turning = lateral_reach_over_tilts(vehicle) if vehicle.n_servos > 1 else 0.0
    turns = by_turning > sideways
    angular = _angular(vehicle, tilt)
    if vertical <= _NONE * GRAVITY:
        raise _grounded(vehicle, "it hovers level, but with no thrust left to climb or to sink")
    for axis, most in zip("xyz", angular, strict=True):
        if most <= _NONE * GRAVITY:  # rad/s², on a lever of a metre
            raise _grounded(vehicle, f"while it hovers level it has no moment about body {axis}")
    thrust = np.array([point.thrust for point in hovering])
    return Capability(
        tilt=tilt,
        sideways=max(sideways, by_turning) / vehicle.mass,
        turns=turns,
        vertical=vertical,
        angular=angular,
        effort=float(((thrust / vehicle.thrust_coefficient) ** 2).sum(axis=1).min()),
    )


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
    return _SHARE * max(lateral_force(vehicle, tilt) for tilt in flown_tilts(vehicle))


def _vertical(vehicle: Vehicle, tilt: FloatArray) -> float:
    """Return the acceleration, m/s², that is there both up and down without a moment."""
    least, most = force_set(vehicle, tilt, zero_moment=True).stretch([0.0, 0.0, 1.0])
    return min(most / vehicle.mass - GRAVITY, GRAVITY - least / vehicle.mass)


def _angular(vehicle: Vehicle, tilt: FloatArray) -> FloatArray:
    """Return the angular acceleration, rad/s², (3,), about each axis either way at hover."""
    moments = moment_set(vehicle, tilt, force=[0.0, 0.0, vehicle.mass * GRAVITY])
    per_unit = vehicle.inertia  # column i: the moment that gives 1 rad/s² about axis i at rest
    return np.array([min(moments.reach(J), moments.reach(-J)) for J in per_unit.T])


def _grounded(vehicle: Vehicle, reason: str) -> VehicleError:
    place = f"vehicle {vehicle.name}"
    return VehicleError(f"{place}: no controller is proposed: {reason}.", file=place)
