"""The process in which files are read: ``python -W error -m tests.fuzz.child KIND FIRST COUNT``.

It makes and reads the cases FIRST … FIRST + COUNT − 1 of a kind, in the working directory, and
prints a line for each that ends in anything but an error of omnimorph's own. A case that takes
longer than 10 s ends the process; so may one that crashes it. The last line "begin" then tells.
"""

from __future__ import annotations

import faulthandler
import resource
import sys
import traceback
from pathlib import Path
from random import Random

from tests.fuzz.kinds import KINDS, Kind

from omnimorph.design.ranges import Range
from omnimorph.errors import OmnimorphError

LONGEST = 10.0  # s
MOST_MEMORY = 2**30  # bytes, beside what the process has before the first case


def main(name: str, first: int, count: int, *bugs: str) -> None:
    """Read so many cases of a kind."""
    if "no-ranges" in bugs:
        Range.__contains__ = lambda self, number: True  # type: ignore[method-assign]
    kind = KINDS[name]
    warm_up(kind)
    limit_memory()
    for case in range(first, first + count):
        tell(f"begin {case}")
        data = kind.make(Random(f"{name} {case}"))
        told = failure(kind, data)
        if told:
            tell(f"failed {case} {told}")


def tell(line: str) -> None:
    """Print a line at once, so that it is known whatever comes next."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def failure(kind: Kind, data: bytes) -> str:
    """Return on one line what is wrong with how a file was read; nothing if all is well."""
    path = Path(kind.name)
    path.write_bytes(data)
    faulthandler.dump_traceback_later(LONGEST, exit=True)
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
        faulthandler.cancel_dump_traceback_later()
    return ""


def warm_up(kind: Kind) -> None:
    """Load what is loaded on first use, so that it counts for no case."""
    for seed in range(3):
        failure(kind, kind.make(Random(f"warm {seed}")))


def limit_memory() -> None:
    """Let the process have so much more address space than it has now, and no more."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    size = next(line for line in status.splitlines() if line.startswith("VmSize:"))
    most = 1024 * int(size.split()[1]) + MOST_MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), *sys.argv[4:])
