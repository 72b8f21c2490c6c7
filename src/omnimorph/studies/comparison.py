"""Platforms side by side: what they can hold, what hovering costs, how they fly the same flight."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from omnimorph.analysis import tilt_of_largest_radius
from omnimorph.analysis.platform import Platform, platform
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import OmnimorphError, TooLargeError
from omnimorph.report.analysis_data import platform_data
from omnimorph.report.comparison_figures import Column, numbers_of_platforms, to_one_scale
from omnimorph.report.page import Picture, render_page
from omnimorph.report.style import save_svg
from omnimorph.report.tables import Table, number
from omnimorph.results.atomic import write_text
from omnimorph.results.metrics import Metrics
from omnimorph.simulation.fly import fly
from omnimorph.simulation.scenario_files import load_scenario
from omnimorph.studies.own_folder import own_folder, write_results

COMPARISON_SCHEMA = "omnimorph comparison"
"""What ``results.json`` says it is."""
SCENARIO = "tour"
"""The common flight: a scenario that proposes each vehicle its own controller."""
PAGE = "comparison.html"

Progress = Callable[[float, float, str], None]


@dataclass(frozen=True, kw_only=True, eq=False)
class Compared:
    """One vehicle: its numbers, and what came of the flight.

    Attributes
    ----------
    vehicle : Vehicle
    platform : Platform
    flown : Metrics or None
        Of the common flight; None if it could not be flown.
    refusal : str
        Why it could not, in a sentence.
    """

    vehicle: Vehicle
    platform: Platform
    flown: Metrics | None
    refusal: str = ""

    @property
    def outcome(self) -> str:
        """How the flight ended, in a word or a sentence."""
        return self.refusal if self.flown is None else self.flown.outcome.replace("_", " ")


def compare(
    vehicles: Sequence[Vehicle], *, seed: int = 0, progress: Progress | None = None
) -> list[Compared]:
    """Compare vehicles by their numbers and by the same flight.

    Parameters
    ----------
    vehicles : sequence of Vehicle
        Any; one that cannot be flown says why.
    seed : int
        Of the noise.
    progress : callable, optional
        Called with what is done, what there is to do, and what comes next.
    """
    rows = []
    for k, vehicle in enumerate(vehicles):
        if progress is not None:
            progress(k, len(vehicles), vehicle.name)
        flown, refusal = None, ""
        try:
            flown = fly(load_scenario(SCENARIO).for_vehicle(vehicle), seed=seed).metrics
        except TooLargeError:  # that is not the vehicle's
            raise
        except OmnimorphError as refused:
            refusal = str(refused)
        rows.append(
            Compared(vehicle=vehicle, platform=platform(vehicle), flown=flown, refusal=refusal)
        )
    return rows


def comparison_data(rows: Sequence[Compared]) -> dict[str, Any]:
    """Return what ``--json`` and ``results.json`` hold; the unit stands at the end of a key."""
    return {
        "schema": COMPARISON_SCHEMA,
        "schema_version": 1,
        "scenario": SCENARIO,
        "vehicles": [_as_dict(row) for row in rows],
    }


def _as_dict(row: Compared) -> dict[str, Any]:
    found = row.platform
    return {
        "vehicle": row.vehicle.name,
        "title": row.vehicle.title,
        "rotors": found.n_rotors,
        "servos": found.n_servos,
        "mass_kg": found.mass,
        **platform_data(found),
        "outcome": row.outcome,
        "flight": None if row.flown is None else row.flown.as_dict(),
    }


# --- the page -------------------------------------------------------------------------------------


def write_comparison(rows: Sequence[Compared], out: Path, command: str, version: str) -> Path:
    """Write ``comparison.html``, its figures (SVG) and ``results.json`` into a folder of its own.

    Parameters
    ----------
    rows : sequence of Compared
        At least one.
    out : Path
        New, empty, or written this way before.
    command, version : str
        What made it, for the page.

    Raises
    ------
    InputError
        If the folder is somebody else's, or cannot be written to.
    """
    with own_folder(out, COMPARISON_SCHEMA) as folder:
        figures = folder / "figures"
        figures.mkdir()
        scale = to_one_scale([row.vehicle for row in rows], [_shown_tilt(row) for row in rows])
        pictures = {
            "scale": Picture(save_svg(scale, figures, "scale"), "The platforms to one scale"),
            "numbers": Picture(
                save_svg(_draw_numbers(rows), figures, "numbers"), "Their numbers side by side"
            ),
        }
        content = {
            "title": "Platforms side by side",
            "count": len(rows),
            "pictures": pictures,
            "platforms": platform_table(rows),
            "flights": flight_table(rows),
            "assumed": _assumed_table(rows),
            "scenario": SCENARIO,
            "duration": load_scenario(SCENARIO).reference.duration,
            "command": command,
            "version": version,
        }
        write_text(folder / PAGE, render_page("comparison.html.j2", **content))
        write_results(folder, comparison_data(rows))
    return out / PAGE


def platform_table(rows: Sequence[Compared]) -> Table:
    """Return the numbers of each platform."""
    cells = [
        [
            row.vehicle.name,
            str(row.platform.n_rotors),
            str(row.platform.n_servos),
            number(row.platform.mass, 3),
            number(row.platform.radius_over_weight, 3),
            number(row.platform.lateral_over_weight, 3),
            number(row.platform.hover_power_per_kg, 3),
            str(row.platform.vehicle_class),
        ]
        for row in rows
    ]
    head = ["", "rotors", "servos", "kg", "radius", "sideways force", "hover power (W/kg)", "class"]
    caption = "Size and class of the platforms; radius and sideways force over the weight."
    return Table(caption, head, cells, frozenset(range(1, 7)))


def flight_table(rows: Sequence[Compared]) -> Table:
    """Return how each flew."""
    cells = []
    for row in rows:
        flown = row.flown
        shown = ["—"] * 4
        if flown is not None:
            shown = [
                number(1e3 * flown.position_error_mean_m, 3),
                number(1e3 * flown.position_error_max_m, 3),
                number(np.degrees(flown.attitude_error_mean_rad), 3),
                number(flown.drag_energy_J / row.vehicle.mass, 4),
            ]
        cells.append([row.vehicle.name, row.outcome, *shown])
    head = ["", "outcome", "position error, mean (mm)", "position error, largest (mm)"]
    head += ["attitude error, mean (°)", "rotor drag energy (J/kg)"]
    return Table(
        "Outcome, errors and energy of the same flight, platform by platform.",
        head,
        cells,
        frozenset({2, 3, 4, 5}),
    )


def _assumed_table(rows: Sequence[Compared]) -> Table:
    cells = [
        [row.vehicle.name, field.replace("_", " "), source.text]
        for row in rows
        for field, source in row.vehicle.sources.items()
        if source.assumed
    ]
    return Table(
        "Every assumed number, vehicle by vehicle.",
        ["vehicle", "number", "what it rests on"],
        cells,
    )


def _shown_tilt(row: Compared) -> float:
    """Return the tilt of the drawing: of the largest radius for one servo, upright otherwise."""
    return tilt_of_largest_radius(row.vehicle) if row.vehicle.n_servos == 1 else 0.0


def _draw_numbers(rows: Sequence[Compared]) -> Any:
    errors = [np.nan if row.flown is None else row.flown.position_error_mean_m for row in rows]
    columns = [
        Column("radius /\nweight (–)", [row.platform.radius_over_weight for row in rows], 1.0),
        Column("sideways force /\nweight (–)", [row.platform.lateral_over_weight for row in rows]),
        Column("hover power\n(W/kg)", [row.platform.hover_power_per_kg for row in rows]),
        Column("position error,\nmean (mm)", [1e3 * error for error in errors]),
    ]
    return numbers_of_platforms([row.vehicle.name for row in rows], columns)
