"""From the text of a vehicle file to a `Vehicle`: parsed, checked, merged, converted to SI."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.design.checks import LONGEST_LINE
from omnimorph.design.documents import check_document, parse_toml
from omnimorph.design.keys import AS_THRUST, FIELDS, FILE_KEYS, OF_VEHICLES, fields_in
from omnimorph.design.unit_doubts import question_units, unit_doubts
from omnimorph.design.vehicle import Source, Vehicle
from omnimorph.design.vehicle_fields import VehicleField
from omnimorph.errors import MISSING, VehicleError

if TYPE_CHECKING:
    from omnimorph.design.schema import Rotor, RotorDefaults, VehicleFile

_SHARED = fields_in("rotor", shared=True)
_LIMIT_KEYS = {*AS_THRUST.keys(), *AS_THRUST.values()}


def parse_vehicle(text: str, file: str | Path, *, questioned: bool = True) -> Vehicle:
    """Build a vehicle from the text of a vehicle file.

    Parameters
    ----------
    text : str
        TOML, as `omnimorph.design.files` describes it.
    file : str or Path
        What messages call the file; it is not opened.
    questioned : bool
        Whether to warn of numbers that look like those of another unit.

    Returns
    -------
    Vehicle
        Checked, in SI.

    Raises
    ------
    VehicleError
        If the text describes no vehicle: one sentence with file, key, value and what is allowed.

    Warns
    -----
    UnlikelyUnitWarning
        If a number looks like one in another unit: file, key, value and the likely unit.
    """
    from omnimorph.design.schema import VehicleFile

    document = parse_toml(text, file, VehicleError)
    content = check_document(VehicleFile, document, file, VehicleError)
    values = _vehicle_values(content, file)
    try:
        vehicle = Vehicle(**values, questioned=False)
    except VehicleError as refused:
        attribute, _, index = str(refused.key).rstrip("]").partition("[")
        where, value = _place(document, attribute, int(index) if index else None)
        raise VehicleError.at(file, where, value, str(refused.allowed)) from None
    if questioned:
        _question_units(vehicle, document, file)
    return vehicle


def _question_units(vehicle: Vehicle, document: Mapping[str, Any], file: str | Path) -> None:
    """Warn of what looks like another unit, with the file's own keys."""

    def place(attribute: str, index: int | None) -> tuple[str, Any]:
        where, value = _place(document, attribute, index)
        return f"{file}: {where}", value

    def name(attribute: str) -> str:
        return FILE_KEYS[attribute].rpartition(".")[2]

    tables = (document.get("rotor_defaults", {}), *document["rotor"])
    as_thrust = any(_as_thrust(table) for table in tables)
    question_units(unit_doubts(vehicle, "Hz", limits_are_thrusts=as_thrust), place, name)


def _vehicle_values(content: VehicleFile, file: str | Path) -> dict[str, Any]:
    """Translate a checked file into the attributes of `Vehicle`."""
    servos = [servo.name for servo in content.servo]
    _check_one_kind_of_limit("rotor_defaults", content.rotor_defaults, file)
    tilted_by, rotors = [], []
    for index, rotor in enumerate(content.rotor):
        tilted_by.append(_servo_index(rotor, servos, f"rotor[{index}]", file))
        rotors.append(_merged(rotor, content.rotor_defaults, f"rotor[{index}]", file))
    rows: dict[str, Sequence[Mapping[str, Any]]] = {
        "": [vars(content)],
        "rotor": rotors,
        "servo": [vars(servo) for servo in content.servo],
        "filter": [vars(content.filter)],
    }
    return {
        "name": content.name,
        "title": content.title,
        "servo_name": tuple(servos),
        "rotor_servo": tilted_by,
        "rotor_spin": [1.0 if rotor.spin == "ccw" else -1.0 for rotor in content.rotor],
        **{
            field.name: _numbers(field, rows[field.table])
            for field in FIELDS.values()
            if field.is_number
        },
        "sources": _sources(content, file),
    }


def _numbers(field: VehicleField, rows: Sequence[Mapping[str, Any]]) -> Any:
    """Return the numbers of a field in SI: of the only row at the top of a file, or of each."""
    found = [_own(field, row[key]) for row in rows for key in field.keys]
    return found if field.table else found[0]


def _own(field: VehicleField, value: Any) -> Any:
    """Return what a table gives for a field in SI, the default if it gives nothing."""
    if value is None:
        return field.filled(field.shape) if field.shape else field.left_out
    if field.shape == (3, 3) and np.ndim(value) == 1:
        value = np.diag(value)
    return field.in_SI(np.array(value, dtype=np.float64) if field.shape else value)


