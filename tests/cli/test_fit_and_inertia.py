"""`omnimorph fit` and `omnimorph inertia`, as processes: answers, pages, refusals."""

from __future__ import annotations

import json
import subprocess
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tests.physics.bench_runs import DRAG, THRUST, TURN, lagged

from omnimorph.units import from_SI

Program = Callable[..., "subprocess.CompletedProcess[str]"]

PARTS = """
[[part]]
name = "body"
kind = "box"
mass_kg = 12.0
size_m = [1.0, 2.0, 3.0]

[[part]]
kind = "cylinder"
mass_kg = 12.0
radius_m = 1.0
length_m = 2.0
orientation_deg = [0.0, 90.0, 0.0]

[[part]]
kind = "point"
mass_kg = 1.0
position_m = [0.0, 0.0, 0.0]
"""


def write_bench(path: Path, *, speed_factor: float = 1.0) -> None:
    """Steps between 60 and 120 Hz on a bench, one row with a wrong force."""
    time = np.arange(1600) / 500.0
    command = TURN * np.where((time // 0.4).astype(int) % 2, 120.0, 60.0)
    speed = lagged(time, command, 0.025, 0.045)
    random = np.random.default_rng(4)
    force = THRUST * speed**2 + 0.05 * random.standard_normal(1600)
    torque = DRAG * speed**2 + 1e-3 * random.standard_normal(1600)
    force[77] += 9.0
    rows = np.column_stack([time, speed_factor * speed / TURN, force, torque, command / TURN])
    header = "time_s,speed_Hz,force_N,torque_Nm,command_Hz"
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.9g")


@pytest.mark.slow
def test_fit_prints_lines_for_a_vehicle_file(program: Program, tmp_path: Path) -> None:
    write_bench(tmp_path / "bench.csv")
    done = program("fit", "bench.csv")
    assert (done.returncode, done.stderr) == (0, "")
    values = tomllib.loads(done.stdout)  # everything else is a comment
    assert values["thrust_coefficient_N_per_Hz2"] == pytest.approx(
        from_SI(THRUST, "N_per_Hz2"), rel=2e-3
    )
    assert values["drag_coefficient_Nm_per_Hz2"] == pytest.approx(
        from_SI(DRAG, "Nm_per_Hz2"), rel=4e-3
    )
    assert values["speed_min_Hz"] == pytest.approx(60.0, rel=1e-3)
    assert values["speed_max_Hz"] == pytest.approx(120.0, rel=1e-3)
    assert values["time_constant_up_ms"] == pytest.approx(25.0, rel=1e-3)
    assert values["time_constant_down_ms"] == pytest.approx(45.0, rel=1e-3)
    assert "# 1 of 1600 rows were left out of the force" in done.stdout
    assert list(tmp_path.iterdir()) == [tmp_path / "bench.csv"]


@pytest.mark.slow
def test_fit_writes_its_page_and_the_same_numbers(program: Program, tmp_path: Path) -> None:
    write_bench(tmp_path / "bench.csv")
    replaced = f"omnimorph: replaced what was there: {Path('found', 'results.json')}.\n"
    for said in ("", replaced):  # a folder of ours is written over
        done = program("fit", "bench.csv", "--out", "found", "--json")
        assert (done.returncode, done.stderr) == (0, said)
    reported = json.loads(done.stdout)
    assert reported == json.loads((tmp_path / "found" / "results.json").read_text("utf-8"))
    thrust = reported["thrust_coefficient_N_per_Hz2"]["both"]
    assert thrust["low"] < from_SI(THRUST, "N_per_Hz2") < thrust["high"]
    assert (reported["rows"], reported["force_outlier_lines"]) == (1600, [79])
    assert [step["up"] for step in reported["steps"]] == [True, False] * 3 + [True]
    page = (tmp_path / "found" / "fit.html").read_text("utf-8")
    assert page.count("<svg") == 3
    assert "time_constant_up_ms = 25" in page
    figures = {path.name for path in (tmp_path / "found" / "figures").iterdir()}
    assert figures == {"coefficients.svg", "residuals.svg", "steps.svg"}


def test_fit_refuses_a_wrong_unit_and_writes_nothing(program: Program, tmp_path: Path) -> None:
    write_bench(tmp_path / "bench.csv", speed_factor=60.0)
    done = program("fit", "bench.csv", "--out", "found")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "omnimorph: bench.csv: speed_Hz is 60 times command_Hz, which is 60: the numbers under "
        "speed_Hz look like rpm.\n"
    )
    assert not (tmp_path / "found").exists()


@pytest.mark.slow
def test_fit_recognises_a_wrong_unit_beside_a_vehicle(program: Program, tmp_path: Path) -> None:
    speed = TURN * np.linspace(30.0, 120.0, 40)  # OmniMorph's coefficients, speeds in rad/s
    rows = np.column_stack([np.arange(40.0), speed, 4.72e-6 * speed**2, 8e-8 * speed**2])
    header = "time_s,speed_Hz,force_N,torque_Nm"
    np.savetxt(tmp_path / "bench.csv", rows, delimiter=",", header=header, comments="")
    done = program("fit", "bench.csv", "--like", "omnimorph")
    assert done.returncode == 2
    assert "about 1/(2π)²: the speeds look like rad/s where Hz is said." in done.stderr
    assert program("fit", "bench.csv").returncode == 0


def test_inertia_adds_up(program: Program, tmp_path: Path) -> None:
    (tmp_path / "parts.toml").write_text(PARTS, encoding="utf-8")
    done = program("inertia", "parts.toml")
    assert (done.returncode, done.stderr) == (0, "")
    values = tomllib.loads(done.stdout)
    assert values["mass_kg"] == 25.0
    assert np.array(values["inertia_kg_m2"]) == pytest.approx(np.diag([19.0, 17.0, 12.0]))
    reported = json.loads(program("inertia", "parts.toml", "--json").stdout)
    assert reported["centre_of_mass_m"] == [0.0, 0.0, 0.0]
    assert np.array(reported["inertia_kg_m2"]) == pytest.approx(np.diag([19.0, 17.0, 12.0]))
    assert reported["warnings"] == []


def test_inertia_of_a_rod_is_reported_to_be_none(program: Program, tmp_path: Path) -> None:
    ends = "".join(
        f'[[part]]\nkind = "point"\nmass_kg = 1.0\nposition_m = [{x}, 0.0, 0.0]\n' for x in (0, 2)
    )
    (tmp_path / "parts.toml").write_text(ends, encoding="utf-8")
    done = program("inertia", "parts.toml")
    assert done.returncode == 0
    assert "# The parts lie in one line and have no inertia about it" in done.stdout
    assert "# [1, 0.0, 0.0] m: positions" in done.stdout


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('"box"', '"bx"', 'part[0].kind is "bx", but it must be one of box, cylinder, point.'),
        ("size_m", "siz_m", "part[0].siz_m is not a known key; did you mean size_m "),
        ("radius_m = 1.0", "", "part[1].radius_m is missing, but it must be zero or a positive "),
        ("mass_kg = 1.0", "mass_kg = -1.0", "part[2].mass_kg is -1.0, but it must be a positive "),
        ("radius_m = 1.0", "radius_m = 1.0\ninner_radius_m = 2.0",
         "part[1], a cylinder: inner_radius is 2.0, but it must be at most the radius, 1 m."),
        ("[[part]]", "[[prt]]", "prt is not a known key; did you mean part "),
        ("mass_kg = 12.0", "mass_kg = 1e308", "part[0].mass_kg is 1e+308, but it must be a "),
    ],
)  # fmt: skip
def test_bad_parts(program: Program, tmp_path: Path, old: str, new: str, expected: str) -> None:
    (tmp_path / "parts.toml").write_text(PARTS.replace(old, new), encoding="utf-8")
    done = program("inertia", "parts.toml")
    assert (done.returncode, done.stdout) == (2, "")
    assert expected in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("command", ["fit", "inertia"])
def test_help(program: Program, command: str) -> None:
    for words in (["--help"], [command, "--help"]):
        done = program(*words)
        assert (done.returncode, done.stderr) == (0, "")
        assert command in done.stdout
