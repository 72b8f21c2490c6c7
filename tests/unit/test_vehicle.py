from __future__ import annotations

import copy
import dataclasses
import math
import pickle
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from omnimorph.design import Source, Vehicle, load_vehicle
from omnimorph.design.checks import LONGEST_LINE
from omnimorph.design.keys import FIELDS
from omnimorph.design.new_vehicle import new_vehicle_text
from omnimorph.design.reading import parse_vehicle
from omnimorph.design.vehicle import MOST_ROTORS, MOST_SERVOS
from omnimorph.errors import VehicleError


def build_quadrotor(**changes: Any) -> Vehicle:
    """Build a plain quadrotor whose last rotor tilts about x; with changes."""
    values: dict[str, Any] = {
        "name": "quad",
        "title": "A quadrotor for tests",
        "mass": 1.0,
        "tilt_mechanism_mass": 0.1,
        "inertia": np.diag([0.01, 0.01, 0.02]),
        "rotor_position": [[0.2, 0, 0], [0, 0.2, 0], [-0.2, 0, 0], [0, -0.2, 0]],
        "rotor_axis": [[0.0, 0.0, 1.0]] * 4,
        "hinge_axis": [[0.0] * 3, [0.0] * 3, [0.0] * 3, [1.0, 0.0, 0.0]],
        "rotor_servo": [-1, -1, -1, 0],
        "rotor_spin": [1, -1, 1, -1],
        "thrust_coefficient": [1e-5] * 4,
        "drag_coefficient": [2e-7] * 4,
        "speed_min": [100.0, 0.0, -200.0, -400.0],
        "speed_max": [600.0] * 4,
        "dead_band": [0.0, 0.0, 50.0, 50.0],
        "time_constant_up": [0.02] * 4,
        "time_constant_down": [0.03] * 4,
        "spin_inertia": [1e-5] * 4,
        "servo_name": ("front",),
        "servo_angle_min": [-0.5],
        "servo_angle_max": [0.5],
        "servo_rate_max": [3.0],
        "servo_time_constant": [0.0],
        "filter_cutoff": [0.0, 0.0, 100.0, 100.0],
        "sources": {"mass": Source("a scale", assumed=False)},
    }
    return Vehicle(**(values | changes))


def fields_of(vehicle: Vehicle) -> list[str]:
    return [field.name for field in dataclasses.fields(vehicle)]


# --- what a vehicle knows --------------------------------------------------------------------


def test_counts_and_derived_numbers() -> None:
    vehicle = build_quadrotor()
    assert (vehicle.n_rotors, vehicle.n_servos) == (4, 1)
    np.testing.assert_allclose(vehicle.thrust_min, [0.1, 0.0, -0.4, -1.6], rtol=1e-15)
    np.testing.assert_allclose(vehicle.thrust_max, [3.6] * 4, rtol=1e-15)
    np.testing.assert_allclose(vehicle.kappa, [0.02] * 4, rtol=1e-15)


def test_arrays_are_read_only_copies() -> None:
    mine = np.diag([0.01, 0.01, 0.02])
    vehicle = build_quadrotor(inertia=mine)
    mine[0, 0] = 7.0
    assert vehicle.inertia[0, 0] == 0.01
    derived = ("thrust_min", "thrust_max", "kappa")
    arrays = [getattr(vehicle, name) for name in [*fields_of(vehicle), *derived]]
    arrays = [value for value in arrays if isinstance(value, np.ndarray)]
    declared = [field for field in FIELDS.values() if field.shape is not None]
    of_several = [field for field in declared if field.whole_shape(4, 1)]
    assert len(arrays) == len(of_several) + len(derived)
    for array in [*arrays, *vehicle.thrust_axis_parts]:
        assert not array.flags.writeable
    with pytest.raises(dataclasses.FrozenInstanceError):
        vehicle.mass = 2.0  # type: ignore[misc]


def test_types_of_the_arrays() -> None:
    vehicle = build_quadrotor()
    assert vehicle.rotor_servo.dtype == np.int64
    assert vehicle.rotor_spin.dtype == np.float64
    assert vehicle.rotor_position.dtype == np.float64


