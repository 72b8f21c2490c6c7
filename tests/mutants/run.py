"""Make each mistake of the list in a copy of this tree; the tests beside it must fail.

Run from the root as ``python -m tests.mutants.run``. Mistakes in the core are compiled, once for
each, in one folder of a reduced build: one flight at a time, 8 rotors, hardly optimised.
"""

from __future__ import annotations

import argparse
import compileall
import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from py_compile import PycInvalidationMode
from queue import SimpleQueue

from tests.mutants.listed import ROOT, Mutant, mutants

NOTICED = "noticed"
_LISTED = ("git", "ls-files", "-z", "--cached", "--others", "--exclude-standard")
_ENOUGH = 5  # failed tests
_PATIENCE = 1200.0  # s
# What is raised where a mistake breaks the program instead of making it wrong: no test needs that.
_BROKEN = ("ImportError", "ModuleNotFoundError", "SyntaxError", "NameError", "AttributeError")


class Copy:
    """A copy of the tree with the compiled core of the installed package in it."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "tree"
        self.report, self._build = folder / "report.xml", folder / "build"
        reported = subprocess.run(
            _LISTED, cwd=ROOT, capture_output=True, text=True, check=True
        ).stdout
        for name in filter(None, reported.split("\0")):
            if (ROOT / name).exists():  # else it is removed, and not yet committed
                (self.root / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / name, self.root / name)
        installed = importlib.util.find_spec("omnimorph._core")
        assert installed is not None
        assert installed.origin is not None
        self.package = self.root / "src" / "omnimorph"
        for module in Path(installed.origin).parent.glob("*.so"):
            shutil.copy(module, self.package)
        for part in ("src", "tests"):  # read again only where the text has changed
            mode = PycInvalidationMode.CHECKED_HASH
            compileall.compile_dir(self.root / part, quiet=1, invalidation_mode=mode)

    def build_core(self) -> str:
        """Compile the reduced core into the package; return what the compiler complains of."""
        settings = {
            "SKBUILD": "ON",
            "OMNIMORPH_ROTOR_COUNTS": "8",
            "CMAKE_BUILD_TYPE": "Hardly",
            "CMAKE_CXX_FLAGS_HARDLY": "-O1 -DNDEBUG",
        }
        find = [sys.executable, "-m", "nanobind", "--cmake_dir"]
        nanobind = subprocess.run(find, capture_output=True, text=True, check=True).stdout.strip()
        settings |= {"nanobind_DIR": nanobind, "Python_EXECUTABLE": sys.executable}
        defined = [f"-D{name}={value}" for name, value in settings.items()]
        for words in (
            ["cmake", "-S", str(self.root), "-B", str(self._build), *defined],
            ["cmake", "--build", str(self._build), "--target", "_core"],
        ):
            done = subprocess.run(words, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                return done.stdout[-2000:] + done.stderr[-2000:]
        for module in self.package.glob("*.so"):  # those of batches are of the whole core
            module.unlink()
        for module in self._build.glob("*.so"):
            shutil.copy(module, self.package)
        return ""

    @contextmanager
    def holding(self, mutant: Mutant) -> Iterator[None]:
        """Make a mistake, and unmake it."""
        file = self.root / mutant.file
        right = file.read_text(encoding="utf-8")
        file.write_text(mutant.applied(right), encoding="utf-8")
        try:
            yield
        finally:
            file.write_text(right, encoding="utf-8")

    def test(self, tests: Iterable[str]) -> str:
        """Run tests, slow ones too; return "passed", "noticed" or what went wrong otherwise."""
        self.report.unlink(missing_ok=True)
        words = ["-m", "pytest", "-q", "-p", "no:cacheprovider", f"--maxfail={_ENOUGH}"]
        chosen = sorted(set(tests))
        environment = {"PYTHONPATH": str(self.package.parent), "PYTHONDONTWRITEBYTECODE": "1"}
        try:
            done = subprocess.run(
                [sys.executable, *words, f"--junitxml={self.report}", *chosen],
                cwd=self.root,
                env=os.environ | environment,
                capture_output=True,
                text=True,
                check=False,
                timeout=_PATIENCE,
            )
        except subprocess.TimeoutExpired:
            return "does not end"
        if done.returncode == 0:
            return "passed"
        if not self.report.exists():
            return f"broken: {(done.stdout + done.stderr)[-300:]}"
        reasons = list(_reasons(self.report))
        if any(not reason.startswith(("error:", *_BROKEN)) for reason in reasons):
            return NOTICED
        return f"broken: {' | '.join(reason[:400] for reason in reasons)}"


def _reasons(report: Path) -> Iterator[str]:
    """Give why each test failed; one that could not be collected or set up has not failed."""
    for case in ElementTree.parse(report).iter("testcase"):
        for failure in case.iter("failure"):
            yield f"{failure.get('message', '')} ({case.get('name')})"
        for error in case.iter("error"):
            yield f"error: {error.get('message', '')} {(error.text or '')[-300:]}"


def _noticed(copy: Copy, mutant: Mutant) -> str:
    """Return whether the tests beside a mistake notice it, in a word, or why that is not known."""
    with copy.holding(mutant):
        complaint = copy.build_core() if mutant.needs_a_build else ""
        found = f"does not compile: {complaint}" if complaint else copy.test(mutant.tests)
    return "UNNOTICED" if found == "passed" else found


def _run(chosen: Sequence[Mutant], jobs: int) -> int:
    """Test all without and with their mistakes; return how many are not noticed."""
    copies: SimpleQueue[Copy] = SimpleQueue()
    missed = []

    def answer(mutant: Mutant) -> None:
        copy = copies.get()
        try:
            found = _noticed(copy, mutant)
        finally:
            copies.put(copy)
        print(f"{mutant.area:15} {mutant.name:40} {found}", flush=True)
        if found != NOTICED:
            missed.append(mutant)

    with tempfile.TemporaryDirectory() as folder:
        jobs = min(jobs, len(chosen))
        made = [Copy(Path(folder, str(k))) for k in range(jobs)]
        for copy in made:
            copies.put(copy)
        for compiled in (False, True):
            part = [mutant for mutant in chosen if mutant.needs_a_build is compiled]
            if not part:
                continue
            for copy in made if compiled else ():
                complaint = copy.build_core()
                assert not complaint, complaint
            found = made[0].test(test for mutant in part for test in mutant.tests)
            reported = "\n".join(_reasons(made[0].report))
            assert found == "passed", (
                f"without a mistake tests beside them fail: {found}\n{reported}"
            )
            with ThreadPoolExecutor(jobs) as pool:
                list(pool.map(answer, part))
    print(f"{len(chosen) - len(missed)} of {len(chosen)} noticed")
    return len(missed)


def main() -> int:
    """Make the mistakes asked for, all if none is; 1 if one is not noticed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("only", nargs="*", help="areas or names of mistakes (default: all)")
    parser.add_argument("--jobs", type=int, default=1, help="copies tested at once (default: 1)")
    options = parser.parse_args()
    listed = mutants()
    unknown = set(options.only) - {word for one in listed for word in (one.area, one.name)}
    if unknown:
        parser.error(f"no area and no mistake is called {', '.join(sorted(unknown))}")
    # leave no copy behind; a shell's & ignores Ctrl-C
    for stop in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(stop, signal.default_int_handler)
    only = set(options.only)
    chosen = [one for one in listed if not only or only & {one.area, one.name}]
    return 1 if _run(chosen, options.jobs) else 0


if __name__ == "__main__":
    sys.exit(main())
