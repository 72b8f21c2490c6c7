"""Scenario files: from TOML with units in its key names to a `Scenario`.

::

    schema = 1
    name = "my-flight"
    base = "paper-case-a"            # optional: what this file leaves out stands there
    vehicle = "omnimorph"            # a catalogue name, or a file beside this one
    plant = "realistic"              # likewise, or a table [plant]

    [controller]                     # gains; left out, the paper's (or only: proposed = true)
    [controller.allocator]
    kind = "three-candidates"
    W1_per_Hz4 = 1e-8
    ...
    [reference]
    kind = "segments"                # or "waypoints", or "samples" with file = "poses.csv"
    start_position_m = [0.0, 0.0, 1.2]
    [[reference.segment]]
    duration_s = 3.0
    move_m = [0.0, 0.0, 0.8]

A part of the loop may be one's own (`omnimorph.simulation.own_parts`), which runs only if it is
allowed: the controller, its allocator, the reference, and tables of their own for the estimator,
the sensors and a disturbance::

    [estimator]
    kind = "python"
    object = "my_module:MyEstimator" # a class is built with the scenario and the options
    [estimator.options]
    gain = 0.3
"""

from __future__ import annotations

import json
import os
from functools import partial
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, cast

import numpy as np

from omnimorph.analysis.flight_worthiness import check_it_can_fly
from omnimorph.control.rules import RULES
from omnimorph.control.tracking import TrackingGains
from omnimorph.design.documents import (
    catalogue_names,
    check_document,
    find_document,
    parse_toml,
    record_or_file,
)
from omnimorph.design.files import load_vehicle
from omnimorph.design.records import declared, values_of
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import MISSING, ScenarioError
from omnimorph.protocols import FloatArray, Reference
from omnimorph.reference.pose_only import PoseOnly
from omnimorph.reference.samples import SampledReference
from omnimorph.reference.segments import Segment, SegmentReference, segments_from_waypoints
from omnimorph.simulation.own_parts import OwnParts, PythonObject
from omnimorph.simulation.plant_files import built_of, list_plants, load_plant, plant_of_table
from omnimorph.simulation.proposed import Controller, overridden, proposed_controller
from omnimorph.simulation.scenario import NoRule, Scenario
from omnimorph.simulation.scenario_schema import ScenarioFile
from omnimorph.units import to_SI

__all__ = [
    "ScenarioLike",
    "as_scenario",
    "list_plants",
    "list_scenarios",
    "load_plant",
    "load_scenario",
]

ScenarioLike = Scenario | str | os.PathLike[str]
"""A scenario, or the name or file of one."""

Document = dict[str, Any]
_RULES = {rule.kind: rule for rule in RULES}
_MOST_BASES = 8


def list_scenarios() -> list[str]:
    """Return the names of the scenarios that come with the package, sorted."""
    return catalogue_names(_catalogue())


def load_scenario(name_or_path: str | os.PathLike[str], *, allow_code: bool = False) -> Scenario:
    """Load a scenario of the catalogue, or from a TOML file.

    Parameters
    ----------
    name_or_path : str or path
        A name of `list_scenarios`, which goes first, or the path of a file.
    allow_code : bool
        Whether code may run that the file names, ``object = "my_module:MyController"``.

    Returns
    -------
    Scenario
        Checked, in SI.

    Raises
    ------
    ScenarioError
        If there is no such scenario, or its file cannot be read or describes none; one sentence
        with the file, the key, the value and what is allowed.

    Examples
    --------
    >>> load_scenario("paper-case-a").reference.duration
    45.0
    """
    document, file, stated = _with_bases(name_or_path, [])
    content = check_document(ScenarioFile, document, file, ScenarioError)
    folder = Path(file).parent
    vehicle = built_of(file, lambda: load_vehicle(_beside(content.vehicle, folder)))
    if isinstance(content.plant, str):
        beside = _beside(content.plant, folder)
        plant = built_of(file, lambda: load_plant(beside))
    else:
        plant = built_of(file, lambda: plant_of_table(content.plant, "own"))
    built_of(file, lambda: check_it_can_fly(vehicle))
    start_tilt = _start_tilt(content.start_tilt_deg, vehicle, file)
    named: Any = content.controller
    controller = named
    if named.kind == "python" and stated is not None:  # it may build that of the base for itself
        document = document | {"controller": stated}
        controller = check_document(ScenarioFile, document, file, ScenarioError).controller
    is_proposed = getattr(controller, "proposed", False)
    overrides: dict[str, Any] = {}
    if controller.kind == "paper" and controller.proposed:
        proposed = built_of(file, lambda: proposed_controller(vehicle, plant, start_tilt))
        controller = _beside_proposed(document, proposed, file)
        overrides = _overrides(controller, document, proposed)
        gains, allocator = overridden(file, proposed, overrides)
    else:
        gains, allocator = _stated(controller)
    own_controller = named if named.kind == "python" else controller
    own = _own_parts(content, own_controller, file, folder, allow_code)
    return built_of(
        file,
        lambda: Scenario(
            name=content.name,
            title=content.title,
            vehicle=vehicle,
            plant=plant,
            gains=gains,
            allocator=allocator,
            reference=_reference_from(content.reference, file, folder, allow_code),
            start_tilt=start_tilt,
            attitude_gives_way=getattr(controller, "attitude_gives_way", False),
            proposed=is_proposed,
            overrides=overrides,
            lost_beyond=content.lost_beyond_m,
            own=own,
        ),
    )


