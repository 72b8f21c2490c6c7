"""Imperfections of the plant: objects one adds to a list.

::

    PlantModel(effects=(RotorLag(up=0.020), Effectiveness(share=0.65)))

Each is a small frozen record in SI; left out, a parameter is the vehicle's own. In files an effect
is a table with its kind: ``{kind = "rotor-lag", up_ms = 20}``. The arithmetic of each is in
``core/include/omnimorph/effects/``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from omnimorph import _core
from omnimorph.design.records import Record, quantity
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import MISSING, ScenarioError
from omnimorph.protocols import FloatArray
from omnimorph.units import from_SI

__all__ = [
    "EFFECTS",
    "CommandDelay",
    "ConstantWrench",
    "DeadBand",
    "Effect",
    "Effectiveness",
    "MeasurementNoise",
    "ModelMismatch",
    "PlantBuild",
    "RotorLag",
    "RotorMomentum",
    "ServoLag",
    "ServoRateLimit",
    "SineWrench",
    "SpeedLimits",
    "WrenchProfile",
]

_TIME = "a number of milliseconds, not negative"
_SIZE = "a number, not negative"
_FACTOR = "a positive factor"
_THREE = "three finite numbers"
_PROFILE = "rows of three finite numbers, one for each time"


class PlantBuild(NamedTuple):
    """What an effect is added to: the core's settings, the true vehicle, and two times in s."""

    settings: _core.PlantSettings
    vehicle: Vehicle
    control_period: float
    step: float


def _own(plant: PlantBuild, kind: str, key: str, values: FloatArray) -> FloatArray:
    """Return the vehicle's own numbers; an effect that would find only zeros is refused."""
    if values.size and not (values > 0.0).any():
        allowed = f"given, because vehicle {plant.vehicle.name} has no such number of its own"
        raise ScenarioError.at(kind, key, MISSING, allowed)
    return values


@dataclass(frozen=True, kw_only=True)
class Effect(Record):
    """Base of all effects: by itself it changes nothing."""

    kind: ClassVar[str] = "none"

    def true_vehicle(self, vehicle: Vehicle) -> Vehicle:
        """Return the vehicle that really flies when the controller believes in `vehicle`."""
        return vehicle

    def add_to(self, plant: PlantBuild) -> None:
        """Add the effect to the core's plant."""


@dataclass(frozen=True, kw_only=True)
class CommandDelay(Effect):
    """A command reaches the actuators `time` (s, a multiple of the physics step) late."""

    kind: ClassVar[str] = "command-delay"
    time: float = quantity("ms", _TIME, at_least=0.0)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the delay in steps."""
        steps = round(self.time / plant.step)
        if abs(steps * plant.step - self.time) > 1e-9 * plant.step + 1e-12 * self.time:
            allowed = f"a multiple of the physics step, {plant.step * 1e3:g} ms"
            raise ScenarioError.at(self.kind, "time_ms", self.time * 1e3, allowed)
        if self.time > 60 * plant.control_period:
            raise ScenarioError.at(
                self.kind, "time_ms", self.time * 1e3, "at most 60 control periods"
            )
        plant.settings.set_delay(steps)


@dataclass(frozen=True, kw_only=True)
class RotorLag(Effect):
    """Rotor speeds follow their commands with a first-order lag.

    Attributes
    ----------
    up, down : float, optional, s
        Time constants towards a larger speed the same way round, and otherwise; `down` is `up`
        if only `up` is given.
    """

    kind: ClassVar[str] = "rotor-lag"
    up: float | None = quantity("ms", _TIME, at_least=0.0, default=None)
    down: float | None = quantity("ms", _TIME, at_least=0.0, default=None)

    def add_to(self, plant: PlantBuild) -> None:
        """Set both time constants of every rotor."""
        vehicle, n = plant.vehicle, plant.vehicle.n_rotors
        if self.up is None:
            up = _own(plant, self.kind, "up_ms", vehicle.time_constant_up)
            down = vehicle.time_constant_down if self.down is None else np.full(n, self.down)
        else:
            up = np.full(n, self.up)
            down = up if self.down is None else np.full(n, self.down)
        plant.settings.add_rotor_lag(up, down)


@dataclass(frozen=True, kw_only=True)
class SpeedLimits(Effect):
    """Rotors turn no faster than ±`largest` (rad/s), or than the vehicle's own limits."""

    kind: ClassVar[str] = "speed-limits"
    largest: float | None = quantity("Hz", "a positive number of hertz", above=0.0, default=None)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the limits; a uni-directional rotor keeps its lower one."""
        low, high = plant.vehicle.speed_min, plant.vehicle.speed_max
        if self.largest is not None:
            high = np.full(plant.vehicle.n_rotors, self.largest)
            if (high <= low).any():
                allowed = f"above the rotors' least speed, {from_SI(float(low.max()), 'Hz'):g} Hz"
                largest = from_SI(self.largest, "Hz")
                raise ScenarioError.at(self.kind, "largest_Hz", largest, allowed)
            low = np.where(low < 0.0, -high, low)
        plant.settings.add_speed_limits(low, high)


@dataclass(frozen=True, kw_only=True)
class DeadBand(Effect):
    """A rotor cannot turn slower than its dead band, and stops before it reverses.

    A command inside gives the nearer of rest and ±`smallest`; a command against the present
    rotation brakes the rotor, holds it at rest for `reversal_time`, then lets it start again.

    Attributes
    ----------
    smallest : float, optional, rad/s
        The vehicle's own by default.
    reversal_time : float, s
        Rest between the two directions; none for a rotor whose band is 0.
    """

    kind: ClassVar[str] = "dead-band"
    smallest: float | None = quantity("Hz", _SIZE, at_least=0.0, default=None)
    reversal_time: float = quantity("ms", _TIME, at_least=0.0, default=0.0)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the band of every rotor."""
        if self.smallest is None:
            band = _own(plant, self.kind, "smallest_Hz", plant.vehicle.dead_band)
        else:
            band = np.full(plant.vehicle.n_rotors, self.smallest)
        fastest = np.maximum(np.abs(plant.vehicle.speed_min), plant.vehicle.speed_max)
        if (band >= fastest).any():
            allowed = f"below the rotors' largest speed, {from_SI(float(fastest.min()), 'Hz'):g} Hz"
            largest = from_SI(float(band.max()), "Hz")
            raise ScenarioError.at(self.kind, "smallest_Hz", largest, allowed)
        plant.settings.add_dead_band(band, self.reversal_time)


