"""Where every attitude can hover: the digits of OmniMorph, other vehicles, the search itself."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star, build_tilting_star, build_vehicle, frozen

from omnimorph.analysis import (
    force_set,
    hover,
    inscribed_radius,
    level_hover_range,
    omnidirectional_range,
    tilt_of_largest_radius,
)
from omnimorph.analysis.tilt_search import highest_point, intervals_above_zero, lowest_points
from omnimorph.design import Vehicle, load_vehicle
from omnimorph.errors import VehicleError
from omnimorph.protocols import FloatArray

OMNIMORPH = load_vehicle("omnimorph")
WEIGHT = 1.315 * 9.81
TOP = 5.3587  # N
BEST = math.atan(math.sqrt(2.0))  # 54.7356°, the axes of a cube's diagonals
Curve = Callable[[float], float]


def degrees(intervals: FloatArray) -> list[list[float]]:
    return [[round(float(end), 2) + 0.0 for end in row] for row in np.degrees(intervals)]


# --- OmniMorph ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("zero_moment", "limited", "turn"),
    [(False, [37.00, 60.0], [37.00, 70.28]), (True, [38.18, 60.0], [38.18, 69.73])],
)
def test_where_omnimorph_is_omnidirectional(
    zero_moment: bool, limited: list[float], turn: list[float]
) -> None:
    """Within its limits it ends at 60°; beyond them at a root, where radius is weight."""
    assert degrees(omnidirectional_range(OMNIMORPH, zero_moment=zero_moment)) == [limited]
    found = omnidirectional_range(OMNIMORPH, zero_moment=zero_moment, beyond_limits=True)
    assert turn in degrees(found)
    assert len(found) == 4
    for end in found.ravel().tolist():
        radius = inscribed_radius(OMNIMORPH, end, zero_moment=zero_moment, beyond_limits=True)
        assert radius == pytest.approx(WEIGHT, abs=1e-9)
    for begin, end in found.tolist():
        middle = 0.5 * (begin + end)
        beside = begin - 1e-6, end + 1e-6
        radii = [
            inscribed_radius(OMNIMORPH, tilt, zero_moment=zero_moment, beyond_limits=True)
            for tilt in (begin + 1e-6, middle, end - 1e-6, *beside)
        ]
        assert min(radii[:3]) > WEIGHT > max(radii[3:])


def test_free_moments_in_closed_form() -> None:
    """r = f_max min(4 s, 8 s c/√(1+c²)): its interval ends at asin and at a root of a quadratic."""
    found = omnidirectional_range(OMNIMORPH, zero_moment=False, beyond_limits=True)
    share = WEIGHT / TOP
    # 64 (1 − c²) c² = share² (1 + c²)
    q = 64.0 - share**2
    c2 = (q - math.sqrt(q**2 - 256.0 * share**2)) / 128.0
    low, high = math.asin(0.25 * share), math.acos(math.sqrt(c2))
    expected = [[low - math.pi, 0.0], [-high, -low], [low, high], [0.0, math.pi - low]]
    expected[0][1], expected[3][0] = high - math.pi, math.pi - high
    np.testing.assert_allclose(found, np.sort(expected), atol=1e-11)


def test_its_largest_radius() -> None:
    """3.2660 f_max = 4 √(2/3) f_max at 54.7356° with free moments."""
    best = tilt_of_largest_radius(OMNIMORPH, zero_moment=False)
    assert math.degrees(best) == pytest.approx(54.7356, abs=5e-5)
    assert best == pytest.approx(BEST, abs=3e-8)
    peak = inscribed_radius(OMNIMORPH, best, zero_moment=False)
    assert peak == pytest.approx(4.0 * math.sqrt(2.0 / 3.0) * TOP, rel=1e-8)
    # over the whole turn four peaks are equal; the one nearest to 0 counts, upwards first
    whole = tilt_of_largest_radius(OMNIMORPH, zero_moment=False, beyond_limits=True)
    assert whole == pytest.approx(BEST, abs=3e-8)
    zero = tilt_of_largest_radius(OMNIMORPH)
    radii = [
        inscribed_radius(OMNIMORPH, zero + step, zero_moment=True) for step in (-1e-4, 0, 1e-4)
    ]
    assert radii[1] > max(radii[0], radii[2])


@pytest.mark.parametrize(
    ("tilt", "ratio"),
    [
        (20.0, 1.3439),
        (30.0, 1.9537),
        (37.0, 2.3446),
        (45.0, 2.7478),
        (54.7356, 3.1543),
        (60.0, 3.0041),
        (70.0, 2.3846),
    ],
)
def test_radius_at_zero_moment(tilt: float, ratio: float) -> None:
    radius = inscribed_radius(OMNIMORPH, math.radians(tilt), zero_moment=True, beyond_limits=True)
    assert radius / TOP == pytest.approx(ratio, abs=5e-5)


def test_where_it_hovers_level() -> None:
    """8 f_max cos α = m g at 72.49°, and the same the other way round and upside down."""
    assert degrees(level_hover_range(OMNIMORPH)) == [[0.0, 60.0]]
    found = level_hover_range(OMNIMORPH, beyond_limits=True)
    last = math.acos(WEIGHT / (8.0 * TOP))
    expected = [[-math.pi, last - math.pi], [-last, last], [math.pi - last, math.pi]]
    np.testing.assert_allclose(found, expected, atol=1e-11)
    assert degrees(found)[1] == [-72.49, 72.49]
    for tilt, feasible in ((last - 1e-6, True), (last + 1e-6, False)):
        assert hover(OMNIMORPH, tilt, beyond_limits=True).feasible is feasible


# --- other vehicles ----------------------------------------------------------------------------


def test_none_for_vehicles_that_are_not() -> None:
    heavy = OMNIMORPH.replace(mass=2.0)
    for vehicle in (build_star(4), build_star(6, cant=0.5), heavy):
        for zero_moment in (False, True):
            found = omnidirectional_range(vehicle, zero_moment=zero_moment)
            assert found.shape == (0, 2)
    assert omnidirectional_range(heavy, zero_moment=True, beyond_limits=True).shape == (0, 2)
    assert degrees(level_hover_range(heavy)) == [[0.0, 60.0]]
    sinking = OMNIMORPH.replace(mass=4.5)
    assert level_hover_range(sinking, beyond_limits=True).shape == (0, 2)


def test_axes_that_do_not_move() -> None:
    """OmniMorph frozen at its best tilt is omnidirectional, at the one angle it has."""
    best, flat = frozen(OMNIMORPH, BEST), frozen(OMNIMORPH, 0.0)
    for vehicle, expected in ((best, [[0.0, 0.0]]), (flat, [])):
        for beyond in (False, True):
            found = omnidirectional_range(vehicle, zero_moment=True, beyond_limits=beyond)
            assert found.tolist() == expected
            assert level_hover_range(vehicle, beyond_limits=beyond).tolist() == [[0.0, 0.0]]
    assert tilt_of_largest_radius(best) == 0.0
    radius = inscribed_radius(best, [], zero_moment=True)
    assert radius == pytest.approx(inscribed_radius(OMNIMORPH, BEST, zero_moment=True), rel=1e-12)


def test_a_locked_servo_and_limits_apart() -> None:
    locked = OMNIMORPH.replace(servo_angle_min=[0.8], servo_angle_max=[0.8])
    assert omnidirectional_range(locked, zero_moment=True).tolist() == [[0.8, 0.8]]
    apart = build_tilting_star(
        4, servo_angle_min=[-1.0, 0.5, -1.0, -1.0], servo_angle_max=[0.4, 1.0, 1.0, 1.0]
    )
    for question in (level_hover_range, tilt_of_largest_radius):
        with pytest.raises(VehicleError, match="no tilt is within the limits of all 4 servos"):
            question(apart)
    assert len(level_hover_range(apart, beyond_limits=True)) > 0


def test_limits_that_cut_an_interval() -> None:
    for low, high, expected in (
        (45.0, 50.0, [[45.0, 50.0]]),
        (-10.0, 38.0, []),
        (0.0, 90.0, [[38.18, 69.73]]),
        (-60.0, 40.0, [[-60.0, -42.75], [38.18, 40.0]]),
    ):
        vehicle = OMNIMORPH.replace(
            servo_angle_min=np.radians([low]), servo_angle_max=np.radians([high])
        )
        assert degrees(omnidirectional_range(vehicle, zero_moment=True)) == expected


def test_rotors_that_only_push_cannot() -> None:
    """Without reversal OmniMorph's upward rotors hold nothing upside down."""
    pushing = OMNIMORPH.replace(speed_min=np.zeros(8))
    assert omnidirectional_range(pushing, zero_moment=True).shape == (0, 2)
    # six rotors along the axes, ± each: every force of up to f_max √(1/3) or more
    axis = np.vstack([np.eye(3), -np.eye(3)])
    cube = build_vehicle(np.zeros((6, 3)), axis, speed_min=0.0, mass=3.5 / 9.81)
    assert inscribed_radius(cube, [], zero_moment=False) == pytest.approx(3.6, rel=1e-12)
    assert omnidirectional_range(cube, zero_moment=False).tolist() == [[0.0, 0.0]]


