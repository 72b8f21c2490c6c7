"""The process in which files are read, in the working directory.

``python -W error -m tests.fuzz.child cases KIND FIRST COUNT [BUG]`` makes and reads so many cases
of a kind; ``… files KIND FILE …`` reads files. Each that ends in anything but an error of
omnimorph's own is printed on a line. One that computes for more than 10 s, or waits for more
than 60, ends the process, with a traceback; so may one that crashes it. The last line "begin" then
tells which it was.
"""

from __future__ import annotations

import faulthandler
import os
import resource
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from random import Random

from tests.fuzz.kinds import KINDS, Kind

from omnimorph.design.ranges import Range
from omnimorph.errors import OmnimorphError, UnlikelyUnitWarning

LONGEST = 10.0  # s of computing: how busy the machine is does not count
LONGEST_WAIT = 60.0  # s
MOST_MEMORY = 2**30  # bytes, beside what the process has before the first case


def read_cases(name: str, first: str, count: str, bug: str = "") -> None:
    """Make and read so many cases of a kind, with a bug planted if one is named."""
    kind = KINDS[name]
    if bug:
        kind = BUGS[bug](kind)
    else:
        limit_memory(kind)
    for case in range(int(first), int(first) + int(count)):
        tell(f"begin {case}")
        reported = failure(kind, kind.make(Random(f"{name} {case}")))
        if reported:
            tell(f"failed {case} {reported}")


def read_files(name: str, *files: str) -> None:
    """Read files."""
    limit_memory(KINDS[name])
    for file in files:
        tell(f"begin {file}")
        reported = failure(KINDS[name], Path(file).read_bytes())
        if reported:
            tell(f"failed {file} {reported}")


def failure(kind: Kind, data: bytes) -> str:
    """Return on one line what is wrong with how a file was read; nothing if all is well."""
    path = Path(kind.name)
    path.write_bytes(data)
    faulthandler.dump_traceback_later(LONGEST_WAIT, exit=True)
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    try:
        kind.use(path)
    except OmnimorphError as refused:
        sentence = str(refused)
        fits = sentence.isprintable() and len(sentence) < 2000
        return "" if fits else f"a sentence nobody wants to read: {sentence[:200]!r}"
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(where.filename).name}:{where.lineno} {where.name}"
        return f"{type(error).__name__} at {place}: {str(error)[:200]!r}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        faulthandler.cancel_dump_traceback_later()
    return ""


def tell(line: str) -> None:
    """Print a line at once, so that it is known whatever comes next."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def limit_memory(kind: Kind) -> None:
    """Let the process have so much more address space than it has now, and no more.

    What is loaded on first use counts for no case, so a few are read before.
    """
    for seed in range(3):
        failure(kind, kind.make(Random(f"warm {seed}")))
    status = Path("/proc/self/status").read_text(encoding="ascii")
    size = next(line for line in status.splitlines() if line.startswith("VmSize:"))
    most = 1024 * int(size.split()[1]) + MOST_MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


# --- bugs that must be found ----------------------------------------------------------------------


def without_ranges(kind: Kind) -> Kind:
    """Let every number pass."""
    limit_memory(kind)
    Range.__contains__ = lambda self, number: True  # type: ignore[method-assign]
    return kind


def with_use(use: Callable[[Path], object]) -> Callable[[Kind], Kind]:
    """Return what plants another reader."""

    def plant(kind: Kind) -> Kind:
        limit_memory(kind)
        return kind._replace(use=use)

    return plant


BUGS: dict[str, Callable[[Kind], Kind]] = {
    "no-ranges": without_ranges,
    "waits": with_use(lambda path: time.sleep(600.0)),
    "computes": with_use(lambda path: sum(range(10**12))),
    "hoards": with_use(lambda path: bytearray(2 * MOST_MEMORY)),
    "crashes": with_use(lambda path: os.abort()),
}


def main(what: str, *words: str) -> None:
    """Do what the words say."""
    warnings.simplefilter("ignore", UnlikelyUnitWarning)  # mutated numbers deserve it
    faulthandler.register(signal.SIGPROF, chain=True)  # a traceback, and then the end
    if what == "cases":
        read_cases(*words)
    else:
        read_files(*words)


if __name__ == "__main__":
    main(*sys.argv[1:])
