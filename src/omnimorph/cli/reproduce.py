"""Reproduce the paper: every figure, table and claim, beside what comes out here."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnimorph.cli import console
from omnimorph.cli.arguments import folder, positive_number, seed_number

if TYPE_CHECKING:
    from omnimorph.studies.reproduction import Plan

SUMMARY = "reproduce the paper, claim by claim, and write the report"
NEEDS = ("omnimorph.studies.reproduction", "omnimorph.simulation.scenario_schema", "h5py")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument(
        "--out",
        type=folder,
        default=Path("reproduction"),
        metavar="DIR",
        help="write report.html, figures, results.json and runs there (default: ./reproduction)",
    )
    parser.add_argument(
        "--quick", action="store_true", help="ask the same questions with fewer seeds"
    )
    parser.add_argument(
        "--seeds",
        type=positive_number("--seeds"),
        metavar="N",
        help="fly each of the paper's flights N times (default: 20, quick 2)",
    )
    parser.add_argument(
        "--seed",
        type=seed_number,
        default=0,
        metavar="K",
        help="the first of the seeds, which the figures show (default: 0)",
    )


def answer(options: argparse.Namespace) -> console.Answer:
    """Fly, write the report, and say where it is and how each claim stands."""
    from omnimorph.results.folder import replaced_text
    from omnimorph.studies.reproduction import reproduce

    out: Path = options.out
    replaced = replaced_text(out / "results.json")
    with console.Progress("reproducing the paper:") as progress:
        report = reproduce(out, _plan(options), progress)
    results = json.loads(Path(out, "results.json").read_text(encoding="utf-8"))
    rows = [_row(one) for one in results["claims"]]
    header = ["claim", "paper", "here", "difference", "verdict", "found"]
    return console.Answer(
        text=f"{console.table(rows, header=header, align='lrrrl')}\n\nThe report: {report}",
        data={"report": str(report)} | results,
        complaint=replaced,
    )


def _plan(options: argparse.Namespace) -> Plan:
    """Return how many flights are asked for, from which seed on."""
    from omnimorph.studies.reproduction import Plan

    build = Plan.quickly if options.quick else Plan.whole
    return build(options.seed) if options.seeds is None else build(options.seed, options.seeds)


def _row(one: dict[str, Any]) -> list[str]:
    difference = one["difference"]
    return [
        one["key"],
        "" if one["paper"] is None else f"{console.number(one['paper'])} {one['unit']}".strip(),
        "" if one["here"] is None else console.number(one["here"], 4),
        "" if difference is None else f"{difference:+.1%}",
        one["verdict"],
        one["why"] if one["explained"] else one["found"],
    ]
