"""Each row of a recorded flight follows from the one before by Newton and Euler, in plain NumPy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import omnimorph as om
from omnimorph.protocols import FloatArray
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.run import Run
from omnimorph.verification.setting import spin_axes

STEP = 1e-3


@pytest.fixture(scope="module", params=["perfect", "realistic-1", "realistic"])
def run(request: pytest.FixtureRequest) -> Run:
    """Case A, which tilts and rolls, as the scenario has it."""
    return om.fly(om.load_scenario("paper-case-a"), seed=2, plant=request.param)


def turned(R: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return R_k v_k for every k."""
    return (R @ vectors[:, :, np.newaxis])[:, :, 0]


def test_velocity_changes_by_force_over_mass(run: Run) -> None:
    force = turned(run.R_WB[:-1], run.wrench_achieved[1:, :3])
    expected = run.v_WB[:-1] + STEP * (force / run.vehicle.mass - [0.0, 0.0, 9.81])
    np.testing.assert_allclose(run.v_WB[1:], expected, rtol=0, atol=1e-14)


def test_position_changes_by_velocity(run: Run) -> None:
    np.testing.assert_allclose(
        run.p_WB[1:], run.p_WB[:-1] + STEP * run.v_WB[1:], rtol=0, atol=1e-14
    )


def test_angular_momentum_changes_by_torque(run: Run) -> None:
    """L = Jω + H, with H = Σ I k w z of the spinning rotors in the realistic plant alone."""
    w, vehicle = run.w_WB_B, run.vehicle
    spin = vehicle.spin_inertia * vehicle.rotor_spin * run.speed
    H = np.array([a @ spin_axes(vehicle, b) for a, b in zip(spin, run.tilt_actual, strict=True)])
    carries = run.provenance.plant_name == "realistic"
    L = w @ vehicle.inertia + (H if carries else 0.0)
    torque = run.wrench_achieved[1:, 3:] - np.cross(w[:-1], L[:-1])
    np.testing.assert_allclose(L[1:], L[:-1] + STEP * torque, rtol=0, atol=1e-15)


def test_attitude_changes_by_body_rate(run: Run) -> None:
    turn = Rotation.from_rotvec(STEP * run.w_WB_B[1:]).as_matrix()
    np.testing.assert_allclose(run.R_WB[1:], run.R_WB[:-1] @ turn, rtol=0, atol=5e-14)


def test_attitude_is_a_rotation_to_the_end(run: Run) -> None:
    R = run.R_WB
    np.testing.assert_allclose(
        R.transpose(0, 2, 1) @ R, np.broadcast_to(np.eye(3), R.shape), atol=1e-13
    )


def test_wrench_comes_from_speeds_and_tilt(run: Run) -> None:
    vehicle, rows = run.vehicle, slice(0, None, 97)
    signed = run.speed[rows] * np.abs(run.speed[rows])
    axes = np.array([spin_axes(vehicle, tilt) for tilt in run.tilt_actual[rows]])
    force = (vehicle.thrust_coefficient * signed)[:, :, np.newaxis] * axes
    drag = (vehicle.rotor_spin * vehicle.drag_coefficient * signed)[:, :, np.newaxis] * axes
    torque = np.cross(vehicle.rotor_position, force) - drag
    wrench = np.hstack([force.sum(axis=1), torque.sum(axis=1)])
    np.testing.assert_allclose(run.wrench_achieved[rows], wrench, rtol=0, atol=1e-12)


