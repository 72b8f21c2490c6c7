"""Everything public says what it is: modules, classes, functions, methods and properties."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = sorted(path for room in ("src", "benchmarks") for path in (ROOT / room).rglob("*.py"))

Documented = ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def decorators(node: Documented) -> set[str]:
    """Return the last words of a definition's decorators: overload, setter, property ..."""
    return {ast.unparse(item).split("(")[0].split(".")[-1] for item in node.decorator_list}


def public_definitions(body: list[ast.stmt], prefix: str = "") -> Iterator[tuple[str, Documented]]:
    """Yield the public classes and functions of a module, and those inside public classes."""
    for node in body:
        if not isinstance(node, Documented) or node.name.startswith("_"):
            continue
        # an overload and a setter are documented by the definition they belong to
        if decorators(node) & {"overload", "setter", "override"}:
            continue
        yield prefix + node.name, node
        if isinstance(node, ast.ClassDef):
            yield from public_definitions(node.body, f"{prefix}{node.name}.")


def test_there_is_something_to_check() -> None:
    assert ROOT / "src" / "omnimorph" / "__init__.py" in FILES


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_public_definitions_have_docstrings(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    missing = [
        f"{name} (line {node.lineno})"
        for name, node in public_definitions(tree.body)
        if not ast.get_docstring(node)
    ]
    if not ast.get_docstring(tree):
        missing.insert(0, "the module itself")
    assert missing == []
