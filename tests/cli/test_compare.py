"""`omnimorph compare`: the table, the JSON and the page say the same; what cannot fly says why."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

import omnimorph as om

Program = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_numbers_are_those_of_the_analysis_and_of_the_flight(
    program: Program, folder: Path
) -> None:
    done = program("compare", "quadrotor", "omnimorph", "--out", "out", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    reported = json.loads(done.stdout)
    assert json.loads((folder / "out" / "results.json").read_text(encoding="utf-8")) == reported
    rows = {row["vehicle"]: row for row in reported["vehicles"]}
    assert list(rows) == ["quadrotor", "omnimorph"]
    omnimorph = om.load_vehicle("omnimorph")
    found = om.analysis.platform(omnimorph)
    assert rows["omnimorph"]["radius_over_weight"] == found.radius_over_weight
    assert rows["omnimorph"]["lateral_over_weight"] == found.lateral_over_weight
    assert rows["omnimorph"]["hover_power_W_per_kg"] == found.hover_power_per_kg
    flown = om.fly(om.load_scenario("tour").for_vehicle(omnimorph), seed=0).metrics
    assert rows["omnimorph"]["flight"] == flown.as_dict()
    assert rows["quadrotor"]["lateral_over_weight"] == 0
    assert rows["quadrotor"]["outcome"] == "completed"
    page = (folder / "out" / "comparison.html").read_text(encoding="utf-8")
    assert "omnimorph compare quadrotor omnimorph" in page
    assert {file.name for file in (folder / "out" / "figures").iterdir()} == {
        "scale.svg",
        "numbers.svg",
    }


@pytest.mark.slow
def test_what_cannot_fly_is_compared_and_says_why(program: Program, folder: Path) -> None:
    assert program("new-vehicle", "heavy").returncode == 0
    file = folder / "heavy.toml"
    text = file.read_text(encoding="utf-8").replace("mass_kg = 1.5 ", "mass_kg = 15.0 ")
    file.write_text(text, encoding="utf-8")
    done = program("compare", "heavy.toml", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    (row,) = json.loads(done.stdout)["vehicles"]
    assert row["flight"] is None
    assert row["hover_power_W_per_kg"] is None
    assert "heavy" in row["outcome"]
    shown = program("compare", "heavy.toml", "--out", "out")
    assert (shown.returncode, shown.stderr) == (0, "")
    assert "heavy" in shown.stdout
    assert row["outcome"] in (folder / "out" / "comparison.html").read_text(encoding="utf-8")
    again = program("compare", "heavy.toml", "--out", "out")
    results = Path("out", "results.json")
    assert (again.returncode, again.stderr) == (
        0,
        f"omnimorph: replaced what was there: {results}.\n",
    )


def test_mistakes_are_reported_before_anything_is_compared(program: Program, folder: Path) -> None:
    done = program("compare", "quadrotr")
    assert done.returncode == 2
    assert "quadrotor" in done.stderr
    (folder / "mine").mkdir()
    (folder / "mine" / "thesis.txt").write_text("my work", encoding="utf-8")
    done = program("compare", "quadrotor", "--out", "mine")
    assert done.returncode == 2
    assert "mine" in done.stderr
    assert [file.name for file in (folder / "mine").iterdir()] == ["thesis.txt"]
