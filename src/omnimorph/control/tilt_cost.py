"""What the best allocation costs at any tilt: the curve that the allocation rules search."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.control.allocators import RuleLike
from omnimorph.control.controller import core_settings
from omnimorph.control.tracking import TrackingGains
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.errors import ScenarioError
from omnimorph.protocols import FloatArray

_ANY_PERIOD = 1.0  # s; the cost knows neither how far the tilt may move nor the gains


def cost_over_tilt(
    vehicle: VehicleLike,
    rule: RuleLike,
    state: ArrayLike,
    acceleration: ArrayLike,
    previous_thrust: ArrayLike,
    tilt: ArrayLike,
) -> FloatArray:
    """Return the least cost of S control steps at K tilts each, for a vehicle with one servo.

    ::

        J(α) = min ‖u‖²_W1 + ‖q̈_r − q̈‖²_W2 + ‖u − u⁻‖²_W3,   f_min ≤ f ≤ f_max

    with ``u = f / c_f`` and ``q̈ = M⁻¹(μ + J_R A(α) f)``: what an `AllocationRule` compares.

    Parameters
    ----------
    vehicle : Vehicle
        The model, with n rotors and one servo.
    rule : AllocationRule
        Its weights count, whatever its kind; or what holds it, such as a scenario.
    state : (S, 18) array
        p_WB (m), R_WB row by row, v_WB (m/s), w_WB_B (rad/s); attitude and body rate are used.
    acceleration : (S, 6) array
        Asked for, q̈_r: linear (m/s², in W), then angular (rad/s², in B).
    previous_thrust : (S, n) array, N
        Commanded the control step before, c_f u⁻.
    tilt : (S, K) array, rad
        Angles of the servo, not checked against its limits.

    Returns
    -------
    (S, K) array
        The costs, without unit; exact to rounding.

    Raises
    ------
    ScenarioError
        If the vehicle has not one servo, an array has another shape or holds numbers that are not
        finite, or the weights do not fit the vehicle.

    Examples
    --------
    At tilt α the lift of equal thrusts falls with cos α, so that the effort of hovering level,
    ‖u‖², grows with 1/cos² α: by a third at 30°, four times at 60°.

    >>> import numpy as np, omnimorph as om
    >>> vehicle, free = om.load_vehicle("omnimorph"), (1.0, 1.0, 1.0)
    >>> rule = om.FixedTilt(W1=1e-20, W2_position=free, W2_attitude=free, W3=0.0)
    >>> level = np.concatenate([np.zeros(3), np.eye(3).ravel(), np.zeros(6)])
    >>> tilt = np.radians([[0.0, 30.0, 60.0]])
    >>> cost = om.cost_over_tilt(vehicle, rule, [level], np.zeros((1, 6)), np.zeros((1, 8)), tilt)
    >>> (cost / cost[0, 0]).round(3)
    array([[1.   , 1.333, 4.   ]])
    """
    vehicle = as_vehicle(vehicle)
    if vehicle.n_servos != 1:
        allowed = "1, so that a cost belongs to one tilt"
        raise ScenarioError.at(f"vehicle {vehicle.name}", "n_servos", vehicle.n_servos, allowed)
    settings = core_settings(vehicle, TrackingGains(), rule, _ANY_PERIOD)
    tilts = _rows("tilt", tilt, None, None)
    S = len(tilts)
    return _core.cost_over_tilt(
        settings,
        _rows("state", state, S, 18),
        _rows("acceleration", acceleration, S, 6),
        _rows("previous_thrust", previous_thrust, S, vehicle.n_rotors),
        tilts,
    )


def _rows(name: str, numbers: ArrayLike, S: int | None, width: int | None) -> FloatArray:
    """Return finite numbers in S rows of a width, where None leaves it open."""
    place, shape = "cost_over_tilt", f"({S or 'S'}, {width or 'K'})"
    try:
        rows = np.asarray(numbers, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):  # a text, or rows of different lengths
        raise ScenarioError.at(place, name, numbers, f"an array of shape {shape}") from None
    if rows.ndim != 2 or S not in (None, rows.shape[0]) or width not in (None, rows.shape[1]):
        raise ScenarioError.at(place, f"{name}.shape", rows.shape, shape)
    if not np.isfinite(rows).all():
        wrong = rows[~np.isfinite(rows)][0]
        raise ScenarioError.at(place, name, wrong, f"finite numbers in an array of shape {shape}")
    return np.ascontiguousarray(rows)
