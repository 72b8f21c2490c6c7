"""How radius, hover power and condition number change with the design, as exact derivatives.

All three are optimal values, so their derivatives need no derivative of the optimum (the envelope
theorem; J. F. Bonnans, A. Shapiro, "Perturbation Analysis of Optimization Problems", 2000): with
multipliers λ and thrusts f at the optimum, a change of A changes the value by ``λ·dA f``. One
matrix G = ∂value/∂A, (6, n), is carried on to tilt, hubs, axes and limits by the chain rule.

Where the optimum is not unique (a ball that touches several facets, a rotor at rest, equal singular
values) the value has a kink, and what is returned is one of its slopes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.analysis.effort import drag_power, least_effort
from omnimorph.analysis.scaling import checked_tilt, radius_of_gyration, thrust_box, whitened
from omnimorph.analysis.wrench_set import force_set
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.allocation import allocation_matrix, tilt_derivative
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

__all__ = ["Quantity", "Sensitivity", "sensitivity"]

Quantity = Literal["radius_free_moment", "radius_zero_moment", "hover_power", "condition_number"]
QUANTITIES: tuple[Quantity, ...] = (
    "radius_free_moment",
    "radius_zero_moment",
    "hover_power",
    "condition_number",
)
_ON_FACET = 1e-9


@dataclass(frozen=True, eq=False, kw_only=True)
class Sensitivity:
    """A value and its derivatives with respect to the design.

    Attributes
    ----------
    value : float
        N for a radius, W for the power of hovering level, 1 for the condition number.
    tilt : (m,) array
        Per rad of each servo.
    position : (n, 3) array
        Per m of each hub, in B.
    axis : (n, 3) array
        Per rad by which the untilted thrust axis of a rotor leans towards each direction, in B;
        the hinge stays. At right angles to the axis.
    thrust_min, thrust_max : (n,) arrays
        Per N of each limit.
    """

    value: float
    tilt: FloatArray
    position: FloatArray
    axis: FloatArray
    thrust_min: FloatArray
    thrust_max: FloatArray


class _Slope(NamedTuple):
    """A value, G = ∂value/∂A (6, n), and its derivatives in the limits (n,), A held."""

    value: float
    matrix: FloatArray
    thrust_min: FloatArray
    thrust_max: FloatArray


def sensitivity(
    vehicle: VehicleLike, tilt: ArrayLike, quantity: Quantity, *, beyond_limits: bool = False
) -> Sensitivity:
    """Return how one quantity changes with tilt, hubs, axes and thrust limits.

    Parameters
    ----------
    vehicle : Vehicle
        Any; the limits of its thrusts are taken as given in N, its mass and inertia as fixed.
    tilt : float or (m,) array, rad
        Of each servo.
    quantity : str
        ``radius_free_moment``, ``radius_zero_moment`` (N), ``hover_power`` (W, level, the least),
        ``condition_number`` (of A in whitened units, the radius of gyration held).
    beyond_limits : bool
        Allow a tilt that the servos cannot reach.

    Returns
    -------
    Sensitivity

    Raises
    ------
    VehicleError
        If the tilt or the quantity cannot be used; if the quantity has no derivative there, as the
        force set is flat, the vehicle cannot hover level, or A has not full rank.

    Examples
    --------
    OmniMorph with free moments at 20°: r = 4 f_max sin α, so dr/dα = 4 f_max cos α = 20.14 N/rad.
    """
    vehicle = as_vehicle(vehicle)
    if quantity not in QUANTITIES:
        allowed = f"one of {', '.join(QUANTITIES)}"
        raise VehicleError.at(f"vehicle {vehicle.name}", "quantity", quantity, allowed)
    angles = checked_tilt(vehicle, tilt, beyond_limits)
    A = allocation_matrix(vehicle, angles)
    if quantity == "hover_power":
        slope = _of_power(vehicle, angles, A)
    elif quantity == "condition_number":
        slope = _of_condition(vehicle, angles)
    else:
        slope = _of_radius(vehicle, angles, A, quantity == "radius_zero_moment")
    return _carried_on(vehicle, angles, slope)


def _of_radius(vehicle: Vehicle, angles: FloatArray, A: FloatArray, zero_moment: bool) -> _Slope:
    """R = max d·Z f over f within limits (and T f = 0), at the direction d where it is least."""
    reached = force_set(vehicle, angles, zero_moment=zero_moment, beyond_limits=True)
    radius, d = reached.ball()
    if radius <= 0.0:
        raise _no_slope(vehicle, "radius", "the force set holds no ball about zero")
    normal = np.concatenate([d, np.zeros(3)])
    if zero_moment:
        normal[3:] = _moment_multiplier(vehicle, A, d)
    pull = normal @ A  # by how much each thrust pushes towards the facet
    size = float(np.abs(pull).max())
    corner = np.where(pull > 0.0, vehicle.thrust_max, vehicle.thrust_min)
    free = np.abs(pull) <= _ON_FACET * size
    thrust = np.where(free, 0.0, corner)
    if free.any():  # the thrusts along the facet put the touching point where it is
        rows = slice(0, 6) if zero_moment else slice(0, 3)
        touching = np.concatenate([radius * d, np.zeros(3)])[rows]
        rest = touching - A[rows] @ thrust
        thrust[free] = np.linalg.lstsq(A[rows][:, free], rest, rcond=None)[0]
    return _Slope(
        value=radius,
        matrix=np.outer(normal, thrust),
        thrust_min=np.where(free, 0.0, np.minimum(pull, 0.0)),
        thrust_max=np.where(free, 0.0, np.maximum(pull, 0.0)),
    )


def _moment_multiplier(vehicle: Vehicle, A: FloatArray, d: FloatArray) -> FloatArray:
    """Return λ that makes (d, λ) the normal of the facet of the wrench set that the ball touches.

    The dual of ``max d·Z f, T f = 0``: minimise over λ the support of the wrench set along (d, λ),
    a linear program.
    """
    from scipy.optimize import linprog

    box = thrust_box(vehicle)
    length = radius_of_gyration(vehicle)
    Z, T = d @ A[:3], A[3:].T / length
    n = vehicle.n_rotors
    # variables λ ℓ (free) and s ≥ |Z + T λ| in each rotor
    rows = np.block([[T, -np.eye(n)], [-T, -np.eye(n)]])
    cost = np.concatenate([T.T @ box.centre, box.half])
    bounds = [(None, None)] * 3 + [(0.0, None)] * n
    found = linprog(cost, A_ub=rows, b_ub=np.concatenate([-Z, Z]), bounds=bounds)
    multiplier: FloatArray = found.x[:3] / length
    return multiplier


def _of_power(vehicle: Vehicle, angles: FloatArray, A: FloatArray) -> _Slope:
    weight = np.zeros((1, 6))
    weight[0, 2] = vehicle.mass * GRAVITY
    found = least_effort(vehicle, angles, weight, "power")
    if not found.feasible[0]:
        raise _no_slope(vehicle, "hover_power", "it cannot hover level")
    thrust, multiplier = found.thrust[0], found.multiplier[0]
    # what a little more thrust of a rotor would save, beyond what it costs
    root = np.sqrt(np.abs(thrust) / vehicle.thrust_coefficient)
    price = 1.5 * np.copysign(vehicle.kappa * root, thrust)
    saved = multiplier @ A - price
    span = vehicle.thrust_max - vehicle.thrust_min
    at_max = vehicle.thrust_max - thrust <= _ON_FACET * span
    at_min = thrust - vehicle.thrust_min <= _ON_FACET * span
    return _Slope(
        value=float(drag_power(vehicle, thrust)),
        matrix=-np.outer(multiplier, thrust),
        thrust_min=np.where(at_min, -saved, 0.0),
        thrust_max=np.where(at_max, -saved, 0.0),
    )


def _of_condition(vehicle: Vehicle, angles: FloatArray) -> _Slope:
    """σ₁/σ₆ of the whitened A; dσ = uᵀ dA v."""
    W = whitened(vehicle, angles)
    U, S, Vt = np.linalg.svd(W, full_matrices=False)
    if len(S) < 6 or S[5] <= 1e-9 * S[0]:
        raise _no_slope(vehicle, "condition_number", "A has not full rank")
    first, last = np.outer(U[:, 0], Vt[0]), np.outer(U[:, 5], Vt[5])
    slope = first / S[5] - (S[0] / S[5] ** 2) * last
    box = thrust_box(vehicle)
    slope_in_A = slope * box.half
    slope_in_A[3:] /= radius_of_gyration(vehicle)
    per_half = np.einsum("wi,wi->i", slope, W) / box.half
    return _Slope(
        value=float(S[0] / S[5]),
        matrix=slope_in_A,
        thrust_min=-0.5 * per_half,
        thrust_max=0.5 * per_half,
    )


def _carried_on(vehicle: Vehicle, angles: FloatArray, slope: _Slope) -> Sensitivity:
    """Apply the chain rule to column i of A, [z; p × z − k κ z] with z = R z0."""
    n = vehicle.n_rotors
    A = allocation_matrix(vehicle, angles)
    force, torque = slope.matrix[:3].T, slope.matrix[3:].T
    z = A[:3].T
    drag = (vehicle.rotor_spin * vehicle.kappa)[:, None]
    per_z = force - np.cross(vehicle.rotor_position, torque) - drag * torque
    tilt = np.zeros(vehicle.n_servos)
    for one, column in zip(np.eye(n), slope.matrix.T, strict=True):
        tilt += column @ tilt_derivative(vehicle, one, angles)
    untilted = np.array([_turned_back(vehicle, angles, i, per_z[i]) for i in range(n)])
    axis = vehicle.rotor_axis
    return Sensitivity(
        value=slope.value,
        tilt=tilt,
        position=np.cross(z, torque),
        axis=untilted - axis * np.sum(axis * untilted, axis=1, keepdims=True),
        thrust_min=slope.thrust_min,
        thrust_max=slope.thrust_max,
    )


def _turned_back(vehicle: Vehicle, angles: FloatArray, i: int, vector: FloatArray) -> FloatArray:
    """Return a vector of the tilted rotor as the untilted rotor sees it: turned by −α."""
    servo = int(vehicle.rotor_servo[i])
    if servo < 0:
        return vector
    a, angle = vehicle.hinge_axis[i], -float(angles[servo])
    along = a * (a @ vector)
    turned: FloatArray = (
        along + (vector - along) * np.cos(angle) + np.cross(a, vector) * np.sin(angle)
    )
    return turned


def _no_slope(vehicle: Vehicle, quantity: str, reason: str) -> VehicleError:
    return VehicleError(f"vehicle {vehicle.name}: {quantity} has no derivative here: {reason}.")
