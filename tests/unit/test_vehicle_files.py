from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from omnimorph.design import (
    Source,
    Vehicle,
    list_vehicles,
    load_vehicle,
    parse_vehicle,
    vehicle_text,
)
from omnimorph.errors import VehicleError

TEXT = """
schema = 1
name = "two"
title = "Two rotors"
mass_kg = 1
inertia_kg_m2 = [0.01, 0.01, 0.02]

[rotor_defaults]
thrust_coefficient_N_per_Hz2 = 1e-4
drag_coefficient_Nm_per_Hz2 = 2e-6
speed_min_Hz = -100.0
speed_max_Hz = 100.0

[[rotor]]
position_m = [0.1, 0.0, 0.0]
spin = "ccw"

[[rotor]]
position_m = [-0.1, 0.0, 0.0]
axis = [0.0, 0.0, -1.0]
hinge = [1.0, 0.0, 0.0]
servo = "back"
spin = "cw"
time_constant_up_ms = 25.0

[[servo]]
name = "back"
angle_min_deg = -90.0
angle_max_deg = 90.0
rate_max_deg_per_s = 360.0

[sources]
mass_kg = "weighed"
rotor.position_m = "measured"

[assumed]
"rotor_defaults.speed_max_Hz" = "a guess"
"""


def refusal(text: str) -> VehicleError:
    """Return the error that a text gives."""
    with pytest.raises(VehicleError) as caught:
        parse_vehicle(text, "two.toml")
    error = caught.value
    assert "\n" not in str(error)
    assert str(error).startswith("two.toml: ")
    assert error.file == "two.toml"
    return error


# --- reading ----------------------------------------------------------------------------------


def test_units_and_defaults() -> None:
    vehicle = parse_vehicle(TEXT, "two.toml")
    assert vehicle.mass == 1.0
    assert vehicle.tilt_mechanism_mass == 0.0
    np.testing.assert_array_equal(vehicle.inertia, np.diag([0.01, 0.01, 0.02]))
    np.testing.assert_array_equal(vehicle.rotor_axis, [[0, 0, 1], [0, 0, -1]])
    np.testing.assert_array_equal(vehicle.hinge_axis, [[0, 0, 0], [1, 0, 0]])
    np.testing.assert_array_equal(vehicle.rotor_servo, [-1, 0])
    np.testing.assert_array_equal(vehicle.rotor_spin, [1, -1])
    np.testing.assert_allclose(vehicle.thrust_max, [1.0, 1.0], rtol=1e-14)
    np.testing.assert_allclose(vehicle.speed_max, 100 * 2 * np.pi)
    np.testing.assert_allclose(vehicle.kappa, 0.02, rtol=1e-14)
    np.testing.assert_array_equal(vehicle.time_constant_up, [0.0, 0.025])
    np.testing.assert_array_equal(vehicle.time_constant_down, 0.0)
    np.testing.assert_array_equal(vehicle.dead_band, 0.0)
    np.testing.assert_allclose(vehicle.servo_rate_max, 2 * np.pi)
    np.testing.assert_array_equal(vehicle.filter_cutoff, np.zeros(4))


def test_sources_are_reported_by_attribute() -> None:
    vehicle = parse_vehicle(TEXT, "two.toml")
    assert dict(vehicle.sources) == {
        "mass": Source("weighed", assumed=False),
        "rotor_position": Source("measured", assumed=False),
        "speed_max": Source("a guess", assumed=True),
    }


def test_mass_of_the_tilt_mechanism() -> None:
    text = TEXT.replace("mass_kg = 1", "mass_kg = 1\ntilt_mechanism_mass_kg = 0.25", 1)
    text = text.replace("[assumed]", '[assumed]\ntilt_mechanism_mass_kg = "a guess"')
    vehicle = parse_vehicle(text, "two.toml")
    assert vehicle.mass == 1.0
    assert vehicle.tilt_mechanism_mass == 0.25
    assert vehicle.sources["tilt_mechanism_mass"] == Source("a guess", assumed=True)


def test_limits_as_thrust() -> None:
    text = TEXT.replace("speed_min_Hz = -100.0", "thrust_min_N = -0.25")
    text = text.replace("speed_max_Hz = 100.0", "thrust_max_N = 4.0")
    vehicle = parse_vehicle(text, "two.toml")
    np.testing.assert_allclose(vehicle.speed_min / (2 * np.pi), -50.0, rtol=1e-14)
    np.testing.assert_allclose(vehicle.speed_max / (2 * np.pi), 200.0, rtol=1e-14)
    np.testing.assert_allclose(vehicle.thrust_min, -0.25, rtol=1e-14)


