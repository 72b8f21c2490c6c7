"""Forces of vehicles whose servos tilt independently, over all tilts at once.

Servo j with its rotors makes the wrench ``Σ_i A_i(α_j) f_i``. Over all its tilts, with the rotors
on it sharing the load in proportion to their limits, that fills a sector; the forces of the vehicle
at zero moment are a sum of such sectors cut by zero moment. Each sector is taken as the polygon of
its points at tilts 5° apart, so what is found can be made, and is at most 0.1 % too small.
"""

from __future__ import annotations

import math

import numpy as np

from omnimorph.arrays import as_numbers
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import OmnimorphError, VehicleError
from omnimorph.model.allocation import allocation_matrix
from omnimorph.protocols import FloatArray

_APART = math.radians(5.0)
_TOGETHER = 20  # linear programs solved as one: each call of the solver takes about 1 ms


def reach_over_tilts(
    vehicle: VehicleLike, directions: FloatArray, beside: FloatArray | None = None
) -> FloatArray:
    """Return the largest force along each direction at zero moment, the tilts free: (D,) array, N.

    Parameters
    ----------
    vehicle : Vehicle
        Any; a rotor without a servo keeps its axis.
    directions : (D, 3) array
        Unit vectors in B.
    beside : (3,) array, N, optional
        A force that is made at the same time, such as the weight; none by default.

    Returns
    -------
    (D,) array, N
        0 where even `beside` alone cannot be made.

    Raises
    ------
    VehicleError
        If the directions, or the force beside them, are none.

    Notes
    -----
    A sector that spans more than half a turn but not a whole one is counted with the chord that
    closes it: for tilts of ±3 rad that adds nothing one could measure.

    Examples
    --------
    A tilting quadrotor whose rotors turn by the whole turn about their arms pushes along x with the
    two rotors whose arms lie along y, about 2 f_max, and upwards with all four.
    """
    vehicle = as_vehicle(vehicle)
    where = f"vehicle {vehicle.name}"
    ways, other = as_numbers(directions), as_numbers(np.zeros(3) if beside is None else beside)
    if ways.ndim != 2 or ways.shape[1] != 3 or not np.isfinite(ways).all():
        raise VehicleError.at(where, "directions", directions, "rows of three finite numbers")
    if other.shape != (3,) or not np.isfinite(other).all():
        raise VehicleError.at(where, "beside", beside, "three finite numbers, in N")
    wrenches, groups = _corners(vehicle)
    made = np.concatenate([other, np.zeros(3)])
    found = [
        _most(vehicle, wrenches, groups, made, ways[first : first + _TOGETHER])
        for first in range(0, len(ways), _TOGETHER)
    ]
    return np.concatenate([np.zeros(0), *found])


def dimension_over_tilts(vehicle: VehicleLike) -> int:
    """Return the dimension of the forces at zero moment, the tilts free: 0 to 3.

    Parameters
    ----------
    vehicle : Vehicle
        Any; a rotor without a servo keeps its axis.

    Notes
    -----
    Zero belongs to the set. As long as a force beside all that were found can be made, it is one
    more direction.
    """
    vehicle = as_vehicle(vehicle)
    wrenches, groups = _corners(vehicle)
    found = np.zeros((3, 0))
    thin = 1e-7 * float(np.abs(wrenches[:, :3]).max(initial=0.0))
    while found.shape[1] < 3:
        beside = np.linalg.svd(found)[0][:, found.shape[1] :].T
        forces = [_farthest(vehicle, wrenches, groups, way) for way in (*beside, *-beside)]
        off = [float(np.linalg.norm(beside @ force)) for force in forces]
        if max(off) <= thin:
            break
        found = np.linalg.qr(np.column_stack([found, forces[int(np.argmax(off))]]))[0]
    return found.shape[1]


