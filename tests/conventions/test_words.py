"""What people read uses the words of the field: no word of ours where engineers have one."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PLACES = (
    "src",
    "core",
    "docs",
    "examples",
    "benchmarks",
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
)
KINDS = (".py", ".hpp", ".cpp", ".j2", ".toml", ".md")
# What may not be read anywhere, and what is said instead.
BANNED = {
    r"\b(told|tells?|telling)\b": "said, given, measured, commanded",
    r"\b(no|without|its) rates\b|rates told": "without velocity and acceleration feed-forward",
    r"\bagainst drag\b": "rotor drag power, rotor drag energy",
    r"\b(balls?)\b": "inscribed sphere, weight sphere",
    r"\boracle\b": "lower bound",
    r"\bdear(er|est)?\b": "costs more",
    r"\babove the least\b": "relative to the lower bound",
    r"\bflat sets?\b|\b(set|sets) (is|are|was) flat\b|\bthe flat\b": "degenerate set (line, plane)",
    r"\(rod\)|\(plate\)|\b(plate|rod|point) (or|and) a (rod|plate)\b": "line, plane",
    r"\b(of|whole|×) (the )?way\b|\bthe way (flown|÷|of our)|\ball the way\b": "path, path length",
    r"\bturned, to rounding\b|\bthe same to rounding\b": "identical to rounding",
    r"\bparted\b": "separated",
    r"\b(missed force|force missed)\b": "force not achieved",
}
# Names that say less than others do, and what is said instead.
BANNED_NAMES = {
    r"(\w*_)?told(_\w*)?": "expected, reported, given",
    r"(\w*_)?findings(_\w*)?": "results",
    r"Look|LOOKS|looks": "LineStyle, LINE_STYLES, line_styles",
    r"Flown": "FlightResult",
}
ROOMS_OF_CODE = ("src", "tests", "benchmarks", "examples")
# Parts of a vehicle may be plates and rods.
ALLOWED = {"src/omnimorph/identification/inertia.py", "docs/identification.md"}


def files() -> Iterator[Path]:
    """Every file of the places in which people read something."""
    for place in PLACES:
        path = ROOT / place
        found = [path] if path.is_file() else sorted(path.rglob("*"))
        yield from (one for one in found if one.suffix in KINDS)


def texts(path: Path) -> Iterator[tuple[int, str]]:
    """Lines of a file with their numbers; of Python what stands in strings and docstrings.

    What stands between backquotes in Markdown are names, old ones in the change log among them.
    """
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        text = re.sub(r"`[^`\n]*`", "``", text)
    if path.suffix != ".py":
        yield from enumerate(text.splitlines(), 1)
        return
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield from enumerate(node.value.splitlines(), node.lineno)


@pytest.fixture(scope="module")
def read() -> list[str]:
    """All that people read, line by line, each after the place in which it stands."""
    paths = {str(path.relative_to(ROOT)): path for path in files()}
    assert len(paths) > 200
    return [
        f"{name}:{number}: {line.strip()}"
        for name, path in paths.items()
        if name not in ALLOWED
        for number, line in texts(path)
    ]


@pytest.mark.parametrize("pattern", BANNED, ids=list(BANNED.values()))
def test_no_word_of_ours_where_the_field_has_one(read: list[str], pattern: str) -> None:
    word = re.compile(pattern, re.IGNORECASE)
    assert [line for line in read if word.search(line.split(": ", 1)[1])] == []


def names(text: str) -> Iterator[tuple[int, str]]:
    """Every name in Python code, with its line: of variables, functions, classes, fields."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.NAME:
            yield token.start[0], token.string


def is_banned(name: str) -> bool:
    """Whether a name is one of ours, or made of one."""
    return any(re.fullmatch(pattern, name) for pattern in BANNED_NAMES)


def test_no_name_of_ours_where_engineers_have_one() -> None:
    paths = {
        str(path.relative_to(ROOT)): path
        for room in ROOMS_OF_CODE
        for path in sorted((ROOT / room).rglob("*.py"))
    }
    assert len(paths) > 400
    assert [
        f"{place}:{line}: {name}"
        for place, path in paths.items()
        for line, name in names(path.read_text(encoding="utf-8"))
        if is_banned(name)
    ] == []


def test_a_word_of_ours_is_found_in_any_name() -> None:
    text = "class Look: ...\ndef as_told(a): ...\nx.looks = 'told'\n"
    assert [name for _, name in names(text) if is_banned(name)] == ["Look", "as_told", "looks"]
    assert not is_banned("looks_at")


def test_a_word_of_ours_is_found_wherever_it_stands(tmp_path: Path) -> None:
    places = {
        "a.py": 'x = 1  # told in a comment is nobody\'s concern\ny = f"it was told {x}"\n',
        "b.md": "nothing\nThe controller is told where to be.\n",
    }
    for name, text in places.items():
        (tmp_path / name).write_text(text)
        lines = [n for n, line in texts(tmp_path / name) if re.search(next(iter(BANNED)), line)]
        assert lines == [2]
