"""What each flight and each branch has of parts of one's own, and what is refused on the way."""

from __future__ import annotations

import copy
import functools
import threading
from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest
from tests.unit.own_objects import SHORT, Counting, Lagging, differing, wall

import omnimorph as om
from omnimorph.errors import TooLargeError
from omnimorph.machine.memory import available_bytes

STEADY = om.Command(np.full(8, 1.6), np.zeros(1))


def test_a_command_that_is_refused_asks_no_part() -> None:
    flights = [om.SteppedFlight(om.with_parts(SHORT, estimator=Lagging(SHORT))) for _ in range(2)]
    for wrong in (om.Command(np.zeros(7), np.zeros(1)), om.Command(*STEADY, np.zeros(5))):
        flights[0].step()
        flights[1].step()
        with pytest.raises(om.InputError):
            flights[0].step(command=wrong)
    for flight in flights:
        flight.step()
    assert differing(flights[0].as_run(), flights[1].as_run()) == []


def test_another_controller_takes_the_place_of_ones_own() -> None:
    flight = om.SteppedFlight(om.with_parts(SHORT, controller=Counting(SHORT)))
    for _ in range(3):
        flight.step()
    flight.change_controller("paper-case-b")
    branch = copy.copy(flight)
    for one in (flight, branch):
        one.fly()
    assert differing(branch.as_run(), flight.as_run()) == []
    assert flight.as_run()["calls"].max() == 3


def counting_function() -> Callable[..., om.Command]:
    calls = [0]

    def controller(time: float, state: om.State, desired: om.Desired) -> om.Command:
        calls[0] += 1
        return om.Command(*STEADY, log={"calls": calls[0]})

    return controller


def a_lambda() -> Callable[..., om.Command]:
    controller = Counting(SHORT)
    return lambda *given: controller(*given)


@pytest.mark.parametrize(
    "made",
    [
        counting_function,
        a_lambda,
        lambda: functools.partial(counting_function()),
        lambda: Counting(SHORT).__call__,
        lambda: Counting(SHORT),
    ],
    ids=["closure", "lambda", "partial", "method", "object"],
)
def test_each_flight_and_each_branch_has_its_own_copy(made: Callable[[], Any]) -> None:
    flights = om.fly_many(SHORT, 3, controller=made(), keep="all")
    for k, run in flights.runs.items():
        assert differing(run, om.fly(SHORT, flight=k, controller=made())) == []
    flight = om.SteppedFlight(om.with_parts(SHORT, controller=made()))
    flight.step()
    branch = copy.copy(flight)
    flight.fly()
    branch.fly()
    assert differing(branch.as_run(), flight.as_run()) == []
    assert flight.as_run()["calls"][-1] == 50


def test_a_part_that_cannot_be_copied_is_refused_in_a_sentence() -> None:
    class Connected(Counting):
        def __init__(self, scenario: om.Scenario) -> None:
            super().__init__(scenario)
            self.line = threading.Lock()

    said = "the controller cannot be copied for another flight, because TypeError"
    flight = om.SteppedFlight(om.with_parts(SHORT, controller=Connected(SHORT)))
    with pytest.raises(om.InputError, match=said):
        copy.copy(flight)
    with pytest.raises(om.InputError, match=said):
        om.fly_many(SHORT, 2, controller=Connected(SHORT))


def test_the_controller_of_a_scenario_is_its_own_one_too() -> None:
    mine = om.with_parts(SHORT, controller=Counting(SHORT))
    assert om.fly(SHORT, controller=mine)["calls"][-1] == 50
    allocated = om.with_parts(SHORT, allocator=lambda *_: STEADY)
    for part in ({"controller": allocated}, {"allocator": allocated}):
        parts: Any = part
        assert set(om.fly(SHORT, **parts).thrust_command[:-1].ravel()) == {1.6}


def test_what_a_part_says_of_itself_cannot_break_the_run() -> None:
    class Filed(Counting):
        def as_file(self, path: str) -> None:
            raise AssertionError

    run = om.fly(SHORT, controller=Filed(SHORT))
    assert run.provenance.scenario["controller"]["name"].endswith("Filed")


@pytest.mark.parametrize("error", [ValueError("no way"), SystemExit(3)])
@pytest.mark.parametrize("at", ["duration", 0.0, 0.1])
def test_a_reference_that_raises_is_refused_in_a_sentence(error: Any, at: Any) -> None:
    class Lost:
        @property
        def duration(self) -> float:
            if at == "duration" and isinstance(error, ValueError):
                raise error
            return 0.2

        def __call__(self, time: float) -> om.Desired:
            if at == "duration" or time >= at:
                raise error
            return SHORT.reference(time)

    with pytest.raises(om.InputError, match=type(error).__name__):
        om.fly(SHORT, reference=Lost())


def test_logs_that_a_run_could_not_hold_are_refused_and_names_are_texts() -> None:
    flight = om.SteppedFlight("paper-case-a")
    control_steps = 45 * 250
    in_control_steps = available_bytes() // 2  # but the run has four rows to each of them
    with pytest.raises(TooLargeError, match="logs"):
        flight.log("all", np.zeros(in_control_steps // (8 * control_steps)))
    name: Any = ["x"]
    with pytest.raises(om.InputError, match="name of a log"):
        flight.log(name, 1.0)


def test_a_log_of_a_command_by_hand_is_kept_and_refused_before_it_flies() -> None:
    flight = om.SteppedFlight(SHORT)
    flight.step()
    flight.step(command=om.Command(*STEADY, log={"lift": (12.8, "N")}))
    with pytest.raises(om.InputError, match="log lift"):
        flight.step(command=om.Command(*STEADY, log={"lift": ("much", "N")}))
    flight.step()
    lift = flight.as_run()["lift"]
    np.testing.assert_array_equal(lift, np.r_[np.full(4, np.nan), np.full(8, 12.8)])


def test_no_two_flights_share_an_object_behind_partial() -> None:
    mine = Counting(SHORT)

    def again(time: float, measured: om.State, previous: om.Command) -> om.State:
        om.fly(SHORT, controller=functools.partial(mine))
        return measured

    with pytest.raises(om.InputError, match="flying already"):
        om.fly(SHORT, controller=functools.partial(mine), estimator=again)


@pytest.mark.parametrize(
    ("part", "name"), [("plant", "truth.mass"), ("controller", "controller.position")]
)
def test_flights_do_not_differ_in_what_an_object_stands_in_for(part: str, name: str) -> None:
    own: Any = {"plant": wall(), "controller": Counting(SHORT)}
    with pytest.raises(om.InputError, match=f"vary is .{name}.* {part} is an object that"):
        om.fly_many(SHORT, 2, vary={name: [1.0, 2.0]}, **{part: own[part]})
    other = ({"plant", "controller"} - {part}).pop()
    assert len(om.fly_many(SHORT, 2, vary={name: [4.0, 4.1]}, **{other: own[other]})) == 2


@pytest.mark.parametrize("at", [0.0, 0.1])
@pytest.mark.parametrize("point", [None, 5, (np.zeros(3),) * 6, ("here", np.eye(3))])
def test_a_point_of_a_reference_that_is_none_is_refused_wherever_it_is(point: Any, at: Any) -> None:
    class Lost:
        duration = 0.2

        def __call__(self, time: float) -> om.Desired:
            given: Any = point if time >= at else SHORT.reference(time)
            return cast(om.Desired, given)

    with pytest.raises(om.InputError, match=rf"the point at {at:g} s is .* omnimorph.Desired"):
        om.fly(SHORT, reference=Lost())
