"""The page ``report.html`` and ``results.md``: what was found, handed to the templates."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from omnimorph.report.page import Picture
from omnimorph.report.tables import metrics_table, plant_table, source_table, trajectory_table
from omnimorph.simulation.scenario_files import load_scenario
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.many_flights import Job
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.ablation import LESS, MORE, PERFECT, Ablation
from omnimorph.studies.reproduction.flights import CASES, A, B
from omnimorph.studies.reproduction.hypotheses import (
    ERRORS,
    MOMENTUM_AND_WAKES,
    WITH_MOMENTUM,
    Hypothesis,
)
from omnimorph.studies.reproduction.plan import Plan
from omnimorph.studies.reproduction.rendering import render
from omnimorph.studies.reproduction.results import Results
from omnimorph.studies.reproduction.spread import spread_of
from omnimorph.studies.reproduction.verdicts import Judged, Verdict, is_near
from omnimorph.studies.reproduction.wording import FLIGHT_LABELS


def page_text(
    results: Results,
    sections: Mapping[str, Sequence[Judged]],
    pictures: Mapping[str, Picture],
    *,
    plan: Plan,
    flown: Mapping[str, Sequence[tuple[Job, FlightResult]]],
    run_files: Sequence[str],
) -> str:
    """Return the report: one HTML file with everything in it."""
    run = results.flights.runs[A]
    judged = [row for part in sections.values() for row in part]
    content = {
        "title": "OmniMorph: the paper, line by line",
        "version": run.provenance.version,
        "article": paper.reference(),
        "run": run,
        "vehicle": run.vehicle,
        "quick": plan.quick,
        "seeds": plan.seeds,
        "n_flights": sum(len(part) for part in flown.values()),
        "results": results,
        "sections": sections,
        "pictures": pictures,
        "shown": _tables_of_run(results),
        "lost_beyond": load_scenario(A).lost_beyond,
        "failures": failures(flown),
        "command": command(plan),
        "run_files": run_files,
        **summary(results, judged),
        **reasons(results.ablation, results.hypotheses),
    }
    return render("reproduction.html.j2", **content)


def results_text(results: Results, judged: Sequence[Judged], command: str) -> str:
    """Return claims, rules, energies, errors, hypotheses and lost thrust, as Markdown."""
    counts = Counter(row.verdict.value for row in judged)
    content = {"results": results, "judged": judged, "verdict_counts": counts, "command": command}
    return render("results.md.j2", **content)


def summary(results: Results, judged: Sequence[Judged]) -> dict[str, Any]:
    """Return what the summary of the page names and counts."""
    counts = Counter(row.verdict.value for row in judged)
    claimed = [paper.claims()[f"drag_energy_{key}"].value or 0.0 for key in ("a", "b")]
    flights, choice = results.flights.realistic, results.tilt_choice
    means = [spread_of(flights[name], "drag_energy_paper").mean for name in (A, B)]
    conjectures = [one for one in results.hypotheses if one.verdict is Verdict.CONJECTURED]
    excess = [[choice.excess(one, name) for one in choice.choices] for name in CASES]
    return {
        "judged": judged,
        "verdict_counts": counts,
        "counted_verdicts": [f"{counts[v.value]} {v.value}" for v in Verdict if counts[v.value]],
        "near_energies": sum(map(is_near, means, claimed)),
        "conjecture": max(conjectures, key=lambda one: one.explained),
        "fit": next(one for one in results.hypotheses if one.verdict is Verdict.CALIBRATED),
        "energy_spread": max(max(one) - min(one) for one in excess),
    }


def reasons(ablation: Ablation, hypotheses: Sequence[Hypothesis]) -> dict[str, Any]:
    """Return what the page says of the ablation: tilts, worst imperfections, two hypotheses."""
    by_label = {(one.group, one.label): one for one in ablation.conditions}
    tilted = {
        "perfect": (PERFECT, "nothing"),
        "noise": (PERFECT, "noise"),
        "no_noise": (LESS, "no measurement noise"),
        "filtered": (MORE, "noise, filtered"),
    }
    own = [one for one in ablation.conditions if one.group in (MORE, LESS)]
    flown = {one.label: one for one in hypotheses}
    return {
        "tilt": {
            key: by_label[label].spread(A, "tilt_mean_deg").mean for key, label in tilted.items()
        },
        "worst": {
            metric: sorted(own, key=lambda one: -one.spread(B, metric).mean)[:3]
            for metric in ERRORS
        },
        "momentum": flown[WITH_MOMENTUM],
        "both": flown[MOMENTUM_AND_WAKES],
    }


class Failure(NamedTuple):
    """Flights of one scenario that came to the same end before they were completed."""

    purpose: str
    scenario: str
    how: str
    flights: int
    among: int
    times: list[float]  # s, when they ended


def failures(flown: Mapping[str, Sequence[tuple[Job, FlightResult]]]) -> list[Failure]:
    """Return the flights that were not completed, by what they were flown for and how they ended.

    Parameters
    ----------
    flown : mapping of str to (Job, FlightResult) pairs
        All flights, by what they were flown for.
    """
    found = []
    for purpose, flights in flown.items():
        ended: dict[tuple[str, str], list[FlightResult]] = {}
        for job, one in flights:
            if not one.completed:
                how = one.failure or one.outcome
                ended.setdefault((job.scenario.name, how), []).append(one)
        for (scenario, how), some in ended.items():
            among = sum(job.scenario.name == scenario for job, _ in flights)
            times = [one.metrics.duration_s for one in some if one.metrics is not None]
            found.append(Failure(purpose, scenario, how, len(some), among, times))
    return found


def _tables_of_run(results: Results) -> dict[str, Any]:
    """Return what every report shows of a run: trajectory, plant, sources, metrics."""
    runs = results.flights.runs
    vehicle = runs[A].vehicle
    # The limit of the speed has a source, but its source says that it is calibrated.
    chosen = [name for name, source in vehicle.sources.items() if source.assumed] + ["speed_max"]
    rest = [name for name in vehicle.sources if name not in chosen]
    assumed = "Assumed: neither published nor measured; or calibrated."
    return {
        "trajectory": trajectory_table(runs[A]),
        "plant": plant_table(runs[A]),
        "assumed": source_table(vehicle, assumed, chosen),
        "sources": source_table(vehicle, "Published or measured, or derived from what is.", rest),
        "metrics": metrics_table(
            "Errors, energies, tilts, limits and residuals over the whole flights.",
            {FLIGHT_LABELS[name]: runs[name].metrics for name in (A, B)},
        ),
    }


def command(plan: Plan) -> str:
    """Return the command that makes the page again."""
    usual = Plan.quickly() if plan.quick else Plan.whole()
    parts = ["omnimorph reproduce --out reproduction"]
    parts += ["--quick"] if plan.quick else []
    parts += [f"--seeds {len(plan.seeds)}"] if len(plan.seeds) != len(usual.seeds) else []
    parts += [f"--seed {plan.seeds[0]}"] if plan.seeds[0] else []
    return " ".join(parts)
