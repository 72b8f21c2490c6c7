"""The page of a fit: ``fit.html`` with its numbers and figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from omnimorph.identification.coefficients import CoefficientFit, Estimate
from omnimorph.identification.rotor_fit import RotorFit
from omnimorph.report import fit_figures
from omnimorph.report.fit_data import vehicle_lines
from omnimorph.report.page import Picture, render_page
from omnimorph.report.style import save_svg
from omnimorph.report.tables import Table, number
from omnimorph.results.atomic import write_text
from omnimorph.units import from_SI
from omnimorph.version import __version__

PAGE = "fit.html"
"""Name of the file."""


def write_fit_page(fit: RotorFit, folder: Path) -> Path:
    """Write ``fit.html`` and ``figures/`` (SVG) into an existing folder; return the page.

    Raises
    ------
    RunFileError
        If something cannot be written.
    """
    figures = folder / "figures"
    figures.mkdir(exist_ok=True)
    drawings = {
        "coefficients": ("Force and torque over the squared speed", fit_figures.coefficients),
        "residuals": ("What the fit leaves, over the speed", fit_figures.residuals),
    }
    if fit.steps:
        drawings["steps"] = ("How the speed follows steps of the command", fit_figures.steps)
    pictures = {
        name: Picture(save_svg(draw(fit), figures, name), title)
        for name, (title, draw) in drawings.items()
    }
    content: dict[str, Any] = {
        "title": f"{Path(fit.bench.source).name}: the numbers of a rotor",
        "rows": len(fit.bench.lines),
        "numbers": _table(fit),
        "lines": vehicle_lines(fit),
        "warnings": fit.warnings,
        "pictures": pictures,
        "outliers": bool(fit.thrust.outlier.any() or fit.drag.outlier.any()),
        "version": __version__,
    }
    page = folder / PAGE
    write_text(page, render_page("fit.html.j2", **content))
    return page


def _table(fit: RotorFit) -> Table:
    rows = [
        *_coefficient_rows("thrust coefficient", "N_per_Hz2", "N/Hz²", fit.thrust),
        *_coefficient_rows("drag coefficient", "Nm_per_Hz2", "N m/Hz²", fit.drag),
        ["torque over force", number(1e3 * fit.drag_to_thrust), "", "mm"],
        ["lowest speed seen", number(from_SI(fit.speed_min, "Hz")), "", "Hz"],
        ["highest speed seen", number(from_SI(fit.speed_max, "Hz")), "", "Hz"],
        _row("time constant up", "ms", "ms", fit.time_constant_up),
        _row("time constant down", "ms", "ms", fit.time_constant_down),
        ["noise of the force, 1σ", number(fit.thrust.noise, 3), "", "N"],
        ["noise of the torque, 1σ", number(fit.drag.noise, 3), "", "N m"],
    ]
    caption = "Every number, with the interval that holds the true one with 95 % confidence."
    return Table(caption, ["", "value", "95 % interval", "unit"], rows, frozenset({1, 2}))


def _coefficient_rows(
    name: str, unit: str, description: str, fit: CoefficientFit
) -> list[list[str]]:
    if not fit.separate:
        return [_row(name, unit, description, fit.both)]
    ways = (("forward", fit.forward), ("reverse", fit.reverse))
    return [_row(f"{name}, {way}", unit, description, found) for way, found in ways]


def _row(name: str, unit: str, description: str, estimate: Estimate | None) -> list[str]:
    if estimate is None:
        return [name, number(None), "", description]
    value, low, high = (number(from_SI(one, unit), 5) for one in estimate)
    return [name, value, f"{low} to {high}", description]
