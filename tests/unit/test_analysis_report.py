"""The page of an analysis: true sentences, for any vehicle, in one file that needs no other."""

from __future__ import annotations

import html
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.unit.analysis_parts import (
    NOT_MORPHING,
    OMNIMORPH,
    analysis_of_omnimorph,
    build_tilting_hexarotor,
)

import omnimorph as om
from omnimorph.analysis import analyze
from omnimorph.analysis.overview import VehicleAnalysis
from omnimorph.report.analysis_data import analysis_data
from omnimorph.report.analysis_page import _content, _tilt_table, write_analysis_page
from omnimorph.report.analysis_summary import key_points
from omnimorph.report.analysis_text import (
    condition_text,
    intervals_text,
    lost_text,
    rows_by_tilt,
    singular_text,
)
from omnimorph.report.page import render_page
from omnimorph.report.tables import degrees, number, tilt_text


@pytest.fixture(scope="module")
def analysis() -> VehicleAnalysis:
    return analysis_of_omnimorph()


def visible_text(page: Path) -> str:
    """Return what a page says, without its figures."""
    text = re.sub(r"<(svg|style).*?</\1>", " ", page.read_text(encoding="utf-8"), flags=re.S)
    text = html.unescape(re.sub(r"<[^>]*>", " ", text))
    return re.sub(r"\s+", " ", text)


# --- words ----------------------------------------------------------------------------------------


def test_conditions_read_as_formulas() -> None:
    assert condition_text(np.array([[1.0, 0, -1, 0], [0, 1.0, 0, -0.5]])) == (
        "f₀ − f₂ or f₁ − 0.5 f₃ not zero"
    )
    assert condition_text(np.eye(12)[11:]) == "f₁₁ not zero"
    assert condition_text(-np.eye(2)[:1]) == "−f₀ not zero"
    assert condition_text(np.empty((0, 4))) == "never"


def test_lost_wrenches_are_named() -> None:
    assert lost_text(np.eye(6)[:, [0, 5]]) == "force along x and torque about z"
    oblique = np.array([[0.6, 0, 0, 0, 0.8, 0]]).T
    assert lost_text(oblique) == "a combination of forces and torques"
    assert lost_text(np.hstack([oblique, np.eye(6)[:, 2:3]])) == (
        "force along z and a combination of forces and torques"
    )


def test_angles_and_intervals_read_well() -> None:
    assert [degrees(math.radians(angle)) for angle in (60.0, -1e-15, -38.177)] == [
        "60°",
        "0°",
        "−38.18°",
    ]
    assert tilt_text(np.zeros(0)) == ""
    assert tilt_text(np.radians([30.0] * 4)) == "30°"
    assert tilt_text(np.radians([30.0, 12.5])) == "(30°, 12.50°)"
    assert intervals_text(np.radians([[1.0, 2.0], [3.0, 3.0]])) == "from 1° to 2° and at 3°"


def test_rows_are_reported_once_with_all_reasons(analysis: VehicleAnalysis) -> None:
    rows = rows_by_tilt(analysis)
    tilts = [float(one.tilt[0]) for one, _ in rows]
    assert tilts == sorted(set(tilts))
    assert {reason for one in analysis.at for reason in one.why.split(", ")} == {
        reason for _, why in rows for reason in why.split(", ")
    }
    assert singular_text(analysis) == "to 4 at 0° and 180°, to 5 at −90° and 90°"


def test_key_points_of_omnimorph(analysis: VehicleAnalysis) -> None:
    points = {
        point.head: point.text.replace("\N{NO-BREAK SPACE}", " ") for point in key_points(analysis)
    }
    assert points["Omnidirectional"].startswith("from 38.18° to 60° at zero moment")
    assert "from 37.00° to 60° with free moments" in points["Omnidirectional"]
    assert "up to 69.73° (zero moment)" in points["Omnidirectional"]
    assert points["Hovering level"].startswith("costs 111.4 W at 0° and 315.1 W at 60°")
    assert "146.4 W at 0° (+31 %)" in points["Wakes:"]
    assert "beyond 30.93° in still air and beyond 40.44°" in points["The tilt mechanism"]


