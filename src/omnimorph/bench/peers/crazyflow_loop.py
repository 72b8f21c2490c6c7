"""Crazyflow: its first-principles dynamics and its Mellinger controller, many steps in a call."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from omnimorph.bench.peers import quadrotor as q
from omnimorph.bench.peers.missing import imported

__all__ = ["fly"]

_RPM = 30.0 / np.pi  # of a rad/s


def fly(loop: q.Loop) -> q.Timed:
    """Fly worlds of one drone each: constant rotor speeds, or its own controller held at a point.

    Raises
    ------
    NotInstalled
        If it is not there.
    """
    imported("crazyflow")
    from crazyflow.control import Control
    from crazyflow.dynamics import Dynamics
    from crazyflow.sim import Sim

    began = time.perf_counter()
    settings: dict[str, Any] = {"state_freq": 500} if loop.closed else {"integrator": "rk4"}
    sim = Sim(
        n_worlds=loop.vehicles,
        control=Control.state if loop.closed else Control.rotor_vel,
        dynamics=Dynamics.first_principles,
        freq=round(1.0 / q.STEP),
        **settings,
    )
    start = sim.data
    if loop.closed:
        command = np.zeros((loop.vehicles, 1, 16), dtype=np.float32)
        command[..., :3] = [0.2, 0.0, 0.5]
        sim.state_control(command)
        start = sim.data
    else:
        start = _our_vehicle(sim)
    sim.data = start
    sim.step(q.STEPS)
    _wait(sim)
    warm_up = time.perf_counter() - began
    sim.data = _copy(sim, loop)
    began = time.perf_counter()
    sim.step(q.STEPS)
    _wait(sim)
    seconds = time.perf_counter() - began
    return q.Timed(seconds, warm_up, np.asarray(sim.data.states.pos[0, 0], dtype=np.float64))


def _wait(sim: Any) -> None:
    sim.data.states.pos.block_until_ready()
