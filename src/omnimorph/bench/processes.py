"""Whole processes against the clock: what someone waits who starts the program once."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

__all__ = [
    "ProcessCost",
    "cost_of_analysis_page",
    "cost_of_flight",
    "cost_of_help",
    "cost_of_import",
]

LAUNCHER = Path(__file__).with_name("launcher.py")


class ProcessCost(NamedTuple):
    """What a process took: wall time in s, from its start to its end, and its peak memory in MB."""

    wall: float
    memory: float


def cost_of_flight() -> ProcessCost:
    """Fly Case A from the command line, all files written."""
    with TemporaryDirectory(prefix="omnimorph-bench-") as folder:
        return _cost_of(["-m", "omnimorph", "fly", "paper-case-a", "--out", f"{folder}/run"])


def cost_of_analysis_page() -> ProcessCost:
    """Do the same and write the page with its figures."""
    with TemporaryDirectory(prefix="omnimorph-bench-") as folder:
        return _cost_of(["-m", "omnimorph", "analyze", "omnimorph", "--out", f"{folder}/page"])


def cost_of_import() -> ProcessCost:
    """Start Python and import the package."""
    return _cost_of(["-c", "import omnimorph"])


def cost_of_help() -> ProcessCost:
    """Ask the command line for its help."""
    return _cost_of(["-m", "omnimorph", "--help"])


def _cost_of(arguments: Sequence[str]) -> ProcessCost:
    """Start Python with these arguments and wait for it.

    A small process in between starts it: the peak memory that the system tells of a child begins
    with what its parent held, and this process holds many libraries.

    Raises
    ------
    RuntimeError
        If the process fails.
    """
    launch = [sys.executable, "-I", "-S", str(LAUNCHER), sys.executable, *arguments]
    answer = subprocess.run(launch, capture_output=True, text=True, check=False)
    if answer.returncode != 0:
        raise RuntimeError(f"{' '.join(arguments)} failed: {answer.stderr.strip()}")
    told = json.loads(answer.stdout)
    return ProcessCost(told["wall_s"], told["memory_MB"])
