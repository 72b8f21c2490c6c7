"""A folder that results are written into: all of them appear at once, or nothing does."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from omnimorph.errors import InputError
from omnimorph.machine.signals import held_back
from omnimorph.results.temporary import temporary_in


def check_folder(out: Path) -> None:
    """Refuse a folder that cannot be written to, before hours are spent on what goes there.

    Raises
    ------
    InputError
        If it is there but no folder, or could not be made.
    """
    with _refusing(out):
        nearest = next(path for path in (out, *out.absolute().parents) if os.path.lexists(path))
        if not nearest.is_dir():
            raise InputError(f"{out}: cannot be written to, because {nearest} is not a folder.")
        if not os.access(nearest, os.W_OK | os.X_OK):
            raise InputError(f"{out}: cannot be written to, because {nearest} is read-only.")


def replaced_text(*paths: Path) -> str:
    """Return, before files are written, which of them are there already; "" if none is.

    Every command that writes results says so on standard error: results replace older ones of
    their names.

    Examples
    --------
    >>> replaced_text(Path("no-such-folder", "run.nc"))
    ''
    """
    older = [str(path) for path in paths if path.is_file()]
    return f"replaced what was there: {', '.join(older)}." if older else ""


@contextmanager
def staged(out: Path, first: str = "") -> Iterator[Path]:
    """Give a folder to write into; its files then move to `out`, over older ones of their names.

    If anything goes wrong, or the user interrupts, nothing of it is left: neither the files nor
    folders made for them, and older files stay as they were.

    Parameters
    ----------
    out : Path
        The folder; it is made if need be.
    first : str
        Name of the file that moves before the others, if it matters.

    Raises
    ------
    InputError
        If it cannot be written to: a file of that name, no permission, a full disk.
    KeyboardInterrupt
        Passed on, with a sentence that says whether anything was written.
    """
    check_folder(out)
    made: list[Path] = []
    written = "nothing was written to"
    try:
        with _refusing(out):
            home = out.absolute() if out.is_dir() else out.absolute().parent
            for path in reversed([path for path in (home, *home.parents) if not path.exists()]):
                path.mkdir()
                made.append(path)
        with _refusing(out), temporary_in(home, as_folder=True) as part, _refusing(out, part):
            yield part
            with held_back():
                _publish(part, out, first)
                written = "all of it is in"
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"{written} {out}.") from None
    finally:
        with held_back():
            for path in reversed(made):
                with suppress(OSError):  # what was published into it keeps a folder
                    path.rmdir()


def _publish(part: Path, out: Path, first: str) -> None:
    """Move everything from one folder to the other; `out` may be there or not."""
    if not out.is_dir():
        part.rename(out)
        return
    files = sorted(path for path in part.rglob("*") if not path.is_dir())
    files.sort(key=lambda path: path.name != first)
    targets = [out / path.relative_to(part) for path in files]
    for target in targets:
        if target.is_dir():
            raise InputError(f"{target}: it cannot be written, because it is a folder.")
        target.parent.mkdir(parents=True, exist_ok=True)
    for path, target in zip(files, targets, strict=True):
        path.replace(target)


@contextmanager
def _refusing(out: Path, part: Path | None = None) -> Iterator[None]:
    """Report a failure to write as the user's mistake, and with the name the user gave."""
    try:
        yield
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(f"{out}: cannot be written to: {reason}.", file=str(out)) from error
    except InputError as error:
        if part is None or str(part) not in str(error):
            raise
        raise InputError(str(error).replace(str(part), str(out)), file=str(out)) from error
