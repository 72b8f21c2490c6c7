"""Parts of the loop written in Python fly in the same plant as the built-in ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import omnimorph as om
from omnimorph.errors import ScenarioError
from omnimorph.model.core import state_row
from omnimorph.protocols import FloatArray
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.run import Run
from omnimorph.simulation.fly import measurement_noise
from omnimorph.simulation.scenario import Scenario

DURATION = 0.6  # s
MOVE = (0.1, -0.1, 0.1)


def short_scenario(name: str = "paper-case-b", plant: str = "realistic") -> Scenario:
    """A case of the paper on a short way that needs the tilt."""
    scenario = om.load_scenario(name)
    way = SegmentReference(
        (0.0, 0.0, 1.0), np.eye(3), [Segment(DURATION, MOVE, (0.0, 0.6, 0.8), 0.3)]
    )
    return replace(scenario, reference=way, plant=om.load_plant(plant))


SAME = {
    **dict.fromkeys(
        ("time", "p_WB", "R_WB", "v_WB", "w_WB_B", "tilt_actual", "tilt_command"), 1e-12
    ),
    **dict.fromkeys(("desired_p_WB", "desired_R_WB", "desired_v_WB", "desired_w_WB_B"), 1e-13),
    **dict.fromkeys(("wrench_achieved", "thrust_command", "thrust_actual"), 1e-8),
    "speed": 1e-5,
}
"""How far columns may lie apart when the same arithmetic is compiled into two loops."""


def assert_same_flight(ours: Run, other: Run) -> None:
    """Both runs were completed and are the same but for rounding."""
    assert ours.outcome is other.outcome is om.Outcome.COMPLETED
    assert len(ours.time) == len(other.time)
    assert_same_rows(ours, other)


def assert_same_rows(ours: Run, other: Run) -> None:
    """All rows of the first run are those of the second, which may be longer."""
    for name, tolerance in SAME.items():
        column = getattr(ours, name)
        reported = getattr(other, name)[: len(column)]
        np.testing.assert_allclose(column, reported, rtol=0.0, atol=tolerance, err_msg=name)


class Recorder:
    """A controller that passes on to another and keeps what it was given."""

    def __init__(self, controller: Callable[..., om.Command]) -> None:
        self.controller = controller
        self.times: list[float] = []
        self.states: list[om.State] = []

    def __call__(self, time: float, state: om.State, desired: om.Desired) -> om.Command:
        self.times.append(time)
        self.states.append(state)
        return self.controller(time, state, desired)


# --- the built-in parts, called from Python ------------------------------------------------------


@pytest.mark.parametrize("plant", ["perfect", "realistic"])
@pytest.mark.parametrize("name", ["paper-case-a", "paper-case-b", "paper-fixed-45-a"])
def test_the_built_in_controller_flies_the_same_from_python(name: str, plant: str) -> None:
    scenario = short_scenario(name, plant)
    reported = om.fly(scenario, seed=3)
    ours = om.fly(scenario, seed=3, controller=scenario.build_controller())
    assert_same_flight(ours, reported)
    np.testing.assert_array_equal(ours.active, reported.active)


def test_an_allocator_that_passes_on_to_the_built_in_one_flies_the_same() -> None:
    scenario = short_scenario()
    controller = scenario.build_controller()

    def allocate(acceleration: FloatArray, state: om.State, previous: om.Command) -> om.Command:
        chosen = controller.allocate(acceleration, state)
        return om.Command(chosen.thrust, chosen.tilt)

    reported = om.fly(scenario, seed=5)
    ours = om.fly(scenario, seed=5, allocator=allocate)
    assert_same_flight(ours, reported)
    np.testing.assert_allclose(ours.wrench_asked, reported.wrench_asked, rtol=0.0, atol=1e-10)


def test_an_allocator_is_given_its_previous_command() -> None:
    scenario = short_scenario()
    controller = scenario.build_controller()
    given: list[om.Command] = []
    answers: list[om.Command] = []

    def allocate(acceleration: FloatArray, state: om.State, previous: om.Command) -> om.Command:
        chosen = controller.allocate(acceleration, state)
        given.append(previous)
        answers.append(om.Command(chosen.thrust, chosen.tilt))
        return answers[-1]

    om.fly(scenario, allocator=allocate)
    hover = scenario.vehicle.mass * 9.81 / 8.0
    np.testing.assert_allclose(given[0].thrust, hover, rtol=1e-14)
    np.testing.assert_array_equal(given[0].tilt, [0.0])
    for reported, answered in zip(given[1:], answers[:-1], strict=True):
        np.testing.assert_array_equal(reported.thrust, answered.thrust)
        np.testing.assert_array_equal(reported.tilt, answered.tilt)


class MinimumJerk:
    """The way of `short_scenario` without its turn, as one would write it in Python."""

    duration = DURATION

    def __call__(self, time: float) -> om.Desired:
        u = time / DURATION
        s = 10.0 * u**3 - 15.0 * u**4 + 6.0 * u**5
        ds = (30.0 * u**2 - 60.0 * u**3 + 30.0 * u**4) / DURATION
        dds = (60.0 * u - 180.0 * u**2 + 120.0 * u**3) / DURATION**2
        move, zero = np.array(MOVE), np.zeros(3)
        start = np.array([0.0, 0.0, 1.0])
        return om.Desired(start + s * move, np.eye(3), ds * move, zero, dds * move, zero)


@pytest.mark.parametrize("plant", ["perfect", "realistic"])
def test_a_reference_in_python_flies_like_the_segments_it_repeats(plant: str) -> None:
    straight = SegmentReference((0.0, 0.0, 1.0), np.eye(3), [Segment(DURATION, MOVE)])
    scenario = replace(short_scenario(plant=plant), reference=straight)
    reported = om.fly(scenario, seed=1)
    ours = om.fly(scenario, seed=1, reference=MinimumJerk())
    assert_same_flight(ours, reported)


@pytest.mark.parametrize("plant", ["perfect", "realistic"])
def test_a_disturbance_in_python_pushes_like_the_effect_it_repeats(plant: str) -> None:
    scenario = short_scenario(plant=plant)
    push = om.effects.ConstantWrench(force=(0.5, -0.3, 0.2), torque=(0.01, 0.0, -0.02))
    pushed_plant = replace(scenario.plant, effects=(*scenario.plant.effects, push))
    wrench = np.array([*push.force, *push.torque])
    calls: list[float] = []

    def disturb(time: float, state: om.State) -> FloatArray:
        calls.append(time)
        return wrench

    reported = om.fly(replace(scenario, plant=pushed_plant), seed=2)
    ours = om.fly(scenario, seed=2, disturbance=disturb)
    assert_same_flight(ours, reported)
    np.testing.assert_allclose(calls, np.arange(600) * 1e-3, rtol=0.0, atol=1e-12)
    undisturbed = om.fly(scenario, seed=2)
    assert np.abs(ours.p_WB - undisturbed.p_WB).max() > 1e-4


def test_a_disturbance_is_shown_the_motion_at_its_step() -> None:
    seen: list[FloatArray] = []

    def look(time: float, state: om.State) -> FloatArray:
        seen.append(state.p_WB.copy())
        return np.zeros(6)

    scenario = short_scenario()
    run = om.fly(scenario, disturbance=look)
    np.testing.assert_array_equal(np.array(seen), run.p_WB[:-1])
    assert_same_flight(run, om.fly(scenario))


def test_controller_and_disturbance_together_call_each_at_its_rate() -> None:
    scenario = short_scenario()
    controller = Recorder(scenario.build_controller())
    pushes: list[float] = []

    def disturb(time: float, state: om.State) -> FloatArray:
        pushes.append(time)
        return np.zeros(6)

    run = om.fly(scenario, controller=controller, disturbance=disturb)
    assert_same_flight(run, om.fly(scenario))
    np.testing.assert_allclose(controller.times, np.arange(150) * 4e-3, rtol=0.0, atol=1e-12)
    assert len(pushes) == 600


# --- stepping a plant ----------------------------------------------------------------------------


@pytest.mark.parametrize("plant", ["perfect", "realistic"])
def test_a_plant_stepped_from_python_flies_what_fly_flies(plant: str) -> None:
    scenario = short_scenario(plant=plant)
    reported = om.fly(scenario, seed=4, flight=2)
    start = om.State(*scenario.reference(0.0)[:4])
    stepped = om.SimulatedPlant(
        scenario.vehicle, scenario.plant, start=start, start_tilt=scenario.tilt, seed=4, flight=2
    )
    controller = scenario.build_controller()
    every = round(scenario.plant.control_period / scenario.plant.physics_step)
    state = stepped.measure()
    for k in range(0, len(reported.time) - 1, every):
        assert stepped.time == pytest.approx(reported.time[k], abs=1e-12)
        for part, column in zip(stepped.state, ("p_WB", "R_WB", "v_WB", "w_WB_B"), strict=True):
            np.testing.assert_allclose(part, getattr(reported, column)[k], rtol=0.0, atol=1e-12)
        desired = scenario.reference(k * scenario.plant.physics_step)
        state = stepped.step(controller(stepped.time, state, desired))
    np.testing.assert_allclose(stepped.state.p_WB, reported.p_WB[-1], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(stepped.speed, reported.speed[-1], rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(stepped.tilt, reported.tilt_actual[-1], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(stepped.wrench, reported.wrench_achieved[-1], rtol=0.0, atol=1e-9)


def test_a_plant_can_be_stepped_one_physics_step_at_a_time() -> None:
    vehicle, model = om.load_vehicle("omnimorph"), om.load_plant("realistic")
    command = om.Command(np.linspace(1.0, 2.0, 8), np.array([0.2]))
    whole, parts = (om.SimulatedPlant(vehicle, model) for _ in range(2))
    whole.step(command)
    parts.send(command)
    for _ in range(4):
        parts.step_physics()
    assert whole.time == parts.time == pytest.approx(4e-3, rel=1e-12)
    for one, other in zip(whole.state, parts.state, strict=True):
        np.testing.assert_array_equal(one, other)


# --- noise ---------------------------------------------------------------------------------------


def test_the_noise_of_a_flight_is_that_of_its_seed_and_number() -> None:
    scenario = short_scenario()
    for seed, flight in ((0, 0), (0, 1), (7, 0)):
        controller = Recorder(scenario.build_controller())
        run = om.fly(scenario, seed=seed, flight=flight, controller=controller)
        noise = measurement_noise(seed, flight, len(controller.states))
        for k, state in enumerate(controller.states):
            row = 4 * k
            error = state.p_WB - run.p_WB[row], state.v_WB - run.v_WB[row]
            np.testing.assert_allclose(error[0], 1e-3 * noise[k, :3], rtol=0.0, atol=1e-14)
            np.testing.assert_allclose(error[1], 1e-2 * noise[k, 3:6], rtol=0.0, atol=1e-14)
            turned = run.w_WB_B[row] + 1e-2 * noise[k, 9:]
            np.testing.assert_allclose(state.w_WB_B, turned, rtol=0.0, atol=1e-14)


def test_flights_differ_by_seed_and_by_number_and_repeat_themselves() -> None:
    scenario = short_scenario()
    first, again = om.fly(scenario, seed=1), om.fly(scenario, seed=1)
    assert first.content_hash == again.content_hash
    for other in (om.fly(scenario, seed=2), om.fly(scenario, seed=1, flight=1)):
        assert np.abs(other.p_WB - first.p_WB).max() > 1e-6


def test_looking_twice_changes_nothing() -> None:
    """Noise is drawn once a control step, also where a filter remembers the noise before."""
    vehicle = om.load_vehicle("omnimorph")
    noise = om.effects.MeasurementNoise(position=1e-3, attitude=1e-2, filtered=True)
    model = om.PlantModel(effects=(noise,))
    once, often = (om.SimulatedPlant(vehicle, model, seed=3) for _ in range(2))
    command = om.Command(np.full(8, 1.6), np.zeros(1))
    for _ in range(5):
        reported = once.step(command)
        often.step(command)
        for _ in range(3):
            np.testing.assert_array_equal(often.measure().p_WB, reported.p_WB)
            np.testing.assert_array_equal(often.measure().R_WB, reported.R_WB)
    assert np.abs(reported.p_WB - once.state.p_WB).max() > 0.0


def test_the_perfect_plant_measures_exactly() -> None:
    scenario = short_scenario(plant="perfect")
    controller = Recorder(scenario.build_controller())
    run = om.fly(scenario, controller=controller)
    np.testing.assert_array_equal([state.p_WB for state in controller.states], run.p_WB[:-1])


def test_a_replayed_flight_gives_the_commands_of_its_steps() -> None:
    scenario = om.load_scenario("hover")
    run = om.fly(scenario)
    wish = state_row(*scenario.reference(0.0))
    every = range(0, 400, 4)
    states = np.array(
        [state_row(run.p_WB[k], run.R_WB[k], run.v_WB[k], run.w_WB_B[k]) for k in every]
    )
    thrust, tilt = scenario.build_controller().replay(states, np.tile(wish, (len(states), 1)))
    alone = scenario.build_controller()
    for k, state in enumerate(states):
        answer = alone.step(state, wish)
        np.testing.assert_array_equal(thrust[k], answer.thrust)
        np.testing.assert_array_equal(tilt[k], answer.tilt)


@pytest.mark.parametrize("rows", [(3, 18, 2, 24), (3, 17, 3, 24), (3, 18, 3, 23)])
def test_a_replay_of_the_wrong_shape_is_refused(rows: tuple[int, int, int, int]) -> None:
    controller = om.load_scenario("hover").build_controller()
    with pytest.raises(ScenarioError, match="replay: shape of its arrays"):
        controller.replay(np.zeros(rows[:2]), np.zeros(rows[2:]))
