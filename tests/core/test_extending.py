"""Every change that `docs/extending.md` shows applies, counts as many places, builds and flies."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from tests.core.other_builds import ROOT, build

PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
MOST_PLACES = {
    "An effect on the actuators": 4,
    "A force": 4,
    "An allocation rule": 5,
    "An estimator": 4,
    "A sensor": 4,
    "A field of vehicles": 4,
    "A recorded column": 2,
    "A metric": 3,
}
PARTS = ("CMakeLists.txt", "pyproject.toml", "README.md", "LICENSE", "core", "docs", "src", "tests")
NOT_COPIED = shutil.ignore_patterns("*.so", "__pycache__")


def sections() -> dict[str, str]:
    """Return the sections of the page by their titles."""
    parts = re.split(r"^## (.+)\n", PAGE, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


DIFFS = {
    title: diff
    for title, text in sections().items()
    for diff in re.findall(r"^```diff\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
}


def files_of(diff: str) -> dict[str, str]:
    """Return what a diff changes, by file."""
    parts = re.split(r"^diff --git a/\S+ b/(\S+)\n", diff, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def places_of(diff: str) -> int:
    """Count the hunks outside new files, tests and pages."""
    return sum(
        len(re.findall(r"^@@ ", change, re.MULTILINE))
        for file, change in files_of(diff).items()
        if not change.startswith("new file") and not file.startswith(("tests/", "docs/"))
    )


def added_tests(diff: str) -> list[str]:
    return [file for file in files_of(diff) if Path(file).name.startswith("test_")]


def test_each_section_has_one_change() -> None:
    found = re.findall(r"^```diff$", PAGE, re.MULTILINE)
    assert list(DIFFS) == list(MOST_PLACES)
    assert len(found) == len(DIFFS)
    assert all(added_tests(diff) for diff in DIFFS.values())


@pytest.mark.parametrize("title", MOST_PLACES)
def test_it_needs_as_few_places_as_the_page_says(title: str) -> None:
    link = "#" + title.lower().replace(" ", "-")
    row = re.search(rf"^\|[^|]*\({link}\) \|[^|]*\| (\d+) \| (\d+) \|$", PAGE, re.MULTILINE)
    assert row is not None
    assert places_of(DIFFS[title]) == int(row[1])
    assert int(row[1]) <= int(row[2]) == MOST_PLACES[title]


def git(tree: Path, *words: str, stdin: str | None = None) -> None:
    """Run git in a tree, whatever it is set to elsewhere."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    clean |= {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_NOSYSTEM": "1"}
    author = ["-c", "user.name=test", "-c", "user.email=test@localhost"]
    command = ["git", *author, *words]
    done = subprocess.run(
        command, cwd=tree, env=clean, input=stdin, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of this tree, in a repository of its own."""
    copy = tmp_path_factory.mktemp("extended") / "tree"
    copy.mkdir()
    for part in PARTS:
        if (ROOT / part).is_dir():
            shutil.copytree(ROOT / part, copy / part, ignore=NOT_COPIED)
        else:
            shutil.copy(ROOT / part, copy / part)
    git(copy, "init", "--quiet")
    git(copy, "add", "--all")
    git(copy, "commit", "--quiet", "--message=as it is")
    git(copy, "tag", "as-it-is")
    return copy


@pytest.mark.slow
@pytest.mark.parametrize("title", DIFFS)
def test_it_applies_to_the_tree_as_it_is(title: str, tree: Path) -> None:
    git(tree, "checkout", "--quiet", "--force", "as-it-is")
    git(tree, "apply", "--check", "-", stdin=DIFFS[title])


@pytest.fixture(scope="module")
def report(tree: Path) -> str:
    """Build a tree with all changes together; return what the tests that they bring report."""
    for number, (title, diff) in enumerate(DIFFS.items()):
        git(tree, "checkout", "--quiet", "--force", "-b", f"change-{number}", "as-it-is")
        git(tree, "apply", "--index", "-", stdin=diff)
        git(tree, "commit", "--quiet", f"--message={title}")
    git(tree, "checkout", "--quiet", "-b", "all", "as-it-is")
    git(tree, "cherry-pick", *(f"change-{number}" for number in range(len(DIFFS))))
    rotor_counts = ""  # none is compiled on its own, so that all are counted at run time
    packages = build(
        tree.parent,
        tree,
        kind="Hardly",
        CMAKE_CXX_FLAGS_HARDLY="-O0",
        OMNIMORPH_NATIVE="ON",
        OMNIMORPH_ROTOR_COUNTS=rotor_counts,
    )
    files = [file for diff in DIFFS.values() for file in added_tests(diff)]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-n0", "-rA", "--tb=short", *files],
        env=os.environ | {"PYTHONPATH": str(packages)},
        cwd=tree,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("title", DIFFS)
def test_it_flies(title: str, report: str) -> None:
    for file in added_tests(DIFFS[title]):
        outcomes = re.findall(rf"^([A-Z]+) {re.escape(file)}", report, re.MULTILINE)
        assert set(outcomes) == {"PASSED"}, report
