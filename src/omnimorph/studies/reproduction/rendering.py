"""The templates of this study, which hold its sentences and tables, and what they are given."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from omnimorph.report.analysis_text import condition_text, listed, rows_by_tilt
from omnimorph.report.figures import BANDS
from omnimorph.report.page import templates_of
from omnimorph.report.tables import Table, degrees
from omnimorph.results.metrics import MEASURES
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.flights import CASES, W3, A, B
from omnimorph.studies.reproduction.hypotheses import error_claims
from omnimorph.studies.reproduction.lost_thrust import (
    KEPT_WITHIN_DEG,
    KEPT_WITHIN_M,
    KINDS,
    NOT_LOST,
    POSE_KEPT,
)
from omnimorph.studies.reproduction.spread import spread_of
from omnimorph.studies.reproduction.verdicts import NEAR
from omnimorph.studies.reproduction.wording import (
    FLIGHT_LABELS,
    difference_text,
    mean_text,
    spread_text,
    with_unit,
)
from omnimorph.units import from_SI

if TYPE_CHECKING:
    from jinja2 import Environment


def render(template: str, **content: Any) -> str:
    """Return a file of ``templates``, filled in: HTML, whose texts are escaped, or Markdown."""
    return templates().get_template(template).render(**content)


@cache
def templates() -> Environment:
    """Return the templates of this study, with the names and the formats that they use."""
    environment = templates_of("omnimorph.studies.reproduction")
    environment.globals |= {
        "A": A,
        "B": B,
        "W3": W3,
        "CASES": CASES,
        "TURN": 2.0 * math.pi,
        "NEAR": NEAR,
        "KEPT_WITHIN_M": KEPT_WITHIN_M,
        "KEPT_WITHIN_DEG": KEPT_WITHIN_DEG,
        "BANDS": BANDS,
        "ALL_ROTORS": KINDS[0],
        "NOT_LOST": NOT_LOST,
        "POSE_KEPT": POSE_KEPT,
        "paper": paper.claims(),
        "error_claims": error_claims,
        "label": FLIGHT_LABELS,
    }
    environment.filters |= {
        "as_table": as_table,
        "cell": lambda text: text.replace("|", "\\|"),
        "condition": condition_text,
        "degrees": degrees,
        "difference": difference_text,
        "hertz": lambda speed: f"{from_SI(speed, 'Hz'):.0f}",
        "listed": listed,
        "mean": _mean,
        "mean_and_interval": mean_text,
        "percentages": lambda ends: " to ".join(f"{100.0 * end:.1f}" for end in ends),
        "rows_by_tilt": rows_by_tilt,
        "sha256": lambda text: hashlib.sha256(text.encode()).hexdigest(),
        "signed": lambda share: f"{100.0 * share:+.1f}".replace("-", "−"),
        "spread": lambda flown, metric, factor=1.0: spread_text(spread_of(flown, metric), factor),
        "with_unit": with_unit,
        "without_caption": lambda table: table.partition("\n\n")[2],
    }
    return environment


def _mean(flown: Sequence[FlightResult], metric: str) -> float:
    return spread_of(flown, metric, MEASURES[metric].factor).mean


def as_table(markdown: str) -> Table:
    r"""Return a table of ``tables.md.j2``: its caption, its names of columns and its rows.

    Examples
    --------
    >>> table = as_table("A caption.\n\n| | speed (Hz) |\n| --- | ---: |\n| rotor 0 | 30 |\n")
    >>> table.caption, table.head, table.rows, set(table.numeric)
    ('A caption.', ['', 'speed (Hz)'], [['rotor 0', '30']], {1})
    """
    caption, _, lines = str(markdown).strip().partition("\n\n")
    head, rule, *rows = [
        [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        for line in lines.splitlines()
    ]
    numeric = frozenset(column for column, mark in enumerate(rule) if mark.endswith(":"))
    return Table(caption, head, rows, numeric)
