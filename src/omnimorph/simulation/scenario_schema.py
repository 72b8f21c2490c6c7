"""The scenario file, table by table, as pydantic models.

The description of a field is what a message says is allowed. Gains, allocation rules, segments and
the plant are not written out here: their models are made of the records (`design.tables`).
"""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag

from omnimorph.control.rules import RULES
from omnimorph.control.tracking import TrackingGains
from omnimorph.design.ranges import UNIT_VECTOR
from omnimorph.design.records import declared
from omnimorph.design.tables import (
    Number,
    Table,
    Vector,
    file_model,
    number,
    table_with,
)
from omnimorph.reference.ranges import POSITIONS, TIMES
from omnimorph.reference.rows import rotation_from_quaternion
from omnimorph.reference.segments import Segment
from omnimorph.simulation.plant_files import FileHead, PlantTable
from omnimorph.simulation.scenario import LOST_BEYOND, TILTS_DEG

_QUATERNION = "four numbers w, x, y, z of unit length"


def _unit(quaternion: list[float]) -> list[float]:
    """Return a quaternion that is nearly of unit length with unit length."""
    if any(number not in UNIT_VECTOR for number in quaternion):
        raise ValueError(f"{_QUATERNION}, {UNIT_VECTOR}")
    length = float(np.linalg.norm(quaternion))
    if abs(length - 1.0) > 0.01:
        raise ValueError(_QUATERNION)
    return [number / length for number in quaternion]


Quaternion = Annotated[list[Number], Field(min_length=4, max_length=4), AfterValidator(_unit)]


class PythonTable(Table):
    """A part of the loop that is one's own, ``kind = "python"``."""

    kind: Literal["python"] = Field(description="python")
    object: str = Field(min_length=1, description='a module and an object, "my_module:MyObject"')
    folder: str = Field(default="", description="where the module lies, seen from this file")
    options: dict[str, Any] = Field(default={}, description="a table of arguments by name")


if TYPE_CHECKING:
    AnyRule = Any
    ControllerTable = Any
else:
    AnyRule = Annotated[
        reduce(or_, map(file_model, RULES)) | PythonTable, Field(discriminator="kind")
    ]
    ControllerTable = file_model(
        TrackingGains,
        allocator=(AnyRule, Field(description="a table with the kind of rule and its weights")),
        kind=(Literal["paper"], Field(default="paper", description="paper or python")),
        attitude_gives_way=(bool, Field(default=False, description="true or false")),
        proposed=(bool, Field(default=False, description="true or false")),
    )


class ProposedTable(
    file_model(  # type: ignore[misc]
        TrackingGains, proposed=(Literal[True], Field(description="true or false"))
    )
):
    """``[controller]`` whose gains and allocator come from the vehicle, but those given here.

    Which keys the allocator may have follows from the one that is proposed.
    """

    kind: Literal["paper"] = Field(default="paper", description="paper or python")
    attitude_gives_way: bool = Field(default=False, description="true or false")
    allocator: dict[str, Any] = Field(default={}, description="a table of weights")


class SegmentTable(table_with(declared(Segment).values())):  # type: ignore[misc]
    """``[[reference.segment]]``: one move from rest to rest."""


class ReferenceTable(Table):
    """What ``[reference]`` may say whatever its kind."""

    pose_only: bool = Field(default=False, description="true or false")


class Segments(ReferenceTable):
    """``[reference]`` made of minimum-jerk segments."""

    kind: Literal["segments"]
    start_position_m: Vector = number(POSITIONS, "three numbers of metres")
    start_quaternion_wxyz: Quaternion | None = number(UNIT_VECTOR, _QUATERNION, None)
    segment: list[SegmentTable] = Field(min_length=1, description="one segment or more")

    def start_attitude(self) -> np.ndarray:
        """Return the attitude at the start as a (3, 3) rotation."""
        if self.start_quaternion_wxyz is None:
            return np.eye(3)
        return rotation_from_quaternion(np.array(self.start_quaternion_wxyz))


class Waypoint(Table):
    """``[[reference.waypoint]]``: a pose at a time, where the vehicle rests."""

    time_s: Number = number(TIMES, "a number of seconds, after the waypoint before")
    position_m: Vector = number(POSITIONS, "three numbers of metres")
    quaternion_wxyz: Quaternion | None = number(UNIT_VECTOR, _QUATERNION, None)


class Waypoints(ReferenceTable):
    """``[reference]`` made of poses, at rest in each."""

    kind: Literal["waypoints"]
    waypoint: list[Waypoint] = Field(min_length=2, description="two waypoints or more")


class Samples(ReferenceTable):
    """``[reference]`` from a CSV file of poses, through which a smooth curve is laid."""

    kind: Literal["samples"]
    file: str = Field(min_length=1, description="the name of a CSV file")


AnyReference = Annotated[Segments | Waypoints | Samples | PythonTable, Field(discriminator="kind")]


def _table_or_name(value: Any) -> str:
    """Return which of the two a plant in a scenario is: only its own mistakes are reported."""
    return "table" if isinstance(value, dict | PlantTable) else "name"


PlantName = Annotated[str, Field(min_length=1)]
AnyPlant = Annotated[
    Annotated[PlantName, Tag("name")] | Annotated[PlantTable, Tag("table")],
    Discriminator(_table_or_name),
]


class PythonController(PythonTable):
    """``[controller]`` of one's own."""

    kind: Literal["python"] = Field(description="paper or python")


def _kind_of_controller(value: Any) -> str:
    """Return which one a controller is, so that only its own mistakes are reported."""
    given = value if isinstance(value, dict) else getattr(value, "__dict__", {})
    if given.get("kind", "paper") != "paper":
        return "PythonController"
    return "ProposedTable" if given.get("proposed") is True else TrackingGains.__name__


AnyController = Annotated[
    Annotated[ProposedTable, Tag("ProposedTable")]
    | Annotated[PythonController, Tag("PythonController")]
    | Annotated[ControllerTable, Tag(TrackingGains.__name__)],
    Discriminator(_kind_of_controller),
]


class ScenarioFile(FileHead):
    """A scenario file, with those it is based on already merged in."""

    vehicle: str = Field(min_length=1, description="a name of the catalogue, or a vehicle file")
    plant: AnyPlant = Field(description="a name of the catalogue, a plant file, or a table")
    controller: AnyController = Field(description="a table with the allocator and the gains")
    reference: AnyReference = Field(description="a table with the kind of reference")
    sensors: PythonTable | None = Field(default=None, description='a table, kind = "python"')
    estimator: PythonTable | None = Field(default=None, description='a table, kind = "python"')
    disturbance: PythonTable | None = Field(default=None, description='a table, kind = "python"')
    start_tilt_deg: Number | list[Number] = number(
        TILTS_DEG, "a finite number of degrees, or one for each servo", 0.0
    )
    lost_beyond_m: Number = number(LOST_BEYOND, "a positive number of metres", 2.0)
