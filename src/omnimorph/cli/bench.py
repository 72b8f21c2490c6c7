"""Measure how fast omnimorph is on this machine, beside the numbers we aim at."""

from __future__ import annotations

import argparse

from omnimorph.cli import console
from omnimorph.cli.arguments import positive_number

SUMMARY = "measure how fast it is on this machine"
NEEDS = ("omnimorph.bench",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument(
        "--rounds",
        type=positive_number("--rounds"),
        default=7,
        metavar="N",
        help="measure everything N times (default: 7)",
    )

    parser.add_argument(
        "--peers",
        action="store_true",
        help="in a checkout of the repository: compare with the solvers and simulators installed",
    )


def answer(options: argparse.Namespace) -> console.Answer:
    """Measure everything and say what came out."""
    with console.Progress("measuring") as progress:
        if options.peers:
            from omnimorph.bench.checkout import import_peers

            report = import_peers().measure_peers(progress, rounds=options.rounds)
        else:
            from omnimorph.bench import measure

            report = measure(progress, rounds=options.rounds)
    numbers = console.table(report.as_rows(), header=report.COLUMNS, align="rrrll")
    origin = console.table([[f"{name}:", text] for name, text in report.provenance.items()])
    notes = "".join(f"{note}\n" for note in report.notes)
    more = notes or "`omnimorph bench --peers` compares with others on this machine.\n"
    return console.Answer(text=f"{numbers}\n\n{more}\n{origin}", data=report.as_dict())
