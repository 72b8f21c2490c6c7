"""Rotors: lag, limits, dead band, lost thrust, and what the controller wrongly believes."""

from __future__ import annotations

import numpy as np

from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects import (
    DeadBand,
    Effect,
    Effectiveness,
    ModelMismatch,
    RotorLag,
    SpeedLimits,
)
from omnimorph.verification.case import Result, case, largest
from omnimorph.verification.setting import (
    EULER,
    RUNGE_KUTTA,
    TURN,
    Integrator,
    command,
    omnimorph,
    plant_with,
)

_STEP_RESPONSE = "closed form w(t) = w_c + (w_0 − w_c) e^(−t/τ)"
_DOCUMENTED = "the effect's definition"


def _thrust(speed_Hz: float) -> float:
    """Return the thrust of a rotor of OmniMorph at a speed."""
    return float(omnimorph().thrust_coefficient[0]) * TURN**2 * speed_Hz * abs(speed_Hz)


def _speeds(
    start_Hz: float, asked_Hz: float, steps: int, *effects: Effect, integrator: Integrator = EULER
) -> FloatArray:
    """Return the speed of the first rotor, Hz, after each of so many steps of 1 ms."""
    first = command(_thrust(start_Hz))
    plant = plant_with(*effects, first=first, integrator=integrator)
    plant.send(command(_thrust(asked_Hz)))
    speeds = []
    for _ in range(steps):
        plant.step_physics()
        speeds.append(plant.speed[0] / TURN)
    return np.array(speeds)


@case(_STEP_RESPONSE)
def rotor_lag_after_one_time_constant() -> Result:
    """After one time constant a rotor has covered 63.2 % of a step, whatever the integrator."""
    lag = RotorLag(up=0.02)
    share = [
        (_speeds(30.0, 90.0, 20, lag, integrator=integrator)[-1] - 30.0) / 60.0
        for integrator in (EULER, RUNGE_KUTTA)
    ]
    worst = max(share, key=lambda value: abs(value - (1.0 - np.exp(-1.0))))
    return Result(value=worst, expected=1.0 - float(np.exp(-1.0)), tolerance=1e-12)


@case(_STEP_RESPONSE)
def rotor_lag_up_and_down() -> Result:
    """A rotor follows with one time constant when it speeds up and with another when it slows."""
    lag, t, errors = RotorLag(up=0.02, down=0.05), np.arange(1, 101) * 1e-3, []
    for start, asked, tau in ((30.0, 90.0, 0.02), (90.0, 30.0, 0.05), (-30.0, -90.0, 0.02)):
        expected = asked + (start - asked) * np.exp(-t / tau)
        for integrator in (EULER, RUNGE_KUTTA):
            errors.append(
                largest(_speeds(start, asked, 100, lag, integrator=integrator) - expected)
            )
    return Result(value=max(errors), tolerance=1e-10, unit="Hz")


@case("closed form: down to rest with one time constant, then up with the other")
def rotor_lag_through_a_reversal() -> Result:
    """A reversing rotor slows with one time constant and, past rest, speeds up with the other."""
    lag, t = RotorLag(up=0.01, down=0.04), np.arange(1, 101) * 1e-3
    slowing = -80.0 + 160.0 * np.exp(-t / 0.04)
    turned = int(np.argmax(slowing < 0.0))  # the step in which it passes through rest
    expected = slowing.copy()
    later = t[turned + 1 :] - t[turned]
    expected[turned + 1 :] = -80.0 + (slowing[turned] + 80.0) * np.exp(-later / 0.01)
    return Result(
        value=largest(_speeds(80.0, -80.0, 100, lag) - expected), tolerance=1e-10, unit="Hz"
    )


@case(_DOCUMENTED)
def vehicle_without_lag_follows_at_once() -> Result:
    """Without the effect the speed that gives the thrust is there after one step."""
    error = largest(_speeds(10.0, -123.0, 1) + 123.0)
    return Result(value=error, tolerance=1e-10, unit="Hz")


@case("the catalogue's limit: 5.3587 N, 169.56 Hz")
def speed_limits_hold() -> Result:
    """However much is asked, no rotor turns faster than its limit, nor than one given instead."""
    given, limit = SpeedLimits(largest=100.0 * TURN), np.sqrt(5.3587 / 1.8638e-4)
    errors = [
        _speeds(0.0, 500.0, 1, SpeedLimits())[0] - limit,
        _speeds(0.0, -500.0, 1, SpeedLimits())[0] + limit,
        _speeds(0.0, 500.0, 1, given)[0] - 100.0,
        _speeds(0.0, -500.0, 1, given)[0] + 100.0,
        _speeds(0.0, 99.0, 1, given)[0] - 99.0,
        _speeds(0.0, 500.0, 1)[0] - 500.0,
    ]
    return Result(value=largest(errors), tolerance=1e-10, unit="Hz")


@case(_DOCUMENTED)
def one_way_rotors_do_not_reverse() -> Result:
    """A rotor that turns one way only keeps its lower limit, whatever its upper one is made."""
    vehicle = omnimorph().replace(speed_min=np.full(8, 20.0 * TURN))
    errors = []
    for limits in (SpeedLimits(), SpeedLimits(largest=100.0 * TURN)):
        plant = plant_with(limits, vehicle=vehicle)
        plant.send(command(_thrust(-50.0)))
        plant.step_physics()
        errors.append(largest(plant.speed / TURN - 20.0))
    return Result(value=max(errors), tolerance=1e-10, unit="Hz")


