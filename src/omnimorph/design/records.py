"""Records whose fields say what they may be, and how they stand in a file.

One declaration serves every door: Python (the record checks itself), TOML (a pydantic model is
made of it, with the unit at the end of each key) and provenance (the record written out again)::

    @dataclass(frozen=True, kw_only=True)
    class RotorLag(Record):
        '''...'''
        kind = "rotor-lag"
        up: float | None = quantity("ms", Range(0.0, 1e6), "a number", default=None)

    RotorLag(up=0.020)                       # SI in Python
    {"kind": "rotor-lag", "up_ms": 20.0}     # its unit in files

`Vehicle` declares its fields in the same way, with `omnimorph.design.vehicle_fields`, and so does
whatever else has arrays: of fields with a `shape` the class itself makes arrays, and checks them.
"""

from __future__ import annotations

import dataclasses
import functools
import typing
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import MISSING
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

from omnimorph.design.ranges import UNIT_VECTOR, Range
from omnimorph.errors import ScenarioError
from omnimorph.units import from_SI, to_SI

if TYPE_CHECKING:
    from pydantic import BaseModel

Kind = TypeVar("Kind")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Declaration:
    """What is declared of one field of a record."""

    name: str = ""  # the attribute
    unit: str = ""  # a key of `omnimorph.units.UNITS`, the end of its key in files
    limits: Range | None = None  # of each number, in that unit; None for what is no number
    values: Sequence[Any] = ()  # all it may be, if it is one of a few texts or whole numbers
    allowed: str = ""  # to be read after "it must be"; the range is stated after it
    length: int | None = None  # of a sequence of numbers; 0 for a single one
    shape: tuple[int, ...] | None = None  # of an array; None where the hint says what it holds
    # In SI, what it is if a file leaves it out; MISSING if none may (a plain default would be none)
    default: Any = dataclasses.field(default_factory=lambda: MISSING)
    word: str = ""  # its name in files without the unit, where it is not the attribute
    hint: Any = None  # the type that the class gives it

    @functools.cached_property
    def depth(self) -> int:
        """How deep its rows may be: 0 for one number, 1 for a row of them."""
        return _depth(self.hint)

    @property
    def short(self) -> str:
        """Its name in files, without the unit."""
        return self.word or self.name

    @property
    def key(self) -> str:
        """Its key within its table: ``angle_min_deg``."""
        return f"{self.short}_{self.unit}" if self.unit else self.short

    @property
    def is_number(self) -> bool:
        """Whether files hold it as a number or several within a range."""
        return self.limits is not None

    @property
    def is_count(self) -> bool:
        """Whether it is one of a few whole numbers."""
        return len(self.values) > 0 and isinstance(self.values[0], int)

    @property
    def is_direction(self) -> bool:
        """Whether it is made of unit vectors."""
        return self.limits is UNIT_VECTOR

    @property
    def is_required(self) -> bool:
        """Whether a file must give it."""
        return self.default is MISSING

    @property
    def in_python(self) -> Any:
        """The default of the attribute in Python."""
        return self.default

    @property
    def ranges(self) -> dict[str, Range | None]:
        """Every key by which its table may give it -> the range of its numbers."""
        return {self.key: self.limits}

    @functools.cached_property
    def limits_in_SI(self) -> Range | None:
        """The range of each number in SI; None if it has none."""
        return self.limits and self.limits.in_SI(self.unit)

    @functools.cached_property
    def allowed_in_file(self) -> str | None:
        """What is allowed in a file, to be read after "it must be"; None where anything is."""
        return f"{self.allowed}, {self.limits}" if self.limits else self.allowed or None

    @functools.cached_property
    def allowed_in_SI(self) -> str:
        """The same in Python."""
        said = f"{self.allowed}, {self.limits_in_SI}" if self.limits else self.allowed
        return f"{said} in SI" if self.limits and self.unit else said

    def allows(self, value: Any, limits: Range | None) -> bool:
        """Return whether a value is allowed; `limits` are those in its unit."""
        if self.values:  # of the same type, because 3.0 == 3 and True == 1
            return type(value) is type(self.values[0]) and value in self.values
        several = isinstance(value, tuple | list)
        if several and self.length not in (None, len(value)):
            return False
        return limits is None or _each_in(value, limits)

    def in_SI(self, value: Any) -> Any:
        """Return a number of a file, or rows or an array of them, in SI."""
        return _convert(value, self.unit, to_SI)

    def as_in_file(self, value: Any) -> Any:
        """Return numbers in SI as a file would hold them."""
        return _convert(value, self.unit, from_SI)


