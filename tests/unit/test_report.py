"""Reports: curves keep their spikes, figures carry units, pages need no other file."""

from __future__ import annotations

import itertools
import json
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.unit.figure_checks import cut_off, laid_out, overlaps

import omnimorph as om
from omnimorph.errors import InputError
from omnimorph.model.geometry import propeller_radius
from omnimorph.report import figures, style
from omnimorph.report.page import Picture, render_page
from omnimorph.report.style import Flight, LineStyle
from omnimorph.report.tables import (
    metrics_table,
    number,
    plant_table,
    source_table,
    trajectory_table,
)
from omnimorph.results import curves
from omnimorph.results.thinning import band, thin
from omnimorph.studies.own_folder import own_folder
from omnimorph.studies.reproduction.figures import summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOOK = LineStyle(style.VERMILLION)


@pytest.fixture(scope="module")
def hover() -> om.Run:
    return om.fly(om.load_scenario("hover"))


@pytest.fixture(scope="module")
def flight(hover: om.Run) -> Flight:
    return Flight("hovering", hover, LOOK)


# --- thinning -------------------------------------------------------------------------------------


@pytest.mark.parametrize("rows", [1, 2, 999, 1000, 45001])
@pytest.mark.parametrize("columns", [1, 7, 500])
def test_thinned_curve_keeps_extremes_and_ends(rows: int, columns: int) -> None:
    time = 1e-3 * np.arange(rows, dtype=np.float64)
    values = np.random.default_rng(rows).normal(size=rows)
    t, v = thin(time, values, columns)
    assert len(t) == len(v) <= max(2 * columns + 2, 1)
    assert (t[0], t[-1]) == (time[0], time[-1])
    assert (v.min(), v.max()) == (values.min(), values.max())
    assert np.all(np.diff(t) > 0)
    assert set(v) <= set(values)


def test_thinned_curve_keeps_a_spike_of_one_row_wherever_it_is() -> None:
    time = np.arange(5000.0)
    for at in (0, 1, 2499, 4998, 4999):
        values = np.zeros(5000)
        values[at] = -3.0
        t, v = thin(time, values, 60)
        assert t[v.argmin()] == at


def test_band_holds_the_curve() -> None:
    time = np.arange(1001.0)
    values = np.sin(time / 50.0)
    shown = band(time, values, 100)
    assert np.all((shown.low <= shown.mean) & (shown.mean <= shown.high))
    assert (shown.low.min(), shown.high.max()) == (values.min(), values.max())
    assert len(shown.time) <= 100


# --- curves ---------------------------------------------------------------------------------------


def test_curves_agree_with_metrics(hover: om.Run) -> None:
    metrics = hover.metrics
    attitude = curves.attitude_error(hover)
    assert curves.position_error_mm(hover).mean() == pytest.approx(
        1e3 * metrics.position_error_mean_m, rel=1e-12
    )
    assert np.radians(attitude.angle_deg).mean() == pytest.approx(
        metrics.attitude_error_mean_rad, rel=1e-12
    )
    assert attitude.sine.mean() == pytest.approx(metrics.attitude_error_paper, rel=1e-12)
    assert curves.drag_energy_J(hover)[-1] == pytest.approx(metrics.drag_energy_J, rel=1e-12)


def test_rotation_goes_on_beyond_half_a_turn() -> None:
    reference = om.load_scenario("paper-case-a").reference
    R = np.array([reference(t).R_WB for t in np.linspace(22.0, 40.0, 400)])
    angle = curves.rotation_about_x_deg(R)
    assert (angle[0], angle[-1]) == pytest.approx((0.0, 360.0))
    assert np.all(np.diff(angle) > -1e-9)


def test_phases_have_short_labels(hover: om.Run) -> None:
    assert curves.phases(hover) == [curves.Phase(0.0, 5.0, "rest")]
    text = json.dumps(om.load_scenario("paper-case-a").as_file())
    provenance = replace(hover.provenance, scenario_text=text)
    labels = [phase.label for phase in curves.phases(replace(hover, provenance=provenance))]
    turns = ["+30°", "+x", "−x", "−30°", "+360°", "+z", "rest"]
    assert labels == ["+z", "−z", "+y", "−y", *turns]


