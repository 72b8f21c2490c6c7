"""Processes that end with the one that started them, however it ends: by ``kill -9``, too."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

_LAUNCHER = Path(__file__).with_name("launcher.py")
_BETWEEN_LOOKS = 0.1  # s


@contextmanager
def started(
    command: Sequence[str], *, output: int = subprocess.DEVNULL
) -> Iterator[subprocess.Popen[str]]:
    """Start a program in an empty folder of its own; give the process that looks after it.

    When the context is left, or this process is no more, the program is ended, with all that it has
    started, and the folder is removed. If it ends before, so does what looks after it, with its
    exit code, and prints what it took: see `omnimorph.machine.launcher`.

    Parameters
    ----------
    command : sequence of str
        The program and its arguments. Its standard output is thrown away.
    output : int
        Where the standard error of the program goes, and what is printed about it, as for
        `subprocess.Popen`.
    """
    theirs, ours = os.pipe()  # at its end, or at a word, the program is ended
    try:
        process = subprocess.Popen(
            [sys.executable, "-I", "-S", str(_LAUNCHER), *command],
            stdin=theirs,
            stdout=output,
            stderr=output,
            text=True,
            start_new_session=True,  # a Ctrl-C is this process's to answer
        )
    except BaseException:
        os.close(ours)
        raise
    finally:
        os.close(theirs)
    with process:
        try:
            yield process
        finally:
            with suppress(BrokenPipeError):  # it has ended
                os.write(ours, b".")  # a forked process may hold the pipe open, too
            os.close(ours)


def end_with(parent: int) -> None:
    """End this process, from now on, when `parent`, which forked or spawned it, is no more.

    A worker waits for its next task in a pipe that its sisters and it hold open themselves, so it
    would wait there for good.
    """

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(_BETWEEN_LOOKS)
        os._exit(1)

    threading.Thread(target=watch, name="ends with its parent", daemon=True).start()
