"""Thrust lost in the wakes of rotors in line: published points, signs, theory and geometry."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from omnimorph.design import Vehicle, load_vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.interference import WAKE_MODELS, WakeModel, stacked_pairs, thrust_lost
from omnimorph.protocols import FloatArray

OMNIMORPH = load_vehicle("omnimorph")
UP = (0.0, 0.0, 1.0)
NONE, ALONG_X = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
BETA = 0.948

each_model = pytest.mark.parametrize("model", WAKE_MODELS)


def build_vehicle(position: ArrayLike, axis: ArrayLike | None = None, **changes: Any) -> Vehicle:
    """Build a vehicle with these hubs and axes (up if not given), none of which tilts."""
    n = len(np.asarray(position))
    values: dict[str, Any] = {
        "name": "test",
        "title": "A vehicle for tests",
        "mass": 1.0,
        "inertia": np.diag([0.01, 0.01, 0.02]),
        "rotor_position": position,
        "rotor_axis": [UP] * n if axis is None else axis,
        "hinge_axis": [NONE] * n,
        "rotor_servo": [-1] * n,
        "rotor_spin": [1] * n,
        "servo_name": (),
        "filter_cutoff": [0.0] * 4,
    }
    of_rotors = {"thrust_coefficient": 1e-5, "drag_coefficient": 2e-7, "speed_max": 600.0}
    of_rotors |= {"speed_min": -600.0, "dead_band": 0.0, "spin_inertia": 1e-5}
    of_rotors |= {"time_constant_up": 0.02, "time_constant_down": 0.02}
    values |= {name: [value] * n for name, value in of_rotors.items()}
    of_servos = ("angle_min", "angle_max", "rate_max", "time_constant")
    m = len(changes.get("servo_name", ()))
    values |= {f"servo_{name}": [1.0] * m for name in of_servos}
    return Vehicle(**(values | changes))


def thrust_at(speed_Hz: ArrayLike) -> FloatArray:
    """Return OmniMorph's thrusts at these speeds, one for all rotors or one each."""
    w = np.broadcast_to(np.asarray(speed_Hz, dtype=np.float64), 8)
    return 1.8638e-4 * w * np.abs(w)


def column(upper_Hz: float, lower_Hz: float) -> FloatArray:
    """Return OmniMorph's thrusts with one speed in each layer."""
    return thrust_at([upper_Hz] * 4 + [lower_Hz] * 4)


def blade_element_loss(kappa: float) -> float:
    """Solve momentum and blade-element theory by bisection for the share of thrust lost."""

    def thrust(inflow: float) -> float:
        return 1.0 - BETA * (inflow - 1.0)

    # a wake adds to the inflow of hover, x = 1, at most itself
    x = brentq(lambda x: x * (x - kappa) - thrust(x), 1.0, 1.0 + kappa, xtol=1e-15)
    return float(np.clip(1.0 - thrust(x), 0.0, 1.0))


# --- what is published ------------------------------------------------------------------------


@each_model
@pytest.mark.parametrize(("tilt_deg", "percent"), [(0.0, 33.3), (50.0, 7.0)])
def test_published_points(model: WakeModel, tilt_deg: float, percent: float) -> None:
    """All eight rotors at 120 Hz, a lower one measured; to the digits that were published."""
    lost = thrust_lost(OMNIMORPH, math.radians(tilt_deg), thrust_at(120.0), model)
    np.testing.assert_array_equal(lost[:4], 0.0)
    np.testing.assert_allclose(100.0 * lost[4:], percent, atol=0.05)


def test_bench_force_falls_from_2_7_to_1_8_newtons() -> None:
    f = thrust_at(120.0)
    left = f * (1.0 - thrust_lost(OMNIMORPH, 0.0, f))
    assert f[4].round(1) == 2.7
    assert left[4].round(1) == 1.8


@pytest.mark.parametrize(
    ("tilt_deg", "at_120_Hz"), [(0.0, 0.333), (50.0, 0.333 * math.exp(-25 / 16))]
)
def test_published_loss_goes_with_the_partners_speed(tilt_deg: float, at_120_Hz: float) -> None:
    """The bench: one lower rotor at 120 Hz, the other seven in steps of 20 Hz."""
    for others in range(0, 121, 20):
        f = thrust_at([others] * 4 + [120.0] + [others] * 3)
        lost = thrust_lost(OMNIMORPH, math.radians(tilt_deg), f)
        assert lost[4] == pytest.approx(at_120_Hz * others / 120.0, rel=1e-12, abs=0.0)


# --- blade-element and momentum theory --------------------------------------------------------


