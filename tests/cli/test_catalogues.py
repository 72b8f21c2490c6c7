"""`omnimorph`, `omnimorph vehicles`, `omnimorph scenarios`: what there is."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import omnimorph as om
from omnimorph.cli.main import COMMANDS, main

Program = Callable[..., "subprocess.CompletedProcess[str]"]


def test_version(program: Program) -> None:
    done = program("--version")
    assert (done.returncode, done.stdout, done.stderr) == (0, f"omnimorph {om.__version__}\n", "")


@pytest.mark.parametrize("words", [(), ("--help",)])
def test_help_names_every_command_and_exit_code(program: Program, words: tuple[str, ...]) -> None:
    done = program(*words)
    assert (done.returncode, done.stderr) == (0, "")
    for command in ("vehicles", "scenarios", "fly", "reproduce", "verify", "bench"):
        assert f"\n    {command}" in done.stdout
    for code in ("0 done", "1 our fault", "2 a mistake", "3 the flight", "130 interrupted"):
        assert code in " ".join(done.stdout.split())


@pytest.mark.parametrize("command", list(COMMANDS))
def test_every_command_has_help_and_json(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--help"]) == 0
    reported = capsys.readouterr()
    assert reported.err == ""
    assert f"usage: omnimorph {command}" in reported.out
    assert "--json" in reported.out


def test_help_loads_nothing_heavy(environment: dict[str, str]) -> None:
    text = (
        "import sys\n"
        "from omnimorph.cli.main import main\n"
        "assert main(['--help']) == 0\n"
        "print(sorted({name.split('.')[0] for name in sys.modules}), file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", text], env=environment, capture_output=True, text=True, check=True
    )
    for heavy in ("numpy", "scipy", "pydantic", "h5py", "matplotlib", "jinja2", "rich"):
        assert f"'{heavy}'" not in done.stderr


def test_vehicles_lists_the_catalogue(program: Program) -> None:
    done = program("vehicles")
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0].split() == ["name", "rotors", "servos", "mass_kg", "title"]
    names = om.list_vehicles()
    assert [line.split()[0] for line in lines[2 : 2 + len(names)]] == names
    own = next(line for line in lines if line.startswith("omnimorph "))
    assert own.split()[1:4] == ["8", "1", "1.315"]


def test_vehicles_for_programs(program: Program) -> None:
    found = json.loads(program("vehicles", "--json").stdout)
    assert [item["name"] for item in found] == om.list_vehicles()
    assert next(item for item in found if item["name"] == "omnimorph") == {
        "name": "omnimorph",
        "rotors": 8,
        "servos": 1,
        "mass_kg": 1.315,
        "title": om.load_vehicle("omnimorph").title,
    }


def test_one_vehicle_shows_the_source_of_every_number(program: Program) -> None:
    done = program("vehicles", "omnimorph")
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    sources = om.load_vehicle("omnimorph").sources
    for source in sources.values():
        found = [line for line in lines if line.endswith(f"  {source.text}")]
        assert {line.startswith("*") for line in found} == {source.assumed}, source.text
    rows = lines[lines.index(next(line for line in lines if line.split()[:1] == ["key"])) + 2 :]
    assert len(rows) == len(sources) + 1  # the servo's name needs none
    assert "no source given" not in done.stdout
    assert ["tilt_mechanism_mass_kg", "0.187"] in [row.split()[:2] for row in rows]
    assert "tilt_mechanism" not in program("vehicles", "omnimorph-2026").stdout


def test_one_vehicle_from_a_file_for_programs(program: Program, tmp_path: Path) -> None:
    Path(tmp_path, "quad.toml").write_text(QUADROTOR, encoding="utf-8")
    done = program("vehicles", "quad.toml", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    found = json.loads(done.stdout)
    assert found["mass_kg"] == 1.2
    assert len(found["rotor"]) == 4
    assert found["sources"] == {"mass_kg": "a kitchen scale"}
    shown = program("vehicles", "quad.toml").stdout
    assert "a kitchen scale" in shown
    assert "4 rotors, 0 servos" in shown
    assert "no source given" in shown


def test_scenarios_lists_those_of_the_package(program: Program) -> None:
    done = program("scenarios")
    assert (done.returncode, done.stderr) == (0, "")
    line = next(line for line in done.stdout.splitlines() if line.startswith("paper-case-b "))
    assert line.split(maxsplit=4) == [
        "paper-case-b",
        "45",
        "omnimorph",
        "realistic",
        "The paper's Case B: effort first",
    ]


def test_scenarios_for_programs(program: Program) -> None:
    found = json.loads(program("scenarios", "--json").stdout)
    assert [item["name"] for item in found] == om.list_scenarios()
    assert {item["duration_s"] for item in found} == {5.0, 25.0, 45.0}


def test_one_scenario_shows_what_is_flown(program: Program) -> None:
    shown = program("scenarios", "paper-case-b-w3").stdout
    assert "It lasts 45 s." in shown
    rows = dict(line.split(maxsplit=1) for line in shown.splitlines()[3:])
    assert rows["controller.allocator.W3_per_Hz4"] == "0.0001"
    assert rows["plant.effects[3].position_mm"] == "1"
    content = json.loads(program("scenarios", "paper-case-b-w3", "--json").stdout)
    assert content == json.loads(json.dumps(om.load_scenario("paper-case-b-w3").as_file()))


@pytest.mark.parametrize("command", ["scenarios paper-case-a", "--help"])
def test_a_reader_that_leaves_is_no_mistake(environment: dict[str, str], command: str) -> None:
    line = (
        f"{shlex.quote(sys.executable)} -m omnimorph {command} | head -1; echo ${{PIPESTATUS[0]}}"
    )
    done = subprocess.run(
        ["bash", "-c", line], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stderr == ""
    assert len(done.stdout.splitlines()) == 2
    assert done.stdout.splitlines()[-1] == "0"


def test_a_pipe_without_a_reader(environment: dict[str, str]) -> None:
    """As `| true`: the reader is gone before the first word."""
    process = subprocess.Popen(
        [sys.executable, "-m", "omnimorph", "vehicles"],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    assert process.stderr.read() == b""
    assert process.wait(timeout=60) == 0
    process.stderr.close()


QUADROTOR = """
schema = 1
name = "quad"
title = "A quadrotor"
mass_kg = 1.2
inertia_kg_m2 = [0.0115, 0.0114, 0.0194]

[rotor_defaults]
thrust_coefficient_N_per_Hz2 = 6.5e-4
drag_coefficient_Nm_per_Hz2 = 1e-5
speed_min_Hz = 16.0
speed_max_Hz = 100.0

[[rotor]]
position_m = [0.2, 0.0, 0.0]
spin = "ccw"

[[rotor]]
position_m = [0.0, 0.2, 0.0]
spin = "cw"

[[rotor]]
position_m = [-0.2, 0.0, 0.0]
spin = "ccw"

[[rotor]]
position_m = [0.0, -0.2, 0.0]
spin = "cw"

[sources]
mass_kg = "a kitchen scale"
"""
