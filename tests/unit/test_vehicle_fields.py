"""A field of a vehicle is declared once: all the rest follows, and none can be forgotten."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
import shutil
import subprocess
import sys
import typing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.unit.test_vehicle import build_quadrotor

import omnimorph
from omnimorph.design import Vehicle, load_vehicle
from omnimorph.design.keys import FIELDS, FILE_KEYS, OF_VEHICLES, fields_in
from omnimorph.design.ranges import Range
from omnimorph.design.schema import Filter, Rotor, RotorDefaults, Servo, VehicleFile
from omnimorph.design.tables import range_of
from omnimorph.design.vehicle_fields import VehicleField, fields_of, of_body
from omnimorph.errors import VehicleError
from omnimorph.model.core import core_fields
from omnimorph.units import UNITS

PACKAGE = Path(omnimorph.__file__).parent
CORE_VEHICLE = Path(__file__).parents[2] / "core/include/omnimorph/model/vehicle.hpp"
TABLES: dict[str, Any] = {"": VehicleFile, "rotor": Rotor, "servo": Servo, "filter": Filter}
NUMBERS = [field for field in FIELDS.values() if field.is_number]

all_fields = pytest.mark.parametrize("field", FIELDS.values(), ids=lambda field: field.name)
all_numbers = pytest.mark.parametrize("field", NUMBERS, ids=lambda field: field.name)


# --- every field ----------------------------------------------------------------------------------


def test_every_field_is_declared_and_documented() -> None:
    names = [field.name for field in dataclasses.fields(Vehicle)]
    assert [*FIELDS, "sources"] == names
    described = re.findall(r"^    ((?:\w+, )*\w+) : ", str(Vehicle.__doc__), re.MULTILINE)
    assert {name for line in described for name in line.split(", ")} >= set(names)


def test_a_field_without_a_declaration_is_refused() -> None:
    @dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
    class Longer(Vehicle):
        blade_chord: float = 0.0

    with pytest.raises(TypeError, match=r"Longer\.blade_chord is not declared with of_body, "):
        fields_of(Longer)


@all_numbers
def test_a_number_has_a_unit_limits_and_a_shape(field: VehicleField) -> None:
    assert field.unit in UNITS
    assert isinstance(field.limits, Range)
    assert math.isfinite(field.limits.least)
    assert math.isfinite(field.limits.most)
    assert field.allowed
    value = np.asarray(getattr(load_vehicle("omnimorph"), field.name))
    assert value.shape == field.whole_shape(8, 1)


@all_fields
def test_a_field_is_in_the_schema_of_files(field: VehicleField) -> None:
    known = TABLES[field.table].model_fields
    for key in field.keys:
        assert key in known
        assert range_of(known[key]) == field.limits
    assert (field.key in RotorDefaults.model_fields) is field.is_shared
    if field.thrust_limits:
        assert range_of(known[field.thrust_key]) == field.thrust_limits


def test_files_have_no_key_that_belongs_to_no_field() -> None:
    declared = {(field.table, key) for field in FIELDS.values() for key in field.keys}
    declared |= {("rotor", field.thrust_key) for field in NUMBERS if field.thrust_key}
    tables = {"schema_version", "rotor_defaults", "rotor", "servo", "filter", "sources", "assumed"}
    for table, model in TABLES.items():
        for key in set(model.model_fields) - (tables if not table else set()):
            assert (table, key) in declared
    assert len(set(FILE_KEYS.values())) == len(FILE_KEYS)
    assert sum(len(field.ranges) for field in NUMBERS if not field.is_direction) == len(OF_VEHICLES)


def test_a_number_is_in_the_lines_of_one_table() -> None:
    listed = [field for table in TABLES for field in fields_in(table)]
    assert sorted(field.name for field in [*listed, *fields_in("rotor", shared=True)]) == sorted(
        field.name for field in NUMBERS
    )


@all_numbers
@pytest.mark.parametrize("beyond", [math.nan, math.inf, "just above", "just below"])
def test_a_number_beyond_its_limits_is_refused(field: VehicleField, beyond: float | str) -> None:
    limits = field.limits_in_SI or Range(-1.02, 1.02)
    ends = {
        "just above": math.nextafter(limits.most, math.inf),
        "just below": math.nextafter(limits.least, -math.inf),
    }
    vehicle = build_quadrotor()
    value = np.array(getattr(vehicle, field.name), dtype=np.float64)
    value[(-1,) * value.ndim] = ends[beyond] if isinstance(beyond, str) else beyond
    with pytest.raises(VehicleError) as caught:
        vehicle.replace(**{field.name: value if value.ndim else float(value)})
    assert str(caught.value.key).partition("[")[0] == field.name
    if isinstance(beyond, str) and field.limits_in_SI:
        assert f"must be {limits} in SI." in str(caught.value)


def test_zero_beside_a_range_is_allowed_where_it_is_declared_so() -> None:
    @dataclasses.dataclass(frozen=True, eq=False, kw_only=True)
    class Longer(Vehicle):
        hull: float = of_body("m", Range(0.1, 1.0, or_zero=True), "a length", default=0.0)

    values = {field: getattr(build_quadrotor(), field) for field in FIELDS}
    assert Longer(**values).hull == 0.0
    with pytest.raises(VehicleError, match=r"hull is 0\.05, but it must be 0 or from 0\.1 to 1 "):
        Longer(**values, hull=0.05)


# --- the core -------------------------------------------------------------------------------------


def test_the_core_is_given_every_field_that_it_lists() -> None:
    listed = re.findall(r'\bfield\("(\w+)"', CORE_VEHICLE.read_text(encoding="utf-8"))
    assert len(listed) > 10
    assert sorted(core_fields(build_quadrotor())) == sorted(listed)


# --- one more field, in a copy of the package -----------------------------------------------------

DECLARED = "    servo_name: tuple[str, ...] = as_text"
NEW_FIELDS = """\
    blade_chord: FloatArray = of_rotors("mm", Range(0.0, 1e3), "a width", default=0.0, in_core=True)
    servo_backlash: FloatArray = of_servos("deg", Range(0.0, 10.0), "an angle", default=0.0)
    drag_area: FloatArray = of_body("m", Range(0.0, 9.0), "areas", default=0.0, shape=(3,))
