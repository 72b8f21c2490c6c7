"""Plants and controllers are copied, pickled and stored in mid-air, and go on the same."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any, Literal, TypeVar

import numpy as np
import pytest
from tests.physics.test_many_flights import rules
from tests.unit.test_effects import EXAMPLES

import omnimorph as om
from omnimorph.design.writing import vehicle_text
from omnimorph.errors import ScenarioError
from omnimorph.protocols import FloatArray
from omnimorph.simulation.plant import INTEGRATORS

PERIODS = 10
STILL = om.Desired(np.zeros(3), np.eye(3), *np.zeros((4, 3)))
WORN = om.PlantModel(physics_step=1e-3, control_period=4e-3, effects=EXAMPLES)
Integrator = Literal["semi-implicit-euler", "runge-kutta-4"]
Part = TypeVar("Part", om.SimulatedPlant, om.PoseController)


def restored(part: Part) -> Part:
    """Return one of the same settings that was in another state before."""
    other = copy.copy(part)
    if isinstance(other, om.SimulatedPlant):
        other.step(om.Command(np.zeros(8), np.zeros(1)))
    else:
        other(0.0, om.State(*STILL[:4])._replace(p_WB=np.ones(3)), STILL)
    other.restore(part.stored_state())
    return other


BRANCHES: dict[str, Callable[[Any], Any]] = {
    "copied": copy.copy,
    "deep-copied": copy.deepcopy,
    "pickled": lambda part: pickle.loads(pickle.dumps(part)),
    "restored": restored,
}


def fly(plant: om.SimulatedPlant, first: int) -> list[FloatArray]:
    """Go on under commands that change in each period; return what was measured."""
    rows = []
    for k in range(first, first + PERIODS):
        thrust = 1.6 + np.cos(k + np.arange(8.0))
        measured = plant.step(om.Command(thrust, np.array([0.3 * np.sin(k)])))
        rows += [part.ravel() for part in (*measured, plant.speed, plant.tilt, plant.wrench)]
    return rows


def steer(controller: om.PoseController, first: int) -> list[FloatArray]:
    """Step a controller that hovers and shall move a little; return all that it answers."""
    rows = []
    state = om.State(*STILL[:4])
    for k in range(first, first + PERIODS):
        acceleration = np.array([0.05 * np.sin(0.3 * k), 0.05 * np.cos(0.4 * k), 0.1])
        a = controller.step(state, STILL._replace(a_WB=acceleration))
        rows += [a.thrust, a.tilt, a.active, a.wrench_asked, np.array([a.cost, a.kkt_residual])]
    return rows


def plant_in_mid_air(integrator: Integrator = "semi-implicit-euler") -> om.SimulatedPlant:
    plant = om.SimulatedPlant("omnimorph", replace(WORN, integrator=integrator), seed=5, flight=3)
    fly(plant, 0)
    return plant


scenario_of = cache(rules)


def controller_in_mid_air(rule: str = "jointly") -> om.PoseController:
    controller = scenario_of()[rule].build_controller()
    steer(controller, 0)
    return controller


@pytest.mark.parametrize("branched", BRANCHES)
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_branch_of_a_plant_flies_the_same_to_the_last_bit(
    integrator: Integrator, branched: str
) -> None:
    """With all effects: noise, filters, lags, and commands under way."""
    plant = plant_in_mid_air(integrator)
    before = plant.stored_state()
    branch = BRANCHES[branched](plant)
    assert branch.stored_state() == before
    flown = fly(branch, PERIODS)
    assert plant.stored_state() == before  # which has not moved with its branch
    np.testing.assert_array_equal(np.concatenate(fly(plant, PERIODS)), np.concatenate(flown))
    assert plant.stored_state() == branch.stored_state() != before


@pytest.mark.parametrize("branched", BRANCHES)
@pytest.mark.parametrize("rule", sorted(rules()))
def test_a_branch_of_a_controller_answers_the_same_to_the_last_bit(
    rule: str, branched: str
) -> None:
    """Beginning with empty caches, beside one that has its own."""
    controller = controller_in_mid_air(rule)
    before = controller.stored_state()
    branch = BRANCHES[branched](controller)
    answers = steer(branch, PERIODS)
    assert controller.stored_state() == before
    np.testing.assert_array_equal(
        np.concatenate(steer(controller, PERIODS)), np.concatenate(answers)
    )
    assert controller.stored_state() == branch.stored_state() != before


def test_the_attitude_that_gives_way_goes_into_a_branch() -> None:
    gains, rule = om.TrackingGains(), scenario_of()["fixed"].allocator
    controller = om.PoseController("quadrotor", gains, rule, 4e-3, lateral_force=0.0)
    steer(controller, 0)
    branch = pickle.loads(pickle.dumps(controller))
    for one, other in zip(steer(controller, PERIODS), steer(branch, PERIODS), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_branch_flies_the_same_in_another_process() -> None:
    plant, controller = plant_in_mid_air("runge-kutta-4"), controller_in_mid_air()
    code = (
        "import pickle, sys\n"
        "from tests.unit.test_branches import PERIODS, fly, steer\n"
        "plant, controller = pickle.load(sys.stdin.buffer)\n"
        "rows = fly(plant, PERIODS) + steer(controller, PERIODS)\n"
        "sys.stdout.buffer.write(pickle.dumps((rows, plant, controller)))\n"
    )
    sent = pickle.dumps((plant, controller))
    done = subprocess.run([sys.executable, "-c", code], input=sent, capture_output=True, check=True)
    rows, *ends = pickle.loads(done.stdout)
    here = fly(plant, PERIODS) + steer(controller, PERIODS)
    np.testing.assert_array_equal(np.concatenate(rows), np.concatenate(here))
    assert [end.stored_state() for end in ends] == [
        plant.stored_state(),
        controller.stored_state(),
    ]


def test_what_a_subclass_adds_goes_with_it() -> None:
    class Named(om.SimulatedPlant):
        pass

    plant = Named("omnimorph", WORN)
    plant.nickname = "Otto"  # type: ignore[attr-defined]
    branch = copy.deepcopy(plant)
    assert type(branch) is Named
    assert vars(branch)["nickname"] == "Otto"


@pytest.mark.parametrize(
    "record",
    [
        om.load_vehicle("omnimorph"),
        om.load_vehicle("omav-12"),
        om.load_plant("realistic"),
        WORN,
        om.load_scenario("tour"),
        om.load_scenario("paper-case-b").for_vehicle("omnimorph-2026"),
    ],
    ids=lambda record: f"{type(record).__name__} {record.name}",
)
@pytest.mark.parametrize("branched", ["copied", "deep-copied", "pickled"])
def test_a_copy_of_a_record_is_what_it_is(record: Any, branched: str) -> None:
    again = BRANCHES[branched](record)
    assert type(again) is type(record)
    if isinstance(record, om.Vehicle):
        assert vehicle_text(again) == vehicle_text(record)
    else:
        assert again.as_file() == record.as_file()


# --- what is refused -----------------------------------------------------------------------------


@cache
def plant_state() -> bytes:
    return plant_in_mid_air().stored_state()


@cache
def controller_state() -> bytes:
    return controller_in_mid_air().stored_state()


def flight_state() -> bytes:
    flown = replace(om.load_scenario("paper-case-b"), plant=WORN)
    return om.SteppedFlight(flown).stored_state()


def assert_refused(part: om.SimulatedPlant | om.PoseController, state: Any, why: str) -> None:
    before = part.stored_state()
    with pytest.raises(ScenarioError, match=rf"^the state of the {part.kind} cannot be .*{why}"):
        part.restore(state)
    assert part.stored_state() == before


@pytest.mark.parametrize("kind", ["plant", "controller"])
def test_changed_and_shortened_bytes_are_refused(kind: str) -> None:
    part: om.SimulatedPlant | om.PoseController
    if kind == "plant":
        part, state = om.SimulatedPlant("omnimorph", WORN), plant_state()
    else:
        part, state = scenario_of()["jointly"].build_controller(), controller_state()
    random = np.random.default_rng(7)
    for at in (*range(70), *random.integers(len(state), size=200)):
        changed = bytearray(state)
        changed[at] ^= 1 << int(random.integers(8))
        assert_refused(part, bytes(changed), "because it (is|was) ")
    for length in (0, 1, 63, 64, 65, len(state) - 1):
        assert_refused(part, state[:length], "because it is broken")
    assert_refused(part, state + b"\0", "because it is broken")
    part.restore(state)
    assert part.stored_state() == state


@pytest.mark.parametrize("state", [None, "state", 3.5, [0.5], 3, {1: 2}])
def test_a_state_is_bytes(state: object) -> None:
    assert_refused(om.SimulatedPlant("omnimorph", WORN), state, "must be what a plant like it has")


def test_a_state_is_not_that_of_something_else() -> None:
    plant = om.SimulatedPlant("omnimorph", WORN)
    for foreign in (controller_state(), flight_state()):
        assert_refused(plant, foreign, "not stored by a plant; it must be")
    controller = scenario_of()["jointly"].build_controller()
    for foreign in (plant_state(), flight_state()):
        assert_refused(controller, foreign, "not stored by a controller; it must be")
    flight = om.SteppedFlight(replace(om.load_scenario("paper-case-b"), plant=WORN))
    with pytest.raises(ScenarioError, match="not stored by a flight; it must be"):
        flight.restore(plant_state())


@pytest.mark.parametrize(
    "other",
    [
        om.SimulatedPlant("quadrotor", om.PlantModel(physics_step=1e-3, control_period=4e-3)),
        om.SimulatedPlant("omnimorph", replace(WORN, effects=())),  # without a delay
        om.SimulatedPlant("omnimorph", replace(WORN, control_period=2e-3)),
        om.SimulatedPlant("omnimorph", replace(WORN, physics_step=2e-3)),
    ],
)
def test_a_state_is_one_of_the_same_counts_and_times(other: om.SimulatedPlant) -> None:
    assert_refused(other, plant_state(), "rotors, servos, delay or time steps differ; it must be")


def test_a_state_of_a_controller_is_one_of_the_same_period() -> None:
    scenario = scenario_of()["jointly"]
    slower = replace(scenario, plant=replace(scenario.plant, control_period=8e-3))
    assert_refused(slower.build_controller(), controller_state(), "time steps differ; it must be")
