"""Tables of TOML files as pydantic models, made of what records declare.

The description of a field is what a message says is allowed: "mass_kg is -1.0, but it must be
<description>".
"""

from __future__ import annotations

import dataclasses
import functools
import operator
import typing
from collections.abc import Iterable, Mapping
from types import MappingProxyType
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

from omnimorph.design.ranges import Range
from omnimorph.design.records import Declaration, Record, declared

Number = Annotated[float, Field(allow_inf_nan=False)]
"""A finite number; whole numbers may be written without a point."""

Vector = Annotated[list[Number], Field(min_length=3, max_length=3)]
"""Three finite numbers."""

_LONGEST_LINE = 200


def _one_line(text: str) -> str:
    if not text.isprintable() or len(text) > _LONGEST_LINE:
        raise ValueError(f"one line of text, at most {_LONGEST_LINE} characters")
    return text


Line = Annotated[str, AfterValidator(_one_line)]
"""A text that can be shown anywhere: one line, without characters that steer a terminal."""

_SHAPES: dict[Any, Any] = {
    (): Number,
    (3,): Vector,
    (3, 3): Vector | Annotated[list[Vector], Field(min_length=3, max_length=3)],
}
"""How files hold arrays of a shape; a matrix may be given by its diagonal."""


class Table(BaseModel):
    """A table of one of our TOML files: no unknown keys, nothing that its declaration forbids."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

    @field_validator("*")
    @classmethod
    def _check_declared(cls, value: Any, info: ValidationInfo) -> Any:
        field = cls.model_fields[str(info.field_name)]
        rule = _declaration(field)
        if rule and value not in (None, []) and not rule.allows(value, rule.limits):
            raise ValueError(field.description)
        return value


def _declaration(field: FieldInfo) -> Declaration | None:
    extra = field.json_schema_extra
    found: Any = extra.get("declared") if isinstance(extra, dict) else None
    return found if isinstance(found, Declaration) else None


def range_of(field: FieldInfo) -> Range | None:
    """Return the range of the numbers of a field; None for one without."""
    rule = _declaration(field)
    return rule.limits if rule else None


def _entry(rule: Declaration, default: Any) -> Any:
    extra: Any = {"declared": rule}
    return Field(default, description=rule.allowed_in_file, json_schema_extra=extra)


def number(limits: Range, allowed: str, default: Any = ...) -> Any:
    """Declare a field of a table that is a number, or several, each within a range.

    The range is in the unit at the end of the key; a message states it after what is `allowed`. A
    field without a default is required.
    """
    return _entry(Declaration(limits=limits, allowed=allowed), default)


def table_with(
    fields: Iterable[Declaration],
    base: type[Table] = Table,
    name: str = "Numbers",
    others: Mapping[str, Any] = MappingProxyType({}),
) -> type[Table]:
    """Return a table like `base` that also has the keys of declared fields, and `others`.

    What may be left out is then None.
    """
    keys: dict[str, Any] = dict(others)
    for field in fields:
        kind = _as_lists(field.hint) if field.shape is None else _SHAPES[field.shape]
        kind, default = (kind, ...) if field.is_required else (kind | None, None)
        for key, limits in field.ranges.items():
            keys[key] = kind, _entry(dataclasses.replace(field, limits=limits), default)
    return create_model(name, __base__=base, **keys)


def file_model(record: type[Record], **others: Any) -> type[Table]:
    """Build the pydantic model of a record as it stands in a file.

    The model has one field for each of the record's, with its unit in its key, and `others`, fields
    that stand in the same table; without any, a field ``kind`` distinguishes it from its
    alternatives.
    """
    others = others or {"kind": (Literal[record.kind], ...)}
    return table_with(declared(record).values(), name=record.__name__, others=others)


def _as_lists(annotation: Any) -> Any:
    """Return the annotation with every tuple turned into the list that TOML has instead."""
    arguments = typing.get_args(annotation)
    if typing.get_origin(annotation) is tuple:
        return Annotated[list[_as_lists(arguments[0])], Field(min_length=1)]  # type: ignore[misc]
    if arguments and typing.get_origin(annotation) is not Literal:
        return functools.reduce(operator.or_, [_as_lists(argument) for argument in arguments])
    return annotation
