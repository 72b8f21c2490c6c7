"""Servos and the course of a command: rate, lag, stops, delay, control period."""

from __future__ import annotations

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects import CommandDelay, Effect, ServoLag, ServoRateLimit
from omnimorph.simulation.plant import PlantModel, SimulatedPlant
from omnimorph.verification.case import Result, case, largest
from omnimorph.verification.setting import (
    EULER,
    RUNGE_KUTTA,
    Integrator,
    command,
    omnimorph,
    plant_with,
)


def _tilts(
    start: float, asked: float, steps: int, *effects: Effect, integrator: Integrator = EULER
) -> FloatArray:
    """Return the tilt, rad, after each of so many steps of 1 ms."""
    plant = plant_with(*effects, first=command(0.0, start), integrator=integrator)
    plant.send(command(0.0, asked))
    tilts = []
    for _ in range(steps):
        plant.step_physics()
        tilts.append(float(plant.tilt[0]))
    return np.array(tilts)


_BOTH: tuple[Integrator, ...] = (EULER, RUNGE_KUTTA)
_TIMES = np.arange(1, 1001) * 1e-3


@case("closed form: a ramp at the rate, then the command")
def servo_moves_at_its_rate() -> Result:
    """A tilt command of 45° is reached at 100°/s, up and down: no sooner, and never passed."""
    limit, errors = ServoRateLimit(), []
    for integrator in _BOTH:
        up = np.minimum(np.radians(100.0) * _TIMES, np.pi / 4)
        errors.append(_tilts(0.0, np.pi / 4, 1000, limit, integrator=integrator) - up)
        errors.append(_tilts(np.pi / 4, 0.0, 1000, limit, integrator=integrator) - np.pi / 4 + up)
        half = np.minimum(np.radians(50.0) * _TIMES, 0.5)
        slow = ServoRateLimit(rate=np.radians(50.0))
        errors.append(_tilts(0.0, 0.5, 1000, slow, integrator=integrator) - half)
    return Result(value=largest(errors), tolerance=1e-12, unit="rad")


@case("closed form α(t) = α_c + (α_0 − α_c) e^(−t/τ)")
def servo_follows_with_its_lag() -> Result:
    """A lagging servo follows a step as a first-order system does."""
    lag, errors = ServoLag(time_constant=0.08), []
    for integrator in _BOTH:
        expected = 0.9 - 0.8 * np.exp(-_TIMES / 0.08)
        errors.append(_tilts(0.1, 0.9, 1000, lag, integrator=integrator) - expected)
    return Result(value=largest(errors), tolerance=1e-12, unit="rad")


@case("closed form: a ramp while the lag asks for more than the rate, then the lag")
def servo_with_rate_and_lag() -> Result:
    """With both, the servo moves at its rate until it is τ times the rate from its goal."""
    effects = (ServoLag(time_constant=0.08), ServoRateLimit(rate=1.0))
    step = 1e-3
    tilts = _tilts(0.0, 0.5, 1000, *effects)
    # In steps: full rate as long as (1 − e^(−h/τ)) × what is left exceeds rate × h.
    ramp = 1 + int(np.floor((0.5 - step / (1.0 - np.exp(-step / 0.08))) / step))
    reached = ramp * step
    slow = 0.5 + (reached - 0.5) * np.exp(-(_TIMES - reached) / 0.08)
    expected = np.where(reached >= _TIMES - 1e-9, _TIMES, slow)
    return Result(value=largest(tilts - expected), tolerance=1e-12, unit="rad")


@case("the catalogue's limits, 0° and 60°")
def servo_stops_at_its_limits() -> Result:
    """The tilt does not leave its limits, whatever is commanded and however it gets there."""
    errors = []
    for effects in ((), (ServoRateLimit(),), (ServoLag(time_constant=0.05),)):
        errors.append(max(_tilts(0.0, 2.0, 1500, *effects)) - np.pi / 3)
        errors.append(min(_tilts(1.0, -2.0, 1500, *effects)))
    return Result(value=largest(errors), tolerance=1e-12, unit="rad")


@case("definition: sent at t, in force from t + delay on")
def command_arrives_on_time() -> Result:
    """A command sent at 3 ms with a delay of 7 ms acts from 10 ms on; later ones follow."""
    errors = []
    for integrator in _BOTH:
        plant = plant_with(CommandDelay(time=0.007), first=command(1.0), integrator=integrator)
        speeds = []
        for k in range(40):
            if k in (3, 8, 9):
                plant.send(command(float(k)))
            plant.step_physics()
            speeds.append(plant.speed[0])
        thrust = np.array(speeds) ** 2 * omnimorph().thrust_coefficient[0]
        expected = np.array([1.0] * 10 + [3.0] * 5 + [8.0] + [9.0] * 24)
        errors.append(thrust - expected)
    return Result(value=largest(errors), tolerance=1e-12, unit="N")


@case("definition: a command is held for a control period")
def command_is_held_between_control_steps() -> Result:
    """A control step of 4 ms is four physics steps of 1 ms under the same command."""
    model = PlantModel(physics_step=1e-3, control_period=4e-3)
    long = SimulatedPlant(omnimorph(), model)
    short = SimulatedPlant(omnimorph(), PlantModel(physics_step=1e-3, control_period=1e-3))
    thrust, errors = np.linspace(1.0, 2.0, 8), []
    for k in range(25):
        asked = command(thrust * (1.0 + 0.1 * np.sin(k)), 0.02 * k)
        one = long.step(asked)
        for _ in range(4):
            other = short.step(asked)
        errors += [largest(a - b) for a, b in zip(one, other, strict=True)]
        errors.append(long.time - short.time)
    return Result(value=largest(errors), tolerance=0.0)
