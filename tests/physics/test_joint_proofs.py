"""Joint allocation proves every answer, however far its servos can turn in one control step.

φ(α), the least cost at given tilts, has kinks in its slope where a thrust reaches a limit, and
curves downwards in places. Fast servos reach across many of them in one step.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from tests.physics.small_vehicles import random_tilting_vehicle
from tests.unit.joint_parts import Problem, Situation, random_situation

import omnimorph as om
from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import FloatArray
from omnimorph.reference.segments import Segment, SegmentReference

PERIOD = 4e-3
PROOF = 1e-9
"""An allocation whose KKT residual is not larger proves itself."""
FOURTEEN = Path(__file__).with_name("fourteen_rotors.toml")


def with_servos_of(vehicle: Vehicle, rate: float) -> Vehicle:
    """Return the vehicle with servos that turn at so many rad/s."""
    return vehicle.replace(servo_rate_max=np.full(vehicle.n_servos, rate))


@pytest.mark.parametrize("rate", [30.0, 100.0])
@pytest.mark.parametrize("name", ["voliro", "tilting-quad", "omav-12"])
def test_tours_with_fast_servos(name: str, rate: float) -> None:
    vehicle = with_servos_of(om.load_vehicle(name), rate)
    run = om.fly(om.load_scenario("tour").for_vehicle(vehicle), seed=4)
    assert run.outcome is om.Outcome.COMPLETED
    assert run.metrics.unproven_steps == 0
    assert run.kkt_residual.max() <= PROOF


@pytest.mark.parametrize("rate", [10.0, 20.0, 50.0, 94.4])
def test_fourteen_one_way_rotors(rate: float) -> None:
    move = np.random.default_rng(5).normal(size=3) * 0.2
    leg = Segment(0.4, move, (0.0, 0.0, 1.0), 0.3)
    scenario = om.load_scenario("tour").for_vehicle(with_servos_of(om.load_vehicle(FOURTEEN), rate))
    reference = SegmentReference((0.0, 0.0, 1.0), np.eye(3), [leg])
    for seed in range(6):
        assert om.fly(scenario, reference=reference, seed=seed).metrics.unproven_steps == 0


def random_case(seed: int) -> tuple[Vehicle, om.JointTilt]:
    """Draw a vehicle, its weights, and whether its rotors turn both ways."""
    draw = np.random.default_rng(seed)
    n = int(draw.integers(2, 19))
    m = int(draw.integers(2, n + 1))
    vehicle = random_tilting_vehicle(draw, n, m)
    size = float(np.mean(vehicle.thrust_max))
    one_way = draw.choice([True, False])
    vehicle = vehicle.replace(
        mass=n * size / 9.81 * draw.uniform(0.25, 0.6),
        speed_min=0.2 * vehicle.speed_max if one_way else vehicle.speed_min,
        servo_rate_max=np.exp(draw.uniform(0.0, np.log(100.0), m)),
        servo_angle_min=-draw.uniform(0.1, 3.2, m),
        servo_angle_max=draw.uniform(0.1, 3.2, m),
    )
    per_Hz4 = (np.mean(vehicle.thrust_coefficient) * (2.0 * np.pi) ** 2 / size) ** 2
    W1, W3 = np.exp(draw.uniform(np.log(1e-3), 0.0, 2)) * per_Hz4
    W2 = float(np.exp(draw.uniform(0.0, np.log(1e3))))
    W4 = float(draw.choice([0.0, np.exp(draw.uniform(np.log(1e-4), np.log(1e-1)))]))
    weights = {"W2_position": (W2,) * 3, "W2_attitude": (0.01 * W2,) * 3}
    return vehicle, om.JointTilt(W1=float(W1), W3=float(W3), W4=W4, **weights)


def demands(
    draw: np.random.Generator, vehicle: Vehicle, count: int
) -> Iterator[tuple[om.State, FloatArray]]:
    """Yield what is asked step after step: mostly little by little, now and then far away."""
    now = random_situation(draw, vehicle)
    acceleration = now.acceleration
    for _ in range(count):
        if draw.random() < 0.3:
            now = random_situation(draw, vehicle)
            acceleration = 2.0 * now.acceleration
        acceleration = 0.95 * acceleration + draw.normal(size=6) * np.repeat([0.3, 1.0], 3)
        yield now.state, acceleration


def unproven(seed: int, count: int) -> list[float]:
    """Return the residuals that are too large, over so many demands of one random vehicle.

    The last answer is also proved without the core, by the gradient of J in NumPy.
    """
    vehicle, rule = random_case(seed)
    rest = np.zeros(vehicle.n_servos)
    start = np.clip(rest, vehicle.servo_angle_min, vehicle.servo_angle_max)
    thrust = 0.3 * vehicle.thrust_max
    controller = om.PoseController(vehicle, om.TrackingGains(), rule, PERIOD, start, thrust)
    found, before = [], (thrust, start)
    for state, acceleration in demands(np.random.default_rng(seed + 1), vehicle, count):
        answer = controller.allocate(acceleration, state)
        asked = Situation(state, acceleration, *before)
        before = (np.array(answer.thrust), np.array(answer.tilt))
        if not answer.kkt_residual <= PROOF:
            found.append(answer.kkt_residual)
    problem = Problem(vehicle, rule, PERIOD, asked)
    assert problem.residual(problem.point(answer)) <= 1e-8
    return found


@pytest.mark.parametrize("seed", range(0, 1000, 50))
def test_random_vehicles(seed: int) -> None:
    assert unproven(seed, 100) == []


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 500, 25))
def test_five_hundred_random_vehicles(first: int) -> None:
    assert {seed: left for seed in range(first, first + 25) if (left := unproven(seed, 1000))} == {}