def test_level_hover_needs_enough_and_not_too_much_lift() -> None:
    """Rotors that cannot turn slowly lift more than a light vehicle weighs, until they tilt."""
    vehicle = OMNIMORPH.replace(speed_min=0.5 * OMNIMORPH.speed_max, mass=0.5)
    found = level_hover_range(vehicle, beyond_limits=True)
    low = math.acos(0.5 * 9.81 / (8.0 * 0.25 * TOP))
    high = math.acos(0.5 * 9.81 / (8.0 * TOP))
    np.testing.assert_allclose(found, [[-high, -low], [low, high]], atol=1e-9)


def test_ranges_agree_with_hovering() -> None:
    """Inside an interval all attitudes hover level or upside down as asked, outside they do not."""
    for vehicle in (OMNIMORPH, OMNIMORPH.replace(mass=1.0), load_vehicle("omnimorph-2026")):
        ranges = level_hover_range(vehicle, beyond_limits=True)
        for tilt in np.linspace(-3.1, 3.1, 63).tolist():
            inside = bool(((ranges[:, 0] <= tilt) & (tilt <= ranges[:, 1])).any())
            assert hover(vehicle, tilt, beyond_limits=True).feasible is inside
            forces = force_set(vehicle, tilt, zero_moment=True, beyond_limits=True)
            assert forces.contains([0.0, 0.0, vehicle.mass * 9.81]) is inside


