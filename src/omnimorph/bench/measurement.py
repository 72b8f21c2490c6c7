"""What was measured: `Measurement` is one number, `BenchReport` all and where they are from."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """One number, measured several times.

    Attributes
    ----------
    name : str
        Its key for programs; the unit is its last word.
    what : str
        What was measured, for people.
    unit : str
        Such as ``steps/s``.
    samples : tuple of float
        One for each round.
    target : float, optional
        What we aim at.
    aim : str
        ``at least`` the target or ``at most``.
    """

    name: str
    what: str
    unit: str
    samples: tuple[float, ...]
    target: float | None = None
    aim: Literal["at least", "at most"] = "at most"

    @property
    def median(self) -> float:
        """The middle of the samples."""
        return statistics.median(self.samples)

    @property
    def lowest(self) -> float:
        """The smallest sample."""
        return min(self.samples)

    @property
    def highest(self) -> float:
        """The largest sample."""
        return max(self.samples)

    def as_dict(self) -> dict[str, Any]:
        """Return the row for programs."""
        return {
            "name": self.name,
            "what": self.what,
            "unit": self.unit,
            "median": self.median,
            "lowest": self.lowest,
            "highest": self.highest,
            "rounds": len(self.samples),
            "target": self.target,
            "aim": None if self.target is None else self.aim,
        }

    def as_row(self) -> list[str]:
        """Return the cells of a table: median, lowest, highest, unit, target, what."""
        target = "" if self.target is None else f"{self.aim} {shown(self.target)}"
        numbers = [shown(value) for value in (self.median, self.lowest, self.highest)]
        return [*numbers, self.unit, target, self.what]


@dataclass(frozen=True, kw_only=True)
class BenchReport:
    """Everything one run of the measurements found out.

    Attributes
    ----------
    measurements : tuple of Measurement
        In the order of the table.
    provenance : mapping
        Machine, versions and date.
    notes : sequence of str
        What else there is to say: what is not installed, what a peer cannot run.
    """

    COLUMNS = ("median", "lowest", "highest", "unit", "target", "what")

    measurements: Sequence[Measurement]
    provenance: Mapping[str, str] = field(default_factory=dict)
    notes: Sequence[str] = ()

    def __getitem__(self, name: str) -> Measurement:
        return {row.name: row for row in self.measurements}[name]

    def as_dict(self) -> dict[str, Any]:
        """Return the report for programs, ready for JSON."""
        rows = [row.as_dict() for row in self.measurements]
        return {
            "provenance": dict(self.provenance),
            "measurements": rows,
            "notes": list(self.notes),
        }

    def as_rows(self) -> list[list[str]]:
        """Return the cells of the table, row by row; `COLUMNS` heads them."""
        return [row.as_row() for row in self.measurements]

    def as_text(self) -> str:
        """Return the table and, below it, the provenance, as plain text."""
        rows = [list(self.COLUMNS), *self.as_rows()]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = []
        for row in rows:
            numbers = [cell.rjust(width) for cell, width in zip(row[:3], widths, strict=False)]
            texts = [cell.ljust(width) for cell, width in zip(row[3:], widths[3:], strict=True)]
            lines.append("  ".join([*numbers, *texts]).rstrip())
        origin = [f"{name}: {text}" for name, text in self.provenance.items()]
        notes = ["", *self.notes] if self.notes else []
        return "\n".join([*lines, *notes, "", *origin])


def shown(value: float) -> str:
    """Return a number as a table shows it: three digits, with a prefix word for large ones.

    Examples
    --------
    >>> shown(1234567.0), shown(45123.0), shown(0.3456), shown(2.1e-14)
    ('1.23 M', '45.1 k', '0.346', '2.1e-14')
    """
    size = abs(value)
    if size >= 1e6:
        return f"{value / 1e6:.3g} M"
    if size >= 1e4:
        return f"{value / 1e3:.3g} k"
    if size >= 100:
        return f"{value:.0f}"
    return f"{value:.3g}" if math.isfinite(value) else "—"
