"""What may stand in for a part of a scenario: a name, a file, a record, or an object of one's own.

=============  =======================================  =========================================
part           name or file                             record
=============  =======================================  =========================================
plant          a plant                                  `PlantModel`
sensors        a plant, whose sensors are taken         sensors of `omnimorph.effects`
estimator      a plant, whose estimator is taken        an estimator of `omnimorph.effects`
controller     a scenario, whose controller is taken    `TrackingGains`
allocator      a kind of rule, with the scenario's      `AllocationRule`
               weights, or a scenario, whose rule is
               taken
reference      a scenario, whose reference is taken,    `SegmentReference` and the like
               or a CSV file of poses
disturbance    a plant, whose forces act as well        forces of `omnimorph.effects`
=============  =======================================  =========================================

A `Scenario` may stand for its controller, its allocator or its reference. A text with a colon,
``my_module:MyController``, names an object of one's own, and anything else is one: see
`omnimorph.protocols`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import MISSING, fields, replace
from typing import Any

from omnimorph.control.allocators import AllocationRule
from omnimorph.control.rules import RULES
from omnimorph.control.tracking import TrackingGains
from omnimorph.errors import ScenarioError
from omnimorph.protocols import (
    Allocator,
    Controller,
    Disturbance,
    Estimator,
    Plant,
    Reference,
    Sensors,
)
from omnimorph.reference.samples import as_reference
from omnimorph.simulation.effects import Effect
from omnimorph.simulation.own_parts import NOT_BOTH, OwnParts, PythonObject
from omnimorph.simulation.plant import PlantModel, as_plant
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import ScenarioLike, as_scenario, list_scenarios

Path_ = str | os.PathLike[str]
Effects = Effect | Sequence[Effect] | PlantModel
AnyPlant = Path_ | PlantModel | PythonObject | Plant
SensorsLike = Path_ | Effects | PythonObject | Sensors
EstimatorLike = Path_ | Effects | PythonObject | Estimator
ControllerLike = Path_ | TrackingGains | Scenario | PythonObject | Controller
AllocatorLike = Path_ | AllocationRule | Scenario | PythonObject | Allocator
ReferenceLike = Path_ | Scenario | PythonObject | Reference
DisturbanceLike = Path_ | Effects | PythonObject | Disturbance


def with_parts(
    scenario: ScenarioLike,
    *,
    plant: AnyPlant | None = None,
    sensors: SensorsLike | None = None,
    estimator: EstimatorLike | None = None,
    controller: ControllerLike | None = None,
    allocator: AllocatorLike | None = None,
    reference: ReferenceLike | None = None,
    disturbance: DisturbanceLike | None = None,
    allow_code: bool = False,
) -> Scenario:
    """Return a scenario with some of its parts replaced; what is None stays.

    Parameters
    ----------
    scenario : Scenario, str or path
        Or its name or file.
    plant, sensors, estimator, controller, allocator, reference, disturbance : optional
        As `fly` takes them.
    allow_code : bool
        Whether code may run that a file or a text names.

    Raises
    ------
    ScenarioError
        If a part is none of what it may be, or does not fit; if a file or a text names code and
        `allow_code` is not True.

    Examples
    --------
    >>> import omnimorph as om
    >>> changed = om.with_parts("hover", plant="perfect", allocator="fixed-tilt")
    >>> changed.plant.name, changed.allocator.kind
    ('perfect', 'fixed-tilt')
    """
    scenario = as_scenario(scenario, allow_code=allow_code)
    own = scenario.own
    if plant is not None:
        part = _resolved("plant", plant, allow_code)
        is_own = _is_own(part, PlantModel)
        own = replace(own, plant=part if is_own else None)
        if not is_own:
            scenario = replace(scenario, plant=as_plant(part))
    for stage, effects in (("sensors", sensors), ("estimator", estimator)):
        if effects is not None:
            part = _resolved(stage, effects, allow_code)
            is_own = _is_own(part, Effect, PlantModel, Sequence)
            own = replace(own, **{stage: part if is_own else None})
            if not is_own:
                scenario = _with_effects(scenario, stage, part, in_place_of=stage)
    if controller is not None:
        part = _resolved("controller", controller, allow_code)
        scenario, theirs = _with_controller(scenario, part, allow_code)
        own = replace(own, controller=theirs.controller, allocator=theirs.allocator)
    if allocator is not None:
        part = _resolved("allocator", allocator, allow_code)
        if controller is None:
            own = replace(own, controller=None)
        elif own.controller is not None:
            raise ScenarioError(NOT_BOTH)
        if not _is_own(part, AllocationRule, Scenario):
            part = _rule(scenario, part, allow_code)
        is_own = not isinstance(part, AllocationRule)
        own = replace(own, allocator=part if is_own else None)
        if not is_own:
            scenario = replace(scenario, allocator=part, proposed=False, overrides={})
    if disturbance is not None:
        part = _resolved("disturbance", disturbance, allow_code)
        if _is_own(part, Effect, PlantModel, Sequence):
            own = replace(own, disturbance=part)
        elif own.plant is not None:
            allowed = "an object that can be called, as a plant of one's own has forces of its own"
            raise ScenarioError.at("fly", "disturbance", part, allowed)
        else:
            scenario = _with_effects(scenario, "disturbance", part, in_place_of=None)
    if reference is not None:
        part = _resolved("reference", reference, allow_code)
        scenario = replace(scenario, reference=_reference(part, allow_code))
    return replace(scenario, own=own)


def names_an_object(part: object) -> bool:
    """Return whether a text names an object of one's own, ``my_module:MyController``."""
    return isinstance(part, str) and ":" in part and not os.path.exists(part)


