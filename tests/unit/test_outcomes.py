"""What a flight is called: numbers that are none, proofs that fail, references not followed."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from tests.unit.test_metrics import resting_run, turns_about

import omnimorph as om
from omnimorph.cli.main import main
from omnimorph.design import vehicle_text
from omnimorph.errors import ScenarioError
from omnimorph.results.run import COLUMNS, Outcome

HOVER = om.load_scenario("hover")
UNKNOWN_FROM_OUTSIDE = {"wrench_asked", "cost", "kkt_residual"}


class Turned:
    """A reference whose attitude is some matrix after half a second."""

    duration = 1.0

    def __init__(self, matrix: Any) -> None:
        self.matrix = np.asarray(matrix, dtype=float)

    def __call__(self, time: float) -> om.Desired:
        still = HOVER.reference(0.0)
        return still if time < 0.5 else still._replace(R_WB=self.matrix)


def mirrored() -> np.ndarray[Any, Any]:
    return np.diag([1.0, 1.0, -1.0])


@pytest.mark.parametrize(
    "matrix",
    [np.zeros((3, 3)), mirrored(), 1.001 * np.eye(3), np.ones((3, 3)), np.diag([1e200, 1.0, 1.0])],
)
def test_an_attitude_that_is_no_rotation_is_refused(matrix: Any) -> None:
    reported = r"attitude of the reference at 0\.5 s is .*, but it must be a rotation matrix"
    with pytest.raises(ScenarioError, match=reported):
        om.fly(HOVER, reference=Turned(matrix))
    start = om.State(np.zeros(3), np.asarray(matrix), np.zeros(3), np.zeros(3))
    with pytest.raises(ScenarioError, match=r"attitude of the start is .* a rotation matrix"):
        om.SimulatedPlant(HOVER.vehicle, HOVER.plant, start=start)


def test_a_rotation_is_flown() -> None:
    run = om.fly(HOVER, reference=Turned(turns_about([0.0, 0.0, 1.0], [0.3])[0]))
    assert run.outcome is Outcome.COMPLETED


@pytest.mark.parametrize("allocator", ["three-candidates", "jointly"])
def test_a_controller_of_the_core_that_overflows_ends_the_flight(allocator: str) -> None:
    scenario = HOVER
    if allocator == "jointly":
        weights = ("W1", "W2_position", "W2_attitude", "W3")
        rule = om.JointTilt(**{name: getattr(HOVER.allocator, name) for name in weights}, W4=0.01)
        scenario = replace(HOVER, allocator=rule)
    flight = om.SteppedFlight(scenario)
    flight.step()
    flight.core.control(np.full(18, np.nan), flight.core.desired())
    flight.core.integrate(flight.control_every, np.zeros(6))
    run = flight.as_run()
    assert run.outcome is Outcome.NOT_FINITE
    assert len(run.time) == flight.control_every + 1
    assert np.isfinite(run.p_WB).all()
    assert not np.isfinite(run.thrust_command[-1]).all()
    flights = om.fly_many(scenario, 5, vary={"noise": np.array([1.0, 1e160, 1.0, 1e160, 1.0])})
    ends = "completed", "not_finite"
    assert flights.metrics.outcome == (ends[0], ends[1], ends[0], ends[1], ends[0])


@pytest.mark.parametrize("name", om.list_scenarios())
def test_a_completed_flight_has_numbers_in_every_column(name: str) -> None:
    run = om.fly(om.load_scenario(name))
    if run.outcome is Outcome.COMPLETED:
        for column in COLUMNS:
            assert np.isfinite(getattr(run, column.name)).all(), column.name
    stepped = om.fly(HOVER, controller=HOVER.build_controller())
    for column in COLUMNS:
        known = np.isfinite(getattr(stepped, column.name)).all()
        assert known == (column.name not in UNKNOWN_FROM_OUTSIDE)


# --- references that were not followed ----------------------------------------------------------


def turned_run(
    degrees: float, gives_way: bool = False, outcome: Outcome = Outcome.COMPLETED
) -> om.Run:
    rows = 2001
    turned = turns_about([1.0, 0.0, 0.0], [math.radians(degrees)] * rows)
    run = resting_run(rows, R_WB=turned, outcome=outcome)
    text = json.dumps({"controller": {"attitude_gives_way": gives_way}, "lost_beyond_m": 0.5})
    return replace(run, provenance=replace(run.provenance, scenario_text=text))


def test_an_attitude_that_was_not_followed_is_reported() -> None:
    far = (
        "The flight was completed, but the attitude was not followed: it was 31° from the reference"
    )
    assert turned_run(31.0).outcome_sentence == f"{far} over the last second."
    plain = "The flight was completed."
    assert turned_run(29.0).outcome_sentence == plain
    assert turned_run(31.0, gives_way=True).outcome_sentence == plain
    lost = turned_run(31.0, outcome=Outcome.LOST)
    assert lost.outcome_sentence == Outcome.LOST.value


def test_a_controller_of_the_user_may_let_the_attitude_give_way() -> None:
    run = turned_run(90.0)
    text = json.dumps({"controller": {"kind": "python", "name": "Mine"}, "lost_beyond_m": 0.5})
    own = replace(run, provenance=replace(run.provenance, scenario_text=text))
    assert own.outcome_sentence == "The flight was completed."


def test_a_short_flight_is_judged_as_a_whole() -> None:
    rows = 301
    turned = turns_about([1.0, 0.0, 0.0], [math.radians(45.0)] * rows)
    run = resting_run(rows, R_WB=turned)
    assert run.outcome_sentence.endswith("it was 45° from the reference throughout the flight.")


def test_a_position_that_was_not_followed_is_reported() -> None:
    run = turned_run(0.0)
    away = replace(run, p_WB=run.p_WB + np.array([0.6, 0.0, 0.0]))
    reported = "The flight was completed, but the position was not followed: it was 0.6 m from the "
    assert away.outcome_sentence == f"{reported}reference over the last second."
    unknown = replace(away, provenance=replace(away.provenance, scenario_text="reported by hand"))
    assert unknown.outcome_sentence == "The flight was completed."


@pytest.mark.parametrize(
    "text",
    [
        '{"controller": 3}',
        '{"controller": [], "events": 3, "lost_beyond_m": "far"}',
        '{"lost_beyond_m": null, "events": ["a push"]}',
        '{"lost_beyond_m": [1.0], "controller": {"attitude_gives_way": "yes"}}',
        '["controller"]',
        "[" * 100_000,
    ],
)
def test_a_scenario_of_another_writer_changes_no_sentence(text: str, tmp_path: Path) -> None:
    run = turned_run(31.0)
    reported = replace(run.provenance, scenario_text=text, vehicle_text=vehicle_text(run.vehicle))
    replace(run, provenance=reported).save(tmp_path / "run.nc")
    assert om.load_run(tmp_path / "run.nc").outcome_sentence == run.outcome_sentence


def test_the_attitude_may_give_way_from_a_change_of_the_controller_on() -> None:
    upside_down = replace(HOVER, reference=Turned(np.diag([1.0, -1.0, -1.0])))
    flight = om.SteppedFlight(upside_down)
    flight.change_controller(replace(upside_down, attitude_gives_way=True))
    while not flight.is_over:
        flight.step()
    assert flight.as_run().metrics.attitude_error_last_second_rad > math.radians(30.0)
    assert flight.as_run().outcome_sentence == Outcome.COMPLETED.value
    assert "was not followed" in om.fly(upside_down).outcome_sentence


IGNORED = """
schema = 1
name = "ignored"
title = "An attitude that weighs next to nothing"
base = "hover"
start_tilt_deg = 0.0
plant = "perfect"

