"""omnimorph: omnidirectional and morphing multirotors, from one geometry file to flight.

::

    import omnimorph as om

    run = om.fly(om.load_scenario("paper-case-a"), seed=0)
    run.metrics.drag_energy_paper

Importing does no work: each public name is loaded when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from omnimorph.version import __version__

if TYPE_CHECKING:
    from omnimorph import analysis, identification, textbook
    from omnimorph.control.allocators import (
        ExhaustiveTilt,
        FixedTilt,
        JointTilt,
        ThreeCandidates,
    )
    from omnimorph.control.controller import PoseController
    from omnimorph.control.gains import ProposedController, propose_controller
    from omnimorph.control.margins import StabilityMargins, stability_margins
    from omnimorph.control.tilt_cost import cost_over_tilt
    from omnimorph.control.tracking import TrackingGains
    from omnimorph.design.files import list_vehicles, load_vehicle
    from omnimorph.design.vehicle import Vehicle
    from omnimorph.errors import InputError, OmnimorphError, UnlikelyUnitWarning
    from omnimorph.model.allocation import allocation_matrix, full_allocation_matrix
    from omnimorph.protocols import Command, Desired, Estimate, State
    from omnimorph.results.flights import Flights
    from omnimorph.results.logged import LoggedColumn
    from omnimorph.results.run import Outcome, Run
    from omnimorph.results.store import load_run
    from omnimorph.simulation import effects
    from omnimorph.simulation.fly import fly
    from omnimorph.simulation.fly_many import fly_many
    from omnimorph.simulation.loop import SteppedFlight
    from omnimorph.simulation.parts import with_parts
    from omnimorph.simulation.paths import paths, replaced, value_at
    from omnimorph.simulation.plant import PlantModel, SimulatedPlant
    from omnimorph.simulation.scenario import Scenario
    from omnimorph.simulation.scenario_files import list_scenarios, load_plant, load_scenario
    from omnimorph.simulation.speed_profile import SpeedProfile, speed_steps
    from omnimorph.simulation.thrust_stand import SixAxisSensor, ThrustStand
    from omnimorph.simulation.variation import Normal, Uniform

_NAMES = {
    "analysis": ("analysis",),
    "control.allocators": ("ExhaustiveTilt", "FixedTilt", "JointTilt", "ThreeCandidates"),
    "control.controller": ("PoseController",),
    "control.gains": ("ProposedController", "propose_controller"),
    "control.margins": ("StabilityMargins", "stability_margins"),
    "control.tilt_cost": ("cost_over_tilt",),
    "control.tracking": ("TrackingGains",),
    "design.files": ("list_vehicles", "load_vehicle"),
    "design.vehicle": ("Vehicle",),
    "errors": ("InputError", "OmnimorphError", "UnlikelyUnitWarning"),
    "identification": ("identification",),
    "model.allocation": ("allocation_matrix", "full_allocation_matrix"),
    "protocols": ("Command", "Desired", "Estimate", "State"),
    "results.flights": ("Flights",),
    "results.logged": ("LoggedColumn",),
    "results.run": ("Outcome", "Run"),
    "results.store": ("load_run",),
    "simulation.effects": ("effects",),
    "simulation.fly": ("fly",),
    "simulation.fly_many": ("fly_many",),
    "simulation.loop": ("SteppedFlight",),
    "simulation.parts": ("with_parts",),
    "simulation.paths": ("paths", "replaced", "value_at"),
    "simulation.plant": ("PlantModel", "SimulatedPlant"),
    "simulation.scenario": ("Scenario",),
    "simulation.scenario_files": ("list_scenarios", "load_plant", "load_scenario"),
    "simulation.speed_profile": ("SpeedProfile", "speed_steps"),
    "simulation.thrust_stand": ("SixAxisSensor", "ThrustStand"),
    "simulation.variation": ("Normal", "Uniform"),
    "textbook": ("textbook",),
}
_HOME = {name: module for module, names in _NAMES.items() for name in names}
_MODULES = {"analysis", "effects", "identification", "textbook"}

__all__ = [
    "Command",
    "Desired",
    "Estimate",
    "ExhaustiveTilt",
    "FixedTilt",
    "Flights",
    "InputError",
    "JointTilt",
    "LoggedColumn",
    "Normal",
    "OmnimorphError",
    "Outcome",
    "PlantModel",
    "PoseController",
    "ProposedController",
    "Run",
    "Scenario",
    "SimulatedPlant",
    "SixAxisSensor",
    "SpeedProfile",
    "StabilityMargins",
    "State",
    "SteppedFlight",
    "ThreeCandidates",
    "ThrustStand",
    "TrackingGains",
    "Uniform",
    "UnlikelyUnitWarning",
    "Vehicle",
    "__version__",
    "allocation_matrix",
    "analysis",
    "cost_over_tilt",
    "effects",
    "fly",
    "fly_many",
    "full_allocation_matrix",
    "identification",
    "list_scenarios",
    "list_vehicles",
    "load_plant",
    "load_run",
    "load_scenario",
    "load_vehicle",
    "paths",
    "propose_controller",
    "replaced",
    "speed_steps",
    "stability_margins",
    "textbook",
    "value_at",
    "with_parts",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    module = import_module(f"{__name__}.{_HOME[name]}")
    value = module if name in _MODULES else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
