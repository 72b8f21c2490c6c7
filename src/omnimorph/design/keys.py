"""What the fields of `Vehicle` are called in a vehicle file, and what their numbers may be.

All follows from how the fields are declared (`omnimorph.design.vehicle_fields`).
"""

from __future__ import annotations

from collections.abc import Mapping

from omnimorph.design.ranges import Range
from omnimorph.design.vehicle import Vehicle
from omnimorph.design.vehicle_fields import VehicleField, fields_of

FIELDS: Mapping[str, VehicleField] = fields_of(Vehicle)
"""Attribute of `Vehicle` -> how it was declared."""

FILE_KEYS: Mapping[str, str] = {name: field.file_key for name, field in FIELDS.items()}
"""Attribute of `Vehicle` -> its key in the file, as messages and ``[sources]`` call it."""

AS_THRUST: Mapping[str, str] = {
    field.key: field.thrust_key for field in FIELDS.values() if field.thrust_limits
}
"""Key of a limit given as a speed -> its key when it is given as a thrust."""

OF_VEHICLES: Mapping[str, Range] = {
    key: limits
    for field in FIELDS.values()
    if not field.is_direction
    for key, limits in field.ranges.items()
    if limits
}
"""Key of a vehicle file -> the range of its numbers, in the unit at its end."""


def fields_in(table: str, *, shared: bool = False) -> list[VehicleField]:
    """Return the fields that files hold as numbers in a table, "" for the top.

    Of a rotor these are those of each alone, or those that all rotors may share.
    """
    numbers = [field for field in FIELDS.values() if field.is_number]
    return [field for field in numbers if field.table == table and field.is_shared is shared]
