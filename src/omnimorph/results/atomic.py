"""Files that are whole or not there: written under another name, then renamed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from omnimorph.errors import RunFileError
from omnimorph.results.temporary import temporary_in


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Give a temporary path in the folder of `path`; what was written there then becomes `path`.

    If anything goes wrong, an interrupt included, the temporary file is removed and an older file
    of that name stays as it was. What a killed process left is removed by the next that writes into
    the folder.

    Parameters
    ----------
    path : str or Path
        The file to be written; a link is followed.

    Raises
    ------
    RunFileError
        If an `OSError` says that the file cannot be written: no folder, no permission, disk full.

    Examples
    --------
    >>> import tempfile
    >>> target = Path(tempfile.mkdtemp(), "numbers.txt")
    >>> with replacing(target) as temporary:
    ...     _ = temporary.write_text("42")
    >>> target.read_text()
    '42'
    """
    try:
        target = Path(os.path.realpath(path))
    except (TypeError, ValueError) as error:  # no path at all, or with a null in it
        raise RunFileError(f"{path}: it cannot be written: {error}.") from None
    try:
        if target.exists() and not target.is_file():
            raise RunFileError(f"{path}: it cannot be written: it is there, but it is not a file.")
        with temporary_in(target.parent) as temporary:
            yield temporary
            os.replace(temporary, target)
    except OSError as error:
        reason = error.strerror or str(error)
        raise RunFileError(f"{path}: it cannot be written: {reason}.", file=str(path)) from error


def write_text(path: str | Path, text: str) -> None:
    """Write a text file as a whole or not at all.

    Raises
    ------
    RunFileError
        If it cannot be written.
    """
    with replacing(path) as temporary:
        # A name that a file system has, and that is no UTF-8, is spelt out.
        temporary.write_text(text, encoding="utf-8", errors="backslashreplace")
