"""No module imports itself by way of others: late imports and those for types count, too."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2] / "src"

# Circles that are there for a reason. Each is inside one package, and closed by one import that is
# late or for type checkers.
EXPLAINED = {
    "a `Vehicle` questions its units when it is made, and what questions them reads one": {
        "omnimorph.design.unit_doubts",
        "omnimorph.design.vehicle",
    },
    "a server has a guard, made once there is a page, which asks what addresses are its own": {
        "omnimorph.viewer.guard",
        "omnimorph.viewer.server",
    },
    "a scenario holds a plant, whose model reads its effects as scenario files do": {
        "omnimorph.simulation.plant",
        "omnimorph.simulation.scenario",
        "omnimorph.simulation.scenario_files",
        "omnimorph.simulation.scenario_schema",
    },
}


def sources() -> dict[str, str]:
    """Return the text of every module by its name; the package itself only lists public names."""
    found = {}
    for path in (ROOT / "omnimorph").rglob("*.py"):
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        found[name] = path.read_text(encoding="utf-8")
    del found["omnimorph"]
    return found


def imported(text: str, modules: Mapping[str, str]) -> Iterator[str]:
    """Yield the modules of the package that a module imports, wherever in it."""
    for node in ast.walk(ast.parse(text)):
        names = [alias.name for alias in getattr(node, "names", ()) if hasattr(alias, "asname")]
        if isinstance(node, ast.ImportFrom):
            inside = [f"{node.module}.{name}" for name in names]
            names = [name if name in modules else str(node.module) for name in inside]
        yield from (name for name in names if name in modules)


def circles(modules: Mapping[str, str]) -> list[set[str]]:
    """Return sets of modules each of which imports all others of its set, by way of any."""
    steps = {name: {*imported(text, modules)} - {name} for name, text in modules.items()}
    reached = {name: set(steps[name]) for name in steps}
    for middle in steps:
        for known in reached.values():
            if middle in known:
                known |= reached[middle]
    found: list[set[str]] = []
    for name in steps:
        circle = {other for other in reached[name] if name in reached[other]}
        if circle and circle not in found:
            found.append(circle)
    return found


def test_no_module_imports_itself_by_way_of_others() -> None:
    found = [one for one in circles(sources()) if not any(one <= x for x in EXPLAINED.values())]
    assert found == []


def test_no_circle_is_explained_among_results() -> None:
    assert not [name for one in EXPLAINED.values() for name in one if ".results." in name]


@pytest.mark.parametrize(
    "late",
    [
        "from a import x",
        "import a",
        "def f():\n    from a import x",
        "if TYPE_CHECKING:\n    import a",
    ],
)
def test_every_import_that_closes_a_circle_is_seen(late: str) -> None:
    modules = {"a": "from b import y", "b": "import c", "c": late, "d": "import a, b, c"}
    assert circles(modules) == [{"a", "b", "c"}]
    assert circles(modules | {"c": ""}) == []
