"""A design under its sliders: what it can make, hold and spend, computed anew at each move."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from omnimorph.analysis.actuation import Actuation, actuation
from omnimorph.analysis.attitude_share import AttitudeShare, attitude_share
from omnimorph.analysis.hover import HoverPoint, hover, hover_power, sphere_directions
from omnimorph.analysis.omnidirectional import tilt_of_largest_radius
from omnimorph.analysis.platform import Platform, platform
from omnimorph.analysis.polytope import Polytope, Sphere
from omnimorph.analysis.wrench_set import force_set, moment_set
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

ATTITUDES = np.vstack([[(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)], sphere_directions(900)])
"""Attitudes on the sphere of hover power, level first: the vertical seen from the body."""

_SAMPLED = 7  # tilts at which a vehicle is looked at before its sets are drawn to scale


@dataclass(frozen=True, eq=False)
class Design:
    """A vehicle from a file and what the sliders make of it.

    Attributes
    ----------
    base : Vehicle
        As in its file.
    tilt : (m,) array, rad
        Of each servo.
    mass : float, kg
        The inertia grows with it, and so does the mass of the tilt mechanism.
    speed : float
        Largest rotor speed over that of the file; limits below zero are scaled too.
    size : float
        Distances of the rotors over those of the file; the inertia grows with its square.
    zero_moment : bool
        Whether the force set is that without a moment, or that with moments free.
    """

    base: Vehicle
    tilt: FloatArray
    mass: float
    speed: float = 1.0
    size: float = 1.0
    zero_moment: bool = True

    @classmethod
    def of(cls, base: Vehicle, tilt: FloatArray | None = None) -> Design:
        """Return a vehicle as its file has it, at a tilt.

        By default where the inscribed sphere of the forces at zero moment is largest, as
        `analyze` has it, if all rotors share one servo; else at the tilt nearest to zero.
        """
        if tilt is None and base.n_servos == 1:
            tilt = np.array([tilt_of_largest_radius(base)])
        if tilt is None:
            tilt = np.clip(0.0, base.servo_angle_min, base.servo_angle_max)
        return cls(base, tilt, base.mass)

    def changed(self, **sliders: object) -> Design:
        """Return the same design with other sliders."""
        return replace(self, **sliders)  # type: ignore[arg-type]

    def vehicle(self) -> Vehicle:
        """Return the vehicle of this design, ready to be analysed or written to a file."""
        base = self.base
        heavier = self.mass / base.mass
        return base.replace(
            mass=self.mass,
            tilt_mechanism_mass=base.tilt_mechanism_mass * heavier,
            inertia=base.inertia * heavier * self.size**2,
            rotor_position=base.rotor_position * self.size,
            speed_max=base.speed_max * self.speed,
            speed_min=np.where(base.speed_min < 0.0, base.speed_min * self.speed, base.speed_min),
            dead_band=base.dead_band * min(self.speed, 1.0),
        )

    def view(self) -> View:
        """Return everything the page shows of it."""
        vehicle = self.vehicle()
        forces = force_set(vehicle, self.tilt, zero_moment=self.zero_moment)
        return View(
            vehicle=vehicle,
            tilt=self.tilt,
            forces=forces,
            moments=moment_set(vehicle, self.tilt),
            sphere=None if forces.is_empty else forces.inscribed_sphere(),
            weight=vehicle.mass * GRAVITY,
            level=hover(vehicle, self.tilt),
            power=hover_power(vehicle, self.tilt, ATTITUDES),
            actuation=actuation(vehicle, self.tilt),
            attitudes=attitude_share(vehicle, force_set(vehicle, self.tilt, zero_moment=True)),
            platform=_platform_of(self.base, self.mass, self.speed, self.size),
        )


class View(NamedTuple):
    """What is seen of a design.

    Attributes
    ----------
    vehicle : Vehicle
    tilt : (m,) array, rad
    forces, moments : Polytope
        In N and N m, in B.
    sphere : Sphere or None
        The inscribed sphere of the forces about zero, and where it touches: the weakest direction.
    weight : float, N
    level : HoverPoint
        Hovering level.
    power : (D,) array, W
        Least hover power in each of `ATTITUDES`; inf where it cannot hover.
    actuation : Actuation
        At this tilt.
    attitudes : AttitudeShare
        Of all attitudes, those in which it can hover at this tilt.
    platform : Platform
        Class and numbers over all tilts, each servo at its own: what `compare` shows.
    """

    vehicle: Vehicle
    tilt: FloatArray
    forces: Polytope
    moments: Polytope
    sphere: Sphere | None
    weight: float
    level: HoverPoint
    power: FloatArray
    actuation: Actuation
    attitudes: AttitudeShare
    platform: Platform


@lru_cache(maxsize=16)
def _platform_of(base: Vehicle, mass: float, speed: float, size: float) -> Platform:
    """Return the numbers over all tilts: with many servos that takes a second, so it is kept."""
    return platform(Design(base, np.zeros(base.n_servos), mass, speed, size).vehicle())


class Scales(NamedTuple):
    """What is drawn one unit long: a length (m), a force (N), a moment (N m)."""

    length: float
    force: float
    moment: float


def scales_of(vehicle: Vehicle) -> Scales:
    """Return the scales at which a vehicle is explored: the same for all its tilts.

    Raises
    ------
    VehicleError
        If it makes no force without a moment at any tilt.
    """
    force = moment = 0.0
    for share in np.linspace(0.0, 1.0, _SAMPLED if vehicle.n_servos else 1):
        low, high = vehicle.servo_angle_min, vehicle.servo_angle_max
        tilt = low + share * (high - low)
        for candidate in (tilt, np.clip(0.0, low, high)):
            force = max(force, _extent(force_set(vehicle, candidate, zero_moment=True)))
            moment = max(moment, _extent(moment_set(vehicle, candidate)))
    if force <= 1e-9 * float(np.maximum(vehicle.thrust_max, -vehicle.thrust_min).sum()):
        raise VehicleError(
            f"vehicle {vehicle.name}: its rotors make no force without a moment at any tilt, so "
            "there is nothing to explore; give it rotors that balance one another."
        )
    hubs = np.linalg.norm(vehicle.rotor_position, axis=1)
    return Scales(length=float(hubs.max()), force=force, moment=moment or 1.0)


def is_cube(vehicle: Vehicle) -> bool:
    """Return whether the rotors sit at the corners of a cube, so that it has a half-edge."""
    corners = np.abs(vehicle.rotor_position)
    return bool(np.allclose(corners, corners[0, 0], rtol=1e-9) and corners[0, 0] > 0.0)


def _extent(polytope: Polytope) -> float:
    if polytope.is_empty:
        return 0.0
    return float(np.linalg.norm(polytope.vertices, axis=1).max())
