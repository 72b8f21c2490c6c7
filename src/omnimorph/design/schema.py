"""The vehicle file, table by table, as pydantic models: which keys it has and what each may hold.

The description of a field is what a message says is allowed: "mass_kg is -1.0, but it must be
<description>". Here are the tables, and the keys that hold words; those that hold numbers follow
from the fields that `Vehicle` declares. What makes a vehicle possible it checks itself.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationInfo,
    create_model,
    field_validator,
)
from pydantic.fields import FieldInfo

from omnimorph.design.keys import fields_in
from omnimorph.design.ranges import Range, numbers_in
from omnimorph.design.vehicle import MOST_ROTORS, MOST_SERVOS
from omnimorph.design.vehicle_fields import VehicleField

__all__ = [
    "Filter",
    "Line",
    "Matrix",
    "Number",
    "Rotor",
    "RotorDefaults",
    "Servo",
    "Table",
    "Vector",
    "VehicleFile",
    "number",
    "range_of",
]

Number = Annotated[float, Field(allow_inf_nan=False)]
"""A finite number; whole numbers may be written without a point."""

Vector = Annotated[list[Number], Field(min_length=3, max_length=3)]
"""Three finite numbers."""


def _one_line(text: str) -> str:
    if not text.isprintable() or len(text) > LONGEST_LINE:
        raise ValueError(f"one line of text, at most {LONGEST_LINE} characters")
    return text


Line = Annotated[str, AfterValidator(_one_line)]
"""A text that can be shown anywhere: one line, without characters that steer a terminal."""

Matrix = Annotated[list[Vector], Field(min_length=3, max_length=3)]
"""Three rows of three finite numbers."""

LONGEST_LINE = 200


def number(limits: Range, allowed: str, default: Any = ...) -> Any:
    """Declare a field that is a number, or several, each within a range.

    Parameters
    ----------
    limits : Range
        In the unit at the end of the key.
    allowed : str
        What is allowed, to be read after "it must be"; the range is stated after it.
    default
        A field without one is required.
    """
    extra: Any = {"range": limits}
    return Field(default, description=f"{allowed}, {limits}", json_schema_extra=extra)


def range_of(field: FieldInfo) -> Range | None:
    """Return the range of a field that was declared with `number`; None for any other."""
    extra = field.json_schema_extra
    limits: Any = extra.get("range") if isinstance(extra, dict) else None
    return limits if isinstance(limits, Range) else None


class Table(BaseModel):
    """A table of one of our TOML files: no unknown keys, nothing but numbers within their range."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    @field_validator("*")
    @classmethod
    def _check_range(cls, value: Any, info: ValidationInfo) -> Any:
        field = cls.model_fields[str(info.field_name)]
        limits = range_of(field)
        if limits is not None and any(item not in limits for item in numbers_in(value)):
            raise ValueError(field.description)
        return value


_SHAPES: dict[Any, Any] = {(): Number, (3,): Vector, (3, 3): Vector | Matrix}
"""How files hold numbers of a shape; a matrix may be given by its diagonal."""


def _with_numbers(fields: list[VehicleField], base: type[Table] = Table) -> type[Table]:
    """Return a table like `base` that also has the keys of some fields of `Vehicle`."""
    keys: dict[str, Any] = {}
    for field in fields:
        kind = _SHAPES[field.shape]
        may_be_left_out = field.is_shared or not field.is_required
        for key, limits in field.ranges.items():
            if may_be_left_out:
                keys[key] = (kind | None, number(limits, field.allowed, None))
            else:
                keys[key] = (kind, number(limits, field.allowed))
    return create_model("Numbers", __base__=base, **keys)


class RotorDefaults(_with_numbers(fields_in("rotor", shared=True))):  # type: ignore[misc]
    """``[rotor_defaults]``: what all rotors share unless their own table says otherwise."""


class Rotor(_with_numbers(fields_in("rotor"), RotorDefaults)):  # type: ignore[misc]
    """``[[rotor]]``: one rotor; any key of ``[rotor_defaults]`` may stand here too."""

    servo: str | None = Field(default=None, description="the name of a [[servo]]")
    spin: Literal["ccw", "cw"] = Field(description='"ccw" or "cw", its sense about the axis')


class Named(Table):
    """What has a name."""

    name: str = Field(description="a name")


class Servo(_with_numbers(fields_in("servo"), Named)):  # type: ignore[misc]
    """``[[servo]]``: one servo, which tilts the rotors that name it."""


class Filter(_with_numbers(fields_in("filter"))):  # type: ignore[misc]
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


class VehicleFile(_with_numbers(fields_in(""), Head)):  # type: ignore[misc]
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
