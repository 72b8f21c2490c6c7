"""Logged columns: what the parts of a flight, or who steps it, had recorded beside a run's own."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Collection, Mapping

from omnimorph.arrays import as_numbers
from omnimorph.errors import InputError
from omnimorph.protocols import FloatArray
from omnimorph.results.columns import Column, Sizes

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,99}")  # what every program that reads netCDF takes
_MOST_DIMS, _LONGEST_UNIT = 3, 40


@dataclasses.dataclass(frozen=True, eq=False)
class LoggedColumn:
    """A column of a run that its own flight logged: numbers over time, and their unit.

    Parameters
    ----------
    values : (K, …) array
        A row for each of the run's, of up to 3 dimensions; kept, not copied, where it holds
        float64. NaN where nothing was logged.
    unit : str
        As it is to be shown, such as ``"N m"``; ``"1"`` for a number without one.

    Raises
    ------
    InputError
        If it does not hold numbers over time, or the unit is no short text.

    Examples
    --------
    >>> import numpy as np
    >>> wind = LoggedColumn(np.zeros((1000, 3)), "m/s")
    >>> wind.values.shape, wind.unit
    ((1000, 3), 'm/s')
    """

    values: FloatArray
    unit: str = "1"

    def __post_init__(self) -> None:
        values = as_numbers(self.values).view()
        if not (1 <= values.ndim <= 1 + _MOST_DIMS and values.size):
            allowed = f"(K, …), with up to {_MOST_DIMS} dimensions after time, none of them empty"
            raise InputError.at("logged column", "shape of the numbers", values.shape, allowed)
        values.flags.writeable = False
        object.__setattr__(self, "values", values)
        unit = self.unit
        is_unit = isinstance(unit, str) and len(unit) <= _LONGEST_UNIT and unit.isprintable()
        if not is_unit or {*unit} & {*"<>&"}:
            allowed = f"up to {_LONGEST_UNIT} characters of text without <, > and &"
            raise InputError.at("logged column", "unit", unit, allowed)


def checked(
    logged: Mapping[str, LoggedColumn], rows: int, taken: Collection[str]
) -> dict[str, LoggedColumn]:
    """Return the logged columns of a run of so many rows, whose other names are `taken`.

    Raises
    ------
    InputError
        If a name is none or taken, or a column does not have a row for each of the run's.
    """
    for name, column in logged.items():
        if not isinstance(name, str) or not _NAME.fullmatch(name):
            allowed = "up to 100 ASCII letters, digits and _, a letter first"
            raise InputError.at("run", "name of a logged column", name, allowed)
        if name in taken:
            allowed = "a name that a run does not have already"
            raise InputError.at("run", "name of a logged column", name, allowed)
        if not isinstance(column, LoggedColumn):
            raise InputError.at("run", f"logged {name}", column, "a LoggedColumn")
        if len(column.values) != rows:
            found = len(column.values)
            raise InputError.at("run", f"number of rows of {name}", found, f"{rows}, the run's")
    return dict(logged)


def logged_sizes(logged: Mapping[str, LoggedColumn]) -> Sizes:
    """Return how long the dimensions of logged columns are; each column has its own."""
    return {
        dim: length
        for column in as_columns(logged)
        for dim, length in zip(column.dims, logged[column.name].values.shape[1:], strict=True)
    }


def as_columns(logged: Mapping[str, LoggedColumn]) -> list[Column]:
    """Return logged columns as they are declared in a run's file."""
    return [
        Column(
            name=name,
            dims=tuple(f"{name}.{k}" for k in range(1, column.values.ndim)),
            units=column.unit,
            long_name=f"{name}, as the flight logged it",
        )
        for name, column in logged.items()
    ]
