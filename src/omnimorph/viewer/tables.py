"""Numbers on the page: a table that people read and that a test can read off."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from typing import NamedTuple


class Row(NamedTuple):
    """One line of a table of numbers.

    Attributes
    ----------
    key : str
        Its name in the page: the cells are the elements ``#key`` and ``#key-2``.
    label : str
        What it is.
    unit : str
        Of the values.
    values : list of str
        One, or one for each of two flights.
    """

    key: str
    label: str
    unit: str
    values: list[str]


_TABLE = "width:100%;border-collapse:collapse;font-size:0.8125rem;line-height:1.5"
_UNIT = "color:#777;padding:1px 4px;white-space:nowrap"
_NUMBER = "text-align:right;font-variant-numeric:tabular-nums;padding:1px 4px"


def number_table(rows: Sequence[Row], names: Sequence[str] = ()) -> str:
    """Return rows as an HTML table, with names above the values if there are several."""
    lines = []
    if len(names) > 1:
        heads = "".join(f'<th style="{_NUMBER}">{html.escape(name)}</th>' for name in names)
        lines.append(f"<tr><td></td>{heads}<td></td></tr>")
    for key, label, unit, values in rows:
        cells = "".join(
            f'<td id="{key}{f"-{k + 1}" if k else ""}" style="{_NUMBER}">{html.escape(value)}</td>'
            for k, value in enumerate(values)
        )
        lines.append(
            f'<tr><td style="padding:1px 4px">{html.escape(label)}</td>{cells}'
            f'<td style="{_UNIT}">{html.escape(unit)}</td></tr>'
        )
    return f'<div style="padding:2px 8px"><table style="{_TABLE}">{"".join(lines)}</table></div>'


def shown_number(value: float, digits: int = 4) -> str:
    """Return a number to so many significant digits; a dash if there is none.

    Examples
    --------
    >>> shown_number(27.41234), shown_number(float("inf"))
    ('27.41', '—')
    """
    return f"{value:.{digits}g}" if math.isfinite(value) else "—"