def test_key_points_where_something_is_missing(analysis: VehicleAnalysis) -> None:
    """Where a mechanism never pays, or no tilt within the limits is omnidirectional."""

    def said(changed: VehicleAnalysis, head: str) -> str:
        (text,) = [one.text for one in key_points(changed) if one.head.startswith(head)]
        return text.replace("\N{NO-BREAK SPACE}", " ")

    trade = analysis.trade
    assert trade is not None
    assert trade.own is not None
    share = f"({number(100.0 * trade.own, 3)} % of the mass of the rest)"
    for one, reported in (
        (replace(trade, break_even=None), "at no tilt in still air and beyond 40.44° in the"),
        (replace(trade, break_even_in_wakes=None), "beyond 30.93° in still air and at no tilt in"),
    ):
        text = said(replace(analysis, trade=one), "The tilt mechanism")
        assert text.startswith(share)
        assert reported in text
    unknown = replace(analysis, trade=replace(trade, own=None))
    assert "does not state" in said(unknown, "The tilt mechanism")
    assert "cannot hover level" in said(replace(analysis, trade=None), "The tilt mechanism")

    found = analysis.omnidirectional
    never = replace(analysis, omnidirectional=replace(found, zero_moment=np.empty((0, 2))))
    text = said(never, "Not omnidirectional")
    assert "With free moments it would be from 37.00° to 60°." in text
    ahead = replace(found, zero_moment=np.empty((0, 2)), zero_moment_beyond=np.radians([[65, 70]]))
    text = said(replace(analysis, omnidirectional=ahead), "Not omnidirectional")
    assert "With more travel it would be so from 65° to 70° (zero moment)." in text
    some = replace(found, level=np.radians([[0.0, 50.0]]))
    text = said(replace(analysis, omnidirectional=some), "Hovering level")
    assert "It can do so from 0° to 50° only." in text
    power = analysis.sweep.level_power.copy()
    power[40] = 0.5 * power.min()  # at 20° of 0° to 90°
    dented = replace(analysis, sweep=replace(analysis.sweep, level_power=power))
    text = said(dented, "Hovering level")
    assert f"Near 20° it is cheapest, {number(power[40])} W." in text


def test_the_optimum_named_is_the_one_at_zero_moment(analysis: VehicleAnalysis) -> None:
    """Told apart by exchanging the sets with free moments, whose optimum is then elsewhere."""
    exchanged = [one.force_free for one in reversed(analysis.at)]
    at = [replace(one, force_free=free) for one, free in zip(analysis.at, exchanged, strict=True)]
    by_zero, by_free = (
        max(at[:-1], key=lambda one: getattr(one, which).inscribed_radius)
        for which in ("force_zero", "force_free")
    )
    assert by_zero is not by_free
    (point,) = [one for one in key_points(replace(analysis, at=tuple(at))) if "mnidi" in one.head]
    radius = by_zero.force_zero.inscribed_radius
    text = point.text.replace("\N{NO-BREAK SPACE}", " ")
    assert f"largest at {tilt_text(by_zero.tilt)}: {number(radius)} N" in text
    assert f"({number(100.0 * radius / analysis.weight, 3)} % of the weight)" in text


def test_moments_and_lifts_named_are_those_of_the_analysis(analysis: VehicleAnalysis) -> None:
    points = {point.head: point.text for point in key_points(analysis)}
    moment = analysis.asked.moment
    for axis, name in zip(np.eye(3), "xyz", strict=True):
        reach = number(min(moment.reach(axis), moment.reach(-axis)), 3)
        assert f"{reach}\N{NO-BREAK SPACE}N m about {name}" in points["Moments"]
    inscribed = number(moment.inscribed_radius, 3)
    assert f"About every axis: {inscribed}\N{NO-BREAK SPACE}N m" in points["Moments"]
    heavy = analyze(NOT_MORPHING["too heavy"])
    cannot = {point.head: point.text for point in key_points(heavy)}["Cannot hover level:"]
    lift, weight = number(heavy.asked.force_zero.reach([0.0, 0.0, 1.0])), number(heavy.weight)
    assert re.findall(r"[\d.]+(?=\WN)", cannot) == [lift, weight]


def test_cells_of_the_table_are_the_data(analysis: VehicleAnalysis) -> None:
    table = _tilt_table(analysis)
    reported = {
        tilt_text(np.radians(one["tilt_deg"])): one for one in analysis_data(analysis)["at_tilt"]
    }
    assert set(table.head[1:]) == set(reported)
    rows = {row[0]: row[1:] for row in table.rows}
    for k, tilt in enumerate(table.head[1:]):
        one = reported[tilt]
        free, zero = one["force_free_moment"], one["force_zero_moment"]
        flat = zero["dimension"] < 3
        expected = {
            "rank of A": str(one["rank_thrust"]),
            "rank of F": str(one["rank_full"]),
            "actuation": one["kind"],
            "thrust": one["thrust_kind"],
            "condition number": number(one["condition_number"]),
            "radius with free": "0 (" if flat else number(free["radius_N"]),
            "radius at zero": "0 (" if flat else number(zero["radius_N"]),
            "volume": "0 (" if flat else number(zero["volume_N3"]),
            "largest lift": number(one["largest_lift_N"]),
            "power to hover": number(one["level_hover"]["power_W"]),
            "the same in": number(one["level_hover"]["power_paper"]),
        }
        for words, cell in expected.items():
            (shown,) = [row[k] for head, row in rows.items() if head.startswith(words)]
            assert shown.startswith(cell), (tilt, words)


