"""The plant: what it is made of.

Within a physics step the actuators move first, then the body: with semi-implicit Euler the new
actuators give the wrench, the new velocities give the pose; fourth-order Runge-Kutta takes the
actuators at the start, middle and end of the step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from omnimorph.design.ranges import Range
from omnimorph.design.records import Record, choice, quantity
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.model.core import as_core, in_float64
from omnimorph.simulation.effects import ConstantWrench, Effect, PlantBuild

INTEGRATORS = ("semi-implicit-euler", "runge-kutta-4")
_TIME_STEPS = Range(1e-3, 1e4)  # ms
_POSITIVE = "a positive number of milliseconds"


@dataclass(frozen=True, kw_only=True)
class PlantModel(Record):
    """How the vehicle really behaves: time steps, integrator, and a list of imperfections.

    Attributes
    ----------
    name : str
        What reports call it.
    physics_step, control_period : float, s
        The period is a multiple of the step.
    integrator : str
        ``semi-implicit-euler`` or ``runge-kutta-4`` (on SO(3)).
    effects : tuple of Effect
        Each kind once, but for constant wrenches, which add up.

    Raises
    ------
    ScenarioError
        If the period is no multiple of the step, or an effect stands twice.
    """

    kind: ClassVar[str] = "plant"
    physics_step: float = quantity("ms", _TIME_STEPS, _POSITIVE, default=1e-3)
    control_period: float = quantity("ms", _TIME_STEPS, _POSITIVE, default=1e-3)
    integrator: Literal["semi-implicit-euler", "runge-kutta-4"] = choice(
        INTEGRATORS, " or ".join(INTEGRATORS), default="semi-implicit-euler"
    )
    effects: tuple[Effect, ...] = ()
    name: str = "own"

    def __post_init__(self) -> None:
        super().__post_init__()
        control_steps(self)
        if not isinstance(self.effects, tuple):
            raise ScenarioError.at("plant", "effects", self.effects, "a sequence of effects")
        seen: set[str] = set()
        for effect in self.effects:
            if not isinstance(effect, Effect):
                raise ScenarioError.at("plant", "effects", effect, "a sequence of effects")
            if effect.kind in seen and not isinstance(effect, ConstantWrench):
                raise ScenarioError.at("plant", "effect", effect.kind, "there only once")
            seen.add(effect.kind)

    def true_vehicle(self, vehicle: Vehicle) -> Vehicle:
        """Return the vehicle that really flies when the controller believes in `vehicle`."""
        known: tuple[Vehicle | None, Vehicle] = vars(self).get("_last_truth", (None, vehicle))
        believed, truth = known
        if believed is not vehicle:  # the same one is asked for again and again
            truth = vehicle
            for effect in self.effects:
                truth = effect.true_vehicle(truth)
            vars(self)["_last_truth"] = vehicle, truth
        return truth

    def core_fields(self, vehicle: Vehicle) -> dict[str, Any]:
        """Return the fields of the core's loop that a plant says, for a controller's vehicle."""
        truth = self.true_vehicle(vehicle)
        plant: dict[str, Any] = {
            "vehicle": as_core(truth),
            "command_coefficient": vehicle.thrust_coefficient,
            "effectiveness": np.ones(vehicle.n_rotors),
            "step": self.physics_step,
            "integrator": self.integrator,
        }
        sensors: dict[str, Any] = {}
        build = PlantBuild(plant, sensors, truth, self.control_period, self.physics_step)
        for effect in self.effects:
            effect.add_to(build)
        sensors.setdefault("estimator", ("low-pass", {"cutoff": np.zeros(4)}))  # which passes all
        periods = {
            "control_every": control_steps(self),
            "control_period": self.control_period,
        }
        return in_float64({"plant": plant} | sensors | periods)


def control_steps(plant: PlantModel) -> int:
    """Return the number of physics steps in a control period; refuse a broken number."""
    ratio = plant.control_period / plant.physics_step
    steps = round(ratio)
    if steps < 1 or abs(ratio - steps) > 1e-9 * ratio:
        allowed = f"a multiple of the physics step, {plant.physics_step * 1e3:g} ms"
        raise ScenarioError.at("plant", "control_period_ms", plant.control_period * 1e3, allowed)
    return steps
