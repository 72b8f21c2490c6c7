"""Write a `Vehicle` as the text of a vehicle file.

Numbers are written so that reading them gives back the same numbers: in full (`repr`), and, where a
unit is converted, with the number in that unit that converts to exactly the value in memory. Such a
number exists for every value that came from a file, so a loaded vehicle is stored without any
change; for other values it may be missing, and the nearest is taken, at most one unit in the last
place (1 part in 4e15) away.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from omnimorph.design.keys import FILE_KEYS, fields_in
from omnimorph.design.vehicle import Vehicle
from omnimorph.design.vehicle_fields import VehicleField
from omnimorph.units import UNITS, from_SI, to_SI

_written_before: WeakKeyDictionary[Vehicle, str] = WeakKeyDictionary()


def vehicle_text(vehicle: Vehicle) -> str:
    """Return a vehicle as TOML that `omnimorph.design.parse_vehicle` reads.

    Numbers that all rotors share stand in ``[rotor_defaults]``. Limits are written as speeds, also
    where they were read as thrusts. Reading it gives an equal vehicle, as the head of this module
    explains.
    """
    text = _written_before.get(vehicle)  # a vehicle never changes, and every run holds its text
    if text is None:
        text = _written_before[vehicle] = "\n".join(_lines(vehicle)) + "\n"
    return text


def _lines(vehicle: Vehicle) -> Iterator[str]:
    yield "schema = 1"
    yield f"name = {_quoted(vehicle.name)}"
    yield f"title = {_quoted(vehicle.title)}"
    yield from _entries(vehicle, fields_in(""))
    yield from ("", "[rotor_defaults]")
    numbers = fields_in("rotor", shared=True)
    shared = [field for field in numbers if len(set(getattr(vehicle, field.name).tolist())) == 1]
    yield from _entries(vehicle, shared, 0)
    own = [field for field in numbers if field not in shared]
    for index in range(vehicle.n_rotors):
        yield from ("", "[[rotor]]")
        yield from _geometry(vehicle, index)
        yield from _entries(vehicle, own, index)
    for index, servo in enumerate(vehicle.servo_name):
        yield from ("", "[[servo]]", f"name = {_quoted(servo)}")
        yield from _entries(vehicle, fields_in("servo"), index)
    yield from ("", "[filter]")
    yield from _entries(vehicle, fields_in("filter"))
    for table, assumed in (("sources", False), ("assumed", True)):
        yield from ("", f"[{table}]")
        for name, source in vehicle.sources.items():
            if source.assumed is assumed:
                yield f"{_quoted(FILE_KEYS[name])} = {_quoted(source.text)}"


def _geometry(vehicle: Vehicle, index: int) -> Iterator[str]:
    """Yield what a rotor never shares."""
    servo = int(vehicle.rotor_servo[index])
    fields = fields_in("rotor")
    yield from _entries(vehicle, [f for f in fields if f.name != "hinge_axis" or servo >= 0], index)
    if servo >= 0:
        yield f"servo = {_quoted(vehicle.servo_name[servo])}"
    yield f"spin = {_quoted('ccw' if vehicle.rotor_spin[index] > 0 else 'cw')}"


def _entries(
    vehicle: Vehicle, fields: Iterable[VehicleField], index: int | None = None
) -> Iterator[str]:
    """Yield a line for each number of some fields, or of one rotor or servo of theirs."""
    for field in fields:
        whole = np.asarray(getattr(vehicle, field.name))
        if field.is_optional and whole.tobytes() == field.filled(whole.shape).tobytes():
            continue
        value = whole if index is None else whole[index]
        several = value if field.table == "filter" else [value]
        for key, numbers in zip(field.keys, several, strict=True):
            yield f"{key} = {_written(numbers, field.unit)}"


def _written(numbers: Any, unit: str) -> str:
    """Write one number, a row of them, or a matrix, of which the diagonal if that is all."""
    if np.ndim(numbers) == 2 and np.array_equal(numbers, np.diag(np.diag(numbers))):
        numbers = np.diag(numbers)
    if np.ndim(numbers):
        return "[" + ", ".join(_written(one, unit) for one in numbers) + "]"
    return _converted(float(numbers), unit)


def _converted(value: float, unit: str) -> str:
    """Write an SI value in a unit: the shortest number that converts back exactly."""
    if UNITS[unit] == 1.0:
        return repr(value)  # which is that already
    nearest = from_SI(value, unit)
    near = [nearest, *(float(f"{nearest:.{digits}g}") for digits in range(1, 17))]
    for towards in (-math.inf, math.inf):
        step = nearest
        for _ in range(3):
            step = math.nextafter(step, towards)
            near.append(step)
    least = min(abs(to_SI(number, unit) - value) for number in near)
    best = [number for number in near if abs(to_SI(number, unit) - value) == least]
    return min((repr(number) for number in best), key=len)


def _quoted(text: str) -> str:
    """Write a TOML basic string; its escapes are those of JSON, and the delete character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
