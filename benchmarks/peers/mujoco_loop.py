"""MuJoCo: the vehicle as a free body with four forces; it has no controller of a multirotor."""

from __future__ import annotations

import os
import time
from typing import Any

import numpy as np

from benchmarks.peers import quadrotor as q
from benchmarks.peers.missing import imported

__all__ = ["fly", "model_text"]


def model_text() -> str:
    """Return the vehicle as MJCF, an actuator a rotor: thrust along z and drag torque about it."""
    kappa = q.TORQUE_COEFFICIENT / q.THRUST_COEFFICIENT
    sites = "".join(
        f'<site name="r{k}" pos="{p[0]} {p[1]} {p[2]}"/>' for k, p in enumerate(q.POSITIONS)
    )
    motors = "".join(
        f'<general site="r{k}" gear="0 0 1 0 0 {spin * kappa}"/>' for k, spin in enumerate(q.SPIN)
    )
    inertia = " ".join(str(J) for J in q.INERTIA)
    return (
        f'<mujoco><option timestep="{q.STEP}" integrator="RK4" gravity="0 0 -9.81"/>'
        f'<worldbody><body><freejoint/><inertial pos="0 0 0" mass="{q.MASS}" '
        f'diaginertia="{inertia}"/>{sites}</body></worldbody><actuator>{motors}</actuator></mujoco>'
    )


def fly(loop: q.Loop) -> q.Timed:
    """Fly under constant thrusts, a batch one after the other in all threads.

    Raises
    ------
    NotInstalled
        If it is not there, or if the loop should be closed: it brings no controller.
    """
    mujoco = imported("mujoco")
    model = mujoco.MjModel.from_xml_string(model_text())
    data = mujoco.MjData(model)
    data.ctrl[:] = q.THRUST_COEFFICIENT * q.SPEEDS**2
    if loop.vehicles == 1:
        began = time.perf_counter()
        mujoco.mj_step(model, data, nstep=q.STEPS)
        return q.Timed(time.perf_counter() - began, 0.0, np.array(data.qpos[:3]))
    return _fly_batch(mujoco, model, data, loop.vehicles)


def _fly_batch(mujoco: Any, model: Any, data: Any, n: int) -> q.Timed:
    rollout = imported("mujoco.rollout")
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = np.zeros(mujoco.mj_stateSize(model, full))
    mujoco.mj_getState(model, data, start, full)
    control = np.tile(data.ctrl, (n, q.STEPS, 1))
    workers = [mujoco.MjData(model) for _ in range(os.cpu_count() or 1)]
    began = time.perf_counter()
    states, _ = rollout.rollout(model, workers, np.tile(start, (n, 1)), control)
    seconds = time.perf_counter() - began
    return q.Timed(seconds, 0.0, np.asarray(states[0, -1, 1:4]))