@dataclass(frozen=True, kw_only=True)
class Effectiveness(Effect):
    """Rotors give only a share of their thrust (degraded thrust), for the same speed and drag.

    Attributes
    ----------
    share : float or (n,)
        1 is healthy, 0.65 is 35 % lost, 0 gives no thrust at all (but turns, and drags).
    """

    kind: ClassVar[str] = "effectiveness"
    share: float | tuple[float, ...] = quantity(
        "", "a share of the thrust, or one for each rotor, none negative", at_least=0.0
    )

    def add_to(self, plant: PlantBuild) -> None:
        """Set the share of every rotor."""
        if np.size(self.share) not in (1, plant.vehicle.n_rotors):
            allowed = f"one number, or one for each of the {plant.vehicle.n_rotors} rotors"
            raise ScenarioError.at(self.kind, "share", self.share, allowed)
        share = np.broadcast_to(np.asarray(self.share, dtype=np.float64), (plant.vehicle.n_rotors,))
        plant.settings.set_effectiveness(share.copy())


@dataclass(frozen=True, kw_only=True)
class ModelMismatch(Effect):
    """The true vehicle is the controller's times these factors.

    Attributes
    ----------
    mass, inertia, thrust_coefficient, drag_coefficient : float
        True value over the one the controller believes in.
    """

    kind: ClassVar[str] = "model-mismatch"
    mass: float = quantity("", _FACTOR, above=0.0, default=1.0)
    inertia: float = quantity("", _FACTOR, above=0.0, default=1.0)
    thrust_coefficient: float = quantity("", _FACTOR, above=0.0, default=1.0)
    drag_coefficient: float = quantity("", _FACTOR, above=0.0, default=1.0)

    def true_vehicle(self, vehicle: Vehicle) -> Vehicle:
        """Return the vehicle with every factor applied."""
        names = ("mass", "inertia", "thrust_coefficient", "drag_coefficient")
        return vehicle.replace(**{k: getattr(vehicle, k) * getattr(self, k) for k in names})


