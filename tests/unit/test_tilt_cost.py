"""The least cost over the tilt, against NumPy and DAQP, and its door."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.physics.small_vehicles import random_tilting_vehicle
from tests.unit.tilt_searches import CASE_A, WEIGHTS, costs_shown, random_step

import omnimorph as om
from omnimorph.control.rules import RULES
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return om.load_vehicle("omnimorph")


def arguments(S: int = 3, K: int = 5) -> dict[str, Any]:
    """Return arguments for S steps at K tilts that are right in everything."""
    return {
        "rule": om.FixedTilt(**CASE_A),
        "state": np.tile(np.concatenate([np.zeros(3), np.eye(3).ravel(), np.zeros(6)]), (S, 1)),
        "acceleration": np.zeros((S, 6)),
        "previous_thrust": np.ones((S, 8)),
        "tilt": np.tile(np.linspace(0.0, 1.0, K), (S, 1)),
    }


@pytest.mark.parametrize("case", ["a", "b"])
def test_costs_are_those_of_the_textbook(vehicle: Vehicle, case: str) -> None:
    """The one is the sum over thrusts in the core, the other NumPy's over the inputs in Hz²."""
    generator = np.random.default_rng(1)
    steps = [random_step(generator, vehicle) for _ in range(12)]
    tilts = generator.uniform(0.0, np.pi / 3.0, (12, 7))  # 7: a pack of four and one not full
    reported = [
        costs_shown(vehicle, case, step, row) for step, row in zip(steps, tilts, strict=True)
    ]
    costs = om.cost_over_tilt(
        vehicle,
        om.FixedTilt(**WEIGHTS[case]),
        [step.row for step in steps],
        [step.acceleration for step in steps],
        [step.thrust for step in steps],
        tilts,
    )
    assert costs.shape == (12, 7)
    np.testing.assert_allclose(costs, reported, rtol=1e-10)


@pytest.mark.parametrize("n", [1, 4, 5, 6, 8, 12, 18])
def test_any_number_of_rotors(n: int) -> None:
    """Those with a loop of their own, and those counted at run time."""
    generator = np.random.default_rng(n)
    vehicle = random_tilting_vehicle(generator, n)
    step = random_step(generator, vehicle)
    tilts = np.linspace(-1.0, 1.0, 6)
    costs = om.cost_over_tilt(
        vehicle,
        om.FixedTilt(**WEIGHTS["b"]),
        [step.row],
        [step.acceleration],
        [step.thrust],
        [tilts],
    )
    np.testing.assert_allclose(costs[0], costs_shown(vehicle, "b", step, tilts), rtol=1e-9)


def test_the_kind_of_rule_does_not_count_and_steps_do_not_touch_one_another(
    vehicle: Vehicle,
) -> None:
    generator = np.random.default_rng(3)
    steps = [random_step(generator, vehicle) for _ in range(4)]
    rows = [np.array([step.row, step.row]) for step in steps]
    tilts = np.tile(np.linspace(0.0, 1.0, 5), (2, 1))
    search = {"span": "window", "candidates": 5}
    for kind in RULES:
        rule = kind(**CASE_A | (search if kind is om.ExhaustiveTilt else {}))
        together = om.cost_over_tilt(
            vehicle,
            rule,
            [step.row for step in steps],
            [step.acceleration for step in steps],
            [step.thrust for step in steps],
            np.tile(tilts[0], (4, 1)),
        )
        for k, step in enumerate(steps):
            wanted, thrust = [step.acceleration] * 2, [step.thrust] * 2
            alone = om.cost_over_tilt(vehicle, rule, rows[k], wanted, thrust, tilts)
            np.testing.assert_array_equal(alone, together[[k, k]])


def test_no_steps_and_no_tilts_cost_nothing(vehicle: Vehicle) -> None:
    assert om.cost_over_tilt(vehicle, **arguments(0, 5)).shape == (0, 5)
    assert om.cost_over_tilt(vehicle, **arguments(3, 0)).shape == (3, 0)


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("tilt", 0.5, "tilt.shape is (), but it must be (S, K)"),
        ("tilt", np.zeros(5), "tilt.shape is (5,), but it must be (S, K)"),
        ("tilt", "level", 'tilt is "level", but it must be an array of shape (S, K)'),
        ("tilt", [[0.0], [0.0, 1.0]], "tilt is [[0.0], [0.0, 1.0]], but it must be an array"),
        ("state", np.zeros((3, 17)), "state.shape is (3, 17), but it must be (3, 18)"),
        ("state", np.zeros((2, 18)), "state.shape is (2, 18), but it must be (3, 18)"),
        ("acceleration", np.zeros((6, 3)), "acceleration.shape is (6, 3), but it must be (3, 6)"),
        ("previous_thrust", np.zeros((3, 7)), "previous_thrust.shape is (3, 7), but it must be"),
        ("acceleration", np.full((3, 6), np.nan), "acceleration is nan, but it must be finite"),
        ("tilt", np.full((3, 5), np.inf), "tilt is inf, but it must be finite numbers"),
    ],
)
def test_arrays_that_do_not_fit(vehicle: Vehicle, name: str, value: Any, sentence: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        om.cost_over_tilt(vehicle, **arguments() | {name: value})
    assert str(caught.value).startswith(f"cost_over_tilt: {sentence}")


def test_weights_and_vehicles_that_do_not_fit(vehicle: Vehicle) -> None:
    two = random_tilting_vehicle(np.random.default_rng(0), 8, 2)
    with pytest.raises(ScenarioError, match=r"n_servos is 2, but it must be 1, so that a cost"):
        om.cost_over_tilt(two, **arguments())
    rule = om.FixedTilt(**CASE_A | {"W1": (1e-9, 1e-9)})
    with pytest.raises(ScenarioError, match="one for each of the 8 rotors"):
        om.cost_over_tilt(vehicle, **arguments() | {"rule": rule})
