"""Limits, marks and bars of an analysis' figures, and each key of its data, are its own numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.unit.analysis_parts import OMNIMORPH, QUADROTOR, analysis_of_omnimorph
from tests.unit.drawn import assert_legend, levels_of, panels_of, spans_of, uprights_of, xy

import omnimorph as om
from omnimorph.analysis import analyze, force_set
from omnimorph.analysis.hover import hover_power
from omnimorph.analysis.overview import VehicleAnalysis
from omnimorph.report import analysis_figures, attitude_figures
from omnimorph.report.analysis_data import analysis_data
from omnimorph.report.analysis_page import _condition_table, _drawings, _tilt_table
from omnimorph.report.analysis_summary import description, key_points
from omnimorph.report.analysis_text import condition_text, rows_by_tilt
from omnimorph.report.tables import degrees, number
from omnimorph.studies.reproduction import design
from omnimorph.units import from_SI, unit_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LIMIT, LAST = 60.0, 90.0  # degrees: what the servo reaches, and where the sweep ends


@pytest.fixture(scope="module")
def analysis() -> VehicleAnalysis:
    return analysis_of_omnimorph()


def triangles_of(panel: Axes) -> list[float]:
    return [float(xy(line)[0, 0]) for line in panel.lines if line.get_marker() == "^"]


# --- figures --------------------------------------------------------------------------------------


def test_what_servos_cannot_reach_is_shaded(analysis: VehicleAnalysis) -> None:
    for draw in (analysis_figures.radius_over_tilt, analysis_figures.level_hover):
        figure = draw(analysis)
        assert_legend(figure)
        for panel in panels_of(figure):
            assert [one.get_label() for one in panel.patches] == ["beyond the limit"]
            assert panel.get_xlim() == pytest.approx((0.0, LAST))
            np.testing.assert_allclose(spans_of(panel), [(LIMIT, LAST)])


def test_weights_and_ranks_are_marked_where_they_are(analysis: VehicleAnalysis) -> None:
    panel = panels_of(analysis_figures.radius_over_tilt(analysis))[-1]
    assert levels_of(panel) == [analysis.weight]
    falls = {math.degrees(one.tilt): one.rank for one in analysis.singular}
    shown = {angle: rank for angle, rank in falls.items() if -1e-6 <= angle <= LAST + 1e-6}
    assert triangles_of(panel) == pytest.approx(list(shown))
    ranks = {
        text.xy[0]: text.get_text()  # type: ignore[attr-defined]
        for text in panel.texts
        if text.get_text().startswith("rank")
    }
    assert list(ranks) == pytest.approx(list(shown))
    assert list(ranks.values()) == [f"rank {rank}" for rank in shown.values()]
    assert f"weight, {number(analysis.weight)} N" in [text.get_text() for text in panel.texts]
    figure = analysis_figures.wakes(analysis)
    assert_legend(figure)
    ratio, radius = panels_of(figure)
    assert (levels_of(ratio), levels_of(radius)) == ([1.0], [analysis.weight])
    assert analysis.wakes is not None
    still = next(line for line in radius.lines if line.get_label() == "still air")
    np.testing.assert_array_equal(xy(still)[:, 1], analysis.wakes.radius_still)
    for one in (ratio, radius):
        assert one.get_xlim() == pytest.approx(np.degrees(analysis.wakes.tilt[[0, -1]]))


def test_bars_of_omnidirectional_tilts_pale_beyond_the_limits(analysis: VehicleAnalysis) -> None:
    bars, _ = panels_of(analysis_figures.radius_over_tilt(analysis))
    found = analysis.omnidirectional
    for level, within, beyond in (
        (0.0, found.zero_moment, found.zero_moment_beyond),
        (1.0, found.free_moment, found.free_moment_beyond),
    ):
        for strength, intervals in ((1.0, within), (0.3, beyond)):
            drawn = [
                xy(line)[:, 0] for line in bars.lines
                if line.get_alpha() == strength and xy(line)[0, 1] == level
            ]  # fmt: skip
            ahead = [one for one in np.degrees(intervals).tolist() if one[1] > 0 and one[0] < LAST]
            np.testing.assert_allclose(drawn, ahead)
    assert [tick.get_text() for tick in bars.get_yticklabels()] == ["zero moment", "moments free"]


def test_the_paper_is_marked_at_its_tilts(analysis: VehicleAnalysis) -> None:
    figure = analysis_figures.mass_break_even(analysis)
    assert_legend(figure)
    (panel,) = panels_of(figure)
    assert analysis.trade is not None
    trade = analysis.trade
    dots = np.array([xy(line)[0] for line in panel.lines if line.get_marker() == "o"])
    np.testing.assert_array_equal(dots[:, 0], [20.0, 30.0, 37.0])
    on_curve = np.interp(np.radians(dots[:, 0]), trade.tilt_fixed, 100.0 * trade.share)
    np.testing.assert_allclose(dots[:, 1], on_curve, rtol=5e-3)
    assert panel.get_xlim() == pytest.approx(np.degrees(trade.tilt_fixed[[0, -1]]))
    assert trade.own is not None
    named = [text.get_text() for text in panel.texts]
    assert f"its own, {number(100.0 * trade.own, 3)} %" in named


def test_bars_of_moments_end_where_the_set_does(analysis: VehicleAnalysis) -> None:
    """A set that reaches farther one way than the other; the lines are the inscribed sphere's."""
    uneven = force_set(om.load_vehicle("tilt-hex"), [], zero_moment=False)
    centre = analysis.asked.force_zero
    for one in (uneven, centre):
        shown = replace(analysis, asked=replace(analysis.asked, moment=one))
        (panel,) = panels_of(attitude_figures.moments(shown))
        for k, axis in enumerate(np.eye(3)):
            ends = [-one.reach(-axis), one.reach(axis)]
            patches: Any = panel.patches[2 * k : 2 * k + 2]
            np.testing.assert_allclose([bar.get_width() for bar in patches], ends, atol=1e-12)
            np.testing.assert_allclose([bar.get_center()[1] for bar in patches], k)
            words = [text.get_text() for text in panel.texts[2 * k : 2 * k + 2]]
            assert words == [number(abs(end), 3) for end in ends]
        radius = one.inscribed_radius
        expected = [-radius, 0.0, radius] if radius > 0.0 else [0.0]
        assert uprights_of(panel) == pytest.approx(expected)
        names = [tick.get_text() for tick in panel.get_yticklabels()]
        assert names == ["roll, about x", "pitch, about y", "yaw, about z"]


