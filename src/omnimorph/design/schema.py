"""The vehicle file, table by table, as pydantic models: which keys it has and what each may hold.

The description of a field is what a message says is allowed: "mass_kg is -1.0, but it must be
<description>". Here are the tables, and the keys that hold words; those that hold numbers follow
from the fields that `Vehicle` declares. What makes a vehicle possible it checks itself.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from omnimorph.design.keys import fields_in
from omnimorph.design.tables import Table, table_with
from omnimorph.design.vehicle import MOST_ROTORS, MOST_SERVOS


class RotorDefaults(table_with(fields_in("rotor", shared=True))):  # type: ignore[misc]
    """``[rotor_defaults]``: what all rotors share unless their own table says otherwise."""


class Rotor(table_with(fields_in("rotor"), RotorDefaults)):  # type: ignore[misc]
    """``[[rotor]]``: one rotor; any key of ``[rotor_defaults]`` may stand here too."""

    servo: str | None = Field(default=None, description="the name of a [[servo]]")
    spin: Literal["ccw", "cw"] = Field(description='"ccw" or "cw", its sense about the axis')


class Named(Table):
    """What has a name."""

    name: str = Field(description="a name")


class Servo(table_with(fields_in("servo"), Named)):  # type: ignore[misc]
    """``[[servo]]``: one servo, which tilts the rotors that name it."""


class Filter(table_with(fields_in("filter"))):  # type: ignore[misc]
    """``[filter]``: cut-offs of the state estimator's filters; 0, or no key, means no filter."""


class Head(Table):
    """What a vehicle file begins with."""

    schema_version: int = Field(
        alias="schema",
        ge=1,
        le=1,
        description="1, the version of the format that this release reads",
    )
    name: str = Field(description="a short name")
    title: str = Field(description="one line of text")


class VehicleFile(table_with(fields_in(""), Head)):  # type: ignore[misc]
    """The whole file."""

    rotor_defaults: RotorDefaults = Field(
        default=RotorDefaults(), description="a table, written [rotor_defaults]"
    )
    rotor: list[Rotor] = Field(
        min_length=1,
        max_length=MOST_ROTORS,
        description=f"tables, written [[rotor]], for 1 to {MOST_ROTORS} rotors",
    )
    servo: list[Servo] = Field(
        default=[],
        max_length=MOST_SERVOS,
        description=f"tables, written [[servo]], for at most {MOST_SERVOS} servos",
    )
    filter: Filter = Field(default=Filter(), description="a table, written [filter]")
    sources: dict[str, Any] = Field(default={}, description="a table, written [sources]")
    assumed: dict[str, Any] = Field(default={}, description="a table, written [assumed]")
