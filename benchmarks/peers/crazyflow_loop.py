"""Crazyflow: its first-principles dynamics and its Mellinger controller, many steps in a call."""

from __future__ import annotations

import time
from functools import cache
from typing import Any

import numpy as np

from benchmarks.peers import quadrotor as q
from benchmarks.peers.missing import imported, quiet

__all__ = ["fly"]

_RPM = 30.0 / np.pi  # of a rad/s


def fly(loop: q.Loop) -> q.Timed:
    """Fly worlds of one drone each: constant rotor speeds, or its own controller held at a point.

    Raises
    ------
    NotInstalled
        If it is not there.
    """
    sim, start, warm_up = _compiled(loop)
    sim.data = start
    began = time.perf_counter()
    sim.step(q.STEPS)
    sim.data.states.pos.block_until_ready()
    seconds = time.perf_counter() - began
    way = np.asarray(sim.data.states.pos[0, 0] - start.states.pos[0, 0], dtype=np.float64)
    return q.Timed(seconds, warm_up, way)


@cache
def _compiled(loop: q.Loop) -> tuple[Any, Any, float]:
    """Return a simulation, what it starts from, and the seconds until it could run."""
    imported("crazyflow")
    from crazyflow.control import Control
    from crazyflow.dynamics import Dynamics
    from crazyflow.sim import Sim

    began = time.perf_counter()
    settings: dict[str, Any] = {"state_freq": 500} if loop.closed else {"integrator": "rk4"}
    with quiet():
        sim = Sim(
            n_worlds=loop.vehicles,
            control=Control.state if loop.closed else Control.rotor_vel,
            dynamics=Dynamics.first_principles,
            freq=round(1.0 / q.STEP),
            **settings,
        )
    _start(sim, loop)
    start = sim.data
    sim.step(q.STEPS)
    sim.data.states.pos.block_until_ready()
    return sim, start, time.perf_counter() - began


def _start(sim: Any, loop: q.Loop) -> None:
    """Closed: its own vehicle, asked to a point nearby. Open: the common one, rotors at speed."""
    import jax.numpy as jnp

    data = sim.data
    above = data.states.pos.at[..., 2].set(1.0)  # its floor is at zero
    data = data.replace(states=data.states.replace(pos=above))
    if loop.closed:
        sim.data = data
        command = np.zeros((loop.vehicles, 1, 16), dtype=np.float32)
        command[..., :3] = [-0.2, 0.0, 0.9]
        command[..., 12] = 1.0  # the last of the attitude, a quaternion
        sim.state_control(command)
        return
    J = jnp.diag(jnp.array(q.INERTIA))
    parts = {
        "mass": [q.MASS],
        "L": [q.ARM],
        "prop_inertia": [0.0],
        "J": J,
        "J_inv": jnp.linalg.inv(J),
        "rpm2thrust": [[0.0, 0.0, q.THRUST_COEFFICIENT / _RPM**2]],
        "rpm2torque": [[0.0, 0.0, q.TORQUE_COEFFICIENT / _RPM**2]],
        "mixing_matrix": np.vstack([q.POSITIONS[:, 1], -q.POSITIONS[:, 0], q.ARM * q.SPIN]) / q.ARM,
        "drag_matrix": np.zeros((3, 3)),
    }
    params = data.params.replace(**{name: jnp.array(value) for name, value in parts.items()})
    rpm = jnp.broadcast_to(jnp.array(_RPM * q.SPEEDS), data.states.rotor_vel.shape)
    sim.data = data.replace(params=params, states=data.states.replace(rotor_vel=rpm))
    sim.rotor_vel_control(rpm)
