"""Platforms in a few numbers: closed forms, and forces over free tilts against grids of tilts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star, build_tilting_star, build_vehicle

import omnimorph as om
from omnimorph.analysis import force_set
from omnimorph.analysis.actuation import ActuationKind, ThrustKind
from omnimorph.analysis.free_tilt import reach_over_tilts
from omnimorph.analysis.hover import sphere_directions
from omnimorph.analysis.platform import lateral_reach, platform
from omnimorph.model.dynamics import GRAVITY

OMNIMORPH = om.load_vehicle("omnimorph")
F_MAX = 1e-5 * 600.0**2  # N, of the small vehicles
AXES = np.vstack([np.eye(3), -np.eye(3)])


@pytest.mark.parametrize("degrees", [10.0, 20.0, 35.0, 50.0])
def test_the_lateral_reach_is_the_largest_that_fits_on_all_sides(degrees: float) -> None:
    tilt = math.radians(degrees)
    forces = force_set(OMNIMORPH, tilt, zero_moment=True)
    r, weight = lateral_reach(OMNIMORPH, tilt), OMNIMORPH.mass * GRAVITY
    turn = np.linspace(0.0, 2.0 * math.pi, 721)
    around = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(721)])
    margins = [forces.margin(r * u + [0.0, 0.0, weight]) for u in around]
    assert min(margins) == pytest.approx(0.0, abs=2e-4 * r)


def test_a_tilting_quadrotor_pushes_with_those_that_can() -> None:
    """About their arms two of four rotors turn towards x, two towards y, all upwards.

    With next to no drag, whose moment about x the other two would have to hold.
    """
    whole = {"servo_angle_min": -math.pi, "servo_angle_max": math.pi}
    tilting = build_tilting_star(4, drag_coefficient=1e-12, **whole)
    reach = reach_over_tilts(tilting, AXES)
    assert reach == pytest.approx(F_MAX * np.array([2.0, 2.0, 4.0, 2.0, 2.0, 4.0]), rel=2e-3)


def test_without_servos_it_is_the_exact_set() -> None:
    canted = build_star(6, cant=0.4)
    directions = sphere_directions(40)
    expected = [force_set(canted, 0.0, zero_moment=True).reach(d) for d in directions]
    assert reach_over_tilts(canted, directions) == pytest.approx(expected, abs=1e-7)


def test_two_servos_against_a_grid_of_tilts() -> None:
    """Four fixed rotors, and two that tilt about their arms: the best of 37 x 37 pairs of tilts."""
    angle = np.radians([0.0, 90.0, 180.0, 270.0, 45.0, 225.0])
    arm = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(6)])
    hinge = np.where(np.arange(6)[:, None] < 4, 0.0, arm)
    vehicle = build_vehicle(
        0.2 * arm,
        rotor_spin=[1, -1, 1, -1, 1, -1],
        hinge_axis=hinge,
        rotor_servo=[-1, -1, -1, -1, 0, 1],
        servos=2,
        speed_min=0.0,
        servo_angle_min=-1.5,
        servo_angle_max=1.5,
    )
    directions = sphere_directions(12)
    grid = np.linspace(-1.5, 1.5, 37)
    sets = [force_set(vehicle, [a, b], zero_moment=True) for a in grid for b in grid]
    best = np.array([max(one.reach(d) for one in sets) for d in directions])
    found = reach_over_tilts(vehicle, directions)
    # each is a sample of the same: they may miss by how far their points are apart
    assert found == pytest.approx(best, rel=0.02, abs=0.02 * F_MAX)


def test_what_cannot_be_made_beside_reaches_nowhere() -> None:
    tilting = build_tilting_star(4, servo_angle_min=-1.0, servo_angle_max=1.0)
    too_much = np.array([0.0, 0.0, 4.1 * F_MAX])
    assert reach_over_tilts(tilting, AXES, too_much).tolist() == [0.0] * 6


def test_classes_and_numbers() -> None:
    flat, canted = platform(build_star(4)), platform(build_star(6, cant=math.radians(20.0)))
    assert (flat.kind, flat.thrust_kind) == (
        ActuationKind.UNDER_ACTUATED,
        ThrustKind.UNI_DIRECTIONAL,
    )
    assert (flat.radius_over_weight, flat.lateral_over_weight) == (0.0, 0.0)
    assert canted.kind is ActuationKind.FULLY_ACTUATED
    assert canted.thrust_kind is ThrustKind.MULTI_DIRECTIONAL
    assert 0.0 < canted.lateral_over_weight < 1.0
    found = platform(OMNIMORPH)
    assert found.kind is ActuationKind.REDUNDANT
    assert found.thrust_kind is ThrustKind.OMNIDIRECTIONAL
    assert found.radius_over_weight == pytest.approx(16.92 / 12.90, abs=2e-3)
    assert found.hover_power_per_kg == pytest.approx(111.40 / 1.315, abs=5e-3)


def test_a_tilting_hexarotor_is_omnidirectional_by_its_servos() -> None:
    """Along x it pushes with |sin| of each arm's angle: Σ |sin φ_i| f_max = 3.464 f_max."""
    tilting = build_tilting_star(6, servo_angle_min=-math.pi, servo_angle_max=math.pi)
    found = platform(tilting)
    assert found.thrust_kind is ThrustKind.OMNIDIRECTIONAL
    x = reach_over_tilts(tilting, np.eye(3)[:1])[0]
    assert x == pytest.approx(4 * math.sin(math.pi / 3) * F_MAX, rel=2e-3)
    assert found.radius_over_weight * tilting.mass * GRAVITY <= x * 1.001


def test_a_vehicle_too_heavy_to_hover_is_said_to_be() -> None:
    found = platform(build_star(4, mass=4.0))
    assert math.isinf(found.hover_power)
    assert found.lateral_over_weight == 0.0


def test_servos_without_a_tilt_in_common_have_a_class_all_the_same() -> None:
    """The hover power is asked at a common tilt only, so there is none."""
    apart = {"servo_angle_min": [0.1, -0.5] * 2, "servo_angle_max": [0.5, -0.1] * 2}
    found = platform(build_tilting_star(4, **apart))
    assert math.isinf(found.hover_power)
    assert found.thrust_kind is ThrustKind.MULTI_DIRECTIONAL
