"""The vehicle file, table by table, as pydantic models: which keys it has and what each may hold.

The description of a field is what a message says is allowed: "mass_kg is -1.0, but it must be
<description>". Here are names, types and what single numbers must satisfy to be converted; what
makes a vehicle possible is checked by `Vehicle` itself.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from omnimorph.design.vehicle import MOST_ROTORS, MOST_SERVOS

__all__ = [
    "Filter",
    "Matrix",
    "Number",
    "Rotor",
    "RotorDefaults",
    "Servo",
    "Table",
    "Vector",
    "VehicleFile",
]

Number = Annotated[float, Field(allow_inf_nan=False)]
"""A finite number; whole numbers may be written without a point."""

Vector = Annotated[list[Number], Field(min_length=3, max_length=3)]
"""Three finite numbers."""

Matrix = Annotated[list[Vector], Field(min_length=3, max_length=3)]
"""Three rows of three finite numbers."""

POSITIVE = "a positive number"
NOT_NEGATIVE = "zero or a positive number"
NUMBER = "a finite number"


class Table(BaseModel):
    """A table of one of our TOML files: no unknown keys, no text in place of numbers."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class RotorDefaults(Table):
    """``[rotor_defaults]``: what all rotors share unless their own table says otherwise."""

    thrust_coefficient_N_per_Hz2: Number | None = Field(default=None, gt=0.0, description=POSITIVE)
    drag_coefficient_Nm_per_Hz2: Number | None = Field(default=None, gt=0.0, description=POSITIVE)
    speed_min_Hz: Number | None = Field(default=None, description=NUMBER)
    speed_max_Hz: Number | None = Field(default=None, description=NUMBER)
    thrust_min_N: Number | None = Field(default=None, description=NUMBER)
    thrust_max_N: Number | None = Field(default=None, description=NUMBER)
    dead_band_Hz: Number | None = Field(default=None, description=NOT_NEGATIVE)
    time_constant_up_ms: Number | None = Field(default=None, description=NOT_NEGATIVE)
    time_constant_down_ms: Number | None = Field(default=None, description=NOT_NEGATIVE)
    spin_inertia_kg_m2: Number | None = Field(default=None, description=NOT_NEGATIVE)


class Rotor(RotorDefaults):
    """``[[rotor]]``: one rotor; any key of ``[rotor_defaults]`` may stand here too."""

    position_m: Vector = Field(description="three finite numbers [x, y, z] in metres")
    axis: Vector = Field(default=[0.0, 0.0, 1.0], description="a unit vector [x, y, z]")
    hinge: Vector | None = Field(default=None, description="a unit vector [x, y, z]")
    servo: str | None = Field(default=None, description="the name of a [[servo]]")
    spin: Literal["ccw", "cw"] = Field(description='"ccw" or "cw", its sense about the axis')


class Servo(Table):
    """``[[servo]]``: one servo, which tilts the rotors that name it."""

    name: str = Field(description="a name")
    angle_min_deg: Number = Field(description=NUMBER)
    angle_max_deg: Number = Field(description=NUMBER)
    rate_max_deg_per_s: Number = Field(description=POSITIVE)
    time_constant_ms: Number = Field(default=0.0, description=NOT_NEGATIVE)


class Filter(Table):
    """``[filter]``: cut-offs of the state estimator's filters; 0, or no key, means no filter."""

    position_cutoff_Hz: Number = Field(default=0.0, description=NOT_NEGATIVE)
    velocity_cutoff_Hz: Number = Field(default=0.0, description=NOT_NEGATIVE)
    attitude_cutoff_Hz: Number = Field(default=0.0, description=NOT_NEGATIVE)
    rate_cutoff_Hz: Number = Field(default=0.0, description=NOT_NEGATIVE)


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
    mass_kg: Number = Field(description="a positive number of kilograms")
    tilt_mechanism_mass_kg: Number = Field(
        default=0.0, description="zero or a positive number of kilograms, below mass_kg"
    )
    inertia_kg_m2: Vector | Matrix = Field(
        description="three numbers [Jx, Jy, Jz] or a 3 x 3 matrix, in kg m²"
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
