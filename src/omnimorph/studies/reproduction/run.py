"""Reproduce the paper: fly, analyse, judge, and write the page.

::

    from pathlib import Path
    from omnimorph.studies.reproduction import Plan, reproduce

    reproduce(Path("reproduction"), Plan.whole())      # -> reproduction/report.html

Flights are kept one by one as they finish, in ``flights.jsonl``; what was interrupted goes on from
there. Everything else appears as a whole.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from omnimorph.errors import InputError
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.results.atomic import write_text
from omnimorph.studies.flight_log import FlightLog, FlightResult
from omnimorph.studies.many_flights import Job, fly_jobs
from omnimorph.studies.own_folder import FLIGHTS, check_own, own_folder
from omnimorph.studies.processes import busy_pool
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.ablation import count_ablation, fly_ablation
from omnimorph.studies.reproduction.degraded import count_degraded, fly_degraded, paper_loss
from omnimorph.studies.reproduction.design import examine_design
from omnimorph.studies.reproduction.figures.page import N_PICTURES, draw_pictures
from omnimorph.studies.reproduction.flight_claims import judge_flights
from omnimorph.studies.reproduction.flights import A, B, count_flights, fly_paper
from omnimorph.studies.reproduction.frontier import physical_limits
from omnimorph.studies.reproduction.hypotheses import count_hypotheses, fly_hypotheses
from omnimorph.studies.reproduction.interference import replay_experiment
from omnimorph.studies.reproduction.page import command, page_text, results_text
from omnimorph.studies.reproduction.plan import Plan, runs_of
from omnimorph.studies.reproduction.results import Results
from omnimorph.studies.reproduction.tilt_choice import (
    TiltChoice,
    count_choices,
    find_lower_bound,
    fly_choices,
    measure_gaps,
)
from omnimorph.studies.reproduction.verdicts import Judged

Progress = Callable[[float, float, str], None]

SCHEMA = "omnimorph reproduction"
"""What ``results.json`` says it is; a folder with such a file may be written over."""
_KEPT = (A, B)
_BYTES_OF_A_SEED = 20_000  # what is kept of the flights of each
_DRAWN_LOSSES = ("a_survives", "b_survives")


def reproduce(out: Path, plan: Plan, progress: Progress | None = None) -> Path:
    """Reproduce the paper and write the report.

    Parameters
    ----------
    out : Path
        A folder: a new one, an empty one, or one that this function wrote before. It gets
        ``report.html``, ``results.json`` and ``results.md``, ``run-paper-case-a.nc`` and
        ``run-paper-case-b.nc``, ``figures/`` with every figure as SVG and PDF, and
        ``flights.jsonl``.
    plan : Plan
        How much is flown.
    progress : callable, optional
        Called now and then with what is done, what there is to do, and what comes next.

    Returns
    -------
    Path
        Of ``report.html``.

    Raises
    ------
    InputError
        If `out` is a file or somebody else's folder, cannot be written, or the plan has no seed, or
        more seeds than memory holds.
    KeyboardInterrupt
        With a sentence that says where the finished flights are.
    """
    out = Path(out)
    if not plan.seeds:
        raise InputError.at("reproduce", "seeds", 0, "at least 1")
    count = plan.seeds.stop - plan.seeds.start
    needed = count * _BYTES_OF_A_SEED
    refuse_more_than_memory(f"reproduce: flights of {count} seeds", needed, "ask for fewer")
    check_own(out, SCHEMA)
    try:
        with FlightLog(out / FLIGHTS) as log:
            work = _Work(plan, log, progress)
            results = work.find()
        with own_folder(out, SCHEMA) as folder:
            _write(results, work, folder)
    except KeyboardInterrupt:
        if not len(log):
            raise
        kept = f"{len(log)} finished flights are kept in {out / FLIGHTS}"
        raise KeyboardInterrupt(f"{kept}; the same command goes on from there.") from None
    return out / "report.html"


class _Work:
    """Flies what the sections ask for, remembers for what, and reports how far it is."""

    def __init__(self, plan: Plan, log: FlightLog, progress: Progress | None) -> None:
        self.plan, self.log = plan, log
        self.flown: dict[str, list[tuple[Job, FlightResult]]] = {}
        self._progress, self._done = progress, 0
        counts = (count_flights, count_hypotheses, count_ablation, count_degraded, count_choices)
        self._total = sum(count(plan) for count in counts) + N_PICTURES

    def find(self) -> Results:
        """Answer every question of the page; what needs no flights is asked beside them."""
        plan, fly_them = self.plan, self.fly_jobs
        aside = busy_pool(1)
        try:
            design, experiment = aside.submit(examine_design), aside.submit(replay_experiment)
            physical, bound = aside.submit(physical_limits), aside.submit(find_lower_bound)
            gaps = aside.submit(measure_gaps, plan.seeds[0])
            return Results(
                flights=fly_paper(plan, fly_them),
                hypotheses=fly_hypotheses(plan, fly_them),
                ablation=fly_ablation(plan, fly_them),
                degraded=fly_degraded(plan, fly_them, physical.result()),
                degraded_runs=runs_of(
                    {key: paper_loss(key) for key in _DRAWN_LOSSES}, plan.seeds[0]
                ),
                tilt_choice=TiltChoice(
                    choices=fly_choices(plan, fly_them),
                    gaps=gaps.result(),
                    lower_bound=bound.result(),
                ),
                design=design.result(),
                experiment=experiment.result(),
            )
        finally:
            aside.shutdown(cancel_futures=True)

    def fly_jobs(self, jobs: Sequence[Job], purpose: str) -> list[FlightResult]:
        """Fly jobs, all that are not in the log."""
        flown = fly_jobs(jobs, self.log, lambda: self.report(f"flying {purpose}"))
        self.flown.setdefault(purpose, []).extend(zip(jobs, flown, strict=True))
        return flown

    def report(self, label: str) -> None:
        """Report that one more thing is about to be done."""
        if self._progress is not None:
            self._progress(self._done, self._total, label)
        self._done += 1

    @property
    def n_flights(self) -> int:
        """How many flights were asked for."""
        return sum(len(part) for part in self.flown.values())


def _write(results: Results, work: _Work, folder: Path) -> None:
    judged = _judged(results)
    names = {name: f"run-{name}.nc" for name in _KEPT}
    for name, file in names.items():
        results.flights.runs[name].save(folder / file)
    pictures = draw_pictures(results, folder / "figures", work.report, draft=work.plan.quick)
    page = page_text(
        results,
        judged,
        pictures,
        plan=work.plan,
        flown=work.flown,
        run_files=list(names.values()),
    )
    write_text(folder / "report.html", page)
    rows = [row for part in judged.values() for row in part]
    write_text(folder / "results.md", results_text(results, rows, command(work.plan)))
    # Last, as it makes the folder ours.
    text = json.dumps(_plain(_results(results, judged, work)), indent=2, allow_nan=False)
    write_text(folder / "results.json", text + "\n")


def _judged(results: Results) -> dict[str, list[Judged]]:
    """Return every claim of the paper, judged, by the section in which it stands."""
    forces = ("omnidirectional", "hover_lost", "break_even", "own_mechanism")
    design = results.design.judged
    sections = {
        "design": [row for row in design if not row.claim.key.startswith(forces)],
        "forces": [row for row in design if row.claim.key.startswith(forces)],
        "flights": judge_flights(results.flights, results.hypotheses),
        "interference": results.experiment.judged,
        "degraded": results.degraded.judged,
    }
    found = [row.claim.key for rows in sections.values() for row in rows]
    assert sorted(found) == sorted(paper.claims()), "each claim is judged once"
    return sections


def _results(results: Results, judged: dict[str, list[Judged]], work: _Work) -> dict[str, Any]:
    """Return what ``results.json`` holds; nothing in it depends on when or how fast it was made."""
    flights = results.flights
    return {
        "schema": SCHEMA,
        "schema_version": 3,
        "version": flights.runs[A].provenance.version,
        "quick": work.plan.quick,
        "seeds": list(work.plan.seeds),
        "n_flights": work.n_flights,
        "not_completed": sum(
            not flown.completed for part in work.flown.values() for _, flown in part
        ),
        "claims": [row.as_dict() for rows in judged.values() for row in rows],
        "design": results.design.as_dict(),
        "flights": flights.as_dict(),
        "hypotheses": [one.as_dict() for one in results.hypotheses],
        "ablation": results.ablation.as_dict(),
        "interference": results.experiment.as_dict(),
        "degraded": results.degraded.as_dict(),
        "tilt_choice": results.tilt_choice.as_dict(),
    }


def _plain(value: Any) -> Any:
    """Return content as JSON knows it: null where a number is not finite."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