def _farthest(
    vehicle: Vehicle, wrenches: FloatArray, groups: np.ndarray, way: FloatArray
) -> FloatArray:
    """Return the force at zero moment, N, that goes farthest in a direction."""
    from scipy.optimize import linprog

    found = linprog(
        -wrenches[:, :3] @ way,
        A_ub=_shares(groups),
        b_ub=np.ones(groups.max() + 1),
        A_eq=wrenches[:, 3:].T / _arm(vehicle),
        b_eq=np.zeros(3),
    )
    if found.status != 0:
        raise OmnimorphError(f"vehicle {vehicle.name}: no forces found, {found.message}")
    return np.asarray(found.x @ wrenches[:, :3])


def _shares(groups: np.ndarray) -> FloatArray:
    """Return which corner belongs to which servo, a row a servo: their shares sum to 1 at most."""
    return np.asarray(groups == np.arange(groups.max() + 1)[:, None], dtype=np.float64)


def _most(
    vehicle: Vehicle, wrenches: FloatArray, groups: np.ndarray, made: FloatArray, ways: FloatArray
) -> FloatArray:
    """Return the largest t ≥ 0 for which ``made + t way`` can be made, for each way; 0 if none is.

    Linear programs in the shares of the corners: those of one servo sum to at most 1.
    """
    from scipy.optimize import linprog
    from scipy.sparse import block_diag

    count, corners = len(ways), len(groups)
    shares = np.pad(_shares(groups), ((0, 0), (0, 1)))
    scale = np.repeat([1.0, 1.0 / _arm(vehicle)], 3)
    most = np.append(np.full(corners, np.inf), np.abs(wrenches[:, :3]).sum())
    sums = scale[:, None] * np.column_stack([wrenches.T, np.zeros(6)])
    each = [sums - np.pad(way[:, None], ((0, 3), (corners, 0))) for way in ways]
    found = linprog(
        np.tile(np.append(np.zeros(corners), -1.0), count),
        A_ub=block_diag([shares] * count, format="csc"),
        b_ub=np.ones(len(shares) * count),
        A_eq=block_diag(each, format="csc"),
        b_eq=np.tile(scale * made, count),
        bounds=np.column_stack([np.zeros(len(most) * count), np.tile(most, count)]),
        options={"presolve": False},  # it takes longer than it saves
    )
    if found.status not in (0, 2):
        raise OmnimorphError(f"vehicle {vehicle.name}: no forces found, {found.message}")
    if found.status == 2:
        return np.zeros(count)
    return np.asarray(found.x[corners :: corners + 1]) + 0.0  # no negative zero


def _corners(vehicle: Vehicle) -> tuple[FloatArray, np.ndarray]:
    """Return the wrenches at the corners of each sector or segment, (K, 6), and whose they are."""
    corners, groups = [], []
    for j in range(vehicle.n_servos):
        low, high = float(vehicle.servo_angle_min[j]), float(vehicle.servo_angle_max[j])
        span = min(high - low, 2.0 * math.pi)
        for angle in low + np.linspace(0.0, span, 1 + math.ceil(span / _APART)):
            tilt = np.zeros(vehicle.n_servos)
            tilt[j] = angle
            A = allocation_matrix(vehicle, tilt)[:, vehicle.rotor_servo == j]
            for limit in (vehicle.thrust_max, vehicle.thrust_min):
                own = limit[vehicle.rotor_servo == j]
                if own.any():  # zero belongs to every sector
                    corners.append(A @ own)
                    groups.append(j)
    fixed = np.flatnonzero(vehicle.rotor_servo < 0)
    A = allocation_matrix(vehicle, np.zeros(vehicle.n_servos))
    for k, i in enumerate(fixed):
        for limit in (vehicle.thrust_max[i], vehicle.thrust_min[i]):
            corners.append(limit * A[:, i])
            groups.append(vehicle.n_servos + k)
    return np.array(corners), np.array(groups)


def _arm(vehicle: Vehicle) -> float:
    """Return a length, m, by which torques are divided to be compared with forces."""
    return float(np.linalg.norm(vehicle.rotor_position, axis=1).max()) or 1.0
