"""The four-rotor vehicle that every simulator is given, and where it really gets to.

Its numbers are those that RotorPy ships for a Crazyflie 2 (``crazyflie_params.py``) but for the
third moment of inertia, there 2.89e-5 kg m²: more than the other two together, which no body has
(MuJoCo refuses it as we do). Without aerodynamics and with rotors at their speeds from the start
what is left is the rigid body, which all simulators share, so that their final states can be held
against one reference.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from omnimorph.bench.batches import fly_all
from omnimorph.control.allocators import FixedTilt
from omnimorph.control.tracking import TrackingGains
from omnimorph.design.files import load_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import Desired, FloatArray
from omnimorph.simulation.plant import PlantModel, SimulatedPlant
from omnimorph.simulation.scenario import Scenario

__all__ = [
    "ARM", "BATCH", "INERTIA", "MASS", "POSITIONS", "SPEEDS", "SPIN", "STEP", "STEPS",
    "THRUST_COEFFICIENT", "TORQUE_COEFFICIENT", "Loop", "Timed", "final_position", "ours",
]  # fmt: skip

MASS = 0.03  # kg
INERTIA = (1.43e-5, 1.43e-5, 2.85e-5)  # kg m²
ARM = 0.043 * 0.5**0.5  # m, from the axes of the body to a rotor
POSITIONS = ARM * np.array([[1.0, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]])  # m
SPIN = np.array([1.0, -1.0, 1.0, -1.0])  # of the drag torque about z
THRUST_COEFFICIENT = 2.3e-8  # N s²/rad²
TORQUE_COEFFICIENT = 7.8e-10  # N m s²/rad²
STEP = 2e-3  # s
STEPS = 500
BATCH = 1024
_HOVER = (MASS * 9.81 / 4.0 / THRUST_COEFFICIENT) ** 0.5
SPEEDS = _HOVER * np.array([1.0004, 1.0, 0.9997, 1.0])  # rad/s: it climbs, tumbles and yaws


class Timed(NamedTuple):
    """What a loop took: seconds a run, seconds before it could run, and where it ended."""

    seconds: float
    warm_up: float
    position: FloatArray  # (3,) m; of the first vehicle


class Loop(NamedTuple):
    """How a simulator is run: how many vehicles, whether its own controller holds them."""

    vehicles: int
    closed: bool


def final_position() -> FloatArray:
    """Return where constant `SPEEDS` take the rigid body, by an adaptive method of order 8, (3,) m.

    Raises
    ------
    RuntimeError
        If the integration fails.
    """
    from scipy.integrate import solve_ivp
    from scipy.spatial.transform import Rotation

    squared = SPEEDS**2
    lift = THRUST_COEFFICIENT * squared.sum()
    forces = np.outer(THRUST_COEFFICIENT * squared, [0.0, 0.0, 1.0])
    torque = np.cross(POSITIONS, forces).sum(axis=0)
    torque[2] += TORQUE_COEFFICIENT * (SPIN @ squared)
    J = np.array(INERTIA)

    def rates(_: float, state: FloatArray) -> FloatArray:
        x, y, z, s = state[6:10]
        w = state[10:13]
        up = Rotation.from_quat(state[6:10]).apply([0.0, 0.0, lift / MASS])
        turning = 0.5 * np.array(
            [
                s * w[0] + y * w[2] - z * w[1],
                s * w[1] + z * w[0] - x * w[2],
                s * w[2] + x * w[1] - y * w[0],
                -x * w[0] - y * w[1] - z * w[2],
            ]
        )
        spin_up = (torque - np.cross(w, J * w)) / J
        return np.concatenate([state[3:6], up - [0.0, 0.0, 9.81], turning, spin_up])

    start = np.zeros(13)
    start[9] = 1.0
    end = STEP * STEPS
    answer = solve_ivp(rates, (0.0, end), start, method="DOP853", rtol=1e-13, atol=1e-13)
    if not answer.success:
        raise RuntimeError(f"The reference flight failed: {answer.message}")
    return np.asarray(answer.y[:3, -1])


def _vehicle() -> Vehicle:
    c = np.full(4, THRUST_COEFFICIENT)
    return load_vehicle("quadrotor").replace(
        name="bench-quadrotor",
        mass=MASS,
        inertia=np.diag(INERTIA),
        rotor_position=POSITIONS,
        rotor_spin=-SPIN,  # the drag torque is against the rotor's own sense
        thrust_coefficient=c,
        drag_coefficient=np.full(4, TORQUE_COEFFICIENT),
        speed_min=np.zeros(4),
        speed_max=np.full(4, 2500.0),
    )


class _Hold:
    """Hover at a point, for as long as the other loops fly."""

    duration = STEP * STEPS

    def __call__(self, time: float) -> Desired:
        """Return the point."""
        rest = np.zeros(3)
        return Desired(rest, np.eye(3), rest, rest, rest, rest)


def _scenario(plant: PlantModel) -> Scenario:
    return Scenario(
        name="bench-quadrotor",
        vehicle=_vehicle(),
        plant=plant,
        gains=TrackingGains(velocity=5.0, position=6.0, rate=40.0, attitude=300.0),
        allocator=FixedTilt(W1=0.0, W2_position=(1e4,) * 3, W2_attitude=(10.0,) * 3, W3=1e-12),
        reference=_Hold(),
        attitude_gives_way=True,
    )


def ours(loop: Loop) -> Timed:
    """Fly our vehicle; closed, with limits obeyed by a QP in every control step."""
    import time

    simple = PlantModel(physics_step=STEP, control_period=STEP)
    if loop.closed:
        began = time.perf_counter()
        away = {"start_position": np.tile([0.2, 0.0, 0.1], (loop.vehicles, 1))}
        keep = (0,) if loop.vehicles == 1 else ()
        flights = fly_all(_scenario(simple), loop.vehicles, vary=away, keep=keep)
        setting_up = time.perf_counter() - began - flights.performance.wall_time
        end = flights.runs[0].p_WB[-1] if flights.runs else np.full(3, np.nan)
        return Timed(flights.performance.wall_time, setting_up, end)
    plant = SimulatedPlant(
        _vehicle(),
        replace(simple, integrator="runge-kutta-4"),
        start_thrust=THRUST_COEFFICIENT * SPEEDS**2,
    )
    began = time.perf_counter()
    state = plant.step_physics(STEPS)
    return Timed(time.perf_counter() - began, 0.0, state.p_WB)
