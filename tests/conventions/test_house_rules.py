"""Small rules that keep the house readable, free and reproducible."""

from __future__ import annotations

import ast
import re
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

import omnimorph as om
from omnimorph.version import __version__

ROOT = Path(__file__).parents[2]
PYTHON = sorted(
    path for room in ("src", "tests", "benchmarks") for path in (ROOT / room).rglob("*.py")
)
CPLUSPLUS = sorted(path for kind in ("*.hpp", "*.cpp") for path in (ROOT / "core").rglob(kind))
HEADERS = [path for path in CPLUSPLUS if ROOT / "core" / "include" in path.parents]
LOCK = (ROOT / "requirements.lock").read_text(encoding="utf-8")
ENGINES_LOCK = (ROOT / "requirements-engines.lock").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

MOST_LINES_OF_A_FILE = 400
MOST_LINES_OF_A_FUNCTION = 60  # without its docstring: what fits on a screen
MOST_COLUMNS_OF_THE_CORE = 120  # characters; clang-format leaves comments as they are


def shown(path: Path) -> str:
    """Return a path as the reader of a failed test wants it: from the root of the project."""
    return str(path.relative_to(ROOT))


def requirement_name(text: str) -> str:
    """Return the normalised package name at the start of a requirement."""
    match = re.match(r"[A-Za-z0-9._-]+", text)
    assert match is not None, text
    return re.sub(r"[-_.]+", "-", match.group()).lower()


def locked_names(lock: str = LOCK) -> list[str]:
    """Return the packages of a lock, once each."""
    lines = re.findall(r"^[A-Za-z0-9][^\n]*", lock, re.MULTILINE)
    return sorted({requirement_name(line) for line in lines})


# --- size and words -----------------------------------------------------------------------------


