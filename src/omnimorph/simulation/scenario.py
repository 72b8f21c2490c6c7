"""Scenarios: which vehicle flies where, with which controller, in which plant."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from omnimorph.analysis.flight_worthiness import check_it_can_fly
from omnimorph.control.allocators import AllocationRule, FixedTilt
from omnimorph.control.capability import usable_lateral_force
from omnimorph.control.controller import PoseController, core_settings
from omnimorph.control.tracking import TrackingGains
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.ranges import Range
from omnimorph.design.records import record_of
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.model.core import as_tilt
from omnimorph.protocols import FloatArray, Reference
from omnimorph.reference.samples import as_reference
from omnimorph.simulation.own_parts import OwnParts, described
from omnimorph.simulation.plant import PlantLike, PlantModel, as_plant
from omnimorph.simulation.proposed import overridden, overrides_as_file, proposed_controller

LOST_BEYOND = Range(1e-6, 1e9)
"""In m."""
TILTS_DEG = Range(-1e5, 1e5)
"""In degrees; the limits of the servos are mostly narrower."""


@dataclass(frozen=True, kw_only=True)
class NoRule(FixedTilt):
    """Stands in a scenario whose file names a controller or an allocator in Python instead."""

    W1: float | tuple[float, ...] = 1.0
    W2_position: tuple[float, ...] = (1.0, 1.0, 1.0)
    W2_attitude: tuple[float, ...] = (1.0, 1.0, 1.0)
    W3: float | tuple[float, ...] = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Scenario:
    """Everything that decides a flight but its seed.

    Attributes
    ----------
    name, title : str
        What it is called, and what it shows.
    vehicle : Vehicle
        The vehicle as the controller knows it.
    plant : PlantModel
        How it really behaves.
    gains : TrackingGains
        Of the pose controller.
    allocator : AllocationRule
        How thrusts and tilt are found.
    reference : Reference
        Where to be; the flight lasts as long as it does.
    start_tilt : float or (m,), rad
        The tilt at the start (and throughout, with a fixed-tilt rule).
    attitude_gives_way : bool
        Whether the attitude gives way where the vehicle cannot push sideways as the position needs.
    proposed : bool
        Whether gains and allocator are those that `propose_controller` gives for the vehicle, the
        plant's control period and its command delay, so that `for_vehicle` proposes new ones.
    overrides : mapping
        Of what is proposed: values given in its place, in SI, by the names of the gains; those of
        the allocator stand in a mapping ``allocator``, which may also be a whole rule. They are in
        `gains` and `allocator` too, and stay with another vehicle.
    lost_beyond : float, m
        The flight ends as lost this far from the reference.
    own : OwnParts
        Parts of the loop that are one's own and stand in for those above.
    """

    name: str
    title: str = ""
    vehicle: Vehicle
    plant: PlantModel
    gains: TrackingGains
    allocator: AllocationRule
    reference: Reference
    start_tilt: float | FloatArray = 0.0
    attitude_gives_way: bool = False
    proposed: bool = False
    overrides: Mapping[str, Any] = field(default_factory=dict)
    lost_beyond: float = 2.0
    own: OwnParts = field(default_factory=OwnParts)

    def __post_init__(self) -> None:
        object.__setattr__(self, "vehicle", as_vehicle(self.vehicle))
        object.__setattr__(self, "plant", as_plant(self.plant))
        for part, kind in (("gains", TrackingGains), ("allocator", AllocationRule)):
            record = record_of(self.name, part, getattr(self, part), kind)
            object.__setattr__(self, part, record)
        if not isinstance(self.own, OwnParts):
            raise ScenarioError.at(self.name, "own", self.own, "of the kind OwnParts")
        if self.own.controller is None and self.own.allocator is None:
            self.check_rule()
        object.__setattr__(self, "reference", as_reference(self.name, self.reference))
        self._check_overrides()
        if self.lost_beyond not in LOST_BEYOND:
            allowed = f"a positive number of metres, {LOST_BEYOND}"
            raise ScenarioError.at(self.name, "lost_beyond_m", self.lost_beyond, allowed)
        tilt = self.tilt
        vehicle = self.vehicle
        slack = 1e-9
        inside = (tilt >= vehicle.servo_angle_min - slack) & (
            tilt <= vehicle.servo_angle_max + slack
        )
        if not inside.all():
            limits = zip(vehicle.servo_angle_min, vehicle.servo_angle_max, strict=True)
            shown = ", ".join(f"{math.degrees(a):g} to {math.degrees(b):g}" for a, b in limits)
            degrees = np.degrees(tilt).round(9)
            raise ScenarioError.at(self.name, "start_tilt_deg", degrees, f"within {shown} degrees")
        # What does not fit the vehicle is refused here, with the name of its file, not in flight.
        self.plant.core_fields(vehicle)
        core_settings(vehicle, self.gains, self.allocator, self.plant.control_period)

    def check_rule(self) -> None:
        """Refuse to allocate by a rule where a file names code instead of one."""
        if isinstance(self.allocator, NoRule):
            raise ScenarioError(
                f"{self.name}: there is no allocation rule, because a controller or an allocator "
                "written in Python stands in its place; give an allocator with all its numbers, "
                "or the controller of a scenario.",
                file=self.name,
                key="controller.allocator",
            )

    def _check_overrides(self) -> None:
        """Refuse overrides of nothing, and those that gains and allocator do not hold."""
        controller = self.gains, self.allocator
        if overridden(self.name, controller, self.overrides) != controller:
            allowed = "values that gains and allocator have too"
            raise ScenarioError.at(self.name, "overrides", self.overrides, allowed)
        if self.overrides and not self.proposed:
            allowed = "left out, as the controller is not proposed"
            raise ScenarioError.at(self.name, "overrides", self.overrides, allowed)

    @property
    def tilt(self) -> FloatArray:
        """The tilt at the start, one angle for each servo, rad."""
        return as_tilt(self.vehicle, self.start_tilt)

    @cached_property  # many linear programs with several servos, and every flight asks
    def lateral_force(self) -> float | None:
        """What the vehicle may push sideways if position goes first, N; None if it does not."""
        if not self.attitude_gives_way:
            return None
        return usable_lateral_force(self.vehicle, self.allocator, self.tilt)

    def for_vehicle(self, vehicle: VehicleLike, *, plant: PlantLike | None = None) -> Scenario:
        """Return the same scenario with another vehicle, and with its own controller if proposed.

        A start tilt that all servos share is kept, or as near to it as the new ones turn.

        Parameters
        ----------
        vehicle : Vehicle
            The other one.
        plant : PlantModel, str or path, optional
            Another plant as well, for a vehicle that does not fit this one; a controller is still
            proposed for the period and the delay of this one.

        Raises
        ------
        ScenarioError, VehicleError
            If it cannot hold itself in the air, if the controller, the plant or the start tilt does
            not fit, or if none can be proposed.

        Examples
        --------
        >>> import omnimorph as om
        >>> tour = om.load_scenario("tour").for_vehicle(om.load_vehicle("omnimorph-2026"))
        >>> tour.vehicle.name, tour.title
        ('omnimorph-2026', 'Climb, sideways, turn by 90 degrees and back: a tour for any vehicle')
        """
        vehicle = as_vehicle(vehicle)
        tilt = np.asarray(self.start_tilt, dtype=np.float64)
        if (tilt == tilt.flat[:1]).all():
            common = np.full(vehicle.n_servos, tilt.flat[0] if tilt.size else 0.0)
            tilt = common.clip(vehicle.servo_angle_min, vehicle.servo_angle_max)
        if self.proposed:
            controller = proposed_controller(vehicle, self.plant, tilt)
            place = f"scenario {self.name} with vehicle {vehicle.name}"
            gains, allocator = overridden(place, controller, self.overrides)
        else:
            gains, allocator = self.gains, self.allocator
            check_it_can_fly(vehicle)
        plant = self.plant if plant is None else as_plant(plant)
        try:
            return replace(
                self,
                vehicle=vehicle,
                plant=plant,
                gains=gains,
                allocator=allocator,
                start_tilt=tilt,
            )
        except ScenarioError as refused:
            if refused.key != "controller.allocator" or self.proposed:
                raise
            raise self._other_controller_needed(refused) from None

    def _other_controller_needed(self, refused: ScenarioError) -> ScenarioError:
        """Return the refusal of another vehicle in the words of who only names that vehicle."""
        return ScenarioError(
            f"scenario {self.name}: its {refused.key} {self.allocator.kind} does not fit "
            f"{refused.file}; fly tour, or another scenario with [controller] proposed = true, "
            f"which takes the controller from the vehicle, or write one with {refused.allowed}.",
            file=self.name,
            key=refused.key,
            value=self.allocator.kind,
            allowed=refused.allowed,
        )

    def build_controller(self) -> PoseController:
        """Return the scenario's controller of the core, to be stepped from Python.

        Raises
        ------
        ScenarioError
            If its file names a controller or an allocator of one's own instead.
        """
        self.check_rule()
        return PoseController(
            self.vehicle,
            self.gains,
            self.allocator,
            self.plant.control_period,
            self.tilt,
            lateral_force=self.lateral_force,
        )

    def as_file(self) -> dict[str, Any]:
        """Return everything that is flown, much as a file would hold it."""
        plant = self.plant.as_file()
        overrides = overrides_as_file(self.gains, self.allocator, self.overrides)
        plant["effects"] = [effect.as_file() for effect in self.plant.effects]
        own = {name: described(part) for name, part in self.own.given().items()}
        allocator = own.pop("allocator", None) or self.allocator.as_file()
        controller = own.pop("controller", None) or (
            self.gains.as_file()
            | {"kind": "paper", "allocator": allocator}
            | ({"attitude_gives_way": True} if self.attitude_gives_way else {})
            | ({"proposed": True} if self.proposed else {})
            | ({"overrides": overrides} if overrides else {})
        )
        if "plant" in own:
            own["engine"] = own.pop("plant")
        return {
            "name": self.name,
            "title": self.title,
            "vehicle": self.vehicle.name,
            "plant": plant,
            "controller": controller,
            "reference": described(self.reference),
            "start_tilt_deg": np.degrees(self.tilt).tolist(),
            "lost_beyond_m": self.lost_beyond,
            **own,
        }
