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
from collections.abc import Iterator, Sequence

import numpy as np

from omnimorph.design.keys import FILE_KEYS, FILTER_KEYS, ROTOR_NUMBERS, SERVO_NUMBERS
from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import FloatArray
from omnimorph.units import from_SI, to_SI, unit_of

__all__ = ["vehicle_text"]


def vehicle_text(vehicle: Vehicle) -> str:
    """Return a vehicle as TOML that `omnimorph.design.parse_vehicle` reads.

    Numbers that all rotors share stand in ``[rotor_defaults]``. Limits are written as speeds, also
    where they were read as thrusts.

    Parameters
    ----------
    vehicle : Vehicle
        Any vehicle.

    Returns
    -------
    str
        TOML. Reading it gives an equal vehicle, as the head of this module explains.
    """
    return "\n".join(_lines(vehicle)) + "\n"


def _lines(vehicle: Vehicle) -> Iterator[str]:
    yield "schema = 1"
    yield f"name = {_quoted(vehicle.name)}"
    yield f"title = {_quoted(vehicle.title)}"
    yield f"mass_kg = {_number(vehicle.mass)}"
    if vehicle.tilt_mechanism_mass:
        yield f"tilt_mechanism_mass_kg = {_number(vehicle.tilt_mechanism_mass)}"
    yield f"inertia_kg_m2 = {_inertia(vehicle.inertia)}"
    yield from ("", "[rotor_defaults]")
    shared = [name for name in ROTOR_NUMBERS if len(set(getattr(vehicle, name).tolist())) == 1]
    for name in shared:
        yield _rotor_number(vehicle, name, 0)
    for index in range(vehicle.n_rotors):
        yield from ("", "[[rotor]]")
        yield from _rotor_lines(vehicle, index)
        for name in ROTOR_NUMBERS:
            if name not in shared:
                yield _rotor_number(vehicle, name, index)
    for index, servo in enumerate(vehicle.servo_name):
        yield from ("", "[[servo]]", f"name = {_quoted(servo)}")
        for name in SERVO_NUMBERS:
            key = FILE_KEYS[name].removeprefix("servo.")
            yield f"{key} = {_converted(key, getattr(vehicle, name)[index])}"
    yield from ("", "[filter]")
    for key, cutoff in zip(FILTER_KEYS, vehicle.filter_cutoff, strict=True):
        yield f"{key} = {_converted(key, cutoff)}"
    for table, assumed in (("sources", False), ("assumed", True)):
        yield from ("", f"[{table}]")
        for name, source in vehicle.sources.items():
            if source.assumed is assumed:
                yield f"{_quoted(FILE_KEYS[name])} = {_quoted(source.text)}"


def _rotor_lines(vehicle: Vehicle, index: int) -> Iterator[str]:
    """Yield what a rotor never shares: its geometry."""
    yield f"position_m = {_vector(vehicle.rotor_position[index])}"
    yield f"axis = {_vector(vehicle.rotor_axis[index])}"
    servo = int(vehicle.rotor_servo[index])
    if servo >= 0:
        yield f"hinge = {_vector(vehicle.hinge_axis[index])}"
        yield f"servo = {_quoted(vehicle.servo_name[servo])}"
    yield f"spin = {_quoted('ccw' if vehicle.rotor_spin[index] > 0 else 'cw')}"


def _rotor_number(vehicle: Vehicle, name: str, index: int) -> str:
    key = FILE_KEYS[name].removeprefix("rotor.")
    return f"{key} = {_converted(key, getattr(vehicle, name)[index])}"


def _inertia(matrix: FloatArray) -> str:
    """Write the diagonal if there is nothing beside it, else the three rows."""
    diagonal = np.diag(matrix)
    if np.array_equal(matrix, np.diag(diagonal)):
        return _vector(diagonal)
    return "[" + ", ".join(_vector(row) for row in matrix) + "]"


def _vector(numbers: FloatArray | Sequence[float]) -> str:
    return "[" + ", ".join(_number(number) for number in numbers) + "]"


def _number(number: float) -> str:
    return repr(float(number))


def _converted(key: str, value: float) -> str:
    """Write an SI value in the unit of a key: the shortest number that converts back exactly."""
    unit = unit_of(key)
    nearest = from_SI(float(value), unit)
    near = [nearest, *(float(f"{nearest:.{digits}g}") for digits in range(1, 17))]
    for towards in (-math.inf, math.inf):
        step = nearest
        for _ in range(3):
            step = math.nextafter(step, towards)
            near.append(step)
    least = min(abs(to_SI(number, unit) - value) for number in near)
    best = [number for number in near if abs(to_SI(number, unit) - value) == least]
    return min((_number(number) for number in best), key=len)


def _quoted(text: str) -> str:
    """Write a TOML basic string; its escapes are those of JSON, and the delete character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
