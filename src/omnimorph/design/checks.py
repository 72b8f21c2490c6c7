"""What a `Vehicle` checks about itself, each rule a small method that names what it refuses.

Every refusal is a `VehicleError` whose `key` is the attribute, with the index of the rotor or servo
where there is one: ``vehicle my-drone: rotor_axis[2] is [0.0, 0.0, 0.5], but it must be ...``.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from omnimorph.design.ranges import Range
from omnimorph.errors import VehicleError
from omnimorph.protocols import FloatArray

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")
_WORDS_OF_A_NAME = "at most 100 letters, digits, '.', '_' and '-', the first a letter or digit"
LONGEST_LINE = 1000

UNIT_LENGTH_TOLERANCE = 0.01
"""An axis this far from unit length is still taken for a unit vector, and normalised."""

_ROUNDING_OF_A_UNIT_VECTOR = 1e-15
"""An axis this close is left as it is, so that normalising twice changes nothing."""

_LEAST_MOMENT = 1e-15
"""In kg m²: that of a grain of sand."""

_ROUNDING_OF_AN_INERTIA = 1e-9
"""Relative slack for symmetry and for the triangle inequality, which a thin plate meets exactly."""


class Source(NamedTuple):
    """Where a number comes from.

    Attributes
    ----------
    text : str
        The source, or the reason for an assumption.
    assumed : bool
        True if nobody has published the number and it was chosen.
    """

    text: str
    assumed: bool


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Forbid writing to an array and return it."""
    array.setflags(write=False)
    return array


class Checks:
    """The rules, and the name of the vehicle that a refusal mentions."""

    def __init__(self, vehicle_name: object) -> None:
        self._where = f"vehicle {vehicle_name}" if isinstance(vehicle_name, str) else "vehicle"

    def refuse(self, key: str, value: object, allowed: str) -> VehicleError:
        """Build the error."""
        return VehicleError.at(self._where, key, value, allowed)

    def name(self, key: str, value: object) -> None:
        """Check that a value can serve as a name."""
        if not (isinstance(value, str) and _NAME.fullmatch(value)):
            raise self.refuse(key, value, f"a name made of {_WORDS_OF_A_NAME}")

    def line(self, key: str, value: object) -> None:
        """Check that a value is one line of text."""
        fits = isinstance(value, str) and value.isprintable() and 1 <= len(value) <= LONGEST_LINE
        if not fits:
            raise self.refuse(key, value, f"one line of text, at most {LONGEST_LINE} characters")

    def names(self, key: str, values: object, most: int) -> tuple[str, ...]:
        """Check names that must differ, at most so many."""
        if not isinstance(values, list | tuple):
            raise self.refuse(key, values, "a tuple of names")
        names = tuple(values)
        if len(names) > most:
            raise self.refuse(key, f"{len(names)} names", f"at most {most}")
        for index, name in enumerate(names):
            self.name(f"{key}[{index}]", name)
            if name in names[:index]:
                raise self.refuse(f"{key}[{index}]", name, "different from the other names")
        return names

    def count(self, key: str, value: object, most: int) -> int:
        """Return the number of rows of an array, from 1 to `most`."""
        rows = 0
        if isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim):
            rows = len(value)
        if not 1 <= rows <= most:
            raise self.refuse(key, f"{rows} rows", f"one row for each of 1 to {most} rotors")
        return rows

    def array(
        self, key: str, value: object, shape: tuple[int, ...], limits: Range | None
    ) -> FloatArray:
        """Return a read-only copy in float64, of the right shape, finite and within its range."""
        try:
            array = np.array(value, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            raise self.refuse(key, value, f"numbers in the shape {shape}") from None
        if array.shape != shape:
            raise self.refuse(key, f"of shape {array.shape}", f"of shape {shape}")
        self.each(key, array, np.isfinite(array), "finite")
        if limits is not None:
            inside = (array >= limits.least) & (array <= limits.most)
            inside |= (array == 0.0) & limits.or_zero
            self.each(key, array, inside, f"{limits} in SI")
        return read_only(array)

    def part_of_mass(self, key: str, part: float, mass: float) -> float:
        """Return one number that is below the mass it is part of."""
        if not part < mass:
            raise self.refuse(key, part, f"zero or positive, and below the mass of {mass} kg")
        return abs(part)  # -0.0 is no other number: files leave out zero

    def each(self, key: str, values: FloatArray, good: NDArray[np.bool_], allowed: str) -> None:
        """Refuse the first row of `values` that is not good."""
        if good.all():
            return
        if not good.ndim:
            raise self.refuse(key, values, allowed)
        good_rows = good.reshape(len(good), -1).all(axis=1)
        index = int(np.argmin(good_rows))
        raise self.refuse(f"{key}[{index}]", values[index], allowed)

    def inertia(self, key: str, matrix: FloatArray) -> FloatArray:
        """Check that a matrix is the inertia of a body that can exist.

        The principal moments of any body are Jx = ∫ (y² + z²) dm and so on, hence positive and none
        above the sum of the other two.
        """
        size = np.max(np.abs(matrix))
        slack = _ROUNDING_OF_AN_INERTIA * size
        if np.any(np.abs(matrix - matrix.T) > slack):
            raise self.refuse(key, matrix, "symmetric")
        symmetric = 0.5 * matrix + 0.5 * matrix.T
        low, middle, high = np.linalg.eigvalsh(symmetric)
        if not low > max(np.finfo(np.float64).eps * size, _LEAST_MOMENT):
            allowed = f"positive definite, with principal moments from {_LEAST_MOMENT:g} kg m² on"
            raise self.refuse(key, matrix, allowed)
        if high > low + middle + slack:
            allowed = "such that no principal moment exceeds the sum of the other two"
            raise self.refuse(key, matrix, allowed)
        return read_only(symmetric)

    def servos(self, key: str, value: NDArray[Any], n_servos: int) -> NDArray[np.int64]:
        """Return the index of each rotor's servo as int64."""
        good = (value == np.floor(value)) & (value >= -1.0) & (value < n_servos)
        allowed = f"-1 (no servo) or the index of one of the {n_servos} servos"
        self.each(key, value, good, allowed)
        return read_only(value.astype(np.int64))

    def unit(self, key: str, axes: FloatArray, rows: NDArray[np.bool_] | None = None) -> FloatArray:
        """Return the axes with the chosen rows normalised; refuse those far from unit length."""
        with np.errstate(over="ignore"):
            length = np.linalg.norm(axes, axis=-1)
        chosen = np.full(length.shape, True) if rows is None else rows
        off = np.abs(length - 1.0)
        near = ~chosen | (off <= UNIT_LENGTH_TOLERANCE)
        self.each(key, axes, near, "of unit length, within 1 %")
        divide = chosen & (off > _ROUNDING_OF_A_UNIT_VECTOR)
        return read_only(axes / np.where(divide, length, 1.0)[..., np.newaxis])

    def sources(
        self, key: str, sources: Mapping[str, Source], fields: Collection[str]
    ) -> Mapping[str, Source]:
        """Return a read-only copy; each source belongs to an attribute and says something."""
        for name, source in sources.items():
            if name not in fields:
                raise self.refuse(key, name, "a mapping from names of attributes of the vehicle")
            if not isinstance(source, Source):
                raise self.refuse(f"{key}[{name}]", source, "a Source")
            self.line(f"{key}[{name}].text", source.text)
        return MappingProxyType(dict(sources))