def test_two_sets_at_the_one_tilt_there_is_are_distinguished() -> None:
    level = analyze(QUADROTOR)
    figure = analysis_figures.force_sets(level)
    radii = [level.asked.force_zero.inscribed_radius, level.asked.force_free.inscribed_radius]
    titles = [panel.get_title() for panel in figure.axes if panel.get_title()]
    expected = zip(("at zero moment", "moments free"), radii, strict=True)
    assert titles == [f"{words}: radius {number(radius, 3)} N" for words, radius in expected]


def test_each_figure_is_drawn_under_its_name(analysis: VehicleAnalysis) -> None:
    for name, (_, draw) in _drawings(analysis).items():
        assert draw.__name__ == name


def shades_at(panel: Axes, x: float, y: float) -> tuple[float, float]:
    """Return between which levels the shade at a point of a disc stands."""
    from matplotlib.path import Path

    areas: Any = next(one for one in panel.collections if hasattr(one, "levels"))
    for k, path in enumerate(areas.get_paths()):
        around = [Path(one).contains_point((x, y)) for one in path.to_polygons()]
        if sum(around) % 2:  # an even number: in a hole
            return float(areas.levels[k]), float(areas.levels[k + 1])
    raise AssertionError("nothing is drawn there")


def test_shades_of_the_discs_are_power_and_best_tilt(analysis: VehicleAnalysis) -> None:
    figure = attitude_figures.hover_map(analysis)
    upper, lower, best, _ = [panel for panel in figure.axes if not panel.get_ylabel()]
    bars = [panel.get_ylabel() for panel in figure.axes if panel.get_ylabel()]
    assert bars == ["least power to hover (W)", "tilt of least power (°)"]
    for panel, sign in ((upper, 1.0), (lower, -1.0)):
        for x, y in ((0.0, 0.0), (0.31, 0.12), (-0.4, 0.33), (0.1, -0.52)):
            stretch, height = math.sqrt(2.0 - x * x - y * y), 1.0 - x * x - y * y
            up = np.array([[x * stretch, y * stretch, sign * height]])
            power = float(hover_power(OMNIMORPH, analysis.asked.tilt, up)[0])
            low, high = shades_at(panel, x, y)
            room = 0.3 * (high - low)
            assert low - room <= power <= high + room
    low, high = shades_at(best, 0.0, 0.0)
    assert low <= 0.0 <= high, "level, it hovers best untilted"
    x = 0.7
    up = np.array([[x * math.sqrt(2.0 - x * x), 0.0, 1.0 - x * x]])
    tilts = np.radians(np.linspace(0.0, LIMIT, 61))
    powers = [hover_power(OMNIMORPH, np.array([tilt]), up)[0] for tilt in tilts]
    low, high = shades_at(best, x, 0.0)
    assert (
        low - 0.5 * (high - low) <= np.degrees(tilts[np.argmin(powers)]) <= 1.5 * high - 0.5 * low
    )


