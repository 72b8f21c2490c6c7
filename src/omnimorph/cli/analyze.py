"""Analyse a vehicle: actuation, force and moment sets, hover and its power, morphing."""

from __future__ import annotations

import argparse
import math
import textwrap
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from omnimorph.cli import console
from omnimorph.cli.arguments import add_out, add_vehicle, angles_in_degrees
from omnimorph.errors import InputError

if TYPE_CHECKING:
    from omnimorph import Vehicle
    from omnimorph.analysis.overview import AtTilt, VehicleAnalysis
    from omnimorph.protocols import FloatArray

_PAGE = "analysis.html"
SUMMARY = "analyse a vehicle: actuation, force and moment sets, hover power, morphing"
NEEDS = ("omnimorph.analysis", "omnimorph.design.schema", "scipy.optimize", "scipy.spatial")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    add_vehicle(parser)
    parser.add_argument(
        "--tilt",
        type=angles_in_degrees,
        metavar="DEG",
        help="show the sets at this tilt; with commas, one angle for each servo "
        "(default: where the radius at zero moment is largest)",
    )
    parser.add_argument(
        "--beyond-limits", action="store_true", help="allow a tilt that the servos cannot reach"
    )
    add_out(parser, "write analysis.html, its figures and results.json there")


def answer(options: argparse.Namespace) -> console.Answer:
    """Analyse, write the page if one is wanted, and say what came out."""
    import omnimorph as om
    from omnimorph.report.analysis_data import analysis_data
    from omnimorph.results.folder import replaced_text

    vehicle = om.load_vehicle(options.vehicle)
    _check_count(options.tilt, vehicle)
    with console.Progress(f"analysing {vehicle.name}:") as progress:
        ask = partial(
            om.analysis.analyze,
            vehicle,
            options.tilt,
            beyond_limits=options.beyond_limits,
            progress=progress,
        )
        replaced = ""
        if options.out is None:
            analysis, where = ask(), "`--out DIR` writes the page with the figures."
        else:
            replaced = replaced_text(options.out / "results.json")
            analysis, where = _written(ask, options.out), f"The page: {options.out / _PAGE}"
    text, data = f"{_as_text(analysis)}\n\n{where}", analysis_data(analysis)
    return console.Answer(text=text, data=data, complaint=replaced)


def _written(ask: Callable[[], VehicleAnalysis], out: Path) -> VehicleAnalysis:
    """Analyse and write everything into a folder that was found fit for it before."""
    from omnimorph.report.analysis_data import ANALYSIS_SCHEMA, analysis_data
    from omnimorph.report.analysis_page import write_analysis_page
    from omnimorph.studies.own_folder import own_folder, write_results

    with own_folder(out, ANALYSIS_SCHEMA) as part:
        analysis = ask()
        write_analysis_page(analysis, part)
        write_results(part, analysis_data(analysis))
    return analysis


def _check_count(tilt: list[float] | float | None, vehicle: Vehicle) -> None:
    """Refuse a number of angles that does not fit the number of servos."""
    if tilt is None:
        return
    angles, servos = tilt if isinstance(tilt, list) else [tilt], vehicle.n_servos
    if servos == 0 or len(angles) not in (1, servos):
        allowed = f"one angle, or one for each of its {servos} servos"
        if servos < 2:
            allowed = "one angle" if servos else "left out, as the vehicle has no servos"
        shown = [round(math.degrees(angle), 9) for angle in angles]
        raise InputError.at(f"vehicle {vehicle.name}", "--tilt", shown, allowed)


def _as_text(analysis: VehicleAnalysis) -> str:
    vehicle = analysis.vehicle
    low, high = (_deg(limit) for limit in analysis.limits)
    servos = f"tilt {low}° to {high}°" if vehicle.n_servos else "no servos"
    parts = [
        f"{vehicle.name}: {vehicle.title}".rstrip(": "),
        f"{console.counted(vehicle.n_rotors, 'rotor')}, {servos}; {vehicle.mass:g} kg, "
        f"weight {analysis.weight:.4g} N",
        "",
        *_class_lines(analysis),
        "",
        _table_by_tilt(analysis),
        "",
        "Radius: the largest force in every direction, N; with moments free (papers often mean "
        "this), and at zero moment,\nwhich hovering needs. Lift: straight up, at zero moment. "
        "Power: rotor drag power, hovering level; “paper”: speeds in Hz.",
        *([_DEAD_BAND] if vehicle.dead_band.any() else []),
        "",
        *_hovering_lines(analysis),
        *_singular_lines(analysis),
        *_wake_lines(analysis),
        *_trade_lines(analysis),
    ]
    return "\n".join(parts)


