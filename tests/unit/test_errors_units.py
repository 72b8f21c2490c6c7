from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

from omnimorph.errors import (
    MISSING,
    InputError,
    OmnimorphError,
    RunFileError,
    ScenarioError,
    VehicleError,
    nearest_name,
    shown,
)
from omnimorph.units import UNITS, from_SI, to_SI, unit_of


def test_sentence_of_an_input_error() -> None:
    error = VehicleError.at("omnimorph.toml", "mass_kg", -1.0, "a positive number of kilograms")
    sentence = "omnimorph.toml: mass_kg is -1.0, but it must be a positive number of kilograms."
    assert str(error) == sentence
    assert type(error) is VehicleError
    assert (error.file, error.key, error.value) == ("omnimorph.toml", "mass_kg", -1.0)
    assert error.allowed == "a positive number of kilograms"


@pytest.mark.parametrize("kind", [VehicleError, ScenarioError, RunFileError])
def test_error_tree(kind: type[InputError]) -> None:
    assert issubclass(kind, InputError)
    assert issubclass(InputError, OmnimorphError)
    assert isinstance(kind.at("a.toml", "b", 1, "2"), kind)


def test_missing_key() -> None:
    assert "mass_kg is missing, but it must be" in str(InputError.at("f", "mass_kg", MISSING, "x"))


def test_unknown_key_names_the_nearest() -> None:
    error = InputError.unknown_key("f.toml", "rotor[0].axs", "axs", ["spin", "axis"])
    sentence = (
        "f.toml: rotor[0].axs is not a known key; did you mean axis (allowed here: spin, axis)?"
    )
    assert str(error) == sentence
    assert error.key == "rotor[0].axs"
    far = InputError.unknown_key("f.toml", "zzz", "zzz", ["spin", "axis"])
    assert str(far) == "f.toml: zzz is not a known key; allowed: spin, axis."


def test_errors_survive_a_process_boundary() -> None:
    error = VehicleError.at("f.toml", "mass_kg", -1.0, "positive")
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is VehicleError
    assert (str(copy), copy.key, copy.value) == (str(error), "mass_kg", -1.0)


def test_nearest_name() -> None:
    assert nearest_name("Mass_KG", ["name", "mass_kg"]) == "mass_kg"
    assert nearest_name("zzz", ["name", "mass_kg"]) is None
    assert nearest_name("name", []) is None


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (True, "true"),
        ("cw", '"cw"'),
        ("a\nb", "'a\\nb'"),
        (math.nan, "nan"),
        (np.array([1.0, 2.0]), "[1.0, 2.0]"),
        (np.float64(0.5), "0.5"),
        (list(range(100)), str(list(range(100)))[:79] + "…"),
    ],
)
def test_values_are_shown_on_one_short_line(value: object, text: str) -> None:
    assert shown(value) == text


def test_a_number_of_thousands_of_digits_is_shown_too() -> None:
    assert shown(1 << 20_000) == "a number too long to show"
    assert shown([1 << 20_000]) == "too long to show"


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("mass_kg", "kg"),
        ("inertia_kg_m2", "kg_m2"),
        ("rate_max_deg_per_s", "deg_per_s"),
        ("thrust_coefficient_N_per_Hz2", "N_per_Hz2"),
        ("drag_coefficient_Nm_per_Hz2", "Nm_per_Hz2"),
        ("time_constant_up_ms", "ms"),
        ("name", ""),
        ("Hz", ""),
    ],
)
def test_unit_at_the_end_of_a_key(key: str, unit: str) -> None:
    assert unit_of(key) == unit


def test_conversions_by_hand() -> None:
    assert to_SI(120.0, "Hz") == pytest.approx(753.98223686, rel=1e-10)
    assert to_SI(180.0, "deg") == math.pi
    assert to_SI(60.0, "rpm") == to_SI(1.0, "Hz")
    assert to_SI(20.0, "ms") == 0.02
    assert from_SI(0.25, "mm") == 250.0
    # thrust does not depend on the unit of the speed: 1.8638e-4 N/Hz² (120 Hz)² = 2.683872 N
    thrust = to_SI(1.8638e-4, "N_per_Hz2") * to_SI(120.0, "Hz") ** 2
    assert thrust == pytest.approx(2.683872, rel=1e-14)


@pytest.mark.parametrize("unit", UNITS)
def test_there_and_back(unit: str) -> None:
    values = np.array([-2.5, 0.0, 1e-9, 7.0, 1e12])
    np.testing.assert_allclose(from_SI(to_SI(values, unit), unit), values, rtol=1e-15)
    assert from_SI(to_SI(0.3, unit), unit) == pytest.approx(0.3, rel=1e-15)


def test_unknown_unit() -> None:
    with pytest.raises(ValueError, match="'furlong' is not known"):
        to_SI(1.0, "furlong")
