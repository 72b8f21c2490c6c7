"""The thrusts that make given wrenches with the least power or the least norm, within the limits.

Rotor drag power is ``Σ c_tau |w_i|³ = Σ c_tau (|f_i|/c_f)^(3/2)``: convex in the thrusts, so the
least is found for certain, by Newton's method on the dual problem
(`core/include/omnimorph/sets/least_effort.hpp`). What it returns is exact for the wrench it makes,
which agrees with the one asked for to 1e-12 of the largest thrust, or to 1e-9 at the end of what is
possible, where rounding may stop the search before.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from omnimorph import _core
from omnimorph.analysis.scaling import radius_of_gyration, rank_of
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.allocation import allocation_matrix
from omnimorph.protocols import FloatArray

Effort = Literal["power", "norm"]

_SOLVED, _NOT_SETTLED = 0.0, 2.0  # outcomes of the core; 1 is impossible, with a proof
_EXACT = 1e-9  # of the largest thrust: how well the wrench must be met


class LeastEffort(NamedTuple):
    """The best thrusts for K wrenches.

    Attributes
    ----------
    thrust : (K, n) array, N
        Zero where it is not feasible.
    multiplier : (K, 6) array
        By how much the least effort grows with each part of the wrench: W/N and W/(N m) for power.
    feasible : (K,) array of bool
        Whether any thrusts within the limits make the wrench.
    """

    thrust: FloatArray
    multiplier: FloatArray
    feasible: FloatArray


def drag_power(vehicle: Vehicle, thrust: FloatArray) -> FloatArray:
    """Return Σ c_tau (|f|/c_f)^(3/2), W, over the last axis of (…, n) thrusts in N.

    OmniMorph hovering level at α = 0, eight times 1.6125 N: 111.40 W.
    """
    cubed = (np.abs(thrust) / vehicle.thrust_coefficient) ** 1.5
    power: FloatArray = cubed @ vehicle.drag_coefficient
    return power


def least_effort(
    vehicle: Vehicle, tilt: FloatArray, wrenches: FloatArray, effort: Effort
) -> LeastEffort:
    """Return the thrusts of least effort for each of K wrenches at one tilt.

    Parameters
    ----------
    vehicle : Vehicle
        Geometry, coefficients and thrust limits; its dead band is ignored.
    tilt : (m,) array, rad
        Of each servo, not checked against limits.
    wrenches : (K, 6) array
        Force (N), then torque (N m), in B.
    effort : "power" or "norm"
        Σ c_tau |w|³ in W, or ½ Σ f² in N².

    Raises
    ------
    VehicleError
        If `effort` is neither.
    """
    if effort not in ("power", "norm"):
        raise VehicleError.at(f"vehicle {vehicle.name}", "least", effort, '"power" or "norm"')
    length = np.repeat([1.0, radius_of_gyration(vehicle)], 3)
    U, S, Vt = np.linalg.svd(allocation_matrix(vehicle, tilt) / length[:, None])
    rank = rank_of(S)
    largest = float(np.maximum(-vehicle.thrust_min, vehicle.thrust_max).max())
    unit = 2.0 ** np.ceil(np.log2(largest))  # so that the limits come back to the last digit
    if effort == "power":
        price = vehicle.drag_coefficient * (unit / vehicle.thrust_coefficient) ** 1.5
    else:
        price = np.full(vehicle.n_rotors, unit**2)
    common = float(price.max())
    asked = wrenches / (length * unit)
    to_rows = U[:, :rank] / S[:rank]
    matrix, in_rows = np.ascontiguousarray(Vt[:rank]), np.ascontiguousarray(asked @ to_rows)
    thrust, multiplier, _, outcome = _core.least_effort(
        matrix,
        in_rows,
        price / common,
        vehicle.thrust_min / unit,
        vehicle.thrust_max / unit,
        effort == "power",
    )
    beside = np.abs(asked @ U[:, rank:]).max(axis=1, initial=0.0)
    missing = np.abs(thrust @ matrix.T - in_rows).max(axis=1)
    settled = (outcome == _SOLVED) | ((outcome == _NOT_SETTLED) & (missing <= _EXACT))
    feasible = settled & (beside <= _EXACT)
    return LeastEffort(
        thrust=np.where(feasible[:, None], unit * thrust, 0.0),
        multiplier=(common / unit) * (multiplier @ to_rows.T) / length,
        feasible=feasible,
    )