# --- the search --------------------------------------------------------------------------------

NARROW = math.radians(0.2)


@pytest.mark.parametrize(
    ("curve", "expected"),
    [
        (lambda x: x - 0.3, [[0.3, 1.0]]),
        (lambda x: 0.3 - x, [[0.0, 0.3]]),
        (lambda x: 1.0, [[0.0, 1.0]]),
        (lambda x: -1.0, []),
        (lambda x: 0.0, [[0.0, 1.0]]),
        (lambda x: (x - 0.25) * (x - 0.75), [[0.0, 0.25], [0.75, 1.0]]),
        (lambda x: -x, [[0.0, 0.0]]),
        (lambda x: x - 1.0, [[1.0, 1.0]]),
        # a peak and a dip between samples half a degree apart
        (lambda x: NARROW - abs(x - 0.5), [[0.5 - NARROW, 0.5 + NARROW]]),
        (lambda x: abs(x - 0.5) - NARROW, [[0.0, 0.5 - NARROW], [0.5 + NARROW, 1.0]]),
        (lambda x: 0.1 * NARROW - abs(x - 0.503), [[0.503 - 0.1 * NARROW, 0.503 + 0.1 * NARROW]]),
        (lambda x: NARROW**2 - (x - 0.507) ** 2, [[0.507 - NARROW, 0.507 + NARROW]]),
        (lambda x: math.cos(40.0 * x) - 0.999, None),
    ],
)
def test_intervals(curve: Curve, expected: list[list[float]] | None) -> None:
    """Ends to 1e-11, of kinks and of smooth curves, steep or not."""
    found = intervals_above_zero(curve, 0.0, 1.0)
    if expected is None:  # seven narrow peaks 9° apart, the first one cut
        half = math.acos(0.999) / 40.0
        peaks = np.arange(7) * math.pi / 20.0
        expected = np.column_stack([peaks - half, peaks + half]).clip(0.0, 1.0).tolist()
    np.testing.assert_allclose(found, np.array(expected).reshape(-1, 2), atol=1e-11)


