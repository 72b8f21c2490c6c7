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

from omnimorph.analysis import actuation, force_set, hover, sensitivity
from omnimorph.analysis.sensitivity import QUANTITIES, Quantity, Sensitivity
from omnimorph.design import Vehicle, load_vehicle
from omnimorph.errors import VehicleError
from omnimorph.protocols import FloatArray

OMNIMORPH = load_vehicle("omnimorph")
STEP = 1e-4  # m, rad or N

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
    """Return a quantity as the other functions of the analysis know it."""
    if quantity == "hover_power":
        return hover(vehicle, tilt, beyond_limits=True).power
    if quantity == "condition_number":
        return actuation(vehicle, tilt, beyond_limits=True).condition_number
    zero_moment = quantity == "radius_zero_moment"
    return force_set(vehicle, tilt, zero_moment=zero_moment, beyond_limits=True).inscribed_radius


def slope_along(change: Callable[[float], float]) -> float:
    """Return a central difference of fourth order."""
    near, far = (change(k * STEP) - change(-k * STEP) for k in (1.0, 2.0))
    return (8.0 * near - far) / (12.0 * STEP)


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


def difference_quotients(vehicle: Vehicle, tilt: FloatArray, quantity: Quantity) -> Sensitivity:
    """Return all derivatives by central differences."""

    def of(change: Callable[[float], Vehicle]) -> float:
        return slope_along(lambda step: value_of(change(step), tilt, quantity))

    n, m = vehicle.n_rotors, vehicle.n_servos
    position, axis = np.zeros((n, 3)), np.zeros((n, 3))
    for i in range(n):
        for k in range(3):
            unit = np.zeros((n, 3))
            unit[i, k] = 1.0
            position[i, k] = of(
                lambda step, u=unit: vehicle.replace(  # type: ignore[misc]
                    rotor_position=vehicle.rotor_position + step * u
                )
            )
        across = np.linalg.svd(vehicle.rotor_axis[[i]])[2][1:]
        axis[i] = sum(of(leaning(vehicle, i, towards)) * towards for towards in across)
    return Sensitivity(
        value=value_of(vehicle, tilt, quantity),
        tilt=np.array(
            [
                slope_along(lambda step, u=unit: value_of(vehicle, tilt + step * u, quantity))  # type: ignore[misc]
                for unit in np.eye(m)
            ]
        ),
        position=position,
        axis=axis,
        thrust_min=np.array([of(with_limit(vehicle, "speed_min", i)) for i in range(n)]),
        thrust_max=np.array([of(with_limit(vehicle, "speed_max", i)) for i in range(n)]),
    )


def check_agree(found: Sensitivity, expected: Sensitivity) -> None:
    assert found.value == pytest.approx(expected.value, rel=1e-9)
    for name in ("tilt", "position", "axis", "thrust_min", "thrust_max"):
        exact, near = getattr(found, name), getattr(expected, name)
        assert exact.shape == near.shape
        size = max(float(np.abs(near).max(initial=0.0)), 1e-3 * abs(expected.value))
        np.testing.assert_allclose(exact, near, atol=2e-6 * size, err_msg=name)


@each_quantity
@pytest.mark.parametrize(("seed", "degrees"), [(0, 20.0), (3, 65.0)])
def test_perturbed_omnimorph(quantity: Quantity, seed: int, degrees: float) -> None:
    vehicle, tilt = perturbed(seed), np.radians([degrees])
    found = sensitivity(vehicle, tilt, quantity, beyond_limits=True)
    check_agree(found, difference_quotients(vehicle, tilt, quantity))


@pytest.mark.parametrize("quantity", ["hover_power", "condition_number"])
def test_rotors_that_only_push(quantity: Quantity) -> None:
    """With several servos, and limits that are active in hovering."""
    vehicle, tilt = pushing(0), np.array([0.1, 0.2, 0.1, 0.2])
    found = sensitivity(vehicle, tilt, quantity)
    check_agree(found, difference_quotients(vehicle, tilt, quantity))
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
    check_agree(found, difference_quotients(heavy, tilt, "hover_power"))


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
    check_agree(found, difference_quotients(vehicle, np.zeros(0), quantity))


# --- closed forms ------------------------------------------------------------------------------


def test_radius_of_omnimorph_in_closed_form() -> None:
    """r = 4 f_max sin α: dr/dα = 4 f_max cos α, and a twelfth more thrust is a twelfth more."""
    for degrees in (10.0, 20.0, 50.0):
        found = sensitivity(OMNIMORPH, math.radians(degrees), "radius_free_moment")
        slope = 4.0 * 5.3587 * math.cos(math.radians(degrees))
        np.testing.assert_allclose(found.tilt, [slope], rtol=1e-12)
        np.testing.assert_allclose(found.position, 0.0, atol=1e-12)
        room = found.thrust_max @ OMNIMORPH.thrust_max + found.thrust_min @ OMNIMORPH.thrust_min
        assert room == pytest.approx(found.value, rel=1e-12)
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
    np.testing.assert_allclose(found.axis, 0.0, atol=1e-8)


# --- where there is none -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vehicle", "tilt", "quantity", "reason"),
    [
        (OMNIMORPH, 0.0, "radius_free_moment", "holds no ball about zero"),
        (OMNIMORPH, 0.0, "radius_zero_moment", "holds no ball about zero"),
        (OMNIMORPH, 0.0, "condition_number", "A has not full rank"),
        (OMNIMORPH.replace(mass=4.5), 0.5, "hover_power", "it cannot hover level"),
        (build_star(4), [], "condition_number", "A has not full rank"),
        (build_star(6), [], "condition_number", "A has not full rank"),
        (build_star(6, cant=0.3), [], "radius_free_moment", "holds no ball about zero"),
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
