"""A folder that one kind of result has for itself: it appears as a whole and harms no other."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from omnimorph.design.input_files import MEGABYTE, read_text
from omnimorph.errors import InputError
from omnimorph.results.atomic import write_text
from omnimorph.results.folder import staged
from omnimorph.results.temporary import is_temporary
from omnimorph.studies.flight_log import is_flight_log

_MARK = "results.json"
_LARGEST_MARK = 64 * MEGABYTE
FLIGHTS = "flights.jsonl"
"""Name of the log of finished flights, which a study that was interrupted leaves behind."""


@contextmanager
def own_folder(out: Path, schema: str) -> Iterator[Path]:
    """Give a folder to write into; when all went well, its files move to `out`.

    If anything goes wrong, an interrupt included, `out` is left as it was. What is written must
    hold a ``results.json`` whose ``schema`` is `schema`: by it the folder is known as its own the
    next time, so it is the first to move.

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
    check_own(out, schema)
    with staged(out, first=_MARK) as part:
        yield part


def write_results(folder: Path, data: dict[str, Any]) -> None:
    """Write ``results.json``, by which the folder is known as its own; numbers must be finite."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False)
    write_text(folder / _MARK, text + "\n")


def check_own(out: Path, schema: str) -> None:
    """Refuse what is no folder, and a folder with files that are not ours.

    Ours is what holds results of the schema, or nothing but a log of flights.

    Raises
    ------
    InputError
        If `out` is something else.
    """
    if not os.path.lexists(out):
        return
    if not out.is_dir():
        sentence = f"{out}: it is not a folder; give a new or an empty one."
        raise InputError(sentence, file=str(out))
    log = out / FLIGHTS
    others = {path for path in out.iterdir() if not is_temporary(path)}
    unfinished = others == {log} and is_flight_log(log)
    if others and not unfinished and _schema_of(out / _MARK) != schema:
        sentence = (
            f"{out}: the folder is not empty and not one of ours; give a new or an empty one."
        )
        raise InputError(sentence, file=str(out))


def _schema_of(path: Path) -> object:
    try:
        content = json.loads(read_text(path, InputError, _LARGEST_MARK))
    except (InputError, ValueError, RecursionError):
        return None
    return content.get("schema") if isinstance(content, dict) else None
