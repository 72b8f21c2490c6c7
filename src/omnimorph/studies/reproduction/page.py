"""The page: from what was found to ``report.html``."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from omnimorph.report import figures
from omnimorph.report.page import Picture, render_page
from omnimorph.report.tables import (
    Table,
    metrics_table,
    number,
    plant_table,
    source_table,
    trajectory_table,
)
from omnimorph.results.atomic import write_text
from omnimorph.simulation.scenario_files import load_scenario
from omnimorph.studies.flight_log import Flown
from omnimorph.studies.many_flights import Job
from omnimorph.studies.reproduction import page_tables as tables
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.ablation import Lag
from omnimorph.studies.reproduction.findings import Findings
from omnimorph.studies.reproduction.flights import A, B, PaperFlights
from omnimorph.studies.reproduction.hypothesis_tables import hypothesis_table, objection_table
from omnimorph.studies.reproduction.key_numbers import key_table
from omnimorph.studies.reproduction.lost_thrust import KEPT_WITHIN_DEG, KEPT_WITHIN_M
from omnimorph.studies.reproduction.plan import Plan
from omnimorph.studies.reproduction.printed_matrix import ROWS
from omnimorph.studies.reproduction.sentences import key_points, reasons
from omnimorph.studies.reproduction.verdicts import RULES, Judged, Verdict
from omnimorph.studies.reproduction.words import FLIGHT_WORDS
from omnimorph.units import from_SI

__all__ = ["command", "write_page"]

_TITLE = "OmniMorph: the paper, line by line"


def write_page(
    path: Path,
    findings: Findings,
    judged: Mapping[str, Sequence[Judged]],
    pictures: Mapping[str, Picture],
    *,
    plan: Plan,
    flown: Mapping[str, Sequence[tuple[Job, Flown]]],
    run_files: Sequence[str],
) -> None:
    """Write the report: one HTML file with everything in it."""
    flights = findings.flights
    run = flights.runs[A]
    rows = [row for part in judged.values() for row in part]
    content = {
        "title": _TITLE,
        "version": run.provenance.version,
        "paper": paper.reference(),
        "vehicle": run.vehicle,
        "quick": plan.quick,
        "seeds": plan.seeds,
        "n_flights": sum(len(part) for part in flown.values()),
        "points": key_points(findings, rows),
        "pictures": pictures,
        "judged": judged,
        "verdicts": list(Verdict),
        "verdict_counts": Counter(row.verdict.value for row in rows),
        "tables": _tables(findings, rows, flown),
        "design": {"matrix": _matrix(findings)},
        "band_seconds": number(run.metrics.duration_s / figures.BANDS, 2),
        "speed_limit": number(from_SI(float(run.vehicle.speed_max.max()), "Hz")),
        "reasons": reasons(findings.ablation, findings.hypotheses),
        "rules": RULES,
        "lag": _lag(findings.ablation.lag),
        "artefact": _artefact(flights),
        "lost_beyond": number(load_scenario(A).lost_beyond),
        "kept_m": number(KEPT_WITHIN_M),
        "kept_deg": number(KEPT_WITHIN_DEG),
        "degraded_words": _degraded_words(findings),
        "command": command(plan),
        "run_files": run_files,
    }
    write_text(path, render_page("reproduction/page.html.j2", **content))


def _tables(
    findings: Findings,
    rows: Sequence[Judged],
    flown: Mapping[str, Sequence[tuple[Job, Flown]]],
) -> dict[str, Table]:
    flights, design, degraded = findings.flights, findings.design, findings.degraded
    run = flights.runs[A]
    vehicle = run.vehicle
    # The limit of the speed has a source, but its source says that it is calibrated.
    chosen = [name for name, source in vehicle.sources.items() if source.assumed] + ["speed_max"]
    stated = [name for name in vehicle.sources if name not in chosen]
    return {
        "key": key_table(findings),
        "claims": tables.claims_table(rows),
        "actuation": tables.actuation_table(design),
        "examples": tables.example_table(design),
        "energy": tables.energy_table(flights),
        "errors": tables.error_table(flights),
        "hypotheses": hypothesis_table(findings.hypotheses),
        "objections": objection_table(findings.hypotheses),
        "ablation": tables.ablation_table(findings.ablation),
        "lag": tables.lag_table(findings.ablation.lag, flights),
        "variants": tables.variant_table(flights),
        "wakes": tables.wake_table(flights),
        "losses": tables.losses_table(degraded),
        "frontier": tables.frontier_table(degraded),
        "dead": tables.dead_rotor_table(degraded),
        "gaps": tables.gap_table(findings.tilt_choice),
        "tilt_choice": tables.tilt_choice_table(findings.tilt_choice),
        "trajectory": trajectory_table(run),
        "plant": plant_table(run),
        "assumed": source_table(
            vehicle, "Assumed: neither published nor measured; or calibrated.", chosen
        ),
        "sources": source_table(vehicle, "Published or measured, or derived from what is.", stated),
        "metrics": metrics_table(
            "Errors, energies, tilts, limits and residuals over the whole flights.",
            {FLIGHT_WORDS[name]: flights.runs[name].metrics for name in (A, B)},
        ),
        "failed": tables.failed_table(flown),
        "provenance": _provenance_table(flights),
    }


def _matrix(findings: Findings) -> dict[str, Any]:
    matrix = findings.design.matrix
    return {
        "rotors": matrix.rotors,
        "misprints": matrix.misprints,
        "named_rows": list(zip(ROWS, matrix.entries, strict=True)),
    }


def _lag(lag: Lag) -> dict[str, str]:
    reported = [paper.claims()[f"attitude_error_{key}"].value or 0.0 for key in ("a", "b", "w3")]
    return {
        "attitude_time": number(lag.attitude_time),
        "position_time": number(lag.position_time),
        "turned": number(lag.turned, 3),
        "path_length": number(lag.path_length, 3),
        "duration": number(lag.duration),
        "shortest": number(lag.duration_for(max(reported)), 3),
        "longest": number(lag.duration_for(min(reported)), 3),
    }


def _artefact(flights: PaperFlights) -> dict[str, Any]:
    reported = paper.claims()["drag_energy_a"].value
    perfect = flights.perfect[A].metrics
    assert reported is not None
    assert perfect is not None
    noise = max(variant.noise for variant in flights.variants)
    return {
        "perfect": number(perfect.drag_energy_paper),
        "paper": number(reported, 5),
        "near": abs(perfect.drag_energy_paper / reported - 1.0) < 0.01,
        "noise": f"{noise:.0e}".replace("e-0", "e−"),
    }


def _degraded_words(findings: Findings) -> str:
    parts = []
    for key in findings.degraded_runs:
        about = paper.claims()[key].about
        parts.append(f"{FLIGHT_WORDS[about['scenario']]} with {about['loss_percent']:g} % less")
    return ", ".join(parts)


def _provenance_table(flights: PaperFlights) -> Table:
    rows = [["omnimorph", flights.runs[A].provenance.version]]
    for name in (A, B):
        run = flights.runs[name]
        origin = run.provenance
        where = f"scenario {name}, plant {origin.plant_name}, seed {origin.seed}"
        rows.append([FLIGHT_WORDS[name], where])
        rows.append(
            [f"{FLIGHT_WORDS[name]}, by itself", f"omnimorph fly {name} --seed {origin.seed}"]
        )
        rows.append([f"{FLIGHT_WORDS[name]}, content hash", run.content_hash])
        rows.append([f"{FLIGHT_WORDS[name]}, scenario hash", _sha256(origin.scenario_text)])
    rows.append(["vehicle hash", _sha256(flights.runs[A].provenance.vehicle_text)])
    return Table("Scenario, plant, seed and hashes of the flights that are kept.", ["", ""], rows)


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def command(plan: Plan) -> str:
    """Return the command that makes the page again."""
    usual = Plan.quickly() if plan.quick else Plan.whole()
    parts = ["omnimorph reproduce --out reproduction"]
    parts += ["--quick"] if plan.quick else []
    parts += [f"--seeds {len(plan.seeds)}"] if len(plan.seeds) != len(usual.seeds) else []
    parts += [f"--seed {plan.seeds[0]}"] if plan.seeds[0] else []
    return " ".join(parts)
