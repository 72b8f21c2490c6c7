"""A vehicle in a few numbers by which platforms are compared, whatever tilts its rotors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from omnimorph.analysis.actuation import actuation
from omnimorph.analysis.free_tilt import dimension_over_tilts, reach_over_tilts
from omnimorph.analysis.hover import hover, sphere_directions
from omnimorph.analysis.omnidirectional import inscribed_radius, tilt_of_largest_radius
from omnimorph.analysis.vehicle_class import ActuationKind, ThrustKind, VehicleClass, thrust_kind
from omnimorph.analysis.wrench_set import force_set
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

_TILTS = 61
_DIRECTIONS, _SIDES = 200, 36
_KINDS = list(ActuationKind)  # from less to more


@dataclass(frozen=True, kw_only=True)
class Platform:
    """What a vehicle comes to.

    Attributes
    ----------
    name : str
    n_rotors, n_servos : int
    mass : float, kg
    kind : ActuationKind
        The highest at any tilts it can take, each servo at its own.
    thrust_kind : ThrustKind
        Likewise.
    radius_over_weight : float
        Largest force in every direction at zero moment over m g: exact and at the best tilt for one
        servo or none; with tilts of its own for each of 200 directions for several.
    lateral_over_weight : float
        Largest sideways force beside the weight, to every side, over m g, likewise.
    hover_power : float, W
        Least rotor drag power to hover level at a tilt common to all servos; inf if it cannot,
        or if they have none in common.
    """

    name: str
    n_rotors: int
    n_servos: int
    mass: float
    kind: ActuationKind
    thrust_kind: ThrustKind
    radius_over_weight: float
    lateral_over_weight: float
    hover_power: float

    @property
    def vehicle_class(self) -> VehicleClass:
        """Both kinds."""
        return VehicleClass(self.kind, self.thrust_kind)

    @property
    def has_free_tilts(self) -> bool:
        """Whether servos tilt independently, so that no common tilt says what it can do."""
        return self.n_servos > 1

    @property
    def hover_power_per_kg(self) -> float:
        """Hover power over mass, W/kg."""
        return self.hover_power / self.mass


def platform(vehicle: VehicleLike) -> Platform:
    """Return a vehicle in a few numbers.

    Examples
    --------
    >>> import omnimorph as om
    >>> found = platform(om.load_vehicle("omnimorph"))
    >>> round(found.radius_over_weight, 3), found.thrust_kind.value, round(found.hover_power, 1)
    (1.312, 'omnidirectional', 111.4)
    """
    vehicle = as_vehicle(vehicle)
    tilts = _common_tilts(vehicle)
    weight = vehicle.mass * GRAVITY
    radius, lateral, dimension = _forces(vehicle, tilts)
    return Platform(
        name=vehicle.name,
        n_rotors=vehicle.n_rotors,
        n_servos=vehicle.n_servos,
        mass=vehicle.mass,
        kind=_actuation_kind(vehicle),
        thrust_kind=thrust_kind(dimension, radius, weight),
        radius_over_weight=radius / weight,
        lateral_over_weight=lateral / weight,
        hover_power=min((hover(vehicle, tilt).power for tilt in tilts), default=math.inf),
    )


def lateral_reach(vehicle: VehicleLike, tilt: float | FloatArray) -> float:
    """Return the largest r for which every sideways force of size r can be added to the weight.

    ``(r cos φ, r sin φ, m g)`` is in the set of forces at zero moment for every φ; exact, from the
    halfspaces n·x ≤ h of the set: r = min (h − n_z m g) / |n_xy|.

    Parameters
    ----------
    vehicle : Vehicle
        Any.
    tilt : float or (m,) array, rad
        Of its servos.

    Returns
    -------
    float
        In N; 0 if the vehicle cannot push sideways, or cannot even hover.

    Examples
    --------
    Parallel rotors push nowhere but up; OmniMorph at 20° pushes sideways beside its weight.

    >>> import omnimorph as om
    >>> vehicle = om.load_vehicle("omnimorph")
    >>> lateral_reach(vehicle, 0.0), round(lateral_reach(vehicle, math.radians(20.0)), 2)
    (0.0, 6.66)
    """
    vehicle = as_vehicle(vehicle)
    forces, weight = force_set(vehicle, tilt, zero_moment=True), vehicle.mass * GRAVITY
    if forces.dimension < 3 or not forces.contains([0.0, 0.0, weight]):
        return 0.0
    # A superfluous halfspace leaves at least as much room, so the facets need not be found.
    normals = forces.rows @ forces.basis.T
    across = np.hypot(normals[:, 0], normals[:, 1])
    room = forces.bounds - normals @ (np.array([0.0, 0.0, weight]) - forces.origin)
    sideways = across > 1e-9
    return max(float((room[sideways] / across[sideways]).min()), 0.0)


def lateral_reach_over_tilts(vehicle: Vehicle) -> float:
    """Return `lateral_reach`, N, with the best tilts of all servos for each of 36 sides."""
    turn = np.linspace(0.0, 2.0 * math.pi, _SIDES, endpoint=False)
    sides = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(_SIDES)])
    weight = np.array([0.0, 0.0, vehicle.mass * GRAVITY])
    return float(reach_over_tilts(vehicle, sides, weight).min())


def _common_tilts(vehicle: Vehicle) -> list[float]:
    """Return tilts that all servos can take together; none if their limits leave none."""
    if vehicle.n_servos == 0:
        return [0.0]
    low, high = float(vehicle.servo_angle_min.max()), float(vehicle.servo_angle_max.min())
    return [] if low > high else np.unique(np.linspace(low, high, _TILTS)).tolist()


def _forces(vehicle: Vehicle, tilts: list[float]) -> tuple[float, float, int]:
    """Return radius, N, largest sideways force beside the weight, N, and dimension of the forces.

    At zero moment, over all tilts.
    """
    if vehicle.n_servos > 1:
        radius = float(reach_over_tilts(vehicle, sphere_directions(_DIRECTIONS)).min())
        return radius, lateral_reach_over_tilts(vehicle), dimension_over_tilts(vehicle)
    best = tilt_of_largest_radius(vehicle) if vehicle.n_servos else 0.0
    radius = inscribed_radius(vehicle, best, zero_moment=True)
    lateral = max(lateral_reach(vehicle, tilt) for tilt in tilts)
    if radius > 0.0:
        return radius, lateral, 3
    return radius, lateral, max(force_set(vehicle, a, zero_moment=True).dimension for a in tilts)


def _actuation_kind(vehicle: Vehicle) -> ActuationKind:
    """Return the highest kind of all tilts: of a few without any pattern, as almost all have it."""
    low, span = vehicle.servo_angle_min, vehicle.servo_angle_max - vehicle.servo_angle_min
    each = np.arange(vehicle.n_servos)
    shares = [np.mod(first + 0.6180339887 * each, 1.0) for first in (0.137, 0.419, 0.731)]
    kinds = [actuation(vehicle, low + share * span).kind for share in shares]
    return max(kinds, key=_KINDS.index)
