"""Temporary files and folders beside the results, and what killed processes left of them.

Who writes holds a lock on what it writes to. The system lets go of it when the process ends, in
whatever way; so what nobody holds was left, and the next one that writes there removes it.
"""

from __future__ import annotations

import fcntl
import os
import re
import secrets
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path

from omnimorph.machine.signals import held_back

_NAME = re.compile(r"\.omnimorph-[0-9a-f]{12}\.part")


def is_temporary(path: Path) -> bool:
    """Say by its name whether a path is one that `temporary_in` gave to somebody."""
    return _NAME.fullmatch(path.name) is not None


@contextmanager
def temporary_in(folder: Path, *, as_folder: bool = False) -> Iterator[Path]:
    """Give a new and empty file, or folder, in a folder; if it is there at the end, it is removed.

    Raises
    ------
    OSError
        If it cannot be made.
    """
    _remove_left_overs(folder)
    path, lock = _claimed(folder, as_folder)
    try:
        yield path
    finally:
        with held_back():
            _remove(path)
            os.close(lock)


def _claimed(folder: Path, as_folder: bool) -> tuple[Path, int]:
    """Make a file or folder and lock it; return the descriptor that holds the lock, too."""
    while True:
        path = folder / f".omnimorph-{secrets.token_hex(6)}.part"
        if as_folder:
            path.mkdir()
        else:
            path.touch(exist_ok=False)
        # In between, another process may have taken it for left over.
        with suppress(FileNotFoundError, BlockingIOError):
            return path, _locked(path)


def _locked(path: Path) -> int:
    """Lock a file or folder, where the file system can; return the descriptor that holds it.

    Raises
    ------
    OSError
        If it is gone, is neither, or another one holds it.
    """
    mode = os.lstat(path).st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise FileNotFoundError(path)
    how = os.O_RDWR if stat.S_ISREG(mode) else os.O_RDONLY | os.O_DIRECTORY
    lock = os.open(path, how | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if not os.path.samestat(os.fstat(lock), os.lstat(path)):
            raise FileNotFoundError(path)
    except OSError:
        os.close(lock)
        raise
    return lock


@lru_cache
def _remove_left_overs(folder: Path) -> None:
    """Remove what killed processes left in a folder; looked for once, as folders can be large."""
    for path in filter(is_temporary, folder.glob(".omnimorph-*.part")):
        with suppress(OSError):  # it is being written, or somebody else's
            lock = _locked(path)
            _remove(path)
            os.close(lock)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):  # it is gone if all went well
            path.unlink()
