"""What came out of a flight: the `Run`, its `Metrics`, and the file both are kept in.

- `Run`: motion, commands and their proofs over time, with `Outcome`, `Provenance`, `Performance`;
- `Metrics`: the numbers of a run, named as the keys of ``metrics.json``;
- `load_run`: reads what `Run.save` wrote.
"""

from __future__ import annotations

from omnimorph.results.metrics import Metrics, metrics_from_run
from omnimorph.results.run import Outcome, Performance, Provenance, Run
from omnimorph.results.store import load_run

__all__ = [
    "Metrics",
    "Outcome",
    "Performance",
    "Provenance",
    "Run",
    "load_run",
    "metrics_from_run",
]
