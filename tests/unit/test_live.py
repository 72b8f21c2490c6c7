"""A live flight without a browser: what its page shows when the flight breaks, and what is kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from tests.unit.own_objects import wall

import omnimorph as om
from omnimorph.live.page import LivePage
from omnimorph.live.pilot import PUSH_SECONDS, Pilot
from omnimorph.simulation.loop import SteppedFlight
from omnimorph.viewer.server import new_server, stop

HOVER = om.load_scenario("hover")


def test_a_flight_that_diverges_is_shown_and_kept() -> None:
    server = new_server()
    try:
        page = LivePage(server, HOVER)
        page.pilot.push(np.array([1e300, 0.0, 0.0]))
        page.pilot.advance(np.inf)
        page.show()
        run = page.flight.as_run()
    finally:
        stop(server)
    assert run.outcome is om.Outcome.DIVERGED
    with np.errstate(over="ignore"):
        assert not np.isfinite(np.square(run.p_WB[-1])).all()


def test_a_push_lasts_as_long_as_it_says() -> None:
    far = replace(HOVER, plant=om.load_plant("perfect"), lost_beyond=1e3)
    pilot = Pilot(SteppedFlight(far))
    pilot.push(np.array([0.0, 0.0, 200.0]))  # more than the rotors can hold against
    pilot.advance(1.0)
    flight, step = pilot.flight, far.plant.physics_step
    rise = flight.columns["v_WB"][: flight.row, 2]
    assert rise.argmax() * step == PUSH_SECONDS


def test_a_push_acts_in_as_many_steps_as_it_lasts() -> None:
    """Whenever it begins: 0.1 s + 0.2 s is not 0.3 s in binary."""
    far = replace(HOVER, plant=om.load_plant("perfect"), lost_beyond=1e3)
    push = np.array([30.0, 0.0, 0.0])
    pilot, by_hand = Pilot(SteppedFlight(far)), SteppedFlight(far)
    pilot.advance(0.1)
    pilot.push(push)
    pilot.advance(0.5)
    count = round(PUSH_SECONDS / far.plant.control_period)
    first = round(0.1 / far.plant.control_period)
    for k in range(round(0.5 / far.plant.control_period)):
        by_hand.step(np.r_[push if first <= k < first + count else np.zeros(3), np.zeros(3)])
    np.testing.assert_array_equal(pilot.flight.as_run().v_WB, by_hand.as_run().v_WB)


def test_plots_go_on_with_the_flight_and_are_never_built_anew() -> None:
    """A plot whose scales were set anew kept, in the browser, to the times it had shown before."""
    server = new_server()
    try:
        page = LivePage(server, HOVER)
        handles = [plot._handle for plot in page._charts._plots]
        scales = [handle.scales for handle in handles]
        for until in (0.5, 1.0):
            page.pilot.push(np.array([80.0 * until, 0.0, 0.0]))  # errors grow, and so do their axes
            page.pilot.advance(until)
            page.show()
            end = page.as_run().time[-1]
            assert [handle.data[0][-1] for handle in handles] == [end] * 5
            for handle in handles:
                now = np.isfinite(handle.data[-1])
                assert set(handle.data[0][now]) == {end}
        assert [handle.scales for handle in handles] == scales
    finally:
        stop(server)


def test_a_part_of_ones_own_that_fails_is_shown_and_the_flight_kept() -> None:
    def fails(time: float, state: om.State, desired: om.Desired) -> om.Command:
        if time > 0.1:
            raise ValueError("no <way>")
        return om.Command(np.full(8, 1.6), np.zeros(1), log={"time_there": time})

    server = new_server()
    try:
        page = LivePage(server, om.with_parts(HOVER, controller=fails))
        page.pilot.advance(np.inf)
        page.show()
        shown, run = page._notice.content, page.as_run()
    finally:
        stop(server)
    assert run.outcome is om.Outcome.PART_FAILED
    assert run["time_there"].max() == 0.1
    assert "no &lt;way&gt;" in shown
    assert "no <way>" not in shown


def test_what_an_engine_decides_itself_is_refused_on_the_page_and_the_flight_goes_on() -> None:
    server = new_server()
    try:
        page = LivePage(server, om.with_parts(HOVER, plant=wall(HOVER)))
        page._try(lambda: page.pilot.cut(0))
        shown = page._notice.content
        page.pilot.advance(np.inf)
        page.show()
        run = page.as_run()
    finally:
        stop(server)
    assert "left to the plant" in shown
    assert run.outcome is om.Outcome.COMPLETED
