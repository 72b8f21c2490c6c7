"""RotorPy: one vehicle in NumPy and SciPy, or a batch of them in PyTorch, stepped from Python."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.peers import quadrotor as q
from benchmarks.peers.missing import imported

__all__ = ["fly", "parameters"]

_STEPS_OF_A_BATCH = 100  # it takes tens of milliseconds a step


def parameters() -> dict[str, Any]:
    """Return the vehicle in RotorPy's own words."""
    names = [f"r{k + 1}" for k in range(4)]
    zero = ("Ixy", "Iyz", "Ixz", "c_Dx", "c_Dy", "c_Dz", "k_d", "k_z", "k_h", "k_flap")
    return dict.fromkeys(zero, 0.0) | {
        "mass": q.MASS,
        "Ixx": q.INERTIA[0],
        "Iyy": q.INERTIA[1],
        "Izz": q.INERTIA[2],
        "num_rotors": 4,
        "rotor_pos": dict(zip(names, q.POSITIONS, strict=True)),
        "rotor_directions": q.SPIN,
        "rI": np.zeros(3),
        "k_eta": q.THRUST_COEFFICIENT,
        "k_m": q.TORQUE_COEFFICIENT,
        "tau_m": 0.072,
        "rotor_speed_min": 0.0,
        "rotor_speed_max": 2500.0,
        "motor_noise_std": 0.0,
        "k_w": 200,
        "k_v": 10,
        "kp_att": 310.0,
        "kd_att": 57.0,
    }


def fly(loop: q.Loop) -> q.Timed:
    """Fly one vehicle or a batch: constant rotor speeds, or its own controller held at a point.

    Raises
    ------
    NotInstalled
        If it, or PyTorch for a batch, is not there.
    """
    imported("rotorpy")
    return _fly_one(loop) if loop.vehicles == 1 else _fly_batch(loop)


def _start() -> dict[str, Any]:
    rest = np.zeros(3)
    upright = np.array([0.0, 0.0, 0.0, 1.0])
    motion = {"x": rest, "v": rest, "q": upright, "w": rest, "wind": rest}
    return motion | {"rotor_speeds": q.SPEEDS}


def _wish() -> dict[str, Any]:
    rest = np.zeros(3)
    flat = dict.fromkeys(("x_dot", "x_ddot", "x_dddot", "x_ddddot"), rest)
    return flat | {"x": np.array([-0.2, 0.0, -0.1]), "yaw": 0.0, "yaw_dot": 0.0, "yaw_ddot": 0.0}


def _fly_one(loop: q.Loop) -> q.Timed:
    from rotorpy.controllers.quadrotor_control import SE3Control
    from rotorpy.vehicles.multirotor import Multirotor

    vehicle = Multirotor(parameters(), control_abstraction="cmd_motor_speeds", aero=False)
    controller, wish, state = SE3Control(parameters()), _wish(), _start()
    began = time.perf_counter()
    for k in range(q.STEPS):
        command = {"cmd_motor_speeds": q.SPEEDS}
        if loop.closed:
            command = controller.update(k * q.STEP, state, wish)
        state = vehicle.step(state, command, q.STEP)
    return q.Timed(time.perf_counter() - began, 0.0, np.asarray(state["x"]))


def _fly_batch(loop: q.Loop) -> q.Timed:
    torch = imported("torch")
    imported("torchdiffeq")
    imported("roma")
    from rotorpy.controllers.quadrotor_control import BatchedSE3Control
    from rotorpy.vehicles.multirotor import BatchedMultirotor, BatchedMultirotorParams

    def prepared(n: int) -> Callable[[int], Any]:
        device = torch.device("cpu")

        def many(value: Any) -> Any:
            row = np.asarray(value, dtype=np.float64)
            return torch.from_numpy(np.broadcast_to(row, (n, *row.shape)).copy())

        shared = BatchedMultirotorParams([parameters()] * n, n, device)
        start = {name: many(value) for name, value in _start().items()}
        wish = {name: many(value) for name, value in _wish().items()}
        vehicle = BatchedMultirotor(
            shared, n, start, device, "cmd_motor_speeds", aero=False, integrator="rk4"
        )
        controller = BatchedSE3Control(shared, n, device)
        constant = {"cmd_motor_speeds": many(q.SPEEDS)}

        def fly_on(count: int) -> Any:
            state = start
            for k in range(count):
                command = controller.update(k * q.STEP, state, wish) if loop.closed else constant
                state = vehicle.step(state, command, q.STEP)
            return state["x"][0].numpy()

        return fly_on

    began = time.perf_counter()
    batch = prepared(loop.vehicles)
    batch(2)
    warm_up = time.perf_counter() - began
    began = time.perf_counter()
    batch(_STEPS_OF_A_BATCH)
    seconds = (time.perf_counter() - began) * q.STEPS / _STEPS_OF_A_BATCH
    return q.Timed(seconds, warm_up, prepared(2)(q.STEPS))  # all end where two of them do
