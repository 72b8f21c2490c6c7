"""The forces, moments and wrenches that the rotors can make at one tilt, exactly.

All are images of the box of thrusts, ``{ C f : E f = e, f_min ≤ f ≤ f_max }``: a zonotope, or a
zonotope cut by a subspace. Its facets are known in closed form
(`core/include/omnimorph/sets/zonotope.hpp`); the number of corners of the box, 2ⁿ, plays no
role. The dead band of the rotors is ignored: a thrust that it forbids counts as possible.

Sources: Hamandi et al., "Design of multirotor aerial vehicles: A taxonomy based on input
allocation", IJRR 2021 (force sets); P. McMullen, "On zonotopes", Trans. AMS 159, 1971.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.analysis.polytope import Polytope, Zonotope, nowhere
from omnimorph.analysis.scaling import (
    RANK_TOLERANCE,
    checked_tilt,
    radius_of_gyration,
    rank_of,
    thrust_box,
)
from omnimorph.arrays import as_numbers
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.allocation import allocation_matrix
from omnimorph.protocols import FloatArray


def force_set(
    vehicle: VehicleLike,
    tilt: ArrayLike,
    *,
    zero_moment: bool,
    moment: ArrayLike | None = None,
    beyond_limits: bool = False,
) -> Polytope:
    """Return the set of forces that the rotors can make, in N, in B.

    With free moments ``{ Z f : f_min ≤ f ≤ f_max }``, Z the thrust axes: what a body held by
    its attitude could feel. At zero moment ``{ Z f : T f = 0, f_min ≤ f ≤ f_max }``, T the torque
    rows of A: what hovering and flying at rest need. The first is never smaller. Papers rarely say
    which they mean, so `zero_moment` has no default.

    Parameters
    ----------
    vehicle : Vehicle
        Geometry and thrust limits; its dead band is ignored.
    tilt : float or (m,) array, rad
        Of each servo.
    zero_moment : bool
        Whether the moment must be zero, or is free.
    moment : (3,) array, N m, in B, optional
        Together with ``zero_moment=True``: hold this moment instead of zero.
    beyond_limits : bool
        Allow a tilt that the servos cannot reach.

    Returns
    -------
    Polytope
        With vertices, facets, volume, inscribed radius and reach; a `Zonotope` if moments are free.
        It may be degenerate (a line at α = 0) or empty, which `dimension` says.

    Raises
    ------
    VehicleError
        If the tilt cannot be used, or a moment is given without ``zero_moment=True``.

    Notes
    -----
    OmniMorph with free moments: r/f_max = min(4 sin α, 8 sin α cos α/√(1 + cos²α)), 3.2660 at its
    best, α = 54.7356°; at zero moment 3.1543 there.
    """
    vehicle = as_vehicle(vehicle)
    A = allocation_matrix(vehicle, checked_tilt(vehicle, tilt, beyond_limits))
    if not zero_moment:
        if moment is not None:
            allowed = "left out where moments are free (zero_moment=False)"
            raise VehicleError.at(f"vehicle {vehicle.name}", "moment", moment, allowed)
        return _zonotope(vehicle, A[:3])
    held = _as_vector(vehicle, "moment", np.zeros(3) if moment is None else moment, "N m")
    length = radius_of_gyration(vehicle)
    return _section(vehicle, A[:3], A[3:] / length, held / length)


def moment_set(
    vehicle: VehicleLike,
    tilt: ArrayLike,
    *,
    force: ArrayLike | None = None,
    beyond_limits: bool = False,
) -> Polytope:
    """Return the set of moments about the centre of mass that the rotors can make, in N m, in B.

    ``{ T f : f_min ≤ f ≤ f_max }``, or, at a given force, ``{ T f : Z f = force, … }``.

    Parameters
    ----------
    vehicle, tilt, beyond_limits
        As of `force_set`.
    force : (3,) array, N, in B, optional
        The force to be made at the same time, m g Rᵀ e3 for hover; without it forces are free.

    Returns
    -------
    Polytope
        Empty if the force cannot be made at all; a `Zonotope` if forces are free.

    Raises
    ------
    VehicleError
        If the tilt or the force cannot be used.
    """
    vehicle = as_vehicle(vehicle)
    A = allocation_matrix(vehicle, checked_tilt(vehicle, tilt, beyond_limits))
    if force is None:
        return _zonotope(vehicle, A[3:])
    held = _as_vector(vehicle, "force", force, "N")
    # Made comparable the other way round: forces as torques at the radius of gyration.
    length = radius_of_gyration(vehicle)
    return _section(vehicle, A[3:], A[:3] * length, held * length)


def wrench_set(vehicle: VehicleLike, tilt: ArrayLike, *, beyond_limits: bool = False) -> Zonotope:
    """Return the set of wrenches (force in N, then torque in N m, in B): a zonotope in R⁶.

    Its support function, membership and reach are exact; a distance in it (`margin`,
    `inscribed_sphere`) mixes N and N m, so only its sign has a meaning. Vertices are not
    listed, there are thousands.

    Parameters
    ----------
    vehicle, tilt, beyond_limits
        As of `force_set`.

    Returns
    -------
    Zonotope
        Flat where A(α) has not full rank.

    Raises
    ------
    VehicleError
        If the tilt cannot be used.
    """
    vehicle = as_vehicle(vehicle)
    A = allocation_matrix(vehicle, checked_tilt(vehicle, tilt, beyond_limits))
    unit = np.repeat([1.0, radius_of_gyration(vehicle)], 3)
    return _zonotope(vehicle, A, unit)


def _zonotope(vehicle: Vehicle, C: FloatArray, unit: FloatArray | None = None) -> Zonotope:
    """Return { C f : f within limits }; division by `unit` makes the rows of C comparable."""
    box = thrust_box(vehicle)
    centre, generators = C @ box.centre, C * box.half
    if unit is None:
        hull = _Hull(generators)
        basis, rows = hull.flat, hull.normals @ hull.flat
    else:
        hull = _Hull(generators / unit[:, None])
        basis = np.linalg.qr(hull.flat * unit[:, None])[0]
        rows = (hull.normals / unit) @ basis
    length = np.sqrt(np.einsum("fr,fr->f", rows, rows))
    rows, bounds = rows / length[:, None], hull.widths / length
    return Zonotope(
        origin=centre,
        basis=basis,
        rows=np.concatenate([rows, -rows]),
        bounds=np.concatenate([bounds, bounds]),
        size=float(np.linalg.norm(generators, axis=0).sum() + np.linalg.norm(centre)),
        centre=centre,
        generators=generators,
    )


def _section(vehicle: Vehicle, C: FloatArray, E: FloatArray, e: FloatArray) -> Polytope:
    """Return { C f : E f = e, f within limits }: the zonotope of (C; E) f, cut by a subspace."""
    box = thrust_box(vehicle)
    both = np.vstack([C, E])
    centre = both @ box.centre
    hull = _Hull(both * box.half)
    k = len(C)
    reach = hull.normals @ centre
    # As unit vectors, so that the part of a normal for x is separated from that for the equations.
    length = np.sqrt(np.einsum("fk,fk->f", hull.normals, hull.normals))
    half = hull.normals / length[:, None]
    normals = np.concatenate([half, -half])
    offsets = np.concatenate([(hull.widths + reach) / length, (hull.widths - reach) / length])
    # (x, e) must lie in the flat of the zonotope: these are the equations for x.
    P = hull.across[:k].T
    p = hull.across.T @ centre - hull.across[k:].T @ e
    U, S, Vt = np.linalg.svd(P)
    rank = int((S > RANK_TOLERANCE).sum())
    size = float(np.abs(offsets).max(initial=0.0))
    if float(np.abs(U[:, rank:].T @ p).max(initial=0.0)) > 1e-9 * size:
        return nowhere(k, size)
    origin = Vt[:rank].T @ ((U[:, :rank].T @ p) / S[:rank])
    basis = Vt[rank:].T if rank else np.eye(k)
    return Polytope.bounded_by(normals[:, :k], offsets - normals[:, k:] @ e, origin, basis, size)


class _Hull:
    """The span of generators and the hyperplanes that bound their zonotope about zero.

    Attributes
    ----------
    flat, across : (k, r), (k, k − r) arrays
        Orthonormal directions along and across what the generators span.
    normals, widths : (F, k), (F,) arrays
        |normals x| ≤ widths.
    """

    def __init__(self, generators: FloatArray) -> None:
        U, S, Vt = np.linalg.svd(generators, full_matrices=generators.shape[1] < len(generators))
        rank = rank_of(S)
        self.flat, self.across = U[:, :rank], U[:, rank:]
        # In the coordinates S⁻¹ Uᵀ x the generators are the columns of Vt: as even as can be.
        normals, self.widths = _core.bounding_hyperplanes(np.ascontiguousarray(Vt[:rank]))
        self.normals: FloatArray = normals @ (self.flat / S[:rank]).T


def _as_vector(vehicle: Vehicle, key: str, value: ArrayLike, unit: str) -> FloatArray:
    vector = as_numbers(value)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        allowed = f"three finite numbers, in {unit}"
        raise VehicleError.at(f"vehicle {vehicle.name}", key, value, allowed)
    return vector
