"""A test stand: the vehicle is bolted down, and one of its rotors sits on a force-torque sensor.

The experiment on interference, replayed (OmniMorph's rotor 4 is a lower one, below rotor 0)::

    effects = (RotorLag(up=0.020), Interference())
    stand = ThrustStand(vehicle=vehicle, rotor=4, tilt=0.0, effects=effects)
    reading = stand.measure(speed_steps(vehicle, 4), seed=0)
    reading.time, reading.thrust                             # (T,) s, (T,) N
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph import _core
from omnimorph.analysis.scaling import checked_tilt
from omnimorph.arrays import as_numbers
from omnimorph.design.files import as_vehicle
from omnimorph.design.ranges import Range
from omnimorph.design.records import Record, quantity, record_of
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.core import state_row
from omnimorph.protocols import FloatArray
from omnimorph.simulation.core_settings import MOST_STEPS
from omnimorph.simulation.effects import (
    CommandDelay,
    DeadBand,
    Effect,
    Effectiveness,
    Interference,
    ModelMismatch,
    RotorLag,
    SpeedLimits,
)
from omnimorph.simulation.plant import PlantModel, core_motion
from omnimorph.simulation.recording import bytes_of_a_row
from omnimorph.simulation.speed_profile import SpeedProfile
from omnimorph.simulation.whole_number import rotor_index, whole_number
from omnimorph.units import from_SI

_STAND, _PROFILE = "the thrust stand", "the speed profile"
_OF_ROTORS: tuple[type[Effect], ...] = (
    CommandDelay,
    DeadBand,
    Effectiveness,
    Interference,
    ModelMismatch,
    RotorLag,
    SpeedLimits,
)
_NOISE = Range(0.0, 1e9)
_ROUNDING = 1e-9
_BYTES_OF_A_READING = 256  # beside the row of the plant: noise and what is read


@dataclass(frozen=True, kw_only=True)
class SixAxisSensor(Record):
    """A force-torque sensor: what it adds to the load it bears, and how often it is read.

    The noise is white and Gaussian, independent on each axis. Not modelled: offset, drift, range,
    rounding to the resolution, what one axis sees of another.

    Attributes
    ----------
    force_noise : (3,), N
        One standard deviation along x, y and z of B.
    torque_noise : (3,), N m
        One standard deviation about them.
    rate : float, 1/s
        Samples a second, at regular times.

    Raises
    ------
    ScenarioError
        If a deviation is negative, a number not finite, or the rate not positive.

    Notes
    -----
    By default the ATI Mini40 in its calibration SI-20-1, the sensor of the experiment in Aboudorra
    et al. 2024, with z along its own axis: its resolution is 1/200 N in x and y, 1/100 N in z, and
    1/8000 N m. ASSUMED: noise of one resolution, 1 kHz. The paper states neither.
    """

    kind: ClassVar[str] = "six-axis-sensor"
    force_noise: tuple[float, ...] = quantity(
        "N", _NOISE, "three numbers, not negative", length=3, default=(0.005, 0.005, 0.01)
    )
    torque_noise: tuple[float, ...] = quantity(
        "Nm", _NOISE, "three numbers, not negative", length=3, default=(1.25e-4,) * 3
    )
    rate: float = quantity(
        "per_s", Range(0.1, 1e6), "a positive number of samples a second", default=1000.0
    )

    def noise(self, seed: int, samples: int) -> FloatArray:
        """Return the (samples, 6) errors, N and N m; the same for the same seed.

        They come from the counter-based generator of the flights, from counts that none reaches.
        """
        normals = _core.measurement_normals(seed, 0, MOST_STEPS, samples)
        errors: FloatArray = normals[:, :6] * [*self.force_noise, *self.torque_noise]
        return errors


@dataclass(frozen=True, eq=False, kw_only=True)
class StandReading:
    """What the sensor reads, and what it bears.

    Forces and torques are those of the rotor on the sensor, in axes parallel to B at the rotor's
    hub. The sensor is zeroed with all rotors at rest, so weight is not among them.

    Attributes
    ----------
    time : (T,) array, s
        Of the samples, from 0 to the end of the profile.
    speed : (T, n) array, rad/s
        Actual speeds of all rotors.
    axis : (3,) array, in B
        The thrust axis z(α) of the rotor measured.
    force, torque : (T, 3) array, N and N m, in B
        As read, with noise.
    true_force, true_torque : (T, 3) array, N and N m, in B
        Without noise.
    """

    time: FloatArray
    speed: FloatArray
    axis: FloatArray
    force: FloatArray
    torque: FloatArray
    true_force: FloatArray
    true_torque: FloatArray

    def __post_init__(self) -> None:
        for array in vars(self).values():
            array.setflags(write=False)

    @property
    def thrust(self) -> FloatArray:
        """The force as read along the rotor's axis, (T,), N: what the paper plots."""
        along: FloatArray = self.force @ self.axis
        return along

    @property
    def true_thrust(self) -> FloatArray:
        """The same without noise."""
        along: FloatArray = self.true_force @ self.axis
        return along


