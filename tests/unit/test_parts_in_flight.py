"""A part of the loop that may remember something flies once at a time."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import omnimorph as om
from omnimorph.errors import ScenarioError
from omnimorph.protocols import FloatArray
from omnimorph.reference.segments import Segment, SegmentReference

REST = SegmentReference((0.0, 0.0, 1.2), np.eye(3), [Segment(0.2)])
SHORT = replace(om.load_scenario("hover"), reference=REST)


class Waiting:
    """A part that, once under way, waits until another flight was tried."""

    def __init__(self) -> None:
        self.under_way, self.go_on = threading.Event(), threading.Event()
        self.controller = SHORT.build_controller()

    def wait(self) -> None:
        self.under_way.set()
        assert self.go_on.wait(60.0)

    def control(self, time: float, state: om.State, desired: om.Desired) -> om.Command:
        self.wait()
        return self.controller(time, state, desired)

    def __call__(self, time: float, state: om.State) -> FloatArray:
        self.wait()
        return np.zeros(6)


@pytest.mark.parametrize("name", ["controller", "disturbance"])
def test_a_part_that_is_flying_is_refused_and_flies_again_later(name: str) -> None:
    waiting = Waiting()
    part: Any = waiting if name == "disturbance" else waiting.control
    flown: list[om.Run] = []
    thread = threading.Thread(target=lambda: flown.append(om.fly(SHORT, **{name: part})))
    thread.start()
    try:
        assert waiting.under_way.wait(60.0)
        with pytest.raises(ScenarioError, match=f"the {name} is flying already; .* give each its"):
            om.fly(SHORT, **{name: part})
    finally:
        waiting.go_on.set()
        thread.join()
    assert flown[0].outcome is om.Outcome.COMPLETED
    again: Any = waiting if name == "disturbance" else waiting.control
    assert om.fly(SHORT, **{name: again}).outcome is om.Outcome.COMPLETED


def calm(time: float, state: om.State) -> FloatArray:
    return np.zeros(6)


def test_what_remembers_nothing_is_shared() -> None:
    """A plain function, and the frozen references of the package."""
    runs: list[om.Run] = []
    threads = [
        threading.Thread(target=lambda: runs.append(om.fly(SHORT, disturbance=calm)))
        for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({run.content_hash for run in runs}) == 1
    assert len(runs) == 4


def test_a_part_is_free_after_a_flight_that_failed() -> None:
    class Failing:
        def __call__(self, time: float, state: om.State) -> FloatArray:
            raise ZeroDivisionError

    part = Failing()
    for _ in range(2):
        with pytest.raises(ScenarioError, match=r"Failing failed .*ZeroDivisionError"):
            om.fly(SHORT, disturbance=part)
