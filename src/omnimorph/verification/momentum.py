"""Spinning rotors: gyroscopic torque, reaction to spinning up, torque of tilting them."""

from __future__ import annotations

import numpy as np

from omnimorph.model.dynamics import rotation_exponential
from omnimorph.protocols import Command, FloatArray, State
from omnimorph.simulation.effects import (
    ConstantWrench,
    Effect,
    RotorLag,
    RotorMomentum,
    ServoLag,
    ServoRateLimit,
)
from omnimorph.simulation.plant import SimulatedPlant
from omnimorph.verification.case import Result, case, largest
from omnimorph.verification.setting import (
    RUNGE_KUTTA,
    command,
    free_rotor_vehicle,
    omnimorph,
    plant_with,
    rotor_momentum_B,
    tumbling,
)

_EULER_EQUATION = "d(Jω + H)/dt + ω × (Jω + H) = τ, H = Σ I k w z(α)"


def _locked_rotors(*effects: Effect) -> SimulatedPlant:
    """Return tumbling OmniMorph, rotors at uneven constant speeds, their torque held off."""
    thrust = np.array([5.0, -1.0, 4.0, 2.0, -3.0, 4.0, 1.0, 2.5])
    first = command(thrust, 0.5)
    torque = plant_with(first=first).wrench[3:]
    held_off = ConstantWrench(torque=tuple((-torque).tolist()))
    start = tumbling()
    return plant_with(*effects, held_off, start=start, first=first, integrator=RUNGE_KUTTA)


@case("ω · (ω × H) = 0")
def gyroscopic_torque_does_no_work() -> Result:
    """With locked servos and steady rotors, ½ ω·Jω stays what it was for 2 s of tumbling."""
    J = omnimorph().inertia
    plant = _locked_rotors(RotorMomentum())
    start, end = (state.w_WB_B for state in (plant.state, plant.step_physics(2000)))
    return Result(value=abs(float(end @ J @ end) / float(start @ J @ start) - 1.0), tolerance=1e-11)


@case(_EULER_EQUATION)
def gyroscopic_torque_turns_the_body() -> Result:
    """The same flight conserves R (Jω + H), the momentum of body and rotors (relative change)."""
    plant = _locked_rotors(RotorMomentum())
    before = _momentum_W(plant)
    plant.step_physics(2000)
    return Result(value=_change(before, _momentum_W(plant)), tolerance=1e-10)


@case("closed form: with Jx = Jy and H along z, ω turns in B at the rate H / Jx")
def spinning_rotor_precesses() -> Result:
    """A body that pitches with rotors spinning about z precesses at H / Jx, in B."""
    vehicle = free_rotor_vehicle().replace(inertia=np.diag([0.01, 0.01, 0.02]))
    first = command(2.0, vehicle=vehicle)
    start = tumbling()._replace(w_WB_B=np.array([1.5, 0.0, 0.0]))
    plant = plant_with(
        RotorMomentum(),
        vehicle=vehicle,
        start=start,
        first=first,
        step=1e-4,
        integrator=RUNGE_KUTTA,
    )
    H = float(np.sum(vehicle.spin_inertia * plant.speed))
    expected = rotation_exponential([0.0, 0.0, H / 0.01 * 0.7]) @ start.w_WB_B
    return Result(
        value=largest(plant.step_physics(7000).w_WB_B - expected), tolerance=1e-10, unit="rad/s"
    )


@case("closed form: Jz Δω = −Σ I k Δw, at once and by the end of a lag")
def reaction_to_spinning_up() -> Result:
    """Rotors that spin up in free space turn the body the other way, with their momentum."""
    vehicle = free_rotor_vehicle()
    speed = np.sqrt(3.0 / vehicle.thrust_coefficient)
    expected = -float(np.sum(vehicle.spin_inertia * speed)) / float(vehicle.inertia[2, 2])
    errors = []
    for lag, steps in (((), 1), ((RotorLag(up=0.02),), 2000)):
        for integrator in ("semi-implicit-euler", RUNGE_KUTTA):
            plant = plant_with(RotorMomentum(), *lag, vehicle=vehicle, integrator=integrator)
            plant.send(command(3.0, vehicle=vehicle))
            errors.append(largest(plant.step_physics(steps).w_WB_B - [0.0, 0.0, expected]))
    return Result(value=max(errors), tolerance=1e-10, unit="rad/s")


