"""Symmetries of the vehicle, which the whole closed loop must share.

OmniMorph is mapped onto itself by S = Rz(90°) · diag(1, 1, −1): a quarter turn about z, then the
mirror z → −z. In the table of rotors take (+, +, +), thrust axis (−s, 0, c), spin −1:

- the quarter turn alone leads it to (−, +, +), (0, −s, c), where a rotor of the *other* spin sits;
- the mirror alone leads it to (+, +, −), axis (−s, 0, −c); a bi-directional rotor that thrusts
  along an axis is one that thrusts backwards along the opposite axis, (s, 0, c), where a rotor
  sits. A mirror image turns the other way, though, and this one does not;
- both together lead it to (−, +, −), axis −(0, s, c), turning the other way: there is such a rotor.

So S maps rotor i to a rotor σ(i) with the thrust negated, and exchanges the x and y axes up to
sign: it needs Jx = Jy. Done twice it is the half turn Rz(180°), with thrusts kept, any inertia.

S turns the z axis of the body, but gravity must stay. So the world is mapped by another matrix Q
that keeps e3 and has the determinant of S, here the mirror diag(1, −1, 1); an attitude follows as
Q R Sᵀ, again a rotation. Angular velocity is an axial vector: it becomes det(S) S ω in B. A level
flight so becomes one upside down.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from omnimorph.control.allocators import ThreeCandidates
from omnimorph.control.controller import PoseController
from omnimorph.control.tracking import TrackingGains
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.dynamics import hover_thrust, rotation_exponential
from omnimorph.protocols import Command, FloatArray, Reference, State
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.simulation.effects import RotorLag, RotorMomentum, ServoRateLimit
from omnimorph.simulation.fly import fly
from omnimorph.simulation.plant import PlantModel, SimulatedPlant
from omnimorph.simulation.scenario_files import load_scenario
from omnimorph.units import to_SI
from omnimorph.verification.case import Result, case, largest
from omnimorph.verification.setting import omnimorph, spin_axes

_START_TILT = 0.5
_HALF_TURN = np.diag([-1.0, -1.0, 1.0])
_QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
_ROTO_REFLECTION = _QUARTER_TURN @ np.diag([1.0, 1.0, -1.0])
_SOURCE = "symmetry of the table of rotors, see the module's text"


def _path(Q: FloatArray, R_start: FloatArray) -> SegmentReference:
    """Return a path of 1.5 s, sideways with a roll, as Q maps it: from the attitude `R_start`."""
    axis = np.linalg.det(Q) * Q @ np.array([0.6, 0.0, 0.8])  # an axial vector
    segments = [
        Segment(0.6, Q @ np.array([0.1, 0.05, 0.1])),
        Segment(0.9, Q @ np.array([0.0, -0.1, 0.05]), axis, 0.5),
    ]
    return SegmentReference(Q @ np.array([0.2, -0.1, 1.2]), R_start, segments)


def _images(vehicle: Vehicle, S: FloatArray) -> tuple[NDArray[np.int64], float]:
    """Return the rotor σ(i) on which S lays each rotor, and the sign that its thrust takes."""
    hubs = vehicle.rotor_position
    distance = np.linalg.norm((hubs @ S.T)[:, np.newaxis] - hubs[np.newaxis], axis=2)
    image = np.argmin(distance, axis=1)
    axes = spin_axes(vehicle, np.array([0.7]))
    sign = np.sum((axes @ S.T) * axes[image], axis=1)
    if not (np.allclose(distance.min(axis=1), 0.0) and np.allclose(np.abs(sign), 1.0)):
        raise ValueError("the vehicle does not have this symmetry")
    return image, float(sign[0])


def _flight(
    vehicle: Vehicle, reference: Reference, backwards: float
) -> list[tuple[State, Command]]:
    """Fly 1.5 s, control every 2 ms, with lag, rotor momentum and a slow tilt; return the rows."""
    effects = (RotorLag(up=0.02), RotorMomentum(), ServoRateLimit())
    model = PlantModel(control_period=2e-3, effects=effects)
    weights = (1e-5, 1e-5)
    rule = ThreeCandidates(
        W1=to_SI(weights[0], "per_Hz4"),
        W2_position=(3e4,) * 3,
        W2_attitude=(10.0,) * 3,
        W3=to_SI(weights[1], "per_Hz4"),
    )
    thrust = backwards * hover_thrust(vehicle, _START_TILT)
    start = State(*reference(0.0)[:4])
    controller = PoseController(vehicle, TrackingGains(), rule, 2e-3, _START_TILT, thrust)
    plant = SimulatedPlant(vehicle, model, start=start, start_tilt=_START_TILT, start_thrust=thrust)
    state, rows = plant.measure(), []
    for k in range(round(reference.duration / 2e-3)):
        command = controller(plant.time, state, reference(2e-3 * k))
        state = plant.step(command)
        rows.append((state, command))
    return rows


def _difference(vehicle: Vehicle, S: FloatArray, Q: FloatArray) -> float:
    """Return by how much the flight of the mapped path differs from the mapped flight."""
    image, sign = _images(vehicle, S)
    axial = np.linalg.det(S) * S
    plain = _flight(vehicle, _path(np.eye(3), np.eye(3)), 1.0)
    mapped = _flight(vehicle, _path(Q, Q @ S.T), sign)
    errors = []
    for (one, asked), (other, asked_there) in zip(plain, mapped, strict=True):
        errors += [*(Q @ one.p_WB - other.p_WB), *(Q @ one.R_WB @ S.T - other.R_WB).ravel()]
        errors += [*(Q @ one.v_WB - other.v_WB), *(axial @ one.w_WB_B - other.w_WB_B)]
        errors += [*(sign * asked.thrust - asked_there.thrust[image])]
        errors += [*(asked.tilt - asked_there.tilt)]
    return largest(errors)


@case(_SOURCE)
def half_turn_of_body_and_world() -> Result:
    """Turned by 180° about z, rotors renamed, the whole flight is the turned flight."""
    return Result(value=_difference(omnimorph(), _HALF_TURN, _HALF_TURN), tolerance=1e-9)


@case(_SOURCE)
def roto_reflection_of_body_and_world() -> Result:
    """With Jx = Jy, the quarter turn with a mirror gives the mapped flight, upside down."""
    vehicle = omnimorph().replace(inertia=np.diag([1.13e-2, 1.13e-2, 1.2e-2]))
    mirror = np.diag([1.0, -1.0, 1.0])
    return Result(value=_difference(vehicle, _ROTO_REFLECTION, mirror), tolerance=1e-9)


@case("gravity has no preferred heading")
def turn_of_the_world() -> Result:
    """Any heading will do: the flight from another place and heading is the moved flight."""
    Q, there = rotation_exponential([0.0, 0.0, 2.1]), np.array([5.0, -3.0, 2.0])
    scenario = replace(load_scenario("paper-case-b"), start_tilt=_START_TILT)
    path = _path(np.eye(3), np.eye(3))
    turned = _path(Q, Q)
    moved = SegmentReference(turned.start_p_WB + there, Q, turned.segments)
    one = fly(scenario, plant="perfect", reference=path)
    other = fly(scenario, plant="perfect", reference=moved)
    errors = [
        largest(one.p_WB @ Q.T + there - other.p_WB),
        largest(Q @ one.R_WB - other.R_WB),
        largest(one.v_WB @ Q.T - other.v_WB),
        largest(one.w_WB_B - other.w_WB_B),
        largest(one.thrust_command - other.thrust_command),
        largest(one.tilt_actual - other.tilt_actual),
    ]
    return Result(value=max(errors), tolerance=1e-9)
