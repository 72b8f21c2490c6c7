"""Whether a tilt mechanism pays for its mass: lighter with a fixed tilt, or morphing to hover.

With m = m0 (1 + Δ_m), a vehicle that hovers untilted with a mechanism of relative mass Δ_m spends
as much as one without it whose rotors are fixed at α_f, if ``P(0, m0 (1 + Δ_m)) = P(α_f, m0)``
(Aboudorra et al. 2024, Sec. 2.4). Thrusts go with the mass and power with its 3/2, so

    Δ̄_m = (P(α_f) / P(0))^(2/3) − 1,

at any m0; where all rotors lean by α_f it is 1/cos α_f − 1.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.analysis.effort import drag_power
from omnimorph.analysis.wakes import hover_in_wakes
from omnimorph.arrays import as_numbers
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.ranges import Range
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import InputError, VehicleError
from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.core import as_tilt
from omnimorph.model.dynamics import GRAVITY
from omnimorph.model.interference import WakeModel
from omnimorph.protocols import FloatArray

_SHARES = Range(0.0, 1e100)


def mass_break_even(tilt_fixed: ArrayLike) -> FloatArray | float:
    """Return the relative mass of a tilt mechanism that just pays, 1/cos α_f − 1.

    For vehicles whose rotors are all upright untilted and lean by the same angle, as OmniMorph's.

    Parameters
    ----------
    tilt_fixed : float or array, rad
        α_f, the tilt of the vehicle without mechanism; |α_f| < 90°.

    Returns
    -------
    float or array
        Δ̄_m, mass of the mechanism over that of everything else.

    Raises
    ------
    InputError
        If a tilt is not finite or not within ±90°.

    Examples
    --------
    >>> round(mass_break_even(math.radians(20.0)), 4), round(mass_break_even(math.radians(30.0)), 4)
    (0.0642, 0.1547)
    """
    angle = as_numbers(tilt_fixed)
    if not (np.abs(angle) < 0.5 * math.pi).all():  # also refuses what is not a number
        raise InputError.at("mass_break_even", "tilt_fixed", tilt_fixed, "within ±π/2 rad")
    share = 1.0 / np.cos(angle) - 1.0
    return share if angle.ndim else float(share)


def mass_break_even_of(
    vehicle: VehicleLike, tilt_fixed: ArrayLike, *, wakes: WakeModel | None = None
) -> FloatArray:
    """Return the relative mass of a tilt mechanism that just pays for a certain vehicle.

    Δ̄_m = (P(α_f) / P(0))^(2/3) − 1 with the powers of hovering level: of the pseudo-inverse as the
    paper takes it, or, with rotors that blow on one another, the least that is found within limits.

    Parameters
    ----------
    vehicle : Vehicle
        With servos; its mass does not matter in still air.
    tilt_fixed : float or (K,) array, rad
        α_f, common to all servos.
    wakes : "published" or "blade-element", optional
        Let rotors lose thrust in one another's wakes; still air by default.

    Returns
    -------
    (K,) array
        Negative if the tilted vehicle needs less; inf if it cannot hover at all.

    Raises
    ------
    VehicleError
        If the vehicle cannot hover level untilted, so that there is nothing to compare with.

    Examples
    --------
    OmniMorph at 30°: 0.1547 in still air, 0.0651 in the rotors' wakes.
    """
    vehicle = as_vehicle(vehicle)
    untilted = _level_power(vehicle, 0.0, wakes)
    if not math.isfinite(untilted):
        raise VehicleError(f"vehicle {vehicle.name}: it cannot hover level untilted.")
    tilts = np.atleast_1d(as_numbers(tilt_fixed))
    powers = np.array([_level_power(vehicle, float(tilt), wakes) for tilt in tilts])
    shares: FloatArray = (powers / untilted) ** (2.0 / 3.0) - 1.0
    return shares


def solved_mass_break_even(vehicle: VehicleLike, tilt_fixed: float) -> float:
    """Return the same in still air, from the implicit equation, solved as the paper does.

    ``P(0, m0 (1 + Δ̄_m)) = P(α_f, m0)`` with m0 the mass without the mechanism; Brent's method.

    Raises
    ------
    VehicleError
        If the vehicle cannot hover level, untilted or at `tilt_fixed`, whatever its thrusts.
    """
    vehicle = as_vehicle(vehicle)
    from scipy.optimize import brentq

    bare = vehicle.replace(mass=vehicle.mass - vehicle.tilt_mechanism_mass, tilt_mechanism_mass=0.0)
    aim = _level_power(bare, tilt_fixed, None)
    if not math.isfinite(aim) or not math.isfinite(_level_power(bare, 0.0, None)):
        raise VehicleError(f"vehicle {vehicle.name}: it cannot hover level at both tilts.")

    def surplus(share: float) -> float:
        return _level_power(bare.replace(mass=bare.mass * (1.0 + share)), 0.0, None) - aim

    return float(brentq(surplus, -0.99, 1e3, xtol=1e-14))


def mechanism_share(vehicle: VehicleLike) -> float | None:
    """Return Δ_m, the mass of the tilt mechanism over that of the rest; None if it is not known.

    OmniMorph: 0.187 / 1.128 = 16.58 %.
    """
    vehicle = as_vehicle(vehicle)
    mechanism = vehicle.tilt_mechanism_mass
    return mechanism / (vehicle.mass - mechanism) if mechanism > 0.0 else None


def break_even_tilt(
    vehicle: VehicleLike, share: float, *, wakes: WakeModel | None = None
) -> float | None:
    """Return the tilt beyond which a mechanism of relative mass `share` pays, rad.

    The smallest root of ``mass_break_even_of(vehicle, α) = share`` in 0 < α < 90°, found between
    samples five degrees apart; None if there is none.

    Raises
    ------
    InputError
        If the share is not a number from 0 to 1e100.

    Examples
    --------
    OmniMorph with its own 16.58 %: 30.93° in still air, 40.44° in the rotors' wakes.
    """
    vehicle = as_vehicle(vehicle)
    if share not in _SHARES:
        raise InputError.at("break_even_tilt", "share", share, f"a number {_SHARES}")
    from scipy.optimize import brentq

    aim = _level_power(vehicle, 0.0, wakes) * (1.0 + share) ** 1.5
    if not math.isfinite(aim):
        return None

    def surplus(tilt: float) -> float:
        return float(_level_power(vehicle, tilt, wakes) - aim)

    before = 0.0
    for tilt in np.radians(np.arange(5.0, 90.0, 5.0)):
        here = surplus(float(tilt))
        if here >= 0.0:
            return float(brentq(surplus, before, tilt, xtol=1e-10)) if here < math.inf else None
        before = float(tilt)
    return None


def _level_power(vehicle: Vehicle, tilt: float, wakes: WakeModel | None) -> float:
    """Return the power of hovering level, W; inf if it cannot."""
    if wakes is not None:
        return hover_in_wakes(vehicle, tilt, model=wakes, beyond_limits=True).power
    A = allocation_matrix(vehicle, as_tilt(vehicle, tilt))
    weight = np.array([0.0, 0.0, vehicle.mass * GRAVITY, 0.0, 0.0, 0.0])
    thrust = np.linalg.pinv(A, rcond=1e-9) @ weight
    met = float(np.abs(A @ thrust - weight).max()) <= 1e-9 * weight[2]
    return float(drag_power(vehicle, thrust)) if met else math.inf
