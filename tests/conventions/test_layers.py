"""Data flows one way: the import contracts of pyproject.toml hold, and they cover every room."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "omnimorph"


def contracts() -> dict[str, Any]:
    """Return the import contracts of pyproject.toml by their id."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return {contract["id"]: contract for contract in settings["tool"]["importlinter"]["contracts"]}


def layers() -> list[list[str]]:
    """Return the rooms of each layer, the top layer first."""
    return [re.findall(r"\w+", layer) for layer in contracts()["layers"]["layers"]]


def existing(rooms: list[str]) -> set[str]:
    """Return those of `rooms` that are there, as omnimorph.<room>."""
    return {
        f"omnimorph.{room}"
        for room in rooms
        if (PACKAGE / room / "__init__.py").is_file() or (PACKAGE / f"{room}.py").is_file()
    }


def test_import_contracts_hold() -> None:
    lint_imports = Path(sys.executable).with_name("lint-imports")
    answer = subprocess.run(
        [lint_imports, "--no-cache", "--no-logo"], cwd=ROOT, capture_output=True, text=True
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert "0 broken" in answer.stdout


def test_rooms_are_stacked_as_the_architecture_draws_them() -> None:
    assert layers() == [
        ["cli"],
        ["live", "verification", "bench"],
        ["studies"],
        ["report", "viewer", "export"],
        ["simulation", "textbook"],
        ["control"],
        ["analysis", "identification"],
        ["reference", "results"],
        ["model"],
        ["design"],
        ["protocols"],
        ["machine"],
        ["arrays", "units", "errors"],
        ["version"],
    ]
    # `|` makes neighbours strangers, `:` would let them import each other
    assert not any(":" in layer for layer in contracts()["layers"]["layers"])
    assert contracts()["layers"]["exhaustive"] is True


@pytest.mark.parametrize(
    ("contract", "first", "last"),
    [("readers", "report", "report"), ("quiet", "simulation", "version")],
)
def test_contract_names_every_room_it_is_about(contract: str, first: str, last: str) -> None:
    """A room that is new must be added to the contracts that name rooms one by one."""
    stack = layers()
    top = next(i for i, rooms in enumerate(stack) if first in rooms)
    bottom = next(i for i, rooms in enumerate(stack) if last in rooms)
    meant = [room for rooms in stack[top : bottom + 1] for room in rooms]
    assert set(contracts()[contract]["source_modules"]) == existing(meant)
