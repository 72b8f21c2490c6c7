"""Where a vehicle cannot push sideways as it would have to, its attitude gives way, no more."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star

import omnimorph as om
from omnimorph.control.capability import lateral_force
from omnimorph.errors import ScenarioError
from omnimorph.model.dynamics import GRAVITY
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.run import Run

OMNIMORPH = om.load_vehicle("omnimorph")
QUADROTOR = build_star(4)
CANTED = build_star(6, cant=math.radians(20.0))
GAINS = om.TrackingGains(position=9.0, velocity=6.0, attitude=100.0, rate=20.0)
WEIGHTS: dict[str, Any] = {
    "W1": 6e-9,
    "W2_position": (3e4, 3e4, 3e4),
    "W2_attitude": (10.0, 10.0, 10.0),
    "W3": 6e-9,
}
THERE_AND_BACK = [
    Segment(2.0, (0.0, 0.0, 0.5)),
    Segment(2.0, (1.0, 0.5, 0.0)),
    Segment(2.0, (-1.0, -0.5, 0.0), (0.0, 0.0, 1.0), math.pi / 2),
    Segment(2.0),
]


def scenario_of(vehicle: om.Vehicle, segments: list[Segment], **changes: Any) -> om.Scenario:
    parts: dict[str, Any] = {
        "name": "sideways",
        "vehicle": vehicle,
        "plant": om.load_plant("perfect"),
        "gains": GAINS,
        "allocator": om.FixedTilt(**WEIGHTS),
        "reference": SegmentReference((0.0, 0.0, 1.0), np.eye(3), segments),
        "attitude_gives_way": True,
    }
    return om.Scenario(**parts | changes)


def lean(run: Run) -> np.ndarray:
    """Angle between body z and the vertical, rad, over time."""
    return np.arccos(np.clip(run.R_WB[:, 2, 2], -1.0, 1.0))


# --- what can be pushed ---------------------------------------------------------------------------


def test_who_pushes_sideways_and_who_need_not_ask() -> None:
    assert lateral_force(QUADROTOR, 0.0) == 0.0
    assert 0.0 < lateral_force(CANTED, 0.0) < math.inf
    assert lateral_force(OMNIMORPH, math.radians(45.0)) == math.inf
    assert lateral_force(OMNIMORPH, 0.0) == 0.0


# --- flights --------------------------------------------------------------------------------------


@pytest.mark.parametrize("plant", ["perfect", "realistic"])
def test_a_quadrotor_follows_a_way_that_is_asked_for_level(plant: str) -> None:
    quadrotor = build_star(4, time_constant_up=0.02, time_constant_down=0.02)
    scenario = scenario_of(quadrotor, THERE_AND_BACK)
    run = om.fly(scenario, plant=plant)
    assert run.outcome is om.Outcome.COMPLETED
    assert run.metrics.position_error_max_m < 0.03
    # it turned about the vertical as it was commanded
    heading = np.arctan2(run.R_WB[-1, 1, 0], run.R_WB[-1, 0, 0])
    assert heading == pytest.approx(math.pi / 2, abs=0.02)
    still = om.fly(replace(scenario, attitude_gives_way=False), plant=plant)
    assert still.metrics.position_error_max_m > 0.5, "level, it cannot"


def test_the_lean_is_that_of_the_trajectory() -> None:
    """Parallel rotors: tan(lean) = |a_xy| / (g + a_z), with the acceleration of the reference."""
    slowly = [Segment(4.0, (2.0, 1.0, 0.5)), Segment(2.0)]
    scenario = scenario_of(QUADROTOR, slowly)
    run = om.fly(scenario)
    sample = scenario.reference.sample(run.time)[:, 18:21]  # type: ignore[attr-defined]
    expected = np.arctan2(np.hypot(sample[:, 0], sample[:, 1]), GRAVITY + sample[:, 2])
    assert expected.max() > 0.08
    off = np.abs(lean(run) - expected)
    assert off.max() < 0.15 * expected.max(), "the jerk jumps where the segment begins"
    settled = (run.time > 2.0) & (run.time < 3.8)
    assert off[settled].max() < 0.02 * expected.max()


def test_it_leans_no_more_than_it_must() -> None:
    """Against a steady side force F: lean = atan(F / m g) − asin(r / |f|), r what it may push."""
    scenario = scenario_of(CANTED, [Segment(6.0)])
    r = scenario.lateral_force
    assert r is not None
    weight = CANTED.mass * GRAVITY
    for F in (0.5 * r, 1.5 * r, 2.5 * r):
        push = om.effects.ConstantWrench(force=(F, 0.0, 0.0))
        run = om.fly(replace(scenario, plant=replace(scenario.plant, effects=(push,))))
        must = math.atan(F / weight) - math.asin(min(r / math.hypot(F, weight), 1.0))
        assert lean(run)[-1] == pytest.approx(max(must, 0.0), abs=2e-3)


def test_a_vehicle_that_can_hold_every_attitude_keeps_it() -> None:
    """OmniMorph at 45°, and Case A, whose servo reaches such tilts: the same to the last bit."""
    for name in ("paper-fixed-45-a", "paper-case-a"):
        scenario = om.load_scenario(name)
        first, second = (
            om.fly(replace(scenario, attitude_gives_way=flag)) for flag in (False, True)
        )
        np.testing.assert_array_equal(first.p_WB, second.p_WB)
        np.testing.assert_array_equal(first.thrust_command, second.thrust_command)


def test_the_controller_stepped_from_python_does_the_same() -> None:
    scenario = scenario_of(QUADROTOR, THERE_AND_BACK)
    controller: Callable[..., om.Command] = scenario.build_controller()
    inside, outside = om.fly(scenario), om.fly(scenario, controller=controller)
    np.testing.assert_array_equal(inside.p_WB, outside.p_WB)


def test_a_file_may_ask_for_it(tmp_path: Path) -> None:
    file = tmp_path / "first.toml"
    text = 'schema = 1\nname = "first"\nbase = "hover"\ncontroller.attitude_gives_way = {}\n'
    file.write_text(text.format("true"))
    scenario = om.load_scenario(file)
    assert scenario.attitude_gives_way
    assert scenario.as_file()["controller"]["attitude_gives_way"] is True
    file.write_text(text.format('"yes"'))
    with pytest.raises(ScenarioError, match='attitude_gives_way is "yes", but it must be true or'):
        om.load_scenario(file)
