"""What the flights with kept values are made of: vehicles, controllers, references; flying them.

All of it is plain arithmetic on given numbers, without a library for linear algebra or splines,
whose last bits depend on its version and on the processor.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from tests.physics.golden_values import Trace, trace_of

import omnimorph as om
from omnimorph import effects
from omnimorph.protocols import FloatArray
from omnimorph.reference import Segment, SegmentReference

FOURTEEN_ROTORS = Path(__file__).with_name("fourteen_rotors.toml")
CONTROLLERS: dict[str, dict[str, Any]] = tomllib.loads(
    Path(__file__).with_name("golden_controllers.toml").read_text(encoding="utf-8")
)
CATALOGUE = tuple(CONTROLLERS)
RULES = {rule.kind: rule for rule in (om.ThreeCandidates, om.JointTilt, om.FixedTilt)}
GAINS = ("position", "velocity", "attitude", "rate")
Flight = Callable[[], list[Trace]]
"""Flies, and returns a trace for each vehicle that flew."""
Named = Iterator[tuple[str, Flight]]

ROWS_KEPT = (0, 1, 2, 7, 8, 16)
"""Of a batch: making a run takes longer than flying it."""

# --- plants -------------------------------------------------------------------------------------

NOISE = effects.MeasurementNoise(position=1e-3, velocity=1e-2, attitude=3e-3, rate=1e-2)
REALISTIC = (
    effects.RotorLag(),
    effects.SpeedLimits(),
    effects.ServoRateLimit(),
    NOISE,
    effects.RotorMomentum(),
)
RUNGE_KUTTA = "runge-kutta-4"


def plant(*worn: effects.Effect, period: float = 4e-3, **changes: Any) -> om.PlantModel:
    """Return a plant with these effects, and control at 250 Hz."""
    return om.PlantModel(effects=worn, control_period=period, **changes)


# --- controllers --------------------------------------------------------------------------------


def exactly(stored: str | list[str]) -> Any:
    """Return a stored hexadecimal number, or a tuple of them."""
    if isinstance(stored, str):
        return float.fromhex(stored)
    return tuple(float.fromhex(number) for number in stored)


def controller_of(vehicle: str) -> dict[str, Any]:
    """Return the gains and the allocator that are stored for a vehicle of the catalogue."""
    stored = CONTROLLERS[vehicle]
    weights = {name: exactly(value) for name, value in stored.items() if name.startswith("W")}
    return {
        "gains": om.TrackingGains(**{name: exactly(stored[name]) for name in GAINS}),
        "allocator": RULES[stored["allocator"]](**weights),
    }


STIFF = om.TrackingGains()
WEIGHTS: dict[str, Any] = {
    "W1": 2.0**-27,
    "W2_position": (32768.0, 32768.0, 32768.0),
    "W2_attitude": (8.0, 8.0, 16.0),
    "W3": 2.0**-27,
}

# --- references ---------------------------------------------------------------------------------

ABOVE_GROUND = (0.0, 0.0, 1.25)
MOVE = Segment(0.125, (0.015625, -0.0078125, 0.03125))
TURN = Segment(0.125, (0.0078125, 0.0, 0.0), (0.6, 0.0, 0.8), 0.25)
MOVE_AND_TURN = SegmentReference(ABOVE_GROUND, np.eye(3), [MOVE, TURN])
QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
FROM_A_QUARTER_TURN = SegmentReference(ABOVE_GROUND, QUARTER_TURN, [TURN, MOVE])


class Screw:
    """A reference in Python: p = p0 + c t³ + d t², and a turn by 2 atan(q0 + 4 t²) about an axis.

    Parameters
    ----------
    start : float
        q0: where the turn begins.
    """

    duration = 0.25

    def __init__(self, start: float = 0.0) -> None:
        self.start = start

    def __call__(self, time: float) -> om.Desired:
        """Return the desired motion; with q the tangent, R = I + 2 (q [a]× + q² [a]×²) / (1+q²)."""
        t = time
        q, dq, ddq = self.start + 4.0 * t * t, 8.0 * t, 8.0
        scale = 1.0 + q * q
        a, c, d = np.array([[0.6, 0.0, 0.8], [2.0, -1.0, 0.5], [0.25, 0.5, 1.0]])
        cross = np.array([[0.0, -0.8, 0.0], [0.8, 0.0, -0.6], [0.0, 0.6, 0.0]])
        cross_twice = np.array([[-0.64, 0.0, 0.48], [0.0, -1.0, 0.0], [0.48, 0.0, -0.36]])
        return om.Desired(
            p_WB=np.array(ABOVE_GROUND) + (c * t + d) * (t * t),
            R_WB=np.eye(3) + (2.0 * q / scale) * (cross + q * cross_twice),
            v_WB=(3.0 * c * t + 2.0 * d) * t,
            w_WB_B=(2.0 * dq / scale) * a,
            a_WB=6.0 * c * t + 2.0 * d,
            dw_WB_B=(2.0 * (ddq * scale - 2.0 * q * dq * dq) / (scale * scale)) * a,
        )


class SampledScrew(Screw):
    """The same, asked for all its rows at once."""

    def sample(self, times: FloatArray) -> FloatArray:
        """Return a row of 24 numbers for each time."""
        points = [self(time) for time in times.tolist()]
        return np.array([np.concatenate([part.reshape(-1) for part in one]) for one in points])


# --- vehicles -----------------------------------------------------------------------------------

vehicle_of = cache(om.load_vehicle)

_DIRECTIONS: tuple[tuple[float, float], ...] = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))
_DIRECTIONS += ((0.8, 0.6), (-0.6, 0.8), (-0.8, -0.6), (0.6, -0.8))
_DIRECTIONS += ((0.6, 0.8), (-0.8, 0.6), (-0.6, -0.8), (0.8, -0.6))


@cache
def ring(n: int, servos: bool = False) -> om.Vehicle:
    """Return a vehicle of n upright rotors, perhaps each with a servo that tilts it about its arm.

    The first twelve are on arms in one plane, the others above them.
    """
    arm = np.array([(*_DIRECTIONS[i % 12], 0.0) for i in range(n)])
    layer = np.array([(0.0, 0.0, float(i // 12)) for i in range(n)])
    m = n if servos else 0
    numbers: dict[str, float] = {
        "thrust_coefficient": 2.0**-17,
        "drag_coefficient": 2.0**-23,
        "speed_min": 0.0,
        "speed_max": 1024.0,
        "dead_band": 0.0,
        "time_constant_up": 0.03125,
        "time_constant_down": 0.0625,
        "spin_inertia": 2.0**-15,
        "servo_angle_min": -1.5,
        "servo_angle_max": 1.5,
        "servo_rate_max": 4.0,
        "servo_time_constant": 0.0,
    }
    of_each: dict[str, Any] = {
        name: np.full(m if name.startswith("servo") else n, number)
        for name, number in numbers.items()
    }
    return om.Vehicle(
        name=f"ring-{n}",
        title="Rotors on arms whose numbers are short",
        mass=0.25 * n,
        inertia=np.diag([0.03125, 0.03125, 0.0625]) * n,
        rotor_position=0.5 * arm + 0.25 * layer,
        rotor_axis=np.tile([0.0, 0.0, 1.0], (n, 1)),
        hinge_axis=arm if servos else np.zeros((n, 3)),
        rotor_servo=np.arange(n) if servos else np.full(n, -1),
        rotor_spin=np.where(np.arange(n) % 2 == 0, 1.0, -1.0),
        servo_name=tuple(f"arm{i}" for i in range(m)),
        filter_cutoff=np.zeros(4),
        questioned=False,
        **of_each,
    )


# --- parts in Python ----------------------------------------------------------------------------


def lift_alone(time: float, state: om.State, desired: om.Desired) -> om.Command:
    """A controller: the same thrust for all eight rotors, by height, and a tilt that grows."""
    height, climb = float(desired.p_WB[2] - state.p_WB[2]), float(state.v_WB[2])
    return om.Command(np.full(8, 1.625 + 2.0 * height - 0.5 * climb), np.array([0.5 * time]))


def spread_out(acceleration: FloatArray, state: om.State, previous: om.Command) -> om.Command:
    """An allocator: lift and yaw on all eight rotors, half of it from the command before."""
    lift, yaw = float(acceleration[2]), float(acceleration[5])
    sign = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    wanted = 0.1640625 * (9.8125 + lift) + (0.0625 * yaw) * sign
    return om.Command(0.5 * previous.thrust + 0.5 * wanted, 0.75 * previous.tilt)


def spring_from_outside(time: float, state: om.State) -> FloatArray:
    """A disturbance: a spring to the start, a swirl and a push that grows with time."""
    x, y, z = state.p_WB.tolist()
    w = float(state.w_WB_B[2])
    return np.array([-2.0 * x, -2.0 * y + time, 0.5 * (1.25 - z), 0.125, 0.0625 * x, -0.25 * w])


class FailingLater:
    """A controller that gives what is no number from 0.1 s on."""

    def __init__(self, number: float) -> None:
        self.number = number

    def __call__(self, time: float, state: om.State, desired: om.Desired) -> om.Command:
        """Return the command of `lift_alone`, one thrust of it replaced in the end."""
        command = lift_alone(time, state, desired)
        if time >= 0.1:
            command.thrust[3] = self.number
        return command


# --- scenarios ----------------------------------------------------------------------------------


def scenario(vehicle: str | Path | om.Vehicle = "omnimorph", **changes: Any) -> om.Scenario:
    """Return a scenario of a quarter of a second; the paper's rule if nothing else is given."""
    parts: dict[str, Any] = {
        "name": "golden",
        "vehicle": vehicle if isinstance(vehicle, om.Vehicle) else vehicle_of(vehicle),
        "plant": plant(*REALISTIC),
        "gains": STIFF,
        "allocator": om.ThreeCandidates(**WEIGHTS),
        "reference": MOVE_AND_TURN,
    }
    return om.Scenario(**parts | changes)


# --- flying -------------------------------------------------------------------------------------


def alone(what: om.Scenario, **with_parts: Any) -> list[Trace]:
    """Fly once, on a seed of its own."""
    return [trace_of(om.fly(what, seed=7, flight=3, **with_parts))]


def many(what: om.Scenario, precision: Any = "float64", **vary: Any) -> list[Trace]:
    """Fly more vehicles than the lanes of the widest register, and no multiple of them."""
    n = 9 if precision == "float64" else 17
    keep = [11 + row for row in ROWS_KEPT if row < n]
    flights = om.fly_many(
        what, n, seed=7, first=11, keep=keep, precision=precision, vary=vary, threads=2
    )
    return [trace_of(run) for run in flights.runs.values()]


def both(name: str, what: om.Scenario, **vary: Any) -> Named:
    """Yield a batch in each precision."""
    yield f"{name}, many", partial(many, what, **vary)
    yield f"{name}, many in float32", partial(many, what, "float32", **vary)
