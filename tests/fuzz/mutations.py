"""Good files made bad: one engine for trees (TOML), one for lines of text (CSV), one for bytes.

Every choice comes from a generator of random numbers, so a case is the same every time.
"""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Iterator
from random import Random
from typing import Any

Path = tuple[str | int, ...]

NUMBERS = (
    0.0, -0.0, 1.0, -1.0, 5e-324, 1e-308, 1e-300, 1e-154, 1e-30, 1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9,
    1e12, 1e30, 1e154, 1e300, -1e300, 1.7976931348623157e308, math.nan, math.inf, -math.inf,
)  # fmt: skip
ODD: tuple[Any, ...] = (
    *NUMBERS, 0, 1, -1, 2**31, 2**63, 10**400, True, False, "", "x", "\x00", "\x1b[31m\n",
    "a" * 300, "α" * 100_000, "../..", "/", "/dev/zero", "hover",
    [], [[]], [1.0] * 10_000, {}, {"kind": "x"},
)  # fmt: skip


# --- trees ----------------------------------------------------------------------------------------


def mutated_tree(tree: dict[str, Any], others: list[dict[str, Any]], rng: Random) -> dict[str, Any]:
    """Return a copy in which a few places hold something else, or are gone, renamed or moved."""
    changed = copy.deepcopy(tree)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        places = list(paths(changed))
        if places:
            _change(changed, rng.choice(places), others, rng)
    return changed


def paths(tree: Any, above: Path = ()) -> Iterator[Path]:
    """Yield the place of everything in a tree."""
    inside = tree.items() if isinstance(tree, dict) else enumerate(tree)
    for key, value in inside:
        yield (*above, key)
        if isinstance(value, dict | list):
            yield from paths(value, (*above, key))


def at(tree: Any, path: Path) -> Any:
    """Return what stands at a place."""
    for step in path:
        tree = tree[step]
    return tree


def _change(tree: dict[str, Any], path: Path, others: list[dict[str, Any]], rng: Random) -> None:
    holder, key = at(tree, path[:-1]), path[-1]
    value = holder[key]
    numeric = isinstance(value, float) or (type(value) is int and abs(value) < 2**63)
    what = rng.choice(("odd", "odd", "scaled", "scaled", "gone", "twice", "moved", "named", "deep"))
    if what == "scaled" and numeric:
        holder[key] = float(value) * rng.choice((-1.0, 0.0, 1e-3, 1e3)) ** rng.randint(1, 100)
    elif what == "gone":
        del holder[key]
    elif what == "twice" and isinstance(holder, list):
        holder.extend([copy.deepcopy(value)] * rng.choice((1, 2, 30)))
    elif what == "moved":
        other = rng.choice([tree, *others])
        holder[key] = copy.deepcopy(at(other, rng.choice(list(paths(other)))))
    elif what == "named" and isinstance(holder, dict):
        holder[rng.choice((f"{key}x", f"{key}"[1:], "kind", "\x1b[1m", "k" * 5000))] = value
    elif what == "deep":
        holder[key] = nested(value, rng.choice((2, 10, 100)), rng)
    else:
        holder[key] = copy.deepcopy(rng.choice(NUMBERS if numeric else ODD))


def nested(value: Any, depth: int, rng: Random) -> Any:
    """Return a value inside so many lists and tables."""
    for _ in range(depth):
        value = [value] if rng.random() < 0.5 else {"k": value}
    return value


def as_toml(tree: dict[str, Any]) -> str:
    """Return a tree as TOML."""
    return "".join(f"{_quoted(key)} = {_inline(value)}\n" for key, value in tree.items())


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        inside = (f"{_quoted(key)} = {_inline(item)}" for key, item in value.items())
        return "{" + ", ".join(inside) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, bool):
        return str(value).lower()
    return f"0x{value:x}" if isinstance(value, int) and value > 2**63 else repr(value)


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


# --- lines of text --------------------------------------------------------------------------------

CELLS = (*map(repr, NUMBERS), "", " ", "x", "1e999", "0x10", "1_000", '"1"', '"', "1;2", "\x00",
         "٣", "9" * 5000, "1,2", "\n")  # fmt: skip


def mutated_text(text: str, rng: Random) -> bytes:
    """Return lines of cells in which a few are others, gone, twice, or in another order."""
    lines = [line.split(",") for line in text.splitlines()]
    for _ in range(rng.choice((1, 1, 1, 2, 5))):
        row = rng.randrange(len(lines))
        column = rng.randrange(len(lines[row]))
        what = rng.choice(("cell", "cell", "column", "column", "gone", "twice", "moved", "short"))
        if what == "cell":
            lines[row][column] = rng.choice(CELLS)
        elif what == "column":  # of all rows but the header
            cell, factor = rng.choice(CELLS), 10.0 ** rng.randint(-320, 305)
            for line in lines[1:]:
                if column < len(line):
                    line[column] = cell if row % 2 else _scaled(line[column], factor)
        elif what == "gone" and len(lines) > 1:
            del lines[row]
        elif what == "twice":
            lines.insert(row, lines[row].copy())
        elif what == "moved":
            lines.insert(rng.randrange(len(lines)), lines.pop(row))
        elif len(lines) > 1:
            del lines[rng.randrange(1, len(lines)) :]
    return "\n".join(map(",".join, lines)).encode("utf-8", errors="replace")


def _scaled(cell: str, factor: float) -> str:
    try:
        return repr(float(cell) * factor)
    except ValueError:
        return cell


# --- bytes ----------------------------------------------------------------------------------------


def mutated_bytes(data: bytes, rng: Random) -> bytes:
    """Return bytes of which a few are others, gone or there twice; or only the first of them."""
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 8))):
        begin = rng.randrange(len(changed) or 1)
        end = begin + rng.choice((1, 2, 4, 8, 64, 1024))
        what = rng.choice(("flip", "flip", "flip", "other", "gone", "twice", "cut"))
        if what == "flip" and changed:
            changed[begin] ^= 1 << rng.randrange(8)
        elif what == "other":
            changed[begin:end] = rng.choice((b"\x00", b"\xff", b"\x7f")) * (end - begin)
        elif what == "gone":
            del changed[begin:end]
        elif what == "twice":
            changed[begin:begin] = changed[begin:end]
        elif rng.random() < 0.2:
            del changed[begin:]
    return bytes(changed)
