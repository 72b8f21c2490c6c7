"""The forces that the rotors can make: radii, reach, volume, and the tilts at which they suffice.

OmniMorph's force set with free moments has closed forms; that at zero moment is checked against
two other ways to find it, all its corners one by one and linear programmes.
"""

from __future__ import annotations

from functools import cache
from itertools import combinations, product

import numpy as np

from omnimorph.analysis import (
    force_set,
    hover,
    inscribed_radius,
    level_hover_range,
    moment_set,
    omnidirectional_range,
    sphere_directions,
    tilt_of_largest_radius,
    wrench_set,
)
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray
from omnimorph.verification.case import Result, case, largest
from omnimorph.verification.hovering import attitudes, can_hover
from omnimorph.verification.setting import omnimorph, spin_axes

_CORNERS = (
    "all corners of the box of thrusts cut by zero moment, one by one, and their forces' hull"
)
_PROGRAMMES = "linear programmes over the thrusts"
_SIDE, _UP = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])

# Tilt in degrees: inscribed radius at zero moment over the largest thrust of a rotor.
_ZERO_MOMENT = {
    20.0: 1.3439,
    30.0: 1.9537,
    37.0: 2.3446,
    45.0: 2.7478,
    float(np.degrees(np.arctan(np.sqrt(2.0)))): 3.1543,
    60.0: 3.0041,
    70.0: 2.3846,
}


@cache
def _wide() -> Vehicle:
    """Return OmniMorph with a servo that turns on to 90°."""
    return omnimorph().replace(servo_angle_max=np.array([0.5 * np.pi]))


def _largest_thrust() -> float:
    return float(omnimorph().thrust_max[0])


# --- radius and reach -------------------------------------------------------------------------


def _closed_form_radius(tilt: float) -> float:
    s, c = np.sin(tilt), np.cos(tilt)
    return _largest_thrust() * float(min(4.0 * s, 8.0 * s * c / np.sqrt(1.0 + c**2)))


@case("closed form min(4 sin α, 8 sin α cos α / √(1 + cos²α)) f_max")
def free_moment_radius_over_the_tilt() -> Result:
    """With free moments the inscribed radius is the closed form at 181 tilts from 0 to 90°."""
    errors = [
        inscribed_radius(_wide(), tilt, zero_moment=False) - _closed_form_radius(tilt)
        for tilt in np.linspace(0.0, 0.5 * np.pi, 181).tolist()
    ]
    return Result(value=largest(errors), tolerance=1e-12, unit="N")


@case("closed form atan √2, where both branches of the radius meet")
def tilt_of_the_largest_free_moment_radius() -> Result:
    """The radius with free moments is largest at 54.7356°."""
    tilt = tilt_of_largest_radius(_wide(), zero_moment=False)
    return Result(value=np.degrees(tilt), expected=54.7356, tolerance=5e-5, unit="deg")


@case("closed form 4 √(2/3)")
def largest_free_moment_radius() -> Result:
    """There it is 3.2660 times the largest thrust of a rotor."""
    tilt = tilt_of_largest_radius(_wide(), zero_moment=False)
    ratio = inscribed_radius(_wide(), tilt, zero_moment=False) / _largest_thrust()
    return Result(value=ratio, expected=3.2660, tolerance=5e-5, unit="f_max")


@case(_CORNERS)
def zero_moment_radius_at_seven_tilts() -> Result:
    """At zero moment the radius is 1.3439 f_max at 20° of tilt, 3.1543 at 54.7356°, 2.3846 at 70°.

    And so on, to the four digits of the table above.
    """
    errors = [
        inscribed_radius(_wide(), np.radians(degrees), zero_moment=True) / _largest_thrust() - ratio
        for degrees, ratio in _ZERO_MOMENT.items()
    ]
    return Result(value=largest(errors), tolerance=5e-5, unit="f_max")


def _forces_of_corners(tilt: float) -> FloatArray:
    """Return the forces of all corners of { f : T f = 0, |f| ≤ f_max }, with repetitions.

    At a corner all thrusts but three are at a limit, and those three cancel the moment.
    """
    A, limit = allocation_matrix(omnimorph(), tilt), _largest_thrust()
    ends = limit * np.array(list(product([-1.0, 1.0], repeat=5)))
    forces = []
    for free in map(list, combinations(range(8), 3)):
        held = np.setdiff1d(np.arange(8), free)
        arms = A[3:, free]
        if abs(np.linalg.det(arms)) > 1e-9 * np.linalg.norm(arms) ** 3:
            thrust = np.empty((len(ends), 8))
            thrust[:, held] = ends
            thrust[:, free] = -np.linalg.solve(arms, A[3:, held] @ ends.T).T
            within = (np.abs(thrust) <= limit * (1.0 + 1e-12)).all(axis=1)
            forces.append(thrust[within] @ A[:3].T)
    return np.vstack(forces)


