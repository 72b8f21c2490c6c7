"""The state of a flight is one value: stored and put back, the flight goes on the same."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from tests.physics.test_many_flights import NOISE, rules, two_seconds

import omnimorph as om
from omnimorph import effects
from omnimorph.errors import ScenarioError
from omnimorph.results.run import COLUMNS
from omnimorph.simulation.effects import Effect
from omnimorph.simulation.plant import INTEGRATORS

WORN = (
    NOISE,
    effects.RotorLag(up=0.01, down=0.014),
    effects.DeadBand(smallest=60.0, reversal_time=0.01),
    effects.ServoLag(time_constant=0.02),
    effects.CommandDelay(time=0.012),
    effects.RotorMomentum(),
)


def scenario(worn: tuple[Effect, ...] = WORN, name: str = "paper-case-b") -> om.Scenario:
    return two_seconds(name, worn)


def step(flight: om.SteppedFlight, periods: int) -> None:
    for _ in range(periods):
        flight.step()


def assert_same_rows(one: om.SteppedFlight, other: om.SteppedFlight, first: int) -> None:
    assert one.row == other.row
    for column in COLUMNS:
        if column.name in one.columns:
            rows = slice(first, one.row + 1)
            a, b = one.columns[column.name][rows], other.columns[column.name][rows]
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("rule", sorted(rules()))
def test_a_branch_goes_on_the_same_to_the_last_bit(
    rule: str, integrator: Literal["semi-implicit-euler", "runge-kutta-4"]
) -> None:
    """With empty caches, commands under way and filters that are filled, by every rule."""
    flown = rules()[rule]
    plant = replace(flown.plant, integrator=integrator, effects=WORN)
    flown = replace(flown, plant=plant)
    flight, branch = om.SteppedFlight(flown, seed=3), om.SteppedFlight(flown, seed=3)
    step(flight, 40)
    state = flight.stored_state()
    branch.restore(state)
    assert branch.stored_state() == state
    step(flight, 40)
    step(branch, 40)
    assert_same_rows(flight, branch, 160)
    flight.restore(state)  # and back in time
    step(flight, 40)
    assert_same_rows(flight, branch, 160)
    assert flight.stored_state() == branch.stored_state()


def test_the_attitude_that_gives_way_is_part_of_the_state() -> None:
    quadrotor = om.load_scenario("tour").for_vehicle(om.load_vehicle("quadrotor"))
    assert quadrotor.attitude_gives_way
    flight, branch = om.SteppedFlight(quadrotor), om.SteppedFlight(quadrotor)
    step(flight, 30)
    branch.restore(flight.stored_state())
    step(flight, 30)
    step(branch, 30)
    assert flight.stored_state() == branch.stored_state()


def test_rows_that_a_branch_has_not_flown_are_no_numbers() -> None:
    flight, branch = om.SteppedFlight(scenario()), om.SteppedFlight(scenario())
    step(flight, 10)
    step(branch, 4)
    branch.restore(flight.stored_state())
    step(branch, 1)
    run = branch.as_run()
    assert np.isfinite(run.p_WB[:16]).all()
    assert np.isnan(run.p_WB[16:40]).all()
    assert np.isfinite(run.p_WB[40:]).all()
    assert "restored" in run.provenance.scenario_text


VERSION, ROTORS, HASH, HEADER = 0, 16, 56, 64


def with_its_hash(state: bytes) -> bytes:
    """As one who meant it would have stored it: with the hash (FNV-1a) of its numbers."""
    number = 0xCBF29CE484222325
    for byte in state[HEADER:]:
        number = (number ^ byte) * 0x100000001B3 % 2**64
    return state[:HASH] + struct.pack("<Q", number) + state[HEADER:]


def of_another_version(state: bytes) -> bytes:
    return bytes([state[VERSION] ^ 1]) + state[1:]


def of_more_rotors(state: bytes) -> bytes:
    return state[:ROTORS] + struct.pack("<q", 9) + state[ROTORS + 8 :]


def at_a_negative_step(state: bytes) -> bytes:
    return with_its_hash(state[:HEADER] + struct.pack("<q", -1) + state[HEADER + 8 :])


def beyond_the_end(state: bytes) -> bytes:
    return with_its_hash(state[:HEADER] + struct.pack("<q", 2**40) + state[HEADER + 8 :])


def after_more_commands_than_there_are_numbers(state: bytes) -> bytes:
    """Whose next commands would be counted past the largest number, to places before the first."""
    return with_its_hash(state[:-16] + struct.pack("<qq", 2**63 - 3, 2**63 - 1))


@pytest.mark.parametrize(
    ("spoil", "why"),
    [
        (of_another_version, "another version of omnimorph"),
        (of_more_rotors, "another flight: rotors, servos, delay"),
        (at_a_negative_step, "broken"),
        (beyond_the_end, "broken"),
        (after_more_commands_than_there_are_numbers, "broken"),
        (lambda state: state[:-1], "broken"),
        (lambda state: state + b"\0", "broken"),
        (lambda state: b"", "broken"),
        (lambda state: b"\0" * len(state), "another version"),
        (lambda state: b"\xff" * len(state), "another version"),
    ],
)
def test_states_that_do_not_fit_are_refused(spoil: Callable[[bytes], bytes], why: str) -> None:
    flight = om.SteppedFlight(scenario())
    step(flight, 3)
    state = flight.stored_state()
    with pytest.raises(ScenarioError, match=f"cannot be used, because it .*{why}"):
        flight.restore(spoil(state))
    assert flight.stored_state() == state  # nothing has changed
    step(flight, 2)


def test_a_state_with_a_delay_is_not_one_without() -> None:
    delayed, direct = om.SteppedFlight(scenario()), om.SteppedFlight(scenario((NOISE,)))
    with pytest.raises(ScenarioError, match="rotors, servos, delay or time steps differ"):
        direct.restore(delayed.stored_state())
    assert len(direct.stored_state()) < 2000 < 8000 < len(delayed.stored_state())


@pytest.mark.parametrize("other", [{"physics_step": 2e-3}, {"control_period": 2e-3}])
def test_a_state_is_one_of_the_same_time_steps(other: dict[str, Any]) -> None:
    """They count its time, and the control steps in which it decides."""
    flight = om.SteppedFlight(scenario())
    step(flight, 3)
    plant = replace(scenario().plant, **other)
    with pytest.raises(ScenarioError, match="delay or time steps differ"):
        om.SteppedFlight(replace(scenario(), plant=plant)).restore(flight.stored_state())


@pytest.mark.parametrize("state", [None, "state", 3.5, [0.5], 3, 2**62, {1: 2}])
def test_a_state_is_bytes(state: object) -> None:
    with pytest.raises(ScenarioError, match="the state of the flight cannot be used"):
        om.SteppedFlight(scenario()).restore(state)  # type: ignore[arg-type]


def test_any_bytes_after_the_header_are_read_or_refused() -> None:
    """Whatever they are, the flight goes on or says why not; counts cannot lead out of memory."""
    flight = om.SteppedFlight(scenario())
    step(flight, 3)
    state, random = flight.stored_state(), np.random.default_rng(1)
    for _ in range(200):
        spoilt = bytearray(state)
        for at in random.integers(HEADER, len(state), size=random.integers(1, 40)):
            spoilt[at] = random.integers(256)
        try:
            flight.restore(with_its_hash(bytes(spoilt)))
        except ScenarioError:
            flight.restore(state)
        if not flight.is_over:
            flight.step()
