"""Sensors, estimators, controllers and allocators of one's own, each at its place in the loop."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.unit.own_objects import SHORT, Counting, Lagging, differing

import omnimorph as om
from omnimorph.protocols import FloatArray

NOISE = [one for one in SHORT.plant.effects if one.kind == "measurement-noise"]


def passing(time: float, measured: om.State, previous: om.Command) -> om.State:
    """An estimator that takes what is measured for true."""
    return measured


def exact(time: float, state: om.State) -> om.State:
    """Sensors without an error."""
    return state


def test_an_estimator_that_believes_what_is_measured_flies_as_the_filters_that_pass_all() -> None:
    own, reported = om.fly(SHORT, estimator=passing), om.fly(SHORT)
    np.testing.assert_allclose(own.p_WB, reported.p_WB, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(own.wrench_asked, reported.wrench_asked, rtol=0.0, atol=1e-6)
    quiet = om.load_plant("perfect")
    reported = om.fly(SHORT, plant=quiet)
    assert differing(om.fly(SHORT, plant=quiet, estimator=passing), reported) == []


def test_sensors_that_do_not_err_fly_as_the_plant_without_noise() -> None:
    quiet = [one for one in SHORT.plant.effects if one.kind != "measurement-noise"]
    reported = om.fly(replace(SHORT, plant=replace(SHORT.plant, effects=tuple(quiet))))
    assert differing(om.fly(SHORT, sensors=exact), reported) == []
    assert differing(om.fly(SHORT, sensors="perfect"), reported) == []
    assert differing(om.fly(SHORT, sensors=[]), reported) == []
    assert differing(om.fly(SHORT, sensors=NOISE), om.fly(SHORT)) == []
    assert differing(om.fly(SHORT), reported) != []


def test_an_estimator_is_given_what_the_sensors_read_and_the_last_command() -> None:
    given: list[tuple[float, om.State, om.Command]] = []

    def keeping(time: float, measured: om.State, previous: om.Command) -> om.State:
        given.append((time, measured, previous))
        return measured

    run = om.fly(SHORT, sensors=exact, estimator=keeping)
    rows = np.arange(0, 200, 4)
    np.testing.assert_array_equal([time for time, _, _ in given], run.time[rows])
    for name in ("p_WB", "R_WB", "v_WB", "w_WB_B"):
        read = [getattr(measured, name) for _, measured, _ in given]
        np.testing.assert_array_equal(read, run[name][rows])
    speeds = [measured.speed for _, measured, _ in given]
    np.testing.assert_array_equal(speeds, run.speed[rows])
    np.testing.assert_array_equal([one.tilt for _, one, _ in given], run.tilt_actual[rows])
    np.testing.assert_array_equal(
        [previous.thrust for _, _, previous in given[1:]], run.thrust_command[rows[:-1]]
    )


def test_the_acceleration_is_what_velocity_and_rate_change_by() -> None:
    push = np.array([3.0, -1.0, 2.0, 0.02, 0.1, -0.05])
    effects = tuple(one for one in SHORT.plant.effects if one.kind != "rotor-momentum")
    plant = replace(SHORT.plant, physics_step=1e-4, control_period=4e-3, effects=effects)
    flight = om.SteppedFlight(replace(SHORT, plant=plant))
    for _ in range(10):
        flight.step(push)
    acceleration = flight.state.acceleration
    flight.step(push)
    run = flight.as_run()
    assert acceleration is not None
    change = (run.v_WB[400] - run.v_WB[399]) / 1e-4, (run.w_WB_B[400] - run.w_WB_B[399]) / 1e-4
    assert abs(acceleration[0]) > 1.0
    np.testing.assert_allclose(acceleration, np.concatenate(change), rtol=0.0, atol=0.02)


def test_estimate_and_controller_are_one_chain() -> None:
    """The paper's controller, given what an estimator lags behind, answers that."""
    both = om.fly(SHORT, estimator=Lagging(SHORT), controller=Counting(SHORT))
    alone = om.fly(SHORT, estimator=Lagging(SHORT))
    names = ("p_WB", "thrust_command", "tilt_command")
    for name in names:
        np.testing.assert_allclose(both[name], alone[name], rtol=0.0, atol=1e-9)
    assert differing(alone, om.fly(SHORT)) != []


def test_a_controller_hands_over_the_wrench_it_asked_for() -> None:
    run = om.fly(SHORT, controller=Counting(SHORT))
    np.testing.assert_array_equal(run.wrench_asked, np.tile(np.arange(6.0), (201, 1)))


@pytest.mark.parametrize("wrench", [np.zeros(5), "strong", 1.0])
def test_a_wrench_asked_for_that_is_none_is_refused(wrench: Any) -> None:
    def asks(time: float, state: om.State, desired: om.Desired) -> om.Command:
        return om.Command(np.full(8, 1.6), np.zeros(1), wrench)

    with pytest.raises(om.InputError, match=r"wrench_asked is .* six numbers"):
        om.fly(SHORT, controller=asks)


@pytest.mark.parametrize("answer", [None, 1.0, (np.zeros(3),) * 4, ("here",) * 4])
@pytest.mark.parametrize("part", ["sensors", "estimator"])
def test_an_answer_that_is_no_state_is_the_users_mistake(part: str, answer: object) -> None:
    parts: Any = {part: lambda *_: answer}
    with pytest.raises(
        om.InputError, match=rf"the {part}: answer is .* must be an omnimorph.State"
    ):
        om.fly(SHORT, **parts)


