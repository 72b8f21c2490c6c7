"""Spinning rotors turn the body: the plant beside MuJoCo, a multibody engine that is not ours.

The vehicle is a free body with one hinge for each rotor. In both engines the rotors follow the same
commands with the same lag; MuJoCo's hinges get the torques that this takes. The rotors make no
thrust and next to no drag: the body turns only by what it exchanges with them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import omnimorph as om
from omnimorph.model.geometry import thrust_axes
from omnimorph.protocols import Command, FloatArray, State
from omnimorph.simulation import effects

if TYPE_CHECKING:
    import mujoco

STEP = 2e-4  # s
HELD = 250  # steps under one command
COMMANDS = 8
TILT = np.radians([33.0])
START = State(np.zeros(3), np.eye(3), np.zeros(3), np.array([0.4, -0.3, 0.7]))
ROTOR_MASS = 0.010  # kg
SAME_RATE = 1e-9  # rad/s

OMNIMORPH = om.load_vehicle("omnimorph")
VEHICLE = OMNIMORPH.replace(drag_coefficient=1e-9 * OMNIMORPH.drag_coefficient)


@pytest.fixture(scope="module")
def thrusts() -> FloatArray:
    """Return thrusts to ask for, of either sign, so that rotors spin up, slow down and reverse."""
    return np.random.default_rng(7).uniform(-4.0, 4.0, (COMMANDS, VEHICLE.n_rotors))


def fly_ours(thrusts: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return body rates and rotor speeds at every step."""
    plant = om.PlantModel(
        physics_step=STEP,
        control_period=HELD * STEP,
        integrator="runge-kutta-4",
        effects=(
            effects.RotorLag(),
            effects.RotorMomentum(),
            effects.Effectiveness(share=0.0),
        ),
    )
    flight = om.SimulatedPlant(
        VEHICLE, plant, start=START, start_tilt=TILT, start_thrust=np.zeros(VEHICLE.n_rotors)
    )
    rates, speeds = [flight.state.w_WB_B], [flight.speed]
    for thrust in thrusts:
        flight.send(Command(thrust, TILT))
        for _ in range(HELD):
            rates.append(flight.step_physics().w_WB_B)
            speeds.append(flight.speed)
    return np.array(rates), np.array(speeds)


# --- the same in MuJoCo ---------------------------------------------------------------------------


def build_bodies() -> mujoco.MjModel:
    """Return a free body with a disc on a hinge for each rotor, of the vehicle's mass and inertia.

    A disc is thin, its inertia across the axis half of that about it; the frame gets what is left.
    """
    import mujoco

    axes = thrust_axes(VEHICLE, TILT)
    J = VEHICLE.inertia.copy()
    discs = []
    for i in range(VEHICLE.n_rotors):
        p, z, spin = VEHICLE.rotor_position[i], axes[i], VEHICLE.spin_inertia[i]
        across = 0.5 * spin
        disc = across * np.eye(3) + (spin - across) * np.outer(z, z)
        J -= disc + ROTOR_MASS * ((p @ p) * np.eye(3) - np.outer(p, p))
        numbers = [" ".join(f"{value:.17g}" for value in row) for row in (p, z)]
        full = " ".join(f"{disc[k]:.17g}" for k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
        discs.append(
            f'<body pos="{numbers[0]}"><joint name="hinge{i}" type="hinge" axis="{numbers[1]}"/>'
            f'<inertial pos="0 0 0" mass="{ROTOR_MASS}" fullinertia="{full}"/></body>'
        )
    left = VEHICLE.mass - ROTOR_MASS * VEHICLE.n_rotors
    frame = " ".join(f"{J[k]:.17g}" for k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP}" integrator="RK4" gravity="0 0 -9.81"/><worldbody><body>'
        f'<freejoint/><inertial pos="0 0 0" mass="{left}" fullinertia="{frame}"/>{"".join(discs)}'
        "</body></worldbody><actuator>"
        + "".join(f'<motor joint="hinge{i}"/>' for i in range(VEHICLE.n_rotors))
        + "</actuator></mujoco>"
    )


def fly_bodies(thrusts: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return body rates and rotor speeds at every step."""
    import mujoco

    model = build_bodies()
    data = mujoco.MjData(model)
    data.qvel[3:6] = START.w_WB_B
    spin, lag = VEHICLE.rotor_spin, VEHICLE.time_constant_up
    target = np.zeros(VEHICLE.n_rotors)

    def drive(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Give the hinges the torques under which their speeds follow the targets."""
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        wanted, bias = (spin * target - data.qvel[6:]) / lag, data.qfrc_bias
        body = np.linalg.solve(M[:6, :6], -(M[:6, 6:] @ wanted + bias[:6]))
        data.ctrl[:] = M[6:, :6] @ body + M[6:, 6:] @ wanted + bias[6:]

    rates, speeds = [data.qvel[3:6].copy()], [data.qvel[6:] * spin]
    mujoco.set_mjcb_control(drive)
    try:
        for thrust in thrusts:
            target = np.sign(thrust) * np.sqrt(np.abs(thrust) / VEHICLE.thrust_coefficient)
            for _ in range(HELD):
                mujoco.mj_step(model, data)
                rates.append(data.qvel[3:6].copy())
                speeds.append(data.qvel[6:] * spin)
    finally:
        mujoco.set_mjcb_control(None)
    return np.array(rates), np.array(speeds)


@pytest.mark.slow
def test_the_body_exchanges_momentum_with_its_rotors_as_in_mujoco(thrusts: FloatArray) -> None:
    assert (VEHICLE.time_constant_up == VEHICLE.time_constant_down).all()
    ours, our_speeds = fly_ours(thrusts)
    theirs, their_speeds = fly_bodies(thrusts)
    np.testing.assert_allclose(our_speeds, their_speeds, rtol=0.0, atol=1e-7 * 700.0)
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=SAME_RATE)
    assert np.ptp(theirs, axis=0).min() > 0.1, "the exchange is felt about every axis"
