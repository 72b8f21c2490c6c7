"""The textbook loop, checked by hand: it is the oracle, so nothing else may be its judge."""

from __future__ import annotations

import math

import numpy as np
import pytest

from omnimorph import textbook
from omnimorph.design.files import load_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import Command, Desired, State


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return load_vehicle("omnimorph")


def at_rest() -> State:
    return State(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))


def test_exponential_of_a_quarter_turn_about_z() -> None:
    R = textbook.exp_so3(np.array([0.0, 0.0, math.pi / 2.0]))
    np.testing.assert_allclose(R, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)


@pytest.mark.parametrize("angle", [0.0, 1e-170, 1e-9, 1e-3, 1.0, 3.0])
def test_exponential_is_a_rotation_by_its_angle(angle: float) -> None:
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    R = textbook.exp_so3(angle * axis)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(R @ axis, axis, atol=1e-15)
    np.testing.assert_allclose(
        0.5 * textbook.vee(R - R.T), math.sin(angle) * axis, rtol=1e-14, atol=1e-16
    )


def test_hat_is_the_cross_product() -> None:
    a, b = np.array([1.0, 2.0, 3.0]), np.array([-4.0, 5.0, 0.5])
    np.testing.assert_array_equal(textbook.hat(a) @ b, np.cross(a, b))
    np.testing.assert_array_equal(textbook.vee(textbook.hat(a)), a)


def test_minimum_jerk_by_hand() -> None:
    assert textbook.minimum_jerk(0.0) == (0.0, 0.0, 0.0)
    assert textbook.minimum_jerk(0.5) == (0.5, 1.875, 0.0)
    assert textbook.minimum_jerk(1.0) == (1.0, 0.0, 0.0)