def test_the_dead_band_is_named_where_there_is_one(analysis: VehicleAnalysis) -> None:
    stiff = OMNIMORPH.replace(dead_band=[2 * math.pi * 30.0] * 8)
    without, named = (
        render_page("ignored.html.j2", **_content(one, {}))
        for one in (analysis, replace(analysis, vehicle=stiff))
    )
    assert "dead band" not in without
    assert "The dead band (rotors cannot turn more slowly than 30 Hz" in named


# --- page -----------------------------------------------------------------------------------------


def check_page(page: Path) -> str:
    """Check what holds for every page; return what it says."""
    text = page.read_text(encoding="utf-8")
    assert not re.search(r"\b(nan|inf|None|Undefined)\b", visible_text(page))
    assert not re.search(r"\{\{|\}\}|\{%|%\}", text)
    assert not re.search(r"<script|<link|<img|<iframe|@import|(src|href)=\"(?!#)", text)
    figures = sorted((page.parent / "figures").iterdir())
    assert {path.suffix for path in figures} == {".svg"}
    assert text.count("<svg") == len(figures)
    for path in figures:
        assert path.stat().st_size < 300_000, path.name
        assert path.read_text(encoding="utf-8").split("\n", 1)[1] in text, path.name
    for name in re.findall(r'href="#([^"]*)"', text):
        assert f'id="{name}"' in text
    return visible_text(page)


def test_the_page_of_omnimorph(analysis: VehicleAnalysis, tmp_path: Path) -> None:
    page = write_analysis_page(analysis, tmp_path)
    text = check_page(page)
    assert {path.stem for path in (page.parent / "figures").iterdir()} == {
        "force_sets",
        "radius_over_tilt",
        "level_hover",
        "hover_map",
        "moments",
        "wakes",
        "mass_break_even",
    }
    assert "f₀ − f₂ − f₄ + f₆ or f₁ − f₃ − f₅ + f₇ not zero" in text
    assert "omnimorph analyze omnimorph --out DIR" in text
    assert f"omnimorph {om.__version__}." in text
    assert "Aboudorra et al., JIRS 2024" in text, "the sources are reported"


@pytest.mark.parametrize("name", list(NOT_MORPHING))
def test_the_page_of_a_vehicle_that_does_not_morph(name: str, tmp_path: Path) -> None:
    vehicle = NOT_MORPHING[name]
    text = check_page(write_analysis_page(analyze(vehicle), tmp_path))
    assert "no servos" in text
    assert not re.search(r"tilt|servo", text.replace("no servos", "").replace("omnimorph", ""))
    assert ("Cannot hover level" in text) == (name in ("too heavy", "one rotor"))
    assert ("Not omnidirectional." in text) == (name != "fixed")
    assert ("rank of A falls" in text) is False
    assert ("force along x and force along y" in text) == (name in ("quadrotor", "too heavy"))
    assert ((tmp_path / "figures" / "moments.svg").exists()) == (name in ("quadrotor", "fixed"))


@pytest.mark.slow
def test_the_page_of_a_vehicle_with_many_servos(tmp_path: Path) -> None:
    hexarotor = build_tilting_hexarotor()
    steps: list[str] = []
    text = check_page(write_analysis_page(analyze(hexarotor), tmp_path, steps.append))
    assert "6 servos (tilt from −20° to 70°, which all reach)" in text
    assert "arm0: f₀ not zero; arm1: f₁ not zero" in text
    assert "all servos are moved together" in text
    assert steps[-1] == "writing the page"
    assert len(steps) == 1 + len(list((tmp_path / "figures").glob("*.svg")))


@pytest.mark.slow
def test_a_tilt_for_each_servo_beyond_the_limits(tmp_path: Path) -> None:
    tilts = np.radians([-5.0, 5.0, -5.0, 5.0, -5.0, 80.0])
    asked = analyze(build_tilting_hexarotor(), tilts, beyond_limits=True)
    text = check_page(write_analysis_page(asked, tmp_path))
    assert "(−5°, 5°, −5°, 5°, −5°, 80°)" in text
    assert "rotors-6.toml --tilt=-5,5,-5,5,-5,80 --beyond-limits --out DIR" in text
