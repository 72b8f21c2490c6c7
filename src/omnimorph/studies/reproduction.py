"""Fly what the paper flew, and write a report that sets it beside what the paper reports.

::

    from pathlib import Path
    from omnimorph.studies.reproduction import reproduce

    reproduce(Path("reproduction"))      # -> reproduction/report.html

Everything is flown first (`fly_everything`), then judged and drawn into a folder that appears as a
whole (`own_folder`).
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from omnimorph.errors import InputError
from omnimorph.results.atomic import write_text
from omnimorph.results.metrics import Metrics
from omnimorph.studies.own_folder import own_folder
from omnimorph.studies.paper_comparison import judge_claims, judge_values
from omnimorph.studies.paper_flights import N_FLIGHTS_BUT_SEEDS, SCENARIOS, Flown, fly_everything
from omnimorph.studies.reproduction_page import N_PICTURES, draw_pictures, write_page

__all__ = ["SCHEMA", "reproduce"]

Progress = Callable[[float, float, str], None]

SCHEMA = "omnimorph reproduction"
"""What ``results.json`` says it is; a folder with such a file may be written over."""
_KEPT = ("paper-case-a", "paper-case-b")


def reproduce(
    out: Path, *, seeds: int = 5, seed: int = 0, progress: Progress | None = None
) -> Path:
    """Fly the paper's cases and write the report; all of it appears, or nothing does.

    Parameters
    ----------
    out : Path
        A folder: a new one, an empty one, or one that this function wrote before. It gets
        ``report.html``, ``results.json``, ``run-paper-case-a.nc``, ``run-paper-case-b.nc`` and
        ``figures/`` with every figure as SVG and PDF.
    seeds : int
        How many flights of each scenario, at least 1.
    seed : int
        The first of their seeds; the figures show it.
    progress : callable, optional
        Called now and then with what is done, what there is to do, and what comes next.

    Returns
    -------
    Path
        Of ``report.html``.

    Raises
    ------
    InputError
        If `out` is a file or somebody else's folder, cannot be written, or `seeds` is not positive.
    """
    if seeds < 1:
        raise InputError.at("reproduce", "seeds", seeds, "at least 1")
    steps = _Steps(progress, seeds * len(SCENARIOS) + N_FLIGHTS_BUT_SEEDS + N_PICTURES)
    with own_folder(Path(out), SCHEMA) as folder:
        flown = fly_everything(range(seed, seed + seeds), steps)
        for name in _KEPT:
            flown.runs[name].save(folder / _run_file(name))
        results = _results(flown)
        pictures = draw_pictures(flown, folder / "figures", steps)
        write_page(folder / "report.html", flown, pictures, [_run_file(name) for name in _KEPT])
        # Last, as it makes the folder ours.
        write_text(folder / "results.json", json.dumps(results, indent=2, allow_nan=False) + "\n")
    return Path(out) / "report.html"


class _Steps:
    """Counts what is done and tells it."""

    def __init__(self, progress: Progress | None, total: int) -> None:
        self._progress, self._total, self._done = progress, total, 0

    def __call__(self, label: str) -> None:
        if self._progress is not None:
            self._progress(self._done, self._total, label)
        self._done += 1


def _run_file(name: str) -> str:
    return f"run-{name}.nc"


def _results(flown: Flown) -> dict[str, object]:
    """Return what ``results.json`` holds; nothing in it depends on when or how fast it was made."""
    realistic = {
        name: {
            "content_hash": flown.runs[name].content_hash,
            "metrics": flown.runs[name].metrics.as_dict(),
            "over_seeds": _over_seeds(flown.spread[name]),
        }
        for name in SCENARIOS
    }
    values = judge_values(flown.spread)
    claims = judge_claims(flown.spread, flown.runs)
    return {
        "schema": SCHEMA,
        "schema_version": 1,
        "version": flown.runs[_KEPT[0]].provenance.version,
        "seeds": list(flown.seeds),
        "realistic": realistic,
        "perfect": {name: metrics.as_dict() for name, metrics in flown.perfect.items()},
        "variants": [
            {
                "step_s": variant.step,
                "noise": variant.noise,
                "paper-case-a": variant.run.metrics.as_dict(),
                "paper-case-b": variant.b.as_dict(),
            }
            for variant in flown.variants
        ],
        "beside_the_paper": [
            vars(value) | {"difference": value.difference, "verdict": value.verdict.value}
            for value in values
        ],
        "claims": [vars(claim) | {"verdict": claim.verdict.value} for claim in claims],
    }


def _over_seeds(metrics: list[Metrics]) -> dict[str, dict[str, float | None]]:
    """Return smallest, mean and largest of every metric that is a number; null if none is."""
    rows = [one.as_dict() for one in metrics]
    found: dict[str, dict[str, float | None]] = {}
    for key in rows[0]:
        values = [value for row in rows if isinstance(value := row[key], float)]
        if len(values) == len(rows):
            found[key] = {"min": min(values), "mean": float(np.mean(values)), "max": max(values)}
        elif key != "outcome":
            found[key] = {"min": None, "mean": None, "max": None}
    return found