def as_scenario(scenario: ScenarioLike, *, allow_code: bool = False) -> Scenario:
    """Return a scenario that may be given as `load_scenario` takes it; refuse anything else."""
    load = partial(load_scenario, allow_code=allow_code)
    return record_or_file(scenario, Scenario, "scenario", load, ScenarioError)


def _catalogue() -> Traversable:
    return resources.files("omnimorph.simulation") / "scenarios"


def _with_bases(
    name_or_path: str | os.PathLike[str], above: list[str]
) -> tuple[Document, str, Document | None]:
    """Return a scenario's document laid over those it is based on, and its file.

    The third is the controller of the core in a base, for the same vehicle, that one of one's own
    stands in for.
    """
    file, text = find_document(name_or_path, _catalogue(), "scenario", ScenarioError)
    document = parse_toml(text, file, ScenarioError)
    base = document.pop("base", None)
    if base is None:
        return document, file, None
    if not isinstance(base, str):
        raise ScenarioError.at(file, "base", base, "the name or file of another scenario")
    if file in above or len(above) == _MOST_BASES:
        raise ScenarioError.at(file, "base", base, "a scenario that is not based on this one")
    below, _, stated = _with_bases(_beside(base, Path(file).parent), [*above, file])
    below = _seen_from_above(below, Path(base).parent)
    if _is_proposed(document) and not _is_proposed(below):
        # The base's gains and allocator would not be flown.
        kept = ("proposed", "attitude_gives_way")
        controller = below.get("controller")
        if isinstance(controller, dict):
            below["controller"] = {key: controller[key] for key in kept if key in controller}
    if "name" not in document:
        raise ScenarioError.at(file, "name", MISSING, "the scenario's own name")
    lower = below.get("controller")
    if isinstance(lower, dict) and lower.get("kind", "paper") == "paper":
        stated = lower
    if "vehicle" in document:  # which it may not fit
        stated = None
    return _laid_over(document, below), file, stated


def _seen_from_above(document: Document, folder: Path) -> Document:
    """Return a base's document with the files it mentions named from the folder of its user."""
    moved = dict(document)
    for key in ("vehicle", "plant"):
        if isinstance(moved.get(key), str):
            moved[key] = _beside(moved[key], folder)
    for key in ("reference", "controller", "sensors", "estimator", "disturbance"):
        if isinstance(moved.get(key), dict):
            moved[key] = _moved_table(moved[key], folder)
    return moved


def _moved_table(table: Document, folder: Path) -> Document:
    """Return a table with the files and modules that it names, seen from above."""
    moved = dict(table)
    if isinstance(table.get("file"), str):
        moved["file"] = str(folder / table["file"])
    if table.get("kind") == "python" and isinstance(table.get("folder", ""), str):
        moved["folder"] = str(folder / table.get("folder", ""))
    if isinstance(table.get("allocator"), dict):
        moved["allocator"] = _moved_table(table["allocator"], folder)
    return moved


def _laid_over(upper: Document, lower: Document) -> Document:
    """Return both documents as one: tables are merged, anything else is the upper one's.

    A table of another kind replaces the lower one: its keys would not fit.
    """
    joined = dict(lower)
    for key, value in upper.items():
        old = lower.get(key)
        if isinstance(value, dict) and isinstance(old, dict):
            kind = old.get("kind", "paper" if key == "controller" else None)
            same_kind = value.get("kind", kind) == kind
            joined[key] = _laid_over(value, old) if same_kind else value
        else:
            joined[key] = value
    return joined