def _servo_index(rotor: Rotor, names: list[str], where: str, file: str | Path) -> int:
    """Return the index of the servo that a rotor names, -1 if it does not tilt."""
    hinge = getattr(rotor, FIELDS["hinge_axis"].key)
    if rotor.servo is None and hinge is None:
        return -1
    if rotor.servo is None:
        allowed = "the name of a [[servo]], as hinge is given"
        raise VehicleError.at(file, f"{where}.servo", MISSING, allowed)
    if hinge is None:
        allowed = "a unit vector [x, y, z], as servo is given"
        raise VehicleError.at(file, f"{where}.hinge", MISSING, allowed)
    if rotor.servo not in names:
        allowed = f"the name of a [[servo]] (there is {', '.join(names) or 'none'})"
        raise VehicleError.at(file, f"{where}.servo", rotor.servo, allowed)
    return names.index(rotor.servo)


def _merged(rotor: Rotor, defaults: RotorDefaults, where: str, file: str | Path) -> dict[str, Any]:
    """Return a rotor's table over the defaults, its limits as speeds."""
    _check_one_kind_of_limit(where, rotor, file)
    own, common = _given(rotor), _given(defaults)
    if own.keys() & _LIMIT_KEYS and _as_thrust(own) != _as_thrust(common):
        common = {key: value for key, value in common.items() if key not in _LIMIT_KEYS}
    numbers = vars(rotor) | common | own
    as_thrust = _as_thrust(common | own)
    for field in _SHARED:
        given_as = field.thrust_key if as_thrust and field.thrust_key else field.key
        number = numbers[given_as]
        if number is None and field.left_out is dataclasses.MISSING:
            allowed = "a number, here or in [rotor_defaults]"
            raise VehicleError.at(file, f"{where}.{given_as}", MISSING, allowed)
        if given_as != field.key:  # f = c_f w|w|, with w in Hz and c_f in N/Hz²
            speed = math.sqrt(abs(number) / numbers["thrust_coefficient_N_per_Hz2"])
            numbers[field.key] = speed = math.copysign(speed, number)
            if speed not in OF_VEHICLES[field.key]:
                allowed = f"such that it takes {OF_VEHICLES[field.key]} Hz, not {speed:g}"
                raise VehicleError.at(file, f"{where}.{given_as}", number, allowed)
    return numbers


def _given(table: RotorDefaults) -> dict[str, float]:
    """Return the shared numbers that a table, of one rotor or of the defaults, gives."""
    keys = [key for field in _SHARED for key in field.ranges]
    return {key: value for key in keys if (value := getattr(table, key)) is not None}


def _as_thrust(numbers: Mapping[str, float]) -> bool:
    """Say whether limits are given as thrusts."""
    return any(key in numbers for key in AS_THRUST.values())


def _check_one_kind_of_limit(where: str, table: RotorDefaults, file: str | Path) -> None:
    """Refuse limits given both as speeds and as thrusts."""
    given = _given(table)
    speeds = [key for key in AS_THRUST if key in given]
    for key in AS_THRUST.values():
        if speeds and key in given:
            allowed = f"left out, as {speeds[0]} is given: limits are speeds or thrusts, not both"
            raise VehicleError.at(file, f"{where}.{key}", given[key], allowed)


def _sources(content: VehicleFile, file: str | Path) -> dict[str, Source]:
    """Collect ``[sources]`` and ``[assumed]`` under the names of attributes."""
    attributes = {key: attribute for attribute, key in FILE_KEYS.items()}
    for speed, thrust in AS_THRUST.items():
        attributes[f"rotor.{thrust}"] = attributes[f"rotor.{speed}"]
    found: dict[str, Source] = {}
    for table in ("sources", "assumed"):
        for key, text in _flat(getattr(content, table)):
            where = f"{table}.{key}"
            attribute = attributes.get(re.sub(r"^rotor_defaults\.", "rotor.", key))
            if attribute is None:
                raise VehicleError.unknown_key(file, where, key, attributes)
            line = " ".join(text.split()) if isinstance(text, str) else ""
            if not (line.isprintable() and 1 <= len(line) <= LONGEST_LINE):
                allowed = f"a text that says where it comes from, at most {LONGEST_LINE} characters"
                raise VehicleError.at(file, where, text, allowed)
            if attribute in found:
                raise VehicleError.at(file, where, line, "left out, as it is given already")
            found[attribute] = Source(line, assumed=table == "assumed")
    return found


def _flat(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Yield the entries of nested tables under dotted keys such as ``rotor.axis``."""
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _place(document: Mapping[str, Any], attribute: str, index: int | None) -> tuple[str, Any]:
    """Return where an attribute of `Vehicle` stands in its file, and what is written there."""
    table, _, key = FILE_KEYS[attribute].rpartition(".")
    places: list[tuple[str, Mapping[str, Any]]] = [(key, document)]
    if FIELDS[attribute].table == "filter":
        key = FIELDS[attribute].keys[index or 0]
        places = [(f"filter.{key}", document["filter"])]
    elif table:
        places = [(f"{table}[{index}].{key}", document[table][index])]
    if table == "rotor":
        places.append((f"rotor_defaults.{key}", document.get("rotor_defaults", {})))
    for where, place in places:
        for given_as in (key, AS_THRUST.get(key, key)):
            if given_as in place:
                return where.removesuffix(key) + given_as, place[given_as]
    return places[0][0], MISSING
