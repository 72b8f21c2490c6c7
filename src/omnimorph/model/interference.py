"""Rotors in line that blow on one another: which they are, and the thrust they lose.

The model is `core/include/omnimorph/model/interference.hpp`; `docs/model.md` says what of it is
published, calibrated and assumed.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph import _core
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.allocation import rotor_speed
from omnimorph.model.core import as_core, as_thrust, as_tilt
from omnimorph.protocols import FloatArray

WakeModel = Literal["published", "blade-element"]

WAKE_MODELS: tuple[WakeModel, ...] = ("published", "blade-element")
"""The two ways to say what a wake costs, see `thrust_lost`."""


def stacked_pairs(vehicle: Vehicle) -> NDArray[np.int64]:
    """Return the pairs of rotors that are in line when nothing is tilted.

    Rotor a is above rotor b if, at α = 0, their thrust axes z_a and z_b are parallel within 10°
    (the same way round) and the hub of b lies within 10° of straight below that of a, seen along
    z_a: ``z_a · z_b ≥ cos 10°`` and ``−z_a · (p_b − p_a) ≥ |p_b − p_a| cos 10°``. Of three in a
    column all three pairs count; two hubs at the same place are no pair.

    Parameters
    ----------
    vehicle : Vehicle
        With n rotors.

    Returns
    -------
    (p, 2) array of int
        Indices (above, below) of each pair, sorted; p = 0 for a vehicle without any.

    Examples
    --------
    OmniMorph's upper layer of four stands on its lower one:

    >>> import omnimorph as om
    >>> stacked_pairs(om.load_vehicle("omnimorph")).tolist()
    [[0, 4], [1, 5], [2, 6], [3, 7]]
    """
    return np.array(_core.stacked_pairs(as_core(vehicle)), dtype=np.int64).reshape(-1, 2)


def thrust_lost(
    vehicle: Vehicle, tilt: ArrayLike, thrust: ArrayLike, model: WakeModel = "published"
) -> FloatArray:
    """Return the share of its thrust that each rotor loses in the wakes of those in line with it.

    A wake leaves a rotor against its thrust. So of a stacked pair (see `stacked_pairs`) the upper
    rotor blows on the lower one if both thrust upwards, the lower on the upper if both thrust
    downwards; for thrusts of opposite signs no loss is known and none is counted. With θ the angle
    between the wake and the line from the upstream hub to the downstream one (θ = α for OmniMorph)
    and speeds w the wake arrives with the strength ``κ = a exp(−(θ/s)²) |w_up|/|w_down|``. What it
    costs:

    - ``"published"``: loss = κ, at most 1, with a = 0.333 and s = 40°.
    - ``"blade-element"``: in units of hover alone, the thrust y and the inflow x through the disc
      obey momentum theory, x (x − κ) = y, and blade-element theory, y = 1 − β (x − 1); hence
      ``x = ((κ − β) + √((κ − β)² + 4 (1 + β)))/2`` and loss = 1 − y, at most 1, with β = 0.948,
      a = 0.857 and s = 50°/√ln(0.857/0.208) = 42.02°.

    A rotor in several wakes keeps the product of the shares it would keep in each. Drag torque and
    power are not touched: they go on with the actual speed.

    Parameters
    ----------
    vehicle : Vehicle
        With n rotors and m servos.
    tilt : float or (m,) array, rad
        Angle of all servos, or of each.
    thrust : (n,) array, N
        Thrusts c_f w|w| before any loss, that is, the speeds.
    model : {"published", "blade-element"}
        What a wake costs.

    Returns
    -------
    (n,) array
        Shares from 0 (nothing lost) to 1. A rotor at rest loses 0: it has nothing to lose. The
        share jumps there, the thrust in N does not.

    Raises
    ------
    VehicleError
        If `tilt` or `thrust` is not finite or has the wrong length, or `model` is no such name.

    Examples
    --------
    Untilted and at equal speeds OmniMorph's lower rotors lose a third, half of that below
    partners half as fast:

    >>> import omnimorph as om
    >>> vehicle = om.load_vehicle("omnimorph")
    >>> thrust_lost(vehicle, 0.0, [2.0, 2.0, 0.5, 0.5, 2.0, 2.0, 2.0, 2.0]).round(4)
    array([0.    , 0.    , 0.    , 0.    , 0.333 , 0.333 , 0.1665, 0.1665])

    Notes
    -----
    Published are two numbers, of a lower rotor at 120 Hz beside seven others at 120 Hz (Aboudorra
    et al. 2024, section on mutual interference): 33 % lost at α = 0, 7 % at 50°. Both models meet
    them, by calibration: in the first a and s; in the second a and s, given β, which is set so that
    full immersion (κ = 1) costs 40 %. Assumed are the bell shape between and beyond these angles,
    that it counts the angle alone and not the distance, and that the same holds upside down. That
    the loss goes with |w_up|/|w_down| follows from theory: momentum theory has a wake's velocity
    proportional to the speed of its rotor, blade-element theory has the thrust that it costs
    proportional to that velocity times the rotor's own speed (J. G. Leishman, *Principles of
    Helicopter Aerodynamics*, chapters 2 and 3). A wake that meets a rotor which it is not in line
    with untilted, as between neighbours of a layer at large tilt, is not modelled.
    """
    if model not in WAKE_MODELS:
        allowed = '"published" or "blade-element"'
        raise VehicleError.at(f"vehicle {vehicle.name}", "model", model, allowed)
    angles = as_tilt(vehicle, tilt)
    speed = rotor_speed(vehicle, as_thrust(vehicle, thrust))
    return _core.thrust_lost(as_core(vehicle), angles, speed, model == "blade-element")
