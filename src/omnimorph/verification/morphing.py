"""What tilting gives and costs: singular tilts, least power, wakes, and when a mechanism pays."""

from __future__ import annotations

import numpy as np

from omnimorph.analysis import (
    actuation,
    break_even_tilt,
    hover,
    hover_in_wakes,
    mass_break_even,
    mass_break_even_of,
    mechanism_share,
    singular_tilts,
    solved_mass_break_even,
    sphere_directions,
)
from omnimorph.analysis.effort import least_effort
from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.dynamics import GRAVITY
from omnimorph.model.interference import WAKE_MODELS, stacked_pairs, thrust_lost
from omnimorph.protocols import FloatArray
from omnimorph.verification.case import Result, case, largest
from omnimorph.verification.setting import omnimorph, spin_axes

_PAPER = "Aboudorra et al. 2024"
_HALF_EDGE = 0.1062  # m


# --- singular tilts ---------------------------------------------------------------------------


def _singular_misses(expected: dict[float, int], found: dict[float, int]) -> float:
    """Return by how many degrees tilts differ; inf if their number or a rank does."""
    if list(expected.values()) != list(found.values()):
        return np.inf
    return largest(np.array(list(expected)) - np.array(list(found)))


@case(f"{_PAPER}, Sec. 2.3")
def singular_tilts_of_omnimorph() -> Result:
    """Over the whole turn A(α) loses rank at 0° and 180° (rank 4) and at ±90° (rank 5) only."""
    found = singular_tilts(omnimorph(), beyond_limits=True)
    expected = {-90.0: 5, 0.0: 4, 90.0: 5, 180.0: 4}
    misses = _singular_misses(expected, {np.degrees(one.tilt): one.rank for one in found})
    return Result(value=misses, tolerance=1e-7, unit="deg")


@case("closed form atan(κ / l) = 7.92°")
def singular_tilts_of_other_spins() -> Result:
    """With one sense of spin a layer, the search finds 7.92° too, with rank 5."""
    layered = omnimorph().replace(rotor_spin=np.array([1.0] * 4 + [-1.0] * 4))
    tilt = float(np.degrees(np.arctan(omnimorph().kappa[0] / _HALF_EDGE)))
    found = {np.degrees(one.tilt): one.rank for one in singular_tilts(layered)}
    misses = _singular_misses({0.0: 4, tilt: 5}, found)
    return Result(value=misses, tolerance=1e-7, unit="deg")


@case("closed forms Σ f h ≠ 0 at 0°, h where a rotor leans to, and Σ f ≠ 0 at 90°")
def when_tilting_adds_a_direction() -> Result:
    """The conditions on thrusts under which tilting adds a direction are these and no others."""
    leaning = spin_axes(omnimorph(), np.array([0.5 * np.pi])).T[:2]
    errors = []
    for tilt, expected in ((0.0, leaning), (0.5 * np.pi, np.ones((1, 8)))):
        found = actuation(omnimorph(), tilt, beyond_limits=True).conditions[0]
        # the same row space: projections onto it are equal
        errors.append(largest(_projection(found) - _projection(expected)))
    return Result(value=max(errors), tolerance=1e-9)


def _projection(rows: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.pinv(rows) @ rows)


# --- least power ------------------------------------------------------------------------------


@case("Karush, Kuhn and Tucker's conditions, which suffice for a convex problem")
def hover_power_is_the_least() -> Result:
    """In 60 attitudes at 4 tilts no thrusts hover with less power than those that are found."""
    vehicle, up = omnimorph(), sphere_directions(60)
    low, high = vehicle.thrust_min, vehicle.thrust_max
    weights = vehicle.mass * GRAVITY * np.hstack([up, np.zeros_like(up)])
    errors, at_limits = [], 0
    for tilt in np.radians([20.0, 45.0, 54.7356, 60.0]):
        A = allocation_matrix(vehicle, tilt)
        found = least_effort(vehicle, np.array([tilt]), weights, "power")
        f, price = found.thrust[found.feasible], found.multiplier[found.feasible] @ A
        c_tau, c_f = vehicle.drag_coefficient, vehicle.thrust_coefficient
        slope = 1.5 * c_tau * np.sign(f) * np.sqrt(np.abs(f)) / c_f**1.5
        # beyond a limit the next newton may cost less than it is worth, and cannot be had
        surplus = (slope - price) / np.abs(slope).max()
        surplus = np.where(f >= high, np.maximum(surplus, 0.0), surplus)
        surplus = np.where(f <= low, np.minimum(surplus, 0.0), surplus)
        errors += [largest(surplus), largest(np.maximum(f - high, low - f).clip(min=0.0))]
        errors.append(largest(f @ A.T - weights[found.feasible]) / largest(weights))
        at_limits += int(((f <= low) | (f >= high)).sum())
    return Result(value=max(errors) if at_limits else np.inf, tolerance=1e-9)


# --- wakes ------------------------------------------------------------------------------------


def _lower_loses(tilt_deg: float, *, partner: float = 1.0, blade: bool) -> float:
    """Return the share that a lower rotor loses below a partner of a relative speed, per cent."""
    thrust = np.array([2.684 * partner**2] * 4 + [2.684] * 4)
    model = WAKE_MODELS[int(blade)]
    return 100.0 * float(thrust_lost(omnimorph(), np.radians(tilt_deg), thrust, model)[4])


@case(f"{_PAPER}, the section on mutual interference: 33 % at 0°, 7 % at 50°")
def wakes_cost_what_was_measured() -> Result:
    """A lower rotor loses 33 % of its thrust untilted and 7 % at 50°, in both models."""
    errors = [
        _lower_loses(degrees, blade=blade) - percent
        for degrees, percent in ((0.0, 33.0), (50.0, 7.0))
        for blade in (False, True)
    ]
    return Result(value=largest(errors), tolerance=0.5, unit="%")


