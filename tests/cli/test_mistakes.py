"""What users get wrong is reported in one line with the exit code 2, and nothing is written."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

Program = Callable[..., "subprocess.CompletedProcess[str]"]

VEHICLE = """
schema = 1
name = "mine"
title = "A rotor that tilts"
mass_kg = 1.2
inertia_kg_m2 = [0.0115, 0.0114, 0.0194]
[rotor_defaults]
thrust_coefficient_N_per_Hz2 = 6.5e-4
drag_coefficient_Nm_per_Hz2 = 1e-5
speed_min_Hz = 16.0
speed_max_Hz = 100.0
[[rotor]]
position_m = [0.2, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
hinge = [1.0, 0.0, 0.0]
servo = "tilt"
spin = "ccw"
[[servo]]
name = "tilt"
angle_min_deg = 0.0
angle_max_deg = 60.0
rate_max_deg_per_s = 100.0
"""

SCENARIO = """
schema = 1
name = "mine"
base = "hover"
vehicle = "mine.vehicle.toml"
lost_beyond_m = 1.0
[plant]
physics_step_ms = 1.0
control_period_ms = 4.0
"""


def complaint(done: subprocess.CompletedProcess[str]) -> str:
    """The one line on standard error; nothing else was said."""
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    (line,) = done.stderr.splitlines()
    assert line.startswith("omnimorph: ")
    return line.removeprefix("omnimorph: ")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("fyl hover", "'fyl' is not a command; did you mean fly?"),
        ("zzz", "'zzz' is not a command; known are vehicles, new-vehicle, analyze, "),
        ("fly", "the following arguments are required: SCENARIO; see `omnimorph fly --help`."),
        ("--jsn", "omnimorph does not take '--jsn'; see `omnimorph --help`."),
        ("fly hover --ot x", "omnimorph fly does not take '--ot'; see `omnimorph fly --help`."),
        ("fly hover --seed", "argument --seed: expected one argument; see "),
        ("fly hover --seed x", 'the command line: --seed is "x", but it must be an integer '),
        ("fly hover --seed -1", 'the command line: --seed is "-1", but it must be an integer '),
        ("fly paper-cas-a", "'paper-cas-a' is neither a scenario of the catalogue nor a file; "
         "did you mean paper-case-a "),
        ("fly hover --plant perfekt", "'perfekt' is neither a plant of the catalogue nor a file; "
         "did you mean perfect "),
        ("vehicles omnimorf", "'omnimorf' is neither a vehicle of the catalogue nor a file; "
         "did you mean omnimorph "),
        ("scenarios missing.toml", "missing.toml: this file cannot be read, because there is no "),
        ("fly folder.toml", "folder.toml: this file cannot be read, because it is a directory."),
        ("fly binary.toml", "binary.toml: this file cannot be read, because it is not a text "),
        ("fly hover --out binary.toml", "binary.toml: cannot be written to, because "),
        ("fly hover --out /dev/null/x", "/dev/null/x: cannot be written to, because /dev/null is"),
        ("reproduce --out binary.toml", "binary.toml: it is not a folder; give a new "),
        ("reproduce --seeds 0", 'the command line: --seeds is "0", but it must be a positive '),
        ("reproduce --seeds 99999999999", 'the command line: --seeds is "99999999999", but it '),
        ("analyze omnimorph --beyond-limits --tilt 1e300", 'the command line: --tilt is "1e300"'),
        ("gains omnimorph --period-ms 1e154", 'the command line: --period-ms is "1e154", but it '
         "must be a number of milliseconds, from 1e-06 to 10000."),
        ("fly hover --out=", 'the command line: --out is "", but it must be the name of a '),
        ("fly hover --out taken", "taken/run.nc: it cannot be written, because it is a folder."),
    ],
)  # fmt: skip
def test_words_that_cannot_be_used(
    program: Program, tmp_path: Path, words: str, sentence: str
) -> None:
    Path(tmp_path, "folder.toml").mkdir()
    Path(tmp_path, "taken", "run.nc").mkdir(parents=True)
    Path(tmp_path, "binary.toml").write_bytes(b"\xff\xfe\x00")
    before = sorted(tmp_path.rglob("*"))
    assert complaint(program(*words.split())).startswith(sentence)
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("lost_beyond_m = 1.0", "lost_beyond_m = = 1", "mine.toml: this file is not valid TOML: "),
        ("lost_beyond_m", "lost_beyond", "mine.toml: lost_beyond is not a known key; did you mean "
         "lost_beyond_m "),
        ("lost_beyond_m = 1.0", "lost_beyond_m = '1'", 'mine.toml: lost_beyond_m is "1", but it '
         "must be a positive number of metres, from 1e-6 to 1e9."),
        ("lost_beyond_m = 1.0", "lost_beyond_m = nan", "mine.toml: lost_beyond_m is nan, but it "
         "must be a positive number of metres, from 1e-6 to 1e9."),
        ("name = \"mine\"", "", "mine.toml: name is missing, but it must be "),
        ("control_period_ms = 4.0", "control_period_ms = 2.5", "mine.toml: plant: "
         "control_period_ms is 2.5, but it must be a multiple of the physics step, 1 ms."),
    ],
)  # fmt: skip
def test_scenario_that_cannot_be_flown(
    program: Program, tmp_path: Path, old: str, new: str, expected: str
) -> None:
    assert old in SCENARIO
    Path(tmp_path, "mine.toml").write_text(SCENARIO.replace(old, new, 1), encoding="utf-8")
    Path(tmp_path, "mine.vehicle.toml").write_text(VEHICLE, encoding="utf-8")
    line = complaint(program("fly", "mine.toml", "--out", "out"))
    assert line.startswith(expected)
    assert not Path(tmp_path, "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("mass_kg = 1.2", "", "mass_kg is missing, but it must be "),
        ("mass_kg = 1.2", "mass_kg = -1.2", "mass_kg is -1.2, but it must be a positive "),
        ("mass_kg = 1.2", "mass_kg = nan", "mass_kg is nan, but it must be "),
        ("0.0194]", "0.9]", "inertia_kg_m2 is [0.0115, 0.0114, 0.9], but it must be "),
        ("axis = [0.0, 0.0, 1.0]", "axis = [0.0, 0.0, 0.9]", "rotor[0].axis is "),
        ("angle_min_deg = 0.0", "angle_min_deg = 70.0", "servo[0].angle_min_deg is 70.0, but "),
    ],
)  # fmt: skip
def test_vehicle_that_cannot_be_used(
    program: Program, tmp_path: Path, old: str, new: str, expected: str
) -> None:
    """The vehicle of a user's scenario: the message names the vehicle's file."""
    assert old in VEHICLE
    Path(tmp_path, "mine.toml").write_text(SCENARIO, encoding="utf-8")
    Path(tmp_path, "mine.vehicle.toml").write_text(VEHICLE.replace(old, new, 1), encoding="utf-8")
    line = complaint(program("fly", "mine.toml", "--out", "out"))
    assert line.startswith(f"mine.vehicle.toml: {expected}")
    assert not Path(tmp_path, "out").exists()


def test_standard_output_that_is_full(environment: dict[str, str]) -> None:
    """A device on which nothing can be written, as a full disk."""
    command = [sys.executable, "-m", "omnimorph", "vehicles"]
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(
            command, env=environment, stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("omnimorph: standard output cannot be written: ")
