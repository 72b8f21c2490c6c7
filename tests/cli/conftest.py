"""The command line as its users have it: a process of its own, in an empty folder."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.left_processes import omnimorph_command

import omnimorph

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


@pytest.fixture
def program(environment: dict[str, str], tmp_path: Path) -> Program:
    """Run ``omnimorph WORD ...`` in an empty folder, to its end."""

    def run(*words: object, **options: Any) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "omnimorph", *map(str, words)]
        settings: dict[str, Any] = {"cwd": tmp_path, "env": environment, "timeout": 120.0}
        settings |= {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
        done: subprocess.CompletedProcess[str]
        done = subprocess.run(command, text=True, check=False, **settings)
        return done

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