# --- data -----------------------------------------------------------------------------------------


def assert_fields(reported: Mapping[str, Any], found: Any, names: Mapping[str, str]) -> None:
    """Hold that each key is the field of its name without the unit, or else of the one given."""
    for key, value in reported.items():
        unit = unit_of(key)
        field = names.get(key, key.removesuffix(f"_{unit}"))
        if not field:
            continue
        own = getattr(found, field)
        if own is None or isinstance(own, str | bool):
            assert value == own, key
            continue
        own = from_SI(np.asarray(own, dtype=np.float64), unit)
        shown = np.asarray(value, dtype=np.float64)  # None becomes not a number
        expected = np.where(np.isfinite(own), own, np.nan)
        np.testing.assert_allclose(shown, expected, rtol=1e-9, atol=1e-9, err_msg=key)


def test_data_over_the_tilt_are_the_fields_they_are_called_by(analysis: VehicleAnalysis) -> None:
    data = analysis_data(analysis)
    assert_fields(data["sweep"], analysis.sweep, {})
    assert_fields(
        data["interference"],
        analysis.wakes,
        {
            "model": "",
            "level_power_W": "power",
            "level_power_still_air_W": "power_still",
            "radius_zero_moment_at_least_N": "radius",
            "radius_zero_moment_still_air_N": "radius_still",
        },
    )
    assert_fields(
        data["morphing_trade"],
        analysis.trade,
        {
            "break_even_share": "share",
            "break_even_share_in_wakes": "share_in_wakes",
            "own_share": "own",
            "break_even_tilt_deg": "break_even",
            "break_even_tilt_in_wakes_deg": "break_even_in_wakes",
        },
    )
    ranges = {
        f"{ours}{where}": np.degrees(getattr(analysis.omnidirectional, f"{field}{suffix}"))
        for ours, field in (
            ("every_attitude_zero_moment", "zero_moment"),
            ("every_attitude_free_moment", "free_moment"),
            ("level", "level"),
        )
        for where, suffix in (("", ""), ("_whole_turn", "_beyond"))
    }
    assert set(ranges) == set(data["hovering_range_deg"])
    for key, expected in ranges.items():
        np.testing.assert_allclose(data["hovering_range_deg"][key], expected, atol=1e-9)
    found = analysis.hover_map
    assert_fields(data["hover_map"], found, {
        "attitudes": "", "feasible_share": "", "best_tilt_deg": ""
    })  # fmt: skip
    best = np.where(found.feasible, np.degrees(found.best_tilt), np.nan)
    shown = np.asarray(data["hover_map"]["best_tilt_deg"], dtype=np.float64)
    np.testing.assert_allclose(shown, best, atol=1e-9)
    assert data["hover_map"]["feasible_share"] == found.feasible.mean()
    assert data["hover_map"]["attitudes"] == len(found.up)
    vehicle = {"rotors": "n_rotors", "servos": "n_servos", "weight_N": "", "dead_band_ignored": ""}
    assert_fields(data["vehicle"], OMNIMORPH, vehicle)
    assert data["vehicle"]["dead_band_ignored"] is bool(OMNIMORPH.dead_band.any())
    reported = [(one["tilt_deg"], one["rank_thrust"]) for one in data["singular_tilts"]]
    assert reported == [(pytest.approx(math.degrees(o.tilt)), o.rank) for o in analysis.singular]
    assert data["vehicle"]["weight_N"] == OMNIMORPH.mass * 9.81
    assert data["tilt_limits_deg"] == pytest.approx([0.0, LIMIT])
    assert_fields(data["over_all_tilts"], analysis.platform, {
        "actuation": "", "thrust": "", "hover_power_W_per_kg": "hover_power_per_kg"
    })  # fmt: skip


