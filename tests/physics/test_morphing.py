"""Whether a tilt mechanism pays, and what it costs to hover in one's own wakes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from tests.physics.small_vehicles import (
    build_star,
    build_tilting_star,
    build_vehicle,
    frozen,
)

from omnimorph.analysis import (
    break_even_tilt,
    force_set,
    hover,
    hover_in_wakes,
    mass_break_even,
    mass_break_even_of,
    mechanism_share,
    solved_mass_break_even,
    vehicle_in_wakes,
)
from omnimorph.analysis.hover import HoverPoint
from omnimorph.design import Vehicle, load_vehicle
from omnimorph.errors import InputError, VehicleError
from omnimorph.model.interference import WAKE_MODELS, WakeModel, stacked_pairs, thrust_lost
from omnimorph.protocols import FloatArray

OMNIMORPH = load_vehicle("omnimorph")
LATER = load_vehicle("omnimorph-2026")

each_model = pytest.mark.parametrize("model", WAKE_MODELS)


# --- the mass that just pays -------------------------------------------------------------------


@pytest.mark.parametrize(("degrees", "percent"), [(20.0, 6.42), (30.0, 15.47), (37.0, 25.2)])
def test_mass_break_even(degrees: float, percent: float) -> None:
    tilt = math.radians(degrees)
    assert 100.0 * mass_break_even(tilt) == pytest.approx(percent, abs=0.03)
    assert mass_break_even(tilt) == 1.0 / math.cos(tilt) - 1.0
    assert isinstance(mass_break_even(tilt), float)


def test_closed_form_ratio_and_solved_equation_agree() -> None:
    tilts = np.radians([-30.0, 0.0, 1.0, 20.0, 37.0, 54.7356, 72.0])
    closed = mass_break_even(tilts)
    for vehicle in (OMNIMORPH, LATER, OMNIMORPH.replace(mass=0.7)):
        np.testing.assert_allclose(mass_break_even_of(vehicle, tilts), closed, atol=1e-11)
        solved = [solved_mass_break_even(vehicle, tilt) for tilt in tilts.tolist()]
        np.testing.assert_allclose(solved, closed, atol=1e-11)


def test_both_spend_the_same_power() -> None:
    """P(0, m0 (1 + Δ)) = P(α_f, m0), each as the least power within limits."""
    bare = OMNIMORPH.replace(mass=1.128, tilt_mechanism_mass=0.0)
    tilt = math.radians(30.0)
    heavier = bare.replace(mass=1.128 * (1.0 + float(mass_break_even(tilt))))
    assert hover(heavier, 0.0).power == pytest.approx(hover(bare, tilt).power, rel=1e-10)


def test_its_own_mechanism() -> None:
    """0.187 kg on 1.128 kg is 16.58 %: it does not pay against 30°, against 37° it does."""
    own = mechanism_share(OMNIMORPH)
    assert own is not None
    assert 100.0 * own == pytest.approx(16.58, abs=5e-3)
    assert mass_break_even(math.radians(30.0)) < own < mass_break_even(math.radians(37.0))
    tilt = break_even_tilt(OMNIMORPH, own)
    assert tilt == pytest.approx(math.acos(1.128 / 1.315), abs=1e-9)
    assert math.degrees(tilt or 0.0) == pytest.approx(30.93, abs=5e-3)
    assert mechanism_share(LATER) is None


def test_rotors_that_lean_when_untilted() -> None:
    """A star canted by 0.3 rad hovers best where its servos take the cant out: it pays nothing."""
    cant = 0.3
    star = build_star(4, cant=cant, rotor_spin=[1.0, -1.0, 1.0, -1.0])
    hinge = 5.0 * star.rotor_position * star.rotor_spin[:, None]
    tilting = build_star(
        4, cant=cant, servos=1, rotor_servo=[0] * 4, hinge_axis=hinge, servo_angle_min=-1.0
    )
    (share,) = mass_break_even_of(tilting, -cant)
    assert share == pytest.approx(math.cos(cant) - 1.0, abs=1e-12)  # negative: it needs less
    assert break_even_tilt(tilting, 0.0) == pytest.approx(0.0, abs=1e-9)


def test_where_there_is_nothing_to_compare() -> None:
    lying = build_vehicle([[0.2, 0.0, 0.0]] * 2, axis=[[1.0, 0.0, 0.0]] * 2)
    with pytest.raises(VehicleError, match="it cannot hover level untilted"):
        mass_break_even_of(lying, 0.2)
    assert break_even_tilt(lying, 0.1) is None
    with pytest.raises(VehicleError, match="it cannot hover level at both tilts"):
        solved_mass_break_even(OMNIMORPH, 0.5 * math.pi)
    assert math.isinf(mass_break_even_of(OMNIMORPH, 0.5 * math.pi)[0])
    assert break_even_tilt(build_star(4), 0.1) is None  # without servos nothing changes
    assert break_even_tilt(OMNIMORPH, 1e9) is None


@pytest.mark.parametrize("tilt", [0.5 * math.pi, -2.0, math.nan, [0.1, math.inf]])
def test_tilts_that_make_no_sense(tilt: ArrayLike) -> None:
    with pytest.raises(InputError, match=r"tilt_fixed is .* within ±π/2 rad"):
        mass_break_even(tilt)


# --- hovering in wakes -------------------------------------------------------------------------


def wrench_left(vehicle: Vehicle, point: HoverPoint, model: WakeModel) -> FloatArray:
    """Return force and moment of what thrust is left, drag going on with the speed: (6,)."""
    z0, zC, zS = vehicle.thrust_axis_parts
    angle = point.tilt[0] if vehicle.n_servos else 0.0
    z = z0 + zC * np.cos(angle) + zS * np.sin(angle)
    full = vehicle.thrust_coefficient * point.speed * np.abs(point.speed)
    left = full * (1.0 - thrust_lost(vehicle, point.tilt, full, model))
    drag = vehicle.drag_coefficient * point.speed * np.abs(point.speed) * vehicle.rotor_spin
    moment = (np.cross(vehicle.rotor_position, z) * left[:, None] - z * drag[:, None]).sum(axis=0)
    return np.concatenate([left @ z, moment])


def check_held(vehicle: Vehicle, point: HoverPoint, model: WakeModel) -> None:
    weight = vehicle.mass * 9.81
    assert point.feasible
    wrench = wrench_left(vehicle, point, model)
    np.testing.assert_allclose(wrench[:3], weight * point.up, atol=2e-7 * weight)
    np.testing.assert_allclose(wrench[3:], 0.0, atol=2e-8 * weight)
    assert (point.speed <= vehicle.speed_max * (1.0 + 1e-12)).all()
    assert (point.speed >= vehicle.speed_min * (1.0 + 1e-12)).all()
    power = np.abs(point.speed) ** 3 @ vehicle.drag_coefficient
    assert point.power == pytest.approx(power, rel=1e-12)


def test_untilted_in_closed_form() -> None:
    """Lower rotors lose 33.3 %, so all turn as for 2/(2 − 0.333) of the weight: 146.4 W."""
    point = hover_in_wakes(OMNIMORPH, 0.0)
    assert point.power == pytest.approx(146.4, abs=0.05)
    ratio = point.power / hover(OMNIMORPH, 0.0).power
    assert ratio == pytest.approx((2.0 / (2.0 - 0.333)) ** 1.5, rel=1e-9)
    assert ratio == pytest.approx(1.2**1.5, abs=5e-4)
    check_held(OMNIMORPH, point, "published")


@each_model
def test_wakes_cost_power_and_the_weight_is_held(model: WakeModel) -> None:
    """Level over the tilt, and in random attitudes; each upside-down twin costs the same."""
    generator = np.random.default_rng(5)
    for k, tilt in enumerate(np.radians([5.0, 30.0, 50.0, 60.0]).tolist()):
        R_WB = np.eye(3) if k < 2 else Rotation.random(random_state=generator).as_matrix()
        point = hover_in_wakes(OMNIMORPH, tilt, R_WB, model=model)
        check_held(OMNIMORPH, point, model)
        assert point.power >= hover(OMNIMORPH, tilt, R_WB).power * (1.0 - 1e-9)
    level = hover_in_wakes(OMNIMORPH, 0.5, model=model)
    over = hover_in_wakes(OMNIMORPH, 0.5, np.diag([1.0, -1.0, -1.0]), model=model)
    assert over.power == pytest.approx(level.power, rel=1e-6)


@each_model
def test_a_coaxial_pair(model: WakeModel) -> None:
    """Two rotors, one degree of freedom: equal drag, so equal speeds, and T (2 − loss) = m g."""
    pair = build_vehicle(
        [[0.0, 0.0, 0.1], [0.0, 0.0, -0.1]], rotor_spin=[1.0, -1.0], speed_min=0.0, mass=0.4
    )
    point = hover_in_wakes(pair, [], model=model)
    loss = thrust_lost(pair, [], [1.0, 1.0], model)
    assert loss[0] == 0.0
    np.testing.assert_allclose(point.thrust, 0.4 * 9.81 / (2.0 - loss[1]), rtol=1e-6)
    check_held(pair, point, model)


def test_too_heavy_for_its_wakes() -> None:
    """8 f_max in still air, (2 − 0.333)/2 of that in wakes; in between only the first hovers."""
    limit = 8.0 * 5.3587 / 9.81
    left = limit * (2.0 - 0.333) / 2.0
    for mass, still, wakes in ((0.999 * left, True, True), (1.001 * left, True, False)):
        vehicle = OMNIMORPH.replace(mass=mass)
        assert hover(vehicle, 0.0).feasible is still
        point = hover_in_wakes(vehicle, 0.0)
        assert point.feasible is wakes
        assert math.isfinite(point.power) is wakes
        assert np.any(point.thrust) == wakes
    sinking = hover_in_wakes(OMNIMORPH.replace(mass=1.01 * limit), 0.0)
    assert not sinking.feasible


def test_break_even_in_wakes() -> None:
    """Wakes cost most untilted, so that morphing pays later: beyond 40.44°."""
    share = mechanism_share(OMNIMORPH) or 0.0
    tilt = break_even_tilt(OMNIMORPH, share, wakes="published") or 0.0
    assert math.degrees(tilt) == pytest.approx(40.44, abs=5e-3)
    (there,) = mass_break_even_of(OMNIMORPH, tilt, wakes="published")
    assert there == pytest.approx(share, rel=1e-6)
    (at_30,) = mass_break_even_of(OMNIMORPH, math.radians(30.0), wakes="published")
    assert at_30 == pytest.approx(0.0651, abs=5e-5)


@each_model
def test_without_pairs_nothing_changes(model: WakeModel) -> None:
    star = build_tilting_star(4)
    assert len(stacked_pairs(star)) == 0
    still, there = hover(star, 0.0), hover_in_wakes(star, 0.0, model=model)
    np.testing.assert_array_equal(there.thrust, still.thrust)
    assert there.power == still.power
    derated = vehicle_in_wakes(star, 0.0, model=model)
    np.testing.assert_array_equal(derated.speed_max, star.speed_max)
    np.testing.assert_array_equal(derated.speed_min, star.speed_min)


def test_names_of_models() -> None:
    for vehicle in (OMNIMORPH, build_tilting_star(4)):
        with pytest.raises(VehicleError, match='model is "none", but it must be "published"'):
            hover_in_wakes(vehicle, 0.0, model="none")  # type: ignore[arg-type]
        with pytest.raises(VehicleError, match='model is "none", but it must be "published"'):
            vehicle_in_wakes(vehicle, 0.0, model="none")  # type: ignore[arg-type]
    with pytest.raises(VehicleError, match='model is "none"'):
        mass_break_even_of(OMNIMORPH, 0.2, wakes="none")  # type: ignore[arg-type]
    with pytest.raises(VehicleError, match="tilt is 75°"):
        vehicle_in_wakes(OMNIMORPH, math.radians(75.0))


# --- the limits that are left ------------------------------------------------------------------


def test_limits_left_in_wakes() -> None:
    """At 0° lower rotors keep 0.667 of 5.3587 N upwards, upper ones downwards."""
    left = vehicle_in_wakes(OMNIMORPH, 0.0)
    up, down = np.full(8, 5.3587), np.full(8, -5.3587)
    up[4:] *= 0.667
    down[:4] *= 0.667
    np.testing.assert_allclose(left.thrust_max, up, rtol=1e-12)
    np.testing.assert_allclose(left.thrust_min, down, rtol=1e-12)
    # a rotor that cannot reverse, or must turn, keeps its lower limit
    for least in (0.0, 100.0):
        pushing = OMNIMORPH.replace(speed_min=np.full(8, least))
        np.testing.assert_array_equal(vehicle_in_wakes(pushing, 0.0).speed_min, least)


@each_model
@pytest.mark.parametrize("degrees", [0.0, 25.0, 60.0])
def test_the_force_set_left_is_within_that_of_still_air(model: WakeModel, degrees: float) -> None:
    tilt = math.radians(degrees)
    left = vehicle_in_wakes(OMNIMORPH, tilt, model=model)
    for zero_moment in (False, True):
        inner, outer = (force_set(one, tilt, zero_moment=zero_moment) for one in (left, OMNIMORPH))
        assert all(outer.contains(vertex) for vertex in inner.vertices)
        assert inner.inscribed_radius <= outer.inscribed_radius
        assert inner.reach([0, 0, 1]) < outer.reach([0, 0, 1])


@each_model
def test_every_force_left_can_be_made(model: WakeModel) -> None:
    """Thrusts within the limits left, whatever they are: speeds are found that give them."""
    generator = np.random.default_rng(6)
    for tilt in (0.0, 0.4, 1.0):
        left = vehicle_in_wakes(OMNIMORPH, tilt, model=model)
        low, high = left.thrust_min, left.thrust_max
        for k in range(12):
            aim = generator.uniform(low, high)
            if k < 4:
                aim = np.where(generator.random(8) < 0.5, low, high)
            made = thrusts_before_loss(OMNIMORPH, tilt, aim, model)
            assert (np.abs(made) <= 5.3587 * (1.0 + 1e-9)).all()
            lost = thrust_lost(OMNIMORPH, tilt, made, model)
            np.testing.assert_allclose(made * (1.0 - lost), aim, atol=1e-8)


def thrusts_before_loss(
    vehicle: Vehicle, tilt: float, aim: FloatArray, model: WakeModel
) -> FloatArray:
    """Return c_f w|w| such that `aim` is left: rotors upstream first, then those in their wakes."""
    made = aim.copy()
    for above, below in stacked_pairs(vehicle):
        if aim[above] * aim[below] <= 0.0:
            continue
        i = below if aim[below] > 0.0 else above

        def left(size: float, i: int = int(i)) -> float:
            tried = made.copy()
            tried[i] = math.copysign(size, aim[i])
            return float(size * (1.0 - thrust_lost(vehicle, tilt, tried, model)[i]) - abs(aim[i]))

        made[i] = math.copysign(brentq(left, 0.0, 6.0, xtol=1e-14), aim[i])
    return made


def test_a_frozen_vehicle_loses_as_one_tilted_by_nothing() -> None:
    """Rotors in line count at α = 0: frozen there the same, frozen at 45° no pairs are left."""
    same = hover_in_wakes(frozen(OMNIMORPH, 0.0), [])
    assert same.power == pytest.approx(hover_in_wakes(OMNIMORPH, 0.0).power, rel=1e-9)
    turned = frozen(OMNIMORPH, 0.25 * math.pi)
    assert hover_in_wakes(turned, []).power == hover(turned, []).power
