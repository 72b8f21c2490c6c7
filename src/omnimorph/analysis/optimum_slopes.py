"""By how much the optimal values of `sensitivity` change as a design sets out in a direction.

Radius and hover power are values of optimisation problems, the condition number is a ratio of
singular values. Where the optimum is unique each has a gradient (the envelope theorem). Where it is
not (a sphere that touches several facets, thrusts that can be exchanged for one another, equal
singular values, limits that leave the multipliers open) it has a slope in every direction still,
the least or the largest over all optima (Danskin's theorem; J. F. Bonnans, A. Shapiro,
"Perturbation Analysis of Optimization Problems", 2000), but not the opposite slope the other way.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from omnimorph.analysis.effort import drag_power, least_effort
from omnimorph.analysis.polytope import Polytope
from omnimorph.analysis.scaling import radius_of_gyration, rank_of, thrust_box, whitened
from omnimorph.analysis.wrench_set import force_set, wrench_set
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import OmnimorphError, VehicleError
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

_SAME = 1e-9  # shares of the largest: what differs by less is equal


class Changes(NamedTuple):
    """P directions in which a design sets out, by what they change at first order.

    Attributes
    ----------
    matrix : (P, 6, n) array
        Of A.
    thrust_min, thrust_max : (P, n) arrays, N
        Of the limits.
    """

    matrix: FloatArray
    thrust_min: FloatArray
    thrust_max: FloatArray

    def reversed(self) -> Changes:
        """Return the opposite directions."""
        return Changes(-self.matrix, -self.thrust_min, -self.thrust_max)


class Slope(NamedTuple):
    """A value, and what gives its slopes, (P,), as a design sets out in P directions."""

    value: float
    ahead: Callable[[Changes], FloatArray]


# --- radius ---------------------------------------------------------------------------------------


class _Touched(NamedTuple):
    """A facet that the inscribed sphere touches.

    Attributes
    ----------
    normals : (J, k) array
        Those of the set of wrenches (or of forces, where moments are free) over this facet: the
        same unit direction of the force, other multipliers of the moment.
    pull : (J, n) array
        By how much each thrust pushes along them.
    thrust : (n,) array, N
        Thrusts that make the touching point.
    exchange : (n, q) array
        Changes of thrusts that leave the point where it is, if limits allow them.
    """

    normals: FloatArray
    pull: FloatArray
    thrust: FloatArray
    exchange: FloatArray


def slope_of_radius(vehicle: Vehicle, angles: FloatArray, A: FloatArray, moment: bool) -> Slope:
    """Return the radius of the largest sphere about zero in the set of forces, and its slopes.

    R = min_d max_f d·Z f over unit vectors d and thrusts f within limits; at zero moment also
    minimised over the multipliers λ of T f = 0. A slope is the least over the facets that are
    touched of min_λ max_f (d, λ)·dA f over all λ and f that are optimal there.

    Parameters
    ----------
    moment : bool
        True if the moment must be zero.
    """
    forces = force_set(vehicle, angles, zero_moment=moment, beyond_limits=True)
    radius = forces.inscribed_radius
    if radius <= 0.0:
        raise _no_slope(vehicle, "radius", "the force set has no inscribed sphere about zero")
    rows = slice(0, 6 if moment else 3)
    reached = wrench_set(vehicle, angles, beyond_limits=True) if moment else forces
    if reached.basis.shape[0] > reached.basis.shape[1]:
        raise _no_slope(vehicle, "radius", "A has not full rank")
    scale = np.repeat([1.0, radius_of_gyration(vehicle)], 3)[rows]
    touched = [
        _touched(vehicle, A[rows], normals, radius, scale)
        for normals in _normals_touched(reached, radius)
    ]

    def ahead(changes: Changes) -> FloatArray:
        slopes = [_facet_ahead(vehicle, facet, changes, rows) for facet in touched]
        return np.asarray(np.min(slopes, axis=0))

    return Slope(radius, ahead)


def _normals_touched(reached: Polytope, radius: float) -> list[FloatArray]:
    """Return the normals of the facets that the sphere touches, those of one direction together."""
    normals = reached.rows @ reached.basis.T
    offsets = reached.bounds + normals @ reached.origin
    length = np.linalg.norm(normals[:, :3], axis=1)
    with_force = length > _SAME
    normals = normals[with_force] / length[with_force, None]
    apart = offsets[with_force] / length[with_force] - radius
    normals = normals[apart <= _SAME * radius]
    groups: list[FloatArray] = []
    while len(normals):
        same = np.abs(normals[:, :3] - normals[0, :3]).max(axis=1) < 1e-7
        groups.append(normals[same])
        normals = normals[~same]
    return groups


def _touched(
    vehicle: Vehicle, rows_of_A: FloatArray, normals: FloatArray, radius: float, scale: FloatArray
) -> _Touched:
    pull = normals @ rows_of_A
    pull[np.abs(pull) <= _SAME * np.abs(pull).max()] = 0.0
    most, least = pull.max(axis=0), pull.min(axis=0)
    free = (most == 0.0) & (least == 0.0)
    thrust = np.where(most > 0.0, vehicle.thrust_max, vehicle.thrust_min)
    thrust[free] = 0.0
    # the thrusts along the facet put the touching point where it is
    rest = -(rows_of_A @ thrust)
    rest[:3] += radius * normals[0, :3]
    of_free = rows_of_A[:, free] / scale[:, None]
    thrust[free] = np.linalg.lstsq(of_free, rest / scale, rcond=_SAME)[0]
    exchange = np.zeros((vehicle.n_rotors, int(free.sum())))
    exchange[free] = np.eye(int(free.sum()))
    return _Touched(normals, pull, thrust, exchange @ _null_space(of_free))


def _facet_ahead(vehicle: Vehicle, facet: _Touched, changes: Changes, rows: slice) -> FloatArray:
    """Return the slopes of the distance of one facet, (P,)."""
    matrix = changes.matrix[:, rows]
    first = np.einsum("jk,pki,i->pj", facet.normals, matrix, facet.thrust)
    first += changes.thrust_max @ np.maximum(facet.pull, 0.0).T
    first += changes.thrust_min @ np.minimum(facet.pull, 0.0).T
    by_exchange = np.einsum("jk,pki,iq->pjq", facet.normals, matrix, facet.exchange)
    slopes: FloatArray = first.min(axis=1)
    open_ones = np.abs(by_exchange).max(axis=(1, 2), initial=0.0)
    for p in np.flatnonzero(open_ones > _SAME * np.abs(matrix).max(axis=(1, 2), initial=0.0)):
        slopes[p] = _game(vehicle, facet, first[p], by_exchange[p])
    return slopes


def _game(vehicle: Vehicle, facet: _Touched, first: FloatArray, by_exchange: FloatArray) -> float:
    """Return min over mixtures p of the normals of max over exchanges y of p·(first + by y).

    Both at once as a linear program: the inner maximum, over thrusts within limits, by its dual.
    """
    from scipy.optimize import linprog

    inside = np.abs(facet.exchange).max(axis=1) > 0.0
    exchange, thrust = facet.exchange[inside], facet.thrust[inside]
    up, down = vehicle.thrust_max[inside] - thrust, thrust - vehicle.thrust_min[inside]
    n, many = len(thrust), len(first)
    found = linprog(
        np.concatenate([first, up, down]),
        A_eq=np.block(
            [
                [-by_exchange.T, exchange.T, -exchange.T],
                [np.ones((1, many)), np.zeros((1, 2 * n))],
            ]
        ),
        b_eq=np.append(np.zeros(exchange.shape[1]), 1.0),
    )
    if found.status != 0:
        raise OmnimorphError(f"vehicle {vehicle.name}: no slope found, {found.message}")
    return float(found.fun)


# --- hover power ----------------------------------------------------------------------------------


def slope_of_power(vehicle: Vehicle, angles: FloatArray, A: FloatArray) -> Slope:
    """Return the least power of hovering level, and its slopes.

    The thrusts f are unique; a slope is max_λ −λ·dA f over the multipliers λ, which are unique only
    if the rotors within their limits make every wrench. It is infinite where hovering ends at once.
    """
    weight = np.zeros((1, 6))
    weight[0, 2] = vehicle.mass * GRAVITY
    found = least_effort(vehicle, angles, weight, "power")
    if not found.feasible[0]:
        raise _no_slope(vehicle, "hover_power", "it cannot hover level")
    thrust, multiplier = found.thrust[0], found.multiplier[0]
    # what a little more thrust of a rotor would save, beyond what it costs
    root = np.sqrt(np.abs(thrust) / vehicle.thrust_coefficient)
    saved = multiplier @ A - 1.5 * np.copysign(vehicle.kappa * root, thrust)
    span = vehicle.thrust_max - vehicle.thrust_min
    at_max = vehicle.thrust_max - thrust <= _SAME * span
    at_min = thrust - vehicle.thrust_min <= _SAME * span
    scale = np.repeat([1.0, radius_of_gyration(vehicle)], 3)
    open_ways = _null_space((A[:, ~(at_max | at_min)] / scale[:, None]).T).T / scale

    def ahead(changes: Changes) -> FloatArray:
        moved = at_max * changes.thrust_max + at_min * changes.thrust_min
        made = changes.matrix @ thrust
        slopes = -(made @ multiplier) - moved @ saved
        gains = -(made + moved @ A.T) @ open_ways.T
        size = np.abs(changes.matrix).max(axis=(1, 2)) * np.abs(thrust).max() + np.abs(moved).max()
        for p in np.flatnonzero(np.abs(gains).max(axis=1, initial=0.0) > 1e-7 * size):
            limits = np.vstack([-(open_ways @ A)[:, at_max].T, (open_ways @ A)[:, at_min].T])
            room = np.concatenate([saved[at_max], -saved[at_min]])
            slopes[p] += _most(vehicle, gains[p], limits, room)
        return np.asarray(slopes)

    return Slope(float(drag_power(vehicle, thrust)), ahead)


def _most(vehicle: Vehicle, gain: FloatArray, rows: FloatArray, room: FloatArray) -> float:
    """Return max gain·y over ``rows y ≤ room``, which holds zero; inf if there is no end."""
    from scipy.optimize import linprog

    if not len(rows):
        return math.inf
    found = linprog(-gain, A_ub=rows, b_ub=np.maximum(room, 0.0), bounds=(None, None))
    if found.status == 3:
        return math.inf
    if found.status != 0:
        raise OmnimorphError(f"vehicle {vehicle.name}: no slope found, {found.message}")
    return float(-found.fun)


# --- condition number -----------------------------------------------------------------------------


def slope_of_condition(vehicle: Vehicle, angles: FloatArray) -> Slope:
    """Return σ₁/σ₆ of the whitened A, and its slopes.

    Of q equal singular values the largest (or least) grows by the largest (or least) eigenvalue of
    the symmetric part of Uᵀ dA V, U and V their q vectors on either side.
    """
    W = whitened(vehicle, angles)
    U, S, Vt = np.linalg.svd(W, full_matrices=False)
    if len(S) < 6 or S[5] <= _SAME * S[0]:
        raise _no_slope(vehicle, "condition_number", "A has not full rank")
    box, length = thrust_box(vehicle), np.repeat([1.0, radius_of_gyration(vehicle)], 3)
    first, last = (np.abs(S - S[k]) <= _SAME * S[0] for k in (0, 5))

    def ahead(changes: Changes) -> FloatArray:
        longer = 0.5 * (changes.thrust_max - changes.thrust_min) / box.half
        dW = changes.matrix / length[:, None] * box.half + W * longer[:, None]
        slopes = []
        for equal, which in ((first, -1), (last, 0)):
            part = np.einsum("wa,pwi,bi->pab", U[:, equal], dW, Vt[equal])
            grown = np.linalg.eigvalsh(0.5 * (part + part.transpose(0, 2, 1)))
            slopes.append(grown[:, which])
        return np.asarray(slopes[0] / S[5] - S[0] / S[5] ** 2 * slopes[1])

    return Slope(float(S[0] / S[5]), ahead)


def _null_space(matrix: FloatArray) -> FloatArray:
    """Return orthonormal x, (k, k − rank), with ``matrix x = 0``."""
    if not matrix.size:
        return np.eye(matrix.shape[1])
    _, S, Vt = np.linalg.svd(matrix)
    return np.asarray(Vt[rank_of(S) :].T)


def _no_slope(vehicle: Vehicle, quantity: str, reason: str) -> VehicleError:
    return VehicleError(f"vehicle {vehicle.name}: {quantity} has no derivative here: {reason}.")