def test_an_estimate_that_is_not_finite_ends_the_flight_and_keeps_it() -> None:
    def blind(time: float, measured: om.State, previous: om.Command) -> om.State:
        return measured._replace(p_WB=measured.p_WB * (1.0 if time < 0.1 else np.nan))

    run = om.fly(SHORT, estimator=blind)
    assert run.outcome is om.Outcome.NOT_FINITE
    assert len(run.time) == 101


@pytest.mark.parametrize("part", ["sensors", "estimator", "controller", "allocator", "disturbance"])
def test_a_part_that_raises_on_the_way_ends_the_flight_which_is_kept(part: str) -> None:
    calls = []
    whole = om.fly(SHORT)

    def fails(*given: Any) -> Any:
        calls.append(given)
        if len(calls) == 21:
            raise ValueError("out of order")
        chosen = SHORT.build_controller().allocate(np.zeros(6), whole_state)
        command = om.Command(chosen.thrust, chosen.tilt)
        answers = {"sensors": given[-1], "estimator": given[1], "disturbance": np.zeros(6)}
        return answers.get(part, command)

    whole_state = om.State(*(whole[name][0] for name in om.State._fields))
    parts: Any = {part: fails}
    run = om.fly(SHORT, **parts)
    assert run.outcome is om.Outcome.PART_FAILED
    at = 20 if part == "disturbance" else 80
    assert len(run.time) == at + 1
    said = f"The flight was ended at {at / 1000:g} s: {part} "
    assert run.outcome_sentence.startswith(said)
    assert "failed with ValueError: out of order (test_own_parts.py:" in run.outcome_sentence


def test_a_command_of_another_shape_on_the_way_ends_the_flight_which_is_kept() -> None:
    def shrinks(time: float, state: om.State, desired: om.Desired) -> om.Command:
        return om.Command(np.full(8 if time < 0.1 else 7, 1.6), np.zeros(1))

    run = om.fly(SHORT, controller=shrinks)
    assert run.outcome is om.Outcome.PART_FAILED
    assert len(run.time) == 101
    assert "thrust has 7 numbers, not 8" in run.outcome_sentence


def test_an_interrupt_is_not_taken_for_a_part_that_fails() -> None:
    def stops(time: float, state: om.State, desired: om.Desired) -> om.Command:
        if time > 0.1:
            raise KeyboardInterrupt
        return om.Command(np.full(8, 1.6), np.zeros(1))

    with pytest.raises(KeyboardInterrupt):
        om.fly(SHORT, controller=stops)


# --- commands and demands, step by step -----------------------------------------------------------


def test_a_command_by_hand_flies_as_the_controller_that_gives_it() -> None:
    def steady(time: float, state: om.State, desired: om.Desired) -> om.Command:
        return om.Command(np.full(8, 1.61 + time), np.array([time]), np.arange(6.0))

    reported = om.fly(SHORT, controller=steady)
    flight, zero = om.SteppedFlight(SHORT), np.zeros(3)
    nowhere: Any = om.Desired(zero, np.eye(3), zero, zero, zero, zero)
    while not flight.is_over:
        flight.step(command=steady(flight.time, flight.state, nowhere))
    assert differing(flight.as_run(), reported) == []


def test_a_demand_by_hand_is_answered_by_the_allocator() -> None:
    up = np.array([0.0, 0.0, 2.0, 0.0, 0.0, 0.0])

    def climbing(acceleration: FloatArray, state: om.State, previous: om.Command) -> om.Command:
        return om.Command(np.full(8, acceleration[2]), np.zeros(1))

    flight = om.SteppedFlight(SHORT)
    own = om.SteppedFlight(replace(SHORT, own=replace(SHORT.own, allocator=climbing)))
    for _ in range(5):
        flight.step(demand=up)
        own.step(demand=up)
    run = flight.as_run()
    wrench = run.vehicle.mass * (2.0 + 9.81)
    np.testing.assert_allclose(run.wrench_asked[:, 2], wrench, rtol=1e-3)
    np.testing.assert_allclose(run.thrust_command[-1].sum(), wrench, rtol=1e-3)
    assert run.kkt_residual.max() < 1e-9
    np.testing.assert_array_equal(own.as_run().thrust_command, np.full((20, 8), 2.0))
    np.testing.assert_allclose(own.as_run().wrench_asked, run.wrench_asked, atol=0.02)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"command": om.Command(np.full(8, np.nan), np.zeros(1))}, "command is .* finite"),
        ({"command": om.Command(np.zeros(7), np.zeros(1))}, "thrust has 7 numbers"),
        ({"command": "up"}, "command is .*up.* omnimorph.Command"),
        ({"demand": np.zeros(3)}, "demand is .* six finite numbers"),
        ({"demand": [np.inf] * 6}, "demand is .* six finite numbers"),
        ({"demand": np.zeros(6), "command": om.Command(np.ones(8), np.zeros(1))}, "not both"),
    ],
)
def test_what_cannot_be_asked_for_is_refused_and_the_flight_goes_on(
    wrong: dict[str, Any], said: str
) -> None:
    flight, left_alone = om.SteppedFlight(SHORT), om.SteppedFlight(SHORT)
    for k in range(5):
        if k == 3:
            with pytest.raises(om.InputError, match=said):
                flight.step(**wrong)
        flight.step()
        left_alone.step()
    assert differing(flight.as_run(), left_alone.as_run()) == []
