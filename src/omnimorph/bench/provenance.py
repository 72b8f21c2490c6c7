"""Where the numbers come from: machine, versions, date."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

from omnimorph.version import __version__


def provenance_of_machine(peers: Sequence[str] = ()) -> dict[str, str]:
    """Return what the numbers depend on, name by name; `peers` are packages that may be missing."""
    installed = {package.metadata["Name"].lower() for package in metadata.distributions()}
    named = ["numpy", "scipy", "daqp", *(peer for peer in peers if peer in installed)]
    versions = [f"{name} {metadata.version(name)}" for name in named]
    python = f"{platform.python_implementation()} {platform.python_version()}"
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "processor": _processor(),
        "cores": f"{_usable_cores()} usable of {os.cpu_count()}; a flight uses one, a batch all",
        "system": f"{platform.system()} {platform.release()}, {platform.machine()}",
        "versions": ", ".join([f"omnimorph {__version__}", *versions, python]),
        "load before": _load(),
    }


def _processor() -> str:
    """Return the name of the processor as the system reports it."""
    table = Path("/proc/cpuinfo")
    if table.is_file():
        for line in table.read_text(encoding="utf-8", errors="replace").splitlines():
            name, _, value = line.partition(":")
            if name.strip() in ("model name", "Model"):
                return value.strip()
    return platform.processor() or platform.machine()


def _usable_cores() -> int:
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def _load() -> str:
    """Return how many processes wanted a core in the last minute: the others among them disturb."""
    return f"{os.getloadavg()[0]:.2f} processes in the last minute"
