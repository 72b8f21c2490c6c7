"""What the README shows works: its commands exist, its Python example runs."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest
from tests.serving import served

import omnimorph as om

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    """The fenced blocks of a language; "" for those without one."""
    fenced = re.findall(r"^```(\w*)\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)
    return [text for name, text in fenced if name == language]


def commands(program: str) -> list[list[str]]:
    """The lines of the README's shell blocks that begin with a program, without their comments."""
    lines = [line for block in blocks("") for line in block.splitlines()]
    return [shlex.split(line, comments=True) for line in lines if line.startswith(f"{program} ")]


def opens_a_page(command: list[str]) -> bool:
    return command[1] == "view" or "--view" in command


def test_python_example_runs(tmp_path: Path) -> None:
    (example,) = blocks("python")
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", example],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("The flight was completed.\n")
    assert (tmp_path / "case-a.nc").stat().st_size > 1_000_000


def test_make_verbs_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    verbs = [command[1] for command in commands("make")]
    assert verbs == ["reproduce", "test"]
    for verb in verbs:
        assert re.search(rf"^{verb}:", makefile, re.MULTILINE)


@pytest.mark.parametrize(
    "command",
    [c for c in commands("omnimorph") if c[1] not in ("bench", "verify") and not opens_a_page(c)],
    ids=lambda command: " ".join(command),
)
def test_quick_shell_command_runs(command: list[str], tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", *command], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout


@pytest.mark.parametrize(
    "command", [c for c in commands("omnimorph") if opens_a_page(c)], ids=" ".join
)
def test_page_of_a_shell_command_is_served(command: list[str], tmp_path: Path) -> None:
    (tmp_path / "flight").mkdir()
    om.fly(om.load_scenario("hover")).save(tmp_path / "flight" / "run.nc")
    with served(*command[1:], folder=tmp_path) as page:
        with urllib.request.urlopen(page.url, timeout=30) as answer:
            assert b"<html" in answer.read(2000).lower()
        code, _, complaints = page.stopped()
    flies = command[1] == "fly"  # nobody has looked, so nothing has flown
    assert code == (130 if flies else 0)
    assert "Traceback" not in complaints


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bench", "verify"])
def test_slow_shell_command_runs(name: str, tmp_path: Path) -> None:
    assert ["omnimorph", name] in commands("omnimorph")
    done = subprocess.run(
        [sys.executable, "-m", "omnimorph", name],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "COLUMNS": "120"},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_files_it_names_exist() -> None:
    for name in re.findall(r"\]\((?!http)([^)]+)\)|`(docs/[^`]+|[A-Z]+\.(?:md|cff))`", README):
        path = ROOT / (name[0] or name[1])
        assert path.exists(), path
