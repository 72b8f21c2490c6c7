"""What we start ends with us, when we are killed and have no say in it, too."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tests.left_processes import marked

from omnimorph.machine.children import started
from omnimorph.studies.processes import busy_pool

_FORKED = """
import time
from omnimorph.studies.processes import busy_pool
pool = busy_pool(3)
waiting = [pool.submit(time.sleep, 0.0) for _ in range(9)]
[task.result() for task in waiting]
time.sleep(1000)
"""
_BUSY = """
import time
from omnimorph.studies.processes import busy_pool
pool = busy_pool(2)
tasks = [pool.submit(time.sleep, 1000) for _ in range(4)]
time.sleep(1000)
"""
_SPAWNED = """
import os, time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from omnimorph.machine.children import end_with
if __name__ == "__main__":
    pool = ProcessPoolExecutor(1, get_context("spawn"), end_with, (os.getpid(),))
    pool.submit(os.getpid).result()
    time.sleep(1000)
"""
_STARTED = """
import time
from omnimorph.machine.children import started
with started(["sh", "-c", "sleep 1000 & sleep 1000 & wait"]):
    time.sleep(1000)
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM], ids=["kill", "term"])
@pytest.mark.parametrize(
    ("program", "count"),
    [(_FORKED, 4), (_BUSY, 3), (_SPAWNED, 3), (_STARTED, 5)],
    ids=["forked", "busy", "spawned", "started"],
)
def test_nothing_is_left_of_a_killed_process(
    tmp_path: Path, program: str, count: int, number: signal.Signals
) -> None:
    """`count`: with the workers, or the resource tracker, or the one that looks after a shell."""
    (tmp_path / "program.py").write_text(program)
    folder = tmp_path / "temporary"
    folder.mkdir()
    with marked([sys.executable, "program.py"], tmp_path, TMPDIR=str(folder)) as run:
        run.wait_for(count)
        run.process.send_signal(number)
        assert run.left() == []
        assert run.process.returncode == -number
    assert list(folder.iterdir()) == [], "the folder of what was started is removed"


def test_what_is_started_has_a_folder_of_its_own(tmp_path: Path) -> None:
    where = tmp_path / "where"
    with started(["sh", "-c", f"pwd > {where}; touch here; exit 7"]) as process:
        assert process.wait(timeout=60) == 7
    assert not Path(where.read_text().strip()).exists()


@pytest.mark.slow
def test_what_does_not_want_to_end_is_ended(tmp_path: Path) -> None:
    started_it = tmp_path / "started"
    stubborn = f"trap '' TERM; touch {started_it}; while :; do sleep 0.1; done"
    with started(["sh", "-c", stubborn]) as process:
        while not started_it.exists():
            time.sleep(0.01)
    assert process.returncode is not None
    assert process.returncode != 0


def test_a_program_that_is_not_there_is_reported() -> None:
    with started(["no-such-program"], output=subprocess.PIPE) as process:
        _, complaint = process.communicate(timeout=60)
    assert process.returncode != 0
    assert "no-such-program" in complaint


def test_a_pool_answers_and_goes() -> None:
    with busy_pool(2) as pool:
        assert list(pool.map(abs, [-1, 2, -3])) == [1, 2, 3]