def test_phases_of_a_run_without_segments(hover: om.Run) -> None:
    provenance = replace(hover.provenance, scenario_text="{}")
    assert curves.phases(replace(hover, provenance=provenance)) == []


# --- figures --------------------------------------------------------------------------------------


def drawn(flight: Flight) -> dict[str, Figure]:
    """Draw every figure of one flight."""
    row = summary.EnergyRow("hovering", [1.0, 2.0], 1.5, 1.8, flight.line_style)
    return {
        "trajectory": figures.trajectory([flight]),
        "errors": figures.errors([flight], [("elsewhere", 11.0, 0.06, flight.line_style)]),
        "tilt": figures.tilt([flight]),
        "rotor_speeds": figures.rotor_speeds([flight]),
        "power_and_energy": figures.power_and_energy([flight], [flight]),
        "overview": summary.overview([flight]),
        "energies": summary.energies([row]),
        "tilt_by_plant": summary.tilt_by_plant([flight]),
    }


def test_every_axis_has_a_unit_and_no_letter_is_too_small(flight: Flight) -> None:
    for name, figure in drawn(flight).items():
        for panel in figure.axes:
            if not panel.axison:
                continue
            # panels above others share their time axis, panels to the right their speed axis
            place = panel.get_subplotspec()
            if place is None or place.is_last_row():
                assert re.search(r"\(.+\)", panel.get_xlabel()), name
            if (place is None or place.is_first_col()) and name != "energies":
                assert re.search(r"\(.+\)", panel.get_ylabel()), name
            texts = [*panel.get_xticklabels(), *panel.get_yticklabels(), *panel.texts, panel.title]
            assert min(float(text.get_fontsize()) for text in texts) >= 8.0, name
        laid_out(figure)
        assert overlaps(figure, least_gap=2.0) == [], name
        assert cut_off(figure) == [], name


def test_figures_do_not_depend_on_the_users_style(flight: Flight) -> None:
    import matplotlib

    plain = style.as_svg(figures.tilt([flight]))
    with matplotlib.rc_context({"font.size": 30.0, "axes.facecolor": "black"}):
        assert style.as_svg(figures.tilt([flight])) == plain


def test_figures_are_kept_as_svg_and_pdf(flight: Flight, tmp_path: Path) -> None:
    svg = style.save_figure(figures.errors([flight]), tmp_path, "errors")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["errors.pdf", "errors.svg"]
    root = ElementTree.fromstring((tmp_path / "errors.svg").read_text(encoding="utf-8"))
    assert root.tag.endswith("svg")
    assert float(root.attrib["width"].removesuffix("pt")) == 72 * style.WIDTH
    assert "scale(0.015625)" in svg, "the scale of a letter must not be rounded"
    assert len(svg) < 300_000
    assert (tmp_path / "errors.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.slow
@pytest.mark.parametrize("lost_after", [1, 700])
def test_a_lost_flight_can_be_drawn(hover: om.Run, lost_after: int) -> None:
    columns: dict[str, Any] = {
        name: value[:lost_after]
        for name, value in vars(hover).items()
        if isinstance(value, np.ndarray)
    }
    lost = replace(hover, **columns, outcome=om.Outcome.LOST)
    for figure in drawn(Flight("lost", lost, LOOK)).values():
        assert style.as_svg(figure).startswith("<svg")


def test_discs_of_the_drawing_do_not_touch() -> None:
    vehicle = om.load_vehicle("omnimorph")
    apart = min(
        float(np.linalg.norm(a - b)) for a, b in itertools.combinations(vehicle.rotor_position, 2)
    )
    assert 0.45 * apart < propeller_radius(vehicle) < 0.5 * apart


# --- tables ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1764.3219, "1764"),
        (-0.000473012, "−0.000473"),
        (12345.6, "12\N{NARROW NO-BREAK SPACE}346"),
        (0.0, "0"),
        (2.22e-16, "2.22e−16"),
        (float("nan"), "—"),
        (None, "—"),
    ],
)
def test_numbers_are_set_as_print_sets_them(value: float | None, text: str) -> None:
    assert number(value) == text


