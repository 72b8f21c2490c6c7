"""A controller proposed from the vehicle alone: gains and weights that fly it without tuning."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.control.allocators import AllocationRule, FixedTilt, JointTilt, ThreeCandidates
from omnimorph.control.capability import Capability, capability
from omnimorph.control.margins import check_times, rotor_lag
from omnimorph.control.tracking import TrackingGains
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError, VehicleError
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray

_CROSSOVER = 0.5  # rad: crossover × lag; with critical damping it leaves a phase margin near 50°
_CROSSOVER_OF_CRITICAL = math.sqrt(2.0 + math.sqrt(5.0))  # |k_p + k_v s| = w² there, over √k_p
_SLOWER_THAN_ATTITUDE = 4.0  # crossover of a position held by leaning, below √k of the attitude
_POSITION_ERROR, _ATTITUDE_ERROR = 0.05, math.radians(5.0)  # m, rad: answered without saturation
_MISSED_LINEAR = 0.05  # × g: as costly to miss as hovering; the paper's Case B on OmniMorph: 0.046
_MISSED_ANGULAR = 0.1  # × the largest angular acceleration; Case B: 24.5 rad/s², 0.10 about x, y
_TURNING = 0.01  # × hovering: what it costs to turn one servo at its full rate
_SOFTEST = _MISSED_LINEAR**2 * GRAVITY / _POSITION_ERROR  # 1/s²: 0.49, see `propose_controller`
_SOFTEST_LEANING = 1.0 / 5.0**2  # 1/s²: a time constant of 5 s


@dataclass(frozen=True, kw_only=True)
class ProposedController:
    """Gains and weights proposed for a vehicle, and why.

    Attributes
    ----------
    gains : TrackingGains
        Of the pose controller.
    allocator : AllocationRule
        The rule and its weights.
    reasons : tuple of str
        What decided each number, a sentence each.
    """

    gains: TrackingGains
    allocator: AllocationRule
    reasons: tuple[str, ...]


def propose_controller(
    vehicle: VehicleLike,
    control_period: float = 0.004,
    delay: float = 0.0,
    start_tilt: ArrayLike = 0.0,
) -> ProposedController:
    """Propose a controller from mass, inertia, limits and lag.

    *Bandwidth.* On each axis an acceleration is asked of a double integrator and comes late by
    ``T = τ + delay + period / 2``: the rotors' lag (the slowest one's, up or down), the delay, and
    half of the time for which a command is held. The crossover is ``w_c = 1 / 2T``; T then costs
    about 1/2 rad = 29° of phase. *Damping* is critical, ``k_v = 2 √k_p``: without lag the error
    does not overshoot, and the crossover is ``√(2 + √5) √k_p = 2.06 √k_p``, so
    ``√k_p = w_c / 2.06``, with 76° of phase before T takes its share.

    *Authority.* ``k_p · 5 cm`` is at most the acceleration that the vehicle has to spare beside its
    weight, and ``k · 5°`` its angular acceleration about each axis while it hovers, both exact, at
    the tilt of the largest sideways force. 5 cm and 5° are 50 and 30 standard deviations of the
    realistic plant's noise: errors that only a disturbance makes.

    *Leaning.* A vehicle without sideways force at any tilt moves sideways by leaning. There the
    attitude must be faster than the position: its crossover is at a quarter of the slower √k of
    roll and pitch, an eighth of their crossover; the closed attitude loop is late by 2/√k, 28° at
    that frequency. One whose several servos turn to push sideways is held as softly: its tilts are
    as slow as a lean.

    *Weights.* A cost of 1 is the effort of hovering level at the tilt where it is least:
    ``W1 = 1 / ‖u‖²``, ``W3 = W1`` as in the paper's Case B. Missing 5 % of g, or a tenth of the
    largest angular acceleration about an axis, costs 1 too. These two ratios are those of Case B on
    OmniMorph, rounded (4.6 %, and 0.09 to 0.10 about x and y), so the QP is conditioned alike.

    *Softest.* Effort makes a hovering vehicle miss 1/400 of g. Where that led more than 5 cm astray
    (k_p below 0.49/s²) nothing is proposed: the delay is too long, or too little thrust is left.
    Nothing of that pulls sideways a vehicle that leans; there the limit is 1/√k_p = 5 s.

    Parameters
    ----------
    vehicle : Vehicle
        Any that hovers level.
    control_period : float, s
        Time between two commands.
    delay : float, s
        From the measurement to the command, or from the command to the rotor.
    start_tilt : float or (m,) array, rad
        Where a rule that does not move the servos leaves them.

    Returns
    -------
    ProposedController
        With its reasons.

    Raises
    ------
    ScenarioError
        If the period is not positive or the delay negative, or if both are so long that nothing
        firm enough is left; it states the longest delay that could be used.
    VehicleError
        If the vehicle cannot hover level, cannot accelerate up and down, or not turn about an axis.

    Notes
    -----
    The noise of the sensors is no property of the vehicle and is not considered: k_v times the
    noise of the velocity is commanded as it comes.

    Examples
    --------
    OmniMorph's rotors lag by 20 ms: T = 22 ms, √k = 1 / (2 · 0.022 · 2.06) = 11.04/s.

    >>> import omnimorph as om
    >>> gains = propose_controller(om.load_vehicle("omnimorph")).gains
    >>> round(gains.attitude[0]), round(gains.rate[0])
    (122, 22)
    """
    vehicle = as_vehicle(vehicle)
    check_times(control_period, delay)
    able = capability(vehicle, start_tilt)
    lag = rotor_lag(vehicle) + delay + control_period / 2.0
    position, attitude = _frequencies(able, lag)
    _check_firmness(vehicle, able, position, lag, delay)
    gains = TrackingGains(
        position=tuple(position**2),
        velocity=tuple(2.0 * position),
        attitude=tuple(attitude**2),
        rate=tuple(2.0 * attitude),
    )
    reasons = _reasons(able, lag, position, attitude)
    return ProposedController(gains=gains, allocator=_rule(vehicle, able), reasons=reasons)


def _frequencies(able: Capability, lag: float) -> tuple[FloatArray, FloatArray]:
    """Return √k_p and √k, 1/s, (3,) each, of the fastest loops that lag and authority allow."""
    fastest = _CROSSOVER / lag / _CROSSOVER_OF_CRITICAL
    attitude = np.minimum(fastest, np.sqrt(able.angular / _ATTITUDE_ERROR))
    spare = np.array([able.sideways, able.sideways, able.vertical])
    position = np.minimum(fastest, np.sqrt(spare / _POSITION_ERROR))
    if able.leans or able.turns:
        crossover = float(attitude[:2].min()) / _SLOWER_THAN_ATTITUDE
        position[:2] = min(fastest, crossover / _CROSSOVER_OF_CRITICAL)
    return position, attitude


def _rule(vehicle: Vehicle, able: Capability) -> AllocationRule:
    """Return the rule for so many servos, with its weights."""
    weights: dict[str, Any] = {
        "W1": 1.0 / able.effort,
        "W2_position": (1.0 / (_MISSED_LINEAR * GRAVITY) ** 2,) * 3,
        "W2_attitude": tuple(1.0 / (_MISSED_ANGULAR * able.angular) ** 2),
        "W3": 1.0 / able.effort,
    }
    if vehicle.n_servos > 1:
        return JointTilt(**weights, W4=_TURNING)
    return ThreeCandidates(**weights) if vehicle.n_servos == 1 else FixedTilt(**weights)


def _check_firmness(
    vehicle: Vehicle, able: Capability, position: FloatArray, lag: float, delay: float
) -> None:
    """Refuse loops so soft that what the effort makes the vehicle miss leads it astray."""
    if _firm(able, position):
        return
    room = _longest_lag(able) - (lag - delay)
    if room > 0.0:
        allowed = f"at most {room:.4g} s for {vehicle.name}: beyond it no gain is firm enough"
        raise ScenarioError.at("the loop", "delay", delay, allowed)
    place = f"vehicle {vehicle.name}"
    raise VehicleError(
        f"{place}: no controller is proposed: even without a delay its rotors' lag and its thrust "
        f"to spare ({able.vertical:.3g} m/s² up and down) leave no gain that is firm enough.",
        file=place,
    )


def _firm(able: Capability, position: FloatArray) -> bool:
    sideways = _SOFTEST_LEANING if able.leans else _SOFTEST
    return bool((position**2 >= (sideways, sideways, _SOFTEST)).all())


def _longest_lag(able: Capability) -> float:
    """Return the longest lag with firm loops, s; 0 if there is none. The longer, the softer."""
    low, high = 0.0, 1.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        firm = _firm(able, _frequencies(able, middle)[0])
        low, high = (middle, high) if firm else (low, middle)
    return low if low > 1e-9 else 0.0


def _reasons(
    able: Capability, lag: float, position: FloatArray, attitude: FloatArray
) -> tuple[str, ...]:
    """Say what decided the gains, a sentence each."""
    fastest = _CROSSOVER / lag / _CROSSOVER_OF_CRITICAL
    by_lag = f"the lag of {1e3 * lag:.3g} ms allows √k = {fastest:.3g}/s"
    spare = {
        "sideways": (position[0], able.sideways, _POSITION_ERROR, "m/s²", "5 cm"),
        "up and down": (position[2], able.vertical, _POSITION_ERROR, "m/s²", "5 cm"),
        "roll": (attitude[0], able.angular[0], _ATTITUDE_ERROR, "rad/s²", "5°"),
        "pitch": (attitude[1], able.angular[1], _ATTITUDE_ERROR, "rad/s²", "5°"),
        "yaw": (attitude[2], able.angular[2], _ATTITUDE_ERROR, "rad/s²", "5°"),
    }
    sentences = []
    for name, (chosen, most, error, unit, shown) in spare.items():
        if name == "sideways" and able.leans:
            reason = "it moves so by leaning, slower than the attitude that leans it"
        elif name == "sideways" and able.turns:
            reason = "it moves so by turning its servos, slower than its attitude"
        elif chosen < fastest:
            reason = f"{shown} of error may ask for no more than the {most:.3g} {unit} to spare"
        else:
            asked = (
                f"{shown} of error then ask for {chosen**2 * error:.3g} of the {most:.3g} {unit}"
            )
            reason = f"{by_lag}; {asked} to spare"
        sentences.append(f"{name}: k = {chosen**2:.4g}/s², {reason}.")
    tilt = ", ".join(f"{angle:.3g}°" for angle in np.degrees(able.tilt))
    sentences.append(
        "What there is to spare is that of level hover" + (f" at {tilt}." if tilt else ".")
    )
    return tuple(sentences)
