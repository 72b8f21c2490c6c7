"""Thousands of bad files of every kind: each is read, or refused in a sentence; see `child`.

What else a case may end in, 10 s of computing or 1 GiB of memory included, fails. What once did is
kept in ``seeds``, a folder a kind, and is read again in the quick tests.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.forked import Forked
from tests.fuzz.kinds import KINDS

import omnimorph

SEEDS = Path(__file__).parent / "seeds"
CASES = dict.fromkeys(KINDS, 2000) | {"random-vehicle": 80}


@pytest.fixture(scope="module")
def forked() -> Iterator[Forked]:
    """A process for small cases that has imported what reads them."""
    process = Forked("from tests.fuzz import child", environment() | {"PYTHONWARNINGS": "error"})
    yield process
    process.close()


def environment() -> dict[str, str]:
    package, tests = Path(omnimorph.__file__).parents[1], Path(__file__).parents[2]
    return os.environ | {"PYTHONPATH": f"{package}:{tests}", "OPENBLAS_NUM_THREADS": "1"}


def fuzzed(folder: Path, *words: object) -> list[str]:
    """Read files of a kind in a process of its own; return what went wrong, a line each."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-m", "tests.fuzz.child", *map(str, words)],
        cwd=folder,
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
        timeout=900.0,
    )
    return failures_of(done)


def failures_of(done: subprocess.CompletedProcess[str]) -> list[str]:
    lines = done.stdout.splitlines()
    failures = [line for line in lines if line.startswith("failed ")]
    if done.returncode:
        last = [line for line in lines if line.startswith("begin ")][-1:]
        failures.append(f"{last} ended the process, {done.returncode}: {done.stderr[-3000:]}")
    return failures


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_bad_files_are_reported(kind: str, tmp_path: Path) -> None:
    assert fuzzed(tmp_path, "cases", kind, 0, CASES[kind]) == []


@pytest.mark.parametrize("kind", KINDS)
def test_what_once_failed_is_reported(kind: str, forked: Forked, tmp_path: Path) -> None:
    files = sorted(map(str, (SEEDS / kind).glob("*")))
    assert files
    assert failures_of(forked.run(f"child.main('files', {kind!r}, *{files!r})", tmp_path)) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "bug", "seen"),
    [
        ("parts", "no-ranges", "OverflowError"),
        ("plant", "no-ranges", "ZeroDivisionError"),
        ("bench", "waits", "Timeout"),
        ("bench", "computes", "in <lambda>"),
        ("bench", "hoards", "MemoryError"),
        ("run", "crashes", "ended the process"),
    ],
)
def test_a_planted_bug_is_found(kind: str, bug: str, seen: str, tmp_path: Path) -> None:
    failures = fuzzed(tmp_path, "cases", kind, 0, 200, bug)
    assert any(seen in failure for failure in failures)