def quantity(
    unit: str,
    limits: Range,
    allowed: str,
    *,
    of: type[Declaration] = Declaration,
    **others: Any,
) -> Any:
    """Declare a field that is a number, or several, with a unit in files: see `Declaration`.

    A field without a `default` is required; `of` is the class that keeps the declaration.
    """
    return field_of(of(unit=unit, limits=limits, allowed=allowed, **others))


def choice(values: Sequence[Any], allowed: str, *, default: Any = MISSING) -> Any:
    """Declare a field that is one of a few texts or whole numbers, the same in files.

    They are of one type, ``("left", "right")`` or ``range(3, 100, 2)``; `allowed` says the same
    after "it must be". A field without a default is required.
    """
    return field_of(Declaration(values=values, allowed=allowed, default=default))


def field_of(declaration: Declaration) -> Any:
    """Return the field of a dataclass with what is declared of it."""
    metadata = {"declared": declaration}
    return dataclasses.field(default=declaration.in_python, metadata=metadata)


def declared(record: type) -> Mapping[str, Declaration]:
    """Return what is declared of each field of a class, by its name, in their order.

    A field that was not declared with one of the functions above has neither unit nor range.
    """
    return _declared(record)


@functools.cache
def _declared(record: Any) -> Mapping[str, Declaration]:
    found, hints = {}, typing.get_type_hints(record)
    for field in dataclasses.fields(record):
        rule = field.metadata.get("declared") or Declaration(default=field.default)
        found[field.name] = dataclasses.replace(rule, name=field.name, hint=hints[field.name])
    return found


def values_of(record: type, content: BaseModel, without: Iterable[str] = ()) -> dict[str, Any]:
    """Return the values, in SI, of a checked table of a file, by the names of a class's fields.

    What the table leaves out is left out, and the fields named in `without`.
    """
    fields = {name: field for name, field in declared(record).items() if name not in without}
    given = {name: getattr(content, field.key) for name, field in fields.items()}
    return {
        name: fields[name].in_SI(_plain(value))
        for name, value in given.items()
        if value is not None
    }


def record_of(place: str, name: str, value: object, kind: type[Kind]) -> Kind:
    """Return a record that an argument is, or holds under the argument's name.

    Raises
    ------
    ScenarioError
        If it neither is one nor holds one; `place` and `name` say which argument it is.
    """
    record = value if isinstance(value, kind) else getattr(value, name, None)
    if not isinstance(record, kind):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        allowed = f"{article} {kind.__name__}, or what has one as its {name}"
        raise ScenarioError.at(place, name, value, allowed)
    return record


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
        for name, field in declared(type(self)).items():
            value = getattr(self, name)
            if isinstance(value, list | tuple) or hasattr(value, "tolist"):
                value = _plain(value)
                object.__setattr__(self, name, value)
            if value is None and field.default is None:
                continue
            if field.is_number or field.values:
                if _depth_of(value) > field.depth or not field.allows(value, field.limits_in_SI):
                    raise ScenarioError.at(self.kind, name, value, field.allowed_in_SI)
            elif isinstance(field.default, bool | str) and type(value) is not type(field.default):
                allowed = "true or false" if isinstance(field.default, bool) else "text"
                raise ScenarioError.at(self.kind, name, value, allowed)

    @classmethod
    def from_file(cls, content: BaseModel, **parts: Any) -> Self:
        """Build the record from a checked table of a file, and from `parts` that it lacks.

        The table's model is made by `omnimorph.design.tables.file_model`.
        """
        return cls(**values_of(cls, content, parts), **parts)

    def as_file(self) -> dict[str, Any]:
        """Return the record as a file would hold it: ``kind``, then the keys with their units."""
        content: dict[str, Any] = {"kind": self.kind}
        for name, field in declared(type(self)).items():
            value = getattr(self, name)
            if value is not None:
                content[field.key] = field.as_in_file(value)
        return content


def _depth(hint: Any) -> int:
    inside = max(map(_depth, typing.get_args(hint)), default=0)
    return inside + (typing.get_origin(hint) is tuple)


def _depth_of(value: Any) -> int:
    return 1 + max(map(_depth_of, value), default=0) if isinstance(value, tuple) else 0


def _each_in(value: Any, limits: Range) -> bool:
    """Return whether a value is a number within limits, or rows of them, none of them empty."""
    if not isinstance(value, tuple | list):
        return value in limits
    return len(value) > 0 and all(_each_in(item, limits) for item in value)


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
