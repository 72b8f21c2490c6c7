"""Records whose fields say what they may be, and how they stand in a file.

One declaration serves three doors: Python (the record checks itself), TOML (a pydantic model is
made from it, with the unit at the end of each key) and provenance (the record written out again)::

    @dataclass(frozen=True, kw_only=True)
    class RotorLag(Record):
        '''...'''
        kind = "rotor-lag"
        up: float | None = quantity("ms", Range(0.0, 1e6), "a number", default=None)

    RotorLag(up=0.020)                       # SI in Python
    {"kind": "rotor-lag", "up_ms": 20.0}     # its unit in files
"""

from __future__ import annotations

import dataclasses
import functools
import operator
import typing
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from omnimorph.design.ranges import Range
from omnimorph.errors import ScenarioError
from omnimorph.units import from_SI, to_SI

if TYPE_CHECKING:
    from pydantic import BaseModel

__all__ = ["Record", "check_record", "choice", "depths", "file_model", "quantity"]


def quantity(
    unit: str,
    limits: Range,
    allowed: str,
    *,
    default: Any = dataclasses.MISSING,
    length: int | None = None,
) -> Any:
    """Declare a field that is a number, or several, with a unit in files.

    Parameters
    ----------
    unit : str
        A key of `omnimorph.units.UNITS`, the end of the field's key in files; "" for none.
    limits : Range
        Of each number, in that unit.
    allowed : str
        What is allowed, to be read after "it must be"; the range is stated after it.
    default
        In SI; a field without one is required.
    length : int, optional
        How many numbers a sequence must have; 0 for a field that is a single number.
    """
    in_SI = limits.in_SI(unit)
    rule = {
        "unit": unit,
        "limits": in_SI,
        "length": length,
        "allowed": f"{allowed}, {in_SI}" + (" in SI" if unit else ""),
        "allowed_in_file": f"{allowed}, {limits}",
    }
    return dataclasses.field(default=default, metadata=rule)


def choice(values: Sequence[Any], allowed: str) -> Any:
    """Declare a required field that is one of a few texts or whole numbers, the same in files.

    Parameters
    ----------
    values : sequence
        All it may be, of one type: ``("left", "right")`` or ``range(3, 100, 2)``.
    allowed : str
        The same, to be read after "it must be".
    """
    rule = {"values": values, "unit": "", "allowed": allowed, "allowed_in_file": allowed}
    return dataclasses.field(metadata=rule)


def check_record(place: str, name: str, value: object, kind: type) -> None:
    """Refuse an argument that is not a record of a kind; `place` and `name` say which it is."""
    if not isinstance(value, kind):
        raise ScenarioError.at(place, name, value, f"of the kind {kind.__name__}")


class Record:
    """Base of the frozen dataclasses declared with `quantity` and `choice`.

    Attributes
    ----------
    kind : str
        What the record is called in files.

    Raises
    ------
    ScenarioError
        When a value is not allowed: the record, the field, the value and what is allowed.
    """

    kind: ClassVar[str]

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if isinstance(value, list | tuple) or hasattr(value, "tolist"):
                value = _plain(value)
                object.__setattr__(self, field.name, value)
            left_out = value is None and field.default is None
            if field.metadata and not left_out:
                too_deep = _depth_of(value) > depths(type(self))[field.name]
                if too_deep or not _is_allowed(value, field.metadata):
                    raise ScenarioError.at(self.kind, field.name, value, field.metadata["allowed"])
            if isinstance(field.default, bool | str) and type(value) is not type(field.default):
                allowed = "true or false" if isinstance(field.default, bool) else "text"
                raise ScenarioError.at(self.kind, field.name, value, allowed)

    @classmethod
    def from_file(cls, content: BaseModel) -> Self:
        """Build the record from the content of a file that `file_model` has checked."""
        values = {}
        for field in dataclasses.fields(cls):  # type: ignore[arg-type]
            value = getattr(content, _key(field))
            if value is not None:
                values[field.name] = _convert(_plain(value), field.metadata.get("unit", ""), to_SI)
        return cls(**values)

    def as_file(self) -> dict[str, Any]:
        """Return the record as a file would hold it: ``kind``, then the keys with their units."""
        content: dict[str, Any] = {"kind": self.kind}
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if value is not None:
                content[_key(field)] = _convert(value, field.metadata.get("unit", ""), from_SI)
        return content


