"""Engines of one's own fly: behind a wall to the last bit; what is wrong with one is noticed."""

from __future__ import annotations

import re
import runpy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.physics.golden_effects import EVERYTHING
from tests.unit.own_objects import SHORT, Counting, Wall, differing, wall

import omnimorph as om
from omnimorph.protocols import FloatArray, Plant
from omnimorph.reference.segments import Segment, SegmentReference

EXAMPLES = Path(__file__).parents[2] / "examples"
RIGID_BODY: Any = runpy.run_path(str(EXAMPLES / "06_every_part_of_your_own.py"))["RigidBody"]
ALL_EFFECTS = replace(SHORT.plant, effects=EVERYTHING)


def blowing(time: float, state: om.State) -> FloatArray:
    """A disturbance that depends on all that it may."""
    return np.array([np.sin(9.0 * time), 0.3, -state.v_WB[2], 0.0, 0.01 * state.w_WB_B[1], 0.0])


@pytest.mark.parametrize(
    ("scenario", "parts"),
    [
        (SHORT, {}),
        (replace(SHORT, plant=om.load_plant("perfect")), {"seed": 2}),
        (replace(SHORT, plant=ALL_EFFECTS), {"seed": 2**64 - 1, "flight": 7}),
        (replace(SHORT, plant=replace(ALL_EFFECTS, integrator="runge-kutta-4")), {"flight": 1}),
        (SHORT, {"disturbance": blowing}),
        (SHORT, {"controller": Counting(SHORT)}),
    ],
    ids=["realistic", "perfect", "every effect", "runge-kutta", "disturbed", "own controller"],
)
def test_a_plant_behind_a_wall_flies_the_same_to_the_last_bit(
    scenario: om.Scenario, parts: dict[str, Any]
) -> None:
    if "controller" in parts:
        alone = om.fly(scenario, controller=Counting(scenario))
    else:
        alone = om.fly(scenario, **parts)
    engine: Plant = wall(scenario)
    behind = om.fly(scenario, plant=engine, **parts)
    assert behind.outcome is alone.outcome is om.Outcome.COMPLETED
    assert differing(behind, alone) == []


def test_a_run_names_the_plant_that_flew(tmp_path: Path) -> None:
    om.fly(SHORT, plant=wall()).save(tmp_path / "run.nc")
    assert om.load_run(tmp_path / "run.nc").provenance.plant_name == "Wall"


def test_a_flight_in_an_engine_can_be_pushed_step_by_step() -> None:
    push = np.array([5.0, 0.0, -2.0, 0.0, 0.1, 0.0])
    own = replace(SHORT, own=replace(SHORT.own, plant=wall()))
    flights = om.SteppedFlight(SHORT, seed=4), om.SteppedFlight(own, seed=4)
    for flight in flights:
        for k in range(40):
            flight.step(push if 10 <= k < 20 else np.zeros(6))
    assert differing(*(flight.as_run() for flight in flights)) == []
    assert np.ptp(flights[0].as_run().v_WB[:, 0]) > 0.1
    np.testing.assert_array_equal(flights[0].state.acceleration, flights[1].state.acceleration)


class Steered(Wall):
    """A wall whose answers can be spoilt from a physics step on."""

    def __init__(self, spoil: Any, after: int = 60) -> None:
        super().__init__(SHORT.vehicle, SHORT.plant)
        self.spoil, self.after, self.steps = spoil, after, 0

    def step_physics(self, steps: int, push: FloatArray) -> None:
        super().step_physics(steps, push)
        self.steps += steps

    def __getattribute__(self, name: str) -> Any:
        answer = super().__getattribute__(name)
        if name.startswith("_") or name in ("steps", "after", "spoil"):
            return answer
        return self.spoil(name, answer) if self.steps >= self.after else answer


def of(what: str, change: Any) -> Any:
    return lambda name, answer: change(answer) if name == what else answer


def nan_in(array: FloatArray) -> FloatArray:
    return np.where(np.arange(array.size).reshape(array.shape) == 0, np.nan, array)


@pytest.mark.parametrize(
    ("what", "change"),
    [
        ("motion", lambda state: state._replace(p_WB=nan_in(state.p_WB))),
        ("motion", lambda state: state._replace(R_WB=nan_in(state.R_WB))),
        ("speed", nan_in),
        ("tilt", nan_in),
        ("wrench", lambda wrench: wrench * np.inf),
    ],
    ids=["position", "attitude", "speed", "tilt", "wrench"],
)
def test_what_is_not_finite_ends_the_flight_and_keeps_it(what: str, change: Any) -> None:
    run = om.fly(SHORT, plant=Steered(of(what, change)))
    assert run.outcome is om.Outcome.DIVERGED
    assert len(run.time) == 61
    assert np.isfinite(run.p_WB[:-1]).all()
    assert np.isfinite(run.speed[:-1]).all()
    assert run.metrics.duration_s > 0.05


def raises(answer: Any) -> Any:
    raise ArithmeticError("the solver gave up")


