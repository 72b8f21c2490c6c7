"""How a recorded column is declared: once, where `Run` lists it.

::

    tilt_actual: FloatArray = column(
        "rad", "servo", long_name="actual tilt", limits=_TILT_LIMITS, read_in="deg"
    )

From the declaration follow the attribute and its documentation, its shape and type, the variable in
a run's file with its units, frame and names, its place in the hash, the memory it takes, the unit,
limits and colour that it is drawn with, and how files are read that were written before it was
recorded: there it is NaN (0, if it holds flags). A new column is declared with the next number as
its `since` (3 is of files with logged columns), which becomes the schema of the files that have it,
so that an older omnimorph asks for a newer one instead of misreading them.
"""

from __future__ import annotations

import dataclasses
import math
import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from omnimorph.results.palette import BLUE, OF_UNITS
from omnimorph.units import from_SI

if TYPE_CHECKING:
    from omnimorph.design.vehicle import Vehicle

Sizes = Mapping[str, int]
"""How long each dimension is, by its name."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Column:
    """What one column of a run is."""

    name: str = ""  # the attribute of `Run`, and the variable in its file
    dims: tuple[str, ...]  # names of the dimensions after time
    units: str
    frame: str = ""  # "" where there is none
    long_name: str
    more: str = ""  # what is to be said beside the long name, in sentences
    flags: Mapping[int, str] = dataclasses.field(default_factory=dict)  # what each number means
    limits: tuple[str, ...] = ()  # the two fields of `Vehicle` that bound it by rotor or servo
    read_in: str = ""  # the unit that people read it in, a key of `UNITS`; "" for `units`
    since: int = 1  # the first schema of files that have it

    @property
    def unit_read(self) -> str:
        """The unit that people read it in, as it is written."""
        return {"": self.units, "deg": "°"}.get(self.read_in, self.read_in)

    @property
    def colour(self) -> str:
        """How it is drawn where nothing else stands beside it."""
        return OF_UNITS.get(self.units, BLUE)

    def as_read(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return numbers of the column in the unit that people read."""
        return from_SI(values, self.read_in)

    def limits_of(self, vehicle: Vehicle) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return its lower and upper limits, by rotor or servo, in the unit that people read."""
        low, high = (self.as_read(getattr(vehicle, name)) for name in self.limits)
        return low, high

    @property
    def dtype(self) -> type:
        """Type of its numbers."""
        return np.int8 if self.flags else np.float64

    def shape(self, rows: int, sizes: Sizes) -> tuple[int, ...]:
        """Return the shape of so many rows."""
        return (rows, *(sizes[dim] for dim in self.dims))

    def bytes_of_a_row(self, sizes: Sizes) -> int:
        """Return how much memory a row takes."""
        return math.prod(self.shape(1, sizes)) * np.dtype(self.dtype).itemsize

    def unrecorded(self, rows: int, sizes: Sizes) -> NDArray[Any]:
        """Return so many rows of what nobody recorded: NaN, or 0 where they are flags."""
        return np.full(self.shape(rows, sizes), 0 if self.flags else np.nan, self.dtype)


def column(units: str, *dims: str, **said: Any) -> Any:
    """Declare a column of a run: see `Column` for what may be said of it."""
    return dataclasses.field(metadata={"column": Column(units=units, dims=dims, **said)})


def columns_of(run: Any) -> tuple[Column, ...]:
    """Return the declared columns of a class of runs, in their order."""
    return tuple(
        dataclasses.replace(field.metadata["column"], name=field.name)
        for field in dataclasses.fields(run)
        if "column" in field.metadata
    )


def sizes_of(vehicle: Vehicle) -> Sizes:
    """Return how long the dimensions of a vehicle's columns are.

    Examples
    --------
    >>> import omnimorph as om
    >>> sizes = sizes_of(om.load_vehicle("omnimorph"))
    >>> sizes["rotor"], sizes["servo"]
    (8, 1)
    """
    sizes = {"axis": 3, "axis_W": 3, "axis_B": 3, "wrench": 6}
    return sizes | {"rotor": vehicle.n_rotors, "servo": vehicle.n_servos}


def described(column: Column) -> str:
    """Return the entry of a column in the documentation of a run's attributes."""
    letters = {"rotor": "n", "servo": "m", "wrench": "6"}
    shape = ", ".join(["K", *(letters.get(dim, "3") for dim in column.dims)])
    kind = [f"({shape}{'' if column.dims else ','}) array{' of int8' if column.flags else ''}"]
    kind += [column.units] if column.units != "1" else []
    kind += [f"in {column.frame}"] if len(column.frame) == 1 else []
    said = f"{column.long_name[0].upper()}{column.long_name[1:]}. {column.more}".rstrip()
    if column.since > 1:
        said += (
            f" {'0' if column.flags else 'NaN'} in a run of a file before schema {column.since}."
        )
    return f"    {column.name} : {', '.join(kind)}\n{_in_lines(said)}\n"


def _in_lines(said: str) -> str:
    return textwrap.fill(said, 100, initial_indent=8 * " ", subsequent_indent=8 * " ")
