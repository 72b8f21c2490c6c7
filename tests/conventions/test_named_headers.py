"""Every file and folder of the core that documents and docstrings name is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
INCLUDED_FROM = (ROOT, ROOT / "core" / "include", ROOT / "core" / "include" / "omnimorph")
TEXTS = sorted(
    [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *(ROOT / "docs").glob("*.md"),
        *(ROOT / "src").rglob("*.py"),
    ]
)
NAMED = r"(?<![\w./])core/[\w./-]*\w|[\w./-]+\.hpp\b"


def named_in(text: str) -> set[str]:
    """Return what a text names of the core; changes it shows name files that are yet to come."""
    return set(re.findall(NAMED, re.sub(r"^```diff\n.*?^```$", "", text, flags=re.M | re.S)))


def test_much_is_named() -> None:
    named = [name for path in TEXTS for name in named_in(path.read_text(encoding="utf-8"))]
    assert len(set(named)) > 10


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_what_is_named_is_there(path: Path) -> None:
    """By their path from the root, or from where the core's headers are."""
    named = named_in(path.read_text(encoding="utf-8"))
    known = {name for name in named if any((base / name).exists() for base in INCLUDED_FROM)}
    assert named - known == set()
