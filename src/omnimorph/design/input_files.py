"""The door through which every file comes in: a plain file of a sensible size, or a sentence."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from typing import BinaryIO

from omnimorph.errors import InputError, legible, shown

MEGABYTE = 2**20

is_file, is_folder = os.path.isfile, os.path.isdir
"""Unlike those of `Path`, these say False of a name that no file can have."""


def open_input(path: object, refuse: Callable[[str], InputError]) -> BinaryIO:
    """Open a plain file to be read.

    A pipe, a device or a folder is refused before it is opened: to read one may take for ever.
    `refuse` makes the error of the reason, which is read after "because".
    """
    if not isinstance(path, str | os.PathLike):
        raise refuse(f"{shown(path)} is not the path of a file")
    try:
        _check_kind(os.stat(path).st_mode, refuse)
        # It may have become another one since, and then a pipe without a writer must not wait.
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        file = os.fdopen(descriptor, "rb")
        try:
            _check_kind(os.fstat(descriptor).st_mode, refuse)
        except InputError:
            file.close()
            raise
        return file
    except FileNotFoundError:
        reason = "there is no such file"
    except (OSError, ValueError) as problem:  # not allowed, a name too long or with a null in it
        reason = (getattr(problem, "strerror", None) or str(problem)).lower()
    raise refuse(reason)


def _check_kind(mode: int, refuse: Callable[[str], InputError]) -> None:
    if stat.S_ISDIR(mode):
        raise refuse("it is a directory")
    if not stat.S_ISREG(mode):
        raise refuse("it is a pipe, a socket or a device")


def read_text(path: object, error: type[InputError], most: int = MEGABYTE) -> str:
    """Read a text file in UTF-8 of at most so many bytes; raise `error` with the reason if not."""

    def refuse(reason: str) -> InputError:
        name = os.fsdecode(path) if isinstance(path, str | os.PathLike) else "the file"
        sentence = f"{legible(name)}: this file cannot be read, because {reason}."
        return error(sentence, file=name)

    try:
        with open_input(path, refuse) as file:
            data = file.read(most + 1)
    except OSError as problem:
        raise refuse((problem.strerror or str(problem)).lower()) from problem
    if len(data) > most:
        raise refuse(f"it is larger than {most / MEGABYTE:g} MB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise refuse("it is not a text file in UTF-8") from None
