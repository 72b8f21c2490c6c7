"""What the paper says: its claims, its printed matrix, its experiment, from ``paper.toml``."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from typing import Any


@dataclass(frozen=True, kw_only=True)
class PaperClaim:
    """One statement of the paper: a number with its unit, or words.

    What it is about, where that is a number or a flight, is named: ``tilt_deg``, ``scenario``…
    """

    key: str  # a short name
    text: str  # the claim in our words
    where: str  # the part of the paper where it stands
    rule: str  # what kind of claim it is, and so how it is judged: see `verdicts.RULES`
    value: float | None = None
    unit: str = ""
    about: Mapping[str, Any] = field(default_factory=dict)


@cache
def claims() -> Mapping[str, PaperClaim]:
    """Return every claim of the paper by its key, in the paper's order."""
    found = {}
    for key, entry in _content()["claim"].items():
        names = ("text", "where", "rule", "value", "unit")
        own = {name: entry.pop(name) for name in names if name in entry}
        found[key] = PaperClaim(key=key, **own, about=entry)
    return found


def reference() -> Mapping[str, str]:
    """Return authors, title, journal, doi and arxiv of the paper."""
    content: Mapping[str, str] = _content()["paper"]
    return content


def printed_matrix() -> list[list[str]]:
    """Return the (6, 8) entries of F as printed, in s, c, L and k, without c_f."""
    rows: list[list[str]] = _content()["printed_matrix"]["rows"]
    return rows


def bench() -> Mapping[str, Any]:
    """Return tilts and speeds of the experiment on interference."""
    content: Mapping[str, Any] = _content()["bench"]
    return content


def _content() -> dict[str, Any]:
    file = resources.files("omnimorph.studies.reproduction") / "paper.toml"
    return tomllib.loads(file.read_text(encoding="utf-8"))
