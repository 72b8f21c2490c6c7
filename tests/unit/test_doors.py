"""Wherever a record is asked for its name or file will do; the rest is refused in a sentence."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import omnimorph as om
from omnimorph.design import vehicle_text

RECORDS = (
    "vehicle",
    "scenario",
    "plant",
    "gains",
    "rule",
    "allocator",
    "reference",
    "bench",
    "parts",
)
NOT_RECORDS: list[Any] = [3, None, [1], b"omnimorph", {}]
ROOMS: list[Any] = [om, om.analysis, om.identification]


def doors() -> Iterator[tuple[str, Callable[..., Any], str]]:
    """Yield the name, the callable and the argument of all that takes a record from a user."""
    for room in ROOMS:
        for name in room.__all__:
            thing = getattr(room, name)
            if inspect.isfunction(thing) or inspect.isclass(thing):
                for argument in RECORDS:
                    if argument in arguments_of(thing) and (name, argument) not in NO_DOORS:
                        yield f"{room.__name__}.{name}", thing, argument
    yield "Scenario.for_vehicle", om.load_scenario("hover").for_vehicle, "vehicle"
    yield "SteppedFlight.change_controller", om.SteppedFlight("hover").change_controller, "scenario"


def arguments_of(door: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    """Return what a callable takes; nothing of what does not tell."""
    try:
        return inspect.signature(door).parameters
    except ValueError:
        return {}


NO_DOORS = {  # results hold what they are of; nobody builds one
    ("Run", "vehicle"),
    ("ProposedController", "gains"),
    ("ProposedController", "allocator"),
    ("RotorFit", "bench"),
}
DOORS = list(doors())
CASES = [
    (name, door, argument, wrong)
    for name, door, argument in DOORS
    for wrong in NOT_RECORDS
    if wrong is not None or arguments_of(door)[argument].default is not None
]


def test_there_are_doors() -> None:
    names = {name for name, _, _ in DOORS}
    assert {"omnimorph.fly", "omnimorph.fly_many", "omnimorph.SteppedFlight"} <= names
    assert {"omnimorph.allocation_matrix", "omnimorph.analysis.hover"} <= names
    assert {"omnimorph.PoseController", "omnimorph.identification.assemble"} <= names
    assert len(DOORS) > 44


@pytest.mark.parametrize(("name", "door", "argument", "wrong"), CASES)
def test_other_types_are_reported(
    name: str, door: Callable[..., Any], argument: str, wrong: object
) -> None:
    arguments = arguments_of(door)
    given: dict[str, Any] = {
        key: None for key, one in arguments.items() if one.default is inspect.Parameter.empty
    }
    given |= {key: known for key, known in GOOD.items() if key in arguments}
    given |= {argument: wrong}
    with pytest.raises(om.OmnimorphError) as caught:
        door(**given)
    sentence = str(caught.value)
    assert {"rule": "allocator"}.get(argument, argument) in sentence
    assert re.search("but it must be an? ", sentence)
    assert sentence.isprintable()


HOVER = om.load_scenario("hover")
GOOD: dict[str, Any] = {
    "name": "mine",
    "scenario": "hover",
    "vehicle": "omnimorph",
    "plant": "perfect",
    "gains": HOVER,
    "rule": HOVER,
    "allocator": HOVER,
    "reference": HOVER.reference,
    "control_period": 0.004,
    "tilt": np.zeros((1, 1)),
}


def test_names_and_files_are_as_good_as_records(tmp_path: Path) -> None:
    vehicle = om.load_vehicle("omnimorph")
    file = tmp_path / "mine.toml"
    file.write_text(vehicle_text(vehicle), encoding="utf-8")
    for like in (vehicle, "omnimorph", file, str(file)):
        assert (om.allocation_matrix(like, 0.3) == om.allocation_matrix(vehicle, 0.3)).all()
        assert om.analysis.hover(like, 0.3).power == om.analysis.hover(vehicle, 0.3).power
        assert om.propose_controller(like) == om.propose_controller(vehicle)
    scenario = om.load_scenario("hover")
    whole = om.fly(scenario, plant="perfect")
    assert om.fly("hover", plant=om.load_plant("perfect")).content_hash == whole.content_hash
    many = om.fly_many("hover", 2, plant="perfect", keep=[0])
    assert many.runs[0].content_hash == whole.content_hash
    assert om.SteppedFlight("hover").duration == om.SteppedFlight(scenario).duration
    assert scenario.for_vehicle("omnimorph").vehicle.name == "omnimorph"


def test_gains_and_rules_may_be_in_a_scenario_or_a_proposal() -> None:
    proposal = om.propose_controller("omnimorph")
    margins = om.stability_margins(proposal.gains, "omnimorph")
    assert (om.stability_margins(proposal, "omnimorph").crossover == margins.crossover).all()
    level = np.concatenate([np.zeros(3), np.eye(3).ravel(), np.zeros(6)])
    steps = [level], np.zeros((1, 6)), np.zeros((1, 8)), [[0.1, 0.2]]
    cost = om.cost_over_tilt("omnimorph", HOVER.allocator, *steps)
    assert (om.cost_over_tilt("omnimorph", HOVER, *steps) == cost).all()
    state = om.State(*HOVER.reference(0.0)[:4])
    hold = [
        om.PoseController("omnimorph", gains, rule, 0.004)(0.0, state, HOVER.reference(0.0))
        for gains, rule in ((HOVER, HOVER), (HOVER.gains, HOVER.allocator))
    ]
    assert (hold[0].thrust == hold[1].thrust).all()
    mine = om.Scenario(
        name="mine",
        vehicle="omnimorph",  # type: ignore[arg-type]
        plant="perfect",  # type: ignore[arg-type]
        gains=proposal,  # type: ignore[arg-type]
        allocator=proposal,  # type: ignore[arg-type]
        reference=HOVER.reference,
    )
    assert (mine.gains, mine.allocator) == (proposal.gains, proposal.allocator)


def test_files_are_as_good_as_what_they_hold(tmp_path: Path) -> None:
    poses = tmp_path / "poses.csv"
    poses.write_text("time_s,x_m,y_m,z_m\n0,0,0,1\n1,0.1,0,1\n2,0,0,1\n")
    moved = dataclasses.replace(HOVER, reference=poses)  # type: ignore[arg-type]
    assert moved.reference.duration == 2.0
    parts = tmp_path / "parts.toml"
    parts.write_text('[[part]]\nkind = "point"\nmass_kg = 0.4\n')
    assert om.identification.assemble(parts).mass == 0.4
    speed = np.linspace(100.0, 800.0, 50)
    rows = [f"{k},{w},{1e-5 * w * w},{1.5e-7 * w * w}" for k, w in enumerate(speed.tolist())]
    bench = tmp_path / "bench.csv"
    bench.write_text("\n".join(["time_s,speed_rad_per_s,force_N,torque_Nm", *rows]))
    fit = om.identification.fit_rotor(bench)
    assert fit.thrust.value.value == pytest.approx(1e-5)
    assert (
        om.identification.fit_rotor(om.identification.read_bench(bench)).thrust.value
        == fit.thrust.value
    )


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"vary": [1]}, "fly_many: vary is [1], but it must be a mapping from some of mass, "),
        (
            {"plant": 3},
            "fly: plant is 3, but it must be a PlantModel, the name or file of one, ",
        ),
        ({"keep": 3}, "fly_many: keep is 3, but it must be numbers of flights"),
    ],
)
def test_fly_many_tells_what_it_does_not_take(changes: dict[str, Any], expected: str) -> None:
    with pytest.raises(om.InputError) as caught:
        om.fly_many("hover", 2, **changes)
    assert str(caught.value).startswith(expected)


@pytest.mark.parametrize("part", ["controller", "allocator", "reference", "disturbance"])
def test_a_part_that_cannot_be_called(part: str) -> None:
    with pytest.raises(om.InputError, match=rf"{part} is 3, but it must be a"):
        om.fly("hover", **{part: 3})  # type: ignore[arg-type]


@pytest.mark.parametrize("field", ["gains", "allocator", "reference"])
def test_a_scenario_of_other_parts(field: str) -> None:
    with pytest.raises(om.InputError, match=f'{field} is "x", but it must be '):
        dataclasses.replace(om.load_scenario("hover"), **{field: "x"})  # type: ignore[arg-type]


def test_tilts_that_no_servo_has() -> None:
    for tilt in (1e300, -1e300, np.nan, np.inf, "x", 10**400, [[1.0]]):
        with pytest.raises(om.InputError, match=r"tilt is .* at most 1745.33"):
            om.allocation_matrix("omnimorph", tilt)


def test_times_that_no_loop_has() -> None:
    for period in (1e-300, 1e154, np.nan, "x"):
        with pytest.raises(om.InputError, match=r"control_period is .* from 1e-9 to 10"):
            om.propose_controller("omnimorph", period)  # type: ignore[arg-type]