def test_actual_thrusts_and_the_drag_make_the_wrench() -> None:
    """Damage, another coefficient, lag and the wakes of others are in the thrust of each rotor."""
    scenario = om.load_scenario("paper-case-b")
    share = (1.0, 0.9, 1.0, 1.0, 0.7, 1.0, 1.0, 1.0)
    worn = (
        om.effects.RotorLag(),
        om.effects.ModelMismatch(thrust_coefficient=0.95),
        om.effects.Effectiveness(share=share),
        om.effects.Interference(),
    )
    start = scenario.reference(0.0)
    way = SegmentReference(start.p_WB, start.R_WB, [Segment(0.4, (0.01, 0.0, 0.02))])
    plant = replace(scenario.plant, effects=worn)
    run = om.fly(replace(scenario, reference=way, plant=plant))
    truth = plant.true_vehicle(run.vehicle)
    signed = run.speed * np.abs(run.speed)
    alone = np.array(share) * truth.thrust_coefficient * signed
    lost = 1.0 - run.thrust_actual / alone
    upper = run.vehicle.rotor_position[:, 2] > 0.0
    np.testing.assert_allclose(lost[:, upper], 0.0, atol=1e-15)
    assert (lost[:, ~upper] > 0.1).all(), "they hover below others, hardly tilted"
    axes = np.array([spin_axes(run.vehicle, tilt) for tilt in run.tilt_actual])
    force = run.thrust_actual[:, :, np.newaxis] * axes
    drag = (truth.rotor_spin * truth.drag_coefficient * signed)[:, :, np.newaxis] * axes
    torque = np.cross(truth.rotor_position, force) - drag
    wrench = np.hstack([force.sum(axis=1), torque.sum(axis=1)])
    np.testing.assert_allclose(run.wrench_achieved, wrench, rtol=0, atol=1e-12)


def test_actuators_follow_their_commands() -> None:
    run = om.fly(om.load_scenario("paper-case-a"), seed=2)
    asked = np.sign(run.thrust_command) * np.sqrt(
        np.abs(run.thrust_command) / run.vehicle.thrust_coefficient
    )
    limited = np.clip(asked, run.vehicle.speed_min, run.vehicle.speed_max)[:-1]
    speed = limited + (run.speed[:-1] - limited) * np.exp(-STEP / 0.020)
    np.testing.assert_allclose(run.speed[1:], speed, rtol=0, atol=1e-9)
    way = np.clip(
        run.tilt_command[:-1] - run.tilt_actual[:-1], *(STEP * np.radians([-100.0, 100.0]))
    )
    np.testing.assert_allclose(run.tilt_actual[1:], run.tilt_actual[:-1] + way, rtol=0, atol=1e-14)


def test_commands_are_held_for_a_control_period() -> None:
    run = om.fly(om.load_scenario("hover"), seed=2)
    for column in (run.thrust_command, run.tilt_command, run.wrench_asked, run.cost):
        held = column[:-1].reshape(-1, 4, *column.shape[1:])
        np.testing.assert_array_equal(held, np.broadcast_to(held[:, :1], held.shape))
    assert len(np.unique(run.thrust_command[::4, 0])) > 1000


def test_power_of_the_rotors_is_the_change_of_energy() -> None:
    """Over Case B the work of the wrench is the gain in kinetic and potential energy."""
    scenario = om.load_scenario("paper-case-b")
    fine = om.PlantModel(physics_step=2.5e-4, control_period=1e-3, integrator="runge-kutta-4")
    run = om.fly(replace(scenario, plant=fine))
    J, m, rows = run.vehicle.inertia, run.vehicle.mass, slice(0, 62_000)  # up to the tilted flight
    v, w = run.v_WB[rows], run.w_WB_B[rows]
    energy = m * (np.sum(v * v, axis=1) / 2.0 + 9.81 * run.p_WB[rows, 2])
    energy = energy + np.sum((w @ J) * w, axis=1) / 2.0
    force = turned(run.R_WB[rows], run.wrench_achieved[rows][:, :3])
    # the wrench of a row acted over the step that led to it
    mean_v, mean_w = (v[1:] + v[:-1]) / 2.0, (w[1:] + w[:-1]) / 2.0
    power = np.sum(force[1:] * mean_v, axis=1)
    power = power + np.sum(run.wrench_achieved[rows][1:, 3:] * mean_w, axis=1)
    work = np.concatenate([[0.0], np.cumsum(power) * 2.5e-4])
    assert np.ptp(energy) > 10.0
    np.testing.assert_allclose(energy - energy[0], work, rtol=0, atol=2e-4)
