"""Everything at once: `analyze` of vehicles that can do much, little or nothing."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star, build_tilting_star, build_vehicle

import omnimorph as om
from omnimorph.analysis import analyze, hover, mass_break_even, tilt_sweep
from omnimorph.analysis.actuation import ActuationKind, ThrustKind
from omnimorph.analysis.overview import VehicleAnalysis
from omnimorph.analysis.polytope import Polytope
from omnimorph.design import Vehicle, load_vehicle
from omnimorph.errors import VehicleError

OMNIMORPH = load_vehicle("omnimorph")
WEIGHT = 1.315 * 9.81
PAIR = [[0.0, 0.0, 0.05], [0.0, 0.0, -0.05]]

VEHICLES: dict[str, Vehicle] = {
    "omnimorph": OMNIMORPH,
    "quadrotor": build_star(4, mass=0.8),
    "one rotor": build_vehicle([[0.0, 0.0, 0.0]], mass=0.2),
    "one rotor aside": build_vehicle([[0.1, 0.0, 0.0]], mass=0.2),
    "too heavy": build_star(6, mass=3.0),
    "coincident": build_vehicle(
        [[0.1, 0.1, 0.0]] * 4, rotor_spin=[1.0, -1.0, 1.0, -1.0], speed_min=0.0, mass=0.8
    ),
    "coaxial": build_vehicle(PAIR, rotor_spin=[1.0, -1.0], speed_min=0.0, mass=0.4),
    "lying": build_vehicle([[0.2, 0.0, 0.0]] * 2, axis=[[1.0, 0.0, 0.0]] * 2),
    "independent": build_tilting_star(6, mass=1.2, servo_angle_min=-0.5, servo_angle_max=0.5),
    "locked": OMNIMORPH.replace(servo_angle_min=[0.9], servo_angle_max=[0.9]),
    "heavy omnimorph": OMNIMORPH.replace(mass=4.5),
}


@cache
def analysis_of(name: str) -> VehicleAnalysis:
    """Analyse one of the vehicles, once."""
    return analyze(VEHICLES[name])


def numbers_in(value: Any, where: str) -> Iterator[tuple[str, Any]]:
    """Go through all numbers and arrays of a record, those of sets as well."""
    if isinstance(value, np.ndarray | float | int):
        yield where, value
    elif isinstance(value, Polytope):
        for name in ("vertices", "normals", "offsets", "volume", "inscribed_radius", "dimension"):
            yield f"{where}.{name}", getattr(value, name)
    elif isinstance(value, tuple):
        for index, item in enumerate(value):
            yield from numbers_in(item, f"{where}[{index}]")
    elif dataclasses.is_dataclass(value) and not isinstance(value, Vehicle):
        for field in dataclasses.fields(value):
            yield from numbers_in(getattr(value, field.name), f"{where}.{field.name}")


MAY_BE_INFINITE = {"power", "power_still", "level_power", "condition_number", "share"}
MAY_BE_INFINITE |= {"share_in_wakes", "hover_power"}


@pytest.mark.parametrize("name", VEHICLES)
def test_every_number_is_one(name: str) -> None:
    """No NaN anywhere; infinite are only powers and condition numbers that do not exist."""
    found = list(numbers_in(analysis_of(name), "analysis"))
    assert len(found) > 60
    for where, value in found:
        assert not np.isnan(value).any(), where
        assert np.isfinite(value).all() or where.split(".")[-1] in MAY_BE_INFINITE, where


@pytest.mark.parametrize("name", VEHICLES)
def test_its_parts_agree(name: str) -> None:
    analysis = analysis_of(name)
    vehicle, weight = analysis.vehicle, analysis.weight
    assert weight == pytest.approx(vehicle.mass * 9.81, rel=1e-12)
    assert analysis.asked in analysis.at
    low, high = analysis.limits
    for one in analysis.at:
        assert (one.tilt >= low - 1e-9).all()
        assert (one.tilt <= high + 1e-9).all()
        assert one.hover.feasible == one.hover_norm.feasible
        assert one.hover.feasible == one.force_zero.contains([0.0, 0.0, weight])
        assert one.hover.power <= one.hover_norm.power * (1.0 + 1e-9)
        assert one.force_zero.inscribed_radius <= one.force_free.inscribed_radius * (1.0 + 1e-9)
        assert all(one.force_free.contains(vertex) for vertex in one.force_zero.vertices)
        if one.hover.feasible:
            assert one.moment.contains(np.zeros(3))
        assert one.force_free.contains([0.0, 0.0, weight]) != one.moment.is_empty
        omnidirectional = one.actuation.thrust_kind is ThrustKind.OMNIDIRECTIONAL
        assert omnidirectional == (one.force_zero.inscribed_radius >= weight * (1.0 - 1e-9))
    limits = analysis.omnidirectional
    for inside, beyond in (
        (limits.free_moment, limits.free_moment_beyond),
        (limits.zero_moment, limits.zero_moment_beyond),
        (limits.level, limits.level_beyond),
    ):
        assert ((inside >= low) & (inside <= high)).all()
        assert len(inside) <= len(beyond)
    sweep = analysis.sweep
    np.testing.assert_array_equal(np.isinf(sweep.condition_number), sweep.rank_thrust < 6)
    assert (sweep.radius_zero_moment <= sweep.radius_free_moment * (1.0 + 1e-9) + 1e-12).all()
    assert sweep.tilt[0] == low
    assert analysis.hover_map.power.shape == (100, len(analysis.hover_map.tilt))


# --- one by one --------------------------------------------------------------------------------


def test_omnimorph() -> None:
    analysis = analysis_of("omnimorph")
    assert analysis.limits == pytest.approx((0.0, math.pi / 3.0), abs=1e-15)
    reasons = {round(math.degrees(one.tilt[0]), 2) + 0.0: one.why for one in analysis.at}
    assert len(reasons) == 4
    assert reasons[0.0] == "least tilt, rank 4"
    assert reasons[38.18] == "omnidirectional from here"
    assert reasons[60.0] == "largest tilt, up to here"
    assert [(round(math.degrees(one.tilt)), one.rank) for one in analysis.singular] == [
        (-90, 5),
        (0, 4),
        (90, 5),
        (180, 4),
    ]
    assert analysis.asked.why == "largest radius"
    sweep = analysis.sweep
    assert math.degrees(sweep.tilt[-1]) == pytest.approx(90.0)
    best = sweep.tilt[np.argmax(sweep.radius_zero_moment)]
    assert best == pytest.approx(analysis.asked.tilt[0], abs=0.01)
    assert analysis.hover_map.feasible.all()
    trade, wakes = analysis.trade, analysis.wakes
    assert trade is not None
    assert wakes is not None
    np.testing.assert_allclose(trade.share, mass_break_even(trade.tilt_fixed), atol=1e-11)
    assert (trade.share_in_wakes <= trade.share + 1e-9).all()
    assert trade.own == pytest.approx(0.187 / 1.128)
    crossings = trade.break_even or 0.0, trade.break_even_in_wakes or 0.0
    assert np.degrees(crossings) == pytest.approx([30.93, 40.44], abs=5e-3)
    np.testing.assert_array_equal(wakes.pairs, [[0, 4], [1, 5], [2, 6], [3, 7]])
    assert (wakes.power >= wakes.power_still).all()
    assert (wakes.radius <= wakes.radius_still + 1e-9).all()


@pytest.mark.parametrize(
    ("name", "rank", "hovers"),
    [
        ("quadrotor", 4, True),
        ("one rotor", 1, False),  # its drag would turn it
        ("one rotor aside", 1, False),
        ("too heavy", 4, False),
        ("coincident", 2, False),  # beside the centre of mass
        ("coaxial", 2, True),
        ("lying", 1, False),
    ],
)
def test_vehicles_without_servos(name: str, rank: int, hovers: bool) -> None:
    analysis = analysis_of(name)
    (only,) = analysis.at
    assert only is analysis.asked
    assert (only.actuation.rank_thrust, only.actuation.rank_full) == (rank, rank)
    assert only.actuation.kind is ActuationKind.UNDER_ACTUATED
    one_way = name in ("quadrotor", "too heavy", "coaxial")
    kind = ThrustKind.UNI_DIRECTIONAL if one_way else ThrustKind.NONE
    assert only.actuation.thrust_kind is kind
    assert only.hover.feasible is hovers
    limits = analysis.omnidirectional
    assert limits.zero_moment.shape == limits.free_moment_beyond.shape == (0, 2)
    assert limits.level.tolist() == ([[0.0, 0.0]] if hovers else [])
    assert analysis.limits == (0.0, 0.0)
    assert analysis.singular == ()
    assert len(analysis.sweep.tilt) == len(analysis.hover_map.tilt) == 1
    assert analysis.trade is None
    assert (analysis.wakes is not None) == (name == "coaxial")
    # of a hundred attitudes none is level
    assert not analysis.hover_map.feasible.any()


def test_a_tilting_rotor_of_its_own_each() -> None:
    analysis = analysis_of("independent")
    asked = analysis.asked
    assert asked.tilt.shape == (6,)
    assert (asked.actuation.rank_full, asked.actuation.kind) == (6, ActuationKind.FULLY_ACTUATED)
    assert analysis.trade is not None
    assert analysis.trade.own is None
    found = [(round(math.degrees(one.tilt), 4) + 0.0, one.rank) for one in analysis.singular]
    assert found == [(-90.0, 5), (0.0, 4), (90.0, 5), (180.0, 4)]


def test_a_locked_servo() -> None:
    analysis = analysis_of("locked")
    assert analysis.limits == (0.9, 0.9)
    (only,) = analysis.at
    assert {"least tilt", "largest tilt", "largest radius"} <= set(only.why.split(", "))
    assert analysis.omnidirectional.zero_moment.tolist() == [[0.9, 0.9]]
    assert only.actuation.thrust_kind is ThrustKind.OMNIDIRECTIONAL


def test_too_heavy_to_hover() -> None:
    analysis = analysis_of("heavy omnimorph")
    assert analysis.omnidirectional.level_beyond.shape == (0, 2)
    assert not any(one.hover.feasible for one in analysis.at)
    assert all(one.moment.is_empty for one in analysis.at)
    assert np.isinf(analysis.sweep.level_power).all()
    assert not analysis.hover_map.feasible.any()
    assert analysis.wakes is not None
    assert np.isinf(analysis.wakes.power).all()
    assert analysis.trade is None


# --- the tilt asked for, and progress ----------------------------------------------------------


def test_the_tilt_asked_for() -> None:
    pair = build_tilting_star(2, servo_angle_min=-0.5, servo_angle_max=0.5)
    analysis = analyze(pair, [0.1, -0.1])
    assert analysis.asked.why == "asked for"
    assert analysis.asked is analysis.at[-1]
    np.testing.assert_array_equal(analysis.asked.tilt, [0.1, -0.1])
    with pytest.raises(VehicleError, match="tilt is 60°, but it must be from -28"):
        analyze(pair, math.radians(60.0))
    beyond = analyze(pair, math.radians(60.0), beyond_limits=True)
    assert beyond.asked.why == "asked for"
    np.testing.assert_allclose(beyond.asked.tilt, math.radians(60.0))
    assert beyond.limits == (-0.5, 0.5)


@pytest.mark.parametrize("tilt", [math.nan, math.inf, [0.1, 0.2]])
def test_tilts_that_cannot_be_used(tilt: Any) -> None:
    with pytest.raises(VehicleError, match="tilt is"):
        analyze(OMNIMORPH, tilt)


def test_servos_without_a_common_tilt() -> None:
    """One sentence, before anything is worked out, that says what to do."""
    apart = VEHICLES["independent"].replace(
        servo_angle_min=np.array([0.2, 0.0, 0.0, 0.0, 0.0, 0.0]),
        servo_angle_max=np.array([0.5, 0.1, 0.1, 0.1, 0.1, 0.1]),
    )
    reported: list[str] = []
    with pytest.raises(VehicleError) as refused:
        analyze(apart, progress=lambda done, of, label: reported.append(label))
    assert reported == []
    assert str(refused.value).count("\n") == 0
    assert "no tilt is within the limits of all 6 servos" in str(refused.value)
    assert om.analysis.actuation(apart, [0.3, 0.0, 0.0, 0.0, 0.0, 0.0]).rank_full == 6


def test_progress_is_reported_in_order() -> None:
    reported: list[tuple[float, float, str]] = []
    analyze(VEHICLES["coaxial"], progress=lambda *words: reported.append(words))
    done, of, labels = zip(*reported, strict=True)
    assert done == tuple(range(len(reported)))
    assert set(of) == {len(reported)}
    assert len(set(labels)) == len(reported)


def test_a_sweep_is_its_questions_one_by_one() -> None:
    tilts = np.radians([0.0, 20.0, 54.7356, 85.0])
    sweep = tilt_sweep(OMNIMORPH, tilts, beyond_limits=True)
    assert sweep.rank_thrust.tolist() == [4, 6, 6, 6]
    powers = [hover(OMNIMORPH, tilt, beyond_limits=True).power for tilt in tilts]
    np.testing.assert_array_equal(sweep.level_power, powers)
    np.testing.assert_allclose(sweep.largest_lift, 8.0 * 5.3587 * np.cos(tilts), rtol=1e-9)
    np.testing.assert_allclose(sweep.radius_zero_moment[1:3] / 5.3587, [1.3439, 3.1543], atol=5e-5)
    with pytest.raises(VehicleError, match="tilt is 85°"):
        tilt_sweep(OMNIMORPH, tilts)


def test_public_names() -> None:
    """All of them can be had from `om.analysis`, and none twice."""
    names = om.analysis.__all__
    assert len(set(names)) == len(names)
    for name in names:
        assert callable(getattr(om.analysis, name))
        assert getattr(om.analysis, name).__doc__
