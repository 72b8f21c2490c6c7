"""How much memory there is, and the refusal of what needs more, before any of it is taken."""

from __future__ import annotations

import os
import resource
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from omnimorph.errors import TooLargeError

_ALWAYS_THERE = 2**26  # bytes that nobody needs to look for


def refuse_more_than_memory(what: str, needed: int, instead: str) -> None:
    """Refuse what needs more memory than there is.

    Parameters
    ----------
    what : str
        What needs it, as the beginning of a sentence, in the plural.
    needed : int
        Bytes, as estimated.
    instead : str
        What to do instead.

    Raises
    ------
    TooLargeError
        If there are fewer.
    """
    if needed <= _ALWAYS_THERE:
        return
    free = available_bytes()
    if needed > free:
        raise TooLargeError(
            f"{what} need about {_size(needed)} of memory, but {_size(free)} are free; {instead}."
        )


def available_bytes(root: Path = Path("/")) -> int:
    """Return the bytes of memory that this process can still have.

    The least of what the machine has free, what the control groups leave that this process is in
    (a container's limit is one), and what its own limit of address space leaves.

    Parameters
    ----------
    root : Path
        Where ``proc`` and ``sys`` are.
    """
    return max(min(_free_of_machine(root), *_free_of_groups(root), _free_of_limit(root)), 0)


def _free_of_machine(root: Path) -> int:
    try:
        lines = (root / "proc/meminfo").read_text().splitlines()
        sizes = dict(line.split(":", 1) for line in lines)
        return 1024 * int(sizes["MemAvailable"].split()[0])
    except (OSError, KeyError, ValueError):  # not Linux
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _free_of_groups(root: Path) -> Iterator[int]:
    """Yield what each group with a limit leaves: of version 2 and of version 1, and those above."""
    mounted = root / "sys/fs/cgroup"
    with suppress(OSError, ValueError):
        for line in (root / "proc/self/cgroup").read_text().splitlines():
            _, controllers, path = line.split(":", 2)
            inside = Path(path.lstrip("/"))
            for group in (inside, *inside.parents):
                if not controllers:
                    yield from _left(mounted / group, "memory.max", "memory.current", "")
                elif "memory" in controllers.split(","):
                    names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_")
                    yield from _left(mounted / "memory" / group, *names)


def _left(group: Path, limit: str, used: str, prefix: str) -> Iterator[int]:
    """Yield limit − used, where there is a limit; cached files that can be let go are not used."""
    with suppress(OSError, ValueError):  # no such group is seen from here, or its limit is "max"
        most, now = int((group / limit).read_text()), int((group / used).read_text())
        lines = (group / "memory.stat").read_text().splitlines()
        cached = dict(line.split() for line in lines).get(f"{prefix}inactive_file", "0")
        yield most - now + int(cached)


def _free_of_limit(root: Path) -> int:
    most, _ = resource.getrlimit(resource.RLIMIT_AS)
    if most == resource.RLIM_INFINITY:
        return 2**63
    with suppress(OSError, ValueError):
        pages = int((root / "proc/self/statm").read_text().split()[0])
        return most - pages * os.sysconf("SC_PAGE_SIZE")
    return most


def _size(count: int) -> str:
    """Return a number of bytes as people say it.

    Examples
    --------
    >>> _size(41_000_000_000), _size(730_000_000), _size(5 * 10**20)
    ('41 GB', '730 MB', '5e+08 TB')
    """
    for unit, name in ((1e12, "TB"), (1e9, "GB")):
        if count >= unit:
            return f"{count / unit:.3g} {name}"
    return f"{count / 1e6:.3g} MB"
