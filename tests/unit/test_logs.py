"""Logs of one's own become columns of the run and of its file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.unit.own_objects import SHORT, Counting, Lagging, differing

import omnimorph as om


def test_what_is_logged_is_held_until_the_next(tmp_path: Path) -> None:
    flight = om.SteppedFlight(SHORT)
    flight.step()
    flight.log("battery", 16.0, unit="V")
    flight.step()
    flight.step()
    flight.log("battery", 15.0, unit="V")
    flight.log("gain", np.eye(2))
    flight.step()
    run = flight.as_run()
    battery = [np.nan] * 4 + [16.0] * 8 + [15.0] * 4
    np.testing.assert_array_equal(run["battery"], battery)
    assert run.logged["battery"].unit == "V"
    np.testing.assert_array_equal(run["gain"][-1], np.eye(2))
    assert np.isnan(run["gain"][:12]).all()
    run.save(tmp_path / "run.nc")
    again = om.load_run(tmp_path / "run.nc")
    assert differing(again, run) == []
    assert again.logged["battery"].unit == "V"
    assert again.content_hash == run.content_hash


def test_what_parts_return_beside_is_logged() -> None:
    run = om.fly(SHORT, controller=Counting(SHORT), estimator=Lagging(SHORT))
    rows = np.arange(200)
    np.testing.assert_array_equal(run["calls"][:-1], rows // 4 + 1)
    np.testing.assert_allclose(run["lift"], run.thrust_command.sum(axis=1), rtol=1e-15)
    assert {name: one.unit for name, one in run.logged.items()} == {
        "calls": "1",
        "lift": "N",
        "lag": "m",
        "previous": "1",
    }
    assert run["lag"].shape == (201, 3)
    np.testing.assert_array_equal(run["previous"][4:200], run.thrust_command[:196])


@pytest.mark.parametrize(
    ("name", "value", "unit", "said"),
    [
        ("battery", [16.0, 15.0], "V", r"shape of log battery is .*\(\), as in the control"),
        ("battery", 16.0, "mV", "unit of log battery is .* V, as before"),
        ("other", "full", "V", "log other is .*full.* number"),
        ("other", [[1.0], [1.0, 2.0]], "V", "log other is .* number"),
        ("other", [], "V", r"log other is \[\].* number"),
        ("other", 1.0, "<b>", "unit"),
        ("p_WB", 1.0, "m", "name that a run does not have"),
        ("metrics", 1.0, "m", "name that a run does not have"),
        ("rotor", 1.0, "m", "name that a run does not have"),
        ("../x", 1.0, "m", "letters"),
        (3, 1.0, "m", "letters"),
    ],
)
def test_what_cannot_be_logged_is_refused(name: Any, value: Any, unit: str, said: str) -> None:
    flight = om.SteppedFlight(SHORT)
    flight.log("battery", 16.0, unit="V")
    flight.step()
    with pytest.raises(om.InputError, match=said):
        flight.log(name, value, unit=unit)
    flight.step()
    assert list(flight.as_run().logged) == ["battery"]


def test_a_log_that_changes_its_shape_ends_the_flight_which_is_kept() -> None:
    def growing(time: float, state: om.State, desired: om.Desired) -> om.Command:
        log = {"growing": np.zeros(2 if time < 0.1 else 3)}
        return om.Command(np.full(8, 1.6), np.zeros(1), log=log)

    run = om.fly(SHORT, controller=growing)
    assert run.outcome is om.Outcome.PART_FAILED
    assert len(run.time) == 101
    assert "shape of log growing is (3,)" in run.outcome_sentence
    assert run["growing"].shape == (101, 2)


def test_what_a_command_by_hand_holds_beside_is_logged() -> None:
    flight = om.SteppedFlight(SHORT)
    command = om.Command(np.full(8, 1.6), np.zeros(1), log={"throttle": (0.5, "%")})
    flight.step(command=command)
    throttle = flight.as_run().logged["throttle"]
    assert (throttle.values.tolist(), throttle.unit) == ([0.5] * 4, "%")


def test_what_sensors_want_recorded_is_logged() -> None:
    def seen(time: float, state: om.State) -> om.State:
        return om.Estimate(*state, log={"seen": (state.p_WB, "m")})

    run = om.fly(SHORT, sensors=seen)
    np.testing.assert_array_equal(run["seen"][:200:4], run.p_WB[:200:4])


def test_a_run_without_logs_has_none() -> None:
    assert om.fly(SHORT).logged == {}
