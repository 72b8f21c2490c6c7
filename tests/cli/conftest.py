"""The command line as its users have it: a process of its own, in an empty folder."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from tests.forked import Forked
from tests.left_processes import omnimorph_command

import omnimorph
from omnimorph.cli.main import COMMANDS

Program = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture(scope="session")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The environment of the processes: this omnimorph, warnings are errors."""
    own = {"COLUMNS", "LINES", "PYTHONPATH"}
    found = {name: value for name, value in os.environ.items() if name not in own}
    if found.pop("PYTHONDONTWRITEBYTECODE", ""):  # compile once, not in every process
        found["PYTHONPYCACHEPREFIX"] = str(tmp_path_factory.mktemp("bytecode"))
    package = str(Path(omnimorph.__file__).parents[1])
    return found | {"PYTHONPATH": package, "PYTHONWARNINGS": "error"}


@pytest.fixture(scope="session")
def forked(environment: dict[str, str]) -> Iterator[Forked]:
    """A process that has imported what commands need, and later need."""
    later = "matplotlib.backends.backend_svg, jinja2, h5py, omnimorph.report.analysis_page"
    needs = sorted({name for one in COMMANDS.values() for name in one.NEEDS})
    process = Forked(f"import runpy, sys, {', '.join(needs)}, {later}", environment)
    yield process
    process.close()


@pytest.fixture
def program(forked: Forked, tmp_path: Path) -> Program:
    """Run ``python -m omnimorph WORD ...`` in an empty folder, to its end."""

    def run(*words: object) -> subprocess.CompletedProcess[str]:
        arguments = ["omnimorph", *map(str, words)]
        as_module = 'runpy.run_module("omnimorph", run_name="__main__")'
        return forked.run(f"sys.argv = {arguments!r}; {as_module}", tmp_path)

    return run


@pytest.fixture
def interrupted(environment: dict[str, str], tmp_path: Path) -> Callable[..., tuple[int, bytes]]:
    """Run ``omnimorph WORD ...`` on a terminal and press Ctrl-C when something is seen there."""

    def run(seen: bytes, *words: str) -> tuple[int, bytes]:
        ours, theirs = pty.openpty()
        process = subprocess.Popen(
            omnimorph_command(*words),
            env=environment | {"TERM": "xterm"},
            cwd=tmp_path,
            stdout=subprocess.DEVNULL,
            stderr=theirs,
        )
        os.close(theirs)
        reported, pressed, deadline = b"", False, time.monotonic() + 100.0
        while time.monotonic() < deadline:
            readable, _, _ = select.select([ours], [], [], 0.1)
            try:
                reported += os.read(ours, 4096) if readable else b""
            except OSError:  # how Linux tells the end of a terminal
                break
            if seen in reported and not pressed:
                process.send_signal(signal.SIGINT)
                pressed = True
        os.close(ours)
        return process.wait(timeout=10.0), reported

    return run
