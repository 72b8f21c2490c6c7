"""How hard a vehicle can push sideways beside its weight: what position-first flight needs."""

from __future__ import annotations

import math

import numpy as np

from omnimorph.analysis.omnidirectional import inscribed_radius
from omnimorph.analysis.polytope import Polytope
from omnimorph.analysis.scaling import searched_range
from omnimorph.analysis.wrench_set import force_set
from omnimorph.control.allocators import AllocationRule, FixedTilt
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

__all__ = ["lateral_force", "usable_lateral_force"]

_SHARE = 0.8  # of what it can push; the rest is left to the controller
_TILTS = 31  # over the range of the servos


def lateral_force(vehicle: Vehicle, tilt: float | FloatArray) -> float:
    """Return the largest r for which every sideways force of size r can be added to the weight.

    ``(r cos φ, r sin φ, m g)`` is in the set of forces at zero moment for every φ; exact, from the
    facets n·x ≤ h of the set: r = min (h − n_z m g) / |n_xy|.

    Parameters
    ----------
    vehicle : Vehicle
        Any.
    tilt : float or (m,) array, rad
        Of its servos.

    Returns
    -------
    float
        In N; inf if the vehicle hovers in every attitude at this tilt, 0 if it cannot push
        sideways, or cannot even hover.

    Examples
    --------
    Parallel rotors push nowhere but up. OmniMorph at 20° of tilt does not hover on its side, but
    pushes sideways beside its weight:

    >>> import omnimorph as om
    >>> vehicle = om.load_vehicle("omnimorph")
    >>> lateral_force(vehicle, 0.0), round(lateral_force(vehicle, np.radians(20.0)), 2)
    (0.0, 4.92)
    """
    if inscribed_radius(vehicle, tilt, zero_moment=True) >= vehicle.mass * GRAVITY:
        return math.inf
    return _beside_the_weight(force_set(vehicle, tilt, zero_moment=True), vehicle.mass * GRAVITY)


def usable_lateral_force(vehicle: Vehicle, rule: AllocationRule, tilt: FloatArray) -> float:
    """Return the sideways force, N, that position-first flight counts on: four fifths of it all.

    At the tilt at which a rule keeps the servos, or at the best of the range that it searches.
    """
    if isinstance(rule, FixedTilt) or vehicle.n_servos == 0:
        return _SHARE * lateral_force(vehicle, tilt)
    low, high = searched_range(vehicle, False)
    return _SHARE * max(lateral_force(vehicle, one) for one in np.linspace(low, high, _TILTS))


def _beside_the_weight(forces: Polytope, weight: float) -> float:
    if forces.dimension < 3 or not forces.contains([0.0, 0.0, weight]):
        return 0.0
    across = np.hypot(forces.normals[:, 0], forces.normals[:, 1])
    room = forces.offsets - weight * forces.normals[:, 2]
    sideways = across > 1e-9
    return float((room[sideways] / across[sideways]).min())