def test_data_at_a_tilt_are_those_of_its_sets_and_its_hovering(analysis: VehicleAnalysis) -> None:
    for reported, one in zip(analysis_data(analysis)["at_tilt"], analysis.at, strict=True):
        assert_fields(
            {key: reported[key] for key in ("rank_thrust", "rank_full", "condition_number",
                                        "singular_values_N")},
            one.actuation,
            {"singular_values_N": "singular_values"},
        )  # fmt: skip
        np.testing.assert_array_equal(reported["null_space"], one.actuation.null_space.T)
        assert (reported["kind"], reported["thrust_kind"]) == (
            one.actuation.kind.value,
            one.actuation.thrust_kind.value,
        )
        for key, unit, polytope in (
            ("force_free_moment", "N", one.force_free),
            ("force_zero_moment", "N", one.force_zero),
            ("moment_at_level_hover", "Nm", one.moment),
        ):
            shown = reported[key]
            assert shown["dimension"] == polytope.dimension
            assert shown[f"radius_{unit}"] == polytope.inscribed_radius
            (volume,) = (value for name, value in shown.items() if name.startswith("volume"))
            assert volume == polytope.volume
            np.testing.assert_allclose(shown[f"vertices_{unit}"], polytope.vertices)
            np.testing.assert_allclose(shown["normals"], polytope.normals)
            np.testing.assert_allclose(shown[f"offsets_{unit}"], polytope.offsets)
        for key, hover in (("level_hover", one.hover), ("level_hover_least_norm", one.hover_norm)):
            shown = reported[key]
            assert shown["feasible"] == hover.feasible
            assert shown["power_W"] == pytest.approx(hover.power)
            np.testing.assert_allclose(shown["thrust_N"], hover.thrust)
            np.testing.assert_allclose(shown["speed_Hz"], hover.speed / (2.0 * math.pi))
        assert reported["attitudes_share"] == one.attitudes.share
        lift = one.force_zero.reach([0.0, 0.0, 1.0])
        assert reported["largest_lift_N"] == lift


# --- words ----------------------------------------------------------------------------------------


def test_the_vehicle_is_described_by_its_own_numbers(analysis: VehicleAnalysis) -> None:
    text = description(analysis).replace("\N{NO-BREAK SPACE}", " ")
    thrust = OMNIMORPH.thrust_coefficient[0] * OMNIMORPH.speed_max[0] ** 2
    assert "8 rotors and 1 servo (tilt from 0° to 60°)" in text
    assert f"weighs {number(analysis.weight)} N ({number(OMNIMORPH.mass)} kg)" in text
    assert f"gives {number(-thrust)} to {number(thrust)} N." in text


def test_wakes_are_reported_at_both_ends_with_what_they_add(analysis: VehicleAnalysis) -> None:
    points = {point.head: point.text for point in key_points(analysis)}
    text = points["Wakes:"].replace("\N{NO-BREAK SPACE}", " ")
    assert analysis.wakes is not None
    effect = analysis.wakes
    assert text.startswith(f"{len(effect.pairs)} pairs of rotors are in line")
    for k in (0, -1):
        more = number(100.0 * (effect.power[k] / effect.power_still[k] - 1.0), 2)
        at = f"{number(effect.power[k])} W at {degrees(effect.tilt[k])} (+{more} %)"
        assert at in text
    best = int(effect.radius.argmax())
    assert (
        f"is {number(effect.radius[best])} N at best, at {degrees(effect.tilt[best])} "
        f"(in still air {number(effect.radius_still.max())} N)"
    ) in text


