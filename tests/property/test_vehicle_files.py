"""Any vehicle survives its file; any damaged file is refused in one sentence."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimorph.design import Source, Vehicle, load_vehicle, parse_vehicle, vehicle_text
from omnimorph.design.keys import FIELDS, FILE_KEYS
from omnimorph.errors import VehicleError
from omnimorph.protocols import FloatArray
from omnimorph.units import UNITS, unit_of

# --- any vehicle --------------------------------------------------------------------------------

names = st.builds(str.__add__, st.sampled_from("aZ0"), st.text("bY1._-", max_size=5))
lines = st.text(min_size=1, max_size=20).filter(str.isprintable)
one_spaced = lines.map(lambda text: " ".join(text.split())).filter(bool)


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Draw numbers of a size that means something: no 1e-300, but zero of either sign."""
    return st.floats(low, high).map(lambda x: x if abs(x) >= 1e-12 else x * 0.0)


@st.composite
def arrays(draw: st.DrawFn, shape: tuple[int, ...], low: float, high: float) -> FloatArray:
    """Draw up to three numbers and repeat them; one alone may stand in ``[rotor_defaults]``."""
    return np.resize(draw(st.lists(numbers(low, high), min_size=1, max_size=3)), shape)


@st.composite
def unit_vectors(draw: st.DrawFn) -> FloatArray:
    """Draw an axis of a length within 1 % of one."""
    polar, azimuth = draw(numbers(0.0, np.pi)), draw(numbers(-np.pi, np.pi))
    level = np.sin(polar)
    axis = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.cos(polar)])
    return np.asarray(axis * draw(numbers(0.995, 1.005)))


@st.composite
def inertias(draw: st.DrawFn) -> FloatArray:
    """Draw the inertia of a body that exists: J = tr(S) 1 - S for any positive definite S."""
    if draw(st.booleans()):
        second_moments = np.diag(draw(arrays((3,), 1e-4, 10.0)))
    else:
        root = draw(arrays((3, 3), -1.0, 1.0))
        second_moments = root @ root.T + 1e-3 * np.eye(3)
    return np.asarray(np.trace(second_moments) * np.eye(3) - second_moments)


@st.composite
def servos(draw: st.DrawFn) -> dict[str, Any]:
    """Draw the servos of a vehicle, often none."""
    servo_name = tuple(draw(st.lists(names, max_size=4, unique=True)))
    m = len(servo_name)
    middle = draw(arrays((m,), -3.0, 3.0))
    return {
        "servo_name": servo_name,
        "servo_angle_min": middle - draw(arrays((m,), 0.0, 3.0)),
        "servo_angle_max": middle + draw(arrays((m,), 0.0, 3.0)),
        "servo_rate_max": draw(arrays((m,), 1e-3, 100.0)),
        "servo_time_constant": draw(arrays((m,), 0.0, 1.0)),
    }


@st.composite
def rotors(draw: st.DrawFn, n: int, m: int) -> dict[str, Any]:
    """Draw the rotors of a vehicle with m servos."""
    rotor_servo = np.resize(draw(st.lists(st.integers(-1, m - 1), min_size=1, max_size=4)), n)
    axes = draw(st.lists(unit_vectors(), min_size=2, max_size=2))
    speed_max = draw(arrays((n,), 10.0, 3000.0))
    return {
        "rotor_position": draw(arrays((n, 3), -2.0, 2.0)),
        "rotor_axis": np.tile(axes[0], (n, 1)),
        "hinge_axis": np.outer(rotor_servo >= 0, axes[1]),
        "rotor_servo": rotor_servo,
        "rotor_spin": np.resize([1.0, draw(st.sampled_from([-1.0, 1.0]))], n),
        "thrust_coefficient": draw(arrays((n,), 1e-9, 1e-2)),
        "drag_coefficient": draw(arrays((n,), 1e-12, 1e-3)),
        "speed_min": speed_max - draw(arrays((n,), 1.0, 6000.0)),
        "speed_max": speed_max,
        "dead_band": draw(st.sampled_from([np.zeros(n), None])),
        "time_constant_up": draw(arrays((n,), 0.0, 1.0)),
        "time_constant_down": draw(arrays((n,), 0.0, 1.0)),
        "spin_inertia": draw(arrays((n,), 0.0, 1e-2)),
    }


