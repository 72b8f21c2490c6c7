"""Every example runs, and prints what its text promises."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))


def run(example: Path, folder: Path) -> str:
    """Run an example as a user does; return what it prints."""
    command = [sys.executable, "-W", "error", str(example)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


_SLOW = {"04_many_flights"}


@pytest.mark.parametrize(
    "example",
    [pytest.param(e, marks=[pytest.mark.slow] * (e.stem in _SLOW), id=e.stem) for e in EXAMPLES],
)
def test_example_runs(example: Path, tmp_path: Path) -> None:
    assert run(example, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_own_controller_flies_like_the_papers(tmp_path: Path) -> None:
    lines = run(EXAMPLES[0], tmp_path).splitlines()
    assert [line.split(": ")[-1] for line in lines if ": " in line] == [
        "The flight was completed."
    ] * 2


def test_before_building_tells_what_limits_and_what_pays(tmp_path: Path) -> None:
    lines = run(EXAMPLES[2], tmp_path).splitlines()
    assert lines[0].startswith("as it is: omnidirectional 38.2 to 60.0")
    slopes = [float(line.split(": ")[1].split()[0]) for line in lines[5:]]
    radius, per_degree, alone, less, per_newton, per_millimetre = slopes
    assert alone == 0.0
    assert less < 0.0
    assert radius == 14.72
    assert per_newton == 2.748  # the radius in shares of the largest thrust
    assert 0.0 < per_millimetre < per_degree


def test_worn_rotors_are_worse_until_the_vehicle_is_lost(tmp_path: Path) -> None:
    words = [line.split() for line in run(EXAMPLES[1], tmp_path).splitlines()]
    assert [line[4] for line in words] == ["completed", "completed", "completed", "lost"]
    errors = [float(line[-3]) for line in words[:3]]
    assert errors == sorted(errors)
