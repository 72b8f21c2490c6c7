"""Flights are copied, pickled and flown on: a branch is the same to the last bit."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.physics.golden_effects import EVERYTHING
from tests.unit.own_objects import (
    SHORT,
    Counting,
    Lagging,
    differing,
    in_another_process,
    wall,
)

import omnimorph as om

WORN = replace(SHORT, plant=replace(SHORT.plant, effects=EVERYTHING))
SHARES = np.array([1.0, 0.5, 1.0, 1.0, 0.9, 1.0, 1.0, 0.75])


def own(**parts: Any) -> om.Scenario:
    """The short scenario with parts of one's own."""
    return replace(SHORT, own=replace(SHORT.own, **parts))


FLIGHTS: dict[str, Callable[[], om.Scenario]] = {
    "every effect": lambda: WORN,
    "jointly": lambda: replace(
        SHORT, allocator=om.load_scenario("tour").for_vehicle("voliro").allocator
    ),
    "own parts": lambda: own(controller=Counting(SHORT), estimator=Lagging(SHORT)),
    "own engine": lambda: own(plant=wall()),
}


def begun(scenario: om.Scenario) -> om.SteppedFlight:
    """Return a flight under way, to which things were done."""
    flight = om.SteppedFlight(scenario, seed=5, flight=2)
    for k in range(25):
        if k == 10:
            flight.log("battery", [16.0, 15.5], unit="V")
            if scenario.own.plant is None:
                flight.set_effectiveness(SHARES)
            if not scenario.own.given():
                flight.change_controller("paper-case-b")
        flight.step(np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]) if k > 15 else np.zeros(6))
    return flight


def finished(flight: om.SteppedFlight) -> om.Run:
    flight.log("battery", [15.0, 14.5], unit="V")
    flight.step(np.array([0.0, 2.0, 0.0, 0.0, 0.0, 0.0]))
    flight.fly()
    return flight.as_run()


@pytest.mark.parametrize("name", FLIGHTS)
def test_branches_fly_on_the_same_to_the_last_bit(name: str) -> None:
    flight = begun(FLIGHTS[name]())
    branches = copy.copy(flight), copy.deepcopy(flight), pickle.loads(pickle.dumps(flight))
    state = flight.state.acceleration
    runs = [finished(one) for one in (*branches, flight)]
    assert {run.outcome for run in runs} == {om.Outcome.COMPLETED}
    for run in runs[:-1]:
        assert differing(run, runs[-1]) == []
        assert run.provenance == runs[-1].provenance
    assert flight.state.acceleration is not state
    assert runs[0]["battery"][60].tolist() == [16.0, 15.5]


def test_a_branch_flies_on_in_another_process() -> None:
    flight = begun(own(controller=Counting(SHORT)))
    code = (
        "import pickle, sys\n"
        "flight = pickle.load(sys.stdin.buffer)\n"
        "flight.fly()\n"
        "pickle.dump(flight.as_run(), sys.stdout.buffer)\n"
    )
    there = pickle.loads(in_another_process(code, pickle.dumps(flight)))
    flight.fly()
    assert differing(there, flight.as_run()) == []
    assert there.content_hash == flight.as_run().content_hash


def test_a_branch_does_not_touch_the_flight_it_came_from() -> None:
    flight, untouched = begun(FLIGHTS["own parts"]()), begun(FLIGHTS["own parts"]())
    branch = copy.copy(flight)
    for _ in range(5):
        branch.step(np.array([0.0, 0.0, 50.0, 0.0, 0.0, 0.0]))
    branch.log("other", 1.0)
    assert differing(finished(flight), finished(untouched)) == []
    assert "other" not in flight.as_run().logged


def test_a_flight_of_an_engine_is_copied_and_not_restored() -> None:
    flight = begun(FLIGHTS["own engine"]())
    with pytest.raises(om.InputError, match="copy or pickle the flight"):
        flight.restore(flight.stored_state())
    with pytest.raises(om.InputError, match=r"effectiveness .* left to the plant"):
        flight.set_effectiveness(SHARES)


def test_another_controller_takes_over_from_ones_own() -> None:
    flights = begun(own(controller=Counting(SHORT), estimator=Lagging(SHORT))), begun(SHORT)
    for flight in flights:
        flight.change_controller("paper-case-b")
        branch = pickle.loads(pickle.dumps(flight))
        flight.fly()
        branch.fly()
        assert differing(branch.as_run(), flight.as_run()) == []
    own_run, run = (flight.as_run() for flight in flights)
    began = begun(SHORT).row
    assert np.isnan(own_run.kkt_residual[:began]).all()
    assert np.isfinite(own_run.kkt_residual[began + 4 :]).all()
    assert np.isfinite(run.kkt_residual).all()


def test_a_controller_in_python_cannot_be_taken_on_the_way() -> None:
    with pytest.raises(om.InputError, match="written in Python"):
        begun(SHORT).change_controller(own(controller=Counting(SHORT)))