def _resolved(name: str, part: Any, allow_code: bool) -> Any:
    """Return what was given for a part; a text that names an object of one's own becomes one."""
    if names_an_object(part):
        part = PythonObject(part, folder=os.getcwd())
    return part.checked("fly", name, allow_code) if isinstance(part, PythonObject) else part


def _is_own(part: object, *records: type) -> bool:
    """Return whether a part is an object of one's own: no name, no file and none of the records."""
    return isinstance(part, PythonObject) or not isinstance(part, (str, os.PathLike, *records))


def _with_effects(scenario: Scenario, stage: str, part: Any, in_place_of: str | None) -> Scenario:
    """Return a scenario whose plant has these effects of a stage, in place of others or beside."""
    if isinstance(part, Effect):
        part = (part,)
    if isinstance(part, Sequence) and not isinstance(part, str):
        chosen = tuple(part)
        for effect in chosen:
            if not isinstance(effect, Effect) or effect.stage != stage:
                raise ScenarioError.at("fly", stage, effect, f"an effect for the {stage}")
    else:
        chosen = tuple(effect for effect in as_plant(part).effects if effect.stage == stage)
    kept = tuple(effect for effect in scenario.plant.effects if effect.stage != in_place_of)
    return replace(scenario, plant=replace(scenario.plant, effects=kept + chosen))


def _with_controller(scenario: Scenario, part: Any, allow_code: bool) -> tuple[Scenario, OwnParts]:
    """Return a scenario with these gains, or with all of another's; and what of it is one's own."""
    if _is_own(part, TrackingGains, Scenario):
        return scenario, OwnParts(controller=part)
    if isinstance(part, TrackingGains):
        gains = replace(scenario, gains=part, proposed=False, overrides={})
        return gains, OwnParts(allocator=scenario.own.allocator)
    other = as_scenario(part, allow_code=allow_code)
    whole = replace(
        scenario,
        gains=other.gains,
        allocator=other.allocator,
        attitude_gives_way=other.attitude_gives_way,
        proposed=False,
        overrides={},
        own=other.own,
    )
    return whole, other.own


def _rule(scenario: Scenario, part: Any, allow_code: bool) -> Any:
    """Return a rule: as it is, by its kind with the scenario's weights, or another scenario's."""
    if isinstance(part, AllocationRule):
        return part
    rules = {rule.kind: rule for rule in RULES}
    rule = rules.get(part) if isinstance(part, str) else None
    if rule is None:
        if isinstance(part, str) and part not in list_scenarios() and not os.path.exists(part):
            allowed = f"{', '.join(rules)}, or the name or file of a scenario"
            raise ScenarioError.at("fly", "allocator", part, allowed)
        other = as_scenario(part, allow_code=allow_code)
        if other.own.allocator is None:
            other.check_rule()
        return other.own.allocator or other.allocator
    scenario.check_rule()
    old = scenario.allocator
    names = {one.name for one in fields(rule)} & {one.name for one in fields(old)}
    missing = [one.name for one in fields(rule) if one.default is MISSING and one.name not in names]
    if missing:
        allowed = f"a rule that needs no more than {old.kind} has, or a record with its numbers"
        raise ScenarioError.at("fly", "allocator", part, f"{allowed} ({', '.join(missing)})")
    return rule(**{name: getattr(old, name) for name in names})


def _reference(part: Any, allow_code: bool) -> Reference:
    """Return a reference: as it is, that of a scenario, or the poses of a CSV file."""
    if isinstance(part, PythonObject):
        part = part.built()
    elif isinstance(part, Scenario):
        part = part.reference
    elif isinstance(part, str | os.PathLike) and not os.fspath(part).endswith(".csv"):
        part = as_scenario(part, allow_code=allow_code).reference
    return as_reference("fly", part)
