"""`omnimorph fly`: what it says, what it writes, what it leaves behind."""

from __future__ import annotations

import json
import re
import resource
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import omnimorph as om
from omnimorph.cli.fly import _as_text

Program = Callable[..., "subprocess.CompletedProcess[str]"]

# Four million steps of Runge and Kutta: no machine flies them in a second.
LONG = """
schema = 1
name = "long"
base = "hover"
[plant]
physics_step_ms = 0.05
control_period_ms = 0.05
integrator = "runge-kutta-4"
[reference]
kind = "segments"
start_position_m = [0.0, 0.0, 1.2]
[[reference.segment]]
duration_s = 200.0
"""

# A third of the thrust is not enough to stay aloft.
WORN = """
schema = 1
name = "worn"
base = "paper-case-a"
[plant]
[[plant.effect]]
kind = "speed-limits"
[[plant.effect]]
kind = "effectiveness"
share = 0.3
"""


def files_in(folder: Path) -> list[str]:
    """Everything below a folder, hidden files too."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_a_flight_is_reported_and_written(program: Program, tmp_path: Path) -> None:
    done = program("fly", "paper-case-a")
    assert (done.returncode, done.stderr) == (0, "")
    assert "The flight was completed." in done.stdout
    assert re.search(r"^position error, mean +[\d.]+  mm$", done.stdout, re.MULTILINE)
    assert re.search(r"^tilt, mean +[\d.]+  °$", done.stdout, re.MULTILINE)
    assert re.search(
        r"^45 s flown in [\d.]+ s: [\d.]+ times real time\.$", done.stdout, re.MULTILINE
    )
    folder = Path("runs", "paper-case-a-seed0")
    assert f"Written to {folder}: run.nc, metrics.json." in done.stdout
    assert files_in(tmp_path / folder) == ["metrics.json", "run.nc"]

    run = om.load_run(tmp_path / folder / "run.nc")
    assert run.outcome is om.Outcome.COMPLETED
    assert run.content_hash == om.fly(om.load_scenario("paper-case-a")).content_hash
    metrics = json.loads((tmp_path / folder / "metrics.json").read_text(encoding="utf-8"))
    assert metrics == run.metrics.as_dict()

    again = program("fly", "paper-case-a")
    older = f"{folder / 'run.nc'}, {folder / 'metrics.json'}"
    assert again.returncode == 0
    assert again.stderr == f"omnimorph: replaced what was there: {older}.\n"


def test_every_metric_is_in_the_table(program: Program) -> None:
    done = program("fly", "hover")
    count = len(om.fly(om.load_scenario("hover")).metrics.as_dict())
    table = done.stdout.split("\n\n")[2].splitlines()
    assert len(table) == count - 1  # the outcome is a sentence
    assert not any("_" in line.replace("‖e_R‖", "") for line in table)


def test_a_flight_for_programs(program: Program, tmp_path: Path) -> None:
    done = program("fly", "hover", "--json", "--seed", 7, "--out", "a/b")
    assert (done.returncode, done.stderr) == (0, "")
    reported = json.loads(done.stdout)
    assert (reported["scenario"], reported["plant"], reported["seed"]) == ("hover", "realistic", 7)
    assert reported["outcome"] == "completed"
    assert reported["real_time_factor"] > 0
    assert {name: Path(path) for name, path in reported["files"].items()} == {
        "run": Path("a/b/run.nc"),
        "metrics": Path("a/b/metrics.json"),
    }
    assert reported["metrics"] == json.loads((tmp_path / "a/b/metrics.json").read_text("utf-8"))
    assert files_in(tmp_path) == ["a", "a/b", "a/b/metrics.json", "a/b/run.nc"]

    scenario = om.load_scenario("hover")
    assert reported["content_hash"] == om.fly(scenario, seed=7).content_hash
    assert reported["content_hash"] != om.fly(scenario, seed=8).content_hash


def test_parts_in_python_are_allowed_and_named(program: Program, tmp_path: Path) -> None:
    Path(tmp_path, "my_parts.py").write_text(
        "def calm(time, state):\n    return [0.0] * 6\n", encoding="utf-8"
    )
    Path(tmp_path, "mine.toml").write_text(
        'schema = 1\nname = "mine"\nbase = "hover"\n'
        '[disturbance]\nkind = "python"\nobject = "my_parts:calm"\n',
        encoding="utf-8",
    )
    for command in ("fly", "scenarios"):
        refused = program(command, "mine.toml")
        assert refused.returncode == 2
        assert "--allow-code" in refused.stderr
    done = program("fly", "mine.toml", "--allow-code", "--out", "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert "\nin Python: disturbance my_parts:calm\n" in done.stdout
    shown = program("scenarios", "mine.toml", "--allow-code").stdout
    assert re.search(r"^disturbance.object +my_parts:calm$", shown, re.MULTILINE)
    assert re.search(r"^controller.kind +paper$", shown, re.MULTILINE)


def test_the_folder_is_named_for_what_was_flown(program: Program, tmp_path: Path) -> None:
    """A user's scenario, whose name must not lead out of the folder, in a user's plant."""
    Path(tmp_path, "my.toml").write_text(
        'schema = 1\nname = "../over there"\nbase = "hover"\n', encoding="utf-8"
    )
    Path(tmp_path, "rough.toml").write_text(
        'schema = 1\nname = "rough sea"\n[plant]\ncontrol_period_ms = 2.0\n', encoding="utf-8"
    )
    done = program("fly", "my.toml", "--plant", "rough.toml", "--seed", "3")
    assert (done.returncode, done.stderr) == (0, "")
    assert files_in(tmp_path / "runs") == [
        "over-there-rough-seed3",
        "over-there-rough-seed3/metrics.json",
        "over-there-rough-seed3/run.nc",
    ]


def test_a_flight_replaces_an_older_one_and_nothing_else(program: Program, tmp_path: Path) -> None:
    Path(tmp_path, "out").mkdir()
    for name in ("run.nc", "metrics.json", "notes.txt"):
        Path(tmp_path, "out", name).write_text("older", encoding="utf-8")
    assert program("fly", "hover", "--seed", 2, "--out", "out").returncode == 0
    assert om.load_run(tmp_path / "out" / "run.nc").provenance.seed == 2
    assert "older" not in Path(tmp_path, "out", "metrics.json").read_text(encoding="utf-8")
    assert files_in(tmp_path / "out") == ["metrics.json", "notes.txt", "run.nc"]


def test_a_lost_vehicle_is_said_and_kept(program: Program, tmp_path: Path) -> None:
    Path(tmp_path, "worn.toml").write_text(WORN, encoding="utf-8")
    done = program("fly", "worn.toml", "--out", "out")
    assert done.returncode == 3
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"omnimorph: worn: {om.Outcome.LOST.value} It flew ")
    assert om.Outcome.LOST.value in done.stdout
    run = om.load_run(tmp_path / "out" / "run.nc")
    assert run.outcome is om.Outcome.LOST
    assert 0.0 < run.time[-1] < 45.0
    assert line.endswith(f" It flew {run.time[-1]:g} s of 45 s.")
    metrics = json.loads((tmp_path / "out" / "metrics.json").read_text("utf-8"))
    assert metrics["outcome"] == "lost"


@pytest.mark.parametrize("older", [False, True])
def test_a_full_disk_leaves_what_was_there(
    environment: dict[str, str], tmp_path: Path, older: bool
) -> None:
    """The largest file the process may write is too small for the run."""
    if older:
        Path(tmp_path, "deep", "out").mkdir(parents=True)
        Path(tmp_path, "deep", "out", "metrics.json").write_text("older", encoding="utf-8")
    before = files_in(tmp_path)
    most = 500_000
    done = subprocess.run(
        [sys.executable, "-m", "omnimorph", "fly", "hover", "--out=deep/out"],
        cwd=tmp_path,
        env=environment | {"PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"omnimorph: {Path('deep/out/run.nc')}: it cannot be written: ")
    assert files_in(tmp_path) == before
    if older:
        assert Path(tmp_path, "deep", "out", "metrics.json").read_text("utf-8") == "older"


def test_interrupting_a_flight_leaves_nothing(
    interrupted: Callable[..., tuple[int, bytes]], tmp_path: Path
) -> None:
    """A long flight shows its progress on a terminal; Ctrl-C ends it there."""
    Path(tmp_path, "long.toml").write_text(LONG, encoding="utf-8")
    code, reported = interrupted(b"flying long", "fly", "long.toml", "--out", "deep/out")
    assert code == 130
    assert b"omnimorph: interrupted; nothing was written" in reported
    assert b"Traceback" not in reported
    assert files_in(tmp_path) == ["long.toml"]


@pytest.mark.parametrize(
    ("wall_time", "expected"),
    [(0.0332, "5 s flown in 0.033 s: 151"), (200.0, "200 s: 0.025"), (1234.0, "1234 s: 0.0041")],
)
def test_no_flight_is_zero_times_real_time(wall_time: float, expected: str) -> None:
    hover = om.load_scenario("hover")
    run = om.fly(hover)
    measured = replace(run.performance, wall_time=wall_time, real_time_factor=5 / wall_time)
    slow = replace(run, performance=measured)
    assert f"{expected} times real time." in _as_text(hover, slow, Path("out"))
