"""Figures of experiments: what is drawn is what was handed in, and everything can be read."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.unit import experiment_parts as parts
from tests.unit.drawn import assert_in_sight, assert_legend
from tests.unit.experiment_parts import LINE_STYLES, PANELS
from tests.unit.figure_checks import cut_off, laid_out, overlaps, texts_of
from tests.unit.reproduction_parts import values_of

import omnimorph as om
from omnimorph.protocols import FloatArray
from omnimorph.report import style
from omnimorph.studies.reproduction.figures.ablation import AblationPanel, AblationRow, ablation
from omnimorph.studies.reproduction.figures.frontier import frontier
from omnimorph.studies.reproduction.figures.line_styles import LINE_STYLES as OF_FLIGHTS
from omnimorph.studies.reproduction.figures.stand import stand
from omnimorph.studies.reproduction.figures.tilt_choice import (
    cost_gaps,
    energy_by_choice,
    tilt_by_choice,
)
from omnimorph.studies.reproduction.flights import SCENARIOS
from omnimorph.studies.reproduction.lost_thrust import KINDS, NOT_LOST, POSE_KEPT
from omnimorph.studies.reproduction.tilt_choice import RANGE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@pytest.fixture(scope="module")
def figures() -> dict[str, Figure]:
    choice = parts.build_choices(om.fly(om.load_scenario("hover")))
    made = {
        "ablation": ablation(parts.build_ablation(), PANELS, LINE_STYLES),
        "stand": stand(parts.build_stand()),
        "frontier": frontier(parts.build_frontier()),
        "tilt_by_choice": tilt_by_choice(choice),
        "cost_gaps": cost_gaps(choice.gaps),
        "energy_by_choice": energy_by_choice(choice),
    }
    return {name: laid_out(figure) for name, figure in made.items()}


def xy(line: Any) -> FloatArray:
    return np.asarray(line.get_xydata(), dtype=np.float64)


def marks_of(panel: Axes, mark: str, colour: str) -> FloatArray:
    """Return where unconnected marks of a kind and colour are, (K, 2), in the order of drawing."""
    found = [
        xy(line)
        for line in panel.lines
        if line.get_marker() == mark
        and line.get_color() == colour
        and (line.get_linestyle() == "None" or len(xy(line)) == 1)
    ]
    return np.concatenate([np.empty((0, 2)), *found])


# --- what all have in common ----------------------------------------------------------------------

NAMES = ["ablation", "stand", "frontier", "tilt_by_choice", "cost_gaps", "energy_by_choice"]


@pytest.mark.parametrize("name", NAMES)
def test_figures_are_legible_and_keep_inside_their_frame(
    figures: dict[str, Figure], name: str
) -> None:
    figure = figures[name]
    width, height = figure.get_size_inches()
    assert width == style.WIDTH
    assert height <= 9.5, "it fits a page"
    with style.house_style():
        inside = figure.get_tightbbox()
    assert min(inside.x0, inside.y0) >= 0.0
    assert inside.x1 <= width
    assert inside.y1 <= height
    assert min(float(text.get_fontsize()) for text in texts_of(figure)) >= 8.0


@pytest.mark.parametrize("name", NAMES)
def test_no_curve_leaves_its_axes(figures: dict[str, Figure], name: str) -> None:
    assert_in_sight(figures[name], floor=name == "cost_gaps")  # whose axis is logarithmic


@pytest.mark.parametrize("name", NAMES[1:])  # an ablation's is of marks of its own
def test_legends_name_all_that_has_a_name(figures: dict[str, Figure], name: str) -> None:
    assert_legend(figures[name])


@pytest.mark.parametrize("name", NAMES)
def test_no_words_run_together(figures: dict[str, Figure], name: str) -> None:
    assert overlaps(figures[name], least_gap=2.0) == []
    assert cut_off(figures[name]) == []


@pytest.mark.parametrize("name", NAMES)
def test_axes_say_their_units(figures: dict[str, Figure], name: str) -> None:
    for panel in figures[name].axes:
        place = panel.get_subplotspec()
        assert place is not None
        if place.is_last_row() or panel.get_xlabel():
            assert re.search(r"\(.+\)", panel.get_xlabel())
        if panel.get_ylabel():
            assert re.search(r"\(.+\)", panel.get_ylabel())


# --- ablation -------------------------------------------------------------------------------------


def test_ablation_draws_mean_and_range_of_every_row(figures: dict[str, Figure]) -> None:
    rows, figure = parts.build_ablation(), figures["ablation"]
    assert len(rows) == 35
    names = [tick.get_text() for tick in figure.axes[0].get_yticklabels()]
    for panel, axis in zip(PANELS, figure.axes, strict=True):
        for case, line_style in LINE_STYLES.items():
            seeds = [np.asarray(row.values[panel.measure].get(case, ())) for row in rows]
            flown = [(row, v[np.isfinite(v)]) for row, v in zip(rows, seeds, strict=True)]
            flown = [(row, v) for row, v in flown if len(v)]
            drawn = marks_of(axis, line_style.mark, line_style.colour)
            np.testing.assert_allclose(drawn[:, 0], [v.mean() for _, v in flown], rtol=1e-12)
            at = [names[round(y)] for y in drawn[:, 1]]
            assert at == [row.label for row, _ in flown]
            ranges = np.concatenate(
                [
                    xy(line)[:, 0].reshape(-1, 3)
                    for line in axis.lines
                    if line.get_alpha() == 0.4 and line.get_color() == line_style.colour
                ]
                or [np.empty((0, 3))]
            )
            assert np.isnan(ranges[:, 2]).all(), "the pen is lifted between rows"
            assert ranges[:, :2].tolist() == [[v.min(), v.max()] for _, v in flown]


def test_ablation_has_headings_and_lost_flights(figures: dict[str, Figure]) -> None:
    rows, (tilt, *others) = parts.build_ablation(), figures["ablation"].axes
    bold = [t.get_text() for t in tilt.get_yticklabels() if t.get_fontweight() == "bold"]
    assert bold == list(dict.fromkeys(row.group for row in rows))
    names = [tick.get_text() for tick in tilt.get_yticklabels()]
    assert len(marks_of(tilt, "x", LINE_STYLES["Case B"].colour)) == 0
    for axis in others:
        lost = marks_of(axis, "x", LINE_STYLES["Case B"].colour)
        assert [names[round(y)] for _, y in lost] == [rows[2].label, rows[8].label]
        assert (lost[:, 0] > 0.9).all(), "a share of the width"
    assert "lost flights" in [t.get_text() for t in figures["ablation"].legends[0].get_texts()]


def test_ablation_draws_the_papers_values_with_their_numbers(figures: dict[str, Figure]) -> None:
    for panel, axis in zip(PANELS, figures["ablation"].axes, strict=True):
        lines = {line.get_color(): xy(line)[0, 0] for line in axis.lines if line.is_dashed()}
        assert lines == {LINE_STYLES[case].colour: value for case, value in panel.paper.items()}
    words = [text.get_text() for axis in figures["ablation"].axes for text in axis.texts]
    assert words == ["2081", "1162", "11", "44", "0.062", "0.068"]


def test_ablation_of_one_row_without_seeds_lost_needs_no_more_words() -> None:
    row = AblationRow("perfect plant", "", {"tilt": {"Case A": [12.0]}})
    figure = ablation(
        [row], [AblationPanel("tilt", "mean tilt (°)")], {"Case A": LINE_STYLES["Case A"]}
    )
    assert [t.get_text() for t in figure.legends[0].get_texts()] == ["Case A: mean and range"]
    (panel,) = figure.axes
    assert [tick.get_text() for tick in panel.get_yticklabels()] == ["perfect plant"]
    np.testing.assert_array_equal(marks_of(panel, "o", style.VERMILLION), [[12.0, 0.0]])


def test_wide_ranges_of_an_ablation_have_ticks_that_can_be_read() -> None:
    """Over five decades, as errors have them; the names of ticks are above the panels as well."""
    values = {case: {"Case A": [1.2e-5 * 10.0**k]} for k, case in enumerate(("x", "y", "z"))}
    rows = [AblationRow(f"{k}", "", {name: one}) for k, (name, one) in enumerate(values.items())]
    spread = [AblationRow("wide", "", {n: {"Case A": [1.2e-5, 0.2]} for n in values})]
    panels = [AblationPanel(name, f"{name}\n(–)", True, {"Case A": 0.062}) for name in values]
    figure = laid_out(ablation([*rows, *spread], panels, {"Case A": LINE_STYLES["Case A"]}))
    assert overlaps(figure, least_gap=2.0) == []
    for panel in figure.axes:
        ticks = panel.xaxis.get_major_ticks()
        names = [tick.label1.get_text() for tick in ticks]
        assert len(names) >= 2
        assert not [name for name in names if "e" in name]
        assert [tick.label2.get_text() for tick in ticks] == names
        assert all(tick.label2.get_visible() for tick in ticks)


def test_two_values_of_the_paper_that_nearly_agree_are_two_lines() -> None:
    """The dashes of one fill the gaps of the other."""
    row = AblationRow("row", "", {"e": {case: [1e-5, 0.1] for case in LINE_STYLES}})
    panel = AblationPanel("e", "e (–)", True, dict.fromkeys(LINE_STYLES, 0.062))
    (axis,) = ablation([row], [panel], LINE_STYLES).axes
    one, two = (style.INTERLEAVED[k] for k in range(2))
    assert two[0] == one[1][0] == one[1][1], "it starts where the gap of the other does"
    drawn_as = [line for line in axis.lines if line.is_dashed()]
    assert [line._unscaled_dash_pattern for line in drawn_as] == [one, two]  # type: ignore[attr-defined]


def test_names_of_ticks_at_the_ends_of_a_panel_stay_in_it() -> None:
    """Else they run together with those of the panel beside it."""
    values = {name: {"Case A": [0.0, 36_000.0]} for name in ("w", "x", "y", "z")}
    panels = [AblationPanel(name, f"{name} (–)") for name in values]
    figure = ablation([AblationRow("row", "", values)], panels, {"Case A": LINE_STYLES["Case A"]})
    laid_out(figure)
    for panel in figure.axes:
        ticks = panel.xaxis.get_major_ticks()
        assert len(ticks) >= 2
        boxes = [tick.label1.get_window_extent() for tick in ticks]
        assert panel.bbox.x0 - 2.0 <= boxes[0].x0
        assert boxes[-1].x1 <= panel.bbox.x1 + 2.0


# --- stand ----------------------------------------------------------------------------------------


def test_stand_draws_speeds_and_forces(figures: dict[str, Figure]) -> None:
    tests = parts.build_stand().tests
    top, *panels = figures["stand"].axes
    alone, others = (xy(line)[:, 1] for line in top.lines)
    np.testing.assert_allclose(alone, 120.0)
    np.testing.assert_allclose(np.unique(others.round(9)), np.arange(0.0, 121.0, 20.0))
    assert [panel.get_title(loc="left") for panel in panels] == ["tilt 0°", "tilt 50°"]
    assert panels[0].get_ylim() == panels[1].get_ylim()
    for test, panel in zip(tests, panels, strict=True):
        means, bands = panel.lines[:2], panel.collections
        for reading, line, band in zip((test.alone, test.together), means, bands, strict=True):
            values = reading.thrust[reading.time >= 0.5]
            assert xy(line)[:, 1].mean() == pytest.approx(values.mean(), rel=1e-3)
            heights = np.asarray(band.get_paths()[0].vertices)[:, 1]
            assert (heights.min(), heights.max()) == (values.min(), values.max())
        assert len(panel.lines[2:]) == len(panel.texts) == 2


# --- frontier -------------------------------------------------------------------------------------


def test_curves_of_a_frontier_that_agree_are_drawn_apart() -> None:
    found = parts.build_frontier()
    same = [replace(found.frontiers[0], scenario=name) for name in SCENARIOS[:3]]
    axis = laid_out(frontier(replace(found, frontiers=same))).axes[0]
    places = [line.get_transform().transform(xy(line)) for line in axis.lines[:3]]
    for one, two in itertools.pairwise(places):
        assert np.all(two - one > 1.0), "points"
        assert np.all(two - one < 3.0)


def test_frontier_without_dead_rotors_has_a_row_for_each_kind_of_loss() -> None:
    figure = frontier(replace(parts.build_frontier(), dead={}))
    assert [axis.get_title(loc="left") for axis in figure.axes] == [
        f"{kind}: {criterion}" for kind in KINDS for criterion in (NOT_LOST, POSE_KEPT)
    ]


# --- choice of the tilt ---------------------------------------------------------------------------


def test_tilts_are_drawn_case_by_case(figures: dict[str, Figure]) -> None:
    above, below = figures["tilt_by_choice"].axes
    assert (above.get_ylabel(), below.get_ylabel()) == ("Case A\ntilt (°)", "Case B\ntilt (°)")
    for panel in (above, below):
        named = [line.get_label() for line in panel.lines]
        assert named[: len(parts.WAYS) + 1] == [*parts.WAYS, "lower bound"]


def test_tilts_that_coincide_are_seen_beside_one_another(figures: dict[str, Figure]) -> None:
    above, _ = figures["tilt_by_choice"].axes
    widths = [line.get_linewidth() for line in above.lines[: len(parts.WAYS)]]
    assert widths == sorted(widths, reverse=True)
    assert widths[0] > 2.0 * widths[-1]


def test_cost_gaps_are_shares_of_steps(figures: dict[str, Figure]) -> None:
    *gaps, _ = parts.build_gaps()
    *lines, empty = figures["cost_gaps"].axes[0].lines
    for one, line in zip(gaps, lines, strict=True):
        assert line.is_dashed() == (one.span == RANGE)
        x, share = xy(line).T
        assert np.all(np.diff(share) <= 0.0)
        for k in (0, 100, 250):
            assert share[k] == pytest.approx(100.0 * (one.gap > x[k] / 100.0).mean(), abs=0.02)
        assert share[-1] > 0.0, "on a logarithmic axis"
    assert (empty.get_label(), len(xy(empty))) == ("Case A: to itself: none", 0)


def test_energies_stand_beside_their_lower_bound(figures: dict[str, Figure]) -> None:
    (panel,) = figures["energy_by_choice"].axes
    texts = {text.get_text() for text in panel.texts}
    choices = parts.build_choices(om.fly(om.load_scenario("hover"))).choices
    for (case, style_of_case), mark in zip(list(OF_FLIGHTS.items())[:2], "os", strict=True):
        means = [float(values_of(one.flown[case], "drag_energy_paper").mean()) for one in choices]
        drawn = marks_of(panel, mark, style_of_case.colour)
        np.testing.assert_allclose(drawn[:, 0], means, rtol=1e-12)
        np.testing.assert_array_equal(drawn[:, 1].round(), range(len(choices)))
        assert {f"{100.0 * (mean / 1100.0 - 1.0):+.1f} %" for mean in means} <= texts
    (line,) = [line for line in panel.lines if line.is_dashed()]
    assert (line.get_label(), line.get_color()) == ("lower bound, Case A and Case B", style.BLACK)
    assert xy(line)[0, 0] == pytest.approx(1100.0)