@pytest.mark.parametrize("path", PYTHON + CPLUSPLUS, ids=shown)
def test_file_is_short_enough_to_read(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= MOST_LINES_OF_A_FILE


@pytest.mark.parametrize("path", PYTHON, ids=shown)
def test_functions_fit_on_a_screen(path: Path) -> None:
    long = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            reported = node.body[0] if ast.get_docstring(node) else None
            docstring = (reported.end_lineno or 0) - reported.lineno + 1 if reported else 0
            lines = (node.end_lineno or 0) - node.lineno + 1 - docstring
            if lines > MOST_LINES_OF_A_FUNCTION:
                long.append(f"{node.name}: {lines} lines")
    assert long == []


def test_verbs_of_functions() -> None:
    """Functions are named for what they give (`build_`, `solve_`, `from_`, `as_`, a noun)."""
    names = [
        f"{shown(path)}: {node.name}"
        for path in PYTHON
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and re.match(r"_*(get|compute)_", node.name)
    ]
    assert names == []


# --- tests --------------------------------------------------------------------------------------


def names_of(path: Path) -> tuple[set[str], set[str]]:
    """Return the names that a module lists in ``__all__``, and those that it defines itself."""
    listed: set[str] = set()
    own: set[str] = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            own.add(node.name)
        for target in getattr(node, "targets", [getattr(node, "target", None)]):
            if isinstance(target, ast.Name) and target.id == "__all__":
                listed = set(ast.literal_eval(node.value))  # type: ignore[attr-defined]
            elif isinstance(target, ast.Name):
                own.add(target.id)
    return listed, own


def test_only_who_hands_on_names_of_others_lists_names() -> None:
    """Elsewhere the underscore says what a module keeps to itself."""
    modules = [path for path in PYTHON if "src" in path.parts and path.name != "__init__.py"]
    twice = [
        shown(path) for path in modules if (names := names_of(path))[0] and names[0] <= names[1]
    ]
    assert twice == []
    assert len(modules) > 200


def test_no_test_skips_or_pretends() -> None:
    """No skip, no expected failure, no mock: a test runs the real thing or is not there."""
    pretence = {"skip", "skipif", "importorskip", "xfail", "mock", "Mock", "MagicMock", "mocker"}
    found = []
    for path in (path for path in PYTHON if ROOT / "tests" in path.parents):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            words: set[str] = set()
            if isinstance(node, ast.Attribute):
                words = {node.attr}
            elif isinstance(node, ast.ImportFrom):
                words = {alias.name for alias in node.names} | set((node.module or "").split("."))
            elif isinstance(node, ast.Import):
                words = {word for alias in node.names for word in alias.name.split(".")}
            elif isinstance(node, ast.arg):
                words = {node.arg}
            found += [f"{shown(path)}: {word}" for word in sorted(words & pretence)]
    assert found == []


# --- the core -----------------------------------------------------------------------------------


def test_headers_are_there() -> None:
    assert ROOT / "core" / "include" / "omnimorph" / "plant" / "plant.hpp" in HEADERS


@pytest.mark.parametrize("path", CPLUSPLUS, ids=shown)
def test_lines_of_the_core_are_short_enough_to_read(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").splitlines()
    long = [number for number, line in enumerate(lines, 1) if len(line) > MOST_COLUMNS_OF_THE_CORE]
    assert long == []


@pytest.mark.parametrize("path", HEADERS, ids=shown)
def test_header_depends_on_the_standard_library_and_its_neighbours_only(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert "#pragma once" in text
    standard = re.findall(r"^\s*#\s*include\s*<([^>]+)>", text, re.MULTILINE)
    ours = re.findall(r'^\s*#\s*include\s*"([^"]+)"', text, re.MULTILINE)
    assert [name for name in standard if not re.fullmatch(r"[a-z_0-9]+", name)] == []
    includes = ROOT / "core" / "include"
    for name in ours:
        assert (includes / name).is_file() or (path.parent / name).is_file(), name


# --- the lock -----------------------------------------------------------------------------------


@pytest.mark.parametrize("lock", [LOCK, ENGINES_LOCK])
def test_lock_names_no_index(lock: str) -> None:
    assert "://" not in lock
    assert not re.search(r"^\s*(-i|-f|--(extra-)?index-url|--find-links)\b", lock, re.MULTILINE)


@pytest.mark.parametrize(("lock", "least"), [(LOCK, 20), (ENGINES_LOCK, 3)])
def test_every_locked_package_is_pinned_and_hashed(lock: str, least: int) -> None:
    entries = re.split(r"\n(?=[A-Za-z0-9])", lock)[1:]
    assert len(entries) > least
    for entry in entries:
        first = entry.splitlines()[0]
        assert re.match(r"[A-Za-z0-9._-]+==[^\s;]+( ; .*)? \\$", first), first
        assert "--hash=sha256:" in entry, first


def test_lock_covers_what_the_project_asks_for() -> None:
    asked = [*PROJECT["project"]["dependencies"], *PROJECT["build-system"]["requires"]]
    asked += [
        line
        for line in (ROOT / "requirements.in").read_text(encoding="utf-8").splitlines()
        if line and not line.startswith("#")
    ]
    assert {requirement_name(line) for line in asked} - set(locked_names()) == set()


def test_both_locks_name_the_same_versions() -> None:
    """The second is installed on top of the first, and must not change what is there."""
    first, second = (
        set(re.findall(r"^[A-Za-z0-9._-]+==\S+", lock, re.MULTILINE))
        for lock in (LOCK, ENGINES_LOCK)
    )
    common = set(locked_names()) & set(locked_names(ENGINES_LOCK))
    assert "numpy" in common
    for name in common:
        pins = [{pin for pin in lock if pin.startswith(f"{name}==")} for lock in (first, second)]
        assert pins[0] == pins[1], name


def licence(name: str) -> str:
    """Return what an installed package says of its licence: expression, classifiers, first line."""
    reported = metadata.metadata(name)
    expression = reported.get_all("License-Expression") or []
    classifiers = [
        line for line in reported.get_all("Classifier") or [] if line.startswith("License")
    ]
    # the field may hold the whole text, which names the licences it is compatible with
    first_lines = [text.strip().split("\n")[0] for text in reported.get_all("License") or []]
    return " ".join([*expression, *classifiers, *first_lines])


def test_nothing_locked_is_gpl() -> None:
    """No package under the GPL, by name for those of this field and by what is installed."""
    known = {"cvxopt", "pycddlib", "pypoman", "pyqt5", "pyqt6", "quadprog"}
    assert known.isdisjoint(locked_names())
    installed = {requirement_name(item.metadata["Name"]) for item in metadata.distributions()}
    checked = sorted(installed & set(locked_names()))
    assert len(checked) > 20
    assert [name for name in checked if re.search(r"GPL|General Public", licence(name))] == []


# --- one version, one home ----------------------------------------------------------------------


def test_version_is_the_same_everywhere() -> None:
    version = PROJECT["project"]["version"]
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    newest = re.search(r"^## (\S+)", changelog, re.MULTILINE)
    assert newest is not None
    assert newest.group(1) == version
    assert f"\nversion: {version}\n" in citation
    assert om.__version__ == __version__ == metadata.version("omnimorph") == version


def test_no_file_names_the_home_of_a_machine() -> None:
    text_files = [path for path in ROOT.iterdir() if path.is_file() and path.name != ".git"]
    for room in ("src", "core", "tests", "docs", "examples", "benchmarks", ".ci"):
        text_files += [path for path in (ROOT / room).rglob("*") if path.is_file()]
    kinds = {"", ".py", ".md", ".toml", ".hpp", ".cpp", ".txt", ".lock", ".in", ".cff", ".pyi"}
    home = re.compile(r"(?<![\w.])/(home|root|Users)/")
    named = [
        shown(path)
        for path in text_files
        if path.suffix in kinds and home.search(path.read_text("utf-8"))
    ]
    assert named == []


def test_no_file_of_another_program_lies_in_the_tree() -> None:
    """Such as a log that a simulator left where it was run; what git ignores is not in the tree."""
    kinds = {".py", ".pyi", ".toml", ".hpp", ".cpp", ".md", ".j2", ".csv", ".svg", ".png"}
    kinds |= {".nc", ".gz"}  # runs; older ones are kept packed
    known = {"CMakeLists.txt", "py.typed"}
    ignored = {".so", ".pyc"}
    strange = [
        shown(path)
        for room in ("src", "core", "tests", "docs", "examples", "benchmarks")
        for path in (ROOT / room).rglob("*")
        if path.is_file() and path.suffix not in kinds | ignored and path.name not in known
    ]
    assert strange == []
    rules = (ROOT / ".gitignore").read_text(encoding="utf-8")
    assert not re.search(r"log|txt", rules, re.IGNORECASE), "a log would lie there unseen"
