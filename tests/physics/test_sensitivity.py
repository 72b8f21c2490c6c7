"""Derivatives with respect to the design, against difference quotients and closed forms."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import ArrayLike
from tests.physics.small_vehicles import (
    build_star,
    build_tilting_star,
    build_vehicle,
    random_axes,
)

from omnimorph.analysis import force_set, hover, sensitivity
from omnimorph.analysis.scaling import whitened
from omnimorph.analysis.sensitivity import QUANTITIES, Derivatives, Quantity, Sensitivity
from omnimorph.design import Vehicle, load_vehicle
from omnimorph.errors import VehicleError
from omnimorph.protocols import FloatArray

OMNIMORPH = load_vehicle("omnimorph")
STEP = 1e-4  # m, rad or N
SOME = [0, 3, 6]  # rotors whose derivatives are compared with differences

each_quantity = pytest.mark.parametrize("quantity", QUANTITIES)


def perturbed(seed: int, much: float = 1.0) -> Vehicle:
    """Return OmniMorph with no two rotors alike, so that no two facets are equally far."""
    generator = np.random.default_rng(seed)
    axis = OMNIMORPH.rotor_axis + 0.1 * much * generator.normal(size=(8, 3))
    top = OMNIMORPH.speed_max * generator.uniform(0.9, 1.1, 8)
    return OMNIMORPH.replace(
        rotor_position=OMNIMORPH.rotor_position + 0.02 * much * generator.normal(size=(8, 3)),
        rotor_axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        hinge_axis=random_axes(generator, 8) if seed % 2 else OMNIMORPH.hinge_axis,
        speed_max=top,
        speed_min=-top * generator.uniform(0.9, 1.0, 8),
        drag_coefficient=OMNIMORPH.drag_coefficient * generator.uniform(0.8, 1.2, 8),
    )


def pushing(seed: int) -> Vehicle:
    """Return the same with rotors that cannot turn slowly or back, and four servos."""
    vehicle = perturbed(seed, 0.3)
    servos = {"servo_angle_min": [-1.0] * 4, "servo_angle_max": [1.0] * 4}
    servos |= {"servo_rate_max": [1.0] * 4, "servo_time_constant": [0.0] * 4}
    return vehicle.replace(
        mass=1.0,
        speed_min=0.4 * vehicle.speed_max,
        servo_name=("one", "two", "three", "four"),
        rotor_servo=np.arange(8) % 4,
        **{name: np.array(values) for name, values in servos.items()},
    )


# --- the quantities, by other means ------------------------------------------------------------


def value_of(vehicle: Vehicle, tilt: ArrayLike, quantity: Quantity) -> float:
    """Return a quantity by other means."""
    if quantity == "hover_power":
        return hover(vehicle, tilt, beyond_limits=True).power
    if quantity == "condition_number":
        return float(np.linalg.cond(whitened(vehicle, np.atleast_1d(tilt))))
    zero_moment = quantity == "radius_zero_moment"
    return force_set(vehicle, tilt, zero_moment=zero_moment, beyond_limits=True).inscribed_radius


def slope_along(change: Callable[[float], float]) -> float:
    """Return a one-sided difference of fourth order: the slope as the step grows from zero."""
    weights = (-25.0 / 12.0, 4.0, -3.0, 4.0 / 3.0, -0.25)
    return sum(weight * change(k * STEP) for k, weight in enumerate(weights)) / STEP


def leaning(vehicle: Vehicle, i: int, towards: FloatArray) -> Callable[[float], Vehicle]:
    """Return the vehicle as a function of how far axis i leans towards a direction, rad."""

    def lean(angle: float) -> Vehicle:
        axis = vehicle.rotor_axis.copy()
        axis[i] = math.cos(angle) * axis[i] + math.sin(angle) * towards
        return vehicle.replace(rotor_axis=axis)

    return lean


def with_limit(vehicle: Vehicle, name: str, i: int) -> Callable[[float], Vehicle]:
    """Return the vehicle as a function of what is added to one limit of thrust, N."""

    def limit(added: float) -> Vehicle:
        speed = getattr(vehicle, name).copy()
        thrust = vehicle.thrust_coefficient[i] * speed[i] * abs(speed[i]) + added
        speed[i] = math.copysign(math.sqrt(abs(thrust) / vehicle.thrust_coefficient[i]), thrust)
        return vehicle.replace(**{name: speed})

    return limit


def quotients(vehicle: Vehicle, tilt: FloatArray, quantity: Quantity, side: float) -> Derivatives:
    """Return the derivatives of some rotors from one side, +1 or −1, by differences."""

    def of(change: Callable[[float], Vehicle]) -> float:
        return side * slope_along(lambda step: value_of(change(side * step), tilt, quantity))

    def widened(i: int) -> Callable[[float], Vehicle]:
        return lambda step: with_limit(with_limit(vehicle, "speed_max", i)(step), "speed_min", i)(
            -step
        )

    n, few = vehicle.n_rotors, len(SOME)
    position, axis = np.zeros((few, 3)), np.zeros((few, 3))
    for row, k in np.ndindex(few, 3):
        i, unit = SOME[row], np.zeros((n, 3))
        unit[i, k] = 1.0
        position[row, k] = of(
            lambda step, u=unit: vehicle.replace(  # type: ignore[misc]
                rotor_position=vehicle.rotor_position + step * u
            )
        )
        across = unit[i] - vehicle.rotor_axis[i] * vehicle.rotor_axis[i, k]
        length = float(np.linalg.norm(across))
        axis[row, k] = length and length * of(leaning(vehicle, i, across / length))
    tilts = [
        side * slope_along(lambda step, u=unit: value_of(vehicle, tilt + side * step * u, quantity))  # type: ignore[misc]
        for unit in np.eye(vehicle.n_servos)
    ]
    return Derivatives(
        tilt=np.array(tilts),
        position=position,
        axis=axis,
        thrust_min=np.array([of(with_limit(vehicle, "speed_min", i)) for i in SOME]),
        thrust_max=np.array([of(with_limit(vehicle, "speed_max", i)) for i in SOME]),
        thrust_range=np.array([of(widened(i)) for i in SOME]),
    )


def check_agree(
    found: Sensitivity, vehicle: Vehicle, tilt: FloatArray, quantity: Quantity, to: float = 2e-6
) -> None:
    """Compare all derivatives, from both sides, with difference quotients."""
    value = value_of(vehicle, tilt, quantity)
    assert found.value == pytest.approx(value, rel=1e-9)
    for exact_ones, side in ((found.left, -1.0), (found.right, 1.0)):
        near_ones = quotients(vehicle, tilt, quantity, side)
        for name, exact, near in zip(Derivatives._fields, exact_ones, near_ones, strict=True):
            exact = exact if name == "tilt" else exact[SOME]
            assert exact.shape == near.shape
            size = max(float(np.abs(near).max(initial=0.0)), 1e-3 * abs(value))
            np.testing.assert_allclose(exact, near, atol=to * size, err_msg=f"{name} {side:+g}")


@each_quantity
@pytest.mark.parametrize(("seed", "degrees"), [(0, 20.0), (3, 65.0)])
def test_perturbed_omnimorph(quantity: Quantity, seed: int, degrees: float) -> None:
    vehicle, tilt = perturbed(seed), np.radians([degrees])
    found = sensitivity(vehicle, tilt, quantity, beyond_limits=True)
    check_agree(found, vehicle, tilt, quantity)


@pytest.mark.parametrize("quantity", ["hover_power", "condition_number"])
def test_rotors_that_only_push(quantity: Quantity) -> None:
    """With several servos, and limits that are active in hovering."""
    vehicle, tilt = pushing(0), np.array([0.1, 0.2, 0.1, 0.2])
    found = sensitivity(vehicle, tilt, quantity)
    check_agree(found, vehicle, tilt, quantity)
    if quantity == "hover_power":  # a least thrust that must be kept costs
        assert (found.thrust_min >= 0.0).all()
        assert found.thrust_min.max() > 0.1
        assert (found.thrust_max <= 0.0).all()


def test_room_above_saves_power() -> None:
    """Near the largest load some rotors are at their upper limit: a newton more saves watts."""
    vehicle, tilt = perturbed(2), np.array([0.3])
    lift = force_set(vehicle, tilt, zero_moment=True).reach([0.0, 0.0, 1.0])
    heavy = vehicle.replace(mass=0.9 * lift / 9.81)
    found = sensitivity(heavy, tilt, "hover_power")
    assert found.thrust_max.min() < -1.0
    check_agree(found, heavy, tilt, "hover_power")


@pytest.mark.parametrize("quantity", ["radius_free_moment", "radius_zero_moment"])
def test_radii_of_rotors_that_only_push(quantity: Quantity) -> None:
    """Two rotors each way along the axes of a cube, beside them and against each other's drag."""
    generator = np.random.default_rng(3)
    push = np.tile(np.vstack([np.eye(3), -np.eye(3)]), (2, 1))
    side = np.repeat([0.15, -0.15], 6)[:, None] * np.roll(np.abs(push), 1, axis=1)
    axis = push + 0.1 * generator.normal(size=(12, 3))
    vehicle = build_vehicle(
        0.1 * push + side + 0.01 * generator.normal(size=(12, 3)),
        axis / np.linalg.norm(axis, axis=1, keepdims=True),
        rotor_spin=np.repeat([1.0, -1.0], 6),
        speed_min=30.0,
        speed_max=generator.uniform(500.0, 600.0, 12),
    )
    found = sensitivity(vehicle, [], quantity)
    assert found.value > 0.5
    check_agree(found, vehicle, np.zeros(0), quantity)


