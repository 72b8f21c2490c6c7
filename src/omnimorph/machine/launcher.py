"""Run a command in an empty folder of its own; print its wall time and peak memory as JSON.

The command is ended, with all that it has started, when standard input ends or says anything: a
pipe from a process ends with that process. Its output is thrown away.

Run as a program of its own, with the standard library alone, so that it is small: the peak memory
that the system reports of a process begins with what its parent held.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from tempfile import TemporaryDirectory

_PATIENCE = 5.0  # s between asking the command to end and ending it


def launch(command: list[str]) -> int:
    """Run a command and print what it took; return its exit code."""
    with TemporaryDirectory(prefix="omnimorph-", ignore_cleanup_errors=True) as folder:
        began = time.perf_counter()
        process = subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            process_group=0,  # by which all that it starts is found
        )
        signal.signal(signal.SIGTERM, lambda number, frame: _signal(process.pid, number))
        threading.Thread(target=_end_when_asked, args=(process.pid,), daemon=True).start()
        _, status, used = os.wait4(process.pid, 0)
        wall = time.perf_counter() - began
        process.returncode = os.waitstatus_to_exitcode(status)
        _signal(process.pid, signal.SIGKILL)  # what it left behind
    to_MB = 1e-6 if sys.platform == "darwin" else 1024e-6  # bytes there, KiB elsewhere
    with suppress(BrokenPipeError):  # nobody is left to report to
        sys.stdout.write(json.dumps({"wall_s": wall, "memory_MB": used.ru_maxrss * to_MB}))
        sys.stdout.flush()
    return process.returncode


def _end_when_asked(group: int) -> None:
    os.read(sys.stdin.fileno(), 1)
    _signal(group, signal.SIGTERM)
    time.sleep(_PATIENCE)
    _signal(group, signal.SIGKILL)


def _signal(group: int, number: int) -> None:
    with suppress(ProcessLookupError, PermissionError):  # all of it has ended
        os.killpg(group, number)


if __name__ == "__main__":
    sys.exit(launch(sys.argv[1:]))
