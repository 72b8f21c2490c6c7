"""The compiled module has five doors (`DOORS`) and a true stub."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "src" / "omnimorph"
BATCH = "omnimorph._batch_"  # its modules for many flights, one for each instruction set
# `results` has the core add up what metrics are made of, from the columns of a run.
DOORS = {"model", "analysis", "control", "results", "simulation"}


def names_core(tree: ast.AST) -> bool:
    """Tell whether a module imports omnimorph._core in any spelling, or names it to an importer."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            if any("_core" in alias.name.split(".") for alias in node.names):
                return True
        elif isinstance(node, ast.ImportFrom):
            if "_core" in (node.module or "").split("."):
                return True
            if any(alias.name == "_core" for alias in node.names):
                return True
        elif isinstance(node, ast.Constant):
            name = str(node.value)
            if name in ("omnimorph._core", "._core") or name.startswith(BATCH):
                return True
    return False


@pytest.mark.parametrize(
    "text",
    [
        "import omnimorph._core",
        "import omnimorph._core as core",
        "from omnimorph import _core",
        "from omnimorph._core import fly",
        "from .. import _core",
        "from .._core import fly",
        "def late():\n    from omnimorph import _core",
        "importlib.import_module('omnimorph._core')",
        "importlib.import_module(f'omnimorph._batch_{name}')",
    ],
)
def test_every_spelling_is_seen(text: str) -> None:
    assert names_core(ast.parse(text))


@pytest.mark.parametrize("text", ["from omnimorph import model", "hard_core = 1", "import score"])
def test_nothing_else_is_taken_for_it(text: str) -> None:
    assert not names_core(ast.parse(text))


def test_core_is_imported_through_its_doors_only() -> None:
    users = {
        path.relative_to(PACKAGE)
        for path in PACKAGE.rglob("*.py")
        if names_core(ast.parse(path.read_text(encoding="utf-8")))
    }
    assert users, "no file imports the compiled core: is this test looking in the right place?"
    assert {user for user in users if user.parts[0] not in DOORS} == set()


def test_stub_names_what_the_compiled_module_holds() -> None:
    """`make stub` writes src/omnimorph/_core.pyi; it must not be older than the bindings."""
    stub = ast.parse((PACKAGE / "_core.pyi").read_text(encoding="utf-8"))
    reported: set[str] = set()
    for node in stub.body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            reported.add(node.name)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            reported.add(node.target.id)
        elif isinstance(node, ast.Assign):
            reported |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    held = dir(importlib.import_module("omnimorph._core"))
    assert {name for name in reported if not name.startswith("_")} == {
        name for name in held if not name.startswith("_")
    }
