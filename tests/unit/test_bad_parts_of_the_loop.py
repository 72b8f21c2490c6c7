"""Parts of the loop that answer badly: the flight ends and keeps its rows, or one says why."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import omnimorph as om
from omnimorph.protocols import FloatArray
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.simulation.scenario import Scenario

DURATION = 0.6  # s


def short_scenario() -> Scenario:
    """Case B on a short way that needs the tilt."""
    way = Segment(DURATION, (0.1, -0.1, 0.1), (0.0, 0.6, 0.8), 0.3)
    reference = SegmentReference((0.0, 0.0, 1.0), np.eye(3), [way])
    return replace(om.load_scenario("paper-case-b"), reference=reference)


class Standing:
    """A reference in Python: it stays where it is."""

    duration = DURATION

    def __call__(self, time: float) -> om.Desired:
        zero = np.zeros(3)
        return om.Desired(np.array([0.0, 0.0, 1.0]), np.eye(3), zero, zero, zero, zero)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("part", ["thrust", "tilt"])
def test_a_number_that_is_not_finite_ends_the_flight_and_keeps_it(part: str, bad: float) -> None:
    scenario = short_scenario()
    controller = scenario.build_controller()

    def fails(time: float, state: om.State, desired: om.Desired) -> om.Command:
        command = controller(time, state, desired)
        if time < 0.2 - 1e-9:
            return command
        return command._replace(**{part: np.full_like(getattr(command, part), bad)})

    run = om.fly(scenario, seed=1, controller=fails)
    assert run.outcome is om.Outcome.NOT_FINITE
    assert len(run.time) == 201  # the last row: where it was when the controller failed
    reported = om.fly(scenario, seed=1)
    np.testing.assert_allclose(run.p_WB, reported.p_WB[:201], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(run.speed, reported.speed[:201], rtol=0.0, atol=1e-5)
    np.testing.assert_allclose(
        run.thrust_command[:-1], reported.thrust_command[:200], rtol=0.0, atol=1e-8
    )
    np.testing.assert_array_equal(run.thrust_command[-1], run.thrust_command[-2])
    assert run.metrics.position_error_max_m < 0.1


def test_an_allocator_that_fails_at_once_leaves_a_run_of_one_row() -> None:
    def fails(acceleration: FloatArray, state: om.State, previous: om.Command) -> om.Command:
        return om.Command(np.full(8, np.nan), previous.tilt)

    run = om.fly(short_scenario(), allocator=fails)
    assert run.outcome is om.Outcome.NOT_FINITE
    assert len(run.time) == 1
    np.testing.assert_array_equal(run.p_WB, [[0.0, 0.0, 1.0]])
    np.testing.assert_array_equal(run.R_WB, [np.eye(3)])
    np.testing.assert_allclose(run.thrust_command, 1.315 * 9.81 / 8.0, rtol=1e-14)
    np.testing.assert_array_equal(run.tilt_actual, [[0.0]])


def test_a_controller_that_gives_up_loses_the_vehicle() -> None:
    def falls(time: float, state: om.State, desired: om.Desired) -> om.Command:
        return om.Command(np.zeros(8), np.zeros(1))

    scenario = om.load_scenario("hover")
    run = om.fly(scenario, controller=falls)
    assert run.outcome is om.Outcome.LOST
    assert run.time[-1] == pytest.approx(np.sqrt(2.0 * scenario.lost_beyond / 9.81), abs=0.05)
    error = np.linalg.norm(run.p_WB - run.desired_p_WB, axis=1)
    assert error[-1] > scenario.lost_beyond >= error[:-1].max()


@pytest.mark.parametrize(
    ("thrust", "tilt"),
    [
        (np.zeros(7), np.zeros(1)),
        (np.zeros(8), np.zeros(2)),
        (np.float64(1.0), np.zeros(1)),
    ],
    ids=["too few thrusts", "too many tilts", "one number"],
)
def test_a_command_of_the_wrong_shape_is_the_users_mistake(
    thrust: FloatArray, tilt: FloatArray
) -> None:
    with pytest.raises(om.InputError, match="command"):
        om.fly(short_scenario(), controller=lambda *_: om.Command(thrust, tilt))


@pytest.mark.parametrize(
    "answer", [None, 1.0, (np.zeros(8),), ("full", "up"), ([10**400] * 8, [0])]
)
def test_an_answer_that_is_no_command_is_the_users_mistake(answer: object) -> None:
    with pytest.raises(om.InputError, match="command"):
        om.fly(short_scenario(), controller=lambda *_: answer)  # type: ignore[arg-type]


@pytest.mark.parametrize("push", [np.zeros(3), np.zeros((6, 1)), None, "hard", [10**400] * 6])
def test_a_disturbance_that_is_no_wrench_is_the_users_mistake(push: object) -> None:
    with pytest.raises(om.InputError, match="disturbance"):
        om.fly(short_scenario(), disturbance=lambda *_: push)  # type: ignore[arg-type]


def test_a_disturbance_that_is_not_finite_ends_the_flight_and_keeps_it() -> None:
    def blows(time: float, state: om.State) -> FloatArray:
        return np.full(6, np.nan if time > 0.1 - 1e-9 else 0.0)

    run = om.fly(short_scenario(), disturbance=blows)
    assert run.outcome is om.Outcome.DIVERGED
    assert len(run.time) == 102
    assert np.isfinite(run.p_WB[:-1]).all()


@pytest.mark.parametrize("point", [None, 1.0, (np.zeros(3), np.eye(3)), ("here",) * 6])
def test_a_reference_that_gives_no_motion_is_the_users_mistake(point: object) -> None:
    class Broken(Standing):
        def __call__(self, time: float) -> om.Desired:
            return super().__call__(time) if time < 0.3 else point  # type: ignore[return-value]

    with pytest.raises(om.InputError, match="reference"):
        om.fly(short_scenario(), reference=Broken())


@pytest.mark.parametrize(
    "duration", [0.0, -1.0, np.nan, np.inf, None, "long", 1j, np.ones(2), 10**400]
)
def test_a_reference_without_a_duration_is_the_users_mistake(duration: Any) -> None:
    way = Standing()
    way.duration = duration
    with pytest.raises(om.InputError, match="duration"):
        om.fly(short_scenario(), reference=way)


@pytest.mark.parametrize("rows", [None, "all", np.zeros((2, 24)), np.zeros((601, 7))])
def test_samples_that_are_no_motion_are_the_users_mistake(rows: object) -> None:
    class Sampled(Standing):
        def sample(self, times: FloatArray) -> object:
            return rows

    with pytest.raises(om.InputError, match=r"shape of its samples is .*\(601, 24\)"):
        om.fly(short_scenario(), reference=Sampled())


@pytest.mark.parametrize(("seed", "flight"), [(-1, 0), (2**64, 0), (0, -1), (0, 2**32), (0.5, 0)])
def test_seed_and_flight_are_numbers_of_a_known_size(seed: int, flight: int) -> None:
    with pytest.raises(om.InputError, match=r"seed|flight"):
        om.fly(short_scenario(), seed=seed, flight=flight)


def test_a_reference_that_is_not_finite_is_the_users_mistake() -> None:
    class Broken(Standing):
        def __call__(self, time: float) -> om.Desired:
            desired = super().__call__(time)
            return desired._replace(p_WB=np.full(3, np.nan)) if time > 0.3 else desired

    with pytest.raises(om.InputError, match="reference"):
        om.fly(short_scenario(), reference=Broken())


def test_a_controller_and_an_allocator_are_refused_together() -> None:
    scenario = short_scenario()
    controller = scenario.build_controller()
    with pytest.raises(om.InputError, match="not both"):
        om.fly(
            scenario,
            controller=controller,
            allocator=lambda acceleration, state, previous: previous,
        )
    with pytest.raises(om.InputError, match="not both"):
        om.fly(scenario, controller=controller, allocator="fixed-tilt")


def test_an_allocator_that_is_none_names_the_rules() -> None:
    with pytest.raises(om.InputError, match=r"allocator is .nope.*three-candidates.*fixed-tilt"):
        om.fly("hover", allocator="nope")


@pytest.mark.parametrize("part", ["plant", "sensors", "estimator", "controller", "disturbance"])
def test_a_class_is_no_part_but_an_object_of_it_is(part: str) -> None:
    parts: Any = {part: om.SimulatedPlant}
    with pytest.raises(om.InputError, match=rf"fly: {part} is .* an object of that class"):
        om.fly(short_scenario(), **parts)


def test_a_call_that_does_not_fit_names_no_line_of_ours() -> None:
    allocator: Any = lambda acceleration: None  # noqa: E731
    with pytest.raises(om.InputError, match=r"TypeError: .*3 were given\.$"):
        om.fly(short_scenario(), allocator=allocator)


def test_an_error_inside_a_controller_reaches_the_caller() -> None:
    def fails(time: float, state: om.State, desired: om.Desired) -> om.Command:
        raise ZeroDivisionError("mine")

    with pytest.raises(om.InputError, match=r"controller .*ZeroDivisionError: mine \(") as caught:
        om.fly(short_scenario(), controller=fails)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)  # with its own traceback
