"""`omnimorph analyze`: what it says, what it writes, what it refuses."""

from __future__ import annotations

import json
import math
import re
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

Program = Callable[..., "subprocess.CompletedProcess[str]"]

HEAD = """
schema = 1
name = "mine"
title = "Four rotors or fewer"
inertia_kg_m2 = [0.0115, 0.0114, 0.0194]
mass_kg = {mass}
[rotor_defaults]
thrust_coefficient_N_per_Hz2 = 6.5e-4
drag_coefficient_Nm_per_Hz2 = 1e-5
speed_min_Hz = 16.0
speed_max_Hz = 100.0
"""
ROTOR = """
[[rotor]]
position_m = [{x}, {y}, 0.0]
spin = "{spin}"
"""
CORNERS = (
    ("0.2", "0.0", "ccw"),
    ("0.0", "0.2", "cw"),
    ("-0.2", "0.0", "ccw"),
    ("0.0", "-0.2", "cw"),
)
QUADROTOR = "".join(ROTOR.format(x=x, y=y, spin=spin) for x, y, spin in CORNERS)
COINCIDENT = "".join(ROTOR.format(x="0.1", y="0.1", spin="ccw") for _ in range(4))


def vehicle(folder: Path, rotors: str, mass: float = 1.28) -> str:
    path = folder / "mine.toml"
    path.write_text(HEAD.format(mass=mass) + rotors, encoding="utf-8")
    return str(path)


def numbers_in(value: Any) -> Iterator[float]:
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for item in value:
            yield from numbers_in(item)
    elif isinstance(value, float):
        yield value


def keys_of(value: dict[str, Any]) -> Iterator[str]:
    for key, item in value.items():
        yield key
        for part in item if isinstance(item, list) else [item]:
            if isinstance(part, dict):
                yield from keys_of(part)


def test_it_answers_in_words(program: Program, tmp_path: Path) -> None:
    done = program("analyze", "omnimorph")
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"^ +0 +4 +5 .* 111\.4 +17\.73 ", done.stdout, re.MULTILINE)
    assert re.search(r"^ +60 +6 +6 .* 315\.09 +50\.148 ", done.stdout, re.MULTILINE)
    assert "every attitude, zero moment   38.18° to 60° " in done.stdout
    assert "every attitude, free moments  37.00° to 60° " in done.stdout
    assert "38.18° to 69.73°" in done.stdout  # beyond its limits
    assert "in still air beyond 30.93°, with interference beyond 40.44°" in done.stdout
    assert list(tmp_path.iterdir()) == []


def test_it_answers_programs_with_the_keys_that_are_documented(program: Program) -> None:
    done = program("analyze", "omnimorph", "--tilt", 45, "--json")
    assert (done.returncode, done.stderr) == (0, "")
    reported = json.loads(done.stdout)
    assert reported["schema"] == "omnimorph.analysis"
    assert reported["tilt_limits_deg"] == [0.0, 60.0]
    (asked,) = [one for one in reported["at_tilt"] if one["tilt_deg"] == [45.0]]
    forces = asked["force_zero_moment"]
    assert forces["radius_N"] == pytest.approx(2.7478 * 5.3587, abs=3e-4)
    for normal, offset in zip(forces["normals"], forces["offsets_N"], strict=True):
        reach = max(np.asarray(forces["vertices_N"]) @ normal)
        assert reach == pytest.approx(offset, abs=1e-9)
    low, high = reported["hovering_range_deg"]["every_attitude_zero_moment"][0]
    assert (low, high) == pytest.approx((38.18346, 60.0), abs=1e-5)
    assert reported["sweep"]["condition_number"][0] is None

    page = (Path(__file__).parents[2] / "docs" / "analysis.md").read_text(encoding="utf-8")
    assert "`…_whole_turn`" in page
    documented = re.compile(r"(?:(?<=`)|(?<=\.))(\w+)`")
    assert {key.removesuffix("_whole_turn") for key in keys_of(reported)} <= set(
        documented.findall(page)
    )


