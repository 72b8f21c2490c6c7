"""The acceleration that a plant says it has is that of its motion."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.test_python_in_the_loop import short_scenario

import omnimorph as om
from omnimorph import effects
from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects import Effect
from omnimorph.verification.setting import rotor_momentum_B, tumbling

STEP = 1e-5  # s
FORCES: tuple[Effect, ...] = (
    effects.ConstantWrench(force=(1.0, -2.0, 0.5), torque=(0.05, 0.0, -0.1)),
    effects.SineWrench(force=(0.0, 3.0, 0.0), torque=(0.2, 0.0, 0.0), frequency=9.0, phase=0.4),
    effects.WrenchProfile(times=(0.0, 0.1), force=((0.0, 0.0, 1.0), (2.0, 0.0, 0.0))),
)
TRUTH: tuple[Effect, ...] = (
    effects.ModelMismatch(mass=1.1, inertia=0.8, thrust_coefficient=0.9),
    effects.Effectiveness(share=(1.0, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 0.25)),
    effects.Interference(model="blade-element"),
)
KINDS: dict[str, tuple[Effect, ...]] = {
    "nothing else": (),
    "forces": FORCES,
    "another truth": TRUTH,
    "momentum of the rotors": (effects.RotorMomentum(),),
    "all": (*FORCES, *TRUTH, effects.RotorMomentum()),
}


def tumbling_plant(*kinds: Effect) -> om.SimulatedPlant:
    """Return a plant whose actuators stand still at unequal thrusts, its body tumbling."""
    model = om.PlantModel(
        physics_step=STEP, control_period=STEP, integrator="runge-kutta-4", effects=kinds
    )
    thrust = np.linspace(-1.0, 4.0, 8)
    return om.SimulatedPlant(
        "omnimorph", model, start=tumbling(), start_tilt=0.6, start_thrust=thrust
    )


def rates(state: om.State) -> FloatArray:
    return np.concatenate([state.v_WB, state.w_WB_B])


@pytest.mark.parametrize("kinds", KINDS.values(), ids=KINDS)
def test_it_is_the_rate_at_which_the_motion_changes(kinds: tuple[Effect, ...]) -> None:
    """By central differences over 0.2 ms, 4 ms after the start."""
    plant = tumbling_plant(*kinds)
    before = rates(plant.step_physics(400))
    plant.step_physics(10)
    said, in_motion = plant.acceleration, plant.motion.acceleration
    after = rates(plant.step_physics(10))
    change = (after - before) / (20 * STEP)
    np.testing.assert_allclose(said, change, rtol=0.0, atol=1e-6 * np.abs(change).max())
    np.testing.assert_array_equal(in_motion, said)


def test_each_effect_counts() -> None:
    alone = tumbling_plant().acceleration
    for effect in (*FORCES[:2], *TRUTH, effects.RotorMomentum()):
        assert np.abs(tumbling_plant(effect).acceleration - alone).max() > 1e-2, effect.kind
    profile = tumbling_plant(FORCES[2])
    profile.step_physics(100)
    bare = tumbling_plant()
    bare.step_physics(100)
    assert np.abs(profile.acceleration - bare.acceleration).max() > 1e-2


@pytest.mark.parametrize("plant", ["perfect", "realistic"])
def test_thrust_and_acceleration_are_those_of_a_flight(plant: str) -> None:
    """Of the flight whose commands it is given; Newton's and Euler's equations by its columns."""
    scenario = short_scenario(plant=plant)
    run = om.fly(scenario, seed=4)
    flown = om.SimulatedPlant(
        scenario.vehicle,
        scenario.plant,
        start=om.State(*scenario.reference(0.0)[:4]),
        start_tilt=scenario.tilt,
    )
    truth = scenario.plant.true_vehicle(scenario.vehicle)
    every = round(scenario.plant.control_period / scenario.plant.physics_step)
    for k in range(len(run.time) - 1):
        if k % every == 0:
            flown.send(om.Command(run.thrust_command[k], run.tilt_command[k]))
        np.testing.assert_array_equal(flown.thrust, run.thrust_actual[k])
        wrench, w = run.wrench_achieved[k], run.w_WB_B[k]
        momentum = truth.inertia @ w
        if any(isinstance(effect, effects.RotorMomentum) for effect in scenario.plant.effects):
            momentum = momentum + rotor_momentum_B(truth, flown)
        expected = [
            run.R_WB[k] @ wrench[:3] / truth.mass - [0.0, 0.0, 9.81],
            np.linalg.solve(truth.inertia, wrench[3:] - np.cross(w, momentum)),
        ]
        np.testing.assert_allclose(
            flown.acceleration, np.concatenate(expected), rtol=0.0, atol=1e-10
        )
        flown.step_physics()
