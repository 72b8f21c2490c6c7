"""Any number of a scenario varies in a batch, each flight as alone, or a sentence says why not."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.physics.test_many_flights import NOISE, assert_metrics, assert_same
from tests.unit.test_paths import EVERY_EFFECT

import omnimorph as om
from omnimorph import effects
from omnimorph.errors import InputError, TooLargeError
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.run import COLUMNS
from omnimorph.simulation.core_rows import CoreRows, numbers_of_core
from omnimorph.simulation.core_settings import core_settings_of
from omnimorph.simulation.paths import paths, replaced, shape_at, value_at
from omnimorph.simulation.variation import SHARED, draw, numbers_of_a_flight

SHORT = SegmentReference(np.array([0.0, 0.0, 1.0]), np.eye(3), [Segment(0.06, (0.01, 0.0, 0.02))])
HOVER = replace(om.load_scenario("hover"), reference=SHORT)
OF_VEHICLE = (  # effects whose numbers are the vehicle's own
    effects.RotorLag(),
    effects.SpeedLimits(),
    effects.DeadBand(),
    effects.ServoLag(),
    effects.ServoRateLimit(),
    effects.RotorMomentum(),
    effects.MeasurementNoise(position=1e-3, rate=1e-2, filtered=True),
)


def in_plant(scenario: om.Scenario, *worn: effects.Effect) -> om.Scenario:
    return replace(scenario, plant=om.PlantModel(control_period=2e-3, effects=worn))


def rich() -> dict[str, om.Scenario]:
    """Return scenarios in which, together, nearly every number counts."""
    vehicle = HOVER.vehicle.replace(
        dead_band=600.0 + np.arange(8.0),  # about as fast as they turn in hover
        time_constant_up=np.full(8, 0.02),
        time_constant_down=np.full(8, 0.03),
        servo_time_constant=np.full(1, 0.001),  # so that its rate limit is reached
        filter_cutoff=np.full(4, 60.0),
    )
    paper = HOVER.allocator
    weights = {name: getattr(paper, name) for name in ("W1", "W2_attitude", "W3")}
    rule = om.ExhaustiveTilt(**weights, W2_position=(3e4, 2.9e4, 2.8e4), span="range", candidates=5)
    other = replace(HOVER, vehicle=vehicle, allocator=rule, start_tilt=0.03)
    own = in_plant(other, *OF_VEHICLE)
    return {"every effect": in_plant(HOVER, *EVERY_EFFECT), "the vehicle's own": own}


RICH = rich()
EVERY_PATH = list(dict.fromkeys(path for scenario in RICH.values() for path in paths(scenario)))
WITHOUT_EFFECT = {
    "vehicle.tilt_mechanism_mass": "a part of the mass, on which no flight depends",
    "truth.tilt_mechanism_mass": "the same",
    "vehicle.servo_angle_max": "far from the tilts that are flown here",
    "truth.servo_angle_min": "no servo is commanded past what the controller believes",
    "truth.servo_angle_max": "the same",
    "plant.dead-band.reversal_time": "no rotor reverses here",
}


@cache
def plain(name: str) -> om.Run:
    return om.fly(RICH[name], seed=3, flight=1)


def another(scenario: om.Scenario, path: str) -> Any:
    """Return other numbers for a path that are possible, not all by the same factor."""
    known = value_at(scenario, path)
    if known is None:  # the effect takes the vehicle's
        return np.array({"plant.speed-limits.largest": 600.0}.get(path, 0.015))
    value = np.array(np.broadcast_to(known, shape_at(scenario, path)))
    if path.endswith("angle_min"):
        return value - 1e-3
    if path.endswith("_axis"):  # which stay of unit length
        return value + 1e-3 * value[:, [1, 2, 0]]
    if path.endswith("inertia") and value.ndim == 2:
        return value * np.diag([1.01, 1.02, 1.03])
    less = 0.99 - 0.01 * np.arange(value.size).reshape(value.shape) / max(value.size, 1)
    if path.endswith("W2_position") and (value == value[0]).all():  # which must stay so
        less = less[0]
    return np.where(value == 0.0, 1e-3, value * less)


def differ(run: om.Run, other: om.Run) -> bool:
    """Return whether two flights differ in any bit of what is recorded."""
    names = [column.name for column in COLUMNS]
    return any(getattr(run, one).tobytes() != getattr(other, one).tobytes() for one in names)


def assert_as_alone(flights: om.Flights, row: int, scenario: om.Scenario) -> om.Run:
    """Compare a flight of a batch with that of a scenario, bit by bit; return the latter."""
    number = int(flights.number[row])
    run, alone = flights.runs[number], om.fly(scenario, seed=flights.seed, flight=number)
    assert_same(run, alone)
    np.testing.assert_array_equal(run.drag_power, alone.drag_power)
    assert_metrics(flights, row, alone)
    assert run.vehicle.mass == alone.vehicle.mass
    assert run.provenance.vehicle_text == alone.provenance.vehicle_text
    reported = dict(run.provenance.scenario)
    assert reported.pop("vary", {}).keys() == flights.varied.keys()
    assert reported == alone.provenance.scenario
    return alone


@pytest.mark.parametrize("path", EVERY_PATH)
def test_each_number_varies_as_alone_or_is_refused_with_a_reason(path: str) -> None:
    moved = False
    for name, scenario in RICH.items():
        if path not in paths(scenario):
            continue
        value = another(scenario, path)
        own = value_at(scenario, path)
        rows = np.stack([np.broadcast_to(value if own is None else own, value.shape), value])
        if path in SHARED:
            with pytest.raises(InputError, match=r"cannot vary, because .* batch"):
                om.fly_many(scenario, 2, vary={path: rows})
            continue
        flights = om.fly_many(scenario, 2, seed=3, vary={path: rows}, keep=[1], threads=1)
        alone = assert_as_alone(flights, 1, replaced(scenario, {path: value}))
        moved |= differ(alone, plain(name))
    assert moved is (path not in SHARED | WITHOUT_EFFECT.keys())


# --- several at once, with keys, in other vehicles, in single precision ---------------------------


def weighing(rule: Any, **more: Any) -> Any:
    paper = HOVER.allocator
    names = ("W1", "W2_position", "W2_attitude", "W3")
    return rule(**{name: getattr(paper, name) for name in names}, **more)


def others() -> dict[str, om.Scenario]:
    """Return scenarios of other vehicles, rules and numbers of rotors and servos."""
    jointly, fixed = weighing(om.JointTilt, W4=0.01), weighing(om.FixedTilt)
    quadrotor, tilt_hex = (
        replace(HOVER, vehicle=om.load_vehicle(name), allocator=fixed)
        for name in ("quadrotor", "tilt-hex")
    )
    voliro = replace(HOVER, vehicle=om.load_vehicle("voliro"), allocator=jointly)
    return {
        "no servo": in_plant(quadrotor, NOISE, effects.RotorLag(up=0.02)),
        "position first": replace(in_plant(tilt_hex, NOISE), attitude_gives_way=True),
        "several servos": in_plant(voliro, NOISE),
        "jointly": in_plant(replace(HOVER, allocator=jointly), NOISE),
        "fixed": in_plant(replace(HOVER, allocator=fixed, start_tilt=0.7), NOISE),
        "wakes": replace(in_plant(HOVER, effects.Interference(), NOISE), start_tilt=0.2),
    }


OTHERS = others()
SPREAD = {
    "vehicle.mass": (0.97, 1.03),
    "vehicle.rotor_position": (0.99, 1.01),
    "vehicle.thrust_coefficient": (0.95, 1.05),
    "truth.thrust_coefficient[2]": (0.9, 1.1),
    "truth.drag_coefficient": (0.9, 1.1),
    "plant.measurement-noise.position": (0.5, 2.0),
    "controller.position": (0.8, 1.2),
    "controller.allocator.W1": (0.5, 2.0),
}


def spread(scenario: om.Scenario, flights: int, *without: str) -> dict[str, Any]:
    """Return numbers for flights, around those of the scenario."""
    drawn, generator = {}, np.random.default_rng(5)
    for path, (low, high) in SPREAD.items():
        if path not in without:
            shape = (flights, *shape_at(scenario, path))
            around = np.asarray(value_at(scenario, path), dtype=np.float64)
            drawn[path] = around * generator.uniform(low, high, shape)
    return drawn


@pytest.mark.parametrize("name", OTHERS)
def test_several_numbers_vary_together(name: str) -> None:
    scenario = OTHERS[name]
    in_line = ("vehicle.rotor_position",) if name == "wakes" else ()
    vary = spread(scenario, 3, *in_line)
    flights = om.fly_many(scenario, 3, seed=8, first=4, vary=vary, keep="all")
    for row in range(3):
        mine = replaced(scenario, {path: rows[row] for path, rows in vary.items()})
        assert_as_alone(flights, row, mine)


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize(
    "scenario", [RICH["every effect"], *OTHERS.values()], ids=["rich", *OTHERS]
)
def test_keys_act_upon_what_paths_make(scenario: om.Scenario, precision: Any) -> None:
    """A batch of both, against batches of one flight of what the paths make, with its keys."""
    paths_alone = spread(scenario, 3, "vehicle.rotor_position")
    keys = {name: np.linspace(0.9, 1.1, 3) for name in ("mass", "inertia", "noise")}
    for name in ("force", "torque", "centre_of_mass", "start_position", "start_attitude"):
        keys[name] = np.linspace(-1e-3, 1e-3, 9).reshape(3, 3)
    for name in ("effectiveness", "drag_coefficient"):
        keys[name] = np.linspace(0.9, 1.0, 3 * scenario.vehicle.n_rotors).reshape(3, -1)
    wanted: dict[str, Any] = {"seed": 6, "keep": "all", "precision": precision}
    flights = om.fly_many(scenario, 3, vary=paths_alone | keys, **wanted)
    for row in range(3):
        mine = replaced(scenario, {path: rows[row] for path, rows in paths_alone.items()})
        own = {name: rows[row : row + 1] for name, rows in keys.items()}
        (run,) = om.fly_many(mine, 1, first=row, vary=own, **wanted).runs.values()
        assert_same(flights.runs[row], run)
        np.testing.assert_array_equal(flights.runs[row].drag_power, run.drag_power)


def test_a_key_is_a_factor_of_what_a_path_gives() -> None:
    scenario = OTHERS["fixed"]
    vary = {"mass": np.array([1.0, 1.25]), "vehicle.mass": np.array([1.3, 1.4])}
    flights = om.fly_many(scenario, 2, vary=vary, keep="all")
    values = {"vehicle.mass": 1.4, "truth.mass": 1.25 * 1.4}
    assert_same(flights.runs[1], om.fly(replaced(scenario, values), flight=1))


def test_what_position_first_counts_on_follows_the_vehicle() -> None:
    scenario = OTHERS["position first"]
    vary = {"vehicle.mass": np.array([1.2, 1.3]), "truth.mass": np.array([1.3, 1.3])}
    flights = om.fly_many(scenario, 2, vary=vary, keep="all")
    forces = set()
    for row in range(2):
        mine = replaced(scenario, {path: values[row] for path, values in vary.items()})
        forces.add(mine.lateral_force)
        assert_as_alone(flights, row, mine)
    assert len(forces) == 2


def test_a_scenario_made_of_whole_numbers_varies_by_broken_ones() -> None:
    worn = (effects.SineWrench(force=(1, 0, 0), frequency=9), effects.RotorLag(up=0, down=1))
    scenario = in_plant(replace(HOVER, start_tilt=0), *worn)
    for path in ("plant.sine-wrench.force[0]", "plant.rotor-lag.down", "start_tilt"):
        flights = om.fly_many(scenario, 2, vary={path: [0.25, 0.75]}, keep="all")
        assert_as_alone(flights, 1, replaced(scenario, {path: 0.75}))


# --- memory and provenance ------------------------------------------------------------------------


def test_rows_that_no_memory_holds_are_refused() -> None:
    parts = core_settings_of(HOVER)
    rows = CoreRows(parts, HOVER, 10**13)
    heavier = numbers_of_core(replaced(HOVER, {"vehicle.mass": 1.4}), parts.start)
    with pytest.raises(TooLargeError, match="flights with 1 numbers of their own each need about"):
        rows.put(1, heavier)


def test_numbers_are_counted_before_they_are_drawn() -> None:
    wanted = {"mass": 1, "force": 3, "truth.mass": 1, "truth.rotor_position": 24, "start_tilt": 1}
    for name, count in wanted.items():
        assert numbers_of_a_flight({name: om.Uniform(0.0, 1.0)}, HOVER) == count
    assert numbers_of_a_flight(wanted, HOVER) == sum(wanted.values())


def test_only_what_differs_becomes_rows() -> None:
    parts = core_settings_of(HOVER)
    drawn = draw({"truth.mass": om.Uniform(1.3, 1.4)}, HOVER, 0, 0, 5)
    (path,) = rows = drawn.for_core(parts)
    assert path == "plant.vehicle.mass"
    np.testing.assert_array_equal(rows[path][:, 0], drawn.drawn["truth.mass"])


def test_a_kept_run_says_what_was_varied_and_is_of_its_own_vehicle() -> None:
    vary: dict[str, Any] = {"vehicle.mass": [1.3, 1.4], "truth.drag_coefficient[0]": [1e-8, 2e-8]}
    run = om.fly_many(HOVER, 2, vary=vary, keep=[1]).runs[1]
    text = run.provenance.scenario_text
    assert json.loads(text)["vary"] == {"vehicle.mass": 1.4, "truth.drag_coefficient[0]": 2e-8}
    assert json.loads(text)["plant"]["effects"][-1]["kind"] == "truth"
    assert run.vehicle.mass == 1.4
    cubes = np.abs(run.speed) ** 3
    drag = HOVER.vehicle.drag_coefficient.copy()
    drag[0] = 2e-8
    np.testing.assert_allclose(run.drag_power, cubes @ drag, rtol=1e-12)