[controller.allocator]
kind = "fixed-tilt"
W1_per_Hz4 = 1e-5
W2_position_s4_per_m2 = [3e4, 3e4, 3e4]
W2_attitude_s4_per_rad2 = [1e-9, 1e-9, 1e-9]
W3_per_Hz4 = 1e-5

[[reference.segment]]
duration_s = 2.0
rotation_axis_W = [1.0, 0.0, 0.0]
rotation_angle_deg = 40.0
"""


def test_the_command_line_tells_it_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("ignored.toml").write_text(IGNORED, encoding="utf-8")
    assert main(["fly", "ignored.toml", "--out", "out"]) == 0
    out, err = capsys.readouterr()
    reported = (
        "but the attitude was not followed: it was 34° from the reference over the last second."
    )
    assert reported in out
    assert reported in err
    with h5py.File("out/run.nc") as file:
        assert reported in file.attrs["outcome_sentence"].decode()


def test_the_command_line_tells_what_is_not_proven(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    flown = om.fly(HOVER)
    residual = np.array(flown.kkt_residual)
    residual[:8] = 0.25
    run = replace(flown, kkt_residual=residual)
    monkeypatch.setattr(om, "fly", lambda *_, **__: run)
    assert main(["fly", "hover", "--out", str(tmp_path / "out")]) == 0
    reported = (
        "hover: 2 control steps are not proven: the KKT residual of their allocation is up to "
    )
    assert capsys.readouterr().err.strip() == f"omnimorph: {reported}2.5e-01."
    assert main(["fly", "hover", "--out", str(tmp_path / "json"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["metrics"]["unproven_steps"] == 2
