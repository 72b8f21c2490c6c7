"""A folder that one kind of result has for itself: it appears as a whole and harms no other."""

from __future__ import annotations

import json
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from omnimorph.errors import InputError

__all__ = ["own_folder"]

_MARK = "results.json"
_PART_START, _PART_END = ".omnimorph-", ".part"


@contextmanager
def own_folder(out: Path, schema: str) -> Iterator[Path]:
    """Give a folder to write into; when all went well, its files move to `out`.

    If anything goes wrong, an interrupt included, `out` is left as it was. What is written must
    hold a ``results.json`` whose ``schema`` is `schema`: by it the folder is known as its own the
    next time.

    Parameters
    ----------
    out : Path
        A folder that is new, empty, or was written this way before with the same schema.
    schema : str
        What kind of result it holds.

    Raises
    ------
    InputError
        If `out` is not such a folder, or cannot be written to.
    """
    part = out
    try:
        _check(out, schema)
        made = _make_folders(out)
        part = out / f"{_PART_START}{secrets.token_hex(6)}{_PART_END}"
        try:
            part.mkdir()
            yield part
            _publish(part, out)
        finally:
            shutil.rmtree(part, ignore_errors=True)
            for folder in reversed(made):
                with suppress(OSError):  # it is kept if something was published into it
                    folder.rmdir()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"{out}: it cannot be written to: {reason}.", file=str(out)) from error
    except InputError as error:
        if str(part) not in str(error) or part == out:
            raise
        raise InputError(str(error).replace(str(part), str(out)), file=str(out)) from error


def _check(out: Path, schema: str) -> None:
    """Refuse what is no folder, and a folder with files that are not ours."""
    if not os.path.lexists(out):
        return
    if not out.is_dir():
        sentence = f"{out}: it is not a folder; give a new or an empty one."
        raise InputError(sentence, file=str(out))
    others = [path for path in out.iterdir() if not _is_left_over(path)]
    if others and _schema_of(out / _MARK) != schema:
        sentence = (
            f"{out}: the folder is not empty and not one of ours; give a new or an empty one."
        )
        raise InputError(sentence, file=str(out))


def _is_left_over(path: Path) -> bool:
    """Tell whether a path is what a killed process left."""
    return path.name.startswith(_PART_START) and path.name.endswith(_PART_END)


def _schema_of(path: Path) -> object:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return content.get("schema") if isinstance(content, dict) else None


def _make_folders(out: Path) -> list[Path]:
    """Make the folder and those above it; return the new ones, outermost first."""
    missing = [path for path in (out, *out.parents) if not path.exists()]
    for path in reversed(missing):
        path.mkdir()
    return missing[::-1]


def _publish(part: Path, out: Path) -> None:
    """Move everything from one folder into the other, over older files of the same names.

    The mark goes first: if the process is killed in between, the folder is known as ours.
    """
    files = sorted(path for path in part.rglob("*") if not path.is_dir())
    files.sort(key=lambda path: path.name != _MARK)
    for path in files:
        target = out / path.relative_to(part)
        target.parent.mkdir(parents=True, exist_ok=True)
        path.replace(target)
