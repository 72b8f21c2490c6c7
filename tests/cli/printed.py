"""What a command prints beside what it hands to programs: every number must be in both."""

from __future__ import annotations

import itertools
import json
import math
import re
from collections.abc import Iterator
from typing import Any

from omnimorph.cli.console import Answer
from omnimorph.cli.main import COMMANDS, parsed
from omnimorph.units import UNITS, unit_of

_NUMBER = re.compile(r"(?<![\w.\-−])[-+−]?\d+(?:\.\d+)?(?:e[-+−]?\d+)?(?![\w.]*\w)(%?)")
# What a number may be multiplied by on its way to the screen: into units of the same kind.
_KINDS = (
    ("m", "mm"),
    ("s", "ms"),
    ("rad", "mrad", "deg"),
    ("Hz", "rad_per_s"),
    ("N_per_Hz2",),
)


def answer_of(*words: str) -> Answer:
    """Return what a command answers, as text and as data, from one and the same computation."""
    options = parsed(list(words))
    answer: Answer = COMMANDS[options.command].answer(options)
    return answer._replace(data=json.loads(answer.as_json()))


def numbers_in(text: str) -> list[str]:
    """Return the numbers that stand in a text by themselves, not as part of a name."""
    return [found.group().replace("−", "-") for found in _NUMBER.finditer(text)]


def unfounded(text: str, data: Any) -> list[str]:
    """Return the numbers of a text that are, to the digits printed, nowhere in some data."""
    shown = {form for value in _leaves("", data) for form in _forms(*value)}
    return [word for word in numbers_in(text) if _plain(word) not in shown]


def is_shown(cell: str, value: float | None) -> bool:
    """Tell whether a cell shows a number to the digits it has; a dash shows that there is none."""
    if value is None or not math.isfinite(value):
        return cell == "—"
    return _plain(cell.replace("−", "-")) in set(_forms("", value))


def rows_of(text: str) -> list[dict[str, str]]:
    """Return the rows of the first table with a ruled header, each from header to cell."""
    lines = text.splitlines()
    at = next(k for k, line in enumerate(lines) if re.fullmatch(r"[- ]*-{2}[- ]*", line))
    spans = [found.span() for found in re.finditer("-+", lines[at])]
    spans[-1] = (spans[-1][0], 10_000)
    body = itertools.takewhile(str.strip, lines[at + 1 :])
    heads = [lines[at - 1][begin:end].strip() for begin, end in spans]
    return [
        dict(zip(heads, (line[begin:end].strip() for begin, end in spans), strict=True))
        for line in body
    ]


def _leaves(key: str, data: Any) -> Iterator[tuple[str, float]]:
    """Give every number of some data with the key above it; those in words, too."""
    if isinstance(data, dict):
        for name, value in data.items():
            yield from _leaves(name, value)
            yield from ((key, float(word.rstrip("%"))) for word in numbers_in(name))
    elif isinstance(data, list):
        for place, value in enumerate(data):
            yield from _leaves(key, value)
            if isinstance(value, dict):
                yield "", place
    elif isinstance(data, str):
        for word in numbers_in(data):
            yield "", float(word.rstrip("%")) * (0.01 if word.endswith("%") else 1.0)
    elif isinstance(data, int | float) and not isinstance(data, bool):
        yield key, float(data)


def _forms(key: str, value: float) -> Iterator[str]:
    """Give the ways in which a number may be printed."""
    unit = unit_of(key)
    kind = next((kind for kind in _KINDS if unit in kind), (unit,))
    for other in kind:
        shown = value * UNITS[unit] / UNITS[other]
        yield from (_plain(f"{shown:.{digits}g}") for digits in range(2, 11))
        yield from (_plain(f"{shown:.{places}f}") for places in range(1, 7))
    yield from (f"{float(f'{100.0 * value:.{places}f}'):g}%" for places in range(3))
    if abs(value) < 1e15:
        yield _plain(f"{math.floor(value):d}" if value == math.floor(value) else f"{value:.17g}")


def _plain(word: str) -> str:
    """Return one spelling of a number."""
    return f"{float(word.rstrip('%')):.12g}" + ("%" if word.endswith("%") else "")
