"""The wrench of the rotors: A(α), its derivative in the tilt, and the full allocation matrix."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.core import as_core, as_thrust, as_tilt
from omnimorph.protocols import FloatArray


def allocation_matrix(vehicle: VehicleLike, tilt: ArrayLike) -> FloatArray:
    """Return A(α), which maps thrusts to the wrench they make: w_B = A(α) f.

    Column i is ``[z_i ; p_i × z_i − k_i κ_i z_i]`` with the thrust axis ``z_i(α)`` turned about its
    hinge by the angle of its servo, the hub ``p_i``, the spin ``k_i`` and ``κ_i = c_τ/c_f``.

    Parameters
    ----------
    vehicle : Vehicle
        With n rotors and m servos.
    tilt : float or (m,) array, rad
        Angle of all servos, or of each.

    Returns
    -------
    (6, n) array
        Force (N/N), then torque about the centre of mass (N m/N), in B.

    Raises
    ------
    VehicleError
        If `tilt` is not finite or has the wrong length.

    Examples
    --------
    At zero tilt all thrusts of OmniMorph point up, so the third row is all ones:

    >>> import omnimorph as om
    >>> om.allocation_matrix(om.load_vehicle("omnimorph"), 0.0)[2]
    array([1., 1., 1., 1., 1., 1., 1., 1.])

    Notes
    -----
    Aboudorra et al. 2024, eqs. (5) to (10). The rank drops to 4 at α = kπ and to 5 at π/2 + kπ.
    """
    if not isinstance(vehicle, Vehicle):
        vehicle = as_vehicle(vehicle)
    return _core.allocation_matrix(as_core(vehicle), as_tilt(vehicle, tilt))


def tilt_derivative(vehicle: Vehicle, thrust: ArrayLike, tilt: ArrayLike) -> FloatArray:
    """Return ∂(A(α) f)/∂α, how the wrench changes with the angle of each servo: (6, m) array.

    N/rad, then N m/rad, in B, of thrusts f, (n,) N, at angles α, one or (m,) rad.
    """
    f = as_thrust(vehicle, thrust)
    return _core.tilt_derivative(as_core(vehicle), f, as_tilt(vehicle, tilt))


def full_allocation_matrix(vehicle: VehicleLike, thrust: ArrayLike, tilt: ArrayLike) -> FloatArray:
    """Return F(f, α) = [A(α) | ∂(A(α) f)/∂α]: how the wrench changes with every input.

    Parameters
    ----------
    vehicle : Vehicle
        With n rotors and m servos.
    thrust : (n,) array, N
        Thrusts f.
    tilt : float or (m,) array, rad
        Angles α.

    Returns
    -------
    (6, n + m) array
        Force, then torque, in B.

    Notes
    -----
    Aboudorra et al. 2024, eq. (11), with thrusts in N for inputs. At α = 0 the last column lies
    outside the range of A exactly if Σ f_i h_i ≠ 0, h_i the direction in which rotor i tilts.
    """
    vehicle = as_vehicle(vehicle)
    columns = (allocation_matrix(vehicle, tilt), tilt_derivative(vehicle, thrust, tilt))
    return np.hstack(columns)


def rotor_speed(vehicle: Vehicle, thrust: FloatArray) -> FloatArray:
    """Return the signed speeds, rad/s, that make thrusts (…, n), N: w = sign(f) √(|f|/c_f).

    OmniMorph: 1.6125 N is 93.01 Hz.
    """
    # two roots, because |f| / c_f may be too large a number
    speed: FloatArray = (
        np.sign(thrust) * np.sqrt(np.abs(thrust)) / np.sqrt(vehicle.thrust_coefficient)
    )
    return speed