def file_model(record: type[Record], **others: Any) -> type[BaseModel]:
    """Build the pydantic model of a record as it stands in a file.

    The model has one field for each of the record's, named with its unit, and `others`, fields that
    stand in the same table; without any, a field ``kind`` distinguishes it from its alternatives.
    """
    from pydantic import ConfigDict, Field, create_model

    hints = typing.get_type_hints(record)
    fields: dict[str, Any] = others or {"kind": (Literal[record.kind], ...)}
    for field in dataclasses.fields(record):  # type: ignore[arg-type]
        missing = field.default is dataclasses.MISSING
        described = Field(
            ... if missing else None, description=field.metadata.get("allowed_in_file")
        )
        annotation = _as_lists(hints[field.name])
        annotation = annotation if missing else annotation | None
        fields[_key(field)] = (annotation, described)
    settings = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)
    checks = _validators(record)
    return create_model(record.__name__, __config__=settings, __validators__=checks, **fields)


def depths(record: type) -> Mapping[str, int]:
    """Return how deep the rows of each field may be: 0 for one number, 1 for a row of them."""
    return _depths(record)


@functools.cache
def _depths(record: Any) -> Mapping[str, int]:
    return {name: _depth(hint) for name, hint in typing.get_type_hints(record).items()}


def _depth(annotation: Any) -> int:
    inside = max(map(_depth, typing.get_args(annotation)), default=0)
    return inside + (typing.get_origin(annotation) is tuple)


def _depth_of(value: Any) -> int:
    return 1 + max(map(_depth_of, value), default=0) if isinstance(value, tuple) else 0


def _as_lists(annotation: Any) -> Any:
    """Return the annotation with every tuple turned into the list that TOML has instead."""
    arguments = typing.get_args(annotation)
    if typing.get_origin(annotation) is tuple:
        return list[_as_lists(arguments[0])]  # type: ignore[misc]
    if arguments and typing.get_origin(annotation) is not Literal:
        return functools.reduce(operator.or_, [_as_lists(argument) for argument in arguments])
    return annotation


def _validators(record: type[Record]) -> dict[str, Any]:
    from pydantic import field_validator

    validators: dict[str, Any] = {}
    for field in dataclasses.fields(record):  # type: ignore[arg-type]
        if field.metadata:
            check = _checker(dict(field.metadata))
            validators[f"_check_{field.name}"] = field_validator(_key(field), mode="after")(check)
    return validators


def _checker(rule: Mapping[str, Any]) -> Any:
    def check(cls: type, value: Any) -> Any:
        if value is None:
            return value
        if not _is_allowed(_convert(_plain(value), rule["unit"], to_SI), rule):
            raise ValueError(rule["allowed_in_file"])
        return value

    return check


def _key(field: dataclasses.Field[Any]) -> str:
    unit = field.metadata.get("unit", "")
    return f"{field.name}_{unit}" if unit else field.name


def _is_allowed(value: Any, rule: Mapping[str, Any]) -> bool:
    if "values" in rule:  # of the same type, because 3.0 == 3 and True == 1
        return type(value) is type(rule["values"][0]) and value in rule["values"]
    if isinstance(value, tuple):
        if rule["length"] is not None and len(value) != rule["length"]:
            return False
        scalar = {**rule, "length": None}
        return len(value) > 0 and all(_is_allowed(item, scalar) for item in value)
    return value in rule["limits"]


def _convert(value: Any, unit: str, door: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(_convert(item, unit, door) for item in value)
    if isinstance(value, bool | str) or not unit:
        return value
    return door(value, unit)


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        value = value.tolist()
    return tuple(_plain(item) for item in value) if isinstance(value, list | tuple) else value