# --- closed forms ------------------------------------------------------------------------------


def test_radius_of_omnimorph_in_closed_form() -> None:
    """r = 4 f_max sin α: dr/dα = 4 f_max cos α, and a twelfth more thrust is a twelfth more.

    The sphere touches opposite facets: more thrust one way of one rotor gains nothing.
    """
    for degrees in (10.0, 20.0, 50.0):
        found = sensitivity(OMNIMORPH, math.radians(degrees), "radius_free_moment")
        slope = 4.0 * 5.3587 * math.cos(math.radians(degrees))
        np.testing.assert_allclose(found.tilt, [slope], rtol=1e-12)
        np.testing.assert_allclose(found.position, 0.0, atol=1e-12)
        room = found.along(thrust_max=OMNIMORPH.thrust_max, thrust_min=OMNIMORPH.thrust_min)
        assert room == pytest.approx(found.value, rel=1e-12)
        np.testing.assert_allclose(found.right.thrust_max, 0.0, atol=1e-12)
        assert found.left.thrust_max.min() > 0.1
        assert np.isnan(found.thrust_max).any()
    assert sensitivity(OMNIMORPH, math.radians(20.0), "radius_free_moment").tilt[0] == (
        pytest.approx(20.14, abs=5e-3)
    )


def test_hover_power_of_omnimorph_in_closed_form() -> None:
    """P = P0 cos^(-3/2) α, so dP/dα = 3/2 P tan α; no limit is met."""
    for degrees in (0.0, 20.0, 60.0):
        tilt = math.radians(degrees)
        found = sensitivity(OMNIMORPH, tilt, "hover_power")
        np.testing.assert_allclose(found.tilt, [1.5 * found.value * math.tan(tilt)], atol=1e-8)
        np.testing.assert_array_equal(found.thrust_min, 0.0)
        np.testing.assert_array_equal(found.thrust_max, 0.0)