@dataclass(frozen=True, kw_only=True)
class ServoLag(Effect):
    """Tilt follows its command with a first-order lag of `time_constant` (s; the vehicle's own)."""

    kind: ClassVar[str] = "servo-lag"
    time_constant: float | None = quantity("ms", _TIME, at_least=0.0, default=None)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the time constant of every servo."""
        if self.time_constant is None:
            own = plant.vehicle.servo_time_constant
            tau = _own(plant, self.kind, "time_constant_ms", own)
        else:
            tau = np.full(plant.vehicle.n_servos, self.time_constant)
        plant.settings.add_servo_lag(tau)


@dataclass(frozen=True, kw_only=True)
class ServoRateLimit(Effect):
    """Tilt moves at most at `rate` (rad/s; the vehicle's own)."""

    kind: ClassVar[str] = "servo-rate-limit"
    rate: float | None = quantity("deg_per_s", "a positive number", above=0.0, default=None)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the rate of every servo."""
        own = self.rate is None
        rate = plant.vehicle.servo_rate_max if own else np.full(plant.vehicle.n_servos, self.rate)
        plant.settings.add_servo_rate_limit(rate)


@dataclass(frozen=True, kw_only=True)
class MeasurementNoise(Effect):
    """Gaussian noise on what the controller is told, one draw a control step.

    The noise of step k in flight j with seed s depends on (s, j, k) alone.

    Attributes
    ----------
    position, velocity, attitude, rate : float
        One standard deviation: m, m/s, rad, rad/s, on each axis.
    filtered : bool
        White by default; otherwise through first-order filters at the cut-off frequencies of the
        vehicle's estimator, which is taken to follow the motion itself without lag.
    """

    kind: ClassVar[str] = "measurement-noise"
    position: float = quantity("mm", _SIZE, at_least=0.0, default=0.0)
    velocity: float = quantity("cm_per_s", _SIZE, at_least=0.0, default=0.0)
    attitude: float = quantity("mrad", _SIZE, at_least=0.0, default=0.0)
    rate: float = quantity("mrad_per_s", _SIZE, at_least=0.0, default=0.0)
    filtered: bool = False

    @property
    def deviation(self) -> FloatArray:
        """The four standard deviations as (4,) numbers."""
        return np.array([self.position, self.velocity, self.attitude, self.rate])

    def add_to(self, plant: PlantBuild) -> None:
        """Set deviations and filters."""
        cutoff = np.zeros(4)
        if self.filtered:
            cutoff = _own(plant, self.kind, "[filter] of the vehicle", plant.vehicle.filter_cutoff)
        plant.settings.add_measurement_noise(self.deviation, cutoff, plant.control_period)


@dataclass(frozen=True, kw_only=True)
class ConstantWrench(Effect):
    """A constant force (N, in W) and torque (N m, in B) push at the centre of mass."""

    kind: ClassVar[str] = "constant-wrench"
    force: tuple[float, ...] = quantity("N", _THREE, length=3, default=(0.0, 0.0, 0.0))
    torque: tuple[float, ...] = quantity("Nm", _THREE, length=3, default=(0.0, 0.0, 0.0))

    def add_to(self, plant: PlantBuild) -> None:
        """Add the wrench to those already there."""
        plant.settings.add_constant_wrench(np.array([*self.force, *self.torque]))


@dataclass(frozen=True, kw_only=True)
class SineWrench(Effect):
    """A force and torque that swing: amplitude × sin(frequency t + phase).

    Attributes
    ----------
    force, torque : (3,), N in W and N m in B
        Amplitudes.
    frequency : float, rad/s
        Angular frequency (in files in Hz).
    phase : float, rad
        At t = 0.
    """

    kind: ClassVar[str] = "sine-wrench"
    force: tuple[float, ...] = quantity("N", _THREE, length=3, default=(0.0, 0.0, 0.0))
    torque: tuple[float, ...] = quantity("Nm", _THREE, length=3, default=(0.0, 0.0, 0.0))
    frequency: float = quantity("Hz", "a positive number of hertz", above=0.0)
    phase: float = quantity("deg", "a finite number of degrees", default=0.0)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the swinging wrench."""
        amplitude = np.array([*self.force, *self.torque])
        plant.settings.set_sine_wrench(amplitude, self.frequency, self.phase)


@dataclass(frozen=True, kw_only=True)
class WrenchProfile(Effect):
    """A force and torque given over time, linear between the points, held at both ends.

    Attributes
    ----------
    times : (k,), s
        Increasing.
    force, torque : (k, 3), N in W and N m in B
        At each time; no torque if it is left out.
    """

    kind: ClassVar[str] = "wrench-profile"
    times: tuple[float, ...] = quantity("s", "finite numbers of seconds, increasing")
    force: tuple[tuple[float, ...], ...] = quantity("N", _PROFILE)
    torque: tuple[tuple[float, ...], ...] | None = quantity("Nm", _PROFILE, default=None)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the profile."""
        k = len(self.times)
        if not (np.diff(self.times) > 0).all():
            raise ScenarioError.at(self.kind, "times_s", self.times, "increasing")
        torque = ((0.0, 0.0, 0.0),) * k if self.torque is None else self.torque
        for name, rows in (("force_N", self.force), ("torque_Nm", torque)):
            if len(rows) != k or any(len(row) != 3 for row in rows):
                raise ScenarioError.at(self.kind, name, rows, f"{k} rows of three numbers")
        plant.settings.set_wrench_profile(np.array(self.times), np.hstack([self.force, torque]))


@dataclass(frozen=True, kw_only=True)
class RotorMomentum(Effect):
    """The spinning rotors carry angular momentum, H = Σ I_i k_i w_i z_i in B.

    From d(Jω + H)/dt = τ − ω × (Jω + H) follow the gyroscopic torque −ω × H, the reaction to
    spinning up −Σ I k ẇ z, and that to tilting a spinning rotor −Σ I k w ∂z/∂α α̇.
    """

    kind: ClassVar[str] = "rotor-momentum"

    def add_to(self, plant: PlantBuild) -> None:
        """Switch it on."""
        _own(plant, self.kind, "spin_inertia_kg_m2 of the vehicle", plant.vehicle.spin_inertia)
        plant.settings.add_rotor_momentum()


EFFECTS: tuple[type[Effect], ...] = (
    CommandDelay,
    RotorLag,
    SpeedLimits,
    DeadBand,
    Effectiveness,
    ModelMismatch,
    ServoLag,
    ServoRateLimit,
    MeasurementNoise,
    ConstantWrench,
    SineWrench,
    WrenchProfile,
    RotorMomentum,
)
"""Every effect that a file can name."""
