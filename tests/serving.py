"""Commands that serve a page, run as real processes."""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from tests.left_processes import omnimorph_command


class Served(NamedTuple):
    """A command that serves a page: where, since when, and its process."""

    url: str
    seconds: float
    process: subprocess.Popen[str]

    def stopped(self) -> tuple[int, str, str]:
        """Press Ctrl-C; return the exit code and what it said."""
        self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=30)
        return self.process.returncode, out, err


@contextmanager
def served(*words: str, folder: Path) -> Iterator[Served]:
    """Run `omnimorph` with some words until its page is there."""
    began = time.monotonic()
    command = omnimorph_command(*words, "--port", 0, "--no-browser")
    process = subprocess.Popen(
        command,
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield Served(_address(process), time.monotonic() - began, process)
    finally:
        process.kill()
        process.communicate()


def _address(process: subprocess.Popen[str]) -> str:
    assert process.stderr is not None
    said = ""
    ends = time.monotonic() + 60.0
    while time.monotonic() < ends:
        if select.select([process.stderr], [], [], 0.5)[0]:
            line = os.read(process.stderr.fileno(), 4096).decode()
            if not line:
                break
            said += line
        found = re.search(r"the page is at (http://[\d.]+:\d+/[\w-]+/) ", said)
        if found:
            return found[1]
    raise AssertionError(f"no page: {said}")
