"""Forces and torques from outside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from omnimorph.design.ranges import Range
from omnimorph.design.records import quantity
from omnimorph.errors import ScenarioError
from omnimorph.simulation.effects.effect import Effect, PlantBuild

_WRENCH = Range(-1e9, 1e9)
_THREE = "three finite numbers"
_PROFILE = "rows of three finite numbers, one for each time"


@dataclass(frozen=True, kw_only=True)
class ConstantWrench(Effect):
    """A constant force (N, in W) and torque (N m, in B) push at the centre of mass."""

    kind: ClassVar[str] = "constant-wrench"
    stage: ClassVar[str] = "disturbance"
    force: tuple[float, ...] = quantity("N", _WRENCH, _THREE, length=3, default=(0.0, 0.0, 0.0))
    torque: tuple[float, ...] = quantity("Nm", _WRENCH, _THREE, length=3, default=(0.0, 0.0, 0.0))

    def add_to(self, plant: PlantBuild) -> None:
        """Add the wrench to those already there."""
        others = plant.laws.get(self.kind, {"constant": np.zeros(6)})["constant"]
        plant.laws[self.kind] = {"constant": others + np.array([*self.force, *self.torque])}


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
    stage: ClassVar[str] = "disturbance"
    force: tuple[float, ...] = quantity("N", _WRENCH, _THREE, length=3, default=(0.0, 0.0, 0.0))
    torque: tuple[float, ...] = quantity("Nm", _WRENCH, _THREE, length=3, default=(0.0, 0.0, 0.0))
    frequency: float = quantity("Hz", Range(1e-6, 1e6), "a positive number of hertz")
    phase: float = quantity("deg", Range(-1e5, 1e5), "a finite number of degrees", default=0.0)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the swinging wrench."""
        amplitude = np.array([*self.force, *self.torque])
        plant.laws[self.kind] = {
            "amplitude": amplitude,
            "frequency": self.frequency,
            "phase": self.phase,
        }


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
    stage: ClassVar[str] = "disturbance"
    times: tuple[float, ...] = quantity(
        "s", Range(-1e6, 1e6), "finite numbers of seconds, increasing"
    )
    force: tuple[tuple[float, ...], ...] = quantity("N", _WRENCH, _PROFILE)
    torque: tuple[tuple[float, ...], ...] | None = quantity("Nm", _WRENCH, _PROFILE, default=None)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the profile."""
        k = len(self.times)
        if not (np.diff(self.times) > 0).all():
            raise ScenarioError.at(self.kind, "times_s", self.times, "increasing")
        torque = ((0.0, 0.0, 0.0),) * k if self.torque is None else self.torque
        for name, rows in (("force_N", self.force), ("torque_Nm", torque)):
            if len(rows) != k or any(len(row) != 3 for row in rows):
                raise ScenarioError.at(self.kind, name, rows, f"{k} rows of three numbers")
        plant.laws[self.kind] = {"profile": np.column_stack([self.times, self.force, torque])}
