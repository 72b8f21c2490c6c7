"""Fit the numbers of a rotor to bench data: thrust and drag coefficient, limits, time constants.

The CSV file names its columns in the first line: time_s, force_N, torque_Nm, speed_Hz (or
speed_rad_per_s, speed_rpm) and, for the time constants, command_Hz.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnimorph.cli import console
from omnimorph.cli.arguments import add_out

if TYPE_CHECKING:
    from omnimorph.identification import RotorFit

SUMMARY = "fit the numbers of a rotor to bench data, each with its confidence interval"
NEEDS = ("omnimorph.identification", "scipy.optimize", "scipy.special")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument("bench", metavar="BENCH.csv", help="a run of one rotor on a thrust bench")
    parser.add_argument(
        "--like",
        metavar="VEHICLE",
        help="a vehicle whose first rotor is about as large: a wrong unit is then recognised",
    )
    add_out(parser, "write fit.html, its figures and results.json there")


def answer(options: argparse.Namespace) -> console.Answer:
    """Fit, write the page if one is wanted, and say what came out."""
    import omnimorph as om
    from omnimorph.report.fit_data import fit_data, vehicle_lines
    from omnimorph.results.folder import replaced_text

    expected: dict[str, Any] = {}
    if options.like is not None:
        like = om.load_vehicle(options.like)
        expected["expected_thrust_coefficient"] = float(like.thrust_coefficient[0])
        expected["expected_drag_coefficient"] = float(like.drag_coefficient[0])
    bench = om.identification.read_bench(options.bench)
    fit = om.identification.fit_rotor(bench, **expected)
    where = "`--out DIR` writes the page with the figures."
    replaced = ""
    if options.out is not None:
        replaced = replaced_text(options.out / "results.json")
        where = f"The page: {_written(fit, options.out)}"
    warnings = [f"# {sentence}" for sentence in fit.warnings]
    heading = f"# {len(bench.lines)} rows of {options.bench}; torque over force "
    heading += f"{console.number(1e3 * fit.drag_to_thrust, 4)} mm"
    parts = ["\n".join([heading, *warnings]), vehicle_lines(fit), f"# {where}"]
    return console.Answer(text="\n\n".join(parts), data=fit_data(fit), complaint=replaced)


def _written(fit: RotorFit, out: Path) -> Path:
    """Write everything into a folder that was found fit for it before; return the page."""
    from omnimorph.report.fit_data import FIT_SCHEMA, fit_data
    from omnimorph.report.fit_page import PAGE, write_fit_page
    from omnimorph.studies.own_folder import own_folder, write_results

    with own_folder(out, FIT_SCHEMA) as part:
        write_fit_page(fit, part)
        write_results(part, fit_data(fit))
    return out / PAGE