def test_limits_of_one_rotor_replace_common_ones_of_the_other_kind() -> None:
    own = 'spin = "cw"\nthrust_min_N = 0.0\nthrust_max_N = 4.0'
    vehicle = parse_vehicle(TEXT.replace('spin = "cw"', own), "two.toml")
    np.testing.assert_allclose(vehicle.thrust_max, [1.0, 4.0], rtol=1e-14)
    np.testing.assert_allclose(vehicle.thrust_min, [-1.0, 0.0], rtol=1e-14)
    one = TEXT.replace('spin = "cw"', 'spin = "cw"\nspeed_max_Hz = 200.0')
    np.testing.assert_allclose(parse_vehicle(one, "f").thrust_max, [1.0, 4.0], rtol=1e-14)


def test_full_inertia() -> None:
    rows = [[0.02, 0.001, 0.0], [0.001, 0.02, 0.0], [0.0, 0.0, 0.03]]
    vehicle = parse_vehicle(TEXT.replace("[0.01, 0.01, 0.02]", str(rows)), "two.toml")
    np.testing.assert_array_equal(vehicle.inertia, rows)


# --- where vehicles are found -----------------------------------------------------------------


def test_catalogue() -> None:
    assert {"omnimorph", "omnimorph-2026"} <= set(list_vehicles())
    for name in list_vehicles():
        assert load_vehicle(name).name == name


def test_listing_does_not_import_pydantic() -> None:
    code = "import sys; from omnimorph.design import list_vehicles as names; names()"
    code += "; print('pydantic' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_path_of_a_file(tmp_path: Path) -> None:
    file = tmp_path / "two.toml"
    file.write_text(TEXT, encoding="utf-8")
    assert load_vehicle(file).name == load_vehicle(str(file)).name == "two"
    plain = tmp_path / "omnimorph"
    plain.write_text("\ufeff" + TEXT, encoding="utf-8")  # some editors write this mark first
    assert load_vehicle(plain).name == "two"


def test_unknown_name() -> None:
    with pytest.raises(VehicleError) as caught:
        load_vehicle("omnimorf")
    assert str(caught.value).startswith("'omnimorf' is neither a vehicle of the catalogue nor a ")
    assert f"did you mean omnimorph (known: {', '.join(list_vehicles())})?" in str(caught.value)
    with pytest.raises(VehicleError, match=f"known are {', '.join(list_vehicles())}"):
        load_vehicle("zzz")
    with pytest.raises(VehicleError, match="neither"):
        load_vehicle("null\x00character")


def test_unreadable_files(tmp_path: Path) -> None:
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    for path, reason in (
        (tmp_path / "nothing.toml", "there is no such file"),
        (tmp_path, "it is a directory"),
        (binary, "it is not a text file in UTF-8"),
        (tmp_path / ("x" * 300 + ".toml"), "file name too long"),
        (f"{tmp_path}/a\x00b.toml", "embedded null"),
    ):
        with pytest.raises(VehicleError) as caught:
            load_vehicle(path)
        assert f"this file cannot be read, because {reason}" in str(caught.value)
        assert caught.value.file == str(path)
        assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    "text", ["mass_kg = ", "a = 1\na = 2", "a = " + "[" * 5000, "a = " + "1" * 5000]
)
def test_not_toml(text: str) -> None:
    assert "this file is not valid TOML: " in str(refusal(text))


# --- what a file may not say ------------------------------------------------------------------

