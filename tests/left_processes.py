"""Processes that are killed, and those that they leave, known by a mark in their environment."""

from __future__ import annotations

import os
import secrets
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import omnimorph

_MARK = "OMNIMORPH_TEST_MARK"
_PATIENCE = 60.0  # s in which what ends by itself has ended, however busy the machine is


class Marked:
    """A process and all that it starts, whoever their parent becomes."""

    def __init__(self, process: subprocess.Popen[str], mark: str) -> None:
        self.process, self._mark = process, f"{_MARK}={mark}".encode()

    def alive(self) -> list[int]:
        """Return the ids of those that have not ended."""
        return [int(entry.name) for entry in Path("/proc").glob("[0-9]*") if self._is_ours(entry)]

    def _is_ours(self, entry: Path) -> bool:
        try:
            if self._mark not in (entry / "environ").read_bytes().split(b"\0"):
                return False
            return (entry / "stat").read_text().rpartition(")")[2].split()[0] not in ("Z", "X")
        except OSError:  # it has ended meanwhile
            return False

    def wait_for(self, count: int) -> None:
        """Wait until there are so many, itself included, or it has ended."""
        while len(self.alive()) < count and self.process.poll() is None:
            time.sleep(0.01)

    def left(self) -> list[int]:
        """Wait for the process, then a while for the others; return those that do not end."""
        self.process.wait(timeout=120.0)
        ends = time.monotonic() + _PATIENCE
        while self.alive() and time.monotonic() < ends:
            time.sleep(0.05)
        return self.alive()


@contextmanager
def marked(command: list[str], folder: Path, **environment: str) -> Iterator[Marked]:
    """Run a command in a folder; whatever is left of it at the end is killed."""
    mark = secrets.token_hex(8)
    package = str(Path(omnimorph.__file__).parents[1])
    process = subprocess.Popen(
        command,
        cwd=folder,
        env=os.environ | {_MARK: mark, "PYTHONPATH": package} | environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    found = Marked(process, mark)
    try:
        with process:
            try:
                yield found
            finally:
                process.kill()
    finally:
        for number in found.alive():
            with suppress(ProcessLookupError):
                os.kill(number, signal.SIGKILL)


# A shell may have made its background jobs ignore Ctrl-C, and nohup the end of the terminal.
_OMNIMORPH = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)
from omnimorph.cli.main import main
sys.exit(main())
"""


def omnimorph_command(*words: object) -> list[str]:
    """Return the command line of `omnimorph WORD ...`, which no signal is kept from."""
    return [sys.executable, "-c", _OMNIMORPH, *map(str, words)]
