"""Imperfections of the servos: lag and rate limit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from omnimorph.design.ranges import Range
from omnimorph.design.records import quantity
from omnimorph.simulation.effects.effect import TIME, TIMES, Effect, PlantBuild, numbers_of


@dataclass(frozen=True, kw_only=True)
class ServoLag(Effect):
    """Tilt follows its command with a first-order lag of `time_constant` (s; the vehicle's own)."""

    kind: ClassVar[str] = "servo-lag"
    time_constant: float | None = quantity("ms", TIMES, TIME, default=None)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the time constant of every servo."""
        tau = numbers_of(self, plant, "servo_time_constant", "time_constant")
        plant.laws[self.kind] = {"time_constant": tau}


@dataclass(frozen=True, kw_only=True)
class ServoRateLimit(Effect):
    """Tilt moves at most at `rate` (rad/s; the vehicle's own)."""

    kind: ClassVar[str] = "servo-rate-limit"
    rate: float | None = quantity("deg_per_s", Range(1e-3, 1e6), "a positive number", default=None)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the rate of every servo."""
        plant.laws[self.kind] = {"rate": numbers_of(self, plant, "servo_rate_max", "rate")}