WRONG = [
    ("schema = 1", "schema = 2", "schema"),
    ("schema = 1", "schema = true", "schema"),
    ("schema = 1\n", "", "schema"),
    ("mass_kg = 1", "mass_kg = -1.0", "mass_kg"),
    ("mass_kg = 1", "mass_kg = nan", "mass_kg"),
    ("mass_kg = 1", "mass_kg = inf", "mass_kg"),
    ("mass_kg = 1", "mass_kg = true", "mass_kg"),
    ("mass_kg = 1", 'mass_kg = "1"', "mass_kg"),
    ("mass_kg = 1", "mass_kg = 2020-01-01", "mass_kg"),
    ("mass_kg = 1", "mass_kg = 0x1" + "0" * 5000, "mass_kg"),
    ("mass_kg = 1", "mass_g = 1", "mass_g"),
    ("mass_kg = 1\n", "", "mass_kg"),
    ("mass_kg = 1", "mass_kg = 1\ntilt_mechanism_mass_kg = 1.0", "tilt_mechanism_mass_kg"),
    ("mass_kg = 1", "mass_kg = 1\ntilt_mechanism_mass_kg = -0.1", "tilt_mechanism_mass_kg"),
    ("mass_kg = 1", "mass_kg = 1\ntilt_mechanism_mass_kg = inf", "tilt_mechanism_mass_kg"),
    ("mass_kg = 1", "mass_kg = 1\ntilt_mechanism_mass_kg = true", "tilt_mechanism_mass_kg"),
    ('name = "two"', 'name = "t w o"', "name"),
    ('title = "Two rotors"', 'title = "Two\\nrotors"', "title"),
    ("[0.01, 0.01, 0.02]", "[0.01, 0.01]", "inertia_kg_m2"),
    ("[0.01, 0.01, 0.02]", "[0.01, 0.01, nan]", "inertia_kg_m2"),
    ("[0.01, 0.01, 0.02]", "[0.01, 0.01, -0.02]", "inertia_kg_m2"),
    ("[0.01, 0.01, 0.02]", "[0.01, 0.01, 0.021]", "inertia_kg_m2"),
    ("[0.01, 0.01, 0.02]", "[[1, 0, 0], [0, 1, 0], [0, 0.1, 1]]", "inertia_kg_m2"),
    ("[0.01, 0.01, 0.02]", "[[1, 0, 0], [0, 1, 0], 1]", "inertia_kg_m2"),
    ("e-4", "e-4\nwings = 2", "rotor_defaults.wings"),
    ("1e-4", "0.0", "rotor_defaults.thrust_coefficient_N_per_Hz2"),
    ("2e-6", "5e-324", "rotor_defaults.drag_coefficient_Nm_per_Hz2"),
    ("drag_coefficient_Nm_per_Hz2 = 2e-6\n", "", "rotor[0].drag_coefficient_Nm_per_Hz2"),
    ("speed_max_Hz = 100.0\n", "", "rotor[0].speed_max_Hz"),
    ("speed_max_Hz = 100.0", "speed_max_Hz = -200.0", "rotor_defaults.speed_max_Hz"),
    ("speed_min_Hz = -100.0", "speed_min_Hz = 100.0", "rotor_defaults.speed_min_Hz"),
    ("speed_max_Hz = 100.0", "thrust_max_N = 1.0", "rotor_defaults.thrust_max_N"),
    ('"cw"', '"cw"\nthrust_max_N = 1.0', "rotor[1].thrust_min_N"),
    ('"cw"', '"cw"\nthrust_max_N = -1.0\nthrust_min_N = -2.0', "rotor[1].thrust_max_N"),
    ('"cw"', '"cw"\nspeed_max_Hz = 5.0\nthrust_min_N = -2.0', "rotor[1].thrust_min_N"),
    ('"cw"', '"cw"\ndead_band_Hz = 100.0', "rotor[1].dead_band_Hz"),
    ('"cw"', '"CW"', "rotor[1].spin"),
    ("[0.1, 0.0, 0.0]", "[0.1, 0.0]", "rotor[0].position_m"),
    ("[0.1, 0.0, 0.0]", "[0.1, nan, 0.0]", "rotor[0].position_m"),
    ("position_m = [0.1, 0.0, 0.0]\n", "", "rotor[0].position_m"),
    ("axis = [0.0, 0.0, -1.0]", "axis = [0.0, 0.0, -0.9]", "rotor[1].axis"),
    ("hinge = [1.0, 0.0, 0.0]", "hinge = [0.0, 0.0, 0.0]", "rotor[1].hinge"),
    ("hinge = [1.0, 0.0, 0.0]\n", "", "rotor[1].hinge"),
    ('servo = "back"\n', "", "rotor[1].servo"),
    ('servo = "back"', 'servo = "front"', "rotor[1].servo"),
    ("angle_max_deg = 90.0", "angle_max_deg = -91.0", "servo[0].angle_min_deg"),
    ("rate_max_deg_per_s = 360.0", "rate_max_deg_per_s = 0.0", "servo[0].rate_max_deg_per_s"),
    ("rate_max_deg_per_s = 360.0\n", "", "servo[0].rate_max_deg_per_s"),
    ("[sources]", "[filter]\nrate_cutoff_Hz = -1\n[sources]", "filter.rate_cutoff_Hz"),
    ("[sources]", "[filter]\nrate_Hz = -1\n[sources]", "filter.rate_Hz"),
    ('mass_kg = "weighed"', 'mass = "weighed"', "sources.mass"),
    ('mass_kg = "weighed"', "mass_kg = 7", "sources.mass_kg"),
    ('mass_kg = "weighed"', 'mass_kg = " "', "sources.mass_kg"),
    ("[assumed]", '[assumed]\nmass_kg = "twice"', "assumed.mass_kg"),
]


