"""What asks to end, such as Ctrl-C: held back where it would do harm, remembered where it is lost.

What is meant is `omnimorph.machine.signals.ENDING`: Ctrl-C, ``kill``, a terminal that is closed.
"""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from omnimorph.machine.signals import answered_by

_came: list[int] = []


@contextmanager
def remembered() -> Iterator[None]:
    """Remember what asked to end, and raise `KeyboardInterrupt` for it.

    A library in whose callback it falls may swallow the exception; `renew` raises it again. Only a
    Ctrl-C is answered more than once: a terminal that is closed sends it twice, and the second time
    would fall into what the first one began to clear away.
    """

    def interrupt(number: int, frame: FrameType | None) -> None:
        _came.append(number)
        if number == signal.SIGINT or len(_came) == 1:
            raise KeyboardInterrupt

    _came.clear()
    with answered_by(interrupt):
        yield


@contextmanager
def wait() -> Iterator[None]:
    """Hold it back until the end: a module that is half loaded cannot bear one."""
    with answered_by(lambda number, frame: _came.append(number)):
        yield
    renew()


def pressed() -> bool:
    """Return whether anything asked to end since `remembered` began."""
    return bool(_came)


def renew() -> None:
    """Raise `KeyboardInterrupt` if anything asked to end since `remembered` began."""
    if pressed():
        raise KeyboardInterrupt


def exit_code() -> int:
    """Return what a shell calls the end by the signal that came first: 130 for Ctrl-C."""
    return 128 + (_came[0] if _came else signal.SIGINT)
