"""The rigid body: the wrench for an acceleration, hover, and rotations in SO(3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.core import as_core, state_row
from omnimorph.protocols import FloatArray, State

GRAVITY = 9.81
"""Acceleration of free fall, m/s²."""


def wrench_for(vehicle: Vehicle, state: State, wanted: ArrayLike) -> FloatArray:
    """Return the wrench that gives an acceleration: Newton and Euler's equations, solved for it.

    ``f_B = m Rᵀ(p̈ + g e3)`` and ``τ_B = J ω̇ + ω × Jω`` (Aboudorra et al. 2024, eq. (3)): force (N),
    then torque about the centre of mass (N m), (6,), in B. The acceleration that is `wanted` is
    linear (m/s², in W), then angular (rad/s², in B), (6,).
    """
    try:
        return _core.wrench_for(as_core(vehicle), state, wanted)
    except (TypeError, ValueError):  # not yet so many numbers in float64
        row = np.ascontiguousarray(wanted, dtype=np.float64)
        return _core.wrench_for(as_core(vehicle), state_row(*state), row)


def hover_thrust(vehicle: Vehicle, tilt: ArrayLike) -> FloatArray:
    """Return the (n,) equal thrusts, N, whose lift along body z is the weight.

    ``f_i = m g / Σ e3·z_i(α)``; with the tilt at which no rotor lifts there is none, and the answer
    is zero.
    """
    lift = float(allocation_matrix(vehicle, tilt)[2].sum())
    equal = vehicle.mass * GRAVITY / lift if abs(lift) > 1e-9 else 0.0
    thrust: FloatArray = np.full(vehicle.n_rotors, equal)
    return thrust.clip(vehicle.thrust_min, vehicle.thrust_max)


def rotation_exponential(phi: ArrayLike) -> FloatArray:
    """Return exp([φ]×): the (3, 3) rotation about φ by |φ| rad (Rodrigues)."""
    return _core.rotation_exponential(np.ascontiguousarray(phi, dtype=np.float64))
