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
from omnimorph.design.ranges import UNIT_VECTOR, Range
from omnimorph.design.unit_doubts import question_units, unit_doubts
from omnimorph.design.vehicle_fields import (
    VehicleField,
    as_text,
    fields_of,
    of_body,
    of_filters,
    of_rotors,
    of_servos,
)
from omnimorph.protocols import FloatArray

__all__ = ["MOST_ROTORS", "MOST_SERVOS", "Source", "ThrustAxisParts", "Vehicle"]

MOST_ROTORS = 18
MOST_SERVOS = 18
MOST_THRUST = 1e9  # N, of one rotor
MOST_KAPPA = 1e7  # m, drag torque per thrust

# What the fields of vehicles may be.
_TIME = Range(0.0, 1e6)  # ms
_ANGLE = Range(-1e5, 1e5)  # degrees
_POSITIVE = "a positive number"
_NOT_NEGATIVE = "zero or a positive number"
_NUMBER = "a finite number"
_DIRECTION = "a unit vector [x, y, z]"


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

    name: str = as_text()
    title: str = as_text()
    mass: float = of_body("kg", Range(1e-6, 1e6), "a positive number of kilograms", in_core=True)
    tilt_mechanism_mass: float = of_body(
        "kg",
        Range(0.0, 1e6),
        "zero or a positive number of kilograms, below mass_kg",
        default=0.0,
    )
    inertia: FloatArray = of_body(
        "kg_m2",
        Range(-1e9, 1e9),
        "three numbers [Jx, Jy, Jz] or a 3 x 3 matrix, in kg m²",
        shape=(3, 3),
        in_core=True,
    )
    rotor_position: FloatArray = of_rotors(
        "m",
        Range(-1e4, 1e4),
        "three finite numbers [x, y, z] in metres",
        shape=(3,),
        in_core=True,
    )
    rotor_axis: FloatArray = of_rotors(
        "", UNIT_VECTOR, _DIRECTION, shape=(3,), in_file=(0.0, 0.0, 1.0)
    )
    hinge_axis: FloatArray = of_rotors(
        "", UNIT_VECTOR, _DIRECTION, shape=(3,), in_file=(0.0, 0.0, 0.0), word="hinge"
    )
    rotor_servo: NDArray[np.int64] = as_text("rotor", ())
    rotor_spin: FloatArray = as_text("rotor", (), in_core=True)
    thrust_coefficient: FloatArray = of_rotors(
        "N_per_Hz2", Range(1e-15, 1e6), _POSITIVE, in_core=True
    )
    drag_coefficient: FloatArray = of_rotors(
        "Nm_per_Hz2", Range(1e-30, 1e6), _POSITIVE, in_core=True
    )
    speed_min: FloatArray = of_rotors(
        "Hz", Range(-1e5, 1e5), _NUMBER, thrust_limits=Range(-1e9, 1e9), in_core=True
    )
    speed_max: FloatArray = of_rotors(
        "Hz", Range(1e-3, 1e5), _POSITIVE, thrust_limits=Range(1e-9, 1e9), in_core=True
    )
    dead_band: FloatArray = of_rotors("Hz", Range(0.0, 1e5), _NOT_NEGATIVE, in_file=0.0)
    time_constant_up: FloatArray = of_rotors("ms", _TIME, _NOT_NEGATIVE, in_file=0.0)
    time_constant_down: FloatArray = of_rotors("ms", _TIME, _NOT_NEGATIVE, in_file=0.0)
    spin_inertia: FloatArray = of_rotors(
        "kg_m2", Range(0.0, 1e6), _NOT_NEGATIVE, in_file=0.0, in_core=True
    )
    servo_name: tuple[str, ...] = as_text("servo")
    servo_angle_min: FloatArray = of_servos("deg", _ANGLE, _NUMBER, in_core=True)
    servo_angle_max: FloatArray = of_servos("deg", _ANGLE, _NUMBER, in_core=True)
    servo_rate_max: FloatArray = of_servos("deg_per_s", Range(1e-3, 1e6), _POSITIVE, in_core=True)
    servo_time_constant: FloatArray = of_servos("ms", _TIME, _NOT_NEGATIVE, in_file=0.0)
    filter_cutoff: FloatArray = of_filters("Hz", Range(0.0, 1e6), _NOT_NEGATIVE, in_file=0.0)
    sources: Mapping[str, Source] = dataclasses.field(default_factory=dict)
    questioned: dataclasses.InitVar[bool] = True

    def __post_init__(self, questioned: bool) -> None:
        check = Checks(self.name)
        check.name("name", self.name)
        check.line("title", self.title)
        self._settle("servo_name", check.names("servo_name", self.servo_name, MOST_SERVOS))
        n = check.count("rotor_position", self.rotor_position, MOST_ROTORS)
        for field in fields_of(type(self)).values():
            if field.shape is not None:
                self._settle(field.name, self._numbers(check, field, n))
        part = check.part_of_mass("tilt_mechanism_mass", self.tilt_mechanism_mass, self.mass)
        self._settle("tilt_mechanism_mass", part)
        self._settle("inertia", check.inertia("inertia", self.inertia))
        self._settle_rotors(check)
        self._check_limits(check)
        fields = [field.name for field in dataclasses.fields(self)]
        self._settle("sources", check.sources("sources", self.sources, fields))
        if questioned:
            question_units(unit_doubts(self, "rad_per_s"), self._place, str)

    def _numbers(self, check: Checks, field: VehicleField, n_rotors: int) -> float | FloatArray:
        """Return what the vehicle was given for a field, checked by its declaration."""
        value, shape = getattr(self, field.name), field.whole_shape(n_rotors, self.n_servos)
        if value is None and field.is_optional:
            value = field.filled(shape)
        array = check.array(field.name, value, shape, field.limits_in_SI)
        if field.is_direction and field.name != "hinge_axis":  # which some rotors do not have
            array = check.unit(field.name, array)
        return array if shape else float(array)

    def _settle(self, field: str, value: Any) -> None:
        """Set a field once, as a frozen dataclass does itself."""
        object.__setattr__(self, field, value)

    def _place(self, attribute: str, index: int | None) -> tuple[str, Any]:
        """Return what an attribute, or one of its entries, is called, and its value."""
        value, where = getattr(self, attribute), f"vehicle {self.name}: {attribute}"
        return (where, value) if index is None else (f"{where}[{index}]", value[index])

    def _settle_rotors(self, check: Checks) -> None:
        """Check what ties a rotor to its servo, and normalise the axes about which it tilts."""
        servo = check.servos("rotor_servo", self.rotor_servo, self.n_servos)
        self._settle("rotor_servo", servo)
        tilts = servo >= 0
        hinge = check.unit("hinge_axis", self.hinge_axis, tilts)
        self._settle("hinge_axis", hinge)
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


def _rebuild(kind: type[Vehicle], values: dict[str, Any]) -> Vehicle:
    return kind(**values)