@pytest.mark.parametrize(("old", "new", "key"), WRONG)
def test_refused(old: str, new: str, key: str) -> None:
    assert old in TEXT
    error = refusal(TEXT.replace(old, new, 1))
    assert error.key == key
    assert str(error).startswith(f"two.toml: {key} is ")
    assert str(error)[-1] in ".?"


def test_nearest_key_is_suggested() -> None:
    error = refusal(TEXT.replace("mass_kg = 1", "mas_kg = 1"))
    assert "mas_kg is not a known key; did you mean mass_kg (allowed here: schema, " in str(error)
    error = refusal(TEXT.replace("axis =", "Axes ="))
    assert "rotor[1].Axes is not a known key; did you mean axis (allowed" in str(error)


def test_tables_in_place_of_numbers_and_numbers_in_place_of_tables() -> None:
    head = TEXT[: TEXT.index("[rotor_defaults]")]
    assert refusal(head).key == "rotor"
    assert refusal(head + "rotor = []").key == "rotor"
    assert refusal(head + "rotor = 3").key == "rotor"
    assert refusal(head + "rotor = [3]").key == "rotor[0]"
    assert refusal(head + "rotor_defaults = 3\n" + TEXT[TEXT.index("[[rotor]]") :]).key == (
        "rotor_defaults"
    )
    many = TEXT + TEXT[TEXT.index("[[rotor]]") : TEXT.index("[[servo]]")] * 9
    assert refusal(many).key == "rotor"


# --- writing ----------------------------------------------------------------------------------


def numbers_of(vehicle: Vehicle) -> dict[str, object]:
    """Return every attribute of a vehicle, arrays as bytes so that -0.0 is not 0.0."""
    return {
        name: value.tobytes() if isinstance(value, np.ndarray) else value
        for name in Vehicle.__dataclass_fields__
        for value in [getattr(vehicle, name)]
    }


@pytest.mark.parametrize("name", [*list_vehicles(), "two"])
def test_a_loaded_vehicle_is_written_without_any_change(name: str) -> None:
    vehicle = parse_vehicle(TEXT, "two.toml") if name == "two" else load_vehicle(name)
    text = vehicle_text(vehicle)
    again = parse_vehicle(text, "again.toml")
    assert numbers_of(again) == numbers_of(vehicle)
    assert vehicle_text(again) == text


def test_numbers_are_written_as_people_write_them() -> None:
    text = vehicle_text(load_vehicle("omnimorph-2026"))
    assert "speed_max_Hz = 220.0\n" in text
    assert "angle_max_deg = 60.0\n" in text
    assert "thrust_coefficient_N_per_Hz2 = 0.000184\n" in text
    assert "inertia_kg_m2 = [0.0113, 0.0113, 0.0113]\n" in text


def test_a_tilt_mechanism_without_a_known_mass_is_not_written() -> None:
    vehicle = load_vehicle("omnimorph").replace(sources={})
    assert "\ntilt_mechanism_mass_kg = 0.187\n" in vehicle_text(vehicle)
    assert "tilt_mechanism" not in vehicle_text(vehicle.replace(tilt_mechanism_mass=0.0))


def test_text_is_written_with_its_marks() -> None:
    title = 'A "quoted" \\ title, 20 °C, 𝛼'
    vehicle = load_vehicle("omnimorph").replace(title=title)
    assert parse_vehicle(vehicle_text(vehicle), "f.toml").title == title
