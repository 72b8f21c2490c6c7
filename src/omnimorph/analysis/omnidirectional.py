"""In which attitudes a vehicle can hover, and at which tilts that is all of them.

A vehicle is omnidirectional where its force set holds the weight sphere. There are two force
sets, and so two answers: with free moments, and at zero moment, which is what hovering needs. The
paper does not say which it takes; its 37° is the first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.analysis.scaling import searched_range
from omnimorph.analysis.tilt_search import highest_point, intervals_above_zero
from omnimorph.analysis.wrench_set import force_set
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False, kw_only=True)
class Omnidirectionality:
    """Where every attitude can hover: intervals of tilt, (K, 2) arrays, rad.

    Attributes
    ----------
    free_moment, zero_moment : arrays
        In both definitions, within the limits of the servos.
    free_moment_beyond, zero_moment_beyond : arrays
        Over the whole turn.
    level, level_beyond : arrays
        Where it can hover level, within the limits and over the whole turn.
    """

    free_moment: FloatArray
    zero_moment: FloatArray
    free_moment_beyond: FloatArray
    zero_moment_beyond: FloatArray
    level: FloatArray
    level_beyond: FloatArray


def inscribed_radius(
    vehicle: VehicleLike, tilt: ArrayLike, *, zero_moment: bool, beyond_limits: bool = False
) -> float:
    """Return the largest force, N, that a vehicle can make in every direction.

    The radius of the inscribed sphere about zero of the force set: with free moments, or at zero
    moment. It is 0 where the set is degenerate.

    Raises
    ------
    VehicleError
        If the tilt cannot be used.

    Examples
    --------
    OmniMorph at 45°: √8 f_max = 15.16 N with free moments, 14.72 N at zero moment.
    """
    vehicle = as_vehicle(vehicle)
    return force_set(
        vehicle, tilt, zero_moment=zero_moment, beyond_limits=beyond_limits
    ).inscribed_radius


def omnidirectional_range(
    vehicle: VehicleLike, *, zero_moment: bool = True, beyond_limits: bool = False
) -> FloatArray:
    """Return the intervals of tilt in which a vehicle can hold its weight in every attitude.

    Where the inscribed radius is at least m g; ends are its roots, to about 1e-12 rad. Intervals,
    and gaps between them, narrower than half a degree may be missed.

    Parameters
    ----------
    vehicle : Vehicle
        Its tilt is common to all servos.
    zero_moment : bool
        Of the force set at zero moment, which hovering needs, or with free moments.
    beyond_limits : bool
        Search the whole turn, −180° to 180°, instead of what the servos reach.

    Returns
    -------
    (K, 2) array, rad
        Begin and end of each interval; no rows if there is none. A vehicle without servos that is
        omnidirectional has the one interval from 0 to 0.

    Raises
    ------
    VehicleError
        If no tilt is within the limits of all servos (and `beyond_limits` is not set).

    Examples
    --------
    OmniMorph, beyond its limit of 60°: 38.18° to 69.73° at zero moment, 37.00° to 70.28° with free
    moments. Tilted the other way it has the same forces, but not the same moments: −69.22° to
    −42.75° at zero moment.
    """
    vehicle = as_vehicle(vehicle)
    weight = vehicle.mass * GRAVITY
    return intervals_above_zero(
        lambda tilt: _extent(vehicle, tilt, zero_moment).radius - weight,
        *searched_range(vehicle, beyond_limits),
    )


def level_hover_range(vehicle: VehicleLike, *, beyond_limits: bool = False) -> FloatArray:
    """Return the intervals of tilt, (K, 2), rad, in which a vehicle can hover level.

    Where the largest upward force without a moment is at least the weight, and the least, of rotors
    that cannot turn slowly, at most. See `omnidirectional_range` for the arguments. OmniMorph: up
    to 72.49°, beyond its limit.
    """
    vehicle = as_vehicle(vehicle)
    weight = vehicle.mass * GRAVITY

    def spare(tilt: float) -> float:
        _, least, most = _extent(vehicle, tilt, True)
        return min(most - weight, weight - least)

    return intervals_above_zero(spare, *searched_range(vehicle, beyond_limits))


def tilt_of_largest_radius(
    vehicle: VehicleLike, *, zero_moment: bool = True, beyond_limits: bool = False
) -> float:
    """Return the tilt, rad, at which the inscribed radius is largest.

    See `omnidirectional_range` for the arguments. OmniMorph: 54.7356° = atan √2 with free moments.
    """
    vehicle = as_vehicle(vehicle)
    low, high = searched_range(vehicle, beyond_limits)
    return highest_point(lambda tilt: _extent(vehicle, tilt, zero_moment).radius, low, high)


def omnidirectionality(vehicle: VehicleLike, limits: tuple[float, float]) -> Omnidirectionality:
    """Return where a vehicle can hover in every attitude, and where level.

    Parameters
    ----------
    vehicle : Vehicle
        Its tilt is common to all servos.
    limits : (float, float), rad
        Tilts that all servos can take together.
    """
    free = omnidirectional_range(vehicle, zero_moment=False, beyond_limits=True)
    zero = omnidirectional_range(vehicle, zero_moment=True, beyond_limits=True)
    level = level_hover_range(vehicle, beyond_limits=True)
    return Omnidirectionality(
        free_moment=_within(free, limits),
        zero_moment=_within(zero, limits),
        level=_within(level, limits),
        free_moment_beyond=free,
        zero_moment_beyond=zero,
        level_beyond=level,
    )


class _Extent(NamedTuple):
    """How far a set of forces reaches, N: to every side, and straight up."""

    radius: float
    least_upwards: float
    most_upwards: float


_extents: WeakKeyDictionary[Vehicle, dict[tuple[float, bool], _Extent]] = WeakKeyDictionary()


def _extent(vehicle: Vehicle, tilt: float, zero_moment: bool) -> _Extent:
    """Return how far the forces reach at a common tilt; kept, as every search takes these tilts."""
    known = _extents.setdefault(vehicle, {})
    if (tilt, zero_moment) not in known:
        forces = force_set(vehicle, tilt, zero_moment=zero_moment, beyond_limits=True)
        known[tilt, zero_moment] = _Extent(forces.inscribed_radius, *forces.stretch(_UP))
    return known[tilt, zero_moment]


def _within(intervals: FloatArray, limits: tuple[float, float]) -> FloatArray:
    """Return what of some intervals is within limits."""
    clipped = np.clip(intervals, *limits)
    return clipped[(intervals[:, 0] <= limits[1]) & (intervals[:, 1] >= limits[0])]