def test_wakes_are_reported_where_it_can_hover_in_them(analysis: VehicleAnalysis) -> None:
    assert analysis.wakes is not None
    effect = analysis.wakes
    power = effect.power.copy()
    power[:3] = power[-5:] = np.inf
    less = replace(analysis, wakes=replace(effect, power=power))
    (text,) = [one.text for one in key_points(less) if one.head == "Wakes:"]
    for k in (3, -6):
        at = f"{number(power[k])}\N{NO-BREAK SPACE}W at {degrees(effect.tilt[k])} (+"
        assert at in text


def test_claims_on_the_design_say_its_numbers(analysis: VehicleAnalysis) -> None:
    """Each in the order of its sentence; ranks and matrix are held by the errata."""
    found = analysis.omnidirectional
    free = min(one for one in np.degrees(found.free_moment_beyond).tolist() if one[0] > 0)
    zero = min(one for one in np.degrees(found.zero_moment_beyond).tolist() if one[0] > 0)
    (lost,) = [high for low, high in np.degrees(found.level_beyond).tolist() if low <= 0 <= high]
    trade = analysis.trade
    assert trade is not None
    assert trade.own is not None
    limit = f"{OMNIMORPH.thrust_max.max():.4f}"
    ends = [math.degrees(one or 0.0) for one in (trade.break_even, trade.break_even_in_wakes)]
    falls = [f"{math.degrees(one.tilt):.0f}°".replace("-", "−") for one in analysis.singular]
    judged = {
        one.claim.key: one
        for part in (
            design._judge_ranks(OMNIMORPH, analysis),
            design._judge_intervals(OMNIMORPH, analysis),
            design._judge_mass(OMNIMORPH, analysis),
            [design._judge_axes(OMNIMORPH)],
        )
        for one in part
    }
    for key in ("rank_at_0", "rank_at_90", "rank_elsewhere"):
        assert f"falls at {', '.join(falls)} only" in judged[key].why
    for key, here, reported in (
        ("omnidirectional_from", free[0], [f"{free[0]:.2f}", f"{zero[0]:.2f}"]),
        ("omnidirectional_to", free[1], [f"{free[1]:.2f}", f"{zero[1]:.2f}"]),
        ("hover_lost_at", lost, [f"{lost:.2f}"]),
    ):
        assert judged[key].here == pytest.approx(here)
        assert re.findall(r"[\d.]+(?=°)", judged[key].found) == reported
        assert f"{limit} N" in judged[key].why
    for key, tilt in (("break_even_20", 20.0), ("break_even_30", 30.0)):
        expected = 100.0 / math.cos(math.radians(tilt)) - 100.0
        assert judged[key].here == pytest.approx(expected)
    pays = judged["own_mechanism_pays"]
    share = [f"{100.0 * trade.own:.2f}", f"{ends[0]:.2f}", f"{ends[1]:.1f}"]
    assert re.findall(r"[\d.]+(?= ?[%°])", pays.found) == share
    assert "at the 37°" in pays.why
    assert pays.verdict.value == "contradicted"
    assert "54.7356°" in judged["turned_axes"].found


def test_conditions_stand_beside_their_tilt_and_rank(analysis: VehicleAnalysis) -> None:
    lacking = [one for one, _ in rows_by_tilt(analysis) if one.actuation.rank_thrust < 6]
    assert _condition_table(analysis).rows == [
        [
            degrees(one.tilt[0]),
            str(one.actuation.rank_thrust),
            condition_text(one.actuation.conditions[0]),
        ]
        for one in lacking
    ]
    why = {row[0]: row[1:] for row in _tilt_table(analysis).rows}
    share = next(cells for head, cells in why.items() if head.startswith("share of all"))
    assert share == [one.attitudes.words for one, _ in rows_by_tilt(analysis)]
