"""What every effect is: a frozen record that adds itself to the core's plant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from omnimorph.design.keys import FILE_KEYS
from omnimorph.design.ranges import Range
from omnimorph.design.records import Record, declared
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.protocols import FloatArray

# What a message says is allowed.
TIME = "a number of milliseconds, not negative"
SIZE = "a number, not negative"
FACTOR = "a positive factor"

TIMES = Range(0.0, 1e6)  # ms
FACTORS = Range(1e-6, 1e6)


class PlantBuild(NamedTuple):
    """What an effect is added to."""

    laws: dict[str, Any]  # imperfections of the core's plant by their kind, each with its fields
    sensors: dict[str, Any]  # the same of its sensors, and the estimator, see `set_estimator`
    vehicle: Vehicle  # the true one
    control_period: float  # s, of the plant
    step: float  # s

    def set_estimator(self, kind: str, name: str, fields: dict[str, Any]) -> None:
        """Choose the core's estimator for an effect; refused if another effect has chosen one."""
        if "estimator" in self.sensors:
            raise ScenarioError.at("plant", "effect", kind, "the only one that sets the estimator")
        self.sensors["estimator"] = (name, fields)


def numbers_of(
    effect: Effect, plant: PlantBuild, field: str, name: str = "", without: str = ""
) -> FloatArray:
    """Return an effect's own number `name` for each, if it has one, else the vehicle's of a field.

    Raises
    ------
    ScenarioError
        If all of the vehicle's are zero, so that the effect would do nothing: it names a plant of
        the catalogue `without` it, if there is one.
    """
    values: FloatArray = getattr(plant.vehicle, field)
    own = getattr(effect, name) if name else None
    if own is not None:
        return np.full(len(values), own)
    if values.size and not (values > 0.0).any():
        kind, key = effect.kind, declared(type(effect))[name].key if name else ""
        allowed = f"positive, because the plant's effect {kind} takes it from the vehicle"
        allowed += f"; or give the effect {key} of its own" if key else ""
        allowed += f"; or fly in the plant {without}, which lacks that effect" if without else ""
        place = f"vehicle {plant.vehicle.name}"
        raise ScenarioError.at(place, FILE_KEYS[field], 0, allowed)
    return values


@dataclass(frozen=True, kw_only=True)
class Effect(Record):
    """Base of all effects: by itself it changes nothing."""

    kind: ClassVar[str] = "none"
    stage: ClassVar[str] = "plant"
    """Where in the loop it acts: ``plant``, ``sensors``, ``estimator`` or ``disturbance``."""

    def true_vehicle(self, vehicle: Vehicle) -> Vehicle:
        """Return the vehicle that really flies when the controller believes in `vehicle`."""
        return vehicle

    def add_to(self, plant: PlantBuild) -> None:
        """Add the effect to the core's plant."""
