"""What the plant that is stepped from Python refuses, in one sentence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import omnimorph as om
from omnimorph.errors import ScenarioError

VEHICLE = om.load_vehicle("omnimorph")
REST = om.Command(np.zeros(8), np.zeros(1))
UPRIGHT = (np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))


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


@pytest.mark.parametrize("disturbance", [None, np.zeros(5), np.full(6, np.inf)])
def test_a_disturbance_is_a_wrench(disturbance: Any) -> None:
    with pytest.raises(ScenarioError, match=r"disturbance is .* six finite numbers"):
        plant().step_physics(1, disturbance)


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