def test_tables_of_a_run(hover: om.Run) -> None:
    shown = metrics_table("", {"one": hover.metrics, "two": hover.metrics})
    assert {len(row) for row in shown.rows} == {len(shown.head)}
    assert ["time flown", "5", "5", "s"] in shown.rows
    assert trajectory_table(hover).rows == [["0 to 5", "rest"]]
    plant = {row[0]: row[1] for row in plant_table(hover).rows}
    assert plant["control period"] == "4 ms"
    assert plant["rotor lag"] == "time constant up 20 ms, time constant down 20 ms"
    assert plant["servo rate limit"] == "servo rate max 100°/s"
    assert "position 1 mm" in plant["measurement noise"]
    assert "velocity 1 cm/s" in plant["measurement noise"]


def test_every_effect_of_a_plant_is_reported(hover: om.Run) -> None:
    from omnimorph.simulation.effects import EFFECTS

    content = json.loads(hover.provenance.scenario_text)
    content["plant"]["effects"] = [{"kind": effect.kind} for effect in EFFECTS]
    provenance = replace(hover.provenance, scenario_text=json.dumps(content))
    rows = plant_table(replace(hover, provenance=provenance)).rows[2:]
    assert len(rows) == len(EFFECTS)
    assert all(row[2] for row in rows), "an effect has no words in the report"


def test_sources_come_with_their_numbers() -> None:
    vehicle = om.load_vehicle("omnimorph")
    rows = source_table(vehicle, "", list(vehicle.sources)).rows
    numbers = {row[0]: row[1] for row in rows}
    assert numbers["mass"] == "1.315 kg"
    assert numbers["inertia"] == "diag(0.0116, 0.0113, 0.0113) kg m²"
    assert numbers["speed max"] == "169.6 Hz"
    assert numbers["time constant up"] == "20 ms"
    assert numbers["servo angle max"] == "60°"


# --- page -----------------------------------------------------------------------------------------


def test_texts_on_a_page_are_escaped_and_figures_are_not() -> None:
    from jinja2 import UndefinedError

    page = render_page("page.html.j2", title="a < b")
    assert "<title>a &lt; b</title>" in page
    with pytest.raises(UndefinedError):
        render_page("page.html.j2")
    assert Picture("<svg></svg>", "nothing").svg == "<svg></svg>"


# --- the folder -----------------------------------------------------------------------------------


def fill(folder: Path, text: str) -> None:
    (folder / "figures").mkdir()
    (folder / "figures" / "one.svg").write_text(text)
    (folder / "results.json").write_text(json.dumps({"schema": "ours"}))


def test_own_folder_appears_as_a_whole_and_can_be_written_over(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    for text in ("first", "second"):
        with own_folder(out, "ours") as folder:
            fill(folder, text)
            assert (out / "figures").exists() == (text == "second")
        assert (out / "figures" / "one.svg").read_text() == text
        assert sorted(path.name for path in out.iterdir()) == ["figures", "results.json"]


def test_own_folder_leaves_nothing_after_a_failure(tmp_path: Path) -> None:
    def interrupted() -> None:
        with own_folder(tmp_path / "deep" / "out", "ours") as folder:
            fill(folder, "half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert list(tmp_path.iterdir()) == []


def test_own_folder_keeps_what_was_there_after_a_failure(tmp_path: Path) -> None:
    with own_folder(tmp_path, "ours") as folder:
        fill(folder, "whole")
    (tmp_path / "mine.txt").write_text("kept")
    with pytest.raises(InputError, match="cannot be written"), own_folder(tmp_path, "ours"):
        raise OSError(28, "No space left on device")
    assert (tmp_path / "figures" / "one.svg").read_text() == "whole"
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "figures",
        "mine.txt",
        "results.json",
    ]


@pytest.mark.parametrize("mark", [None, "{}", "[]", "no json", '{"schema": "another"}'])
def test_somebody_elses_folder_is_refused(tmp_path: Path, mark: str | None) -> None:
    (tmp_path / "mine.txt").write_text("kept")
    if mark is not None:
        (tmp_path / "results.json").write_text(mark)
    with pytest.raises(InputError, match="not empty and not one of ours"):
        own_folder(tmp_path, "ours").__enter__()
    assert (tmp_path / "mine.txt").read_text() == "kept"


def test_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("kept")
    with pytest.raises(InputError, match="not a folder"):
        own_folder(tmp_path / "out", "ours").__enter__()
    with pytest.raises(InputError, match=r"out.inner.*cannot be written"):
        own_folder(tmp_path / "out" / "inner", "ours").__enter__()
