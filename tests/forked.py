"""Run `omnimorph WORD ...` in a process of its own that need not import everything once more.

A server imports what the commands need, then forks for each command: what runs there is `python -m
omnimorph`, in its own folder, with its own output and exit code. What an interpreter does when it
begins and ends (imports, signals, terminals) is tested with whole ones, in `test_readme.py` among
others.
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import runpy
import subprocess
import sys
import traceback
from importlib import import_module
from pathlib import Path
from select import select
from tempfile import TemporaryDirectory
from typing import IO, Any, NoReturn

_PATIENCE = 120.0  # s
_PREPARED = ("omnimorph.report.analysis_page", "matplotlib.backends.backend_svg", "jinja2", "h5py")
"""What commands import later than at their beginning."""


class Forked:
    """A server that runs commands, one at a time."""

    def __init__(self, environment: dict[str, str]) -> None:
        self._folder = TemporaryDirectory()
        self._server = subprocess.Popen(
            [sys.executable, str(Path(__file__))],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def run(self, words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
        """Run a command in a folder, to its end."""
        out, err = (Path(self._folder.name, name) for name in ("out", "err"))
        answers = self._server.stdout
        assert answers is not None
        _send(self._server.stdin, [words, str(folder), str(out), str(err)])
        assert select([answers], [], [], _PATIENCE)[0], f"no end of {words}"
        code = int(answers.readline())
        return subprocess.CompletedProcess(
            words, code, *(said.read_bytes().decode() for said in (out, err))
        )

    def close(self) -> None:
        """End the server."""
        self._server.kill()
        self._server.communicate()
        self._folder.cleanup()


def _send(pipe: IO[str] | None, what: Any) -> None:
    assert pipe is not None
    pipe.write(json.dumps(what) + "\n")
    pipe.flush()


def _serve() -> None:
    """Fork for each line that asks for a command, and answer with its exit code."""
    from omnimorph.cli.main import COMMANDS

    for name in {name for one in COMMANDS.values() for name in one.NEEDS}.union(_PREPARED):
        import_module(name)
    gc.freeze()  # so that what was imported stays shared
    while line := sys.stdin.readline():  # a line at a time: the child must not find the next ones
        words, *places = json.loads(line)
        child = os.fork()
        if child == 0:
            _become(words, *places)
        _send(sys.stdout, os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))


def _become(words: list[str], folder: str, out: str, err: str) -> NoReturn:
    """Be `omnimorph WORD ...` from now on."""
    os.chdir(folder)
    for number, (name, way) in enumerate(
        ((os.devnull, os.O_RDONLY), (out, _WRITTEN), (err, _WRITTEN))
    ):
        os.dup2(os.open(name, way, 0o600), number)
    sys.argv = ["omnimorph", *words]
    sys.path[0] = folder
    try:
        runpy.run_module("omnimorph", run_name="__main__")
    except SystemExit as end:
        atexit._run_exitfuncs()
        sys.stdout.flush()
        os._exit(int(end.code or 0))  # to take down all that was imported takes 0.2 s
    except BaseException:
        traceback.print_exc()
    os._exit(1)


_WRITTEN = os.O_WRONLY | os.O_CREAT | os.O_TRUNC

if __name__ == "__main__":
    _serve()
