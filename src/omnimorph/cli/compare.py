"""Compare vehicles: a table on the screen, a page if one is wanted."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from omnimorph.cli import console
from omnimorph.cli.arguments import add_out
from omnimorph.version import __version__

if TYPE_CHECKING:
    from omnimorph.studies.comparison import Compared

SUMMARY = "compare vehicles: what they can hold, what hovering costs, how they fly"
NEEDS = ("omnimorph.studies.comparison", "omnimorph.simulation.scenario_schema", "scipy.optimize")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument(
        "vehicles",
        nargs="*",
        metavar="VEHICLE",
        help="names that `omnimorph vehicles` lists, or TOML files (default: the catalogue)",
    )
    add_out(parser, "write comparison.html and results.json there")


def answer(options: argparse.Namespace) -> console.Answer:
    """Compare, write the page if one is wanted, and show the table."""
    import omnimorph as om
    from omnimorph.results.folder import replaced_text
    from omnimorph.studies.comparison import (
        COMPARISON_SCHEMA,
        SCENARIO,
        compare,
        comparison_data,
        write_comparison,
    )
    from omnimorph.studies.own_folder import check_own

    names = options.vehicles or om.list_vehicles()
    vehicles = [om.load_vehicle(name) for name in names]
    replaced = ""
    if options.out is not None:
        check_own(options.out, COMPARISON_SCHEMA)
        replaced = replaced_text(options.out / "results.json")
    with console.Progress("comparing") as progress:
        rows = compare(vehicles, progress=progress)
    where = "`--out DIR` writes the page with the figures."
    if options.out is not None:
        command = " ".join(["omnimorph compare", *options.vehicles])
        where = f"The page: {write_comparison(rows, options.out, command, __version__)}"
    header = ["vehicle", "rotors", "servos", "kg", "radius", "sideways", "W/kg", "mm", "class"]
    text = console.table([_row(row) for row in rows], header=header, align="lrrrrrrrl")
    notes = (
        "Radius and sideways force over the weight, each servo at its own tilt; power to hover "
        "level with all servos\nat one tilt, per kilogram; mm: mean position error in the "
        f"scenario {SCENARIO}, plant realistic, with proposed gains."
    )
    text = f"{text}\n\n{notes}\n{where}"
    return console.Answer(text=text, data=comparison_data(rows), complaint=replaced)


def _row(row: Compared) -> list[str]:
    found: Any = row.platform
    error = "—" if row.flown is None else console.number(1e3 * row.flown.position_error_mean_m, 3)
    completed = row.flown is not None and row.flown.outcome == "completed"
    return [
        row.vehicle.name,
        str(found.n_rotors),
        str(found.n_servos),
        console.number(found.mass, 3),
        console.number(found.radius_over_weight, 3),
        console.number(found.lateral_over_weight, 3),
        console.number(found.hover_power_per_kg, 3),
        error,
        str(found.vehicle_class) + ("" if completed else f"; {row.outcome}"),
    ]
