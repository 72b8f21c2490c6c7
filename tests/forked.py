"""Processes of their own that need not import everything once more: forked from one that has.

What a program does there to files, output, exit code, limits and memory is its own. What only a
whole interpreter shows (how it begins and ends, signals, terminals) is tested with whole ones; so
runs `test_readme.py` each command.
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import subprocess
import sys
import traceback
from pathlib import Path
from select import select
from tempfile import TemporaryDirectory
from typing import IO, Any, NoReturn

_PATIENCE = 120.0  # s
_WRITTEN = os.O_WRONLY | os.O_CREAT | os.O_TRUNC


class Forked:
    """A process that has run a program, and goes on with others in copies of itself.

    Parameters
    ----------
    before : str
        The program that all others go on from.
    environment : dict of str
    """

    def __init__(self, before: str, environment: dict[str, str]) -> None:
        self._folder = TemporaryDirectory()
        self._process = subprocess.Popen(
            [sys.executable, str(Path(__file__))],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        _send(self._process.stdin, before)

    def run(self, program: str, folder: Path) -> subprocess.CompletedProcess[str]:
        """Run a program in a folder, to its end."""
        out, err = (Path(self._folder.name, name) for name in ("out", "err"))
        answers = self._process.stdout
        assert answers is not None
        _send(self._process.stdin, [program, str(folder), str(out), str(err)])
        if not select([answers], [], [], _PATIENCE)[0]:
            self._process.kill()  # its answer would be taken for that of the next
            raise AssertionError(f"no end of {program}")
        code = int(answers.readline())
        said = (file.read_bytes().decode() for file in (out, err))
        return subprocess.CompletedProcess([program], code, *said)

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()
        self._folder.cleanup()


def _send(pipe: IO[str] | None, what: Any) -> None:
    assert pipe is not None
    pipe.write(json.dumps(what) + "\n")
    pipe.flush()


def _serve() -> None:
    """Fork for each line that holds a program, and answer with its exit code."""
    names: dict[str, Any] = {"__name__": "__main__"}
    exec(json.loads(sys.stdin.readline()), names)
    gc.freeze()  # so that what was imported stays shared
    while line := sys.stdin.readline():  # a line at a time: the child must not find the next ones
        program, *places = json.loads(line)
        child = os.fork()
        if child == 0:
            _become(program, names, *places)
        _send(sys.stdout, os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))


def _become(program: str, names: dict[str, Any], folder: str, out: str, err: str) -> NoReturn:
    """Run a program and end, but without taking down all that was imported, which takes 0.2 s."""
    os.chdir(folder)
    for number, (name, way) in enumerate(
        ((os.devnull, os.O_RDONLY), (out, _WRITTEN), (err, _WRITTEN))
    ):
        os.dup2(os.open(name, way, 0o600), number)
    sys.path[0] = folder
    code = 0
    try:
        exec(program, names)
    except SystemExit as end:
        code = int(end.code or 0)
    except BaseException:
        traceback.print_exc()
        code = 1
    atexit._run_exitfuncs()
    sys.stdout.flush()
    os._exit(code)


if __name__ == "__main__":
    _serve()