@case(_CORNERS)
def zero_moment_force_set_is_that_of_its_corners() -> Result:
    """At these tilts the radius and the volume at zero moment are those of the corners' hull."""
    from scipy.spatial import ConvexHull

    errors = []
    for degrees in _ZERO_MOMENT:
        tilt = float(np.radians(degrees))
        hull = ConvexHull(_forces_of_corners(tilt))
        forces = force_set(_wide(), tilt, zero_moment=True)
        errors.append(forces.inscribed_radius / -hull.equations[:, 3].max() - 1.0)
        errors.append(forces.volume / hull.volume - 1.0)
    return Result(value=largest(errors), tolerance=1e-11)


@case("closed form 8 f_max cos α, with all thrusts equal, which make no moment")
def largest_force_straight_up() -> Result:
    """Straight up the rotors give 8 f_max cos α, with free moments and at zero moment."""
    errors = []
    for tilt in np.linspace(0.0, 0.5 * np.pi, 19).tolist():
        lift = 8.0 * _largest_thrust() * np.cos(tilt)
        for zero_moment in (False, True):
            errors.append(force_set(_wide(), tilt, zero_moment=zero_moment).reach(_UP) - lift)
    return Result(value=largest(errors), tolerance=1e-11, unit="N")


@case("P. McMullen's formula 2³ Σ |det(g_i, g_j, g_k)| over all triples of generators")
def free_moment_volume() -> Result:
    """The volume of the force set with free moments is the sum of its triples' parallelepipeds."""
    errors = []
    for tilt in np.linspace(0.1, 1.5, 8).tolist():
        axes = _largest_thrust() * spin_axes(_wide(), np.array([tilt]))
        triples = axes[np.array(list(combinations(range(8), 3)))]
        expected = 8.0 * np.abs(np.linalg.det(triples)).sum()
        errors.append(force_set(_wide(), tilt, zero_moment=False).volume / expected - 1.0)
    return Result(value=largest(errors), tolerance=1e-12)


# --- where it can hover -----------------------------------------------------------------------


def _misses(found: FloatArray, *expected: float) -> float:
    """Return by how many degrees the ends of one interval differ from those expected."""
    if found.shape != (1, 2):
        return np.inf
    return largest(np.degrees(found[0]) - expected)


@case("roots of the closed form of the radius")
def omnidirectional_with_free_moments() -> Result:
    """With free moments the weight can be held in every direction from 37.00° to 70.28°."""
    found = omnidirectional_range(_wide(), zero_moment=False)
    return Result(value=_misses(found, 37.00, 70.28), tolerance=5e-3, unit="deg")


@case(_CORNERS)
def omnidirectional_at_zero_moment() -> Result:
    """At zero moment, which hovering needs, OmniMorph is omnidirectional from 38.18° to 69.73°."""
    found = omnidirectional_range(_wide(), zero_moment=True)
    return Result(value=_misses(found, 38.18, 69.73), tolerance=5e-3, unit="deg")


@case("closed form acos(m g / (8 f_max))")
def level_hover_is_lost() -> Result:
    """Level hover is lost beyond 72.49°."""
    return Result(value=_misses(level_hover_range(_wide()), 0.0, 72.49), tolerance=5e-3, unit="deg")


@case("the limit that puts the paper's 37° at zero moment; 37, 70.5 and 73.0° to its digits")
def another_limit_gives_the_same_onset() -> Result:
    """With 5.502 N a rotor it is omnidirectional from 37 to 70.5° and hovers level up to 73.0°."""
    more = np.sqrt(5.502 / _largest_thrust())
    vehicle = _wide().replace(
        speed_min=more * _wide().speed_min, speed_max=more * _wide().speed_max
    )
    every = _misses(omnidirectional_range(vehicle, zero_moment=True), 37.0, 70.5)
    level = _misses(level_hover_range(vehicle), 0.0, 73.0)
    return Result(value=max(every, level), tolerance=0.05, unit="deg")


# --- weak rotors ------------------------------------------------------------------------------


def _sideways(share: float, *, zero_moment: bool, drag_share: float = 1.0) -> float:
    """Return the largest force along y at 60°, N, of rotors that give a share of their thrust."""
    vehicle = omnimorph()
    weak = vehicle.replace(
        thrust_coefficient=share * vehicle.thrust_coefficient,
        drag_coefficient=drag_share * vehicle.drag_coefficient,
    )
    return force_set(weak, np.pi / 3, zero_moment=zero_moment).reach(_SIDE)


def _forces_left(weaker: float, weak: float, *, zero_moment: bool, less_drag: bool) -> Result:
    """Compare with the forces, N, that 65 and 70 % of the thrust give."""
    errors = [
        _sideways(share, zero_moment=zero_moment, drag_share=share if less_drag else 1.0) - force
        for share, force in ((0.65, weaker), (0.7, weak))
    ]
    return Result(value=largest(errors), tolerance=5e-3, unit="N")


