"""Parts of the loop that a scenario file names: they fly if code is allowed, and only then."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.unit.own_objects import SHORT, differing, wall

import omnimorph as om

MODULE = """
import numpy as np
import omnimorph as om

{first}


class Steady:
    def __init__(self, scenario, thrust=1.6):
        self.thrust = np.full(scenario.vehicle.n_rotors, thrust)
        self.tilt = scenario.tilt

    def __call__(self, time, state, desired):
        return om.Command(self.thrust, self.tilt, log={{"thrust": self.thrust[0]}})


class Still:
    duration = 0.1

    def __call__(self, time):
        zero = np.zeros(3)
        return om.Desired(np.array([0.0, 0.0, 1.0]), np.eye(3), zero, zero, zero, zero)


def passing(time, measured, previous):
    return measured


def half(acceleration, state, previous):
    return om.Command(np.full(8, 1.5), previous.tilt)


def gust(time, state):
    return np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def exact(time, state):
    return state


def failing(time, state, desired):
    raise ValueError("not today")


number = 3
"""
SCENARIO = """
schema = 1
name = "mine"
base = "paper-case-a"
"""
VEHICLE = 'vehicle = "omnimorph"\n'  # stated, so that the controller of the base is not for it


def of(key: str, named: str) -> str:
    return f'\n[{key}]\nkind = "python"\nobject = "{named}"\n'


STILL = of("reference", "{module}:Still")
PARTS = {
    "controller": of("controller", "{module}:Steady"),
    "controller.allocator": of("controller.allocator", "{module}:half"),
    "reference": "",
    "estimator": of("estimator", "{module}:passing"),
    "sensors": of("sensors", "{module}:exact"),
    "disturbance": of("disturbance", "{module}:gust"),
}


def written(folder: Path, parts: str, first: str = "") -> tuple[Path, str]:
    """Write a scenario and its module, whose name is its own in every test."""
    module = "own_" + "".join(c if c.isalnum() else "_" for c in folder.name)
    (folder / f"{module}.py").write_text(MODULE.format(first=first), encoding="utf-8")
    file = folder / "mine.toml"
    file.write_text(SCENARIO + parts.replace("{module}", module), encoding="utf-8")
    return file, module


@pytest.mark.parametrize("key", PARTS)
def test_a_part_in_a_file_flies_as_the_same_object_in_python(key: str, tmp_path: Path) -> None:
    file, module = written(tmp_path, STILL + PARTS[key])
    with pytest.raises(om.InputError) as caught:
        om.load_scenario(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert f"{module}:" in str(caught.value)
    assert "--allow-code" in str(caught.value)
    scenario = om.load_scenario(file, allow_code=True)
    named: Any = sys.modules[module]
    objects = {
        "controller": named.Steady(scenario),
        "allocator": named.half,
        "estimator": named.passing,
        "sensors": named.exact,
        "disturbance": named.gust,
    }
    part = key.rpartition(".")[2]
    parts = {part: objects[part]} if part in objects else {}
    reported = om.fly("paper-case-a", reference=named.Still(), seed=2, **parts)
    run = om.fly(file, seed=2, allow_code=True)
    assert run.outcome is om.Outcome.COMPLETED
    assert len(run.time) == 101
    assert differing(run, reported) == []
    flights = om.fly_many(file, 3, seed=2, keep="all", allow_code=True)
    for k in range(3):
        assert differing(flights.runs[k], om.fly(scenario, seed=2, flight=k)) == []
    for metric in ("position_error_mean_m", "drag_energy_J"):
        alone = [getattr(flights.runs[k].metrics, metric) for k in range(3)]
        np.testing.assert_array_equal(getattr(flights.metrics, metric), alone)
    provenance = run.provenance.scenario
    for name in key.split("."):
        provenance = provenance[name]
    assert provenance["kind"] == "python"


def test_options_are_arguments_of_the_class(tmp_path: Path) -> None:
    options = "[controller.options]\nthrust = 1.7\n"
    file, _ = written(tmp_path, STILL + PARTS["controller"] + options)
    run = om.fly(file, allow_code=True)
    assert set(run["thrust"][:-1]) == {1.7}
    assert run.provenance.scenario["controller"]["options"] == {"thrust": 1.7}


def test_a_module_is_looked_for_beside_the_file_that_names_it(tmp_path: Path) -> None:
    below = tmp_path / "below"
    below.mkdir()
    file, _ = written(below, STILL + PARTS["controller"] + PARTS["estimator"])
    above = tmp_path / "above.toml"
    above.write_text('schema = 1\nname = "above"\nbase = "below/mine.toml"\n', encoding="utf-8")
    assert differing(om.fly(above, allow_code=True), om.fly(file, allow_code=True)) == []


def test_a_file_may_be_named_from_its_own_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, _ = written(tmp_path, STILL + PARTS["controller"])
    monkeypatch.chdir(tmp_path)
    scenario = om.load_scenario("mine.toml", allow_code=True)
    here = om.fly(scenario)
    monkeypatch.chdir("/")
    assert differing(om.fly(scenario), here) == []
    assert differing(om.fly(file, allow_code=True), here) == []


@pytest.mark.parametrize(
    ("key", "parts"),
    [
        ("controller", {"allocator": "fixed-tilt"}),
        ("controller", {"controller": om.TrackingGains()}),
        ("controller.allocator", {"allocator": "joint-tilt"}),
    ],
)
def test_nothing_allocates_by_the_weights_that_a_file_does_not_give(
    key: str, parts: dict[str, Any], tmp_path: Path
) -> None:
    file, _ = written(tmp_path, VEHICLE + PARTS[key])
    scenario = om.load_scenario(file, allow_code=True)
    with pytest.raises(om.InputError, match="mine: there is no allocation rule"):
        om.with_parts(scenario, **parts)
    own = om.with_parts(scenario, controller="paper-case-b").own
    assert own.controller is own.allocator is None


def test_a_demand_needs_an_allocator(tmp_path: Path) -> None:
    file, _ = written(tmp_path, VEHICLE + PARTS["controller"])
    up = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    flight = om.SteppedFlight(om.load_scenario(file, allow_code=True))
    with pytest.raises(om.InputError, match="mine: there is no allocation rule"):
        flight.step(demand=up)
    with pytest.raises(om.InputError, match="mine: there is no allocation rule"):
        flight.scenario.build_controller()
    file, _ = written(tmp_path, PARTS["controller.allocator"])
    flight = om.SteppedFlight(om.load_scenario(file, allow_code=True))
    flight.step(demand=up)
    assert set(flight.as_run().thrust_command[0]) == {1.5}


def test_what_is_proposed_flies_with_an_allocator_of_ones_own(tmp_path: Path) -> None:
    file, _ = written(
        tmp_path, STILL + "\n[controller]\nproposed = true\n" + PARTS["controller.allocator"]
    )
    scenario = om.load_scenario(file, allow_code=True)
    assert scenario.gains == om.propose_controller(scenario.vehicle, 4e-3).gains
    run = om.fly(scenario)
    assert set(run.thrust_command[:-1].ravel()) == {1.5}


@pytest.mark.parametrize(
    ("object_", "first", "said"),
    [
        ("nowhere_at_all:X", "", "ModuleNotFoundError: No module named 'nowhere_at_all'"),
        ("{module}:Missing", "", "no attribute 'Missing'"),
        ("{module}:Steady", "1 / 0", "ZeroDivisionError: division by zero"),
        ("{module}:Steady", "raise SystemExit(0)", "SystemExit: 0"),
        ("{module}:Steady", "def broken(:", "SyntaxError"),
        ("no colon", "", "my_module:MyController"),
        ("{module}:", "", "my_module:MyController"),
        ("../{module}:X", "", "my_module:MyController"),
        ("os:system('x')", "", "my_module:MyController"),
        ("{module}:number", "", "object that can be called"),
    ],
)
def test_an_object_that_is_not_there_is_refused_in_a_sentence(
    object_: str, first: str, said: str, tmp_path: Path
) -> None:
    file, module = written(tmp_path, of("controller", object_), first)
    with pytest.raises(om.InputError) as caught:
        om.fly(om.load_scenario(file, allow_code=True))
    assert said in str(caught.value)
    assert str(caught.value).isprintable()
    with pytest.raises(om.InputError):
        om.fly("hover", controller=object_.replace("{module}", module), allow_code=True)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (of("controller", "m:C") + "gain = 3\n", "controller.gain"),
        ('\n[estimator]\nobject = "m:C"\n', "estimator.kind"),
        ('\n[estimator]\nkind = "kalman"\nobject = "m:C"\n', "estimator.kind"),
        ('\n[estimator]\nkind = "python"\n', "estimator.object"),
        ('\n[estimator]\nkind = "python"\nobject = 3\n', "estimator.object"),
        ("\nestimator = 3\n", "estimator"),
        ("\ncontroller = 3\n", "controller"),
        ("\n[[controller]]\n", "controller"),
        ("\n[controller]\nallocator = 3\n", "controller.allocator"),
        ("\n[controller]\nkind = 3\n", "controller.kind"),
        ("\n[controller]\nproposed = true\nallocator = 3\n", "controller.allocator"),
        (
            '\n[controller]\nkind = "mine"\n',
            'controller.kind is "mine", but it must be paper or python.',
        ),
    ],
)
def test_a_table_that_is_wrong_names_its_key(text: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(SCENARIO + text, encoding="utf-8")
    with pytest.raises(om.InputError) as caught:
        om.load_scenario(file, allow_code=True)
    assert f"{said} " in f"{caught.value} "


def test_the_paper_is_the_default_kind_of_controller(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(SCENARIO + '[controller]\nkind = "paper"\n', encoding="utf-8")
    assert om.load_scenario(file).gains == om.load_scenario("paper-case-a").gains


BUILT = {
    "controller": (lambda *given: om.Command(np.full(8, 1.6), np.zeros(1)), "controller.position"),
    "allocator": (
        lambda *given: om.Command(np.full(8, 1.6), np.zeros(1)),
        "controller.allocator.W1",
    ),
    "sensors": (lambda time, state: state, "plant.measurement-noise.position"),
    "plant": (wall(SHORT), "truth.mass"),
}


@pytest.mark.parametrize("part", BUILT)
def test_flights_do_not_differ_in_what_an_object_stands_in_for(part: str) -> None:
    own: Any
    own, path = BUILT[part]
    parts: Any = {part: own}
    vary = {path: [1.4, 1.5]}
    with pytest.raises(om.InputError, match=f"{path} would change nothing, because the {part} is"):
        om.fly_many(SHORT, 2, vary=vary, **parts)
    assert len(om.fly_many(SHORT, 2, vary={"vehicle.mass": [1.3, 1.4]}, **parts)) == 2


def test_a_class_that_is_named_is_built_for_each_flight_with_its_scenario(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    engine = """
class Engine(om.SimulatedPlant):
    def __init__(self, scenario):
        super().__init__(scenario.vehicle, scenario.plant)
"""
    _, module = written(tmp_path, "")
    with open(tmp_path / f"{module}.py", "a", encoding="utf-8") as file:
        file.write(engine)
    masses = [1.3, 1.4]
    monkeypatch.chdir(tmp_path)
    named: Any = {"plant": f"{module}:Engine", "allow_code": True}
    flights = om.fly_many(SHORT, 2, vary={"truth.mass": masses}, keep="all", **named)
    for k, mass in enumerate(masses):
        alone = om.fly(om.replaced(SHORT, {"truth.mass": mass}), flight=k)
        assert differing(flights.runs[k], alone) == []


def test_the_forces_of_a_plant_are_not_lost_in_a_plant_of_ones_own() -> None:
    wind = om.effects.ConstantWrench(force=(1.0, 0.0, 0.0))
    with pytest.raises(om.InputError, match=r"disturbance is .* an object that can be called"):
        om.fly(SHORT, plant=wall(SHORT), disturbance=wind)
