"""What is not known, or was not asked for, is shown as "—" and never as 0."""

from __future__ import annotations

import gzip
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import omnimorph as om
from omnimorph.cli.main import main
from omnimorph.report.tables import metrics_table
from omnimorph.results.metrics import MEASURES
from omnimorph.viewer.flight_page import FlightPage, notices, numbers_of
from omnimorph.viewer.frames import Flight
from omnimorph.viewer.server import new_server, stop

HOVER = om.load_scenario("hover")
OLDER = Path(__file__).parent / "older_files" / "run-schema-1.nc.gz"
TILTS = ("tilt_mean_deg", "tilt_min_deg", "tilt_max_deg")
RESIDUALS = ("kkt_residual_max", "unproven_steps")


def half_of_the_weight(time: float, state: om.State, desired: om.Desired) -> om.Command:
    """Give thrusts without a wrench in mind: the vehicle falls."""
    return om.Command(np.full(8, 0.5 * 1.315 * 9.81 / 8.0), np.zeros(1))


@pytest.fixture(scope="module")
def own() -> om.Run:
    """A flight with a controller that allocates by itself, so that nobody asks for a wrench."""
    return om.fly(HOVER, controller=half_of_the_weight)


def shown(run: om.Run, row: int) -> dict[str, str]:
    """Return the numbers beside the picture of a flight."""
    flight = Flight(run, "hover")
    return {one.key: one.values[0] for one in numbers_of([flight], [flight.frame(row)])}


def test_a_wrench_that_nobody_asked_for_is_not_missed(own: om.Run) -> None:
    assert np.isnan(own.wrench_asked).all()
    assert np.isnan(own.cost).all()
    numbers = shown(own, 100)
    assert numbers["missed-force"] == "—"
    assert numbers["largest-thrust"] == f"{np.abs(own.thrust_actual[100]).max():.3f}"
    flight = Flight(own, "hover")
    assert np.isnan(flight.frame(100).missed_W).all()
    assert "not achieved" not in notices([flight], [flight.frame(100)])


def test_a_wrench_that_was_asked_for_is_compared_with_the_one_made() -> None:
    run = om.fly(HOVER)
    missed = np.linalg.norm(run.wrench_asked[500, :3] - run.wrench_achieved[500, :3])
    assert shown(run, 500)["missed-force"] == f"{missed:.3f}" != "0.000"


def test_the_scene_of_a_flight_without_a_wish_shows_no_missed_force(own: om.Run) -> None:
    server = new_server()
    try:
        page = FlightPage(server, [Flight(own, "own")])
        page.playback.move_to(0.2)
        page._show()
        missed = page.scene.actors[0]._missed
        assert not missed.visible
        assert "—" in page._numbers.content
    finally:
        stop(server)


def test_a_controller_that_fails_at_once_leaves_no_wish() -> None:
    run = om.fly(HOVER, controller=lambda *_: om.Command(np.full(8, np.nan), np.zeros(1)))
    assert len(run.time) == 1
    for column in (run.wrench_asked, run.cost, run.kkt_residual):
        assert np.isnan(column).all()


def test_an_older_run_shows_no_thrust_that_it_did_not_record(tmp_path: Path) -> None:
    (tmp_path / "older.nc").write_bytes(gzip.decompress(OLDER.read_bytes()))
    run = om.load_run(tmp_path / "older.nc")
    numbers = shown(run, 4)
    assert numbers["largest-thrust"] == "—"
    assert numbers["fastest-rotor"] == f"{np.abs(run.speed[4]).max() / (2.0 * np.pi):.2f}"


def test_metrics_that_do_not_apply_are_no_numbers(own: om.Run) -> None:
    quadrotor = om.fly(om.load_scenario("tour").for_vehicle(om.load_vehicle("quadrotor")))
    batch = om.fly_many(om.load_scenario("tour").for_vehicle(om.load_vehicle("quadrotor")), 1)
    for metrics, names in (
        (quadrotor.metrics, TILTS),
        (batch.metrics[0], TILTS),
        (own.metrics, RESIDUALS),
    ):
        table = {row[0]: row[1] for row in metrics_table("", {"one": metrics}).rows}
        for name in names:
            assert metrics.as_dict()[name] is None
            assert table[MEASURES[name].label] == "—"
    known = replace(quadrotor.metrics, outcome="completed").as_dict()
    assert known["unproven_steps"] == 0


def test_the_command_line_shows_no_tilt_of_a_quadrotor(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = str(tmp_path / "out")
    assert main(["fly", "tour", "--vehicle", "quadrotor", "--out", out]) == 0
    lines = capsys.readouterr().out.splitlines()
    reported = {
        words: line for line in lines for words in ("tilt, mean",) if line.startswith(words)
    }
    assert reported["tilt, mean"].split()[-2:] == ["—", "°"]
    kept = json.loads((tmp_path / "out" / "metrics.json").read_text(encoding="utf-8"))
    assert [kept[name] for name in TILTS] == [None] * 3