@dataclass(frozen=True, eq=False, kw_only=True)
class ThrustStand:
    """A vehicle bolted to a structure that does not move, one rotor on a force-torque sensor.

    The rotors are those of the plant (`omnimorph.PlantModel`), under the same effects, stepped once
    a sample. With the actual speeds w, the sensor bears

    - force ``s c_f w|w| (1 − lost) z(α)``, with the share s of `Effectiveness` and what the wakes
      of `Interference` take (`omnimorph.model.interference.thrust_lost`);
    - torque ``−k c_τ w|w| z(α)`` about the hub, which neither of them changes.

    Attributes
    ----------
    vehicle : Vehicle
        As its motor drivers know it: their commands are speeds.
    rotor : int
        The one on the sensor, from 0.
    tilt : float or (m,) array, rad
        At which the rotors are fixed; kept as (m,).
    effects : tuple of Effect
        Imperfections of the rotors: command delay, dead band, effectiveness, interference, model
        mismatch (of the coefficients), rotor lag, speed limits.
    sensor : SixAxisSensor
        See there; its rate is also that of the rotors' steps.
    beyond_limits : bool
        Allow a tilt that the servos cannot reach.

    Raises
    ------
    VehicleError
        If the tilt is no angle for each servo, or beyond a limit.
    ScenarioError
        If there is no such rotor, or an effect is none of the rotors or does not fit the vehicle.

    Examples
    --------
    OmniMorph's lower rotor 4 at 120 Hz alone, then below rotor 0 at 120 Hz: 1.8638e-4 · 120² N, and
    a third less.

    >>> import omnimorph as om
    >>> vehicle, wakes = om.load_vehicle("omnimorph"), om.effects.Interference()
    >>> stand = om.ThrustStand(vehicle=vehicle, rotor=4, tilt=0.0, effects=(wakes,))
    >>> reading = stand.measure(om.speed_steps(vehicle, 4))
    >>> reading.true_thrust[[1, -1]].round(3)
    array([2.684, 1.79 ])

    Notes
    -----
    The experiment is that of Aboudorra et al. 2024, section on mutual interference. Not modelled:
    shaking of the structure, wakes that the structure or the wall send back, the torque of
    speeding a rotor up, and, as in the plant, anything that a rotor's wake does beside its thrust.
    """

    vehicle: Vehicle
    rotor: int
    tilt: ArrayLike
    effects: tuple[Effect, ...] = ()
    sensor: SixAxisSensor = field(default_factory=SixAxisSensor)
    beyond_limits: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "vehicle", as_vehicle(self.vehicle))
        object.__setattr__(self, "rotor", rotor_index(self.vehicle, self.rotor))
        tilt = checked_tilt(self.vehicle, self.tilt, self.beyond_limits).copy()
        tilt.setflags(write=False)
        object.__setattr__(self, "tilt", tilt)
        record_of(_STAND, "sensor", self.sensor, SixAxisSensor)
        self._plant().core_fields(self._held())

    def measure(self, profile: SpeedProfile, seed: int = 0) -> StandReading:
        """Run a profile and return what the sensor reads.

        All rotors rest at t = 0, and the first row is commanded then. A command that falls between
        two samples acts from the second.

        Parameters
        ----------
        profile : SpeedProfile
            Of the n rotors.
        seed : int
            Which noise, 0 … 2⁶⁴ − 1: sample k of seed s has the same on every stand, and no flight
            has it. Take a seed for each run.

        Returns
        -------
        StandReading
            One sample more than ``duration · rate``, which is rounded.

        Raises
        ------
        ScenarioError
            If the profile is one of another number of rotors, of no sample or too many, beyond the
            limits of `SpeedLimits` or too fast to compute with; or the seed is no such integer.
        TooLargeError
            If the reading has more rows than memory holds.
        """
        record_of(_STAND, "profile", profile, SpeedProfile)
        thrust = self._commands(profile)
        seed = whole_number(_STAND, "seed", seed, 64)
        rate = self.sensor.rate
        steps = profile.duration * rate
        if not 0.5 < steps < MOST_STEPS:
            allowed = f"from one sample to {MOST_STEPS} of them, {rate:g} a second"
            raise ScenarioError.at(_PROFILE, "duration", profile.duration, allowed)
        rows = round(steps) + 1
        needed = rows * (bytes_of_a_row(self.vehicle) + _BYTES_OF_A_READING)
        refuse_more_than_memory(
            f"{_PROFILE}: the {rows} rows of the reading",
            needed,
            "measure for less time or fewer times a second",
        )
        first_rows = np.ceil(np.round(profile.time * rate, 6)).astype(int)
        speed, load = self._run(thrust, np.diff(first_rows, append=rows))
        read = load + self.sensor.noise(seed, rows)
        return StandReading(
            time=np.arange(rows) / rate,
            speed=speed,
            axis=allocation_matrix(self.vehicle, self.tilt)[:3, self.rotor],
            force=read[:, :3],
            torque=read[:, 3:],
            true_force=load[:, :3],
            true_torque=load[:, 3:],
        )

    def _run(self, thrust: FloatArray, lengths: NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
        """Return speeds (T, n) and the loads (T, 6) of the hub measured, at rest first.

        Each command is in force for so many rows.
        """
        vehicle, tilt = self.vehicle, as_numbers(self.tilt)
        at_rest = np.zeros(vehicle.n_rotors)
        start = {
            "motion": core_motion(state_row(np.zeros(3), np.eye(3), np.zeros(6))),
            "command": {"thrust": at_rest, "tilt": tilt},
        }
        settings = _core.LoopSettings(self._plant().core_fields(self._held()) | {"start": start})
        plant = _core.new_plant(settings=settings, seed=0, flight=0)
        speeds, loads = [at_rest[np.newaxis]], [np.zeros((1, 6))]
        for command, length in zip(thrust, lengths.tolist(), strict=True):
            plant.send(command, tilt)
            speed, load = plant.run_actuators(length, self.rotor)
            speeds.append(speed)
            loads.append(load)
        speed, load = np.vstack(speeds)[:-1], np.vstack(loads)[:-1]
        with np.errstate(over="ignore"):
            can_be_squared = np.isfinite(load * load).all()  # as whoever fits a curve to it does
        if not can_be_squared:
            largest = f"{float(np.abs(thrust).max()):g} N"
            allowed = "small enough to compute with"
            raise ScenarioError.at(_PROFILE, "largest thrust", largest, allowed)
        return speed, load

    def _held(self) -> Vehicle:
        """Return the vehicle with its servos held at the tilt."""
        return self.vehicle.replace(servo_angle_min=self.tilt, servo_angle_max=self.tilt)

    def _plant(self) -> PlantModel:
        """Return the plant that the rotors are of, stepped once a sample."""
        step = 1.0 / self.sensor.rate
        plant = PlantModel(physics_step=step, control_period=step, effects=self.effects)
        for effect in plant.effects:
            if not isinstance(effect, _OF_ROTORS):
                allowed = f"one of the rotors: {', '.join(kind.kind for kind in _OF_ROTORS)}"
                raise ScenarioError.at(_STAND, "effect", effect.kind, allowed)
        return plant

    def _commands(self, profile: SpeedProfile) -> FloatArray:
        """Return the thrusts, (K, n), N, from which the motor drivers get their speeds."""
        vehicle, speed = self.vehicle, profile.speed
        if speed.shape[1] != vehicle.n_rotors:
            allowed = f"one for each of the {vehicle.n_rotors} rotors of vehicle {vehicle.name}"
            raise ScenarioError.at(_PROFILE, "number of columns of speed", speed.shape[1], allowed)
        for effect in self.effects:
            if isinstance(effect, SpeedLimits):
                _check_limits(speed, *effect.of_rotors(vehicle))
        with np.errstate(over="ignore"):
            thrust: FloatArray = vehicle.thrust_coefficient * speed * np.abs(speed)
        return thrust


def _check_limits(speed: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """Refuse speeds, (K, n), that no rotor reaches."""
    slack = _ROUNDING * np.abs(speed)
    beyond = (speed < low - slack) | (speed > high + slack)
    if beyond.any():
        k, i = np.argwhere(beyond)[0]
        limits = (f"{from_SI(float(limit[i]), 'Hz'):g}" for limit in (low, high))
        allowed = f"from {' to '.join(limits)} Hz, as far as speed-limits lets rotor {i} turn"
        asked = f"{from_SI(float(speed[k, i]), 'Hz'):g} Hz"
        raise ScenarioError.at(_PROFILE, f"speed[{k}][{i}]", asked, allowed)
