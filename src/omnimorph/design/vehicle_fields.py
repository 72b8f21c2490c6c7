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
from collections.abc import Mapping
from dataclasses import MISSING
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnimorph.design.ranges import Range
from omnimorph.design.records import Declaration, declared, field_of, quantity

FILTERED = ("position", "velocity", "attitude", "rate")
"""What the state estimator filters, in the order of a field of the filters."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class VehicleField(Declaration):
    """What is declared of one field of `Vehicle`, beside what is declared of any.

    Its `shape` is that of the numbers of the body, or of one rotor, servo or filter: ``(3,)`` for a
    vector, ``(3, 3)`` for a matrix that a file may give by its diagonal, None for names. What has a
    `default` Python may leave out too, and a file is written without it. Without limits, files hold
    it as words.
    """

    shape: tuple[int, ...] | None = ()
    table: str = ""  # where it stands in a file: rotor, servo, filter, or "" for the top
    # In SI, what it is if a file leaves it out, where Python may not; MISSING if neither may.
    in_file: Any = dataclasses.field(default_factory=lambda: MISSING)
    in_core: bool = False  # whether the core is given it
    thrust_limits: Range | None = None  # of a limit of the speed: in N, if given as a thrust

    @property
    def is_optional(self) -> bool:
        """Whether Python may leave it out."""
        return self.default is not MISSING

    @property
    def left_out(self) -> Any:
        """What it is, in SI, if a file leaves it out; `dataclasses.MISSING` if none may."""
        return self.default if self.is_optional else self.in_file

    @property
    def is_required(self) -> bool:
        """Whether its table must give it; what rotors share may stand in either of two."""
        return self.left_out is MISSING and not self.is_shared

    @property
    def short(self) -> str:
        """Its name within its table, which is also the core's: ``angle_min``."""
        return self.word or self.name.removeprefix(f"{self.table}_")

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
    def ranges(self) -> dict[str, Range | None]:
        """Every key by which a file may give its numbers -> their range."""
        ranges: dict[str, Range | None] = dict.fromkeys(self.keys, self.limits)
        if self.thrust_limits:
            ranges[self.thrust_key] = self.thrust_limits
        return ranges

    @property
    def is_shared(self) -> bool:
        """Whether ``[rotor_defaults]`` may hold it for all rotors."""
        return self.table == "rotor" and self.is_number and self.shape == ()

    @functools.cached_property
    def limits_in_SI(self) -> Range | None:
        """The range of each number in SI; None if it has none of its own, as the parts of axes."""
        return None if self.is_direction or not self.limits else self.limits.in_SI(self.unit)

    @property
    def in_python(self) -> Any:
        """The default of the attribute; None for an array, whose length is not known yet."""
        is_array = self.whole_shape(1, 1) != ()
        return None if self.is_optional and is_array else self.default

    def whole_shape(self, n_rotors: int, n_servos: int) -> tuple[int, ...]:
        """Return the shape of the whole attribute."""
        rows = {"rotor": n_rotors, "servo": n_servos, "filter": len(FILTERED)}
        shape = self.shape or ()
        return (rows[self.table], *shape) if self.table else shape

    def filled(self, shape: tuple[int, ...]) -> NDArray[np.float64]:
        """Return the default in the shape of the whole attribute."""
        return np.broadcast_to(np.asarray(self.left_out, dtype=np.float64), shape)


of_body = functools.partial(quantity, of=VehicleField, table="")
of_rotors = functools.partial(quantity, of=VehicleField, table="rotor")
of_servos = functools.partial(quantity, of=VehicleField, table="servo")
of_filters = functools.partial(quantity, of=VehicleField, table="filter")


def as_text(table: str = "", shape: tuple[int, ...] | None = None, **others: Any) -> Any:
    """Declare what files hold as words: names, or (`shape` is given) numbers that stand for them.

    How such a field is read and written is its own affair, in `reading` and `writing`.
    """
    return field_of(VehicleField(table=table, shape=shape, **others))


def fields_of(vehicle: type) -> Mapping[str, VehicleField]:
    """Return what is declared of each field of a class of vehicles, by its name, in their order.

    Raises
    ------
    TypeError
        If a field is not declared with one of the functions above.
    """
    return _fields_of(vehicle)


@functools.cache
def _fields_of(vehicle: Any) -> Mapping[str, VehicleField]:
    found = {}
    for name, field in declared(vehicle).items():
        if isinstance(field, VehicleField):
            found[name] = field
        elif name != "sources":
            ways = "of_body, of_rotors, of_servos, of_filters or as_text"
            raise TypeError(f"{vehicle.__name__}.{name} is not declared with {ways}")
    return found
