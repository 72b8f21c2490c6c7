"""Fly what the paper flew and write the report that sets it beside what the paper reports."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from omnimorph.cli import console
from omnimorph.cli.arguments import folder, positive_number, seed_number

__all__ = ["SUMMARY", "add_arguments", "answer"]

SUMMARY = "fly the paper's cases and write the report"
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
        "--seeds",
        type=positive_number("--seeds"),
        default=5,
        metavar="N",
        help="fly each scenario N times (default: 5)",
    )
    parser.add_argument(
        "--seed",
        type=seed_number,
        default=0,
        metavar="K",
        help="the first of the seeds, which the figures show (default: 0)",
    )


def answer(options: argparse.Namespace) -> console.Answer:
    """Fly, write the report, and say where it is and how near it comes."""
    from omnimorph.studies.reproduction import reproduce

    out: Path = options.out
    try:
        with console.Progress("reproducing the paper:") as progress:
            report = reproduce(out, seeds=options.seeds, seed=options.seed, progress=progress)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"nothing was written to {out}.") from None
    results = json.loads(Path(out, "results.json").read_text(encoding="utf-8"))
    rows = [_row(one) for one in results["beside_the_paper"]]
    header = ["scenario", "metric", "paper", "here", "difference", "verdict"]
    return console.Answer(
        text=f"{console.table(rows, header=header, align='llrrr')}\n\nThe report: {report}",
        data={"report": str(report)} | results,
    )


def _row(one: dict[str, Any]) -> list[str]:
    return [
        one["scenario"],
        one["metric"],
        console.number(one["paper"]),
        console.number(one["here"]),
        f"{one['difference']:+.1%}",
        one["verdict"],
    ]