@case("definition: the nearer of rest and ±w_dead, 30 Hz here")
def dead_band_gives_the_nearer() -> Result:
    """A command inside the dead band gives rest or the band's edge, whichever is nearer."""
    band = DeadBand(smallest=30.0 * TURN)
    asked = {0.0: 0.0, 14.9: 0.0, 15.1: 30.0, 29.0: 30.0, 40.0: 40.0, -14.9: 0.0, -20.0: -30.0}
    errors = [_speeds(0.0, ask, 1, band)[0] - given for ask, given in asked.items()]
    return Result(value=largest(errors), tolerance=1e-10, unit="Hz")


def _reversal(integrator: Integrator) -> float:
    """Return the error of a reversal from 80 to −80 Hz: lag 20 ms, band 30 Hz, rest 10 ms."""
    effects = (RotorLag(up=0.02), DeadBand(smallest=30.0 * TURN, reversal_time=0.01))
    k = np.arange(1, 101)
    # It brakes by e^(−t/20 ms) until a step begins with it inside the band: at 20 ms, 29.4 Hz.
    braking = 80.0 * np.exp(-k / 20.0)
    starting = -80.0 * (1.0 - np.exp(-(k - 30.0) / 20.0))
    expected = np.where(k <= 20, braking, np.where(k <= 30, 0.0, starting))
    return largest(_speeds(80.0, -80.0, 100, *effects, integrator=integrator) - expected)


@case("closed form: braking, rest for the reversal time, start")
def reversal_takes_its_time() -> Result:
    """A reversing rotor brakes to its dead band, rests for 10 ms, then starts the other way."""
    return Result(value=_reversal(EULER), tolerance=1e-10, unit="Hz")


@case("closed form: braking, rest for the reversal time, start")
def reversal_takes_its_time_with_runge_kutta() -> Result:
    """Runge-Kutta gives the same reversal, to the step."""
    return Result(value=_reversal(RUNGE_KUTTA), tolerance=1e-10, unit="Hz")


@case("definition: rest for the reversal time")
def reversal_takes_its_time_without_lag() -> Result:
    """A rotor without lag rests for the reversal time, 5 ms, too before it turns the other way."""
    band = DeadBand(smallest=30.0 * TURN, reversal_time=0.005)
    expected = np.array([0.0] * 5 + [-80.0] * 5)
    errors = [
        _speeds(80.0, -80.0, 10, band, integrator=integrator) - expected
        for integrator in (EULER, RUNGE_KUTTA)
    ]
    return Result(value=largest(errors), tolerance=1e-10, unit="Hz")


@case("definition: a band of zero width is none")
def dead_band_of_nothing_changes_nothing() -> Result:
    """With a dead band of 0 Hz and no reversal time a rotor reverses as if there were none."""
    effects = (RotorLag(up=0.02), DeadBand(smallest=0.0))
    errors = _speeds(80.0, -80.0, 100, *effects) - _speeds(80.0, -80.0, 100, effects[0])
    return Result(value=largest(errors), tolerance=1e-10, unit="Hz")


@case("definition: the command decides, not the braking")
def reversal_called_off() -> Result:
    """A command back the old way ends the braking: the rotor speeds up again, without a rest."""
    effects = (RotorLag(up=0.02), DeadBand(smallest=30.0 * TURN, reversal_time=0.01))
    plant = plant_with(*effects, first=command(_thrust(80.0)))
    plant.send(command(_thrust(-80.0)))
    plant.step_physics(10)
    braked = float(plant.speed[0]) / TURN
    plant.send(command(_thrust(80.0)))
    plant.step_physics(20)
    expected = 80.0 + (braked - 80.0) * np.exp(-1.0)
    return Result(value=largest(plant.speed / TURN - expected), tolerance=1e-10, unit="Hz")


@case("definition: thrust c_f share w|w|, drag c_τ w|w|")
def lost_thrust_leaves_the_drag() -> Result:
    """Degraded rotors give their share of the thrust; speed and drag torque are what they were."""
    vehicle, tilt = omnimorph(), 0.7
    share = np.array([1.0, 0.65, 0.0, 0.3, 1.0, 0.9, 0.5, 0.7])
    thrust = np.linspace(-4.0, 5.0, 8)
    first = command(thrust, tilt)
    plant = plant_with(Effectiveness(share=tuple(share.tolist())), first=first)
    A = allocation_matrix(vehicle, tilt)
    drag = np.zeros((6, 8))
    drag[3:] = -vehicle.rotor_spin * vehicle.kappa * A[:3]
    errors = [*(plant.wrench - ((A - drag) * share + drag) @ thrust)]
    errors += [*(plant.speed - plant_with(first=first).speed)]
    return Result(value=largest(errors), tolerance=1e-12, unit="N, N m")


@case("definition: the true vehicle is the believed one times the factors")
def true_vehicle_differs_from_the_believed() -> Result:
    """With another mass, inertia, thrust and drag than believed, the body answers with the true."""
    vehicle, tilt = omnimorph(), 0.7
    factors = ModelMismatch(mass=1.2, inertia=0.8, thrust_coefficient=0.9, drag_coefficient=1.1)
    thrust = np.linspace(1.0, 2.0, 8)
    plant = plant_with(factors, first=command(thrust, tilt))
    truth = factors.true_vehicle(vehicle)
    wrench = allocation_matrix(truth, tilt) @ (0.9 * thrust)
    errors = [*(plant.wrench - wrench)]
    end = plant.step_physics(1)
    lift = wrench[:3] / (1.2 * vehicle.mass) - np.array([0.0, 0.0, GRAVITY])
    errors += [*(end.v_WB / 1e-3 - lift)]
    errors += [*(end.w_WB_B / 1e-3 - np.linalg.solve(0.8 * vehicle.inertia, wrench[3:]))]
    return Result(value=largest(errors), tolerance=1e-10)