def _beside(name: str, folder: Path) -> str:
    """Return a path that a file mentions, relative to the file's folder; names stay as they are."""
    is_path = name.endswith((".toml", ".csv")) or os.sep in name
    return str(folder / name) if is_path else name


def _is_proposed(document: Document) -> bool:
    controller = document.get("controller")
    return isinstance(controller, dict) and controller.get("proposed") is True


def _beside_proposed(document: Document, proposed: Controller, file: str) -> Any:
    """Return ``[controller]`` checked, with the proposed rule below it, as in a base."""
    given = {"allocator": {}} | document["controller"] | {"proposed": False}
    below = {"allocator": json.loads(json.dumps(proposed[1].as_file()))}  # lists, as TOML has them
    whole = document | {"controller": _laid_over(given, below)}
    return check_document(ScenarioFile, whole, file, ScenarioError).controller


def _overrides(controller: Any, document: Document, proposed: Controller) -> dict[str, Any]:
    """Return what ``[controller]`` gives in place of what is proposed, by the names of fields."""
    overrides = values_of(TrackingGains, controller)
    given = document["controller"].get("allocator", {})
    if controller.allocator.kind == "python":
        return overrides
    rule = _RULES[controller.allocator.kind].from_file(controller.allocator)
    if type(rule) is not type(proposed[1]):
        overrides["allocator"] = rule
    elif given:
        names = [name for name, field in declared(type(rule)).items() if field.key in given]
        kind = {"kind": rule.kind} if "kind" in given else {}
        overrides["allocator"] = kind | {name: getattr(rule, name) for name in names}
    return overrides


def _start_tilt(degrees: float | list[float], vehicle: Vehicle, file: str) -> FloatArray:
    if isinstance(degrees, list) and len(degrees) != vehicle.n_servos:
        allowed = f"one number, or one for each of the {vehicle.n_servos} servos of {vehicle.name}"
        raise ScenarioError.at(file, "start_tilt_deg", degrees, allowed)
    return to_SI(np.array(degrees), "deg")


def _stated(controller: Any) -> Controller:
    """Return the gains and the rule that a table states; of one's own are none."""
    rule = getattr(controller, "allocator", controller)
    if rule.kind != "python":
        return TrackingGains.from_file(controller), _RULES[rule.kind].from_file(rule)
    gains = TrackingGains.from_file(controller) if rule is not controller else TrackingGains()
    return gains, NoRule()


def _own_parts(
    content: Any, controller: Any, file: str, folder: Path, allow_code: bool
) -> OwnParts:
    """Return the parts of the loop that a file names as objects of one's own."""
    tables = {
        "controller": controller,
        "controller.allocator": getattr(controller, "allocator", None),
        "sensors": content.sensors,
        "estimator": content.estimator,
        "disturbance": content.disturbance,
    }
    named: Any = {
        key.rpartition(".")[2]: _python_object(table, key, file, folder, allow_code)
        for key, table in tables.items()
        if getattr(table, "kind", "") == "python"
    }
    return OwnParts(**named)


def _python_object(table: Any, key: str, file: str, folder: Path, allow_code: bool) -> PythonObject:
    part = PythonObject(table.object, table.options, str((folder / table.folder).resolve()))
    return part.checked(file, f"{key}.object", allow_code)


def _reference_from(content: Any, file: str, folder: Path, allow_code: bool) -> Reference:
    if content.kind == "python":
        part: Any = _python_object(content, "reference", file, folder, allow_code).built()
        return cast(Reference, part)
    whole = _whole_reference(content, folder)
    return PoseOnly(whole) if content.pose_only else whole


def _whole_reference(content: Any, folder: Path) -> SegmentReference | SampledReference:
    if content.kind == "samples":
        return SampledReference.from_csv(str(folder / content.file))
    if content.kind == "waypoints":
        points = content.waypoint
        turned = any(point.quaternion_wxyz is not None for point in points)
        upright = [1.0, 0.0, 0.0, 0.0]
        return segments_from_waypoints(
            [point.time_s for point in points],
            [point.position_m for point in points],
            [point.quaternion_wxyz or upright for point in points] if turned else None,
        )
    segments = [Segment(**values_of(Segment, part)) for part in content.segment]
    return SegmentReference(content.start_position_m, content.start_attitude(), segments)