def test_the_paper_reference_returns_level_after_45_seconds() -> None:
    reference = textbook.paper_reference()
    assert reference.duration == 45.0
    end = reference(45.0)
    np.testing.assert_allclose(end.p_WB, [0.0, 0.0, 1.6], atol=1e-14)
    np.testing.assert_allclose(end.R_WB, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(reference(4.5).p_WB, [0.0, 0.0, 1.6], atol=1e-14)
    tilted = textbook.exp_so3(np.array([math.radians(30.0), 0.0, 0.0]))
    np.testing.assert_allclose(reference(17.0).R_WB, tilted, atol=1e-15)


@pytest.mark.parametrize("time", [1.0, 7.3, 12.9, 15.0, 22.0])
def test_velocities_of_a_reference_are_the_derivatives_of_its_pose(time: float) -> None:
    turned = textbook.Segment(20.0, displacement=(1.0, -2.0, 0.5), rotation=(0.3, 1.0, -0.7))
    reference = textbook.SegmentedReference((0.0, 0.0, 1.0), (turned, turned))
    h = 1e-4
    before, now, after = reference(time - h), reference(time), reference(time + h)
    R_rate = (after.R_WB - before.R_WB) / (2.0 * h)
    np.testing.assert_allclose((after.p_WB - before.p_WB) / (2.0 * h), now.v_WB, atol=1e-8)
    np.testing.assert_allclose((after.v_WB - before.v_WB) / (2.0 * h), now.a_WB, atol=1e-8)
    np.testing.assert_allclose(textbook.vee(now.R_WB.T @ R_rate), now.w_WB_B, atol=1e-8)
    np.testing.assert_allclose((after.w_WB_B - before.w_WB_B) / (2.0 * h), now.dw_WB_B, atol=1e-8)


@pytest.mark.parametrize("tilt_deg", [0.0, 25.0, 54.7356, 90.0])
def test_allocation_matrix_is_the_one_of_the_geometry(vehicle: Vehicle, tilt_deg: float) -> None:
    s, c = math.sin(math.radians(tilt_deg)), math.cos(math.radians(tilt_deg))
    # x and y of each hub, then its thrust axes in the upper and in the lower layer.
    axes = {
        (1, 1): ((-s, 0, c), (s, 0, c)),
        (-1, 1): ((0, -s, c), (0, s, c)),
        (-1, -1): ((s, 0, c), (-s, 0, c)),
        (1, -1): ((0, s, c), (0, -s, c)),
    }
    kappa = 2.754e-6 / 1.8638e-4
    A = textbook.allocation_matrix(vehicle, np.radians([tilt_deg]))
    for i, hub in enumerate(vehicle.rotor_position):
        x, y, z = np.sign(hub).astype(int).tolist()
        force = np.array(axes[x, y][0 if z > 0 else 1])
        np.testing.assert_allclose(A[:3, i], force, atol=1e-15)
        torque = np.cross(0.1062 * np.array([x, y, z]), force) + x * y * kappa * force
        np.testing.assert_allclose(A[3:, i], torque, atol=1e-15)


def test_without_any_error_the_reference_acceleration_is_the_desired_one() -> None:
    R, w = textbook.exp_so3(np.array([0.4, -0.2, 1.0])), np.array([0.1, 0.2, 0.3])
    desired = Desired(np.ones(3), R, np.zeros(3), w, np.array([1.0, 2, 3]), np.array([4.0, 5, 6]))
    q_r = textbook.reference_acceleration(State(*desired[:4]), desired, textbook.PAPER_GAINS)
    np.testing.assert_allclose(q_r, [1, 2, 3, 4, 5, 6], atol=1e-14)


def test_feedback_has_the_papers_gains() -> None:
    angle = 0.1
    desired = Desired(
        np.array([1.0, 0.0, 0.0]),
        textbook.exp_so3(np.array([0.0, 0.0, angle])),
        np.array([0.0, 1.0, 0.0]),
        np.array([0.0, 0.0, 1.0]),
        np.zeros(3),
        np.zeros(3),
    )
    q_r = textbook.reference_acceleration(at_rest(), desired, textbook.PAPER_GAINS)
    np.testing.assert_allclose(q_r, [300, 30, 0, 0, 0, 100 * math.sin(angle) + 40], atol=1e-13)


def test_box_qp_by_hand() -> None:
    x, residual = textbook.solve_box_qp(np.eye(2), np.array([-2.0, 0.5]), -np.ones(2), np.ones(2))
    np.testing.assert_array_equal(x, [1.0, -0.5])
    assert residual == 0.0


def test_box_qps_are_solved_to_rounding_with_none_to_all_bounds_active() -> None:
    generator = np.random.default_rng(1)
    lower, upper, counts = -np.ones(8), np.linspace(0.2, 1.0, 8), set()
    for _ in range(400):
        E = generator.normal(size=(6, 8))
        H = E.T @ E + 10.0 ** generator.uniform(-4.0, 0.0) * np.eye(8)
        g = 10.0 ** generator.uniform(-1.0, 1.5) * generator.normal(size=8)
        H, g = H / H.trace() * 8.0, g / H.trace() * 8.0
        x, residual = textbook.solve_box_qp(H, g, lower, upper)
        assert residual <= 1e-12
        counts.add(int(np.sum((x == lower) | (x == upper))))
    assert counts == set(range(9))


def test_at_hover_the_cheapest_thrusts_are_equal_and_the_tilt_stays_at_zero(
    vehicle: Vehicle,
) -> None:
    tilt = np.zeros(1)
    hover = textbook.hover_thrust(vehicle, tilt)
    np.testing.assert_allclose(hover, 1.315 * 9.81 / 8.0, rtol=1e-15)
    demand = textbook.build_demand(vehicle, at_rest(), np.zeros(6))
    chosen = textbook.three_candidates(
        vehicle, np.array([1e-3]), demand, Command(hover, tilt), textbook.CASE_B
    )
    np.testing.assert_array_equal(chosen.tilt, tilt)
    np.testing.assert_allclose(chosen.thrust, hover, rtol=1e-2)
    np.testing.assert_allclose(chosen.thrust, chosen.thrust[0], rtol=1e-12)
    assert chosen.kkt_residual <= 1e-12


def test_the_tilt_grows_for_a_sideways_push_up_to_its_limit(vehicle: Vehicle) -> None:
    sideways = np.array([5.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    demand = textbook.build_demand(vehicle, at_rest(), sideways)
    for tilt, step, expected in (
        (vehicle.servo_angle_max, 0.1, vehicle.servo_angle_max),
        (np.array([0.3]), 0.1, np.array([0.4])),
        (np.array([0.3]), 0.0, np.array([0.3])),
    ):
        previous = Command(textbook.hover_thrust(vehicle, tilt), tilt)
        chosen = textbook.three_candidates(
            vehicle, np.array([step]), demand, previous, textbook.CASE_A
        )
        np.testing.assert_allclose(chosen.tilt, expected, rtol=1e-15)


def test_actuators_follow_at_once_or_with_their_lag_and_rate(vehicle: Vehicle) -> None:
    tau, thrust = 0.02, np.full(8, 2.0)
    command, still = Command(thrust, np.array([0.5])), np.zeros(8)
    target = textbook.rotor_speed(vehicle, thrust)
    np.testing.assert_allclose(vehicle.thrust_coefficient * target**2, 2.0, rtol=1e-15)

    speed, tilt = textbook.step_actuators(vehicle, still, np.zeros(1), command, textbook.PERFECT)
    np.testing.assert_array_equal(speed, target)
    np.testing.assert_array_equal(tilt, command.tilt)

    lagging = textbook.REALISTIC._replace(physics_step=tau)
    speed, tilt = textbook.step_actuators(vehicle, still, np.zeros(1), command, lagging)
    np.testing.assert_allclose(speed, (1.0 - math.exp(-1.0)) * target, rtol=1e-14)
    np.testing.assert_allclose(tilt, math.radians(100.0) * tau, rtol=1e-14)


def test_without_thrust_it_falls_and_with_hover_thrust_it_stays(vehicle: Vehicle) -> None:
    fallen = textbook.step_body(vehicle, at_rest(), np.zeros(6), 0.01)
    np.testing.assert_allclose(fallen.v_WB, [0.0, 0.0, -0.0981], rtol=1e-15)
    np.testing.assert_allclose(fallen.p_WB, [0.0, 0.0, -0.000981], rtol=1e-15)
    for tilt in (np.zeros(1), np.array([0.7])):
        wrench = textbook.allocation_matrix(vehicle, tilt) @ textbook.hover_thrust(vehicle, tilt)
        stayed = textbook.step_body(vehicle, at_rest(), wrench, 0.01)
        np.testing.assert_allclose(np.concatenate([stayed.v_WB, stayed.w_WB_B]), 0.0, atol=1e-15)


@pytest.mark.parametrize("weights", [textbook.CASE_A, textbook.CASE_B])
def test_a_short_climb_stays_on_the_reference(vehicle: Vehicle, weights: textbook.Weights) -> None:
    reference = textbook.paper_reference()
    flight = textbook.fly(
        vehicle, reference, textbook.PAPER_GAINS, weights, textbook.PERFECT, duration=0.25
    )
    assert flight.time.shape == (251,)
    assert flight.R_WB.shape == (251, 3, 3)
    assert flight.thrust_command.shape == flight.speed.shape == (251, 8)
    assert flight.tilt_actual.shape == flight.tilt_command.shape == (251, 1)
    np.testing.assert_allclose(flight.p_WB[-1], reference(0.25).p_WB, atol=1e-4)
    np.testing.assert_allclose(flight.R_WB[-1], np.eye(3), atol=1e-12)
    assert np.all(flight.tilt_actual == 0.0)
    assert np.max(flight.kkt_residual) <= 1e-12


def test_a_noisy_flight_holds_each_command_and_keeps_a_fixed_tilt(vehicle: Vehicle) -> None:
    noise = np.random.default_rng(2).standard_normal((25, 12))
    flight = textbook.fly(
        vehicle,
        textbook.paper_reference(),
        textbook.PAPER_GAINS,
        textbook.CASE_A,
        textbook.REALISTIC,
        duration=0.1,
        tilt=0.6,
        noise=noise,
        fixed_tilt=True,
    )
    held = flight.thrust_command[:-1].reshape(25, 4, 8)
    np.testing.assert_array_equal(held, np.repeat(held[:, :1], 4, axis=1))
    assert np.all(np.any(held[1:, 0] != held[:-1, 0], axis=1))
    np.testing.assert_array_equal(flight.thrust_command[-1], flight.thrust_command[-2])
    assert np.all(flight.tilt_actual == 0.6)
    assert np.max(np.linalg.norm(flight.p_WB - flight.p_WB[0], axis=1)) < 0.02
