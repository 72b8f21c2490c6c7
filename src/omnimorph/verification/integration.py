"""The rigid body: what stays, what falls, and how fast the error vanishes with the step."""

from __future__ import annotations

import numpy as np

from omnimorph.model.dynamics import GRAVITY, rotation_exponential
from omnimorph.protocols import FloatArray, State
from omnimorph.simulation.effects import Effect, RotorLag, RotorMomentum, ServoLag, SineWrench
from omnimorph.simulation.plant import SimulatedPlant
from omnimorph.verification.case import Result, case, largest, order_of
from omnimorph.verification.setting import (
    EULER,
    RUNGE_KUTTA,
    TURN,
    Integrator,
    command,
    omnimorph,
    plant_with,
    tumbling,
)

_CONSERVED = "conservation law of the torque-free rigid body"


def _after_free_motion() -> tuple[State, State]:
    """Return a tumbling motion and what becomes of it in two seconds without thrust."""
    plant = plant_with(start=tumbling(), integrator=RUNGE_KUTTA)
    return tumbling(), plant.step_physics(2000)


@case(_CONSERVED)
def angular_momentum_of_free_motion() -> Result:
    """Without thrust, R J ω stays what it was for 2 s of tumbling (relative change)."""
    J = omnimorph().inertia
    momentum = [state.R_WB @ J @ state.w_WB_B for state in _after_free_motion()]
    change = float(np.linalg.norm(momentum[1] - momentum[0]) / np.linalg.norm(momentum[0]))
    return Result(value=change, tolerance=1e-11)


@case(_CONSERVED)
def energy_of_free_motion() -> Result:
    """Without thrust, ½ ω·Jω stays what it was for 2 s of tumbling (relative change)."""
    J = omnimorph().inertia
    energy = [float(state.w_WB_B @ J @ state.w_WB_B) / 2.0 for state in _after_free_motion()]
    return Result(value=abs(energy[1] / energy[0] - 1.0), tolerance=1e-11)


@case("closed form p0 + v0 t − ½ g t², v0 − g t")
def free_fall() -> Result:
    """Without thrust, the centre of mass follows the parabola for 2 s, however the body tumbles."""
    start, end = _after_free_motion()
    down, time = np.array([0.0, 0.0, -GRAVITY]), 2.0
    p = start.p_WB + start.v_WB * time + down * time**2 / 2.0
    error = largest([*(end.p_WB - p), *(end.v_WB - start.v_WB - down * time)])
    return Result(value=error, tolerance=1e-11, unit="m, m/s")


@case("closed form: semi-implicit Euler lands −½ g t h below the parabola")
def free_fall_of_the_euler_steps() -> Result:
    """Semi-implicit Euler falls by ½ g t h further than the parabola, with h the physics step."""
    plant = plant_with(integrator=EULER)
    fallen = -float(plant.step_physics(1000).p_WB[2])
    return Result(
        value=fallen - GRAVITY / 2.0, expected=GRAVITY / 2.0 * 1e-3, tolerance=1e-12, unit="m"
    )


@case("closed form exp([ω t]×) for a rotation about a principal axis")
def steady_turn() -> Result:
    """A turn about a principal axis goes on for ever: ten turns lead back to the same attitude."""
    start = tumbling()._replace(w_WB_B=np.array([0.0, TURN, 0.0]))
    errors = []
    for integrator in (EULER, RUNGE_KUTTA):
        end = plant_with(start=start, integrator=integrator).step_physics(10_000)
        errors.append(largest(end.R_WB - start.R_WB))
        middle = plant_with(start=start, integrator=integrator).step_physics(137)
        turned = start.R_WB @ rotation_exponential(0.137 * start.w_WB_B)
        errors.append(largest(middle.R_WB - turned))
    return Result(value=max(errors), tolerance=2e-12)


@case("RᵀR = I: the attitude is a rotation")
def attitude_stays_a_rotation() -> Result:
    """After 100 000 steps of tumbling the attitude is still a rotation, to rounding."""
    errors = []
    for integrator in (EULER, RUNGE_KUTTA):
        R = plant_with(start=tumbling(), integrator=integrator).step_physics(100_000).R_WB
        errors.append(largest(R.T @ R - np.eye(3)))
    return Result(value=max(errors), tolerance=5e-13)


def _thrusts() -> FloatArray:
    """Return uneven thrusts that lift, push and turn a little."""
    return np.array([1.6, 1.5, 1.7, 1.4, 1.55, 1.65, 1.5, 1.6])


def _order(integrator: Integrator, steps: tuple[float, ...], *effects: Effect) -> Result:
    """Measure the order of convergence of a tumbling flight under constant thrust."""
    ends = []
    for step in steps:
        plant = plant_with(*effects, start=tumbling(), step=step, integrator=integrator)
        if not effects:  # nothing to settle: the rotors turn from the start
            first = command(_thrusts(), 0.6)
            plant = plant_with(start=tumbling(), first=first, step=step, integrator=integrator)
        plant.send(command(_thrusts(), 0.6))
        ends.append(_numbers(plant, round(0.4 / step)))
    expected = 4.0 if integrator == RUNGE_KUTTA else 1.0
    return Result(value=order_of(ends), expected=expected, tolerance=0.2)


def _numbers(plant: SimulatedPlant, steps: int) -> FloatArray:
    end = plant.step_physics(steps)
    return np.concatenate([part.ravel() for part in end])


_COARSE = (8e-3, 4e-3, 2e-3)
_FINE = (1e-3, 5e-4, 2.5e-4)
_ORDER = "observed order of convergence, by halving the step twice"


@case(_ORDER)
def order_of_semi_implicit_euler() -> Result:
    """Semi-implicit Euler is of first order on a tumbling body under constant thrust."""
    return _order(EULER, _FINE)


@case(_ORDER)
def order_of_runge_kutta() -> Result:
    """Runge-Kutta on SO(3) is of fourth order on the same flight."""
    return _order(RUNGE_KUTTA, _COARSE)


@case(_ORDER)
def order_of_semi_implicit_euler_with_lag() -> Result:
    """Semi-implicit Euler keeps its order while rotors spin up with a lag."""
    return _order(EULER, _FINE, RotorLag(up=0.02))


@case(_ORDER)
def order_of_runge_kutta_with_lag() -> Result:
    """Runge-Kutta keeps its order while rotors spin up with a lag."""
    return _order(RUNGE_KUTTA, _COARSE, RotorLag(up=0.05))


@case(_ORDER)
def order_of_runge_kutta_with_everything_smooth() -> Result:
    """It does so with lagging rotors that carry momentum, a lagging tilt and a swinging push."""
    push = SineWrench(force=(2.0, 0.0, -1.0), torque=(0.05, -0.03, 0.02), frequency=9.0, phase=0.3)
    lags = (RotorLag(up=0.05), ServoLag(time_constant=0.1))
    return _order(RUNGE_KUTTA, _COARSE, *lags, RotorMomentum(), push)
