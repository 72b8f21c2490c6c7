"""The plant file, and the table ``[plant]`` of a scenario, as pydantic models."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from omnimorph.design.tables import Line, Table, file_model
from omnimorph.simulation.effects import EFFECTS
from omnimorph.simulation.plant_model import PlantModel

__all__ = ["PlantFile", "PlantTable"]

if TYPE_CHECKING:
    PlantTable = Any
else:
    AnyEffect = Annotated[reduce(or_, map(file_model, EFFECTS)), Field(discriminator="kind")]
    PlantTable = file_model(
        PlantModel,
        without=("effects", "name"),
        effect=(
            list[AnyEffect],
            Field(default=[], description="a list of effects, each with its kind"),
        ),
    )


class PlantFile(Table):
    """A plant file."""

    schema_version: Literal[1] = Field(
        alias="schema", description="1, the version this package reads"
    )
    name: Line = Field(min_length=1, description="a name, at most 200 printable characters")
    title: Line = Field(default="", description="one line of text, at most 200 characters")
    plant: PlantTable = Field(description="a table, written [plant]")
