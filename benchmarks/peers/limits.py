"""What peers make of OmniMorph, eight reversible rotors tilted by one servo: it is tried."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.peers.missing import NotInstalled, imported
from benchmarks.peers.rotorpy_loop import parameters
from omnimorph.design.files import load_vehicle
from omnimorph.model.allocation import allocation_matrix

__all__ = ["what_peers_cannot_run"]


def what_peers_cannot_run() -> list[str]:
    """Return one sentence a peer: what became of the attempt, or that it is not installed."""
    attempts: tuple[Callable[[], str], ...] = (_rotorpy, _crazyflow, _mujoco)
    sentences = []
    for attempt in attempts:
        try:
            sentences.append(attempt())
        except NotInstalled as missing:
            sentences.append(str(missing))
    return sentences


def _rotorpy() -> str:
    """Give it eight rotors where OmniMorph's are, with speeds of either sign."""
    imported("rotorpy")
    from rotorpy.controllers.quadrotor_control import SE3Control

    vehicle = load_vehicle("omnimorph")
    own = parameters() | {
        "num_rotors": 8,
        "rotor_pos": {f"r{k + 1}": p for k, p in enumerate(vehicle.rotor_position)},
        "rotor_directions": -vehicle.rotor_spin,
        "rotor_speed_min": float(vehicle.speed_min[0]),
        "rotor_speed_max": float(vehicle.speed_max[0]),
    }
    try:
        SE3Control(own)
        outcome = "takes eight rotors"
    except Exception as problem:  # whatever it raises is the answer
        outcome = f"its controller raises {type(problem).__name__} ({problem}) for eight rotors"
    return (
        f"rotorpy: {outcome}, and there is no word for the direction of a thrust: all are along z."
    )


def _crazyflow() -> str:
    """Look for a way to say how many rotors there are, or which way they point."""
    imported("crazyflow")
    from crazyflow.control import Control
    from crazyflow.dynamics import Dynamics
    from crazyflow.sim import Sim

    sim = Sim(control=Control.rotor_vel, dynamics=Dynamics.first_principles)
    speeds = np.zeros((1, 1, 8), dtype=np.float32)
    try:
        sim.rotor_vel_control(speeds)
        outcome = "takes eight speeds"
    except Exception as problem:
        outcome = f"eight rotor speeds raise {type(problem).__name__} ({problem})"
    return f"crazyflow: {outcome}, and its thrusts are summed along the body's z axis."


def _mujoco() -> str:
    """Build the rigid body with thrusts at a fixed tilt, and see whether anything controls it."""
    mujoco = imported("mujoco")
    vehicle = load_vehicle("omnimorph")
    A = allocation_matrix(vehicle, 0.7)
    sites = "".join(
        f'<site name="r{k}" pos="{p[0]} {p[1]} {p[2]}"/>'
        for k, p in enumerate(vehicle.rotor_position)
    )
    motors = []
    for k, column in enumerate(A.T):
        drag = column[3:] - np.cross(vehicle.rotor_position[k], column[:3])
        gear = " ".join(str(number) for number in (*column[:3], *drag))
        motors.append(f'<general site="r{k}" gear="{gear}"/>')
    J = " ".join(str(number) for number in np.diag(vehicle.inertia))
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><body><freejoint/><inertial pos="0 0 0" mass="{vehicle.mass}" '
        f'diaginertia="{J}"/>{sites}</body></worldbody><actuator>{"".join(motors)}</actuator></mujoco>'
    )
    return (
        f"mujoco: runs it as a free body with {model.nu} forces at a fixed tilt; tilt, rotor "
        "speeds, limits, allocation and control are the user's to write."
    )
