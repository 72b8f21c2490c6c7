"""What the cases fly: the paper's vehicle, an odd motion to start from, plants to order."""

from __future__ import annotations

from functools import cache
from typing import Literal

import numpy as np

from omnimorph.control.allocators import AllocationRule, FixedTilt
from omnimorph.design.files import load_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.dynamics import rotation_exponential
from omnimorph.protocols import Command, FloatArray, State
from omnimorph.simulation.effects import Effect
from omnimorph.simulation.plant import PlantModel, SimulatedPlant
from omnimorph.units import to_SI

Integrator = Literal["semi-implicit-euler", "runge-kutta-4"]
RUNGE_KUTTA: Integrator = "runge-kutta-4"
EULER: Integrator = "semi-implicit-euler"
TURN = 2.0 * np.pi
"""rad/s in one Hz."""

PRECISE_RULE: AllocationRule = FixedTilt(
    W1=to_SI(1e-10, "per_Hz4"),
    W2_position=(3e6,) * 3,
    W2_attitude=(1e3,) * 3,
    W3=to_SI(1e-5, "per_Hz4"),
)
"""Case A's weights, but for an effort so cheap that what it costs in position cannot be seen."""


@cache
def omnimorph() -> Vehicle:
    """Return the paper's vehicle."""
    return load_vehicle("omnimorph")


@cache
def free_rotor_vehicle() -> Vehicle:
    """Return OmniMorph with all hubs in its centre of mass, hardly any drag, all rotors spun alike.

    Whatever its rotors do, the air turns it by nothing; their angular momenta do not cancel.
    """
    n = omnimorph().n_rotors
    return omnimorph().replace(
        rotor_position=np.zeros((n, 3)), drag_coefficient=np.full(n, 1e-30), rotor_spin=np.ones(n)
    )


def tumbling() -> State:
    """Return a motion with nothing special about it: moving, turned, spinning about all axes."""
    return State(
        p_WB=np.array([0.3, -0.2, 1.5]),
        R_WB=rotation_exponential([0.4, -0.7, 0.9]),
        v_WB=np.array([1.0, 2.0, -0.5]),
        w_WB_B=np.array([3.0, -5.0, 4.0]),
    )


def command(
    thrust: FloatArray | float, tilt: float = 0.0, vehicle: Vehicle | None = None
) -> Command:
    """Return a command with one tilt; a single thrust is that of all rotors."""
    vehicle = omnimorph() if vehicle is None else vehicle
    thrusts = np.broadcast_to(np.asarray(thrust, dtype=np.float64), (vehicle.n_rotors,)).copy()
    return Command(thrusts, np.full(vehicle.n_servos, tilt))


def plant_with(
    *effects: Effect,
    vehicle: Vehicle | None = None,
    start: State | None = None,
    first: Command | None = None,
    step: float = 1e-3,
    integrator: Integrator = EULER,
    flight: int = 0,
) -> SimulatedPlant:
    """Return a plant with these effects that stands under the command `first` (no thrust)."""
    vehicle = omnimorph() if vehicle is None else vehicle
    before = command(0.0, vehicle=vehicle) if first is None else first
    model = PlantModel(
        physics_step=step, control_period=step, integrator=integrator, effects=effects
    )
    plant = SimulatedPlant(
        vehicle,
        model,
        start=start,
        start_tilt=before.tilt,
        start_thrust=before.thrust,
        flight=flight,
    )
    plant.send(before)
    return plant


def spin_axes(vehicle: Vehicle, tilt: FloatArray) -> FloatArray:
    """Return the (n, 3) thrust axes z_i(α) in B, from the vehicle's own record."""
    z0, zC, zS = vehicle.thrust_axis_parts
    angle = np.append(tilt, 0.0)[vehicle.rotor_servo][:, np.newaxis]  # -1, no servo: the last, 0
    axes: FloatArray = z0 + zC * np.cos(angle) + zS * np.sin(angle)
    return axes


def rotor_momentum_B(vehicle: Vehicle, plant: SimulatedPlant) -> FloatArray:
    """Return H = Σ I_i k_i w_i z_i(α), N m s, in B: what the spinning rotors carry."""
    spin = vehicle.spin_inertia * vehicle.rotor_spin * plant.speed
    momentum: FloatArray = spin @ spin_axes(vehicle, plant.tilt)
    return momentum