@pytest.mark.parametrize("ratio", [0.0, 1e-6, 0.1, 0.5, 1.0, 1.1, 2.0, 2.39, 2.41, 5.0])
def test_blade_element_solves_its_two_equations(ratio: float) -> None:
    lost = thrust_lost(OMNIMORPH, 0.0, column(120.0 * ratio, 120.0), "blade-element")
    np.testing.assert_allclose(lost[4:], blade_element_loss(0.857 * ratio), rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(("kappa", "percent"), [(1.0, 40), (0.857, 33), (0.208, 7)])
def test_calibration_of_the_blade_element_model(kappa: float, percent: int) -> None:
    """Full immersion and the two published points, the last two to the digits published."""
    f = column(120.0 * kappa / 0.857, 120.0)
    lost = thrust_lost(OMNIMORPH, 0.0, f, "blade-element")
    assert round(100.0 * lost[4]) == percent
    assert round(100.0 * blade_element_loss(kappa)) == percent


@pytest.mark.parametrize("tilt_deg", [-60.0, 0.0, 10.0, 42.0, 50.0, 90.0])
def test_blade_element_wakes_fade_with_the_angle(tilt_deg: float) -> None:
    kappa = 0.857 * (0.208 / 0.857) ** (tilt_deg / 50.0) ** 2
    lost = thrust_lost(OMNIMORPH, math.radians(tilt_deg), thrust_at(100.0), "blade-element")
    np.testing.assert_allclose(lost[4:], blade_element_loss(kappa), rtol=1e-9)


def test_a_faint_wake_costs_its_share_of_the_slope() -> None:
    """1 − y = β κ / (2 + β) to first order, and exactly nothing without a wake."""
    f = column(120e-7, 120.0)
    lost = thrust_lost(OMNIMORPH, 0.0, f, "blade-element")
    np.testing.assert_allclose(lost[4:], 0.857e-7 * BETA / (2.0 + BETA), rtol=1e-6)
    np.testing.assert_array_equal(
        thrust_lost(OMNIMORPH, 0.0, column(0.0, 120.0), "blade-element"), 0.0
    )


# --- who blows on whom ------------------------------------------------------------------------


@each_model
@pytest.mark.parametrize(
    ("upper", "lower", "losing"),
    [(90.0, 120.0, "lower"), (-90.0, -120.0, "upper"), (90.0, -120.0, ""), (-90.0, 120.0, "")],
)
def test_the_rotor_downstream_loses(
    model: WakeModel, upper: float, lower: float, losing: str
) -> None:
    lost = thrust_lost(OMNIMORPH, 0.3, column(upper, lower), model)
    expected = np.repeat([losing == "upper", losing == "lower"], 4)
    np.testing.assert_array_equal(lost > 0.0, expected)
    assert lost.max() < 1.0


@each_model
def test_upside_down_is_the_same(model: WakeModel) -> None:
    right_way = thrust_lost(OMNIMORPH, 0.4, column(90.0, 120.0), model)
    upside_down = thrust_lost(OMNIMORPH, 0.4, column(-120.0, -90.0), model)
    np.testing.assert_array_equal(upside_down, np.roll(right_way, 4))


@each_model
def test_every_pair_by_itself(model: WakeModel) -> None:
    """Random speeds and tilts against the model written out for one pair after another."""
    rng = np.random.default_rng(1)
    for _ in range(50):
        w, tilt_deg = rng.uniform(-150.0, 150.0, 8), rng.uniform(0.0, 60.0)
        expected = np.zeros(8)
        for upper, lower in zip(range(4), range(4, 8), strict=True):
            if w[upper] * w[lower] < 0.0:
                continue
            down, up = (lower, upper) if w[lower] > 0.0 else (upper, lower)
            if model == "published":
                kappa = 0.333 * math.exp(-((tilt_deg / 40.0) ** 2)) * abs(w[up] / w[down])
                expected[down] = min(kappa, 1.0)
            else:
                weight = 0.857 * (0.208 / 0.857) ** (tilt_deg / 50.0) ** 2
                expected[down] = blade_element_loss(weight * abs(w[up] / w[down]))
        lost = thrust_lost(OMNIMORPH, math.radians(tilt_deg), thrust_at(w), model)
        np.testing.assert_allclose(lost, expected, rtol=1e-9, atol=1e-15)


def test_the_angle_is_that_of_the_rotor_upstream() -> None:
    """Two rotors in line, each with a servo of its own, tilted one at a time."""
    vehicle = build_vehicle(
        [[0, 0, 0.1], [0, 0, -0.1]],
        hinge_axis=[ALONG_X, ALONG_X],
        rotor_servo=[0, 1],
        servo_name=("upper", "lower"),
    )
    tilted, straight = 0.333 * math.exp(-25 / 16), 0.333
    only_upper, only_lower = [math.radians(50.0), 0.0], [0.0, math.radians(50.0)]
    np.testing.assert_allclose(thrust_lost(vehicle, only_upper, [1, 1]), [0, tilted], rtol=1e-12)
    np.testing.assert_allclose(thrust_lost(vehicle, only_lower, [1, 1]), [0, straight], rtol=1e-12)
    np.testing.assert_allclose(
        thrust_lost(vehicle, only_upper, [-1, -1]), [straight, 0], rtol=1e-12
    )
    np.testing.assert_allclose(thrust_lost(vehicle, only_lower, [-1, -1]), [tilted, 0], rtol=1e-12)


@each_model
def test_losses_turn_omnimorph_about_its_vertical_axis(model: WakeModel) -> None:
    """Equal thrusts of both layers balance in yaw; without Δf below, 4 l sin α Δf is left."""
    tilt, f = math.radians(30.0), thrust_at(120.0)
    lost = f * thrust_lost(OMNIMORPH, tilt, f, model)
    wrench = allocation_matrix(OMNIMORPH, tilt) @ (f - lost)
    yaw = 4.0 * 0.1062 * math.sin(tilt) * lost[4]
    np.testing.assert_allclose(wrench[[0, 1, 3, 4, 5]], [0, 0, 0, 0, yaw], atol=1e-14)


# --- at rest and near it ----------------------------------------------------------------------


@each_model
@pytest.mark.parametrize("fading", ["upper", "lower"])
def test_thrust_in_newtons_is_continuous_where_a_rotor_stops(model: WakeModel, fading: str) -> None:
    """At most √(f_up f_down) is lost, from either side; at rest nothing."""
    for sign in (1.0, -1.0):
        for size in (1e-2, 1e-6, 1e-12, 1e-300, 0.0):
            faint, strong = sign * size, 2.7
            f = np.repeat([faint, strong] if fading == "upper" else [strong, faint], 4)
            for thrust in (f, -f):
                gone = np.abs(thrust) * thrust_lost(OMNIMORPH, 0.0, thrust, model)
                assert (gone <= math.sqrt(size * strong)).all()


@each_model
def test_loss_is_a_share_whatever_the_speeds(model: WakeModel) -> None:
    """From 0 to 1, never NaN, up to the ends of what a double holds."""
    sizes = [0.0, 5e-324, 1e-300, 1e-9, 1.0, 1e9, 1e308]
    for upper in sizes:
        for lower in sizes:
            lost = thrust_lost(OMNIMORPH, 0.0, np.repeat([upper, lower], 4), model)
            assert ((lost >= 0.0) & (lost <= 1.0)).all()
            if upper == 0.0 or lower == 0.0:
                np.testing.assert_array_equal(lost, 0.0)
            elif upper > 1e3 * lower:
                np.testing.assert_array_equal(lost[4:], 1.0)


@each_model
def test_only_the_ratio_of_speeds_counts(model: WakeModel) -> None:
    slow = thrust_lost(OMNIMORPH, 0.2, column(60.0, 80.0), model)
    fast = thrust_lost(OMNIMORPH, 0.2, column(120.0, 160.0), model)
    np.testing.assert_allclose(slow, fast, rtol=1e-14)


# --- which rotors are in line -----------------------------------------------------------------


def test_pairs_of_omnimorph() -> None:
    pairs = stacked_pairs(OMNIMORPH)
    np.testing.assert_array_equal(pairs, [[0, 4], [1, 5], [2, 6], [3, 7]])
    assert pairs.dtype == np.int64


@pytest.mark.parametrize(
    "position",
    [[[0.2, 0, 0], [0, 0.2, 0], [-0.2, 0, 0], [0, -0.2, 0]], [NONE], [NONE, NONE]],
    ids=["quadrotor", "one rotor", "two at the same place"],
)
@each_model
def test_rotors_that_are_not_in_line_lose_nothing(position: ArrayLike, model: WakeModel) -> None:
    vehicle = build_vehicle(position)
    assert stacked_pairs(vehicle).shape == (0, 2)
    n = vehicle.n_rotors
    np.testing.assert_array_equal(thrust_lost(vehicle, [], np.full(n, 2.0), model), np.zeros(n))


def leaning(degrees: float) -> tuple[float, float, float]:
    """Return the upward direction, leant over towards x."""
    return (math.sin(math.radians(degrees)), 0.0, math.cos(math.radians(degrees)))


@pytest.mark.parametrize(
    ("off_line", "off_axis", "in_line"),
    [(0, 0, True), (9.9, 0, True), (-9.9, 9.9, True), (10.1, 0, False), (0, 10.1, False),
     (0, 180, False), (180, 0, True), (90, 0, False)],
)  # fmt: skip
def test_in_line_means_within_ten_degrees(off_line: float, off_axis: float, in_line: bool) -> None:
    """Hubs along a line that leans, the axis of one leaning too."""
    vehicle = build_vehicle([leaning(off_line), NONE], [UP, leaning(off_axis)])
    order = [1, 0] if off_line == 180 else [0, 1]
    assert stacked_pairs(vehicle).tolist() == ([order] if in_line else [])


def test_a_pair_not_quite_in_line_loses_less() -> None:
    vehicle = build_vehicle([leaning(8.0), NONE])
    lost = thrust_lost(vehicle, [], [1.0, 1.0])
    np.testing.assert_allclose(lost, [0.0, 0.333 * math.exp(-((8.0 / 40.0) ** 2))], rtol=1e-12)


def test_untilted_is_what_counts_not_where_the_servo_stands() -> None:
    """At 90° of tilt OmniMorph's wakes miss their partners, yet the pairs are the same."""
    locked = OMNIMORPH.replace(servo_angle_min=[1.0], servo_angle_max=[1.0])
    np.testing.assert_array_equal(stacked_pairs(locked), stacked_pairs(OMNIMORPH))
    assert thrust_lost(OMNIMORPH, math.pi / 2, thrust_at(120.0)).max() < 0.003


def test_three_in_a_column_keep_the_product() -> None:
    vehicle = build_vehicle([[0, 0, -0.2], [0, 0, 0.2], NONE])
    np.testing.assert_array_equal(stacked_pairs(vehicle), [[1, 0], [1, 2], [2, 0]])
    # bottom, top, middle at speeds 2, 1, 1: the bottom one meets two wakes of half strength
    lost = thrust_lost(vehicle, [], [4.0, 1.0, 1.0])
    np.testing.assert_allclose(1.0 - lost, [(1 - 0.333 / 2) ** 2, 1.0, 1 - 0.333], rtol=1e-14)
    lost = thrust_lost(vehicle, [], [-1.0, -4.0, -1.0])
    np.testing.assert_allclose(1.0 - lost, [1.0, (1 - 0.333 / 2) ** 2, 1 - 0.333], rtol=1e-14)
    # a rotor that turns the other way round between two leaves them to each other
    lost = thrust_lost(vehicle, [], [1.0, 1.0, -1.0])
    np.testing.assert_allclose(lost, [0.333, 0.0, 0.0], rtol=1e-14)


@each_model
def test_the_numbering_of_the_rotors_does_not_matter(model: WakeModel) -> None:
    order = np.random.default_rng(2).permutation(8)
    of_rotors = ("rotor_position", "rotor_axis", "hinge_axis", "rotor_servo", "rotor_spin")
    changes = {name: getattr(OMNIMORPH, name)[order] for name in of_rotors}
    renumbered = OMNIMORPH.replace(**changes)
    f = thrust_at([90, 100, -110, 120, 130, 80, -70, 60])
    lost = thrust_lost(OMNIMORPH, 0.4, f, model)
    assert (lost > 0.0).sum() == 4
    np.testing.assert_array_equal(thrust_lost(renumbered, 0.4, f[order], model), lost[order])
    pairs = {tuple(order[pair]) for pair in stacked_pairs(renumbered)}
    assert pairs == {tuple(pair) for pair in stacked_pairs(OMNIMORPH)}


@each_model
def test_the_body_axes_do_not_matter(model: WakeModel) -> None:
    turn = Rotation.from_rotvec([0.7, -1.9, 0.4]).as_matrix()
    vectors = ("rotor_position", "rotor_axis", "hinge_axis")
    turned = OMNIMORPH.replace(**{name: getattr(OMNIMORPH, name) @ turn.T for name in vectors})
    np.testing.assert_array_equal(stacked_pairs(turned), stacked_pairs(OMNIMORPH))
    f = thrust_at([90, 100, -110, 120, 130, 80, -70, 60])
    for tilt in (0.0, 0.4, 1.0):
        np.testing.assert_allclose(
            thrust_lost(turned, tilt, f, model), thrust_lost(OMNIMORPH, tilt, f, model), rtol=1e-12
        )


# --- mistakes ---------------------------------------------------------------------------------


def test_unknown_model() -> None:
    with pytest.raises(VehicleError, match=r'model is "blade_element", but it must be "published"'):
        thrust_lost(OMNIMORPH, 0.0, thrust_at(1.0), "blade_element")  # type: ignore[arg-type]


@pytest.mark.parametrize("thrust", [1.0, [1.0] * 7, [math.nan] * 8, [math.inf] + [1.0] * 7])
def test_thrust_that_is_none(thrust: ArrayLike) -> None:
    with pytest.raises(VehicleError, match=r"omnimorph: thrust is .* each of the 8 rotors"):
        thrust_lost(OMNIMORPH, 0.0, thrust)


@pytest.mark.parametrize("tilt", [math.nan, [0.1, 0.2]])
def test_tilt_that_is_none(tilt: ArrayLike) -> None:
    with pytest.raises(VehicleError, match="vehicle omnimorph: tilt is"):
        thrust_lost(OMNIMORPH, tilt, thrust_at(1.0))