@case("closed form: 2 √3 of what a rotor gives")
def weak_rotors_push_sideways() -> Result:
    """With 35 and 30 % of thrust lost, 12.07 and 12.99 N are left sideways at 60°, moments free."""
    return _forces_left(12.07, 12.99, zero_moment=False, less_drag=False)


@case("a share of the exact force of sound rotors")
def weak_rotors_push_sideways_without_a_moment() -> Result:
    """At zero moment 11.73 and 12.63 N are left if the drag of the rotors falls as well."""
    return _forces_left(11.73, 12.63, zero_moment=True, less_drag=True)


@case("the linear programmes of the next case")
def weak_rotors_with_all_their_drag() -> Result:
    """If it does not, drag takes more of the moments, and 11.56 and 12.49 N are left."""
    return _forces_left(11.56, 12.49, zero_moment=True, less_drag=False)


@case(_PROGRAMMES)
def weak_rotors_by_linear_programmes() -> Result:
    """That is what linear programmes find, over thrusts from which a share is taken."""
    from scipy.optimize import linprog

    vehicle, limit, errors = omnimorph(), _largest_thrust(), []
    A = allocation_matrix(vehicle, np.pi / 3)
    of_thrust = A.copy()
    of_thrust[3:] += vehicle.rotor_spin * vehicle.kappa * A[:3]  # without the drag torques
    for share in (0.65, 0.7):
        left = A - (1.0 - share) * of_thrust
        others = left[[0, 2, 3, 4, 5]]  # neither x, nor z, nor a moment
        answer = linprog(-left[1], A_eq=others, b_eq=np.zeros(5), bounds=(-limit, limit))
        errors.append(_sideways(share, zero_moment=True) + answer.fun)
    return Result(value=largest(errors), tolerance=1e-9, unit="N")


# --- support and membership -------------------------------------------------------------------


@case(_PROGRAMMES)
def support_functions() -> Result:
    """Support functions of force sets and of moments in hover are what linear programmes find."""
    from scipy.optimize import linprog

    limit, weight = _largest_thrust(), omnimorph().mass * GRAVITY * _UP
    errors = []
    for tilt in (0.3, 0.9):
        A = allocation_matrix(omnimorph(), tilt)
        lifted, free = {"A_eq": A[:3], "b_eq": weight}, wrench_set(omnimorph(), tilt)
        sets = [
            (force_set(omnimorph(), tilt, zero_moment=False), A[:3], {}),
            (
                force_set(omnimorph(), tilt, zero_moment=True),
                A[:3],
                {"A_eq": A[3:], "b_eq": np.zeros(3)},
            ),
            (moment_set(omnimorph(), tilt, force=weight), A[3:], lifted),
        ]
        for direction in sphere_directions(8):
            for found, rows, equations in sets:
                answer = linprog(-direction @ rows, bounds=(-limit, limit), **equations)
                errors.append(found.support(direction) + answer.fun)
            both = np.concatenate([direction, 3.0 * direction])
            answer = linprog(-both @ A, bounds=(-limit, limit))
            errors.append(free.support(both) + answer.fun)
    return Result(value=largest(errors), tolerance=1e-9, unit="N, N m")


@case(_PROGRAMMES)
def reach_along_any_direction() -> Result:
    """The largest force along each of 20 directions is what linear programmes find."""
    from scipy.optimize import linprog

    limit, tilt, errors = _largest_thrust(), np.pi / 3, []
    A = allocation_matrix(omnimorph(), tilt)
    forces = [force_set(omnimorph(), tilt, zero_moment=zero) for zero in (False, True)]
    bounds = [(-limit, limit)] * 8 + [(0.0, None)]
    for direction in sphere_directions(20):
        # thrusts and the size of the force, t: Z f = t d, and T f = 0 if asked
        equations = np.column_stack([A, np.concatenate([-direction, np.zeros(3)])])
        for found, rows in zip(forces, (3, 6), strict=True):
            answer = linprog(
                -np.eye(9)[8], A_eq=equations[:rows], b_eq=np.zeros(rows), bounds=bounds
            )
            errors.append(found.reach(direction) + answer.fun)
    return Result(value=largest(errors), tolerance=1e-9, unit="N")


@case("a linear programme for each attitude")
def three_ways_to_tell_what_hovers() -> Result:
    """In 40 attitudes at 30° membership and least power agree with a linear programme: none not."""
    weight, tilt = omnimorph().mass * GRAVITY, np.pi / 6
    forces, wrong, held = force_set(omnimorph(), tilt, zero_moment=True), 0, 0
    for R_WB in attitudes(40, seed=9):
        expected = can_hover(tilt, R_WB)
        held += expected
        wrong += forces.contains(weight * R_WB[2]) != expected
        wrong += hover(omnimorph(), tilt, R_WB).feasible != expected
    # a check that only ever saw one answer would say nothing
    return Result(value=wrong if 0 < held < 40 else np.inf, tolerance=0.0, unit="answers")
