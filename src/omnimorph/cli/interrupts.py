"""Ctrl-C: held back where it would do harm, and remembered where somebody swallows it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

__all__ = ["pressed", "remembered", "renew", "wait"]

_pressed = threading.Event()


@contextmanager
def remembered() -> Iterator[None]:
    """Remember a Ctrl-C, which also raises `KeyboardInterrupt` as usual.

    A library in whose callback it falls may swallow the exception; `renew` raises it again.
    """

    def interrupt(number: int, frame: FrameType | None) -> NoReturn:
        _pressed.set()
        raise KeyboardInterrupt

    _pressed.clear()
    with _handled_by(interrupt):
        yield


@contextmanager
def wait() -> Iterator[None]:
    """Hold a Ctrl-C back until the end: a module that is half loaded cannot bear one."""
    with _handled_by(lambda number, frame: _pressed.set()):
        yield
    renew()


def pressed() -> bool:
    """Tell whether Ctrl-C was pressed since `remembered` began."""
    return _pressed.is_set()


def renew() -> None:
    """Raise `KeyboardInterrupt` if Ctrl-C was pressed since `remembered` began."""
    if pressed():
        raise KeyboardInterrupt


@contextmanager
def _handled_by(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