@pytest.mark.slow
def test_the_page_is_written(program: Program, tmp_path: Path) -> None:
    done = program("analyze", "omnimorph", "--out", "deep/out")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-1] == f"The page: {Path('deep/out/analysis.html')}"
    out = tmp_path / "deep" / "out"
    assert "<html" in (out / "analysis.html").read_text(encoding="utf-8")
    assert list((out / "figures").glob("*.svg"))
    assert json.loads((out / "results.json").read_text(encoding="utf-8"))["schema_version"] == 1

    again = program("analyze", "omnimorph-2026", "--out", "deep/out")
    assert again.returncode == 0
    older = Path("deep/out/results.json")
    assert again.stderr == f"omnimorph: replaced what was there: {older}.\n"
    assert [path.name for path in Path(tmp_path, "deep").iterdir()] == ["out"]


def test_a_folder_of_others_is_refused(program: Program, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    done = program("analyze", "omnimorph", "--out", ".")
    assert done.returncode == 2
    assert done.stderr == (
        "omnimorph: .: the folder is not empty and not one of ours; give a new or an empty one.\n"
    )
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (
            ["--tilt", "75"],
            "vehicle omnimorph: tilt is 75°, but it must be from 0° to 60°, as far as servo tilt "
            "turns; beyond_limits (--beyond-limits) analyses it all the same.",
        ),
        (
            ["--tilt", "steep"],
            'the command line: --tilt is "steep", but it must be a number of degrees, or one for '
            "each servo with commas between, from -1e5 to 1e5.",
        ),
        (["--tilt", "1,2"], "vehicle omnimorph: --tilt is [1.0, 2.0], but it must be one angle."),
        (["--tilt", "nan"], 'the command line: --tilt is "nan", but it must be a number of'),
    ],
)
def test_a_tilt_that_cannot_be_used(program: Program, words: list[str], expected: str) -> None:
    done = program("analyze", "omnimorph", *words)
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"omnimorph: {expected}")


def test_beyond_the_limits_if_asked(program: Program) -> None:
    reported = json.loads(
        program("analyze", "omnimorph", "--tilt", 75, "--beyond-limits", "--json").stdout
    )
    (asked,) = [one for one in reported["at_tilt"] if one["tilt_deg"] == pytest.approx([75.0])]
    assert asked["level_hover"] == {
        "feasible": False,
        "power_W": None,
        "power_paper": None,
        "thrust_N": None,
        "speed_Hz": None,
    }
    assert asked["moment_at_level_hover"]["dimension"] == -1


@pytest.mark.parametrize(
    ("rotors", "mass", "lift", "rank", "hovers"),
    [
        (QUADROTOR, 1.28, 26.0, 4, True),
        (QUADROTOR, 5.0, 26.0, 4, False),  # too heavy for its rotors
        (ROTOR.format(x="0.0", y="0.0", spin="ccw"), 0.3, 0.0, 1, False),  # it would spin up
        (COINCIDENT, 1.28, 0.0, 1, False),
    ],
)
def test_vehicles_that_can_do_little(
    program: Program, tmp_path: Path, rotors: str, mass: float, lift: float, rank: int, hovers: bool
) -> None:
    reported = json.loads(program("analyze", vehicle(tmp_path, rotors, mass), "--json").stdout)
    (only,) = reported["at_tilt"]
    assert only["rank_thrust"] == rank
    assert only["largest_lift_N"] == pytest.approx(lift, abs=1e-9)
    assert only["level_hover"]["feasible"] is hovers
    assert only["force_zero_moment"]["radius_N"] == 0.0
    assert reported["morphing_trade"] is None
    assert all(math.isfinite(number) for number in numbers_in(reported))


def test_a_vehicle_without_servos(program: Program, tmp_path: Path) -> None:
    path = vehicle(tmp_path, QUADROTOR)
    done = program("analyze", path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "It can hover level: yes; in every attitude: no" in done.stdout
    assert not re.search(r"\b(nan|inf)\b", done.stdout)

    refused = program("analyze", path, "--tilt", 10)
    assert refused.returncode == 2
    assert "left out, as the vehicle has no servos" in refused.stderr


def test_limits_of_zero_are_refused(program: Program, tmp_path: Path) -> None:
    path = vehicle(tmp_path, QUADROTOR)
    text = (
        Path(path).read_text(encoding="utf-8").replace("speed_max_Hz = 100.0", "speed_max_Hz = 0")
    )
    Path(path).write_text(text.replace("speed_min_Hz = 16.0", "speed_min_Hz = 0"), encoding="utf-8")
    done = program("analyze", path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "speed_max_Hz is 0, but it must be a positive number, from 0.001 to" in done.stderr