def test_axis_parts_are_a_rotation_about_the_hinge() -> None:
    """Against a rotation built independently, for a hinge that is not at right angles."""
    hinge = np.array([1.0, 2.0, 2.0]) / 3.0
    vehicle = build_quadrotor(hinge_axis=[[0.0] * 3] * 3 + [hinge])
    z0, zC, zS = vehicle.thrust_axis_parts
    for angle in np.linspace(-3.0, 3.0, 13):
        w, x, y, z = math.cos(angle / 2), *(math.sin(angle / 2) * hinge)
        third_column = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
        tilted = z0 + zC * math.cos(angle) + zS * math.sin(angle)
        np.testing.assert_allclose(tilted[3], third_column, atol=1e-15)
        np.testing.assert_array_equal(tilted[:3], [[0.0, 0.0, 1.0]] * 3)


def test_axes_near_unit_length_are_normalised_once() -> None:
    vehicle = build_quadrotor(rotor_axis=[[0.0, 0.0, 1.009], [0.0, 0.6, 0.8], [0, 0, 1], [0, 0, 1]])
    np.testing.assert_array_equal(vehicle.rotor_axis[0], [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(vehicle.rotor_axis[1], [0.0, 0.6, 0.8])


def test_replace_checks_again() -> None:
    vehicle = build_quadrotor()
    assert vehicle.replace(mass=2.0).mass == 2.0
    assert vehicle.mass == 1.0
    with pytest.raises(VehicleError, match="mass is -2"):
        vehicle.replace(mass=-2.0)


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda v: pickle.loads(pickle.dumps(v))])
def test_copies_are_equal_and_read_only(duplicate: Any) -> None:
    vehicle = build_quadrotor()
    other = duplicate(vehicle)
    for name in fields_of(vehicle):
        np.testing.assert_equal(getattr(other, name), getattr(vehicle, name))
    assert not other.rotor_axis.flags.writeable


def test_importing_the_record_does_not_import_pydantic() -> None:
    code = "import sys, omnimorph.design.vehicle; print('pydantic' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_unknown_name_of_the_package() -> None:
    import omnimorph.design

    assert "load_vehicle" in dir(omnimorph.design)
    with pytest.raises(AttributeError, match="no attribute 'wings'"):
        _ = omnimorph.design.wings


# --- OmniMorph --------------------------------------------------------------------------------


def test_thrust_axes_of_omnimorph() -> None:
    """The table of the consistent reading of the paper, exactly."""
    vehicle = load_vehicle("omnimorph")
    hubs = [[1, 1, 1], [-1, 1, 1], [-1, -1, 1], [1, -1, 1]]
    hubs += [[x, y, -z] for x, y, z in hubs]
    np.testing.assert_array_equal(vehicle.rotor_position, 0.1062 * np.array(hubs))
    np.testing.assert_array_equal(
        vehicle.rotor_spin, -np.sign(vehicle.rotor_position[:, 0] * vehicle.rotor_position[:, 1])
    )
    z0, zC, zS = vehicle.thrust_axis_parts
    np.testing.assert_array_equal(z0, np.zeros((8, 3)))
    np.testing.assert_array_equal(zC, [[0.0, 0.0, 1.0]] * 8)
    upper = [[-1, 0, 0], [0, -1, 0], [1, 0, 0], [0, 1, 0]]
    lower = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
    np.testing.assert_array_equal(zS, upper + lower)


def test_parameters_of_omnimorph() -> None:
    vehicle = load_vehicle("omnimorph")
    assert vehicle.mass == 1.315
    assert vehicle.mass - vehicle.tilt_mechanism_mass == pytest.approx(1.128, rel=1e-15)
    np.testing.assert_array_equal(vehicle.inertia, np.diag([1.16e-2, 1.13e-2, 1.13e-2]))
    np.testing.assert_allclose(vehicle.thrust_max, 5.3587, rtol=1e-14)
    np.testing.assert_array_equal(vehicle.thrust_min, -vehicle.thrust_max)
    np.testing.assert_allclose(vehicle.thrust_max / (vehicle.mass * 9.81), 0.4154, atol=5e-5)
    np.testing.assert_allclose(vehicle.speed_max / (2 * np.pi), 169.56, atol=5e-3)
    np.testing.assert_allclose(vehicle.kappa, 2.754e-6 / 1.8638e-4, rtol=1e-14)
    np.testing.assert_allclose(np.rad2deg(vehicle.servo_angle_max), 60.0)
    np.testing.assert_allclose(np.rad2deg(vehicle.servo_rate_max), 100.0)
    np.testing.assert_array_equal(vehicle.time_constant_up, 0.02)
    np.testing.assert_array_equal(vehicle.dead_band, 0.0)
    # hover with all rotors alike: 93.01 Hz
    speed = np.sqrt(vehicle.mass * 9.81 / 8 / vehicle.thrust_coefficient[0])
    assert speed / (2 * np.pi) == pytest.approx(93.01, abs=5e-3)


