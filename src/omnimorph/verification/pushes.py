"""Wrenches from outside: what they push is force times time."""

from __future__ import annotations

import numpy as np

from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects import ConstantWrench, Effect, SineWrench, WrenchProfile
from omnimorph.verification.case import Result, case, largest
from omnimorph.verification.setting import EULER, RUNGE_KUTTA, omnimorph, plant_with, tumbling

_FORCE, _TORQUE = (3.0, -2.0, 5.0), (0.0, 0.0, 0.02)


def _gained(steps: int, *effects: Effect) -> FloatArray:
    """Return what a resting body gains in so many ms: m v (W) less that of falling, J ω (B)."""
    vehicle = omnimorph()
    plant = plant_with(*effects, integrator=RUNGE_KUTTA)
    end = plant.step_physics(steps)
    fall = np.array([0.0, 0.0, -GRAVITY * steps * 1e-3])
    momentum = vehicle.mass * (end.v_WB - fall)
    return np.concatenate([momentum, vehicle.inertia @ end.w_WB_B])


@case("closed form: momentum = force × time")
def constant_push() -> Result:
    """A constant force and torque give momentum in proportion to time; two of them add up."""
    half = ConstantWrench(force=(1.5, -1.0, 2.5), torque=(0.0, 0.0, 0.01))
    whole = ConstantWrench(force=_FORCE, torque=_TORQUE)
    expected = np.array([*_FORCE, *_TORQUE]) * 1.5
    errors = [_gained(1500, whole) - expected, _gained(1500, half, half) - expected]
    return Result(value=largest(errors), tolerance=1e-11, unit="N s, N m s")


@case("closed form: the push of F sin(ωt + φ) is F (cos φ − cos(ωt + φ)) / ω")
def swinging_push() -> Result:
    """A swinging force and torque give the momentum of their integral."""
    push = SineWrench(force=_FORCE, torque=_TORQUE, frequency=7.0, phase=0.4)
    area = (np.cos(0.4) - np.cos(7.0 * 1.5 + 0.4)) / 7.0
    error = _gained(1500, push) - np.array([*_FORCE, *_TORQUE]) * area
    return Result(value=largest(error), tolerance=1e-10, unit="N s, N m s")


@case("closed form: trapezia between the points, rectangles outside")
def push_along_a_profile() -> Result:
    """A profile gives the momentum of its area: linear between its points, held at both ends."""
    force = ((1.0, 0.0, 0.0), (4.0, 2.0, 0.0), (0.0, 0.0, -3.0))
    torque = ((0.0, 0.0, 0.01), (0.0, 0.0, 0.03), (0.0, 0.0, -0.02))
    push = WrenchProfile(times=(0.2, 0.5, 0.6), force=force, torque=torque)
    points = np.hstack([force, torque])
    held = 0.2 * points[0] + 0.4 * points[2]
    area = held + 0.15 * (points[0] + points[1]) + 0.05 * (points[1] + points[2])
    return Result(value=largest(_gained(1000, push) - area), tolerance=1e-12, unit="N s, N m s")


@case("definition: forces in W, torques in B")
def force_in_the_world_torque_in_the_body() -> Result:
    """A force from outside keeps its direction in W, a torque in B, however the body is turned."""
    start = tumbling()._replace(w_WB_B=np.zeros(3))
    push = ConstantWrench(force=_FORCE, torque=(0.02, 0.0, 0.0))
    errors = []
    for integrator in (EULER, RUNGE_KUTTA):
        end = plant_with(push, start=start, integrator=integrator).step_physics(1)
        gain = (end.v_WB - start.v_WB) / 1e-3 + np.array([0.0, 0.0, GRAVITY])
        errors.append(omnimorph().mass * gain - _FORCE)
        errors.append(omnimorph().inertia @ end.w_WB_B / 1e-3 - [0.02, 0.0, 0.0])
    return Result(value=largest(errors), tolerance=1e-11, unit="N, N m")


@case("definition: a push handed to a step acts for that step, like the same effect")
def push_handed_to_a_step() -> Result:
    """A wrench handed over with the steps does what the effect of the same wrench does."""
    wrench = np.array([*_FORCE, 0.01, -0.02, 0.03])
    effect = ConstantWrench(force=_FORCE, torque=(0.01, -0.02, 0.03))
    errors = []
    for integrator in (EULER, RUNGE_KUTTA):
        one = plant_with(effect, start=tumbling(), integrator=integrator).step_physics(300)
        other = plant_with(start=tumbling(), integrator=integrator).step_physics(300, wrench)
        errors += [largest(a - b) for a, b in zip(one, other, strict=True)]
    return Result(value=max(errors), tolerance=0.0)
