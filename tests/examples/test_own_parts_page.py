"""What docs/own-parts.md shows works as it says."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any

import numpy as np

import omnimorph as om

PAGE = (Path(__file__).parents[2] / "docs" / "own-parts.md").read_text(encoding="utf-8")
PYTHON = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
[SCENARIO] = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
MODULE = """
class MyController:
    def __init__(self, scenario, stiffness):
        self.stiffness, self.paper = stiffness, scenario.build_controller()

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
    names: dict[str, Any] = {"om": om, "np": np, "copy": copy}
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
