"""Plant files: from TOML with units in its key names to a `PlantModel`."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import reduce
from importlib import resources
from importlib.resources.abc import Traversable
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

from pydantic import Field

from omnimorph.design.documents import (
    catalogue_names,
    check_document,
    find_document,
    parse_toml,
    record_or_file,
)
from omnimorph.design.input_files import is_file
from omnimorph.design.records import declared
from omnimorph.design.tables import Line, Table, file_model, table_with
from omnimorph.errors import InputError, ScenarioError
from omnimorph.simulation.effects import EFFECTS
from omnimorph.simulation.plant_model import PlantModel

PlantLike = PlantModel | str | os.PathLike[str]
"""A plant, or the name or file of one."""

Built = TypeVar("Built")
_EFFECTS = {effect.kind: effect for effect in EFFECTS}


if TYPE_CHECKING:
    AnyEffect = Any
else:
    AnyEffect = Annotated[reduce(or_, map(file_model, EFFECTS)), Field(discriminator="kind")]

_FIELDS = [field for field in declared(PlantModel).values() if field.allowed]


class PlantTable(table_with(_FIELDS)):  # type: ignore[misc]
    """``[plant]``: time steps, integrator and imperfections."""

    effect: list[AnyEffect] = Field(default=[], description="a list of effects, each with its kind")


class FileHead(Table):
    """What a plant file and a scenario file begin with."""

    schema_version: Literal[1] = Field(
        alias="schema", description="1, the version this package reads"
    )
    name: Line = Field(min_length=1, description="a name, at most 200 printable characters")
    title: Line = Field(default="", description="one line of text, at most 200 characters")


class PlantFile(FileHead):
    """A plant file."""

    plant: PlantTable = Field(description="a table, written [plant]")


def list_plants() -> list[str]:
    """Return the names of the plants that come with the package, sorted."""
    return catalogue_names(_catalogue())


def load_plant(name_or_path: str | os.PathLike[str]) -> PlantModel:
    """Load a plant of the catalogue (``perfect``, ``realistic``), or from a TOML file.

    Raises
    ------
    ScenarioError
        As `omnimorph.load_scenario` does.
    """
    file, text = find_document(name_or_path, _catalogue(), "plant", ScenarioError)
    document = parse_toml(text, file, ScenarioError)
    content = check_document(PlantFile, document, file, ScenarioError)
    return built_of(file, lambda: plant_of_table(content.plant, content.name))


def as_plant(plant: PlantLike) -> PlantModel:
    """Return a plant that may be given as `load_plant` takes it; refuse anything else."""
    return record_or_file(plant, PlantModel, "plant", load_plant, ScenarioError)


def plant_of_table(content: Any, name: str) -> PlantModel:
    """Return the plant of a checked table ``[plant]``."""
    effects = tuple(_EFFECTS[effect.kind].from_file(effect) for effect in content.effect)
    return PlantModel.from_file(content, effects=effects, name=name)


def built_of(file: str, build: Callable[[], Built]) -> Built:
    """Build something of a file's content; what it refuses is reported with the file's name.

    A refusal that names another file, in which the mistake is, stays as it is.
    """
    try:
        return build()
    except InputError as refused:
        if refused.file is not None and is_file(refused.file):
            raise
        raise ScenarioError(
            f"{file}: {refused}",
            file=file,
            key=refused.key,
            value=refused.value,
            allowed=refused.allowed,
        ) from None


def _catalogue() -> Traversable:
    return resources.files("omnimorph.simulation") / "plants"
