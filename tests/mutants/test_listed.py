"""The list of mistakes stays true: each can still be made, and the tests beside it are there."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from tests.mutants.listed import ROOT, Mutant, mutants

LISTED = mutants()


def test_names_are_unique() -> None:
    assert [name for name, count in Counter(one.name for one in LISTED).items() if count > 1] == []


@pytest.mark.parametrize("mutant", LISTED, ids=lambda one: one.name)
def test_a_mistake_can_be_made_where_it_says(mutant: Mutant) -> None:
    text = (ROOT / mutant.file).read_text(encoding="utf-8")
    assert mutant.applied(text) != text
    assert mutant.wrong.endswith(".")
    assert mutant.tests
    for test in mutant.tests:
        file, _, name = test.partition("::")
        assert f"def {name}" in (ROOT / file).read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupted_run_leaves_no_copy_behind(stop: signal.Signals, tmp_path: Path) -> None:
    words = [sys.executable, "-m", "tests.mutants.run", LISTED[0].name]
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    with subprocess.Popen(words, cwd=ROOT, env=environment, stderr=subprocess.DEVNULL) as process:
        while not list(tmp_path.glob("*/0/tree/src")):
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(stop)
    assert process.returncode != 0
    assert list(tmp_path.iterdir()) == []