@each_quantity
def test_what_does_not_change(quantity: Quantity) -> None:
    """Turning all axes together, or moving all hubs along the thrust, changes what it must."""
    vehicle, tilt = perturbed(4), math.radians(45.0)
    found = sensitivity(vehicle, tilt, quantity)
    # an axis leans at right angles to itself
    np.testing.assert_allclose(np.sum(found.axis * vehicle.rotor_axis, axis=1), 0.0, atol=1e-12)
    if quantity.startswith("radius"):  # of degree 1 in the limits
        room = found.thrust_max @ vehicle.thrust_max + found.thrust_min @ vehicle.thrust_min
        assert room == pytest.approx(found.value, rel=1e-9)
    if quantity == "radius_free_moment":
        np.testing.assert_array_equal(found.position, 0.0)
    if quantity == "condition_number":  # of degree 0 in the limits
        room = found.thrust_max @ vehicle.thrust_max + found.thrust_min @ vehicle.thrust_min
        assert room == pytest.approx(0.0, abs=1e-9)


def test_a_quadrotor_spends_less_if_less_must_turn() -> None:
    """dP/df_min is the power of a newton more that another need not give."""
    star = build_star(4, mass=1.0, speed_min=[0.0, 0.0, 0.0, 0.0])
    found = sensitivity(star, [], "hover_power")
    assert found.tilt.shape == (0,)
    f = 0.25 * 9.81
    assert found.value == pytest.approx(4.0 * 2e-7 * (f / 1e-5) ** 1.5, rel=1e-10)
    # level hover ends where an axis leans, as nothing holds the force sideways
    assert np.isposinf(found.right.axis[:, :2]).all()
    assert np.isneginf(found.left.axis[:, :2]).all()
    np.testing.assert_array_equal(found.axis[:, 2], 0.0)
    np.testing.assert_allclose(found.position, 0.0, atol=1e-8)


