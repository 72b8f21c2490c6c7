"""What our TOML files have in common; vehicle files are tested in test_vehicle_files.py."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import pytest
from pydantic import Field, field_validator

from omnimorph.design.documents import check_document
from omnimorph.design.tables import Number, Table
from omnimorph.errors import ScenarioError


class Climb(Table):
    kind: Literal["climb"]
    height_m: Number = Field(description="a height")


class Hold(Table):
    kind: Literal["hold"]
    duration_s: Number = Field(gt=0.0)
    notes: dict[str, str] = Field(default={}, description="a table of texts")

    @field_validator("duration_s")
    @classmethod
    def not_too_long(cls, value: float) -> float:
        if value > 100.0:
            raise ValueError("at most 100 s")
        return value


class Flight(Table):
    segment: list[Annotated[Climb | Hold, Field(discriminator="kind")]] = Field(
        description="tables, written [[segment]]"
    )


@pytest.mark.parametrize(
    ("segment", "key", "end"),
    [
        (3, "segment[0]", "is 3, but it must be tables, written [[segment]]."),
        ({}, "segment[0].kind", "is missing, but it must be one of climb, hold."),
        ({"kind": "jump"}, "segment[0].kind", 'is "jump", but it must be one of climb, hold.'),
        ({"kind": "climb"}, "segment[0].height_m", "is missing, but it must be a height."),
        (
            {"kind": "climb", "heigth_m": 1.0},
            "segment[0].heigth_m",
            "is not a known key; did you mean height_m (allowed here: kind, height_m)?",
        ),
        (
            {"kind": "hold", "duration_s": -1.0},
            "segment[0].duration_s",
            "is -1.0, but it must be greater than 0.",
        ),
        (
            {"kind": "hold", "duration_s": 200.0},
            "segment[0].duration_s",
            "is 200.0, but it must be at most 100 s.",
        ),
        (
            {"kind": "hold", "duration_s": 1.0, "notes": {"a": 1}},
            "segment[0].notes.a",
            "is 1, but it must be a table of texts.",
        ),
    ],
)
def test_refusals_inside_a_list_of_kinds(segment: Any, key: str, end: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        check_document(Flight, {"segment": [segment]}, "f.toml", ScenarioError)
    assert caught.value.key == key
    assert str(caught.value) == f"f.toml: {key} {end}"


def test_what_is_right_passes() -> None:
    flight = check_document(
        Flight, {"segment": [{"kind": "climb", "height_m": 1}]}, "f.toml", ScenarioError
    )
    assert isinstance(flight.segment[0], Climb)
    assert flight.segment[0].height_m == 1.0