def test_parameters_of_the_later_prototype() -> None:
    vehicle = load_vehicle("omnimorph-2026")
    assert vehicle.mass == 1.625
    assert vehicle.tilt_mechanism_mass == 0.0  # nobody has published it
    np.testing.assert_array_equal(np.abs(vehicle.rotor_position), 0.125)
    np.testing.assert_allclose(vehicle.speed_max / (2 * np.pi), 220.0)
    np.testing.assert_array_equal(vehicle.speed_min, -vehicle.speed_max)
    np.testing.assert_allclose(vehicle.dead_band / (2 * np.pi), 30.0)
    np.testing.assert_allclose(vehicle.kappa, 2.0e-6 / 1.84e-4)
    first = load_vehicle("omnimorph").thrust_axis_parts
    for part, part_of_first in zip(vehicle.thrust_axis_parts, first, strict=True):
        np.testing.assert_array_equal(part, part_of_first)


@pytest.mark.parametrize("name", ["omnimorph", "omnimorph-2026"])
def test_every_number_has_a_source(name: str) -> None:
    vehicle = load_vehicle(name)
    words = {"name", "title", "servo_name", "sources"}
    left_out = {field.name for field in FIELDS.values() if field.is_optional}
    left_out |= {"dead_band"} if name == "omnimorph" else set()
    assert set(fields_of(vehicle)) - words - left_out <= set(vehicle.sources)
    assumed = {key for key, source in vehicle.sources.items() if source.assumed}
    guesses = {"time_constant_up", "time_constant_down", "servo_rate_max", "servo_time_constant"}
    half_edge = {"rotor_position"} if name == "omnimorph" else set()
    assert assumed == guesses | half_edge | {"filter_cutoff"}


# --- what a vehicle refuses -------------------------------------------------------------------

NAN = math.nan
EYE = np.eye(3)
WRONG: list[tuple[str, Any, str]] = [
    ("name", "two words", "name"),
    ("name", 3, "name"),
    ("title", "two\nlines", "title"),
    ("mass", -1.0, "mass"),
    ("mass", NAN, "mass"),
    ("mass", "heavy", "mass"),
    ("tilt_mechanism_mass", -0.1, "tilt_mechanism_mass"),
    ("tilt_mechanism_mass", 1.0, "tilt_mechanism_mass"),
    ("tilt_mechanism_mass", NAN, "tilt_mechanism_mass"),
    ("tilt_mechanism_mass", math.inf, "tilt_mechanism_mass"),
    ("tilt_mechanism_mass", [0.1], "tilt_mechanism_mass"),
    ("tilt_mechanism_mass", "light", "tilt_mechanism_mass"),
    ("inertia", EYE[:2], "inertia"),
    ("inertia", EYE + np.triu(np.full((3, 3), 0.1), 1), "inertia"),
    ("inertia", np.diag([1.0, 1.0, -1.0]), "inertia"),
    ("inertia", np.diag([1.0, 1.0, 0.0]), "inertia"),
    ("inertia", np.diag([1.0, 1.0, 2.1]), "inertia"),
    ("inertia", np.array([[1.0, 0.9, 0.0], [0.9, 1.0, 0.0], [0.0, 0.0, 0.05]]), "inertia"),
    ("rotor_position", [], "rotor_position"),
    ("rotor_position", np.zeros((19, 3)), "rotor_position"),
    ("rotor_position", np.array(1.0), "rotor_position"),
    ("rotor_position", np.zeros((4, 2)), "rotor_position"),
    ("rotor_position", [[0, 0, 0], [0, 0, math.inf], [0, 0, 0], [0, 0, 0]], "rotor_position[1]"),
    ("rotor_axis", [[0, 0, 1], [0, 0, 1], [0, 0, 0.98], [0, 0, 1]], "rotor_axis[2]"),
    ("rotor_axis", np.zeros((4, 3)), "rotor_axis[0]"),
    ("hinge_axis", np.zeros((4, 3)), "hinge_axis[3]"),
    ("hinge_axis", [[1, 0, 0]] * 4, "hinge_axis[0]"),
    ("rotor_servo", [-1, -1, -1, 1], "rotor_servo[3]"),
    ("rotor_servo", [-1, -2, -1, 0], "rotor_servo[1]"),
    ("rotor_servo", [-1, -1, -1, 0.5], "rotor_servo[3]"),
    ("rotor_spin", [1, -1, 0, 1], "rotor_spin[2]"),
    ("thrust_coefficient", [1e-5, 0.0, 1e-5, 1e-5], "thrust_coefficient[1]"),
    ("drag_coefficient", [1e-5, 1e-5, 1e-5, -1e-5], "drag_coefficient[3]"),
    ("drag_coefficient", [1e305, 1.0, 1.0, 1.0], "drag_coefficient[0]"),
    ("speed_max", [600.0, 600.0, 600.0, 0.0], "speed_max[3]"),
    ("speed_max", [1e160, 600.0, 600.0, 600.0], "speed_max[0]"),
    ("speed_min", [600.0, 0.0, 0.0, 0.0], "speed_min[0]"),
    ("speed_min", [0.0] * 3, "speed_min"),
    ("dead_band", [0.0, 0.0, 0.0, -1.0], "dead_band[3]"),
    ("dead_band", [0.0, 0.0, 200.0, 0.0], "dead_band[2]"),
    ("time_constant_up", [0.0, 0.0, -0.1, 0.0], "time_constant_up[2]"),
    ("time_constant_down", [0.0, 0.0, -0.1, 0.0], "time_constant_down[2]"),
    ("spin_inertia", [-1e-9, 0.0, 0.0, 0.0], "spin_inertia[0]"),
    ("servo_name", "front", "servo_name"),
    ("servo_name", tuple(f"s{j}" for j in range(19)), "servo_name"),
    ("servo_name", ("front", "front"), "servo_name[1]"),
    ("servo_angle_max", [-0.6], "servo_angle_min[0]"),
    ("servo_rate_max", [0.0], "servo_rate_max[0]"),
    ("servo_time_constant", [-1.0], "servo_time_constant[0]"),
    ("filter_cutoff", [0.0, 0.0, NAN, 0.0], "filter_cutoff[2]"),
    ("filter_cutoff", [0.0, 0.0, 0.0, -1.0], "filter_cutoff[3]"),
    ("sources", {"wings": Source("none", assumed=False)}, "sources"),
    ("sources", {"mass": "a scale"}, "sources[mass]"),
    ("sources", {"mass": Source("", assumed=False)}, "sources[mass].text"),
]


