"""Interference in the plant is the interference of the analysis."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

import omnimorph as om
from omnimorph import effects
from omnimorph.errors import ScenarioError
from omnimorph.model.interference import WakeModel, thrust_lost
from omnimorph.protocols import FloatArray, State

VEHICLE = om.load_vehicle("omnimorph")
MODELS: tuple[WakeModel, ...] = get_args(WakeModel)
LEVEL = State(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))


def wrench_flown(
    thrust: FloatArray, tilt: float, model: WakeModel, share: float = 1.0
) -> FloatArray:
    """The wrench of a plant whose rotors have long turned as asked."""
    wakes = effects.Interference(model=model)
    plant = om.PlantModel(effects=(wakes, effects.Effectiveness(share=share)))
    flying = om.SimulatedPlant(
        VEHICLE, plant, start=LEVEL, start_tilt=tilt, start_thrust=np.ascontiguousarray(thrust)
    )
    return flying.wrench


@pytest.mark.parametrize("model", MODELS)
def test_the_wrench_is_the_thrust_kept_and_all_of_the_drag(model: WakeModel) -> None:
    numbers = np.random.default_rng(3)
    for tilt in (0.0, 0.4, 1.0):
        thrust = numbers.uniform(-5.0, 5.0, 8)
        kept = 1.0 - thrust_lost(VEHICLE, tilt, thrust, model)
        A = om.allocation_matrix(VEHICLE, tilt)
        z, drag = A[:3], -VEHICLE.rotor_spin * VEHICLE.kappa * A[:3]
        lever = np.cross(VEHICLE.rotor_position, z.T).T
        expected = np.concatenate([z @ (kept * thrust), lever @ (kept * thrust) + drag @ thrust])
        assert np.allclose(wrench_flown(thrust, tilt, model), expected, rtol=0.0, atol=1e-12)


def test_worn_rotors_lose_their_share_of_what_is_left() -> None:
    thrust = np.full(8, 2.0)
    whole, worn = (wrench_flown(thrust, 0.3, "published", share) for share in (1.0, 0.5))
    assert np.allclose(worn[:3], 0.5 * whole[:3], rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("model", MODELS)
def test_the_thrusts_that_hover_in_wakes_hold_the_vehicle(model: WakeModel) -> None:
    weight = np.array([0.0, 0.0, VEHICLE.mass * 9.81, 0.0, 0.0, 0.0])
    for tilt in (0.0, 0.5, 1.0):
        found = om.analysis.hover_in_wakes(VEHICLE, tilt, model=model)
        wrench = wrench_flown(found.thrust, tilt, model)
        assert np.allclose(wrench, weight, rtol=0.0, atol=1e-5)


def test_it_is_felt_in_flight() -> None:
    """A controller that knows nothing of it sags, and stays aloft."""
    scenario = om.load_scenario("hover")
    model = om.PlantModel(effects=(effects.Interference(),))
    still, wakes = (
        om.fly(dataclasses.replace(scenario, plant=plant)) for plant in (om.PlantModel(), model)
    )
    assert wakes.outcome is om.Outcome.COMPLETED
    assert wakes.p_WB[-1, 2] < still.p_WB[-1, 2] - 1e-3
    assert still.metrics.position_error_mean_m < 1e-4


def test_a_vehicle_without_rotors_in_line_has_none() -> None:
    split = VEHICLE.replace(rotor_position=VEHICLE.rotor_position * [1.0, 1.0, 0.0])
    spread = split.replace(rotor_position=split.rotor_position * np.repeat([1.0, 2.0], 4)[:, None])
    plant = om.PlantModel(effects=(effects.Interference(),))
    with pytest.raises(ScenarioError, match="has no two rotors in line"):
        om.SimulatedPlant(spread, plant, start=LEVEL)


def test_a_model_nobody_knows_is_refused() -> None:
    with pytest.raises(ScenarioError, match='"published" or "blade-element"'):
        effects.Interference(model="guess")  # type: ignore[arg-type]


def test_it_can_be_named_in_a_file(tmp_path: Path) -> None:
    text = (
        'schema = 1\nname = "windy"\n[plant]\neffect = [{{kind = "interference", model = "{}"}}]\n'
    )
    (tmp_path / "windy.toml").write_text(text.format("blade-element"), encoding="utf-8")
    plant = om.load_plant(tmp_path / "windy.toml")
    assert plant.effects == (effects.Interference(model="blade-element"),)
    (tmp_path / "windy.toml").write_text(text.format("guess"), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"effect\[0\].model is \"guess\", but it must be"):
        om.load_plant(tmp_path / "windy.toml")
