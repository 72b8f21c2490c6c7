"""The page of an analysis: ``analysis.html`` with its tables and figures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.analysis.overview import AtTilt, VehicleAnalysis
from omnimorph.analysis.polytope import Polytope
from omnimorph.report import analysis_figures, attitude_figures
from omnimorph.report.analysis_summary import description, key_points
from omnimorph.report.analysis_text import condition_text, count_text, rows_by_tilt, singular_text
from omnimorph.report.page import Picture, render_page
from omnimorph.report.style import save_svg
from omnimorph.report.tables import Table, degrees, number, source_table, tilt_text
from omnimorph.results.atomic import write_text
from omnimorph.units import from_SI
from omnimorph.version import __version__

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = "analysis.html"
"""Name of the file."""

_SHAPES = {3: "solid", 2: "plane", 1: "line", 0: "point", -1: "empty"}
# What of a vehicle an analysis rests on; lags and rates play no role.
_USED = (
    *("mass", "tilt_mechanism_mass", "inertia", "rotor_position", "rotor_axis", "hinge_axis"),
    *("rotor_servo", "rotor_spin", "thrust_coefficient", "drag_coefficient"),
    *("speed_min", "speed_max", "dead_band", "servo_angle_min", "servo_angle_max"),
)
_Drawing = Callable[[VehicleAnalysis], "Figure"]


def write_analysis_page(
    analysis: VehicleAnalysis, folder: Path, next_step: Callable[[str], None] | None = None
) -> Path:
    """Write ``analysis.html`` and ``figures/`` (SVG) into a folder.

    The page holds its figures and needs no other file.

    Parameters
    ----------
    analysis : VehicleAnalysis
        Of any vehicle.
    folder : Path
        An existing folder; what is there under these names is written over.
    next_step : callable, optional
        Called with a few words before each figure, and before the page.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    RunFileError
        If something cannot be written.
    """
    tell = next_step or (lambda words: None)
    figures = folder / "figures"
    figures.mkdir(exist_ok=True)
    pictures: dict[str, Picture] = {}
    for name, (title, draw) in _drawings(analysis).items():
        tell(f"drawing {name.replace('_', ' ')}")
        pictures[name] = Picture(save_svg(draw(analysis), figures, name), title)
    tell("writing the page")
    page = folder / PAGE
    write_text(page, render_page("analysis.html.j2", **_content(analysis, pictures)))
    return page


def _drawings(analysis: VehicleAnalysis) -> dict[str, tuple[str, _Drawing]]:
    """Return the figures that this vehicle has something to show in: name -> (title, function)."""
    varied, sweep = _varied(analysis), analysis.sweep
    shown: dict[str, tuple[str, _Drawing]] = {
        "force_sets": ("Sets of forces, seen from the side", analysis_figures.force_sets)
    }
    if len(sweep.tilt) > 1:
        title = "Inscribed radii of both sets of forces over the tilt, beside the weight"
        shown["radius_over_tilt"] = (title, analysis_figures.radius_over_tilt)
        if np.isfinite(sweep.level_power).any() or np.isfinite(sweep.condition_number).any():
            title = "Power of hovering level, and the condition number, over the tilt"
            shown["level_hover"] = (title, analysis_figures.level_hover)
    if _hovers_somewhere(analysis):
        title = "Least hover power, and the best tilt, over the attitude"
        shown["hover_map"] = (title, attitude_figures.hover_map)
    if analysis.asked.hover.feasible and analysis.asked.moment.dimension > 0:
        title = "The set of moments while hovering level"
        shown["moments"] = (title, attitude_figures.moments)
    if analysis.wakes is not None and varied:
        title = "What wakes cost in power and in radius over the tilt"
        shown["wakes"] = (title, analysis_figures.wakes)
    if analysis.trade is not None:
        title = "Mass of a tilt mechanism that just pays, over the tilt it is compared with"
        shown["mass_break_even"] = (title, analysis_figures.mass_break_even)
    return shown


def _varied(analysis: VehicleAnalysis) -> bool:
    return analysis.limits[1] > analysis.limits[0]


def _hovers_somewhere(analysis: VehicleAnalysis) -> bool:
    """Return whether the vehicle can hover in some attitude at a tilt that is shown."""
    at_asked = any(
        float(np.linalg.norm(corner)) >= analysis.weight
        for corner in analysis.asked.force_zero.vertices
    )
    elsewhere = len(analysis.omnidirectional.level) > 0 or analysis.hover_map.feasible.any()
    return at_asked or bool(elsewhere)


def _content(analysis: VehicleAnalysis, pictures: dict[str, Picture]) -> dict[str, Any]:
    vehicle, asked = analysis.vehicle, analysis.asked
    used = [name for name in vehicle.sources if name in _USED]
    assumed = [name for name in used if vehicle.sources[name].assumed]
    stated = [name for name in used if name not in assumed]
    return {
        "title": f"{vehicle.name}: actuation, force sets and hover power",
        "vehicle": vehicle,
        "description": description(analysis),
        "rotors": count_text(vehicle.n_rotors, "rotor"),
        "servos": "the servo" if vehicle.n_servos == 1 else "the servos",
        "points": key_points(analysis),
        "pictures": pictures,
        "varied": _varied(analysis),
        "asked": tilt_text(asked.tilt),
        "asked_flat": asked.force_zero.dimension < 3,
        "moment_radius": asked.moment.inscribed_radius,
        "by_tilt": _tilt_table(analysis),
        "conditions": _condition_table(analysis),
        "singular": singular_text(analysis),
        "limit": degrees(analysis.limits[1]),
        "beyond": bool(analysis.sweep.tilt[-1] > analysis.limits[1] + 1e-6),
        "with_wakes": analysis.wakes is not None,
        "trade": analysis.trade,
        "hovers": bool(len(analysis.omnidirectional.level)),
        "level_power": bool(np.isfinite(analysis.sweep.level_power).any()),
        "conditioned": bool(np.isfinite(analysis.sweep.condition_number).any()),
        "omnidirectional": bool(len(analysis.omnidirectional.zero_moment_beyond)),
        "dead_band": float(from_SI(vehicle.dead_band.max(), "Hz")),
        "assumed": source_table(vehicle, "Assumed: neither published nor measured.", assumed),
        "stated": source_table(vehicle, "Published or measured, or derived from what is.", stated),
        "command": _command(analysis),
        "version": __version__,
    }


def _tilt_table(analysis: VehicleAnalysis) -> Table:
    """Return the answers at the tilts that stand out, a column a tilt."""
    shown = rows_by_tilt(analysis)
    columns = [_tilt_column(analysis, one, why) for one, why in shown]
    labels = list(columns[0])
    rows = [[label, *(column[label] for column in columns)] for label in labels]
    if not analysis.vehicle.n_servos:
        return Table("Actuation, force sets and hover power.", ["", "value"], rows)
    head = ["tilt", *(tilt_text(one.tilt) for one, _ in shown)]
    caption = "Actuation, force sets and hover power at the tilts of interest"
    caption += "." if analysis.vehicle.n_servos == 1 else ", all servos together."
    return Table(caption, head, rows)


def _tilt_column(analysis: VehicleAnalysis, one: AtTilt, why: str) -> dict[str, str]:
    actuation, power = one.actuation, one.hover
    column: dict[str, str] = {}
    if analysis.vehicle.n_servos:
        column["why it is here (radius and attitudes at zero moment)"] = why
    column["rank of A: what thrusts change"] = str(actuation.rank_thrust)
    if analysis.vehicle.n_servos:
        column["rank of F: what thrusts and tilt change"] = str(actuation.rank_full)
    cannot = "cannot hover"
    return column | {
        "actuation": actuation.kind.value,
        "thrust": actuation.thrust_kind.value,
        "condition number of A": number(actuation.condition_number),
        "radius with free moments (N)": _radius(one.force_free),
        "radius at zero moment (N)": _radius(one.force_zero),
        "volume of the set at zero moment (N³)": _volume(one.force_zero),
        "largest lift straight up at zero moment (N)": number(one.force_zero.reach([0, 0, 1])),
        "share of all attitudes it can hover in": one.attitudes.words,
        "power to hover level (W)": number(power.power) if power.feasible else cannot,
        "the same in the OmniMorph paper's count": number(power.power_paper)
        if power.feasible
        else cannot,
    }


def _radius(one: Polytope) -> str:
    radius = one.inscribed_radius
    return number(radius) if one.dimension == 3 else f"0 ({_SHAPES[one.dimension]})"


def _volume(one: Polytope) -> str:
    return number(one.volume) if one.dimension == 3 else f"0 ({_SHAPES[one.dimension]})"


def _condition_table(analysis: VehicleAnalysis) -> Table:
    """Return, for tilts at which A lacks a direction, what thrusts let a servo add one."""
    several = analysis.vehicle.n_servos > 1
    rows = []
    for one, _ in rows_by_tilt(analysis):
        if one.actuation.rank_thrust == 6:
            continue
        named = zip(analysis.vehicle.servo_name, one.actuation.conditions, strict=True)
        sums = [(f"{name}: " if several else "") + condition_text(rows) for name, rows in named]
        rows.append([tilt_text(one.tilt), str(one.actuation.rank_thrust), "; ".join(sums)])
    head = ["tilt", "rank of A", f"moving {'a' if several else 'the'} servo adds a direction if"]
    caption = "Where thrusts alone cannot change all six directions: when the tilt helps."
    return Table(caption, head, rows if analysis.vehicle.n_servos else [])


def _command(analysis: VehicleAnalysis) -> str:
    """Return the command that makes the page again."""
    from omnimorph.design.files import list_vehicles

    name = analysis.vehicle.name
    words = ["omnimorph analyze", name if name in list_vehicles() else f"{name}.toml"]
    asked = analysis.asked
    if asked.why == "asked for":
        angles = [f"{value:.10g}" for value in np.degrees(asked.tilt).tolist()]
        value = angles[0] if len(set(angles)) == 1 else ",".join(angles)
        words.append(f"--tilt={value}" if value.startswith("-") else f"--tilt {value}")
        if not _within_limits(analysis):
            words.append("--beyond-limits")
    return " ".join([*words, "--out DIR"])


def _within_limits(analysis: VehicleAnalysis) -> bool:
    vehicle, tilt = analysis.vehicle, analysis.asked.tilt
    above = tilt >= vehicle.servo_angle_min - 1e-9
    return bool((above & (tilt <= vehicle.servo_angle_max + 1e-9)).all())
