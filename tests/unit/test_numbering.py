"""Rotors and servos are numbered from 0, as in arrays and PX4, wherever someone reads a number."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.unit.reproduction_parts import table
from tests.visitor import Visitor, wait_until

import omnimorph as om
from omnimorph.cli.main import main
from omnimorph.design.new_vehicle import KINDS, new_vehicle_text
from omnimorph.live.page import LivePage
from omnimorph.report import figures, style
from omnimorph.studies.reproduction.figures.frontier import frontier
from omnimorph.studies.reproduction.lost_thrust import Share
from omnimorph.viewer.charts import charts_of
from omnimorph.viewer.flight_page import notices
from omnimorph.viewer.frames import Flight
from omnimorph.viewer.server import address_of, new_server, stop

ROOT = Path(__file__).parents[2]
HOVER = om.load_scenario("hover")
NUMBERS = [str(i) for i in range(8)]
SOURCES = [
    path
    for room, kinds in (("src", ("*.py", "*.j2", "*.toml", "*.js")), ("examples", ("*.py",)))
    for kind in kinds
    for path in sorted((ROOT / room).rglob(kind))
]
TEXTS = [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md", *SOURCES]


@pytest.fixture(scope="module")
def run() -> om.Run:
    return om.fly(HOVER, seed=1)


def test_a_panel_shows_the_speed_of_the_rotor_it_names(run: om.Run) -> None:
    figure = figures.rotor_speeds([style.Flight("one", run, style.LineStyle(style.BLUE))])
    reported = {panel.get_title(loc="left").split("  ")[0]: panel for panel in figure.axes}
    assert sorted(reported) == [f"rotor {i}" for i in NUMBERS]
    for i in range(8):
        shown = np.asarray(reported[f"rotor {i}"].lines[0].get_ydata(), dtype=np.float64)
        assert shown.max() == pytest.approx(run.speed[:, i].max() / (2.0 * np.pi), rel=1e-12)


def test_curves_and_notices_of_a_page_name_the_rotors_they_mean(run: om.Run) -> None:
    flight = Flight(run, "hover")
    (speeds,) = (chart for chart in charts_of([flight]) if chart.title.startswith("rotor speeds"))
    assert [word for word, _ in speeds.key] == [*NUMBERS, "dotted: limits"]
    for i, curve in enumerate(speeds.curves):
        assert curve.label == f"hover rotor {i}"
        np.testing.assert_array_equal(curve.values, run.speed[:, i] / (2.0 * np.pi))
    for i in range(8):
        frame = flight.frame(100)._replace(active=np.eye(8)[i])
        assert f"at the limit: rotor {i}<" in notices([flight], [frame])


def test_the_rotor_that_is_named_is_cut() -> None:
    server = new_server()
    try:
        page = LivePage(server, HOVER)
        with Visitor(address_of(server)) as visitor:
            visitor.look()
            controls = [one for one in visitor.shown() if "label" in one.get("props", {})]
            shown = {one["props"]["label"]: one for one in controls}
            assert shown["rotor"]["props"]["options"] == [f"rotor {i}" for i in NUMBERS]
            visitor.set(shown["rotor"]["uuid"], "rotor 2")
            visitor.set(shown["Cut its thrust"]["uuid"], True)
            wait_until(lambda: page.flight.notes.get("events"))
        page.pilot.advance(0.1)
        page.show()
        assert "without thrust: rotor 2<" in page._done_to_it()
        thrust = page.flight.columns["thrust_actual"][page.flight.row]
    finally:
        stop(server)
    assert np.flatnonzero(thrust == 0.0).tolist() == [2]


def test_tables_of_the_reproduction_number_the_rotors() -> None:
    found: Any = SimpleNamespace(dead={("paper-case-a", "kept"): [(1, 5)] * 8})
    assert table("dead", found).head == ["", *(f"rotor {i}" for i in NUMBERS)]


def test_figures_of_the_reproduction_number_the_rotors() -> None:
    shares = {("paper-case-a", "kept"): [Share(1, 5)] * 8}
    found: Any = SimpleNamespace(frontiers=[], dead=shares)
    dead = frontier(found).axes[-1]
    assert [f"{tick:g}" for tick in dead.get_xticks()] == NUMBERS


def test_the_table_of_a_vehicle_numbers_its_rotors(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["vehicles", "omnimorph"]) == 0
    lines = capsys.readouterr().out.splitlines()
    head = next(k for k, line in enumerate(lines) if line.split()[:1] == ["rotor"])
    assert [line.split()[0] for line in lines[head + 2 : head + 10]] == NUMBERS


@pytest.mark.parametrize("name", [*om.list_vehicles(), *KINDS])
def test_a_number_in_the_name_of_a_servo_is_its_own(name: str) -> None:
    if name in KINDS:
        text = new_vehicle_text("mine", 6, name)
        servos = [one["name"] for one in tomllib.loads(text).get("servo", [])]
    else:
        servos = list(om.load_vehicle(name).servo_name)
    for j, servo in enumerate(servos):
        digits = re.search(r"\d+$", servo)
        assert digits is None or int(digits.group()) == j


def test_nothing_numbers_rotors_from_one() -> None:
    """Neither by an index and one more, nor by a number that only the paper has."""
    one_more = r"(?i:rotor|servo|motor|arm)s?[ _]?\{{1,2} ?[^{}]*(\+ ?1|loop\.index) ?\}"
    by_number = r"\b(?<!paper's )rotors? (\d+)(?: and (\d+))?"
    found = []
    for path in TEXTS:
        text = path.read_text(encoding="utf-8")
        reported = [*re.finditer(one_more, text), *re.finditer(by_number, text)]
        found += [
            f"{path.name}: {one.group()}"
            for one in reported
            if re.search(r"1 ?\}|[89]", one.group())
        ]
    assert len(TEXTS) > 250
    assert found == []
