"""What asks a program to end: Ctrl-C, ``kill``, and a terminal that is closed."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def answered_by(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Let a function answer `ENDING`; only the main thread may, so elsewhere nothing changes.

    One that is ignored, as under ``nohup``, is left ignored.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in ENDING}
    answered = {number: old for number, old in before.items() if old not in (None, signal.SIG_IGN)}
    try:
        for number in answered:
            signal.signal(number, handler)
        yield
    finally:
        for number, old in answered.items():
            signal.signal(number, old)


@contextmanager
def held_back() -> Iterator[None]:
    """Hold `ENDING` back for the blink of an eye in which files are moved; then it takes effect."""
    came: list[int] = []
    try:
        with answered_by(lambda number, frame: came.append(number)):
            yield
    finally:
        if came:
            signal.raise_signal(came[0])
