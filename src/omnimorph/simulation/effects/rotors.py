"""Imperfections of the rotors: lag, limits, dead band, lost thrust, wakes, angular momentum."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from omnimorph.design.ranges import Range
from omnimorph.design.records import quantity
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.model.interference import WAKE_MODELS, WakeModel, stacked_pairs
from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects.effect import SIZE, TIME, TIMES, Effect, PlantBuild, numbers_of
from omnimorph.units import from_SI


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
    up: float | None = quantity("ms", TIMES, TIME, default=None)
    down: float | None = quantity("ms", TIMES, TIME, default=None)

    def add_to(self, plant: PlantBuild) -> None:
        """Set both time constants of every rotor."""
        up = down = numbers_of(self, plant, "time_constant_up", "up")
        if self.up is None or self.down is not None:
            down = numbers_of(self, plant, "time_constant_down", "down")
        plant.laws[self.kind] = {"up": up, "down": down}


@dataclass(frozen=True, kw_only=True)
class SpeedLimits(Effect):
    """Rotors turn no faster than ±`largest` (rad/s), or than the vehicle's own limits."""

    kind: ClassVar[str] = "speed-limits"
    largest: float | None = quantity(
        "Hz", Range(1e-3, 1e5), "a positive number of hertz", default=None
    )

    def of_rotors(self, vehicle: Vehicle) -> tuple[FloatArray, FloatArray]:
        """Return the least and the largest speeds, (n,) each, rad/s.

        A uni-directional rotor keeps its lower limit.
        """
        low, high = vehicle.speed_min, vehicle.speed_max
        if self.largest is not None:
            high = np.full(vehicle.n_rotors, self.largest)
            if (high <= low).any():
                allowed = f"above the rotors' least speed, {from_SI(float(low.max()), 'Hz'):g} Hz"
                largest = from_SI(self.largest, "Hz")
                raise ScenarioError.at(self.kind, "largest_Hz", largest, allowed)
            low = np.where(low < 0.0, -high, low)
        return low, high

    def add_to(self, plant: PlantBuild) -> None:
        """Set the limits."""
        low, high = self.of_rotors(plant.vehicle)
        plant.laws[self.kind] = {"speed_min": low, "speed_max": high}


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
    smallest: float | None = quantity("Hz", Range(0.0, 1e5), SIZE, default=None)
    reversal_time: float = quantity("ms", TIMES, TIME, default=0.0)

    def add_to(self, plant: PlantBuild) -> None:
        """Set the band of every rotor."""
        band = numbers_of(self, plant, "dead_band", "smallest")
        fastest = np.maximum(np.abs(plant.vehicle.speed_min), plant.vehicle.speed_max)
        if (band >= fastest).any():
            allowed = f"below the rotors' largest speed, {from_SI(float(fastest.min()), 'Hz'):g} Hz"
            largest = from_SI(float(band.max()), "Hz")
            raise ScenarioError.at(self.kind, "smallest_Hz", largest, allowed)
        plant.laws[self.kind] = {"smallest": band, "reversal_time": self.reversal_time}


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
        "", Range(0.0, 1e3), "a share of the thrust, or one for each rotor, none negative"
    )

    def add_to(self, plant: PlantBuild) -> None:
        """Set the share of every rotor."""
        if np.size(self.share) not in (1, plant.vehicle.n_rotors):
            allowed = f"one number, or one for each of the {plant.vehicle.n_rotors} rotors"
            raise ScenarioError.at(self.kind, "share", self.share, allowed)
        share = np.broadcast_to(np.asarray(self.share, dtype=np.float64), (plant.vehicle.n_rotors,))
        plant.laws[self.kind] = share.copy()


@dataclass(frozen=True, kw_only=True)
class Interference(Effect):
    """Rotors in line lose thrust in one another's wakes; drag torque and power do not change.

    Attributes
    ----------
    model : "published" or "blade-element"
        What a wake costs, see `omnimorph.model.interference.thrust_lost`.
    """

    kind: ClassVar[str] = "interference"
    model: WakeModel = "published"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.model not in WAKE_MODELS:
            allowed = " or ".join(f'"{model}"' for model in WAKE_MODELS)
            raise ScenarioError.at(self.kind, "model", self.model, allowed)

    def add_to(self, plant: PlantBuild) -> None:
        """Switch it on; refused for a vehicle without rotors in line."""
        if not len(stacked_pairs(plant.vehicle)):
            allowed = f"left out, because vehicle {plant.vehicle.name} has no two rotors in line"
            raise ScenarioError.at("the plant", "effect", self.kind, allowed)
        plant.laws[self.kind] = {"model": self.model}


@dataclass(frozen=True, kw_only=True)
class RotorMomentum(Effect):
    """The spinning rotors carry angular momentum, H = Σ I_i k_i w_i z_i in B.

    From d(Jω + H)/dt = τ − ω × (Jω + H) follow the gyroscopic torque −ω × H, the reaction to
    spinning up −Σ I k ẇ z, and that to tilting a spinning rotor −Σ I k w ∂z/∂α α̇.
    """

    kind: ClassVar[str] = "rotor-momentum"

    def add_to(self, plant: PlantBuild) -> None:
        """Switch it on."""
        numbers_of(self, plant, "spin_inertia", without="realistic-1")
        plant.laws[self.kind] = {}
