"""Numbers of a vehicle that look like those of another unit.

A number is in doubt if it is far from anything that flies. What is usual:

- the tips of propellers move at no more than 300 m/s, the propellers being the largest that fit
  between the hubs (they may be smaller);
- all rotors together lift 0.3 to 40 times the weight, and drag torque over thrust is 1 mm to 0.2 m;
- the radius of gyration is 0.02 to 2 times the reach of hubs and propellers;
- hubs are within 10 m of the centre of mass, and servos turn by 4° or more.

Speeds, thrust coefficients and mass depend on one another: reported is each way in which one of
them, or two, may be in another unit so that all is usual.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from omnimorph.errors import UnlikelyUnitWarning, legible, shown
from omnimorph.units import SPEED_SLIPS, SPEED_UNITS

if TYPE_CHECKING:
    from omnimorph.design.vehicle import Vehicle

USUAL_KAPPA = (0.005, 0.05)
"""Torque over force of propellers from 4 to 30 inches, m."""

Explanation = tuple[tuple[str, str], ...]
"""Attributes, and what each looks: ``("speed_max", "like rpm")``."""

_LONGEST = 1000  # characters of a warning
_FASTEST_TIP = 300.0  # m/s
_GRAVITY, _AIR = 9.81, 1.225  # m/s², kg/m³
# Each pair: what is not questioned, and what another unit must come to, to be likely.
_LIFT = (0.3, 40.0), (0.8, 30.0)  # of the rotors over the weight
_KAPPA = (0.001, 0.2), (0.6 * USUAL_KAPPA[0], 2.0 * USUAL_KAPPA[1])  # m
_GYRATION = (0.02, 2.0), (0.08, 0.8)  # radius over reach
_LIKELY_TIP = (30.0, _FASTEST_TIP)
# c_f/(ρ D⁴): 0.1 for the true diameter D, less where the propellers are smaller than what fits
# between the hubs, more where they overlap. A unit that makes it larger must bring it nearer to
# the middle.
_LIKELY_COEFFICIENT, _USUAL_COEFFICIENT = (1e-3, 20.0), 0.3
_FARTHEST_HUB = 10.0  # m
_ONE_AXIS = 1e-3  # 1 − cos of less than 3°
_TILT = (math.radians(4.0), 4.0 * math.pi), (math.radians(4.0), math.radians(400.0))
_LENGTHS = {"mm": 1e-3, "cm": 1e-2}
_INERTIAS = {"g m²": 1e-3, "kg cm²": 1e-4, "kg mm²": 1e-6, "g cm²": 1e-7}
_THRUST_PER = {"Hz": "N/Hz²", "rpm": "N/rpm²", "rad_per_s": "N s²/rad²"}
_TORQUE_PER = {"Hz": "N m/Hz²", "rpm": "N m/rpm²", "rad_per_s": "N m s²/rad²"}


class UnitDoubt(NamedTuple):
    """A number that is probably in another unit."""

    attribute: str  # of `Vehicle`
    number: int | None  # of the rotor or servo; None for what the vehicle has once
    why: str  # what follows from the number
    explanations: tuple[Explanation, ...]  # how it would be usual; empty if no unit explains it


def largest_radius(vehicle: Vehicle) -> float | None:
    """Return the largest radius, m, with which no two discs touch, but for 4 %.

    Those at one place count as one, and so do two fixed rotors one above the other on one axis.

    Returns
    -------
    float or None
        0.48 times the least distance; None if there is none.
    """
    hubs, axes = vehicle.rotor_position, vehicle.rotor_axis
    offset = hubs[:, None] - hubs[None]
    apart = np.linalg.norm(offset, axis=2)
    fixed = vehicle.rotor_servo < 0
    along = np.abs(np.einsum("ijk,ik->ij", offset, axes))
    coaxial = (np.abs(axes @ axes.T) > 1.0 - _ONE_AXIS) & (along > (1.0 - _ONE_AXIS) * apart)
    between = apart[(apart > 1e-9) & ~(coaxial & fixed[:, None] & fixed)]
    return 0.48 * float(between.min()) if len(between) else None


def unit_doubts(
    vehicle: Vehicle, said: str, *, limits_are_thrusts: bool = False
) -> list[UnitDoubt]:
    """Return what is in doubt about the units of a vehicle; an empty list if nothing is.

    Parameters
    ----------
    vehicle : Vehicle
        Any.
    said : str
        The unit in which its speeds were given: ``Hz`` in a file, ``rad_per_s`` in Python.
    limits_are_thrusts : bool
        Whether the limits were given as thrusts, so that the speeds follow from them.

    Examples
    --------
    >>> from omnimorph.design.files import load_vehicle
    >>> quadrotor = load_vehicle("quadrotor")
    >>> unit_doubts(quadrotor, "Hz")
    []
    >>> (doubt,) = unit_doubts(quadrotor.replace(mass=1280.0), "Hz")
    >>> doubt.attribute, doubt.why
    ('mass', 'all rotors together lift 0.00207 times the weight')
    """
    hubs = list(_of_hubs(vehicle))
    if hubs:
        return hubs  # lengths are in all the others
    found = list(_of_thrusts(vehicle, said, limits_are_thrusts))
    if not found:
        found += _of_torques(vehicle, said)
    if not any(doubt.attribute == "mass" for doubt in found):
        found += _of_inertia(vehicle)
    return [*found, *_of_tilt(vehicle, said)]


def _of_hubs(vehicle: Vehicle) -> Iterator[UnitDoubt]:
    away = np.linalg.norm(vehicle.rotor_position, axis=1)
    far = int(away.argmax())
    share = _gyration_over_reach(vehicle)
    likely = [u for u, size in _LENGTHS.items() if _within(share / size, _GYRATION[1])]
    if likely and away[far] > _FARTHEST_HUB:
        why = f"the hub is {away[far]:.3g} m from the centre of mass"
        yield UnitDoubt("rotor_position", far, why, _like("rotor_position", likely))


class _Cure(NamedTuple):
    """An explanation with the factors that put speeds, thrust coefficients and mass right."""

    explanation: Explanation
    speed: float = 1.0
    coefficient: float = 1.0
    mass: float = 1.0


def _cures(said: str) -> Iterator[list[_Cure]]:
    """Yield the ways in which units may be wrong, the likelier ones first."""
    grams = _Cure((("mass", "like g"),), mass=1e-3)
    likely, converted = [grams], []
    for slip in (slip for slip in SPEED_SLIPS if slip.said == said):
        speed = _Cure((("speed_max", f"like {SPEED_UNITS[slip.meant]}"),), 1.0 / slip.factor)
        per = ("thrust_coefficient", f"like {_THRUST_PER[slip.meant]}")
        coefficient = _Cure((per,), coefficient=slip.factor**2)
        likely += [speed, coefficient, _both(speed, coefficient)]
        wrong = f"about {slip.factor**2:.4g} times too large"
        if slip.factor < 1.0:
            wrong = f"about {slip.factor**-2:.4g} times too small"
        converted.append(_Cure((("thrust_coefficient", wrong),), coefficient=slip.factor**-2))
    yield likely
    yield converted  # the wrong way round, or twice
    yield [_both(one, grams) for one in likely[1:] if one.speed < 1.0 or one.coefficient > 1.0]


def _both(one: _Cure, other: _Cure) -> _Cure:
    return _Cure(
        one.explanation + other.explanation,
        one.speed * other.speed,
        one.coefficient * other.coefficient,
        one.mass * other.mass,
    )


def _of_thrusts(vehicle: Vehicle, said: str, limits_are_thrusts: bool) -> Iterator[UnitDoubt]:
    """Question speeds, thrust coefficients and mass, which depend on one another."""
    radius = largest_radius(vehicle)
    if radius is None:
        return
    speeds = np.maximum(np.abs(vehicle.speed_min), np.abs(vehicle.speed_max))
    tip, lift = radius * float(speeds.max()), _lift(vehicle)
    if tip <= _FASTEST_TIP and _within(lift, _LIFT[0]):
        return
    coefficient = float(np.median(vehicle.thrust_coefficient)) * (2.0 * math.pi) ** 2
    coefficient /= _AIR * (2.0 * radius) ** 4

    def odd(number: float) -> float:
        return abs(math.log(number / _USUAL_COEFFICIENT))

    def explains(cure: _Cure) -> bool:
        speed = cure.coefficient**-0.5 if limits_are_thrusts else cure.speed
        lifted = lift * cure.coefficient * speed**2 / cure.mass
        return (
            (cure.speed == 1.0 or not limits_are_thrusts)
            and _within(tip * speed, _LIKELY_TIP)
            and _within(lifted, _LIFT[1])
            and _within(coefficient * cure.coefficient, _LIKELY_COEFFICIENT)
            and (cure.coefficient <= 1.0 or odd(coefficient * cure.coefficient) <= odd(coefficient))
        )

    found = next(filter(None, ([c for c in cures if explains(c)] for cures in _cures(said))), [])
    explanations = tuple(_with_drag(vehicle, said, cure.explanation) for cure in found)
    why = f"all rotors together lift {lift:.3g} times the weight"
    if tip > _FASTEST_TIP:
        why = f"the largest propellers that fit between the hubs, of {1e3 * radius:.3g} mm radius, "
        slow = 1e3 * radius * _FASTEST_TIP / tip
        why += f"have tips at {tip:.4g} m/s, and only below {slow:.3g} mm do they stay under "
        why += f"{_FASTEST_TIP:g} m/s"
    if explanations:
        attribute = explanations[0][0][0]
    elif tip > _FASTEST_TIP:
        attribute = "thrust_coefficient" if limits_are_thrusts else "speed_max"
    else:
        return
    rotor = {"mass": None, "speed_max": int(speeds.argmax())}.get(attribute, 0)
    yield UnitDoubt(attribute, rotor, why, explanations)


def _with_drag(vehicle: Vehicle, said: str, explanation: Explanation) -> Explanation:
    """Add the drag coefficients to what is wrong with those of thrust, if they fit to those."""
    units = [slip.meant for slip in SPEED_SLIPS if slip.said == said]
    wrong = [u for u in units if ("thrust_coefficient", f"like {_THRUST_PER[u]}") in explanation]
    if wrong and _within(float(np.median(vehicle.kappa)), _KAPPA[0]):
        return (*explanation, ("drag_coefficient", f"like {_TORQUE_PER[wrong[0]]}"))
    return explanation


def _of_torques(vehicle: Vehicle, said: str) -> Iterator[UnitDoubt]:
    """Question drag coefficients beside thrust coefficients that are usual."""
    low, high = _KAPPA[0]
    for rotor, kappa in enumerate(vehicle.kappa.tolist()):
        if not low <= kappa <= high:
            likely = [
                _TORQUE_PER[slip.meant]
                for slip in SPEED_SLIPS
                if slip.said == said and _within(kappa * slip.factor**2, _KAPPA[1])
            ]
            if likely:
                why = f"drag torque over thrust is {kappa:.3g} m"
                yield UnitDoubt("drag_coefficient", rotor, why, _like("drag_coefficient", likely))
                return


def _of_inertia(vehicle: Vehicle) -> Iterator[UnitDoubt]:
    if largest_radius(vehicle) is None:
        return  # its size is not known
    share = _gyration_over_reach(vehicle)
    likely = [u for u, s in _INERTIAS.items() if _within(share * math.sqrt(s), _GYRATION[1])]
    if likely and not _within(share, _GYRATION[0]):
        why = f"the radius of gyration is {share:.3g} times the reach of the hubs and propellers"
        yield UnitDoubt("inertia", None, why, _like("inertia", likely))


def _of_tilt(vehicle: Vehicle, said: str) -> Iterator[UnitDoubt]:
    """Question degrees in a file that look like rad, and rad in Python that look like degrees."""
    in_file = said == "Hz"
    ends = np.maximum(np.abs(vehicle.servo_angle_min), np.abs(vehicle.servo_angle_max))
    for servo, end in enumerate(ends.tolist()):
        as_other = math.degrees(end) if in_file else math.radians(end)
        odd = 0.0 < end < _TILT[0][0] if in_file else end > _TILT[0][1]
        moves = vehicle.servo_angle_min[servo] < vehicle.servo_angle_max[servo]
        if odd and moves and _within(as_other, _TILT[1]):
            most = vehicle.servo_angle_max[servo] >= end
            attribute = "servo_angle_max" if most else "servo_angle_min"
            why = f"the servo turns by {math.degrees(end):.4g}° at most"
            unit = "rad" if in_file else "degrees"
            yield UnitDoubt(attribute, servo, why, _like(attribute, [unit]))
            return


def question_units(
    doubts: Iterable[UnitDoubt],
    place: Callable[[str, int | None], tuple[str, Any]],
    name: Callable[[str], str],
) -> None:
    """Warn of numbers that are in doubt, in one sentence each.

    `place` returns where an attribute, of a rotor or servo, stands and what is written there;
    `name` what an attribute is called in the sentence.
    """
    for doubt in doubts:
        where, value = place(doubt.attribute, doubt.number)
        likely = _likeness(doubt, name) or "check its unit"
        sentence = f"{where} is {shown(value)}: {doubt.why}; {likely}."
        warnings.warn(legible(sentence, _LONGEST), UnlikelyUnitWarning, stacklevel=4)


def _likeness(doubt: UnitDoubt, name: Callable[[str], str]) -> str:
    """Return what the number looks like, and others with it; one way or another."""
    ways = doubt.explanations
    if all(len(way) == 1 and way[0][0] == doubt.attribute for way in ways):
        likeness = " or ".join(likeness for ((_, likeness),) in ways)
        return f"it looks {likeness}" if likeness else ""
    return ", or ".join(_explained(doubt.attribute, way, name) for way in ways)


def _explained(attribute: str, way: Explanation, name: Callable[[str], str]) -> str:
    (first, likeness), *others = way
    parts = [f"{'it' if first == attribute else name(first)} looks {likeness}"]
    parts += [f"{name(other)} {likeness}" for other, likeness in others]
    return " and ".join(filter(None, [", ".join(parts[:-1]), parts[-1]]))


def _lift(vehicle: Vehicle) -> float:
    return float(vehicle.thrust_max.sum()) / (_GRAVITY * vehicle.mass)


def _gyration_over_reach(vehicle: Vehicle) -> float:
    """Return the largest radius of gyration over how far hubs and propellers reach."""
    hubs = vehicle.rotor_position
    reach = float(np.linalg.norm(hubs, axis=1).max()) + (largest_radius(vehicle) or 0.1)
    return math.sqrt(float(np.linalg.eigvalsh(vehicle.inertia).max()) / vehicle.mass) / reach


def _like(attribute: str, units: Sequence[str]) -> tuple[Explanation, ...]:
    return tuple(((attribute, f"like {unit}"),) for unit in units)


def _within(number: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= number <= limits[1]
