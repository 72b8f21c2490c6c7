"""What the rotors and servos can move: ranks of A and F, null spaces, singular tilts.

Source: Aboudorra et al. 2024, Sec. 2.3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.analysis.scaling import (
    RANK_TOLERANCE,
    checked_tilt,
    radius_of_gyration,
    rank_of,
    searched_range,
    thrust_box,
    whitened,
)
from omnimorph.analysis.tilt_search import lowest_points
from omnimorph.analysis.vehicle_class import (
    ActuationKind,
    ThrustKind,
    VehicleClass,
    actuation_kind,
    thrust_kind,
)
from omnimorph.analysis.wrench_set import force_set
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.allocation import tilt_derivative
from omnimorph.model.core import as_thrust
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

__all__ = [
    "Actuation",
    "ActuationKind",
    "SingularTilt",
    "ThrustKind",
    "VehicleClass",
    "actuation",
    "singular_tilts",
]


@dataclass(frozen=True, eq=False, kw_only=True)
class Actuation:
    """What rotors and servos can move at one tilt.

    Ranks count singular values above 1e-9 of the largest, in whitened units: torques divided by the
    radius of gyration √(tr J / 3m), thrusts by half their range.

    Attributes
    ----------
    tilt : (m,) array, rad
        Where.
    rank_thrust : int
        Rank of A(α): what the thrusts alone can change.
    rank_full : int
        Rank of F(f, α) = [A | ∂(A f)/∂α] at the thrust asked for; without one the rank that almost
        every thrust gives.
    singular_values : (6,) array, N
        Of the whitened A, largest first.
    condition_number : float
        Largest over smallest of them; inf if rank A < 6.
    null_space : (n, n − rank) array
        Orthonormal thrusts that make no wrench.
    lost : (6, 6 − rank) array
        Unit wrenches, in whitened units, that no thrusts can make.
    conditions : tuple of (q, n) arrays, one for each servo
        Where rank A < 6: moving servo j adds a direction if and only if ``conditions[j] @ f`` is
        not zero. No rows: it never does. In reduced echelon form.
    kind : ActuationKind
    thrust_kind : ThrustKind
        At this tilt; `platform` has the class of the vehicle over all its tilts.
    """

    tilt: FloatArray
    rank_thrust: int
    rank_full: int
    singular_values: FloatArray
    condition_number: float
    null_space: FloatArray
    lost: FloatArray
    conditions: tuple[FloatArray, ...]
    kind: ActuationKind
    thrust_kind: ThrustKind

    @property
    def vehicle_class(self) -> VehicleClass:
        """Both kinds at this tilt."""
        return VehicleClass(self.kind, self.thrust_kind)


class SingularTilt(NamedTuple):
    """A tilt (rad) at which A(α) has a lower rank than elsewhere, and that rank."""

    tilt: float
    rank: int


def actuation(
    vehicle: VehicleLike,
    tilt: ArrayLike,
    thrust: ArrayLike | None = None,
    *,
    beyond_limits: bool = False,
) -> Actuation:
    """Analyse what a vehicle can move at one tilt.

    Parameters
    ----------
    vehicle : Vehicle
        Any.
    tilt : float or (m,) array, rad
        Of each servo.
    thrust : (n,) array, N, optional
        Where F is evaluated; almost any thrust by default.
    beyond_limits : bool
        Allow a tilt that the servos cannot reach.

    Returns
    -------
    Actuation

    Raises
    ------
    VehicleError
        If tilt or thrust cannot be used.

    Examples
    --------
    OmniMorph at α = 0 has rank A = 4; tilting adds a direction unless Σ f_i h_i = 0, h_i where
    rotor i leans to: all thrusts equal, or 1 above and 2 below, give rank F = 4, one rotor alone 5.
    At 90° it has rank 5, and 6 with the tilt unless Σ f_i = 0.
    """
    vehicle = as_vehicle(vehicle)
    angles = checked_tilt(vehicle, tilt, beyond_limits)
    box = thrust_box(vehicle)
    U, S, Vt = np.linalg.svd(whitened(vehicle, angles))
    forces = force_set(vehicle, angles, zero_moment=True, beyond_limits=True)
    values = np.zeros(6)
    values[: len(S)] = S
    rank = rank_of(values)
    lost = U[:, rank:]
    slopes = _slopes(vehicle, angles)
    gains = np.einsum("wl,wmi->mli", lost, slopes)
    if thrust is None:
        rank_full = rank + max(_rank_gained(gains, f) for f in _any_thrusts(vehicle))
    else:
        rank_full = rank + _rank_gained(gains, as_thrust(vehicle, thrust))
    null_space = np.linalg.qr(Vt[rank:].T * box.half[:, None])[0]
    return Actuation(
        tilt=angles,
        rank_thrust=rank,
        rank_full=rank_full,
        singular_values=values,
        condition_number=float(values[0] / values[5]) if rank == 6 else np.inf,
        null_space=null_space,
        lost=lost,
        conditions=tuple(_echelon(gain) for gain in gains),
        kind=actuation_kind(rank, rank_full, vehicle.n_rotors),
        thrust_kind=thrust_kind(forces.dimension, forces.inscribed_radius, vehicle.mass * GRAVITY),
    )


def singular_tilts(
    vehicle: VehicleLike, *, beyond_limits: bool = False
) -> tuple[SingularTilt, ...]:
    """Return the tilts, common to all servos, at which the rank of A(α) falls.

    Found as the roots of the smallest singular value, to about 1e-10 rad, or 1e-8 rad where it only
    touches zero: the lowest points between samples half a degree apart, so that two roots nearer
    than that may count as one.

    Parameters
    ----------
    vehicle : Vehicle
        Any; without servos there are none.
    beyond_limits : bool
        Search the whole turn, −180° < α ≤ 180°, instead of what the servos reach.

    Raises
    ------
    VehicleError
        If no tilt is within the limits of all servos (and `beyond_limits` is not set).

    Examples
    --------
    OmniMorph: 0° and 180° with rank 4, ±90° with rank 5.
    """
    vehicle = as_vehicle(vehicle)
    if vehicle.n_servos == 0:
        return ()
    low, high = searched_range(vehicle, beyond_limits)

    def values(tilt: float) -> FloatArray:
        angles = np.full(vehicle.n_servos, tilt)
        S = np.linalg.svd(whitened(vehicle, angles), compute_uv=False)
        return np.asarray(S / S[0])

    def rank(tilt: float) -> int:
        return rank_of(values(tilt))

    ordinary = max(rank(low + share * (high - low)) for share in (0.137, 0.419, 0.731))
    found = lowest_points(lambda tilt: float(values(tilt)[ordinary - 1]), low, high)
    # A root of higher order is found to 1e-8 only; a round angle as near as that is meant.
    round_angles = [math.radians(round(math.degrees(tilt), 5)) for tilt in found]
    pairs = zip(found, round_angles, strict=True)
    nearest = [near if rank(near) <= rank(tilt) else tilt for tilt, near in pairs]
    singular = [SingularTilt(tilt, rank(tilt)) for tilt in nearest if rank(tilt) < ordinary]
    whole_turn = [one for one in singular if one.tilt > -np.pi + 1e-6 or not beyond_limits]
    return tuple(whole_turn)


def _slopes(vehicle: Vehicle, angles: FloatArray) -> FloatArray:
    """Return ∂A/∂α_j in whitened wrench units: (6, m, n)."""
    columns = [tilt_derivative(vehicle, one, angles) for one in np.eye(vehicle.n_rotors)]
    slopes = np.stack(columns, axis=-1)
    slopes[3:] /= radius_of_gyration(vehicle)
    return slopes


def _rank_gained(gains: FloatArray, thrust: FloatArray) -> int:
    """Return the rank of [P ∂(A f)/∂α_1 …], P onto the wrenches that A cannot make."""
    size = float(np.abs(thrust).max())
    if not gains.size or size == 0.0:
        return 0
    added = np.einsum("mli,i->lm", gains, thrust / size)
    return int((np.linalg.svd(added, compute_uv=False) > RANK_TOLERANCE).sum())


def _any_thrusts(vehicle: Vehicle) -> FloatArray:
    """Return a few thrusts without any pattern: what holds for one of them holds for almost all."""
    return np.sin(np.outer([1.0, 2.0**0.5, np.pi], 1.0 + np.arange(vehicle.n_rotors) ** 1.5))


def _echelon(gain: FloatArray) -> FloatArray:
    """Return the reduced echelon form of a matrix: the same row space, easiest to read."""
    matrix = gain.copy()
    row = 0
    for column in range(matrix.shape[1]):
        if row == len(matrix):
            break
        pivot = row + int(np.abs(matrix[row:, column]).argmax())
        if abs(matrix[pivot, column]) <= RANK_TOLERANCE:
            continue
        matrix[[row, pivot]] = matrix[[pivot, row]]
        matrix[row] /= matrix[row, column]
        others = np.arange(len(matrix)) != row
        matrix[others] -= np.outer(matrix[others, column], matrix[row])
        row += 1
    matrix[np.abs(matrix) <= RANK_TOLERANCE] = 0.0
    return matrix[:row]
