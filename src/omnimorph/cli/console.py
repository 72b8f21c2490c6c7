"""What a command says: its answer on standard output, complaints and progress on standard error."""

from __future__ import annotations

import json
import math
import os
import shutil
import sys
import textwrap
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import Any, NamedTuple, Self, TextIO

from omnimorph.cli import interrupts
from omnimorph.errors import InputError, UnlikelyUnitWarning

_NARROWEST = 24  # columns: text is not wrapped more narrowly than this


class Answer(NamedTuple):
    """What a command found out.

    Attributes
    ----------
    text : str
        For people.
    data : object
        The same for programs: what ``--json`` prints.
    code : int
        The exit code.
    complaint : str
        One line for standard error, if all did not go well.
    """

    text: str
    data: Any
    code: int = 0
    complaint: str = ""

    def as_json(self) -> str:
        """Return the data as JSON; null for numbers that are not finite, which JSON lacks.

        In ASCII, so that a name comes through whole, whatever the terminal knows.
        """
        return json.dumps(_plain(self.data), indent=2, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def write(text: str) -> None:
    """Print a text on standard output, silently if its reader has left (``| head``).

    Raises
    ------
    InputError
        If standard output cannot be written, as on a full disk.
    """
    if sys.stdout is None:  # closed by whoever started us
        return
    if hasattr(sys.stdout, "reconfigure"):
        sys.stdout.reconfigure(errors="replace")  # a terminal may not know α
    try:
        sys.stdout.write(text.rstrip("\n") + "\n")
        sys.stdout.flush()
    except BrokenPipeError:
        _give_up(sys.stdout)
    except OSError as error:
        _give_up(sys.stdout)
        raise InputError(f"standard output cannot be written: {error.strerror}.") from error


def finish() -> None:
    """Print what is left in the buffer of standard output; be silent if its reader has left."""
    if sys.stdout is not None:
        try:
            sys.stdout.flush()
        except OSError:
            _give_up(sys.stdout)


@contextmanager
def printed_warnings() -> Iterator[None]:
    """Print each warning of an unlikely unit on standard error, once and in one line."""
    printed: set[str] = set()

    def show(message: Warning | str, category: type[Warning], *place: Any) -> None:
        if not issubclass(category, UnlikelyUnitWarning):
            others(message, category, *place)
        elif str(message) not in printed:
            printed.add(str(message))
            complain(str(message))

    with warnings.catch_warnings():
        others = warnings.showwarning
        warnings.showwarning = show  # type: ignore[assignment]
        warnings.simplefilter("always", UnlikelyUnitWarning)
        yield


def complain(text: str) -> None:
    """Print one line on standard error, with the program's name in front."""
    if sys.stderr is None:
        return
    try:
        sys.stderr.write(f"omnimorph: {' '.join(text.split())}\n")
        sys.stderr.flush()
    except OSError:
        _give_up(sys.stderr)


def _give_up(stream: TextIO) -> None:
    """Point a stream at nothing, so that the interpreter does not fail on it once more."""
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, stream.fileno())
    os.close(nothing)


def number(value: float | None, digits: int = 5) -> str:
    """Return a number to so many significant digits; a dash if there is none.

    Examples
    --------
    >>> number(1764.3456), number(0.25), number(None)
    ('1764.3', '0.25', '—')
    """
    return "—" if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


def brief(value: float) -> str:
    """Return a measured number to two digits, whole from 10 on, and never as 0 if it is not.

    Examples
    --------
    >>> brief(1354.2), brief(5.34), brief(0.0312), brief(123.0)
    ('1354', '5.3', '0.031', '123')
    """
    return f"{value:.0f}" if abs(value) >= 10.0 else f"{value:.2g}"


def counted(count: int, what: str) -> str:
    """Return a number of things in words.

    Examples
    --------
    >>> counted(1, "rotor"), counted(8, "rotor")
    ('1 rotor', '8 rotors')
    """
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def table(rows: Sequence[Sequence[str]], *, header: Sequence[str] = (), align: str = "") -> str:
    """Return rows of text as columns.

    On a terminal the last column is wrapped to its width, and stands below the others if there is
    no room beside them; in a pipe a row stays one line.

    Parameters
    ----------
    rows : sequence of rows of str
        All of one length.
    header : sequence of str
        Names of the columns; none by default.
    align : str
        ``l`` or ``r`` for each column but the last, which is left-aligned; left by default.

    Examples
    --------
    >>> print(table([["a", "1.5", "m"], ["bcd", "12", "kg"]], align="lr"))
    a    1.5  m
    bcd   12  kg
    """
    lines = [header, *rows] if header else list(rows)
    if not lines:
        return ""
    align = align.ljust(len(lines[0]), "l")
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)][:-1]
    indent = sum(widths) + 2 * len(widths)
    longest = max(len(line[-1]) for line in lines)
    below = indent + min(longest, _NARROWEST) > _terminal_width()
    text = []
    for line in lines:
        cells = [
            cell.rjust(size) if side == "r" else cell.ljust(size)
            for cell, size, side in zip(line, widths, align, strict=False)
        ]
        start = "  ".join(cells)
        if below:
            text += [start.rstrip(), *_wrapped(line[-1], 4)]
        else:
            first, *others = _wrapped(line[-1], indent) or [""]
            text += [f"{start}  {first.lstrip()}".rstrip() if cells else first, *others]
    if header:
        rules = ["-" * size for size in [*widths, len(header[-1])]]
        text.insert(text.index(text[0]) + 1 + below, "  ".join(rules[: len(rules) - below]))
    return "\n".join(text)


def _wrapped(text: str, indent: int) -> list[str]:
    room = max(_terminal_width() - indent, _NARROWEST)
    return [" " * indent + part for part in textwrap.wrap(text, room, break_long_words=False)]


def _terminal_width() -> int:
    is_terminal = sys.stdout is not None and sys.stdout.isatty()
    return shutil.get_terminal_size().columns if is_terminal else sys.maxsize


class Progress:
    """A bar on standard error for what takes longer than a second; none if that is no terminal.

    It is called with what is done and what there is to do, in any unit, and can be handed to
    whatever reports its progress in that way ::

        with Progress("flying") as progress:
            om.fly(scenario, progress=progress)
    """

    _PATIENCE = 0.4  # s before it is decided whether this takes longer than a second

    def __init__(self, label: str) -> None:
        self._label = label
        self._began = time.monotonic()
        self._wanted = sys.stderr is not None and sys.stderr.isatty()
        self._bar: Any = None

    def __enter__(self) -> Self:
        return self

    def __call__(self, done: float, total: float, label: str = "") -> None:
        """Show that `done` of `total` is done, and with what it goes on."""
        interrupts.renew()
        if not self._wanted:
            return
        if self._bar is None:
            spent = time.monotonic() - self._began
            if spent < self._PATIENCE or spent * total < done:
                return
            self._bar = _started_bar(self._label)
        description = f"{self._label} {label}".strip()
        self._bar.update(
            self._bar.task_ids[0], completed=done, total=total, description=description
        )

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()
        if error is None:
            interrupts.renew()


def _started_bar(label: str) -> Any:
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}"), BarColumn())
    bar = Bar(
        *columns,
        TaskProgressColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    bar.add_task(label)
    bar.start()
    return bar
