"""`docs/how-to-add-a-vehicle.md`, walked through as it is written: each command, then its code."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

Program = Callable[..., "subprocess.CompletedProcess[str]"]
PAGE = Path(__file__).parents[2] / "docs" / "how-to-add-a-vehicle.md"


@pytest.mark.slow
def test_the_page_can_be_walked_through(
    program: Program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    page = PAGE.read_text(encoding="utf-8")
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    lines = [line for language, text in blocks if not language for line in text.splitlines()]
    assert len(lines) == 6
    for line in lines:
        name, *words = shlex.split(line)
        assert name == "omnimorph"
        done = program(*words)
        assert (done.returncode, done.stderr) == (0, ""), line
    (code,) = (text for language, text in blocks if language == "python")
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    printed = [float(word) for word in done.stdout.strip(" []\n").split()]
    (reported,) = re.findall(r"`\[([^\]]*)\]`\.$", page, re.MULTILINE)
    assert printed == [float(word.replace("−", "-")) for word in reported.split(",")]