@pytest.mark.parametrize(("field", "value", "key"), WRONG)
def test_refused(field: str, value: Any, key: str) -> None:
    with pytest.raises(VehicleError) as caught:
        build_quadrotor(**{field: value})
    assert caught.value.key == key
    assert str(caught.value).startswith("vehicle")
    assert f": {key} is " in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_tilt_mechanism_is_lighter_than_the_vehicle() -> None:
    with pytest.raises(VehicleError, match=r"zero or positive, and below the mass of 0\.05 kg"):
        build_quadrotor(mass=0.05)


def test_what_lies_on_the_limit_is_accepted() -> None:
    build_quadrotor(tilt_mechanism_mass=math.nextafter(1.0, 0.0))
    assert math.copysign(1.0, build_quadrotor(tilt_mechanism_mass=-0.0).tilt_mechanism_mass) == 1.0
    build_quadrotor(inertia=np.diag([0.01, 0.01, 0.02]))  # a flat plate
    build_quadrotor(servo_angle_min=[0.5])  # a locked servo
    build_quadrotor(speed_min=[0.0] * 4, dead_band=[599.0] * 4)
    build_quadrotor(rotor_axis=[[0.0, 0.0, 0.991]] * 4)


def test_as_many_rotors_servos_and_letters_as_allowed_and_not_one_more() -> None:
    """What a message calls the most is itself allowed, in files and in Python."""
    text = new_vehicle_text("whole", MOST_ROTORS, "independent")
    whole = parse_vehicle(text, "whole.toml")
    assert (whole.n_rotors, whole.n_servos) == (MOST_ROTORS, MOST_SERVOS)
    title = "t" * LONGEST_LINE
    assert whole.replace(title=title).title == title
    for changes, allowed in (
        ({"title": f"{title}t"}, f"at most {LONGEST_LINE} characters"),
        ({"name": "n" * 101}, "at most 100 letters"),
        ({"servo_name": (*whole.servo_name, "one more")}, f"at most {MOST_SERVOS}"),
    ):
        with pytest.raises(VehicleError, match=allowed):
            whole.replace(**changes)
    assert whole.replace(name="n" * 100).name == "n" * 100