"""
CHILD = """
import json
from omnimorph.design import Vehicle, list_vehicles, load_vehicle, parse_vehicle, vehicle_text
from omnimorph.errors import VehicleError
from omnimorph.model.core import core_fields

def refusal(build):
    try:
        build()
    except VehicleError as refused:
        return str(refused)

found = {name: vehicle_text(load_vehicle(name)) for name in list_vehicles()}
plain = load_vehicle("omnimorph")
text = found["omnimorph"].replace("[rotor_defaults]", "[rotor_defaults]\\nblade_chord_mm = 21.7", 1)
text = text.replace("[[servo]]", "[[servo]]\\nbacklash_deg = 0.3")
text = text.replace("mass_kg", "drag_area_m = [0.1, 0.2, 0.3]\\nmass_kg", 1)
text = text.replace("[sources]", "[sources]\\n'rotor.blade_chord_mm' = 'a ruler'", 1)
vehicle = parse_vehicle(text, "longer.toml")
again = parse_vehicle(vehicle_text(vehicle), "again.toml")
names = ("blade_chord", "servo_backlash", "drag_area")
print(json.dumps({
    "texts": found,
    "defaults": [getattr(plain, name).tolist() for name in names],
    "read": [getattr(vehicle, name).tolist() for name in names],
    "again": all(getattr(again, n).tobytes() == getattr(vehicle, n).tobytes() for n in names),
    "source": again.sources["blade_chord"].text,
    "core": core_fields(vehicle)["blade_chord"].tolist(),
    "not in the core": sorted({"backlash", "drag_area"} & set(core_fields(vehicle))),
    "in Python": refusal(lambda: vehicle.replace(blade_chord=[-1.0] + [0.0] * 7)),
    "in a file": refusal(lambda: parse_vehicle(text.replace("21.7", "2e3"), "longer.toml")),
    "misspelt": refusal(lambda: parse_vehicle(text.replace("backlash", "backlsh"), "longer.toml")),
}))
"""


@pytest.fixture(scope="module")
def longer(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What a copy of the package makes of three lines more in the list of fields."""
    copy = tmp_path_factory.mktemp("copy") / "omnimorph"
    copy.mkdir()
    for entry in PACKAGE.iterdir():
        if entry.name != "design":
            (copy / entry.name).symlink_to(entry)
    shutil.copytree(PACKAGE / "design", copy / "design", ignore=shutil.ignore_patterns("*.pyc"))
    source = copy / "design" / "vehicle.py"
    text = source.read_text(encoding="utf-8")
    assert text.count(DECLARED) == 1
    source.write_text(text.replace(DECLARED, NEW_FIELDS + DECLARED), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", CHILD],
        env=os.environ | {"PYTHONPATH": str(copy.parent)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return typing.cast("dict[str, Any]", json.loads(done.stdout))


def test_one_line_more_is_a_field_in_python_in_files_and_in_the_core(
    longer: dict[str, Any],
) -> None:
    chord, backlash = 21.7 * UNITS["mm"], 0.3 * UNITS["deg"]
    assert longer["defaults"] == [[0.0] * 8, [0.0], [0.0] * 3]
    assert longer["read"] == [[chord] * 8, [backlash], [0.1, 0.2, 0.3]]
    assert longer["again"] is True
    assert longer["source"] == "a ruler"
    assert longer["core"] == [chord] * 8
    assert longer["not in the core"] == []


def test_one_line_more_is_checked(longer: dict[str, Any]) -> None:
    assert longer["in Python"] == (
        "vehicle omnimorph: blade_chord[0] is -1.0, but it must be from 0 to 1 in SI."
    )
    assert longer["in a file"] == (
        "longer.toml: rotor_defaults.blade_chord_mm is 2000.0, but it must be a width, "
        "from 0 to 1000."
    )
    assert (
        "servo[0].backlsh_deg is not a known key; did you mean backlash_deg" in longer["misspelt"]
    )


def test_one_line_more_changes_no_file_there_is(longer: dict[str, Any]) -> None:
    for name, text in longer["texts"].items():
        assert text == omnimorph.design.vehicle_text(load_vehicle(name))