@pytest.mark.parametrize(
    ("what", "change", "said"),
    [
        ("motion", lambda state: state[:3], "cannot be flown"),
        ("motion", lambda _: None, "cannot be flown"),
        ("speed", lambda speed: speed[:7], "the speed has 7 numbers, not 8"),
        ("tilt", lambda tilt: "up", "cannot be flown"),
        ("wrench", lambda wrench: [10**400] * 6, "cannot be flown"),
        ("speed", raises, r"ArithmeticError: the solver gave up \(test_engines.py:\d+\)"),
        ("physics_step", lambda step: 2.0 * step, r"steps in seconds is \(0.002, 0.004\)"),
        ("control_period", lambda period: None, "control_period is None"),
    ],
    ids=["three parts", "none", "shape", "text", "huge", "raises", "other step", "no period"],
)
def test_an_engine_that_fails_on_the_way_ends_the_flight_which_is_kept(
    what: str, change: Any, said: str
) -> None:
    engine = Steered(of(what, change))
    run = om.fly(SHORT, plant=engine)
    assert run.outcome is om.Outcome.PART_FAILED
    assert 60 <= len(run.time) <= 64
    assert differing_rows(run, om.fly(SHORT), len(run.time) - 1) == []
    [failure] = run.provenance.scenario["events"]
    assert failure["part"] == "plant Steered"
    assert failure["time_s"] == pytest.approx(0.06, abs=0.004)
    assert re.search(said, run.outcome_sentence)
    assert "plant Steered failed" in run.outcome_sentence


def differing_rows(run: om.Run, other: om.Run, rows: int) -> list[str]:
    names = ("p_WB", "R_WB", "speed", "thrust_command", "tilt_actual", "wrench_asked")
    return [name for name in names if not np.array_equal(run[name][:rows], other[name][:rows])]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (of("physics_step", lambda _: 0.0), "physics_step is 0.0.*positive number"),
        (of("physics_step", lambda _: 0.003), "control_period_ms"),
        (of("control_period", lambda _: "fast"), "control_period is .*fast"),
        (of("speed", lambda speed: speed[:3]), "the speed has 3 numbers"),
    ],
)
def test_an_engine_that_cannot_fly_at_all_is_refused(change: Any, said: str) -> None:
    with pytest.raises(om.InputError, match=said):
        om.fly(SHORT, plant=Steered(change, after=0))


def test_what_is_no_plant_is_refused_with_what_it_lacks() -> None:
    class Lifeless:
        physics_step = control_period = 1e-3

        def send(self, command: om.Command) -> None: ...

    class Numb(Lifeless):
        def reset(self, *_: object) -> None: ...

        def step_physics(self, *_: object) -> None: ...

    lifeless: Any = Lifeless()
    numb: Any = Numb()
    with pytest.raises(om.InputError, match="that has motion, speed, tilt, wrench"):
        om.fly(SHORT, plant=numb)
    with pytest.raises(om.InputError, match="that has reset, step_physics"):
        om.fly(SHORT, plant=lifeless)


def test_an_engine_may_say_its_thrust_and_its_acceleration() -> None:
    class Saying(Wall):
        thrust = np.arange(8.0)
        acceleration = np.arange(6.0)

    seen: list[Any] = []

    def watching(time: float, state: om.State) -> FloatArray:
        seen.append(state.acceleration)
        return np.zeros(6)

    run = om.fly(SHORT, plant=Saying(SHORT.vehicle, SHORT.plant), disturbance=watching)
    np.testing.assert_array_equal(run.thrust_actual, np.tile(np.arange(8.0), (len(run.time), 1)))
    np.testing.assert_array_equal(seen[-1], np.arange(6.0))


def test_a_rigid_body_in_numpy_flies_as_the_core_does() -> None:
    way = Segment(0.2, (0.01, 0.0, 0.02), (0.0, 0.6, 0.8), 0.1)
    turning = SegmentReference((0.0, 0.0, 1.0), np.eye(3), [way])
    perfect = replace(SHORT, plant=om.load_plant("perfect"), reference=turning)
    engine = RIGID_BODY(perfect.vehicle)
    engine.physics_step, engine.control_period, engine.drag = 5e-4, 2e-3, 0.0
    own = om.fly(perfect, plant=engine)
    steps = replace(perfect.plant, physics_step=5e-4, control_period=2e-3)
    core = om.fly(replace(perfect, plant=steps))
    assert own.outcome is om.Outcome.COMPLETED
    assert own.provenance.physics_step == 5e-4
    assert len(own.time) == len(core.time) == 401
    np.testing.assert_allclose(own.p_WB, core.p_WB, rtol=0.0, atol=2e-6)
    np.testing.assert_allclose(own.R_WB, core.R_WB, rtol=0.0, atol=2e-5)
    assert abs(own.R_WB[-1] - np.eye(3)).max() > 0.05
    assert own.provenance.scenario["engine"] == {"kind": "python", "name": "RigidBody"}
