"""How radius, hover power and condition number change with the design: exact one-sided derivatives.

A symmetric vehicle stands at a kink of most of these: its inscribed sphere touches several facets
at once, its singular values are equal in pairs. More thrust of one rotor then gains nothing, as the
opposite facet stays where it is, while less of it costs. So every derivative is given from both
sides, and `Sensitivity.along` gives it for changes made together. `optimum_slopes` derives them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.analysis.optimum_slopes import (
    Changes,
    Slope,
    slope_of_condition,
    slope_of_power,
    slope_of_radius,
)
from omnimorph.analysis.scaling import checked_tilt
from omnimorph.arrays import as_numbers
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.allocation import allocation_matrix, tilt_derivative
from omnimorph.protocols import FloatArray

Quantity = Literal["radius_free_moment", "radius_zero_moment", "hover_power", "condition_number"]
QUANTITIES: tuple[Quantity, ...] = (
    "radius_free_moment",
    "radius_zero_moment",
    "hover_power",
    "condition_number",
)
_SAME = 1e-9  # of the largest: derivatives from both sides that differ by less are one


class Derivatives(NamedTuple):
    """Derivatives of a value with respect to the design.

    Attributes
    ----------
    tilt : (m,) array
        Per rad of each servo.
    position : (n, 3) array
        Per m of each hub along x, y, z of B.
    axis : (n, 3) array
        Per rad by which the untilted thrust axis of a rotor leans towards x, y, z of B: only the
        part of these at right angles to the axis counts. The hinge stays.
    thrust_min, thrust_max : (n,) arrays
        Per N that is added to one limit of one rotor.
    thrust_range : (n,) array
        Per N by which both limits of one rotor move outwards together.
    """

    tilt: FloatArray
    position: FloatArray
    axis: FloatArray
    thrust_min: FloatArray
    thrust_max: FloatArray
    thrust_range: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Sensitivity:
    """A value and its derivatives with respect to the design, from both sides.

    `tilt`, `position`, `axis`, `thrust_min`, `thrust_max` and `thrust_range` are the derivatives
    (see `Derivatives` for units) where there are any: not a number where left and right differ.

    Attributes
    ----------
    value : float
        N for a radius, W for the power of hovering level, 1 for the condition number.
    left, right : Derivatives
        As a parameter decreases, and as it increases: the limits of (v(x) − v(x − h)) / h and
        (v(x + h) − v(x)) / h for h → 0. Infinite where the vehicle could not hover level any more.
    """

    value: float
    left: Derivatives
    right: Derivatives
    _parameters: _Parameters
    _slope: Slope

    @property
    def tilt(self) -> FloatArray:
        """Per rad of each servo, (m,)."""
        return _both(self.left.tilt, self.right.tilt)

    @property
    def position(self) -> FloatArray:
        """Per m of each hub, (n, 3), in B."""
        return _both(self.left.position, self.right.position)

    @property
    def axis(self) -> FloatArray:
        """Per rad by which each untilted thrust axis leans, (n, 3), in B."""
        return _both(self.left.axis, self.right.axis)

    @property
    def thrust_min(self) -> FloatArray:
        """Per N of each lower limit, (n,)."""
        return _both(self.left.thrust_min, self.right.thrust_min)

    @property
    def thrust_max(self) -> FloatArray:
        """Per N of each upper limit, (n,)."""
        return _both(self.left.thrust_max, self.right.thrust_max)

    @property
    def thrust_range(self) -> FloatArray:
        """Per N by which both limits of a rotor move outwards, (n,)."""
        return _both(self.left.thrust_range, self.right.thrust_range)

    def along(
        self,
        *,
        tilt: ArrayLike = 0.0,
        position: ArrayLike = 0.0,
        axis: ArrayLike = 0.0,
        thrust_min: ArrayLike = 0.0,
        thrust_max: ArrayLike = 0.0,
    ) -> float:
        """Return the derivative as the design sets out in a direction, everything together.

        At a kink it is not the sum of those of its parts. The one the other way is
        −``along`` of the opposite direction.

        Parameters
        ----------
        tilt, position, axis, thrust_min, thrust_max : arrays or numbers
            By how much each changes: rad, m, rad, N, N; shaped as in `Derivatives`.

        Examples
        --------
        One rotor more of a newton upwards gains OmniMorph nothing; all, both ways, gain.

        >>> import math
        >>> found = sensitivity("omnimorph", math.radians(20.0), "radius_free_moment")
        >>> float(found.right.thrust_max[0]), round(found.along(thrust_max=1, thrust_min=-1), 4)
        (0.0, 1.3681)
        """
        given = {"tilt": tilt, "position": position, "axis": axis}
        given |= {"thrust_min": thrust_min, "thrust_max": thrust_max}
        return float(self._slope.ahead(self._parameters.together(given))[0])


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
        force set is degenerate, the vehicle cannot hover level, or A has not full rank.

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
        slope = slope_of_power(vehicle, angles, A)
    elif quantity == "condition_number":
        slope = slope_of_condition(vehicle, angles)
    else:
        slope = slope_of_radius(vehicle, angles, A, quantity == "radius_zero_moment")
    parameters = _Parameters.of(vehicle, angles, A)
    changes = parameters.one_by_one()
    return Sensitivity(
        value=slope.value,
        left=parameters.sorted_out(-slope.ahead(changes.reversed())),
        right=parameters.sorted_out(slope.ahead(changes)),
        _parameters=parameters,
        _slope=slope,
    )


def _both(left: FloatArray, right: FloatArray) -> FloatArray:
    """Return the derivative where it is the same from both sides, else not a number."""
    ends = np.concatenate([left.ravel(), right.ravel()])
    size = float(np.abs(ends[np.isfinite(ends)]).max(initial=0.0))
    with np.errstate(invalid="ignore"):
        return np.where(np.abs(left - right) <= _SAME * size, 0.5 * (left + right), np.nan)


class _Parameters(NamedTuple):
    """What can be changed, by how it changes A: column i is [z; p × z − k κ z], z = R z0.

    Attributes
    ----------
    matrices : dict
        Name -> (P, 6, n) array: ∂A by each number of that parameter.
    shapes : dict
        Name -> shape of that parameter.
    """

    matrices: dict[str, FloatArray]
    shapes: dict[str, tuple[int, ...]]

    @classmethod
    def of(cls, vehicle: Vehicle, angles: FloatArray, A: FloatArray) -> _Parameters:
        n, m = vehicle.n_rotors, vehicle.n_servos
        tilt = np.zeros((m, 6, n))
        position, axis = np.zeros((n, 3, 6, n)), np.zeros((n, 3, 6, n))
        for i, one in enumerate(np.eye(n)):
            tilt[:, :, i] = tilt_derivative(vehicle, one, angles).T
            position[i, :, 3:, i] = np.cross(np.eye(3), A[:3, i])
            z0, p = vehicle.rotor_axis[i], vehicle.rotor_position[i]
            leaning = _turned(vehicle, angles, i, np.eye(3) - np.outer(z0, z0))
            drag = float(vehicle.rotor_spin[i] * vehicle.kappa[i])
            axis[i, :, :3, i] = leaning
            axis[i, :, 3:, i] = np.cross(p, leaning) - drag * leaning
        still = np.zeros((n, 6, n))
        matrices = {"tilt": tilt, "position": position.reshape(-1, 6, n)}
        matrices |= {"axis": axis.reshape(-1, 6, n), "thrust_min": still, "thrust_max": still}
        shapes: dict[str, tuple[int, ...]] = {"tilt": (m,), "position": (n, 3), "axis": (n, 3)}
        return cls(matrices, shapes | {"thrust_min": (n,), "thrust_max": (n,)})

    def together(self, given: dict[str, ArrayLike]) -> Changes:
        """Return one direction in which several numbers change."""
        steps = {
            name: np.broadcast_to(as_numbers(value), self.shapes[name])
            for name, value in given.items()
        }
        matrix = sum(np.tensordot(steps[name].ravel(), self.matrices[name], 1) for name in steps)
        return Changes(
            np.asarray(matrix)[None], steps["thrust_min"][None], steps["thrust_max"][None]
        )

    def one_by_one(self) -> Changes:
        """Return the directions in which a single number changes, then the ranges of thrust."""
        n = self.shapes["thrust_max"][0]
        each = np.concatenate([*self.matrices.values(), np.zeros((n, 6, n))])
        least, most = np.zeros((2, len(each), n))
        least[-3 * n : -2 * n], most[-2 * n : -n] = np.eye(n), np.eye(n)
        least[-n:], most[-n:] = -np.eye(n), np.eye(n)
        return Changes(each, least, most)

    def sorted_out(self, slopes: FloatArray) -> Derivatives:
        """Return slopes in the order of `one_by_one` by name."""
        shapes = [*self.shapes.values(), self.shapes["thrust_max"]]
        ends = np.cumsum([int(np.prod(shape)) for shape in shapes])
        parts = np.split(slopes + 0.0, ends[:-1])
        return Derivatives(*(part.reshape(s) for part, s in zip(parts, shapes, strict=True)))


def _turned(vehicle: Vehicle, angles: FloatArray, i: int, rows: FloatArray) -> FloatArray:
    """Return vectors, (k, 3), that are fixed to a rotor, as they are when it is tilted."""
    servo = int(vehicle.rotor_servo[i])
    if servo < 0:
        return rows
    a, angle = vehicle.hinge_axis[i], float(angles[servo])
    along = np.outer(rows @ a, a)
    turned: FloatArray = along + (rows - along) * np.cos(angle) + np.cross(a, rows) * np.sin(angle)
    return turned