@case("closed form: Jz Δω = Σ I w (1 − cos α)")
def tilting_spinning_rotors_turns_the_body() -> Result:
    """Tilting equal rotors by 45° takes momentum from the z axis, which the body takes up."""
    vehicle = free_rotor_vehicle()
    first = command(3.0, vehicle=vehicle)
    effects = (RotorMomentum(), ServoRateLimit(rate=np.radians(100.0)))
    plant = plant_with(*effects, vehicle=vehicle, first=first, integrator=RUNGE_KUTTA)
    plant.send(command(3.0, np.pi / 4, vehicle=vehicle))
    taken = float(np.sum(vehicle.spin_inertia * plant.speed)) * (1.0 - np.cos(np.pi / 4))
    expected = np.array([0.0, 0.0, taken / float(vehicle.inertia[2, 2])])
    error = largest(plant.step_physics(600).w_WB_B - expected)
    return Result(value=error, tolerance=1e-10, unit="rad/s")


@case(_EULER_EQUATION)
def momentum_is_conserved_whatever_the_rotors_do() -> Result:
    """Without torque from the air R (Jω + H) stays, while rotors spin up, reverse and tilt."""
    vehicle = free_rotor_vehicle()
    effects = (RotorMomentum(), RotorLag(up=0.02, down=0.03), ServoLag(time_constant=0.05))
    plant = plant_with(*effects, vehicle=vehicle, start=tumbling(), integrator=RUNGE_KUTTA)
    before, changes = _momentum_W(plant, vehicle_is_free=True), []
    numbers = np.random.default_rng(5)
    for _ in range(10):
        plant.send(Command(numbers.uniform(-5.0, 5.0, 8), numbers.uniform(0.0, 1.0, 1)))
        plant.step_physics(100)
        changes.append(_change(before, _momentum_W(plant, vehicle_is_free=True)))
    return Result(value=max(changes), tolerance=1e-8)


@case("J ω̇ = τ − ω × (Jω + H) − Σ I k ẇ z − Σ I k w z′(α) α̇, terms by hand")
def reaction_torques_term_by_term() -> Result:
    """A short step changes ω as the four torques say, each computed on its own."""
    vehicle, step = omnimorph(), 1e-6
    first = command(np.linspace(-2.0, 4.0, 8), 0.5)
    effects = (RotorMomentum(), RotorLag(up=0.02), ServoRateLimit(rate=1.5))
    plant = plant_with(*effects, start=tumbling(), first=first, step=step, integrator=RUNGE_KUTTA)
    w, speed, torque = plant.state.w_WB_B, plant.speed, plant.wrench[3:]
    plant.send(command(np.linspace(4.0, -2.0, 8), 1.0))
    measured = (plant.step_physics(1).w_WB_B - w) / step
    asked = np.linspace(4.0, -2.0, 8)
    wanted = np.sign(asked) * np.sqrt(np.abs(asked) / vehicle.thrust_coefficient)
    carried = vehicle.spin_inertia * vehicle.rotor_spin
    z0, zC, zS = vehicle.thrust_axis_parts
    z, slope = z0 + zC * np.cos(0.5) + zS * np.sin(0.5), zS * np.cos(0.5) - zC * np.sin(0.5)
    total = torque - np.cross(w, vehicle.inertia @ w + (carried * speed) @ z)
    total -= (carried * (wanted - speed) / 0.02) @ z + (carried * speed) @ slope * 1.5
    expected = np.linalg.solve(vehicle.inertia, total)
    error = float(np.linalg.norm(measured - expected) / np.linalg.norm(expected))
    return Result(value=error, tolerance=1e-4)


def _momentum_W(plant: SimulatedPlant, vehicle_is_free: bool = False) -> FloatArray:
    """Return R (Jω + H), the angular momentum of body and rotors about the centre of mass, in W."""
    vehicle = free_rotor_vehicle() if vehicle_is_free else omnimorph()
    state: State = plant.state
    carried = rotor_momentum_B(vehicle, plant)
    momentum: FloatArray = state.R_WB @ (vehicle.inertia @ state.w_WB_B + carried)
    return momentum


def _change(before: FloatArray, after: FloatArray) -> float:
    return float(np.linalg.norm(after - before) / np.linalg.norm(before))