def _class_lines(analysis: VehicleAnalysis) -> list[str]:
    """Return what the vehicle is over all its tilts; how it is judged below, if otherwise."""
    from omnimorph.report.analysis_text import judged_text, over_all_tilts_text

    over_all = f"Class: {over_all_tilts_text(analysis.platform)}."
    return textwrap.wrap(judged_text(analysis.platform) or over_all, _WIDTH)


_WIDTH = 110
_DEAD_BAND = "The dead band of the rotors is ignored: thrusts it forbids count as possible."


def _table_by_tilt(analysis: VehicleAnalysis) -> str:
    header = [
        *("tilt °", "rank A", "rank F", "condition", "r free N", "r zero N", "lift N"),
        *("power W", "paper", "class at this tilt"),
    ]
    rows = [_row(one) for one in analysis.at]
    if not analysis.vehicle.n_servos:
        header, rows = [*header[1:-1], "class"], [row[1:] for row in rows]
    return console.table(rows, header=header, align="r" * (len(header) - 1))


def _row(one: AtTilt) -> list[str]:
    actuation, power = one.actuation, one.hover
    is_common = len(set(one.tilt.tolist())) == 1  # one angle stands for all servos
    words = str(actuation.vehicle_class) + (f" ({one.why})" if one.why else "")
    return [
        ", ".join(_deg(angle) for angle in (one.tilt[:1] if is_common else one.tilt)),
        str(actuation.rank_thrust),
        str(actuation.rank_full),
        console.number(actuation.condition_number, 4),
        console.number(one.force_free.inscribed_radius, 4),
        console.number(one.force_zero.inscribed_radius, 4),
        console.number(one.force_zero.reach([0.0, 0.0, 1.0]), 4),
        console.number(power.power),
        console.number(power.power_paper),
        words,
    ]


def _hovering_lines(analysis: VehicleAnalysis) -> list[str]:
    found = analysis.omnidirectional
    if not analysis.vehicle.n_servos:
        every, level = len(found.zero_moment) > 0, len(found.level) > 0
        return [
            f"It can hover level: {_yes(level)}; in every attitude: {_yes(every)}; "
            f"share of all attitudes: {analysis.asked.attitudes.words}."
        ]
    rows = [
        ("every attitude, zero moment", found.zero_moment, found.zero_moment_beyond),
        ("every attitude, free moments", found.free_moment, found.free_moment_beyond),
        ("level", found.level, found.level_beyond),
    ]
    table = [[words, _intervals(within), _intervals(beyond)] for words, within, beyond in rows]
    together = ", all servos at one tilt" if analysis.platform.has_free_tilts else ""
    header = [
        f"it can hover{together}",
        "within its limits",
        "if the servos turned through a full rotation",
    ]
    return [console.table(table, header=header)]


def _singular_lines(analysis: VehicleAnalysis) -> list[str]:
    if not analysis.singular:
        return []
    tilts = ", ".join(f"{_deg(one.tilt)}° (rank {one.rank})" for one in analysis.singular)
    together = ", all servos together" if analysis.platform.has_free_tilts else ""
    return ["", f"Singular tilts, over a full rotation{together}: {tilts}."]


def _wake_lines(analysis: VehicleAnalysis) -> list[str]:
    wakes = analysis.wakes
    if wakes is None:
        return []
    ends = (0,) if len(wakes.tilt) == 1 else (0, -1)
    found = ", ".join(
        f"{console.number(wakes.power[k], 4)} W instead of "
        f"{console.number(wakes.power_still[k], 4)} W at {_deg(wakes.tilt[k])}°"
        for k in ends
    )
    pairs = console.counted(len(wakes.pairs), "pair")
    return ["", f"Interference: {pairs} of rotors in line; hovering level takes {found}."]


def _trade_lines(analysis: VehicleAnalysis) -> list[str]:
    trade = analysis.trade
    if trade is None or trade.own is None:
        return []
    tilts = [("in still air", trade.break_even)]
    if analysis.wakes is not None:
        tilts.append(("with interference", trade.break_even_in_wakes))
    found = ", ".join(
        f"{where} beyond {_deg(tilt)}°" if tilt is not None else f"{where} never"
        for where, tilt in tilts
    )
    return [
        "",
        f"Its tilt mechanism is {trade.own:.2%} of the rest; against a vehicle with a fixed tilt "
        f"it pays {found}.",
    ]


def _intervals(intervals: FloatArray) -> str:
    return ", ".join(f"{_deg(low)}° to {_deg(high)}°" for low, high in intervals) or "nowhere"


def _deg(angle: float) -> str:
    """Return an angle in degrees: a whole number if it is one, else two decimal places."""
    degrees = math.degrees(angle)
    whole = round(degrees)
    return str(whole) if abs(degrees - whole) < 1e-7 else f"{degrees:.2f}"


def _yes(truth: bool) -> str:
    return "yes" if truth else "no"
