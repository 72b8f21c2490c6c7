"""Parts of one's own that write into what they are given, answer anything, or raise anywhere."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.unit.own_objects import SHORT, Counting, Wall, differing, wall

import omnimorph as om
from omnimorph.protocols import FloatArray

STEADY = om.Command(np.full(8, 1.6), np.zeros(1))


class Unreadable:
    """What cannot become an array, such as a tensor that is still part of a gradient."""

    def __array__(self, *_: Any, **__: Any) -> FloatArray:
        raise RuntimeError("call detach first")

    def __repr__(self) -> str:
        raise RuntimeError("nor can it be shown")


class Speechless(Exception):
    """An error that fails when it is shown."""

    def __str__(self) -> str:
        raise ValueError("nothing to say")


def overwrite(*arrays: Any) -> None:
    for array in arrays:
        if array is not None and array.flags.writeable:
            array[...] = 7.0


def forwarding(**changed: Any) -> Any:
    """Return an engine that forwards, but for what is changed."""
    return type("Engine", (Wall,), changed)(SHORT.vehicle, SHORT.plant)


def test_a_part_that_writes_into_what_it_is_given_changes_nothing_but_its_own() -> None:
    def sensors(time: float, state: om.State) -> om.State:
        answer = copy.deepcopy(state)
        overwrite(*state, state.speed, state.tilt, state.acceleration)
        return answer

    def estimator(time: float, measured: om.State, previous: om.Command) -> om.State:
        answer = copy.deepcopy(measured)
        overwrite(*measured, measured.speed, measured.tilt, measured.acceleration, *previous)
        return answer

    def disturbance(time: float, state: om.State) -> FloatArray:
        overwrite(*state, state.speed, state.tilt, state.acceleration)
        return np.zeros(6)

    own: Any = {"sensors": sensors, "estimator": estimator, "disturbance": disturbance}
    reported = om.fly(SHORT, sensors="perfect", estimator=lambda time, state, previous: state)
    assert differing(om.fly(SHORT, **own), reported) == []


def test_a_controller_that_writes_into_state_and_wish_flies_the_same() -> None:
    class Overwriting(Counting):
        def __call__(self, time: float, state: om.State, desired: om.Desired) -> om.Command:
            command = super().__call__(time, state, desired)
            overwrite(*state, state.speed, state.tilt, state.acceleration, *desired)
            return command

    reported = om.fly(SHORT, controller=Counting(SHORT))
    assert differing(om.fly(SHORT, controller=Overwriting(SHORT)), reported) == []


def test_an_engine_that_writes_into_the_command_does_not_change_who_decided_it() -> None:
    def send(self: Wall, command: om.Command) -> None:
        Wall.send(self, command)
        overwrite(*command)

    def constant(time: float, state: om.State, desired: om.Desired) -> om.Command:
        return om.Command(thrust, tilt)

    thrust, tilt = np.full(8, 1.6), np.zeros(1)
    run = om.fly(SHORT, plant=forwarding(send=send), controller=constant)
    assert set(run.thrust_command.ravel()) == {1.6}
    assert set(thrust) == {1.6}


def test_no_engine_can_change_the_push_of_other_flights() -> None:
    def pushed(self: Wall, steps: int, push: FloatArray) -> None:
        Wall.step_physics(self, steps, push)
        push += 1.0

    with pytest.raises(om.InputError, match=r"plant Engine failed before .* read-only"):
        om.fly(SHORT, plant=forwarding(step_physics=pushed))
    mine = np.ones(6)
    flight = om.SteppedFlight(om.with_parts(SHORT, plant=forwarding(step_physics=pushed)))
    with pytest.raises(om.InputError, match="read-only"):
        flight.step(mine)
    np.testing.assert_array_equal(mine, np.ones(6))
    assert differing(om.fly(SHORT, plant=wall()), om.fly(SHORT)) == []


def later(bad: Callable[[], Any], good: Any) -> Callable[[float], Any]:
    return lambda time: bad() if time > 0.1 else good


def half_an_answer() -> Any:
    yield STEADY.thrust
    raise RuntimeError("lost my thread")


class Hidden(tuple[FloatArray, FloatArray]):
    """A command whose attributes raise."""

    __slots__ = ()

    @property
    def wrench_asked(self) -> Any:
        raise RuntimeError("not ready")


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        (half_an_answer, r"RuntimeError: lost my thread \(test_parts_that_misbehave.py:\d+\)"),
        (lambda: (Unreadable(), np.zeros(1)), "RuntimeError: call detach first"),
        (lambda: om.Command(*STEADY, wrench_asked=Unreadable()), "cannot be shown"),  # type: ignore[arg-type]
        (lambda: Hidden(STEADY), "RuntimeError: not ready"),
        (lambda: (["1.6"] * 8, ["0"]), "not made of real numbers"),
        (lambda: (np.full(8, 1.6j), np.zeros(1)), "not made of real numbers"),
        (lambda: om.Command(*STEADY, log={"x": Unreadable()}), "call detach first"),
    ],
)
def test_whatever_a_controller_answers_the_flight_is_kept(bad: Any, said: str) -> None:
    answer = later(bad, STEADY)
    run = om.fly(SHORT, controller=lambda time, state, desired: answer(time))
    assert run.outcome is om.Outcome.PART_FAILED
    assert len(run.time) == 105
    assert re.search(said, run.outcome_sentence)


@pytest.mark.parametrize("part", ["sensors", "estimator", "disturbance"])
@pytest.mark.parametrize("bad", [Unreadable(), (Unreadable(),) * 4])
def test_what_is_no_array_ends_the_flight_and_names_the_part(part: str, bad: Any) -> None:
    def answers(time: float, state: om.State, *_: Any) -> Any:
        good = np.zeros(6) if part == "disturbance" else state
        return bad if time > 0.1 else good

    parts: Any = {part: answers}
    run = om.fly(SHORT, **parts)
    assert run.outcome is om.Outcome.PART_FAILED
    assert f"{part}: answer is" in run.outcome_sentence


def test_sensors_may_answer_a_plain_tuple() -> None:
    """They then say nothing of speeds, tilts and acceleration."""
    known = []

    def controller(time: float, state: om.State, desired: om.Desired) -> om.Command:
        known.append(state)
        return STEADY

    sensors: Any = lambda time, state: tuple(state)  # noqa: E731
    om.fly(SHORT, sensors=sensors, controller=controller)
    assert known[-1].speed is known[-1].tilt is known[-1].acceleration is None


def test_a_push_that_is_not_finite_is_the_fault_of_who_gave_it() -> None:
    def disturbance(time: float, state: om.State) -> FloatArray:
        return np.full(6, np.nan if time > 0.1 else 0.0)

    run = om.fly(SHORT, plant=wall(), disturbance=disturbance)
    assert "disturbance: answer is [nan" in run.outcome_sentence


@pytest.mark.parametrize("error", [Speechless(), SystemExit(3), MemoryError(), StopIteration()])
def test_whatever_is_raised_is_named(error: BaseException) -> None:
    def fails(time: float, state: om.State, desired: om.Desired) -> om.Command:
        if time > 0.1:
            raise error
        return STEADY

    run = om.fly(SHORT, controller=fails)
    assert run.outcome is om.Outcome.PART_FAILED
    assert f"failed with {type(error).__name__}" in run.outcome_sentence


# --- engines --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        (lambda: 1 // 0, "ZeroDivisionError"),
        (lambda: np.zeros(5), "acceleration is .* six numbers"),
        (lambda: "much", "acceleration is .*much.* six numbers"),
    ],
)
def test_the_acceleration_of_an_engine_is_checked(bad: Any, said: str) -> None:
    times = iter(range(10**6))
    acceleration = property(lambda _: bad() if next(times) > 20 else np.zeros(6))
    engine = forwarding(acceleration=acceleration)
    run = om.fly(SHORT, plant=engine, controller=lambda time, state, desired: STEADY)
    assert run.outcome is om.Outcome.PART_FAILED
    assert re.search(f"plant Engine failed with .*{said}", run.outcome_sentence)


def test_a_state_that_cannot_be_read_is_refused_in_a_sentence() -> None:
    engine = forwarding(acceleration=property(lambda _: 1 // 0))
    with pytest.raises(om.InputError, match="plant Engine failed with ZeroDivisionError"):
        om.SteppedFlight(om.with_parts(SHORT, plant=engine)).state  # noqa: B018


def test_no_part_can_write_into_an_engine_by_its_acceleration() -> None:
    mine = np.zeros(6)

    def controller(time: float, state: om.State, desired: om.Desired) -> om.Command:
        overwrite(state.acceleration)
        return STEADY

    om.fly(SHORT, plant=forwarding(acceleration=mine), controller=controller)
    assert not mine.any()


@pytest.mark.parametrize("name", ["physics_step", "control_period", "motion", "speed"])
def test_an_engine_that_cannot_be_read_at_all_is_refused_in_a_sentence(name: str) -> None:
    engine = type("Engine", (Wall,), {name: property(lambda _: 1 // 0)})
    with pytest.raises(om.InputError, match=r"plant Engine failed before .*: ZeroDivisionError"):
        om.fly(SHORT, plant=engine(SHORT.vehicle, SHORT.plant))


@pytest.mark.parametrize(
    ("name", "bad", "said"),
    [
        ("motion", lambda _: om.State.__base__, "cannot be flown, because"),
        ("motion", lambda state: (*state, state[0]), "too many values to unpack"),
        ("speed", lambda speed: speed * 1j, "not made of real numbers"),
        ("tilt", lambda _: None, "NoneType .* not made of real numbers"),
        ("wrench", lambda wrench: [str(one) for one in wrench], "not made of real numbers"),
    ],
)
def test_what_an_engine_gives_is_made_of_real_numbers(name: str, bad: Any, said: str) -> None:
    changed = property(lambda self: bad(getattr(self._behind, name)))
    with pytest.raises(om.InputError, match=said) as caught:
        om.fly(SHORT, plant=forwarding(**{name: changed}))
    assert "ndarray[" not in str(caught.value)


@pytest.mark.parametrize("late", [0, 101])
def test_an_attitude_that_is_no_rotation_ends_the_flight(late: int) -> None:
    times = iter(range(10**6))

    def stretched(self: Wall) -> om.State:
        state = self._behind.motion
        return state._replace(R_WB=state.R_WB * 1.01) if next(times) >= late else state

    flight = om.SteppedFlight(om.with_parts(SHORT, plant=forwarding(motion=property(stretched))))
    if late == 0:
        with pytest.raises(om.InputError, match=r"the plant: attitude is .* a rotation"):
            flight.fly()
        return
    flight.fly()
    run = flight.as_run()
    assert run.outcome is om.Outcome.PART_FAILED
    assert 101 <= len(run.time) <= 105