def test_a_curve_that_touches_zero() -> None:
    """From below, −|x − a| is zero at one point; from above |x − a| everywhere holds."""
    (found,) = intervals_above_zero(lambda x: -abs(x - 0.5), 0.0, 1.0)
    np.testing.assert_allclose(found, 0.5, atol=1e-12)
    touching = intervals_above_zero(lambda x: abs(x - 0.5), 0.0, 1.0)
    np.testing.assert_allclose(touching, [[0.0, 1.0]], atol=1e-12)


@pytest.mark.parametrize(
    ("level", "expected"), [(1.0, [[0.4, 0.4]]), (0.0, [[0.4, 0.4]]), (-1, [])]
)
def test_a_range_of_one_point(level: float, expected: list[list[float]]) -> None:
    assert intervals_above_zero(lambda x: level, 0.4, 0.4).tolist() == expected
    assert lowest_points(lambda x: level, 0.4, 0.4) == [0.4]
    assert highest_point(lambda x: level, 0.4, 0.4) == 0.4


def test_a_range_shorter_than_a_step() -> None:
    end = 0.4 + 1e-3
    found = intervals_above_zero(lambda x: x - 0.4003, 0.4, end)
    np.testing.assert_allclose(found, [[0.4003, end]], atol=1e-12)
    assert lowest_points(lambda x: -x, 0.4, end) == [end]


@pytest.mark.parametrize(
    ("curve", "expected", "accuracy"),
    [
        (lambda x: abs(x - 0.123456789), [0.123456789], 1e-10),
        (lambda x: abs(math.sin(3.0 * x)), [-math.pi / 3.0, 0.0, math.pi / 3.0], 1e-10),
        (lambda x: 0.3 + abs(x - 0.2), [0.2], 1e-8),
        (lambda x: (x - 0.2) ** 2 - 5.0, [0.2], 1e-7),
        (lambda x: x, [-1.2], 0.0),
        (lambda x: -x, [1.2], 0.0),
        (lambda x: -(x**2), [-1.2, 1.2], 0.0),
        (lambda x: 2.0 * abs(x - 0.5) if x < 0.5 else 50.0 * abs(x - 0.5), [0.5], 3e-8),
        (lambda x: abs(x - 0.5) * abs(x + 0.5), [-0.5, 0.5], 1e-10),
    ],
)
def test_lowest_points(curve: Curve, expected: list[float], accuracy: float) -> None:
    found = lowest_points(curve, -1.2, 1.2)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=accuracy)


@pytest.mark.parametrize(
    ("curve", "expected"),
    [
        (lambda x: math.cos(6.0 * x), 0.0),
        (lambda x: math.cos(6.0 * (x - 0.3)), 0.3),  # its equal at −0.747 is farther from 0
        (lambda x: math.cos(6.0 * abs(x) - 3.0), 0.5),  # of −0.5 and 0.5 the positive one
        (lambda x: x, 1.2),
        (lambda x: -abs(x + 0.321), -0.321),
    ],
)
def test_highest_point(curve: Curve, expected: float) -> None:
    assert highest_point(curve, -1.2, 1.2) == pytest.approx(expected, abs=1e-7)


def test_the_tilt_is_checked() -> None:
    bad: list[tuple[Vehicle, float]] = [(OMNIMORPH, 1.1), (OMNIMORPH, math.nan)]
    for vehicle, tilt in bad:
        with pytest.raises(VehicleError, match="tilt is"):
            inscribed_radius(vehicle, tilt, zero_moment=True)
