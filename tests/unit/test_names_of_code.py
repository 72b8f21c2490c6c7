"""Which code a name in a file or on the command line stands for, and that one's own is named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.unit.own_objects import SHORT, differing
from tests.unit.test_code_in_files import PARTS, STILL, of, written

import omnimorph as om
from omnimorph.cli.main import main

LASTING = """
class Counter:
    calls = 0

    def __call__(self, time, state, desired):
        self.calls += 1
        return om.Command(np.full(8, 1.6), np.zeros(1), log={"calls": self.calls})


counter = Counter()


class Paper:
    def __init__(self, scenario):
        self.controller = scenario.build_controller()

    def __call__(self, time, state, desired):
        return self.controller(time, state, desired)


class Lost(Still):
    def __call__(self, time):
        raise SystemExit(3)
"""


def with_more(folder: Path, parts: str) -> Path:
    """Write a scenario and its module, which has more in it, in a folder of its own."""
    folder.mkdir()
    file, module = written(folder, parts)
    with (folder / f"{module}.py").open("a", encoding="utf-8") as added:
        added.write(LASTING)
    return file


@pytest.fixture
def steady(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    name = "".join(c if c.isalnum() else "_" for c in request.node.name)
    return with_more(tmp_path / name, STILL + PARTS["controller"])


def test_a_file_flies_by_every_path_to_it(steady: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = steady.parent
    linked = folder.parent / "linked"
    linked.symlink_to(folder)
    reported = om.fly(steady, allow_code=True)
    monkeypatch.chdir(folder)
    around = f"../{folder.name}/../{folder.name}/mine.toml"
    for path in ("mine.toml", "./mine.toml", around, linked / "mine.toml"):
        assert differing(om.fly(path, allow_code=True), reported) == []
    monkeypatch.chdir(folder.parent)
    assert differing(om.fly(f"{folder.name}/mine.toml", allow_code=True), reported) == []


def test_another_module_of_the_same_name_is_never_taken_for_it(steady: Path) -> None:
    """Not even that of a folder below, whose path begins with the same."""
    om.fly(steady, allow_code=True)
    above = steady.parent.parent
    (module,) = steady.parent.glob("own_*.py")
    (above / module.name).write_text(module.read_text("utf-8"), encoding="utf-8")
    (above / "mine.toml").write_text(steady.read_text("utf-8"), encoding="utf-8")
    with pytest.raises(om.InputError, match=f"another {module.stem} is in use"):
        om.fly(above / "mine.toml", allow_code=True)


def test_what_a_module_imports_beside_it_is_never_that_of_another_folder(tmp_path: Path) -> None:
    thrusts = {"here": 1.6, "there": 1.5}
    for name, thrust in thrusts.items():
        file = with_more(tmp_path / name, STILL + PARTS["controller"])
        (file.parent / "thrust_of_mine.py").write_text(f"THRUST = {thrust}\n", encoding="utf-8")
        (module,) = file.parent.glob("own_*.py")
        text = module.read_text("utf-8").replace("thrust=1.6", "thrust=THRUST")
        module.write_text(f"from thrust_of_mine import THRUST\n{text}", encoding="utf-8")
    for _ in range(2):
        run = om.fly(tmp_path / "here/mine.toml", allow_code=True)
        assert set(run["thrust"]) == {1.6}
        with pytest.raises(om.InputError, match="another thrust_of_mine is in use"):
            om.fly(tmp_path / "there/mine.toml", allow_code=True)


def test_an_object_that_a_module_has_made_is_new_in_every_flight(tmp_path: Path) -> None:
    file = with_more(tmp_path / "lasting", STILL + of("controller", "{module}:counter"))
    runs = [om.fly(file, allow_code=True) for _ in range(2)]
    runs += om.fly_many(file, 3, allow_code=True, keep="all").runs.values()
    assert [run["calls"][-1] for run in runs] == [25] * 5


def test_what_options_hold_does_not_break_the_run(steady: Path) -> None:
    text = steady.read_text("utf-8").replace(":Steady", ":Dated")
    (module,) = steady.parent.glob("own_*.py")
    with module.open("a", encoding="utf-8") as added:
        added.write("\nclass Dated(Steady):\n    def __init__(self, scenario, built):\n")
        added.write("        super().__init__(scenario)\n")
    steady.write_text(text + "[controller.options]\nbuilt = 2026-01-31\n", encoding="utf-8")
    run = om.fly(steady, allow_code=True)
    assert run.provenance.scenario["controller"]["options"] == {"built": "2026-01-31"}


def test_the_rule_that_a_file_does_not_state_is_never_flown(steady: Path, tmp_path: Path) -> None:
    """Nor that of a base for another vehicle."""
    for folder in (steady.parent, tmp_path / "paper"):
        file = folder / "mine.toml"
        if not folder.exists():
            with_more(folder, STILL + of("controller", "{module}:Paper"))
        text = file.read_text("utf-8").replace("\n[", '\nvehicle = "omnimorph"\n[', 1)
        file.write_text(text, encoding="utf-8")
    mine, said = om.load_scenario(steady, allow_code=True), "there is no allocation rule"
    for parts in ({"allocator": "joint-tilt"}, {"controller": om.TrackingGains()}):
        given: Any = parts
        with pytest.raises(om.InputError, match=said):
            om.fly(mine, **given)
    with pytest.raises(om.InputError, match=said):
        om.fly(SHORT, allocator=mine)
    with pytest.raises(om.InputError, match=said):
        om.fly(tmp_path / "paper/mine.toml", allow_code=True)
    flight = om.SteppedFlight(mine)
    with pytest.raises(om.InputError, match=said):
        flight.step(demand=[0.0] * 6)
    flight.change_controller(SHORT)
    flight.step(demand=[0.0] * 6)
    assert om.fly(mine, controller=SHORT).outcome is om.Outcome.COMPLETED


def test_a_controller_of_ones_own_may_build_that_of_its_base(tmp_path: Path) -> None:
    file = with_more(tmp_path / "built", STILL + of("controller", "{module}:Paper"))
    scenario = om.load_scenario(file, allow_code=True)
    base = om.load_scenario("paper-case-a")
    assert (scenario.gains, scenario.allocator) == (base.gains, base.allocator)
    reported = om.fly(base, reference=scenario.reference)
    run = om.fly(scenario)
    np.testing.assert_allclose(run.p_WB, reported.p_WB, rtol=0.0, atol=1e-9)
    above = tmp_path / "above.toml"
    above.write_text('schema = 1\nname = "above"\nbase = "built/mine.toml"\n', encoding="utf-8")
    assert differing(om.fly(above, allow_code=True), run) == []


def test_a_part_of_another_file_brings_its_code_if_that_is_allowed(steady: Path) -> None:
    for part in ("controller", "reference"):
        given: Any = {part: steady}
        with pytest.raises(om.InputError, match="allow-code"):
            om.fly(SHORT, **given)
    run = om.fly(SHORT, controller=steady, allow_code=True)
    assert set(run["thrust"][:-1]) == {1.6}
    assert om.with_parts(SHORT, reference=steady, allow_code=True).reference.duration == 0.1


def test_a_reference_that_leaves_is_the_users_mistake(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = with_more(tmp_path / "lost", of("reference", "{module}:Lost"))
    assert main(["fly", str(file), "--allow-code", "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "reference Lost failed before anything was flown: SystemExit: 3" in said
    assert "Traceback" not in said


def test_an_engine_flies_beside_another_vehicle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "engine_of_mine.py").write_text(
        "import omnimorph as om\n\n\n"
        "class Engine(om.SimulatedPlant):\n    def __init__(self, scenario):\n"
        "        super().__init__(scenario.vehicle, scenario.plant)\n",
        encoding="utf-8",
    )
    monkeypatch.chdir(tmp_path)
    words = ["hover", "--vehicle", "omnimorph", "--plant", "engine_of_mine:Engine", "--out", "out"]
    assert main(["fly", *words]) == 2
    assert main(["fly", *words, "--allow-code"]) == 0
    assert om.load_run("out/run.nc").provenance.scenario["engine"]["object"] == words[4]