@st.composite
def vehicles(draw: st.DrawFn) -> Vehicle:
    """Draw a vehicle of 1 to 18 rotors."""
    of_servos = draw(servos())
    n = draw(st.integers(1, 6) | st.just(18))
    of_rotors = draw(rotors(n, len(of_servos["servo_name"])))
    if of_rotors["dead_band"] is None:
        low, high = of_rotors["speed_min"], of_rotors["speed_max"]
        of_rotors["dead_band"] = 0.5 * np.where(low < 0, np.minimum(-low, high), high)
    mass = draw(numbers(1e-3, 1e3))
    # Fields that came later, whichever they are: of any numbers within their limits.
    shapes = {
        field: field.whole_shape(n, len(of_servos["servo_name"]))
        for field in FIELDS.values()
        if field.is_optional and field.name != "tilt_mechanism_mass"
    }
    others: dict[str, Any] = {
        field.name: draw(arrays(shape, field.limits_in_SI.least, field.limits_in_SI.most))
        for field, shape in shapes.items()
        if field.limits_in_SI is not None
    }
    reported = st.builds(Source, text=one_spaced, assumed=st.booleans())
    return Vehicle(
        name=draw(names),
        title=draw(lines),
        mass=mass,
        tilt_mechanism_mass=draw(numbers(-0.0, 0.99 * mass)),
        inertia=draw(inertias()),
        filter_cutoff=draw(arrays((4,), 0.0, 1e4)),
        sources=draw(st.dictionaries(st.sampled_from(sorted(FILE_KEYS)), reported, max_size=4)),
        questioned=False,
        **of_rotors,
        **of_servos,
        **others,
    )


def steps_apart(one: FloatArray, other: FloatArray) -> float:
    """Return the largest difference in units in the last place."""
    larger = np.maximum(np.abs(one), np.abs(other))
    return float(np.max(np.abs(one - other) / np.spacing(larger), initial=0.0))


@given(vehicles())
def test_any_vehicle_survives_its_file(vehicle: Vehicle) -> None:
    text = vehicle_text(vehicle)
    again = parse_vehicle(text, "any.toml", questioned=False)
    for attribute in Vehicle.__dataclass_fields__:
        old, new = getattr(vehicle, attribute), getattr(again, attribute)
        converted = UNITS[unit_of(FILE_KEYS.get(attribute, ""))] != 1.0
        if converted or attribute == "filter_cutoff":
            assert steps_apart(old, new) <= 1.0, attribute
        else:
            np.testing.assert_equal(new, old, err_msg=attribute)
    # and what came from a file is stored without any change
    once_more = parse_vehicle(vehicle_text(again), "any.toml", questioned=False)
    assert numbers_of(once_more) == numbers_of(again)


def numbers_of(vehicle: Vehicle) -> list[bytes]:
    values = [getattr(vehicle, name) for name in Vehicle.__dataclass_fields__]
    return [value.tobytes() for value in values if isinstance(value, np.ndarray)]


# --- any damage ---------------------------------------------------------------------------------

OMNIMORPH = vehicle_text(load_vehicle("omnimorph")).split("[sources]")[0]
ENTRY = re.compile(r"^(\w+) = (.*)$", re.MULTILINE)
ENTRIES = list(ENTRY.finditer(OMNIMORPH))
MAY_BE_LEFT_OUT = re.compile(
    r"tilt_mechanism_mass_kg|axis|dead_band_Hz|time_constant.*|spin_inertia_kg_m2|\w+_cutoff_Hz",
    re.ASCII,
)
ALL_KEYS = {entry[1] for entry in ENTRIES} | {"thrust_min_N", "thrust_max_N"}

