"""Where the rotors point, and how large their propellers are drawn."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.design.unit_doubts import largest_radius
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.allocation import allocation_matrix
from omnimorph.protocols import FloatArray


def propeller_radius(vehicle: Vehicle) -> float:
    """Return a radius for drawings, m: the largest with which no two discs touch, but for 4 %.

    Vehicles do not know their propellers. OmniMorph: 0.48 · 0.2124 m = 0.102 m, its 8 inches. The
    rotors of a fixed coaxial pair do not touch; both at one place are drawn as one.
    """
    return largest_radius(vehicle) or 0.1


def thrust_axes(vehicle: Vehicle, tilt: ArrayLike) -> FloatArray:
    """Return the unit thrust axes in B at a tilt, rad, (n, 3): the forces per newton of thrust."""
    axes: FloatArray = np.ascontiguousarray(allocation_matrix(vehicle, tilt)[:3].T)
    return axes