# --- kinks ---------------------------------------------------------------------------------------

CUBE = load_vehicle("omnicopter")  # every axis of symmetry a cube has: many facets are touched


@each_quantity
@pytest.mark.parametrize(
    "degrees", [45.0, pytest.param(math.degrees(math.atan(2.0**0.5)), marks=pytest.mark.slow)]
)
def test_both_sides_of_a_symmetric_vehicle(quantity: Quantity, degrees: float) -> None:
    """The second tilt is where the radius has its peak, and two kinds of facets are touched."""
    tilt = np.radians([degrees])
    found = sensitivity(OMNIMORPH, tilt, quantity)
    check_agree(found, OMNIMORPH, tilt, quantity, 2e-5)


@pytest.mark.slow
@each_quantity
def test_both_sides_of_a_cube(quantity: Quantity) -> None:
    check_agree(sensitivity(CUBE, [], quantity), CUBE, np.zeros(0), quantity, 2e-5)


def test_both_sides_where_several_multipliers_are_optimal() -> None:
    """ODAR-8: each facet of the forces belongs to two of the wrenches."""
    odar = load_vehicle("odar-8")
    found = sensitivity(odar, [], "radius_zero_moment")
    check_agree(found, odar, np.zeros(0), "radius_zero_moment", 2e-5)


def test_the_tilt_of_the_largest_radius_is_a_peak() -> None:
    found = sensitivity(OMNIMORPH, math.atan(math.sqrt(2.0)), "radius_free_moment")
    assert found.left.tilt[0] > 1.0
    assert found.right.tilt[0] < -1.0
    assert np.isnan(found.tilt[0])


@each_quantity
def test_a_direction_is_what_its_steps_give_together(quantity: Quantity) -> None:
    """Along random directions from a kink; the other way it is not the opposite."""
    generator = np.random.default_rng(5)
    tilt, n = math.radians(45.0), 8
    found = sensitivity(OMNIMORPH, tilt, quantity)
    hubs, least, most = (generator.normal(size=shape) for shape in ((n, 3), n, n))

    def moved(step: float) -> float:
        vehicle = OMNIMORPH.replace(rotor_position=OMNIMORPH.rotor_position + step * 0.1 * hubs)
        for i in range(n):
            vehicle = with_limit(vehicle, "speed_min", i)(step * least[i])
            vehicle = with_limit(vehicle, "speed_max", i)(step * most[i])
        return value_of(vehicle, tilt + 0.5 * step, quantity)

    for way in (1.0, -1.0):
        limits = {"thrust_min": way * least, "thrust_max": way * most}
        slope = found.along(tilt=0.5 * way, position=0.1 * way * hubs, **limits)
        expected = slope_along(lambda step, way=way: moved(way * step))  # type: ignore[misc]
        assert slope == pytest.approx(expected, rel=1e-4, abs=1e-5 * found.value)


# --- where there is none -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vehicle", "tilt", "quantity", "reason"),
    [
        (OMNIMORPH, 0.0, "radius_free_moment", "has no inscribed sphere about zero"),
        (OMNIMORPH, 0.0, "radius_zero_moment", "has no inscribed sphere about zero"),
        (OMNIMORPH, 0.0, "condition_number", "A has not full rank"),
        (OMNIMORPH.replace(mass=4.5), 0.5, "hover_power", "it cannot hover level"),
        (build_star(4), [], "condition_number", "A has not full rank"),
        (build_star(6), [], "condition_number", "A has not full rank"),
        (build_star(6, cant=0.3), [], "radius_free_moment", "has no inscribed sphere about zero"),
        (build_vehicle([[0.1, 0.0, 0.0]]), [], "hover_power", "it cannot hover level"),
        (build_tilting_star(4), 0.3, "hover_power", "it cannot hover level"),
    ],
)
def test_no_derivative(vehicle: Vehicle, tilt: ArrayLike, quantity: Quantity, reason: str) -> None:
    with pytest.raises(VehicleError, match=f"has no derivative here: .*{reason}"):
        sensitivity(vehicle, tilt, quantity)


def test_refused() -> None:
    with pytest.raises(VehicleError, match='quantity is "radius", but it must be one of radius_f'):
        sensitivity(OMNIMORPH, 0.5, "radius")  # type: ignore[arg-type]
    with pytest.raises(VehicleError, match="tilt is 75°"):
        sensitivity(OMNIMORPH, math.radians(75.0), "hover_power")