entries = st.sampled_from(ENTRIES)


def dotted_key(entry: re.Match[str], name: str | None = None) -> str:
    """Return the full key of an entry, ``rotor[2].axis``, by counting the tables above it."""
    tables = re.findall(r"^\[+(\w+)\]+$", OMNIMORPH[: entry.start()], re.MULTILINE)
    key = name or entry[1]
    if not tables:
        return key
    table = tables[-1]
    index = f"[{tables.count(table) - 1}]" if table in {"rotor", "servo"} else ""
    return f"{table}{index}.{key}"


def refusal(text: str) -> VehicleError:
    """Return the one error that a text gives, after checking its form."""
    with pytest.raises(VehicleError) as caught:
        parse_vehicle(text, "damaged.toml")
    assert str(caught.value).startswith("damaged.toml: ")
    assert str(caught.value).isprintable()
    assert str(caught.value)[-1] in ".?"
    return caught.value


@given(entries.filter(lambda entry: not MAY_BE_LEFT_OUT.fullmatch(entry[1])))
def test_missing_entry(entry: re.Match[str]) -> None:
    error = refusal(OMNIMORPH[: entry.start()] + OMNIMORPH[entry.end() :])
    if entry[1] in {"speed_min_Hz", "speed_max_Hz"} or "coefficient" in entry[1]:
        assert error.key == f"rotor[0].{entry[1]}"  # missed where it is needed
    else:
        assert error.key == dotted_key(entry)
    assert f"{error.key} is missing" in str(error)


@given(entries, st.data())
def test_misspelt_key(entry: re.Match[str], data: st.DataObject) -> None:
    key = entry[1]
    place = data.draw(st.integers(0, len(key) - 1))
    letter = data.draw(st.sampled_from(["", "_", "x", key[place] * 2, "Z"]))
    wrong = key[:place] + letter + key[place + 1 :]
    if not wrong or wrong in ALL_KEYS:
        return
    error = refusal(OMNIMORPH[: entry.start(1)] + wrong + OMNIMORPH[entry.end(1) :])
    assert error.key == dotted_key(entry, wrong)
    assert f"{error.key} is not a known key; " in str(error)
    if len(key) > 5:
        assert "did you mean " in str(error)


never_right = st.sampled_from(
    [
        "nan",
        "-inf",
        "true",
        "[]",
        "{}",
        "[nan, 0.0, 1.0]",
        "[1.0, 2.0]",
        "12:30:00",
        "-1e400",
        "1e-400",
    ]
)


@given(entries, never_right)
def test_wrong_value(entry: re.Match[str], value: str) -> None:
    key = dotted_key(entry)
    fits = r".*(_Hz|_ms|_deg|kg_m2|mechanism_mass_kg)"  # 1e-400 is read as zero, which these may be
    if value == "1e-400" and re.fullmatch(fits, key):
        value = "nan"
    error = refusal(OMNIMORPH[: entry.start(2)] + value + OMNIMORPH[entry.end(2) :])
    assert error.key == key
    assert f"{key} is " in str(error)
    assert ", but it must be " in str(error)


@given(st.integers(0, len(OMNIMORPH) - 1), st.text(max_size=3))
def test_any_slip_of_the_pen_gives_a_vehicle_or_one_sentence(place: int, slip: str) -> None:
    text = OMNIMORPH[:place] + slip + OMNIMORPH[place + 1 :]
    message = "damaged.toml: "
    try:
        parse_vehicle(text, "damaged.toml")
    except VehicleError as error:
        message = str(error)
    assert message.startswith("damaged.toml: ")
    assert message.isprintable()


@given(st.text(max_size=200))
def test_any_text_gives_one_sentence(text: str) -> None:
    error = refusal(text)
    assert error.file == "damaged.toml"
