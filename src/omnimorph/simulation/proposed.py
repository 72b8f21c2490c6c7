"""The controller that is proposed for a scenario's vehicle, with single values of one's own.

Overrides are a mapping from names of `TrackingGains` to values in SI; ``allocator`` is a mapping
likewise, whose ``kind`` may be stated, or a whole rule in place of the proposed one::

    {"position": 40.0, "allocator": {"W1": 1e-12}}
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from omnimorph.control.allocators import AllocationRule
from omnimorph.control.gains import propose_controller
from omnimorph.control.tracking import TrackingGains
from omnimorph.design.records import Record, declared
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects import CommandDelay
from omnimorph.simulation.plant_model import PlantModel

Controller = tuple[TrackingGains, AllocationRule]


def proposed_controller(
    vehicle: Vehicle, plant: PlantModel, start_tilt: float | FloatArray
) -> Controller:
    """Return what is proposed for a vehicle at a plant's control period and command delay."""
    delay = sum(effect.time for effect in plant.effects if isinstance(effect, CommandDelay))
    proposal = propose_controller(vehicle, plant.control_period, delay, start_tilt)
    return proposal.gains, proposal.allocator


def overridden(place: str, proposed: Controller, overrides: object) -> Controller:
    """Return gains and rule with overrides in place of what was proposed.

    Raises
    ------
    ScenarioError
        If there is no such value; `place` says in which scenario.
    """
    if not isinstance(overrides, Mapping):
        allowed = "a mapping from names of gains, or allocator, to values"
        raise ScenarioError.at(place, "overrides", overrides, allowed)
    gains, allocator = proposed
    rule = overrides.get("allocator", {})
    gains = _with(
        place, "controller", gains, {k: overrides[k] for k in overrides if k != "allocator"}
    )
    if isinstance(rule, AllocationRule):
        return gains, rule
    if not isinstance(rule, Mapping):
        allowed = "an allocation rule, or a mapping from names of weights to values"
        raise ScenarioError.at(place, "controller.allocator", rule, allowed)
    kind = rule.get("kind", allocator.kind)
    if kind != allocator.kind:
        allowed = f"{allocator.kind}, which is proposed, or given with all its weights"
        raise ScenarioError.at(place, "controller.allocator.kind", kind, allowed)
    weights = {name: value for name, value in rule.items() if name != "kind"}
    return gains, _with(place, "controller.allocator", allocator, weights)


def _with(place: str, where: str, record: Any, values: Mapping[str, Any]) -> Any:
    """Return a record with other values; refuse names that it does not have."""
    known = declared(type(record))
    for name, value in values.items():
        if name not in known:
            allowed = f"left out, as {record.kind} has only {', '.join(known)}"
            raise ScenarioError.at(place, f"{where}.{name}", value, allowed)
    return replace(record, **values)


def overrides_as_file(gains: TrackingGains, allocator: Record, overrides: Mapping[str, Any]) -> Any:
    """Return overrides as the table ``[controller]`` would hold them."""
    rule = overrides.get("allocator", {})
    held = _given(gains, overrides)
    if isinstance(rule, Record):
        held["allocator"] = rule.as_file()
    elif rule:
        kind = {"kind": rule["kind"]} if "kind" in rule else {}
        held["allocator"] = kind | _given(allocator, rule)
    return held


def _given(record: Record, names: Mapping[str, Any]) -> dict[str, Any]:
    whole = record.as_file()
    keys = [field.key for name, field in declared(type(record)).items() if name in names]
    return {key: whole[key] for key in keys}
