"""Values of flights that are kept to the last bit: a hash of each column, and the outcome."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import omnimorph as om

VALUES = Path(__file__).with_name("golden_flights.toml")

COLUMNS: tuple[str, ...] = ("p_WB", "R_WB", "v_WB", "w_WB_B", "speed", "tilt_actual")
COLUMNS += ("thrust_actual", "thrust_command")
COLUMNS += ("tilt_command", "wrench_asked", "wrench_achieved", "cost", "kkt_residual", "active")

Trace = Mapping[str, Any]
"""What one flight left behind: arrays by the names of their columns, and the outcome."""


def trace_of(run: om.Run) -> Trace:
    """Return the columns that are kept, and the outcome."""
    return {name: getattr(run, name) for name in COLUMNS} | {"outcome": run.outcome.name}


def hash_of(columns: Iterable[ArrayLike]) -> str:
    """Return a hash of the shapes and bytes of some arrays.

    What is no number counts as such, whatever its bits: which of two operands hands its own on is
    for the compiler to choose.
    """
    digest = hashlib.sha256()
    for column in columns:
        numbers = np.array(column, dtype="<f8")
        numbers[np.isnan(numbers)] = np.nan
        digest.update(repr(numbers.shape).encode() + numbers.tobytes())
    return digest.hexdigest()[:16]


def values_of(traces: list[Trace]) -> dict[str, str]:
    """Return the hash of each column, over all flights of a batch, and their outcomes."""
    outcomes = [str(trace["outcome"]) for trace in traces]
    if len(set(outcomes)) == 1:
        del outcomes[1:]
    names = [name for name in traces[0] if name != "outcome"]
    hashes = {name: hash_of(trace[name] for trace in traces) for name in names}
    return hashes | {"outcome": " ".join(outcomes)}


def kept_values() -> dict[str, dict[str, str]]:
    """Return the values that are kept, by the names of the flights."""
    return tomllib.loads(VALUES.read_text(encoding="utf-8"))


def differing(flown: Mapping[str, str], kept: Mapping[str, str]) -> list[str]:
    """Return the names of what is not as it was."""
    return [name for name in {**kept, **flown} if flown.get(name) != kept.get(name)]


def as_file(values: Mapping[str, Mapping[str, str]]) -> str:
    """Return the text of the file that keeps the values."""
    lines = [
        "# A hash of each column of the flights of golden_flights.py, and how they ended. Written",
        "# by `python -m tests.physics.golden_flights`, edited by nobody.",
    ]
    for name, kept in values.items():
        lines += ["", f'["{name}"]', *(f'{column} = "{value}"' for column, value in kept.items())]
    return "\n".join(lines) + "\n"
