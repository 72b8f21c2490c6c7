"""Run a command, its output thrown away, and print its wall time and peak memory as JSON.

Run as a program of its own, with the standard library alone, so that it is small.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time

__all__ = ["launch"]


def launch(command: list[str]) -> int:
    """Run a command and print what it took; return its exit code."""
    began = time.perf_counter()
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    wall = time.perf_counter() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    to_MB = 1e-6 if sys.platform == "darwin" else 1024e-6  # bytes there, KiB elsewhere
    sys.stdout.write(json.dumps({"wall_s": wall, "memory_MB": used.ru_maxrss * to_MB}))
    return process.returncode


if __name__ == "__main__":
    sys.exit(launch(sys.argv[1:]))
