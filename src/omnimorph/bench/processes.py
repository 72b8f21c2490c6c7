"""Whole processes against the clock: what someone waits who starts the program once."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from typing import NamedTuple

from omnimorph.machine.children import started


class ProcessCost(NamedTuple):
    """What a process took: wall time in s, from its start to its end, and its peak memory in MB."""

    wall: float
    memory: float


def cost_of_flight() -> ProcessCost:
    """Fly Case A from the command line, all files written."""
    return _cost_of(["-m", "omnimorph", "fly", "paper-case-a", "--out", "run"])


def cost_of_analysis_page() -> ProcessCost:
    """Do the same and write the page with its figures."""
    return _cost_of(["-m", "omnimorph", "analyze", "omnimorph", "--out", "page"])


def cost_of_import() -> ProcessCost:
    """Start Python and import the package."""
    return _cost_of(["-c", "import omnimorph"])


def cost_of_help() -> ProcessCost:
    """Ask the command line for its help."""
    return _cost_of(["-m", "omnimorph", "--help"])


def _cost_of(arguments: Sequence[str]) -> ProcessCost:
    """Start Python with these arguments and wait for it.

    Raises
    ------
    RuntimeError
        If the process fails.
    """
    with started([sys.executable, *arguments], output=subprocess.PIPE) as process:
        answer, complaint = process.communicate()
    if process.returncode != 0:
        raise RuntimeError(f"{' '.join(arguments)} failed: {complaint.strip()}")
    cost = json.loads(answer)
    return ProcessCost(cost["wall_s"], cost["memory_MB"])
