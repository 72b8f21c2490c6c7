"""The vehicle file, table by table, as pydantic models: which keys it has and what each may hold.

The description of a field is what a message says is allowed: "mass_kg is -1.0, but it must be
<description>". Here are names, types and what single numbers must satisfy to be converted; what
makes a vehicle possible is checked by `Vehicle` itself.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationInfo, field_validator
from pydantic.fields import FieldInfo

from omnimorph.design.ranges import OF_VEHICLES, UNIT_VECTOR, Range, numbers_in
from omnimorph.design.vehicle import MOST_ROTORS, MOST_SERVOS

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

POSITIVE = "a positive number"
NOT_NEGATIVE = "zero or a positive number"
NUMBER = "a finite number"


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


class RotorDefaults(Table):
    """``[rotor_defaults]``: what all rotors share unless their own table says otherwise."""

    thrust_coefficient_N_per_Hz2: Number | None = number(
        OF_VEHICLES["thrust_coefficient_N_per_Hz2"], POSITIVE, None
    )
    drag_coefficient_Nm_per_Hz2: Number | None = number(
        OF_VEHICLES["drag_coefficient_Nm_per_Hz2"], POSITIVE, None
    )
    speed_min_Hz: Number | None = number(OF_VEHICLES["speed_min_Hz"], NUMBER, None)
    speed_max_Hz: Number | None = number(OF_VEHICLES["speed_max_Hz"], POSITIVE, None)
    thrust_min_N: Number | None = number(OF_VEHICLES["thrust_min_N"], NUMBER, None)
    thrust_max_N: Number | None = number(OF_VEHICLES["thrust_max_N"], POSITIVE, None)
    dead_band_Hz: Number | None = number(OF_VEHICLES["dead_band_Hz"], NOT_NEGATIVE, None)
    time_constant_up_ms: Number | None = number(
        OF_VEHICLES["time_constant_up_ms"], NOT_NEGATIVE, None
    )
    time_constant_down_ms: Number | None = number(
        OF_VEHICLES["time_constant_down_ms"], NOT_NEGATIVE, None
    )
    spin_inertia_kg_m2: Number | None = number(
        OF_VEHICLES["spin_inertia_kg_m2"], NOT_NEGATIVE, None
    )


class Rotor(RotorDefaults):
    """``[[rotor]]``: one rotor; any key of ``[rotor_defaults]`` may stand here too."""

    position_m: Vector = number(
        OF_VEHICLES["position_m"], "three finite numbers [x, y, z] in metres"
    )
    axis: Vector = number(UNIT_VECTOR, "a unit vector [x, y, z]", [0.0, 0.0, 1.0])
    hinge: Vector | None = number(UNIT_VECTOR, "a unit vector [x, y, z]", None)
    servo: str | None = Field(default=None, description="the name of a [[servo]]")
    spin: Literal["ccw", "cw"] = Field(description='"ccw" or "cw", its sense about the axis')


class Servo(Table):
    """``[[servo]]``: one servo, which tilts the rotors that name it."""

    name: str = Field(description="a name")
    angle_min_deg: Number = number(OF_VEHICLES["angle_min_deg"], NUMBER)
    angle_max_deg: Number = number(OF_VEHICLES["angle_max_deg"], NUMBER)
    rate_max_deg_per_s: Number = number(OF_VEHICLES["rate_max_deg_per_s"], POSITIVE)
    time_constant_ms: Number = number(OF_VEHICLES["time_constant_ms"], NOT_NEGATIVE, 0.0)


class Filter(Table):
    """``[filter]``: cut-offs of the state estimator's filters; 0, or no key, means no filter."""

    position_cutoff_Hz: Number = number(OF_VEHICLES["position_cutoff_Hz"], NOT_NEGATIVE, 0.0)
    velocity_cutoff_Hz: Number = number(OF_VEHICLES["velocity_cutoff_Hz"], NOT_NEGATIVE, 0.0)
    attitude_cutoff_Hz: Number = number(OF_VEHICLES["attitude_cutoff_Hz"], NOT_NEGATIVE, 0.0)
    rate_cutoff_Hz: Number = number(OF_VEHICLES["rate_cutoff_Hz"], NOT_NEGATIVE, 0.0)


class VehicleFile(Table):
    """The whole file."""

    schema_version: int = Field(
        alias="schema",
        ge=1,
        le=1,
        description="1, the version of the format that this release reads",
    )
    name: str = Field(description="a short name")
    title: str = Field(description="one line of text")
    mass_kg: Number = number(OF_VEHICLES["mass_kg"], "a positive number of kilograms")
    tilt_mechanism_mass_kg: Number = number(
        OF_VEHICLES["tilt_mechanism_mass_kg"],
        "zero or a positive number of kilograms, below mass_kg",
        0.0,
    )
    inertia_kg_m2: Vector | Matrix = number(
        OF_VEHICLES["inertia_kg_m2"], "three numbers [Jx, Jy, Jz] or a 3 x 3 matrix, in kg m²"
    )
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
