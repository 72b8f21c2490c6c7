"""Figures of an analysis: drawings are projections, curves are the analysis, axes have units."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.unit.analysis_parts import (
    OMNIMORPH,
    QUADROTOR,
    analysis_of_omnimorph,
    build_multirotor,
    build_tilting_hexarotor,
)
from tests.unit.drawn import assert_in_sight, levels_of, xy
from tests.unit.figure_checks import cut_off, laid_out, overlaps

import omnimorph as om
from omnimorph.analysis import analyze, force_set, hover_map
from omnimorph.analysis.hover import hover_power
from omnimorph.analysis.overview import VehicleAnalysis
from omnimorph.analysis.polytope import Polytope
from omnimorph.protocols import FloatArray
from omnimorph.report import analysis_figures, attitude_figures, attitudes, style
from omnimorph.report.polytope_drawing import (
    SphereLook,
    draw_polytope,
    nice_length,
    picture_panel,
    stage_for,
)
from omnimorph.report.vehicle_drawing import camera

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@pytest.fixture(scope="module")
def analysis() -> VehicleAnalysis:
    return analysis_of_omnimorph()


def axes_of(figure: Figure) -> list[Axes]:
    return [panel for panel in figure.axes if panel.axison]


# --- the drawing of a set -------------------------------------------------------------------------


def drawn(polytope: Polytope, radii: tuple[float, ...] = ()) -> Axes:
    figure = style.new_figure(3.0, 0)[0]
    figure.set_layout_engine(None)
    panel = picture_panel(figure, 0.0, 0.0, 3.0, 3.0)
    spheres = [SphereLook(radius, style.BLACK, filled=True) for radius in radii]
    stage = stage_for([polytope], radii, "N")
    draw_polytope(panel, polytope, stage, colour=style.BLUE, spheres=spheres)
    return panel


def faces_of(panel: Axes) -> dict[float, list[FloatArray]]:
    """Return the polygons of a drawing by the order in which they are drawn."""
    from matplotlib.collections import PolyCollection

    return {
        one.get_zorder(): [np.asarray(path.vertices)[:-1] for path in one.get_paths()]
        for one in panel.collections
        if isinstance(one, PolyCollection) and one.get_alpha() is None
    }


def signed_area(polygon: FloatArray) -> float:
    x, y = polygon.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def test_the_camera_is_an_orthonormal_frame() -> None:
    frame = np.array(camera())
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    np.testing.assert_allclose(camera().seen(camera().towards), 0.0, atol=1e-15)
    assert camera().seen([0.0, 0.0, 1.0])[0] @ [0.0, 1.0] > 0.9, "z is upwards in the picture"


def test_the_faces_of_a_solid_fill_its_outline_from_both_sides() -> None:
    solid = force_set(OMNIMORPH, 0.8, zero_moment=True)
    layers = sorted(layer for layer in faces_of(drawn(solid)).items() if len(layer[1]) > 3)
    back, front = (faces for _, faces in layers)
    assert len(back) + len(front) == len(solid.facets)
    assert all(signed_area(face) < 1e-9 for face in back)
    assert all(signed_area(face) > 0.0 for face in front)
    outline = sum(signed_area(face) for face in front)
    assert -sum(signed_area(face) for face in back) == pytest.approx(outline)
    corners = np.vstack(front)
    for along, direction in zip(corners.T, camera()[:2], strict=True):
        assert along.max() == pytest.approx(solid.support(direction))


def test_a_ball_is_a_circle_of_its_radius() -> None:
    from matplotlib.patches import Circle

    solid = force_set(OMNIMORPH, 0.8, zero_moment=True)
    panel = drawn(solid, (solid.inscribed_radius, 0.0))
    circles = [patch for patch in panel.patches if isinstance(patch, Circle)]
    assert [circle.radius for circle in circles] == [solid.inscribed_radius]
    assert panel.get_aspect() == 1.0


def test_flat_sets_are_drawn_as_what_they_are() -> None:
    rod = force_set(OMNIMORPH, 0.0, zero_moment=True)
    ends = [line.get_xydata() for line in drawn(rod).lines if line.get_linewidth() == 4.0]
    assert len(ends) == 1
    np.testing.assert_allclose(np.abs(ends[0]), np.abs(camera().seen(rod.vertices)))

    point = force_set(build_multirotor(np.zeros(1)), 0.0, zero_moment=True)
    dots = [line for line in drawn(point).lines if line.get_color() == style.BLUE]
    np.testing.assert_allclose(np.asarray(dots[0].get_xydata()), np.zeros((1, 2)), atol=1e-12)

    turned = build_tilting_hexarotor()
    plate = force_set(turned, 0.5 * math.pi, zero_moment=False, beyond_limits=True)
    assert plate.dimension == 2
    faces = [face for faces in faces_of(drawn(plate)).values() for face in faces]
    assert [len(face) for face in faces if len(face) > 4] == [len(plate.vertices)]


def test_an_empty_set_is_reported() -> None:
    spinning = build_multirotor(np.zeros(1), speed_min=[100.0])
    empty = force_set(spinning, 0.0, zero_moment=True)
    assert empty.is_empty
    assert "none at all" in [text.get_text() for text in drawn(empty).texts]


@pytest.mark.parametrize("about", [0.0123, 0.5, 1.0, 1.99, 2.0, 4.999, 12.9, 7654.0])
def test_scale_bars_have_round_lengths(about: float) -> None:
    length = nice_length(about)
    assert 0.4 * about < length <= about
    assert f"{length:.0e}"[0] in "125"
    assert float(f"{length:.0e}") == length


# --- figures --------------------------------------------------------------------------------------


def curve(panel: Axes, label: str) -> FloatArray:
    """Return the x and y of the curve with a label, (K, 2)."""
    found = [line for line in panel.lines if line.get_label() == label]
    assert len(found) == 1, label
    return np.asarray(found[0].get_xydata())


def finite(values: FloatArray) -> FloatArray:
    return np.where(np.isfinite(values), values, np.nan)


def test_radii_are_those_of_the_sweep(analysis: VehicleAnalysis) -> None:
    bars, panel = axes_of(analysis_figures.radius_over_tilt(analysis))
    sweep = analysis.sweep
    for label, radius in (
        ("radius at zero moment", sweep.radius_zero_moment),
        ("radius, moments free", sweep.radius_free_moment),
    ):
        drawn_curve = curve(panel, label)
        np.testing.assert_allclose(drawn_curve, np.column_stack([np.degrees(sweep.tilt), radius]))
    strong = [np.asarray(line.get_xdata()) for line in bars.lines if line.get_alpha() == 1.0]
    found = analysis.omnidirectional
    np.testing.assert_allclose(
        strong, np.degrees([found.zero_moment[0], found.free_moment[0]]), rtol=1e-12
    )
    words = {text.get_text() for one in (bars, panel) for text in one.texts}
    assert {"37.00°", "38.18°", "69.73°", "70.28°", "rank 4", "rank 5"} <= words


def test_marks_that_are_near_one_another_are_read_apart() -> None:
    """Two ranks that fall at neighbouring tilts; two tilts where the mechanism begins to pay."""
    fast_hex = analyze(om.load_vehicle("fast-hex"))
    near = tuple(one._replace(tilt=0.01 * k) for k, one in enumerate(2 * fast_hex.singular[:1]))
    close = replace(fast_hex, singular=near)
    assert len(near) == 2
    for figure in (
        analysis_figures.radius_over_tilt(close),
        analysis_figures.mass_break_even(fast_hex),
    ):
        assert overlaps(laid_out(figure), least_gap=2.0) == []


def test_radii_that_agree_are_both_seen(analysis: VehicleAnalysis) -> None:
    """The dashed curve lies on the other, so that its gaps show it."""
    lines = axes_of(analysis_figures.radius_over_tilt(analysis))[-1].lines
    labels = [line.get_label() for line in lines]
    assert labels.index("radius at zero moment") < labels.index("radius, moments free")
    assert lines[labels.index("radius, moments free")].is_dashed()


def test_power_and_condition_are_those_of_the_sweep(analysis: VehicleAnalysis) -> None:
    power, condition = axes_of(analysis_figures.level_hover(analysis))
    assert analysis.wakes is not None
    np.testing.assert_array_equal(
        curve(power, "still air")[:, 1], finite(analysis.sweep.level_power)
    )
    np.testing.assert_array_equal(curve(power, "in the wakes")[:, 1], analysis.wakes.power)
    values = np.asarray(condition.lines[0].get_ydata())
    np.testing.assert_array_equal(values, finite(analysis.sweep.condition_number))
    assert condition.get_yscale() == "log"


def test_wakes_and_mass_are_those_of_the_analysis(analysis: VehicleAnalysis) -> None:
    assert analysis.wakes is not None
    assert analysis.trade is not None
    ratio, radius = axes_of(analysis_figures.wakes(analysis))
    effect, trade = analysis.wakes, analysis.trade
    np.testing.assert_array_equal(ratio.lines[0].get_ydata(), effect.power / effect.power_still)
    kept = curve(radius, "left for certain in the wakes")
    np.testing.assert_array_equal(kept[:, 1], effect.radius)
    figure = analysis_figures.mass_break_even(analysis)
    assert_in_sight(figure)
    (panel,) = axes_of(figure)
    assert trade.own is not None
    assert levels_of(panel) == [100.0 * trade.own]
    crossings = np.degrees([trade.break_even or 0.0, trade.break_even_in_wakes or 0.0])
    marks = [xy(line)[0] for line in panel.lines if line.get_marker() == "D"]
    np.testing.assert_allclose(marks, [[tilt, 100.0 * trade.own] for tilt in crossings])
    np.testing.assert_allclose(curve(panel, "still air")[:, 1], 100.0 * trade.share)
    np.testing.assert_allclose(curve(panel, "in the wakes")[:, 1], 100.0 * trade.share_in_wakes)
    words = {text.get_text() for text in panel.texts}
    assert {"6.42 % at 20°", "15.5 % at 30°", "25.2 % at 37°", "30.9°", "40.4°"} <= words


def test_force_sets_name_their_tilts_and_radii(analysis: VehicleAnalysis) -> None:
    figure = analysis_figures.force_sets(analysis)
    titles = [panel.get_title() for panel in figure.axes if panel.get_title()]
    assert titles == [f"tilt {tilt}°" for tilt in (0, 12, 24, 36, 48, 60)]
    words = [text.get_text() for panel in figure.axes for text in panel.texts]
    radii = [word for word in words if word.startswith("radius")]
    assert radii[0] == "radius 0 N"
    last = force_set(OMNIMORPH, math.radians(60.0), zero_moment=True).inscribed_radius
    assert radii[-1] == f"radius {last:.1f} N"
    limits = {panel.get_xlim() for panel in figure.axes[1::2]}
    assert len(limits) == 1, "all sets have one scale"


def test_moments_are_those_at_hover(analysis: VehicleAnalysis) -> None:
    figure = attitude_figures.moments(analysis)
    (panel,) = axes_of(figure)
    moment = analysis.asked.moment
    reach = [moment.reach(sign * axis) for axis in np.eye(3) for sign in (-1.0, 1.0)]
    ends = [abs(patch.get_width()) for patch in panel.patches]  # type: ignore[attr-defined]
    np.testing.assert_allclose(ends, reach, rtol=1e-12)


def test_figures_are_legible_and_say_their_units(analysis: VehicleAnalysis) -> None:
    figures = {
        draw.__name__: draw(analysis)
        for draw in (
            analysis_figures.force_sets,
            analysis_figures.radius_over_tilt,
            analysis_figures.level_hover,
            analysis_figures.wakes,
            analysis_figures.mass_break_even,
            attitude_figures.moments,
        )
    }
    for name, figure in figures.items():
        assert overlaps(laid_out(figure), least_gap=2.0) == [], name
        assert cut_off(figure) == [], name
        for panel in axes_of(figure):
            place = panel.get_subplotspec()
            if place is None or place.is_last_row():
                assert re.search(r"\(.+\)", panel.get_xlabel()), name
            if panel.get_ylabel():
                assert re.search(r"\(.+\)", panel.get_ylabel()), name
        for panel in figure.axes:
            texts = [*panel.texts, panel.title]
            assert min(float(text.get_fontsize()) for text in texts) >= 8.0, name


# --- attitudes ------------------------------------------------------------------------------------


def test_the_discs_hold_every_attitude_with_its_share() -> None:
    grid = attitudes.attitude_grid(61)
    np.testing.assert_allclose(np.linalg.norm(grid.up, axis=2), 1.0, rtol=1e-12)
    upper, lower = grid.up
    on_disc = upper[:, 2] >= 0.0
    # over a hemisphere the mean of z is 1/2, that of z² is 1/3: equal areas, equal shares
    assert upper[on_disc, 2].mean() == pytest.approx(0.5, abs=0.01)
    assert (upper[on_disc] ** 2).mean(axis=0) == pytest.approx([1 / 3] * 3, abs=0.01)
    np.testing.assert_array_equal(lower, upper * [1.0, 1.0, -1.0])
    square = grid.on_discs(grid.up.reshape(-1, 3)[:, 0])
    assert square[0, 30, 30] == pytest.approx(0.0, abs=1e-12), "the middle is upright"
    assert square[0, 30, 45] > 0.3, "x is to the right"
    assert np.isnan(square[0, 0, 0])


def test_power_over_the_attitude_is_that_of_the_hover_map() -> None:
    up = attitudes.attitude_grid(7).up.reshape(-1, 3)
    power = hover_power(OMNIMORPH, np.array([0.5]), up)
    np.testing.assert_allclose(power, hover_map(OMNIMORPH, up, [0.5]).power[:, 0], rtol=1e-12)
    assert np.isinf(power).any()
    assert np.isfinite(power).any()


def test_the_best_tilt_costs_no_more_than_its_neighbours() -> None:
    up = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, 0.0, 0.8], [0.5, 0.5, -0.7]])
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    tilts = np.radians(np.linspace(0.0, 60.0, 25))
    best = attitudes.best_tilt_on(OMNIMORPH, tilts, up)
    assert best[0] == 0.0, "level, OmniMorph hovers best untilted"
    for direction, tilt in zip(up, best, strict=True):
        found = hover_power(OMNIMORPH, np.array([tilt]), direction[None])[0]
        on_grid = hover_map(OMNIMORPH, direction[None], np.radians(np.linspace(0, 60, 241)))
        assert found <= 1.001 * on_grid.least_power[0]


def test_a_quadrotor_hovers_in_one_attitude() -> None:
    level = analyze(QUADROTOR)
    figure = attitude_figures.hover_map(level)
    words = [text.get_text() for panel in figure.axes for text in panel.texts]
    assert [word for word in words if word.endswith(" W")] == [f"{level.asked.hover.power:.3g} W"]
    dots = [len(one.get_offsets()) for panel in figure.axes for one in panel.collections]  # type: ignore[arg-type]
    assert sum(dots) == 1