@case("blade-element and momentum theory: −40, −33 and −7 %")
def wakes_by_theory() -> Result:
    """Wake weights of 1, 0.857 and 0.208 cost 40, 33 and 7 % in the blade-element model."""
    errors = [
        _lower_loses(0.0, partner=weight / 0.857, blade=True) - percent
        for weight, percent in ((1.0, 40.0), (0.857, 33.0), (0.208, 7.0))
    ]
    return Result(value=largest(errors), tolerance=0.5, unit="%")


@case("momentum theory x (x − κ) = y, blade-element theory y = 1 − β (x − 1), β = 0.948")
def wakes_obey_both_theories() -> Result:
    """Inflow and thrust in a wake satisfy both equations, at wake weights up to 1.5."""
    errors = []
    for weight in np.linspace(0.0, 1.5, 16).tolist():
        thrust = 1.0 - 0.01 * _lower_loses(0.0, partner=weight / 0.857, blade=True)
        inflow = 1.0 + (1.0 - thrust) / 0.948
        errors.append(inflow * (inflow - weight) - thrust)
    return Result(value=largest(errors), tolerance=1e-12)


@case("closed form (2 / (2 − 0.333))^1.5, the 1.2^1.5 of a third lost, to three digits")
def hover_power_in_wakes() -> Result:
    """Untilted, in their wakes, the rotors need 1.314 times the power of still air."""
    ratio = hover_in_wakes(omnimorph(), 0.0).power / hover(omnimorph(), 0.0).power
    return Result(value=ratio, expected=(2.0 / (2.0 - 0.333)) ** 1.5, tolerance=1e-9)


@case("forces and moments of each rotor, summed from hubs and axes")
def hover_in_wakes_holds_the_weight() -> Result:
    """What is left in the wakes holds the weight without a moment, at 7 tilts, in both models."""
    vehicle, errors = omnimorph(), []
    weight = vehicle.mass * GRAVITY
    for model in WAKE_MODELS:
        for tilt in np.radians(np.arange(0.0, 61.0, 10.0)).tolist():
            point = hover_in_wakes(vehicle, tilt, model=model)
            axes = spin_axes(vehicle, np.array([tilt]))
            left = point.thrust * (1.0 - thrust_lost(vehicle, tilt, point.thrust, model))
            drag = vehicle.rotor_spin * vehicle.drag_coefficient * point.speed * abs(point.speed)
            moment = np.cross(vehicle.rotor_position, axes).T @ left - drag @ axes
            force = left @ axes - np.array([0.0, 0.0, weight])
            errors += [largest(force) / weight, largest(moment) / (weight * _HALF_EDGE)]
    return Result(value=max(errors), tolerance=1e-6)


@case("closed form 4 l sin α Δf")
def wakes_make_a_yaw_moment() -> Result:
    """As lower rotors alone lose thrust Δf, equal thrusts yaw the vehicle by 4 l sin α Δf."""
    vehicle, thrust, errors = omnimorph(), np.full(8, 2.0), []
    for tilt in np.linspace(0.0, 1.0, 11).tolist():
        lost = thrust * thrust_lost(vehicle, tilt, thrust)
        axes = spin_axes(vehicle, np.array([tilt]))
        moment = -(lost @ np.cross(vehicle.rotor_position, axes))
        _, below = stacked_pairs(vehicle).T
        expected = 4.0 * _HALF_EDGE * np.sin(tilt) * lost[below[0]]
        errors.append(largest(moment - [0.0, 0.0, expected]))
    return Result(value=max(errors), tolerance=1e-14, unit="N m")


# --- whether it pays --------------------------------------------------------------------------


@case("closed form 1 / cos α_f − 1")
def mass_that_just_pays() -> Result:
    """A mechanism pays up to 6.42 % of the mass against 20° of fixed tilt, 15.47 % against 30°."""
    errors = 100.0 * mass_break_even(np.radians([20.0, 30.0])) - np.array([6.42, 15.47])
    return Result(value=largest(errors), tolerance=5e-3, unit="%")


@case("closed form 1 / cos α_f − 1")
def mass_that_just_pays_where_omnidirectional() -> Result:
    """Against 37°, from where on every attitude can hover, it pays up to 25.2 %."""
    percent = 100.0 * mass_break_even(np.radians(37.0))
    return Result(value=float(percent), expected=25.2, tolerance=0.05, unit="%")


@case("closed form 1 / cos α_f − 1")
def mass_that_just_pays_from_hover_powers() -> Result:
    """Ratios of hover power give it too, and so does the paper's implicit equation, solved."""
    tilts = np.radians(np.linspace(0.0, 70.0, 8))
    solved = [solved_mass_break_even(omnimorph(), tilt) for tilt in tilts.tolist()]
    both = np.vstack([mass_break_even_of(omnimorph(), tilts), solved])
    errors = both - mass_break_even(tilts)
    return Result(value=largest(errors), tolerance=1e-10)


@case("closed form acos(1.128 / 1.315), from the two masses")
def tilt_from_which_its_mechanism_pays() -> Result:
    """OmniMorph's own mechanism, 16.58 % of the rest, pays against fixed tilts beyond 30.93°."""
    share = mechanism_share(omnimorph()) or 0.0
    tilt = break_even_tilt(omnimorph(), share)
    known = tilt is not None and round(100.0 * share, 2) == 16.58
    degrees = np.degrees(tilt or 0.0) if known else np.inf
    return Result(value=degrees, expected=30.93, tolerance=5e-3, unit="deg")
