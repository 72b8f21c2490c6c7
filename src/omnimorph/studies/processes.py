"""A pool for work that keeps the interpreter busy: processes where they can be forked."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any

from omnimorph.machine.children import end_with


def busy_pool(
    workers: int | None = None, prepare: Callable[..., None] | None = None, *args: Any
) -> Executor:
    """Return a pool of as many workers as there are cores, or of so many.

    On Linux they are forked: they see all that this process knows without a copy, and only what
    they answer is sent. Elsewhere forking is not safe and they are threads, which take turns.

    Parameters
    ----------
    workers : int, optional
        How many.
    prepare : callable
        Called with `args` in each worker before its first task; nothing of it is copied.

    Notes
    -----
    A Ctrl-C is this process's to answer; the workers do not notice it. They end with it, however it
    ends.
    """
    count = workers or os.cpu_count()
    if sys.platform != "linux":
        return ThreadPoolExecutor(count, initializer=prepare, initargs=args)
    fork = multiprocessing.get_context("fork")
    return ProcessPoolExecutor(count, fork, _begin, (os.getpid(), prepare, *args))


def _begin(parent: int, prepare: Callable[..., None] | None, *args: Any) -> None:
    end_with(parent)
    for number in (signal.SIGINT, signal.SIGHUP):  # they reach all processes of a terminal
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # by which a pool ends what is left of it
    if prepare is not None:
        prepare(*args)
