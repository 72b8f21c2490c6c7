"""How a field of `Vehicle` is declared: once, where the class lists it.

::

    mass: float = of_body("kg", Range(1e-6, 1e6), "a positive number of kilograms", in_core=True)
    blade_chord: FloatArray = of_rotors("mm", Range(0.0, 1e3), "a number", default=0.0)

From the declaration follow what the vehicle checks, its key in files (``mass_kg``, and
``blade_chord_mm`` in each ``[[rotor]]`` or, for all, in ``[rotor_defaults]``), how it is read and
written, and whether and by which name the core is given it. What has a default may be left out,
and is left out of a file where it is the default, so that a new field changes no file there is.
"""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import MISSING
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnimorph.design.ranges import UNIT_VECTOR, Range
from omnimorph.units import to_SI

__all__ = [
    "VehicleField",
    "fields_of",
    "of_body",
    "of_filters",
    "of_rotors",
    "of_servos",
    "quantity_of",
    "words",
]

FILTERED = ("position", "velocity", "attitude", "rate")
"""What the state estimator filters, in the order of a field of the filters."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class VehicleField:
    """One field of `Vehicle`, as it was declared.

    Attributes
    ----------
    name : str
        The attribute.
    table : str
        Where it stands in a file: ``rotor``, ``servo``, ``filter``, or "" for the top.
    unit : str
        A key of `omnimorph.units.UNITS`, the end of its key in files; "" for none.
    limits : Range or None
        Of each number, in that unit; None for what files hold as words.
    allowed : str
        What is allowed, to be read after "it must be".
    shape : tuple of int or None
        Of the numbers of the body, or of one rotor, servo or filter; None for words.
    default
        In SI, what it is if a file leaves it out; `dataclasses.MISSING` if none may.
    is_optional : bool
        Whether Python may leave it out too; a file is then written without the default.
    in_core : bool
        Whether the core is given it.
    thrust_limits : Range or None
        Of a limit of the speed: in N, if a file gives it as a thrust.
    word : str
        Its name within its table, where it is not the attribute without ``rotor_`` or ``servo_``.
    """

    name: str = ""
    table: str
    unit: str = ""
    limits: Range | None = None
    allowed: str = ""
    shape: tuple[int, ...] | None = ()
    default: Any
    is_optional: bool = False
    in_core: bool = False
    thrust_limits: Range | None = None
    word: str = ""

    @property
    def short(self) -> str:
        """Its name within its table, which is also the core's: ``angle_min``."""
        return self.word or self.name.removeprefix(f"{self.table}_")

    @property
    def key(self) -> str:
        """Its key within its table: ``angle_min_deg``."""
        return f"{self.short}_{self.unit}" if self.unit else self.short

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of its numbers: one for each filter, or its only one."""
        if self.table != "filter":
            return (self.key,)
        return tuple(f"{filtered}_{self.key}" for filtered in FILTERED)

    @property
    def file_key(self) -> str:
        """What messages and ``[sources]`` call it: ``servo.angle_min_deg``."""
        if self.table == "filter":
            return self.table
        return f"{self.table}.{self.key}" if self.table else self.key

    @property
    def thrust_key(self) -> str:
        """Its key if a file gives it as a thrust: ``thrust_min_N``; "" if none can."""
        return self.short.replace("speed", "thrust") + "_N" if self.thrust_limits else ""

    @property
    def ranges(self) -> dict[str, Range]:
        """Every key by which a file may give its numbers -> their range."""
        ranges = dict.fromkeys(self.keys, self.limits) | {self.thrust_key: self.thrust_limits}
        return {key: limits for key, limits in ranges.items() if limits is not None}

    @property
    def is_number_in_files(self) -> bool:
        """Whether files hold it as numbers, not as words."""
        return self.limits is not None

    @property
    def is_required(self) -> bool:
        """Whether a file must give it."""
        return self.default is MISSING

    @property
    def is_direction(self) -> bool:
        """Whether it is made of unit vectors."""
        return self.limits is UNIT_VECTOR

    @property
    def is_shared(self) -> bool:
        """Whether ``[rotor_defaults]`` may hold it for all rotors."""
        return self.table == "rotor" and self.is_number_in_files and self.shape == ()

    @property
    def limits_in_SI(self) -> Range | None:
        """The range of each number in SI; None if it has none of its own."""
        return None if self.limits is None or self.is_direction else self.limits.in_SI(self.unit)

    def whole_shape(self, n_rotors: int, n_servos: int) -> tuple[int, ...]:
        """Return the shape of the whole attribute."""
        rows = {"rotor": n_rotors, "servo": n_servos, "filter": len(FILTERED)}
        shape = self.shape or ()
        return (rows[self.table], *shape) if self.table else shape

    def filled(self, shape: tuple[int, ...]) -> NDArray[np.float64]:
        """Return the default in the shape of the whole attribute."""
        return np.broadcast_to(np.asarray(self.default, dtype=np.float64), shape)

    def in_SI(self, value: Any) -> Any:
        """Return a number of a file, or an array of them, in SI."""
        return to_SI(value, self.unit)


def quantity_of(
    table: str,
    unit: str,
    limits: Range,
    allowed: str,
    *,
    default: Any = MISSING,
    in_file: Any = MISSING,
    **others: Any,
) -> Any:
    """Declare a field that is a number, or several, for the body or for each rotor or servo.

    Parameters
    ----------
    table : str
        Where it stands in a file; `of_body`, `of_rotors`, `of_servos` and `of_filters` name it.
    unit : str
        A key of `omnimorph.units.UNITS`, the end of the field's key in files; "" for none.
    limits : Range
        Of each number, in that unit.
    allowed : str
        What is allowed, to be read after "it must be"; the range is stated after it.
    default
        In SI, for what files and Python may leave out.
    in_file
        The same for what a file may leave out, but not Python.
    **others
        Of `VehicleField`: `shape`, ``(3,)`` for a vector and ``(3, 3)`` for a matrix that a file
        may give by its diagonal; `in_core`; `thrust_limits`; `word`.
    """
    is_optional = default is not MISSING
    left_out = default if is_optional else in_file
    others |= {"unit": unit, "limits": limits, "allowed": allowed}
    return _declared(VehicleField(table=table, default=left_out, is_optional=is_optional, **others))


of_body = functools.partial(quantity_of, "")
of_rotors = functools.partial(quantity_of, "rotor")
of_servos = functools.partial(quantity_of, "servo")
of_filters = functools.partial(quantity_of, "filter")


def words(table: str = "", shape: tuple[int, ...] | None = None, **others: Any) -> Any:
    """Declare what files hold as words: names, or (`shape` is given) numbers that stand for them.

    How such a field is read and written is its own affair, in `reading` and `writing`.
    """
    return _declared(VehicleField(table=table, shape=shape, default=MISSING, **others))


def _declared(field: VehicleField) -> Any:
    default: Any = MISSING
    if field.is_optional:  # an array of it can be made only when its length is known
        default = field.default if field.whole_shape(1, 1) == () else None
    return dataclasses.field(default=default, metadata={"declared": field})


def fields_of(vehicle: type) -> tuple[VehicleField, ...]:
    """Return the declared fields of a class of vehicles, in their order.

    Raises
    ------
    TypeError
        If a field is not declared with one of the functions above.
    """
    return _fields_of(vehicle)


@functools.cache
def _fields_of(vehicle: Any) -> tuple[VehicleField, ...]:
    found = []
    for field in dataclasses.fields(vehicle):
        declared = field.metadata.get("declared")
        if declared is not None:
            found.append(dataclasses.replace(declared, name=field.name))
        elif field.name != "sources":
            ways = "of_body, of_rotors, of_servos, of_filters or words"
            raise TypeError(f"{vehicle.__name__}.{field.name} is not declared with {ways}")
    return tuple(found)
