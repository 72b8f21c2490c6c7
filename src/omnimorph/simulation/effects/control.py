"""What the controller does not know: noise, delay, and what the vehicle is really like."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from omnimorph.design.ranges import Range
from omnimorph.design.records import quantity
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects.effect import (
    FACTOR,
    FACTORS,
    SIZE,
    TIME,
    TIMES,
    Effect,
    PlantBuild,
    numbers_of,
)

_NOISE = Range(0.0, 1e9)


@dataclass(frozen=True, kw_only=True)
class CommandDelay(Effect):
    """A command reaches the actuators `time` (s, a multiple of the physics step) late."""

    kind: ClassVar[str] = "command-delay"
    time: float = quantity("ms", TIMES, TIME)

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
        plant.laws[self.kind] = {"steps": steps}


@dataclass(frozen=True, kw_only=True)
class MeasurementNoise(Effect):
    """Gaussian noise on what the controller measures, one draw a control step.

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
    stage: ClassVar[str] = "sensors"
    position: float = quantity("mm", _NOISE, SIZE, default=0.0)
    velocity: float = quantity("cm_per_s", _NOISE, SIZE, default=0.0)
    attitude: float = quantity("mrad", _NOISE, SIZE, default=0.0)
    rate: float = quantity("mrad_per_s", _NOISE, SIZE, default=0.0)
    filtered: bool = False

    @property
    def deviation(self) -> FloatArray:
        """The four standard deviations as (4,) numbers."""
        return np.array([self.position, self.velocity, self.attitude, self.rate])

    def add_to(self, plant: PlantBuild) -> None:
        """Set deviations and filters."""
        plant.sensors[self.kind] = {"deviation": self.deviation}
        if self.filtered:
            cutoff = numbers_of(self, plant, "filter_cutoff")
            plant.set_estimator(self.kind, "low-pass", {"cutoff": cutoff})


@dataclass(frozen=True, kw_only=True)
class ModelMismatch(Effect):
    """The true vehicle is the controller's times these factors.

    Attributes
    ----------
    mass, inertia, thrust_coefficient, drag_coefficient : float
        True value over the one the controller believes in.
    """

    kind: ClassVar[str] = "model-mismatch"
    mass: float = quantity("", FACTORS, FACTOR, default=1.0)
    inertia: float = quantity("", FACTORS, FACTOR, default=1.0)
    thrust_coefficient: float = quantity("", FACTORS, FACTOR, default=1.0)
    drag_coefficient: float = quantity("", FACTORS, FACTOR, default=1.0)

    def true_vehicle(self, vehicle: Vehicle) -> Vehicle:
        """Return the vehicle with every factor applied."""
        names = ("mass", "inertia", "thrust_coefficient", "drag_coefficient")
        scaled = {name: getattr(vehicle, name) * getattr(self, name) for name in names}
        mechanism = self.mass * vehicle.tilt_mechanism_mass  # a part of the mass
        return vehicle.replace(**scaled, tilt_mechanism_mass=mechanism)
