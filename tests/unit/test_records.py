"""Records that check themselves, stand in files with their units, and come back the same."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError, dataclass
from typing import Any, ClassVar, Literal

import numpy as np
import pytest
from pydantic import ValidationError

from omnimorph.design.ranges import Range
from omnimorph.design.records import Record, choice, declared, quantity, values_of
from omnimorph.design.tables import file_model, table_with
from omnimorph.errors import ScenarioError
from omnimorph.reference.segments import Segment

ANY = Range(-1e6, 1e6)


@dataclass(frozen=True, kw_only=True)
class Spring(Record):
    """A record with every kind of field."""

    kind: ClassVar[str] = "spring"
    length: float = quantity("mm", Range(1e-3, 1e6), "a positive length")
    angle: float | None = quantity("deg", Range(90.0, 1e3), "at least a right angle", default=None)
    push: tuple[float, ...] = quantity("N", ANY, "three numbers", length=3, default=(0.0, 0.0, 1.0))
    rate: float | tuple[float, ...] = quantity("Hz", ANY, "one or more numbers", default=1.0)
    table: tuple[tuple[float, ...], ...] | None = quantity(
        "m", ANY, "rows of numbers", default=None
    )
    share: float = quantity("", ANY, "a number", default=0.5)
    side: Literal["left", "right"] = "left"
    heavy: bool = False


def as_file_again(record: Spring) -> Spring:
    """Return what a file with the record in it is read as."""
    content = {key: as_lists(value) for key, value in record.as_file().items()}
    return Spring.from_file(file_model(Spring).model_validate(content))


def as_lists(value: Any) -> Any:
    """Return a value with the lists that TOML has in place of tuples."""
    return [as_lists(item) for item in value] if isinstance(value, tuple) else value


def test_keys_in_files_end_in_their_unit() -> None:
    content = Spring(length=0.02, angle=math.pi, rate=(4.0 * math.pi, 0.0)).as_file()
    assert content == {
        "kind": "spring",
        "length_mm": 20.0,
        "angle_deg": 180.0,
        "push_N": (0.0, 0.0, 1.0),
        "rate_Hz": (2.0, 0.0),
        "share": 0.5,
        "side": "left",
        "heavy": False,
    }


@pytest.mark.parametrize(
    "record",
    [
        Spring(length=0.02),
        Spring(length=0.5, angle=2.0, push=(1.0, 2.0, 3.0), rate=3.0, share=0.0),
        Spring(length=0.5, table=((1.0, 2.0), (3.0,)), side="right", heavy=True),
    ],
)
def test_a_record_comes_back_from_its_file(record: Spring) -> None:
    again = as_file_again(record)
    assert (again.side, again.heavy, again.table) == (record.side, record.heavy, record.table)
    assert again.length == pytest.approx(record.length, rel=1e-15)
    assert again.rate == pytest.approx(record.rate, rel=1e-15)
    assert again.angle == (None if record.angle is None else pytest.approx(record.angle))


def test_a_file_may_leave_out_what_has_a_default_and_write_whole_numbers() -> None:
    spring = Spring.from_file(file_model(Spring).model_validate({"kind": "spring", "length_mm": 5}))
    assert spring == Spring(length=0.005)
    model = file_model(Spring).model_validate(
        {"kind": "spring", "length_mm": 5, "push_N": [1, 2, 3], "table_m": [[1], [2, 3]]}
    )
    assert Spring.from_file(model).push == (1.0, 2.0, 3.0)
    assert Spring.from_file(model).table == ((1.0,), (2.0, 3.0))


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({"length": 0.0}, "length"),
        ({"length": -1.0}, "length"),
        ({"length": math.nan}, "length"),
        ({"length": math.inf}, "length"),
        ({"length": "1"}, "length"),
        ({"length": True}, "length"),
        ({"length": [1.0]}, "length"),
        ({"rate": [[1.0]]}, "rate"),
        ({"table": [[[1.0]]]}, "table"),
        ({"angle": 1.0}, "angle"),
        ({"push": (1.0, 2.0)}, "push"),
        ({"push": (1.0, 2.0, 3.0, 4.0)}, "push"),
        ({"push": (1.0, 2.0, math.nan)}, "push"),
        ({"push": ()}, "push"),
        ({"push": "xyz"}, "push"),
        ({"rate": ()}, "rate"),
        ({"table": ((1.0,), (math.inf,))}, "table"),
        ({"table": ((1.0,), ())}, "table"),
        ({"share": [0.5, "a"]}, "share"),
    ],
)
def test_a_record_checks_itself(values: dict[str, Any], field: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        Spring(**{"length": 1.0} | values)
    error = caught.value
    assert error.key == field
    assert str(error).startswith(f"spring: {field} is ")
    assert "but it must be" in str(error)
    assert "\n" not in str(error)


@pytest.mark.parametrize(
    "content",
    [
        {},
        {"kind": "spring"},
        {"kind": "coil", "length_mm": 1.0},
        {"kind": "spring", "length_mm": 0.0},
        {"kind": "spring", "length_mm": "1"},
        {"kind": "spring", "length_mm": True},
        {"kind": "spring", "length_mm": math.nan},
        {"kind": "spring", "length_m": 1.0},
        {"kind": "spring", "length_mm": 1.0, "angle_deg": 89.0},
        {"kind": "spring", "length_mm": 1.0, "push_N": [1.0, 2.0]},
        {"kind": "spring", "length_mm": 1.0, "push_N": 1.0},
        {"kind": "spring", "length_mm": 1.0, "rate_Hz": []},
        {"kind": "spring", "length_mm": 1.0, "table_m": [[1.0], [math.inf]]},
        {"kind": "spring", "length_mm": 1.0, "side": "middle"},
        {"kind": "spring", "length_mm": 1.0, "heavy": 1},
    ],
)
def test_a_file_is_checked_in_its_own_units(content: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        file_model(Spring).model_validate(content)


def test_a_limit_is_the_same_in_both_doors() -> None:
    at_the_limit = {"kind": "spring", "length_mm": 1.0, "angle_deg": 90.0}
    spring = Spring.from_file(file_model(Spring).model_validate(at_the_limit))
    assert spring.angle == math.pi / 2
    assert Spring(length=1e-3, angle=math.pi / 2) == spring


def test_other_fields_may_stand_in_the_same_table() -> None:
    model = file_model(Spring, partner=(str, ...))
    content = model.model_validate({"length_mm": 1.0, "partner": "damper"})
    assert Spring.from_file(content) == Spring(length=1e-3)
    with pytest.raises(ValidationError):
        model.model_validate({"length_mm": 1.0})


def test_arrays_and_lists_become_tuples() -> None:
    spring = Spring(
        length=np.float64(0.1),
        push=np.array([1.0, 2.0, 3.0]),  # type: ignore[arg-type]
        rate=[1.0, 2.0],  # type: ignore[arg-type]
    )
    assert spring.push == (1.0, 2.0, 3.0)
    assert spring.rate == (1.0, 2.0)
    assert isinstance(spring.length, float)
    assert hash(spring) == hash(Spring(length=0.1, push=(1.0, 2.0, 3.0), rate=(1.0, 2.0)))


def test_records_are_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        Spring(length=1.0).length = 2.0  # type: ignore[misc]


@dataclass(frozen=True, kw_only=True)
class Gear(Record):
    """A record with choices."""

    kind: ClassVar[str] = "gear"
    side: Literal["left", "right"] = choice(("left", "right"), '"left" or "right"')
    teeth: int = choice(range(3, 100, 2), "an odd whole number from 3 to 99")


def test_a_choice_is_the_same_in_a_file() -> None:
    gear = Gear(side="left", teeth=np.int64(99))  # type: ignore[arg-type]
    assert gear.as_file() == {"kind": "gear", "side": "left", "teeth": 99}
    assert Gear.from_file(file_model(Gear).model_validate(gear.as_file())) == gear


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *(("side", value) for value in ("middle", 3, None)),
        *(("teeth", value) for value in (4, 1, 101, 5.0, True, "5", [5], None)),
    ],
)
def test_a_choice_refuses_what_is_not_in_it(field: str, value: Any) -> None:
    content = {"side": "right", "teeth": 5, field: value}
    with pytest.raises(ScenarioError) as caught:
        Gear(**content)
    assert caught.value.key == field
    with pytest.raises(ValidationError):
        file_model(Gear).model_validate({"kind": "gear"} | content)


def test_a_class_with_arrays_has_a_table_too() -> None:
    table = table_with(declared(Segment).values())
    content = table.model_validate(
        {"duration_s": 2, "move_m": [1, 2.0, 3.0], "rotation_angle_deg": 90.0}
    )
    values = {"duration": 2.0, "move_W": (1.0, 2.0, 3.0), "rotation_angle": math.pi / 2}
    assert values_of(Segment, content) == values
    assert Segment(**values_of(Segment, content)).as_file()["move_m"] == [1.0, 2.0, 3.0]
    for wrong in ({}, {"move_m": [1.0, 2.0]}, {"move_m": [1e9, 0.0, 0.0]}, {"move_W": [0.0] * 3}):
        with pytest.raises(ValidationError):
            table.model_validate({"duration_s": 2.0} | wrong if wrong else wrong)
