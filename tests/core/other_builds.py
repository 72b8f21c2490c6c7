"""Builds of the package beside the one under test, each in a folder of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def build(into: Path, tree: Path = ROOT, kind: str = "Release", **settings: str) -> Path:
    """Build the package with settings of CMakeLists.txt; return the folder to import it from."""
    chosen = {"build-dir": str(into / "build"), "cmake.build-type": kind}
    chosen |= {f"cmake.define.{name}": value for name, value in settings.items()}
    options = [f"--config-settings={name}={value}" for name, value in chosen.items()]
    packages = into / "packages"
    pip = ["pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    answer = subprocess.run(
        [sys.executable, "-m", *pip, "--target", str(packages), *options, str(tree)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return packages


def run_python(packages: Path, arguments: list[str], more: dict[str, str]) -> str:
    """Run Python where `packages` come first; it must succeed. Return what it prints."""
    answer = subprocess.run(
        [sys.executable, *arguments],
        env=os.environ | {"PYTHONPATH": f"{packages}:{ROOT}"} | more,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 0, answer.stdout[-5000:] + answer.stderr[-5000:]
    return answer.stdout
