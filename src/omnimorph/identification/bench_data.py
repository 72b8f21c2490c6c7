"""What a thrust bench recorded: time, speed, force, torque and, if it is known, the command."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.arrays import as_numbers
from omnimorph.design.csv_tables import read_csv_table
from omnimorph.design.documents import record_or_file
from omnimorph.design.ranges import Range
from omnimorph.errors import MISSING, InputError
from omnimorph.identification.unit_hints import check_ratio
from omnimorph.protocols import FloatArray
from omnimorph.units import SPEED_UNITS, from_SI, to_SI, unit_of

_SPEEDS = tuple(f"speed_{unit}" for unit in SPEED_UNITS)
_COMMANDS = tuple(f"command_{unit}" for unit in SPEED_UNITS)
_ALWAYS = ("time_s", "force_N", "torque_Nm")
_RANGES = {
    "time": Range(-1e9, 1e9),
    "speed": Range(-1e6, 1e6),
    "force": Range(-1e9, 1e9),
    "torque": Range(-1e9, 1e9),
    "command": Range(-1e6, 1e6),
}
"""Of what a bench records, in SI."""
_APART = 1e-9  # s, the least time from one row to the next
STILL = 1e-6  # rad/s: a rotor that turns no faster rests
_SAME = 0.02  # two columns of one speed agree this well, relative


@dataclass(frozen=True, eq=False, kw_only=True)
class BenchData:
    """One run of one rotor on a thrust bench.

    Attributes
    ----------
    time : (K,) array, s
        Increasing.
    speed : (K,) array, rad/s
        Signed: negative while the rotor turns the other way round.
    force : (K,) array, N
        Along the rotor's axis, of the same sign as the speed.
    torque : (K,) array, N m
        About the rotor's axis: the drag, of the sign of the speed, or what the bench feels, of the
        other sign.
    command : (K,) array, rad/s, optional
        The speed that was asked for.
    source : str
        What messages call the data.
    lines : tuple of int
        Where each row stands in its file; rows are counted from 1 if there is none.

    Raises
    ------
    InputError
        If a number is not finite or beyond its range, the lengths differ or the time does not
        increase by 1 ns or more.
    """

    time: FloatArray
    speed: FloatArray
    force: FloatArray
    torque: FloatArray
    command: FloatArray | None = None
    source: str = "the bench data"
    lines: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        columns = ["time", "speed", "force", "torque"]
        for name in columns if self.command is None else [*columns, "command"]:
            object.__setattr__(self, name, self._checked(name, getattr(self, name)))
        if not self.lines:
            object.__setattr__(self, "lines", tuple(range(1, len(self.time) + 1)))
        late = np.flatnonzero(np.diff(self.time) < _APART)
        if late.size:
            row = int(late[0])
            allowed = (
                f"later than the time before it, {self.time[row]:g} s, by {_APART:g} s or more"
            )
            key = f"line {self.lines[row + 1]}, time"
            raise InputError.at(self.source, key, f"{self.time[row + 1]:g} s", allowed)

    def _checked(self, name: str, value: ArrayLike) -> FloatArray:
        array = as_numbers(value).copy()
        limits = _RANGES[name]
        if array.ndim != 1 or not ((array >= limits.least) & (array <= limits.most)).all():
            allowed = f"one row of finite numbers {limits} in SI"
            raise InputError.at(self.source, name, value, allowed)
        if array.size != np.size(self.time):
            allowed = f"{np.size(self.time)}, as there are times"
            raise InputError.at(self.source, f"number of values of {name}", array.size, allowed)
        array.setflags(write=False)
        return array


BenchLike = BenchData | str | os.PathLike[str]
"""Bench data, or the file of them."""


def as_bench(bench: BenchLike) -> BenchData:
    """Return bench data that may be given as `read_bench` takes them; refuse anything else."""
    return record_or_file(bench, BenchData, "bench", read_bench, InputError)


def read_bench(path: str | os.PathLike[str]) -> BenchData:
    """Read a run of a thrust bench from a CSV file.

    Parameters
    ----------
    path : str or Path
        A text file whose first line names the columns, in any order: ``time_s``, ``force_N``,
        ``torque_Nm``, at least one of ``speed_Hz``, ``speed_rad_per_s``, ``speed_rpm`` and, if the
        command was recorded, one of ``command_Hz``, ``command_rad_per_s``, ``command_rpm``.

    Returns
    -------
    BenchData
        In SI.

    Raises
    ------
    InputError
        If the file cannot be read, a column is missing, a value is no number, the time does not
        increase, or two speed columns contradict each other: one sentence, which names the unit
        that was most likely meant.
    """
    path = os.fspath(path) if isinstance(path, os.PathLike) else path  # refused, if it is neither
    table = read_csv_table(path, partial(_check_columns, path), column_ranges(), InputError)
    columns = dict(zip(table.columns, table.rows.T, strict=True))
    speeds = [name for name in _SPEEDS if name in columns]
    _check_same(str(path), speeds, columns)
    commands = [name for name in _COMMANDS if name in columns]
    if speeds and commands:
        _check_command(str(path), speeds[0], commands[0], columns)
    return BenchData(
        time=columns["time_s"],
        speed=_in_SI(speeds[0], columns),
        force=columns["force_N"],
        torque=columns["torque_Nm"],
        command=_in_SI(commands[0], columns) if commands else None,
        source=str(path),
        lines=tuple(table.lines),
    )


def column_ranges() -> dict[str, Range]:
    """Return the range of each column that a file may have, in its own unit."""
    found = {}
    for name in (*_ALWAYS, *_SPEEDS, *_COMMANDS):
        unit = unit_of(name)
        limits = _RANGES[name.removesuffix(f"_{unit}")]
        found[name] = Range(from_SI(limits.least, unit), from_SI(limits.most, unit))
    return found


def _in_SI(name: str, columns: dict[str, FloatArray]) -> FloatArray:
    return to_SI(columns[name], unit_of(name))


def _check_columns(path: str, columns: list[str]) -> None:
    known = (*_ALWAYS, *_SPEEDS, *_COMMANDS)
    listed = f"{', '.join(_ALWAYS)}, one of {', '.join(_SPEEDS)}"
    allowed = f"there: the first line names the columns {listed}"
    for name in columns:
        if name not in known:
            raise InputError.unknown_key(path, f"line 1, column {name!r}", name, known)
    for name in _ALWAYS:
        if name not in columns:
            raise InputError.at(path, f"line 1, column {name}", MISSING, allowed)
    if not any(name in columns for name in _SPEEDS):
        raise InputError.at(path, "line 1, column speed_Hz", MISSING, allowed)
    if sum(name in columns for name in _COMMANDS) > 1:
        raise InputError(f"{path}: line 1 names several commands, but must name one or none.")


def _check_same(path: str, names: list[str], columns: dict[str, FloatArray]) -> None:
    """Refuse two columns of speed that disagree."""
    for other in names[1:]:
        first, second = (_in_SI(name, columns) for name in (names[0], other))
        ratio = _ratio(first, second)
        check_ratio(path, names[0], other, ratio)
        if not abs(ratio - 1.0) <= _SAME:
            sentence = f"{path}: {names[0]} and {other} do not give the same speed: "
            raise InputError(f"{sentence}the first is {ratio:.4g} times the second.", file=path)


def _check_command(path: str, speed: str, command: str, columns: dict[str, FloatArray]) -> None:
    """Refuse a command that is in another unit than its column says."""
    check_ratio(path, speed, command, _ratio(_in_SI(speed, columns), _in_SI(command, columns)))


def _ratio(first: FloatArray, second: FloatArray) -> float:
    """Return how many times the second the first is, as a rule; 1 if both rest all the time."""
    moving = np.abs(second) > max(0.02 * np.abs(second).max(initial=0.0), STILL)
    if moving.any():
        return float(np.median(np.abs(first[moving] / second[moving])))
    return math.inf if np.abs(first).max(initial=0.0) > STILL else 1.0
