"""`Vehicle`: one frozen, checked record of everything the equations need to know.

Rotor i of n has its hub at ``p_i`` and thrusts along ``z_i``. A rotor on servo j tilts about its
hinge axis ``a_i``; Rodrigues' formula for a turn by +α about ``a_i`` is, exactly ::

    z_i(α) = z0_i + zC_i cos α + zS_i sin α
    z0 = a (a·z),   zC = z − a (a·z),   zS = a × z          (z = thrust axis at α = 0)

and a rotor that does not tilt has z0 = z, zC = zS = 0. Its thrust is f = c_f w|w|, signed along
``z_i``; its drag torque is −k kappa f ``z_i`` with kappa = c_tau / c_f.

Everything here is SI and in the frame B at the centre of mass.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from omnimorph.design.checks import Checks, Source, read_only
from omnimorph.design.unit_doubts import unit_doubts
from omnimorph.design.unit_warnings import question_units
from omnimorph.protocols import FloatArray

__all__ = ["MOST_ROTORS", "MOST_SERVOS", "Source", "ThrustAxisParts", "Vehicle"]

MOST_ROTORS = 18
MOST_SERVOS = 18
MOST_THRUST = 1e9  # N, of one rotor
MOST_KAPPA = 1e7  # m, drag torque per thrust


class ThrustAxisParts(NamedTuple):
    """The parts of z(α) = z0 + zC cos α + zS sin α, each an (n, 3) array in B."""

    z0: FloatArray
    zC: FloatArray
    zS: FloatArray


@dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
class Vehicle:
    """A multirotor of 1 to 18 rotors and 0 to 18 servos.

    Arrays are copied, made read-only and checked; n is the number of rotors, m of servos.

    Attributes
    ----------
    name : str
        Short name: letters, digits, ``.``, ``_`` and ``-``.
    title : str
        One line that says which vehicle it is.
    mass : float
        In kg, everything included.
    tilt_mechanism_mass : float
        Of what tilts the rotors, in kg: a part of `mass`, and below it; 0 = none, or not known.
    inertia : (3, 3) array, kg m², in B
        About the centre of mass; symmetric, positive definite, no principal moment larger than the
        sum of the other two.
    rotor_position : (n, 3) array, m, in B
        Hubs ``p_BP``, from the centre of mass.
    rotor_axis : (n, 3) array, in B
        Unit thrust axes at zero tilt (within 1 % of unit length they are normalised).
    hinge_axis : (n, 3) array, in B
        Unit axes of tilt, normalised likewise; zeros for a rotor that does not tilt.
    rotor_servo : (n,) array of int64
        The servo that tilts the rotor; −1 if none does.
    rotor_spin : (n,) array
        ``k``: +1 if the rotor turns counter-clockwise about its thrust axis when w > 0, −1 if
        clockwise. Drag torque: −k kappa f z.
    thrust_coefficient : (n,) array, N s²/rad²
        c_f > 0 in f = c_f w|w|.
    drag_coefficient : (n,) array, N m s²/rad²
        c_tau > 0 in the torque c_tau w|w|.
    speed_min, speed_max : (n,) array, rad/s
        Limits of the speed w; a negative minimum means the rotor can turn both ways.
    dead_band : (n,) array, rad/s
        The rotor cannot turn more slowly than this, unless it rests; 0 if it can.
    time_constant_up, time_constant_down : (n,) array, s
        Of the first-order lag of the speed when its magnitude rises, and when it falls; 0 = none.
    spin_inertia : (n,) array, kg m²
        Of propeller and motor bell about the axis of rotation; 0 = neglected.
    servo_name : tuple of m str
        Names, all different.
    servo_angle_min, servo_angle_max : (m,) array, rad
        Limits of the tilt; equal for a servo that is locked.
    servo_rate_max : (m,) array, rad/s
        Largest rate of the tilt, > 0.
    servo_time_constant : (m,) array, s
        Of the first-order lag of the tilt; 0 = none.
    filter_cutoff : (4,) array, rad/s
        Of the state estimator's first-order filters for position, velocity, attitude and body rate;
        0 = not filtered.
    sources : mapping of str to Source
        Name of an attribute above -> where its numbers come from.
    questioned : bool, of the constructor only
        Whether numbers that look like those of another unit are questioned; True by default.

    Raises
    ------
    VehicleError
        If anything is not as said above; the message names the attribute, and the rotor or servo by
        its index, counted from 0.

    Warns
    -----
    UnlikelyUnitWarning
        If a number looks like one in another unit; copies are not questioned again.
    """

    name: str
    title: str
    mass: float
    tilt_mechanism_mass: float = 0.0
    inertia: FloatArray
    rotor_position: FloatArray
    rotor_axis: FloatArray
    hinge_axis: FloatArray
    rotor_servo: NDArray[np.int64]
    rotor_spin: FloatArray
    thrust_coefficient: FloatArray
    drag_coefficient: FloatArray
    speed_min: FloatArray
    speed_max: FloatArray
    dead_band: FloatArray
    time_constant_up: FloatArray
    time_constant_down: FloatArray
    spin_inertia: FloatArray
    servo_name: tuple[str, ...]
    servo_angle_min: FloatArray
    servo_angle_max: FloatArray
    servo_rate_max: FloatArray
    servo_time_constant: FloatArray
    filter_cutoff: FloatArray
    sources: Mapping[str, Source] = dataclasses.field(default_factory=dict)
    questioned: dataclasses.InitVar[bool] = True

    def __post_init__(self, questioned: bool) -> None:
        check = Checks(self.name)
        set_once = object.__setattr__  # how a frozen dataclass settles its own fields
        check.name("name", self.name)
        check.line("title", self.title)
        set_once(self, "mass", check.number("mass", self.mass))
        part = check.part_of_mass("tilt_mechanism_mass", self.tilt_mechanism_mass, self.mass)
        set_once(self, "tilt_mechanism_mass", part)
        set_once(self, "inertia", check.inertia("inertia", self.inertia))
        set_once(self, "servo_name", check.names("servo_name", self.servo_name, MOST_SERVOS))
        n = check.count("rotor_position", self.rotor_position, MOST_ROTORS)
        for field, shape in _shapes(n, len(self.servo_name)).items():
            set_once(self, field, check.array(field, getattr(self, field), shape))
        self._settle_rotors(check)
        self._check_limits(check)
        fields = [field.name for field in dataclasses.fields(self)]
        set_once(self, "sources", check.sources("sources", self.sources, fields))
        if questioned:
            question_units(unit_doubts(self, "rad_per_s"), self._place, str)

    def _place(self, attribute: str, index: int | None) -> tuple[str, Any]:
        """Return what an attribute, or one of its entries, is called, and its value."""
        value, where = getattr(self, attribute), f"vehicle {self.name}: {attribute}"
        return (where, value) if index is None else (f"{where}[{index}]", value[index])

    def _settle_rotors(self, check: Checks) -> None:
        """Normalise the axes and check what ties a rotor to its servo."""
        servo = check.servos("rotor_servo", self.rotor_servo, self.n_servos)
        object.__setattr__(self, "rotor_servo", servo)
        object.__setattr__(self, "rotor_axis", check.unit("rotor_axis", self.rotor_axis))
        tilts = servo >= 0
        hinge = check.unit("hinge_axis", self.hinge_axis, tilts)
        object.__setattr__(self, "hinge_axis", hinge)
        check.each("hinge_axis", hinge, tilts | ~hinge.any(axis=1), "zero, as no servo tilts it")
        check.each("rotor_spin", self.rotor_spin, np.abs(self.rotor_spin) == 1.0, "1 or -1")

    def _check_limits(self, check: Checks) -> None:
        """Check the order of limits, and what follows from several numbers."""
        below = self.speed_min < self.speed_max
        check.each("speed_min", self.speed_min, below, "below the upper limit")
        slowest = np.where(
            self.speed_min < 0.0, np.minimum(-self.speed_min, self.speed_max), self.speed_max
        )
        check.each("dead_band", self.dead_band, self.dead_band < slowest, "below the speed limits")
        ordered = self.servo_angle_min <= self.servo_angle_max
        check.each("servo_angle_min", self.servo_angle_min, ordered, "at most the upper limit")
        for field, derived, most in (
            ("speed_min", self.thrust_min, MOST_THRUST),
            ("speed_max", self.thrust_max, MOST_THRUST),
            ("drag_coefficient", self.kappa, MOST_KAPPA),
        ):
            small = np.abs(derived) <= most
            allowed = f"so small that {_DERIVED[field]} is at most {most:g}"
            check.each(field, getattr(self, field), small, allowed)

    @property
    def n_rotors(self) -> int:
        """Number of rotors, n."""
        return len(self.rotor_position)

    @property
    def n_servos(self) -> int:
        """Number of servos, m."""
        return len(self.servo_name)

    @cached_property
    def thrust_min(self) -> FloatArray:
        """Lower limit of the thrust, c_f w|w| at `speed_min`: (n,) array, N."""
        return self._thrust(self.speed_min)

    @cached_property
    def thrust_max(self) -> FloatArray:
        """Upper limit of the thrust, c_f w|w| at `speed_max`: (n,) array, N.

        OmniMorph: 5.3587 N, which is 1.8638e-4 N/Hz² times (169.56 Hz)².
        """
        return self._thrust(self.speed_max)

    @cached_property
    def kappa(self) -> FloatArray:
        """Drag torque per thrust, c_tau / c_f: (n,) array, m.

        OmniMorph: 2.754e-6 / 1.8638e-4 = 0.014776 m.
        """
        return read_only(self.drag_coefficient / self.thrust_coefficient)

    @cached_property
    def thrust_axis_parts(self) -> ThrustAxisParts:
        """Parts z0, zC, zS of the thrust axes z(α) = z0 + zC cos α + zS sin α, each (n, 3), in B.

        OmniMorph's first rotor has hinge (0, −1, 0), so z0 = 0, zC = (0, 0, 1), zS = (−1, 0, 0).
        """
        axis, hinge = self.rotor_axis, self.hinge_axis
        tilts = (self.rotor_servo >= 0)[:, np.newaxis]
        along = hinge * np.sum(hinge * axis, axis=1, keepdims=True)
        z0 = np.where(tilts, along, axis)
        return ThrustAxisParts(
            z0=read_only(z0),
            zC=read_only(axis - z0),
            zS=read_only(np.cross(hinge, axis)),
        )

    def replace(self, **changes: Any) -> Self:
        """Return a copy with some attributes changed, checked again.

        Examples
        --------
        OmniMorph without its tilt mechanism, 1.315 − 0.187 = 1.128 kg ::

            bare = vehicle.mass - vehicle.tilt_mechanism_mass
            vehicle.replace(mass=bare, tilt_mechanism_mass=0.0)
        """
        return dataclasses.replace(self, **({"questioned": False} | changes))

    def _thrust(self, speed: FloatArray) -> FloatArray:
        return read_only(self.thrust_coefficient * speed * np.abs(speed))

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor, so that a copy from another process is as read-only as this one.
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        values |= {"sources": dict(self.sources), "questioned": False}
        return (_rebuild, (type(self), values))


_DERIVED = {
    "speed_min": "the size of the least thrust, N,",
    "speed_max": "the largest thrust, N,",
    "drag_coefficient": "drag torque per thrust, m,",
}


def _shapes(n: int, m: int) -> dict[str, tuple[int, ...]]:
    """Return the shape of each array of a vehicle with n rotors and m servos."""
    vectors = ("rotor_position", "rotor_axis", "hinge_axis")
    of_rotors = (
        "rotor_servo",
        "rotor_spin",
        "thrust_coefficient",
        "drag_coefficient",
        "speed_min",
        "speed_max",
        "dead_band",
        "time_constant_up",
        "time_constant_down",
        "spin_inertia",
    )
    of_servos = ("servo_angle_min", "servo_angle_max", "servo_rate_max", "servo_time_constant")
    shapes: dict[str, tuple[int, ...]] = {"filter_cutoff": (4,)}
    shapes |= dict.fromkeys(vectors, (n, 3))
    shapes |= dict.fromkeys(of_rotors, (n,))
    shapes |= dict.fromkeys(of_servos, (m,))
    return shapes


def _rebuild(kind: type[Vehicle], values: dict[str, Any]) -> Vehicle:
    return kind(**values)
