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
    reported = json.loads(program("verify", "--json").stdout)
    assert reported["failed"] == 0
    assert reported["passed"] == len(reported["cases"])
    for case in reported["cases"]:
        assert case["passed"] is True
        assert abs(case["value"] - case["expected"]) <= case["tolerance"]
        assert case["claim"]
        assert case["source"]


@pytest.mark.slow
def test_reproduce(program: Program, tmp_path: Path) -> None:
    done = program("reproduce", "--quick", "--seeds", 1, "--out", "deep/out")
    assert (done.returncode, done.stderr) == (0, "")
    report = Path("deep/out/report.html")
    assert done.stdout.splitlines()[-1] == f"The report: {report}"
    assert "printed_matrix" in done.stdout
    assert "<html" in (tmp_path / report).read_text(encoding="utf-8")
    flights = (tmp_path / "deep/out/flights.jsonl").read_bytes()

    again = program("reproduce", "--quick", "--seeds", 1, "--out", "deep/out", "--json")
    assert again.returncode == 0
    results = Path("deep/out/results.json")
    assert again.stderr == f"omnimorph: replaced what was there: {results}.\n"
    reported = json.loads(again.stdout)
    assert reported["report"] == str(report)
    assert (reported["seeds"], reported["quick"]) == ([0], True)
    assert (tmp_path / "deep/out/flights.jsonl").read_bytes() == flights, "nothing is flown twice"
    assert [path.name for path in Path(tmp_path, "deep").iterdir()] == ["out"]


@pytest.mark.slow
def test_interrupting_the_reproduction_keeps_the_flights(
    interrupted: Callable[..., tuple[int, bytes]], tmp_path: Path
) -> None:
    code, reported = interrupted(b"one imperfection", "reproduce", "--quick", "--out", "deep/out")
    assert code == 130
    assert b"finished flights are kept in deep/out/flights.jsonl" in reported
    assert b"the same command goes on from there." in reported
    assert b"Traceback" not in reported
    assert [path.name for path in Path(tmp_path, "deep/out").iterdir()] == ["flights.jsonl"]


@pytest.mark.slow
def test_bench(program: Program) -> None:
    done = program("bench", "--rounds", 1)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split()[:6] == ["median", "lowest", "highest", "unit", "target", "what"]
    assert "`omnimorph --help`" in done.stdout
    assert "processor: " in done.stdout

    reported = json.loads(program("bench", "--rounds", 1, "--json").stdout)
    rows = {row["name"]: row for row in reported["measurements"]}
    assert rows["core_case_a_steps_per_s"]["median"] > 0
    assert rows["cold_flight_MB"]["rounds"] == 1
