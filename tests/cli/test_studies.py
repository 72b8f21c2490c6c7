"""`omnimorph verify`, `omnimorph reproduce` and `omnimorph bench`, as a user runs them."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Program = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.mark.slow
def test_verify(program: Program) -> None:
    done = program("verify")
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    rows = [line for line in lines if line.startswith("passed ")]
    assert lines[-1] == f"{len(rows)} of {len(rows)} cases passed."
    assert len(rows) > 20
    assert any("free-fall: " in row for row in rows)


@pytest.mark.slow
def test_verify_for_programs(program: Program) -> None:
    told = json.loads(program("verify", "--json").stdout)
    assert told["failed"] == 0
    assert told["passed"] == len(told["cases"])
    for case in told["cases"]:
        assert case["passed"] is True
        assert abs(case["value"] - case["expected"]) <= case["tolerance"]
        assert case["claim"]
        assert case["source"]


@pytest.mark.slow
def test_reproduce(program: Program, tmp_path: Path) -> None:
    done = program("reproduce", "--seeds", 1, "--out", "deep/out")
    assert (done.returncode, done.stderr) == (0, "")
    report = Path("deep/out/report.html")
    assert done.stdout.splitlines()[-1] == f"The report: {report}"
    assert "paper-case-a" in done.stdout
    assert "<html" in (tmp_path / report).read_text(encoding="utf-8")

    again = program("reproduce", "--seeds", 1, "--seed", 3, "--out", "deep/out", "--json")
    assert (again.returncode, again.stderr) == (0, "")
    told = json.loads(again.stdout)
    assert told["report"] == str(report)
    assert told["seeds"] == [3]
    assert [path.name for path in Path(tmp_path, "deep").iterdir()] == ["out"]


@pytest.mark.slow
def test_interrupting_the_reproduction_leaves_nothing(
    interrupted: Callable[..., tuple[int, bytes]], tmp_path: Path
) -> None:
    code, told = interrupted(b"reproducing the paper:", "reproduce", "--out", "deep/out")
    assert code == 130
    assert b"omnimorph: interrupted; nothing was written to deep/out." in told
    assert b"Traceback" not in told
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_bench(program: Program) -> None:
    done = program("bench", "--rounds", 1)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split()[:6] == ["median", "lowest", "highest", "unit", "target", "what"]
    assert "`omnimorph --help`" in done.stdout
    assert "processor: " in done.stdout

    told = json.loads(program("bench", "--rounds", 1, "--json").stdout)
    rows = {row["name"]: row for row in told["measurements"]}
    assert rows["core_case_a_steps_per_s"]["median"] > 0
    assert rows["cold_flight_MB"]["rounds"] == 1
