"""What docs/own-parts.md, and docs/extending.md of Python, show works as they say."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import omnimorph as om

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "own-parts.md").read_text(encoding="utf-8")
PYTHON = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
[SCENARIO] = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
MODULE = """
import omnimorph as om


class MyController:
    def __init__(self, scenario, stiffness):
        self.stiffness, self.paper = stiffness, om.load_scenario("paper-case-a").build_controller()

    def __call__(self, time, state, desired):
        return self.paper(time, state, desired)


class MyEstimator:
    def __init__(self, scenario):
        self.vehicle = scenario.vehicle

    def __call__(self, time, measured, previous):
        return measured
"""


def test_the_controller_that_the_page_shows_holds_its_place() -> None:
    names: dict[str, Any] = {}
    exec(PYTHON[0], names)
    run = names["run"]
    assert run.outcome is om.Outcome.COMPLETED
    assert run["force"].shape == (len(run.time), 3)
    assert run.logged["force"].unit == "N"
    assert run.metrics.position_error_last_second_m < 0.02
    np.testing.assert_allclose(run.wrench_asked[0, 2], 1.315 * 9.81, rtol=0.02)  # noise


def test_a_flight_is_stepped_logged_and_branched_as_the_page_shows() -> None:
    names: dict[str, Any] = {"om": om, "np": np}
    exec(PYTHON[1], names)
    run = names["run"]
    assert run["battery"][-1] == 16.2
    assert names["flight"].row == 15
    assert len(run.time) == 5001


def test_the_scenario_that_the_page_shows_flies(tmp_path: Path) -> None:
    (tmp_path / "my_module.py").write_text(MODULE, encoding="utf-8")
    file = tmp_path / "mine.toml"
    file.write_text(SCENARIO, encoding="utf-8")
    scenario = om.load_scenario(file, allow_code=True)
    flight = om.SteppedFlight(scenario)
    for _ in range(5):
        flight.step()
    assert flight.as_run().provenance.scenario["controller"]["options"] == {"stiffness": 30.0}


def test_each_addition_of_the_page_on_extending_flies_in_python() -> None:
    page = (DOCS / "extending.md").read_text(encoding="utf-8")
    [block] = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names: dict[str, Any] = {}
    exec(block, names)
    run, vehicle = names["run"], names["vehicle"]
    assert run.outcome is om.Outcome.COMPLETED
    assert run.p_WB[-1, 0] == pytest.approx(-0.01, abs=1e-4)  # the bias of the sensor
    assert run["v_filtered"].shape == (len(run.time), 3)
    assert names["largest_speed"](run) == np.linalg.norm(run["v_filtered"], axis=1).max()
    assert run.thrust_command.max() <= 0.8 * vehicle.thrust_max.min()
    exact = run.provenance.plant_name, run.provenance.scenario["disturbance"]["name"]
    assert exact == ("Resolution", "body_drag")
    engine = names["Resolution"](vehicle, om.load_plant("perfect"))
    engine.send(om.Command(np.full(8, 1.7), np.zeros(1)))
    engine.step_physics(1)
    turns = engine.speed / np.pi
    np.testing.assert_allclose(turns, np.round(turns), rtol=0.0, atol=1e-9)
