"""The plant that is stepped from Python: how it begins anew, and what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import omnimorph as om
from omnimorph.errors import ScenarioError, VehicleError
from omnimorph.protocols import Plant
from omnimorph.simulation.fly import measurement_noise

VEHICLE = om.load_vehicle("omnimorph")
REST = om.Command(np.zeros(8), np.zeros(1))
UPRIGHT = (np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))
MOVING = om.State(np.ones(3), np.eye(3)[[1, 2, 0]], np.array([0.5, 0.0, -1.0]), np.full(3, 0.25))
THRUST = np.linspace(1.0, 2.0, 8)


def plant(**given: Any) -> om.SimulatedPlant:
    return om.SimulatedPlant(VEHICLE, om.PlantModel(), **given)


@pytest.mark.parametrize("rotor", [1.0, np.float64(2.0), True, "1", None, -1, 8, 2**70, [1]])
def test_a_rotor_is_one_of_the_vehicle(rotor: Any) -> None:
    with pytest.raises(ScenarioError, match=r"rotor is .* a number from 0 to 7"):
        plant().hub_load(rotor)
    assert plant().hub_load(np.int64(7)).shape == (6,)  # type: ignore[arg-type]


@pytest.mark.parametrize("steps", [1.5, float("nan"), "1", None, True, -1, 2**40])
def test_steps_are_a_whole_number(steps: Any) -> None:
    with pytest.raises(ScenarioError, match=r"plant: steps is .* an integer"):
        plant().step_physics(steps)


@pytest.mark.parametrize("push", [None, np.zeros(5), np.full(6, np.inf)])
def test_a_push_is_a_wrench(push: Any) -> None:
    with pytest.raises(ScenarioError, match=r"push is .* six finite numbers"):
        plant().step_physics(1, push)


@pytest.mark.parametrize("command", [None, 3, REST[:1], (*REST, 0.0), (REST.tilt, REST.thrust)])
def test_a_command_has_a_thrust_a_rotor_and_a_tilt_a_servo(command: Any) -> None:
    with pytest.raises(ScenarioError, match="command cannot be used, because"):
        plant().step(command)


@pytest.mark.parametrize("seed", [-1, 1.5, 2**64, None, "a", True])
@pytest.mark.parametrize("which", ["seed", "flight"])
def test_noise_is_that_of_an_integer(which: str, seed: Any) -> None:
    with pytest.raises(ScenarioError, match=rf"plant: {which} is .* an integer"):
        plant(**{which: seed})


@pytest.mark.parametrize("start", [3, UPRIGHT[:3], (*UPRIGHT[:2], np.zeros(2), np.zeros(4))])
def test_a_start_is_a_state(start: Any) -> None:
    with pytest.raises(ScenarioError, match=r"start is .* a State of finite numbers"):
        plant(start=start)


# --- beginning anew ------------------------------------------------------------------------------


def test_it_is_a_plant_that_can_be_flown() -> None:
    """mypy checks the assignment; what it promises is there."""
    flown: Plant = om.SimulatedPlant(VEHICLE, om.load_plant("realistic"))
    flown.reset(MOVING, np.array([0.2]), THRUST, 3)
    flown.send(om.Command(THRUST, np.array([0.2])))
    flown.step_physics(4, np.zeros(6))
    motion = flown.motion
    assert flown.control_period == 4 * flown.physics_step == 4e-3
    assert motion.speed is not None
    assert motion.tilt is not None
    np.testing.assert_array_equal(motion.speed, flown.speed)
    np.testing.assert_array_equal(motion.tilt, flown.tilt)
    assert flown.wrench.shape == (6,)


@pytest.mark.parametrize("seed", [0, 7, 2**64 - 1, 2**64, 5 << 64 | 7, 2**96 - 1])
def test_one_that_begins_anew_is_a_new_one_to_the_last_bit(seed: int) -> None:
    noise = om.effects.MeasurementNoise(position=1e-3, attitude=1e-2, filtered=True)
    delay = om.effects.CommandDelay(time=3e-3)
    model = om.PlantModel(effects=(noise, delay, om.effects.RotorLag(up=0.01, down=0.02)))
    flight, low = divmod(seed, 2**64)
    new = om.SimulatedPlant(
        VEHICLE,
        model,
        start=MOVING,
        start_tilt=0.2,
        start_thrust=THRUST,
        seed=low,
        flight=flight,
    )
    used = om.SimulatedPlant(VEHICLE, model, seed=99)
    for _ in range(5):
        used.step(om.Command(THRUST[::-1], np.array([-0.5])))
    used.reset(MOVING, np.array([0.2]), THRUST, seed)
    assert used.stored_state() == new.stored_state()
    for _ in range(5):
        for one, same in zip(new.step(REST), used.step(REST), strict=True):
            np.testing.assert_array_equal(one, same)
    assert used.stored_state() == new.stored_state()


@pytest.mark.parametrize(("seed", "flight"), [(7, 0), (7, 5), (2**64 - 1, 2**32 - 1)])
def test_its_seed_holds_the_number_of_the_flight(seed: int, flight: int) -> None:
    noise = om.effects.MeasurementNoise(position=1e-3)
    flown = om.SimulatedPlant(VEHICLE, om.PlantModel(effects=(noise,)))
    flown.reset(MOVING, 0.0, THRUST, flight << 64 | seed)
    error = 1e-3 * measurement_noise(seed, flight, 1)[0, :3]
    np.testing.assert_allclose(flown.measure().p_WB, MOVING.p_WB + error, rtol=1e-15)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"state": UPRIGHT[:3]}, "start is .* a State of finite numbers"),
        ({"state": MOVING._replace(p_WB=np.full(3, np.nan))}, "start is .* a State of finite"),
        ({"state": MOVING._replace(R_WB=2 * np.eye(3))}, "attitude of the start is"),
        ({"tilt": np.zeros(2)}, "tilt is .* one finite angle"),
        ({"thrust": THRUST[1:]}, "start_thrust is .* 8 finite numbers"),
        ({"thrust": "much"}, "start_thrust is .much., but it must be 8 finite numbers"),
        ({"seed": -1}, "seed is -1, but it must be an integer from 0"),
        ({"seed": 2**96}, "seed is .* an integer from 0"),
        ({"seed": 0.5}, "seed is 0.5, but it must be an integer from 0"),
    ],
)
def test_what_it_cannot_begin_with_is_refused_and_changes_nothing(given: Any, why: str) -> None:
    begun = plant()
    begun.step(REST)
    before = begun.stored_state()
    with pytest.raises((ScenarioError, VehicleError), match=why):
        begun.reset(**{"state": MOVING, "tilt": 0.0, "thrust": THRUST, "seed": 0} | given)
    assert begun.stored_state() == before
