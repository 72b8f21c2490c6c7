"""A flight flown step by step is the flight; what is done to it is what a scenario would say."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import omnimorph as om
from omnimorph.errors import ScenarioError
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.simulation.loop import SteppedFlight

HOVER = om.load_scenario("hover")
N = HOVER.vehicle.n_rotors
QUADROTOR = om.load_vehicle("quadrotor")


def flown(flight: SteppedFlight, until: float = np.inf) -> SteppedFlight:
    while not flight.is_over and flight.time < until:
        flight.step()
    return flight


def test_left_alone_it_is_the_flight_of_fly() -> None:
    run = flown(SteppedFlight(HOVER, seed=3, flight=2)).as_run()
    assert run.content_hash == om.fly(HOVER, seed=3, flight=2).content_hash
    assert not np.array_equal(run.p_WB, om.fly(HOVER, seed=3, flight=0).p_WB)
    assert run.outcome is om.Outcome.COMPLETED


def test_there_is_no_run_before_the_first_step() -> None:
    flight = om.SteppedFlight(HOVER)
    with pytest.raises(ScenarioError, match="hover: nothing has been flown yet; step first"):
        flight.as_run()
    flight.step()
    np.testing.assert_array_equal(flight.as_run().R_WB[0], np.eye(3))


def test_rows_on_the_way_are_those_of_the_whole_flight() -> None:
    flight = flown(SteppedFlight(HOVER), until=0.5)
    so_far, whole = flight.as_run(), om.fly(HOVER)
    assert so_far.outcome is om.Outcome.UNDER_WAY
    assert len(so_far.time) == flight.row + 1 == round(0.5 / HOVER.plant.physics_step)
    np.testing.assert_array_equal(so_far.p_WB, whole.p_WB[: flight.row + 1])


def test_a_cut_rotor_is_one_whose_effectiveness_is_zero() -> None:
    share = np.ones(N)
    share[2] = 0.0
    flight = SteppedFlight(HOVER)
    flight.set_effectiveness(share)
    effects = (*HOVER.plant.effects, om.effects.Effectiveness(share=tuple(share.tolist())))
    worn = replace(HOVER, plant=replace(HOVER.plant, effects=effects))
    np.testing.assert_array_equal(flown(flight).as_run().p_WB[1:], om.fly(worn).p_WB[1:])


def test_shares_count_from_what_the_plant_gives() -> None:
    half = om.effects.Effectiveness(share=0.5)
    worn = replace(HOVER, plant=replace(HOVER.plant, effects=(*HOVER.plant.effects, half)))
    flight = SteppedFlight(worn)
    flight.set_effectiveness(np.zeros(N))
    flight.set_effectiveness(np.ones(N))
    np.testing.assert_array_equal(flown(flight).as_run().p_WB, om.fly(worn).p_WB)


def test_another_controller_at_the_start_is_the_other_scenario() -> None:
    a, b = om.load_scenario("paper-case-a"), om.load_scenario("paper-case-b")
    flight = SteppedFlight(a)
    flight.change_controller(b)
    so_far = flown(flight, until=1.0).as_run()
    np.testing.assert_array_equal(so_far.tilt_actual, om.fly(b).tilt_actual[: len(so_far.time)])


def test_a_controller_change_goes_on_from_the_last_command() -> None:
    a, b = om.load_scenario("paper-case-a"), om.load_scenario("paper-case-b")
    flight = flown(SteppedFlight(a), until=20.0)
    flight.change_controller(b)
    run = flown(flight, until=21.0).as_run()
    steps = np.abs(np.diff(run.tilt_command[:, 0]))
    limit = a.vehicle.servo_rate_max[0] * a.plant.control_period
    assert steps.max() <= limit * (1 + 1e-9)
    assert not np.array_equal(run.tilt_actual[-1], om.fly(a).tilt_actual[len(run.time) - 1])


def test_position_goes_first_where_the_new_controller_says_so() -> None:
    """A quadrotor cannot push sideways, so it is seen whether it leans for its position."""
    aside = SegmentReference((0.0, 0.0, 1.0), np.eye(3), [Segment(1.0, move_W=(0.5, 0, 0))])
    stiff = replace(om.load_scenario("tour").for_vehicle(QUADROTOR), reference=aside)
    stiff = replace(stiff, attitude_gives_way=False)
    leaning = replace(stiff, attitude_gives_way=True)
    for before, after in ((stiff, leaning), (leaning, stiff)):
        flight = SteppedFlight(before)
        flight.change_controller(after)
        np.testing.assert_array_equal(flown(flight).as_run().R_WB, om.fly(after).R_WB)
    assert not np.array_equal(om.fly(stiff).R_WB, om.fly(leaning).R_WB)


def test_wakes_change_with_the_shares_of_the_thrust() -> None:
    share = np.array([1.0, 0.6, 1.0, 0.9, 0.7, 1.0, 1.0, 0.8])
    with_wakes = (*HOVER.plant.effects, om.effects.Interference())
    windy = replace(HOVER, plant=replace(HOVER.plant, effects=with_wakes))
    flight = SteppedFlight(windy)
    flight.set_effectiveness(share)
    effects = (*with_wakes, om.effects.Effectiveness(share=tuple(share.tolist())))
    worn = replace(HOVER, plant=replace(HOVER.plant, effects=effects))
    np.testing.assert_array_equal(flown(flight).as_run().p_WB[1:], om.fly(worn).p_WB[1:])


def test_a_push_moves_it_as_its_impulse_says() -> None:
    free = replace(HOVER, plant=om.load_plant("perfect"), lost_beyond=1e3)
    flight, force = SteppedFlight(free), np.array([20.0, 0, 0, 0, 0, 0])
    before = flight.core.motion()[12]
    flight.step(force)
    period = free.plant.control_period
    gained = flight.core.motion()[12] - before
    assert gained == pytest.approx(20.0 * period / free.vehicle.mass, rel=1e-3)


def test_what_was_done_is_reported_in_the_provenance() -> None:
    flight = flown(SteppedFlight(HOVER), until=0.1)
    flight.set_effectiveness(np.full(N, 0.9))
    flight.note("push", force_N=[1.0, 0.0, 0.0], duration_s=0.2)
    events = json.loads(flown(flight).as_run().provenance.scenario_text)["events"]
    assert [event["kind"] for event in events] == ["effectiveness", "push"]
    assert events[0]["time_s"] == pytest.approx(0.1)


@pytest.mark.parametrize("share", [[1.0], [-1.0] * N, [np.nan] * N])
def test_impossible_shares_are_refused(share: list[float]) -> None:
    with pytest.raises(ScenarioError, match="shares of the thrust"):
        SteppedFlight(HOVER).set_effectiveness(np.array(share))


def test_the_controller_of_another_vehicle_is_refused() -> None:
    other = om.load_scenario("tour").for_vehicle(om.load_vehicle("tilt-hex"))
    with pytest.raises(ScenarioError, match="which is flying"):
        SteppedFlight(HOVER).change_controller(other)
