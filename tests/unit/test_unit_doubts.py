"""Numbers of a vehicle in another unit than their key says are questioned; others are not."""

from __future__ import annotations

import dataclasses
import json
import math
import pickle
import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.physics.small_vehicles import build_vehicle

import omnimorph as om
from omnimorph.analysis import hover
from omnimorph.cli import console
from omnimorph.cli.main import main
from omnimorph.design.files import parse_vehicle, vehicle_text
from omnimorph.design.new_vehicle import KINDS, new_vehicle_text
from omnimorph.design.unit_doubts import unit_doubts
from omnimorph.design.vehicle import Vehicle

ROOT = Path(__file__).parents[2]
TURN = 2.0 * math.pi
SPEEDS, THRUST, DRAG = "speed_(?:min|max)_Hz", "thrust_coefficient_N_per_Hz2", "drag_coefficient_"
FAST = r"rotor_defaults\.speed_max_Hz is .* (m\/s|the weight); it looks like "
WEAK = r"rotor_defaults\.thrust_coefficient_N_per_Hz2 is .*: all rotors .*; it looks "

# What is multiplied by what, and what is said: (keys, factors, sentence).
SLIPS: dict[str, tuple[Sequence[str], Sequence[float], str]] = {
    "speeds in rpm": ([SPEEDS], [60.0], FAST + r"rpm\.$"),
    "speeds in rad/s": ([SPEEDS], [TURN], FAST + r"rad/s\.$"),
    "coefficients per rpm²": (
        [THRUST, DRAG],
        [60.0**-2] * 2,
        WEAK + r"like N/rpm² and drag_coefficient_Nm_per_Hz2 like N m/rpm²\.$",
    ),
    "coefficients per (rad/s)²": (
        [THRUST, DRAG],
        [TURN**-2] * 2,
        WEAK + r"like N s²/rad² and drag_coefficient_Nm_per_Hz2 like N m s²/rad²\.$",
    ),
    "coefficients converted twice": (
        [THRUST, DRAG],
        [3600.0] * 2,
        WEAK + r"about 3600 times too large\.$",
    ),
    "all in rpm": (
        [SPEEDS, THRUST, DRAG],
        [60.0, 60.0**-2, 60.0**-2],
        FAST + r"rpm, thrust_coefficient_N_per_Hz2 like N/rpm² and drag_.* like N m/rpm²\.$",
    ),
    "all in rad/s": (
        [SPEEDS, THRUST, DRAG],
        [TURN, TURN**-2, TURN**-2],
        FAST + r"rad/s, thrust_coeff.* like N s²/rad² and drag_.* like N m s²/rad²\.$",
    ),
    "drag per rpm²": ([DRAG], [60.0**-2], r"drag_.*_Hz2 is .* m; it looks like N m/rpm²\.$"),
    "drag per (rad/s)²": ([DRAG], [TURN**-2], r"drag_.*_Hz2 is .*; it looks like N m s²/rad²\.$"),
    "mass in g": (["mass_kg"], [1e3], r"^x\.toml: mass_kg is .*weight; it looks like g\.$"),
    "inertia in g cm²": (["inertia_kg_m2"], [1e7], r"inertia_kg_m2 is .*looks .*like g cm²\.$"),
    "inertia in kg cm²": (["inertia_kg_m2"], [1e4], r"inertia_kg_m2 is .*looks .*like kg cm²\.$"),
    "hubs in mm": (["position_m"], [1e3], r"rotor\[\d\]\.position_m is .* m .*; it looks like mm"),
    "tilt in rad": (
        ["angle_(?:min|max)_deg"],
        [math.radians(1.0)],
        r"servo\[0\]\.angle_max_deg is .*° at most; it looks like rad\.$",
    ),
}
QUICK = {"omnimorph", "quadrotor", "voliro"}
CASES = [
    pytest.param(name, slip, marks=() if name in QUICK else pytest.mark.slow)
    for name in om.list_vehicles()
    for slip in SLIPS
    # its propellers overlap, so the largest that do not are half as large and half as fast
    if (name, slip) != ("omnicopter", "all in rad/s")
]


def reported(text: str) -> list[str]:
    """Return what is said about a file."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        parse_vehicle(text, "x.toml")
    assert all(one.category is om.UnlikelyUnitWarning for one in caught)
    return [str(one.message) for one in caught]


def multiplied(text: str, key: str, factor: float) -> str:
    def times(match: re.Match[str]) -> str:
        return match[1] + repr((factor * np.array(json.loads(match[2]))).tolist())

    return re.sub(rf"(?m)^({key}\w* = )(.+)$", times, text)


def with_slip(name: str, slip: str) -> str:
    text = re.sub("(?m)^tilt_mechanism.*$", "", vehicle_text(om.load_vehicle(name)))
    for key, factor in zip(*SLIPS[slip][:2], strict=True):
        text = multiplied(text, key, factor)
    return text


@pytest.mark.parametrize(("name", "slip"), CASES)
def test_a_slip_of_a_unit_is_named(name: str, slip: str) -> None:
    found = reported(with_slip(name, slip))
    if slip == "tilt in rad" and not om.load_vehicle(name).n_servos:
        assert found == []
        return
    (sentence,) = found
    assert re.search(SLIPS[slip][2], sentence)
    assert sentence.startswith("x.toml: ")


QUADROTOR = """
schema = 1
name = "nano"
title = "A quadrotor of 27 g whose numbers are in rpm"
mass_kg = 0.027
inertia_kg_m2 = [1.4e-5, 1.4e-5, 2.2e-5]

[rotor_defaults]
thrust_coefficient_N_per_Hz2 = 2.63e-10
drag_coefficient_Nm_per_Hz2 = 6.03e-12
speed_min_Hz = 0.0
speed_max_Hz = 24000.0

[[rotor]]
position_m = [0.0325, -0.0325, 0.0]
spin = "ccw"

[[rotor]]
position_m = [-0.0325, -0.0325, 0.0]
spin = "cw"

[[rotor]]
position_m = [-0.0325, 0.0325, 0.0]
spin = "ccw"

[[rotor]]
position_m = [0.0325, 0.0325, 0.0]
spin = "cw"

[filter]
position_cutoff_Hz = 0.0
velocity_cutoff_Hz = 0.0
attitude_cutoff_Hz = 0.0
rate_cutoff_Hz = 0.0

[assumed]
mass_kg = "for a test"
inertia_kg_m2 = "for a test"
rotor.position_m = "for a test"
rotor.axis = "for a test"
rotor.spin = "for a test"
rotor.thrust_coefficient_N_per_Hz2 = "for a test"
rotor.drag_coefficient_Nm_per_Hz2 = "for a test"
rotor.speed_min_Hz = "for a test"
rotor.speed_max_Hz = "for a test"
"""


def in_hertz(text: str) -> str:
    """Return the quadrotor with its numbers in the units that the keys say."""
    for key, factor in ((THRUST, 3600.0), (DRAG, 3600.0), (SPEEDS, 1.0 / 60.0)):
        text = multiplied(text, key, factor)
    return text


def test_a_nano_quadrotor_in_rpm_would_take_sixty_times_its_power() -> None:
    assert reported(in_hertz(QUADROTOR)) == []
    assert hover(parse_vehicle(in_hertz(QUADROTOR), "x"), []).power == pytest.approx(10.1, abs=0.1)
    (sentence,) = reported(QUADROTOR)
    assert sentence == (
        "x.toml: rotor_defaults.speed_max_Hz is 24000.0: the largest propellers that fit between "
        "the hubs, of 31.2 mm radius, have tips at 4705 m/s, and only below 1.99 mm do they stay "
        "under 300 m/s; it looks like rpm, thrust_coefficient_N_per_Hz2 like N/rpm² and "
        "drag_coefficient_Nm_per_Hz2 like N m/rpm²."
    )
    with pytest.warns(om.UnlikelyUnitWarning):
        wrong = parse_vehicle(QUADROTOR, "x")
    assert hover(wrong, []).power == pytest.approx(605.0, abs=5.0)


def test_limits_given_as_thrusts_leave_the_coefficient_in_doubt() -> None:
    text = QUADROTOR.replace("speed_min_Hz = 0.0\n", "thrust_min_N = 0.0\n", 1)
    text = text.replace("speed_max_Hz = 24000.0", "thrust_max_N = 0.15")
    text = text.replace("rotor.speed_min_Hz", "rotor.thrust_min_N")
    text = text.replace("rotor.speed_max_Hz", "rotor.thrust_max_N")
    (sentence,) = reported(text)
    assert "rotor_defaults.thrust_coefficient_N_per_Hz2 is 2.63e-10: the largest" in sentence
    assert sentence.endswith("like N/rpm² and drag_coefficient_Nm_per_Hz2 like N m/rpm².")


@pytest.mark.parametrize("command", [["analyze"], ["vehicles"], ["gains"]])
def test_the_command_line_says_it_once_and_goes_on(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "nano.toml"
    path.write_text(QUADROTOR, encoding="utf-8")
    assert main([*command, str(path), "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)
    (line,) = err.splitlines()
    assert line.startswith(f"omnimorph: {path}: rotor_defaults.speed_max_Hz is 24000.0: ")
    assert line.endswith("like N m/rpm².")


def test_a_file_that_is_read_twice_is_questioned_once(capsys: pytest.CaptureFixture[str]) -> None:
    with console.printed_warnings():
        parse_vehicle(QUADROTOR, "nano.toml")
        parse_vehicle(QUADROTOR, "nano.toml")
        parse_vehicle(QUADROTOR, "other.toml")
    lines = capsys.readouterr().err.splitlines()
    assert [line.split()[1] for line in lines] == ["nano.toml:", "other.toml:"]


def test_a_stored_run_is_not_questioned_again(tmp_path: Path) -> None:
    path = tmp_path / "in-rpm.toml"
    path.write_text(with_slip("quadrotor", "all in rpm"), encoding="utf-8")
    with pytest.warns(om.UnlikelyUnitWarning, match="looks like rpm"):
        vehicle = om.load_vehicle(path)
    om.fly(om.load_scenario("tour").for_vehicle(vehicle)).save(tmp_path / "run.nc")
    assert om.load_run(tmp_path / "run.nc").vehicle.mass == vehicle.mass


# --- vehicles built in Python -------------------------------------------------------------------

VOLIRO = om.load_vehicle("voliro")


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"mass": 1e3}, "mass is 1920.0: .*; it looks like g"),
        ({"speed_max": 1 / TURN, "speed_min": 1 / TURN}, r"speed_max\[0\] is 133.* looks like Hz"),
        (
            {"speed_max": 60 / TURN},
            r"speed_max\[0\] is 8002.* tips at 1440 m/s, .*; it looks like rpm",
        ),
        (
            {"thrust_coefficient": TURN**2, "drag_coefficient": TURN**2},
            r"thrust_coefficient\[0\] is .* like N/Hz² and drag_coefficient like N m/Hz²",
        ),
        ({"servo_angle_max": 180 / math.pi}, r"servo_angle_max\[0\] is 171.*it looks like degrees"),
    ],
)
def test_in_python_numbers_are_questioned_in_SI(changes: dict[str, float], sentence: str) -> None:
    values: dict[str, Any] = {name: getattr(VOLIRO, name) * f for name, f in changes.items()}
    with pytest.warns(om.UnlikelyUnitWarning, match=f"^vehicle voliro: {sentence}") as caught:
        built = dataclasses.replace(VOLIRO, **values)
    assert len(caught) == 1
    pickle.loads(pickle.dumps(built))  # copies are silent
    assert built.replace(title="A copy").mass == built.mass
    dataclasses.replace(VOLIRO, questioned=False, **values)


HALF_WAY = np.array([0.0, 0.0, 0.03])


def coaxial_octocopter() -> Vehicle:
    """Return eight propellers of 30 inches in four pairs, 60 mm apart: 20 kg."""
    angle = 0.5 * math.pi * np.arange(4)
    arm = 0.75 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(4)])
    values: dict[str, Any] = {
        "spin_inertia": 1e-3,
        "rotor_spin": np.repeat([1.0, -1.0], 4),
        "speed_min": 0.0,
    }
    values |= {"thrust_coefficient": 9.4e-4, "drag_coefficient": 3.3e-5, "speed_max": 75.0 * TURN}
    hubs = np.concatenate([arm + HALF_WAY, arm - HALF_WAY])
    return build_vehicle(hubs, mass=20.0, inertia=np.diag([1.2, 1.2, 2.2]), **values)


@pytest.mark.parametrize("factor", [1e3, 60.0, TURN])
def test_pairs_on_one_axis_are_questioned_as_other_vehicles(factor: float) -> None:
    octocopter = coaxial_octocopter()
    assert unit_doubts(octocopter, "Hz") == []
    changes: dict[str, Any] = {"mass": factor * octocopter.mass}
    if factor < 1e3:
        changes = {"speed_max": factor * octocopter.speed_max}
    (doubt,) = unit_doubts(octocopter.replace(**changes), "Hz")
    assert doubt.attribute in changes
    meant = {1e3: "g", 60.0: "rpm", TURN: "rad/s"}[factor]
    assert ((doubt.attribute, f"like {meant}"),) in doubt.explanations


# --- what is not questioned ---------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_templates_are_not_questioned(kind: Any) -> None:
    for rotors in range(6, 19, 2):
        assert reported(new_vehicle_text("mine", rotors, kind)) == []


def test_a_vehicle_too_heavy_or_odd_without_another_unit_is_not_questioned() -> None:
    quadrotor = om.load_vehicle("quadrotor")
    for changes in (
        {"mass": 3.0 * quadrotor.mass},
        {"mass": 9.0 * quadrotor.mass},
        {"mass": 0.3 * quadrotor.mass},
        {"inertia": 10.0 * quadrotor.inertia},
        {"inertia": 0.02 * quadrotor.inertia},
        {"rotor_position": 0.5 * quadrotor.rotor_position},
        {"drag_coefficient": 4.0 * quadrotor.drag_coefficient},
    ):
        dataclasses.replace(quadrotor, **changes)  # a warning is an error here


def test_rotors_at_one_place_have_no_propeller_to_judge_by() -> None:
    one = om.load_vehicle("quadrotor")
    dataclasses.replace(one, rotor_position=np.zeros((4, 3)), speed_max=60.0 * one.speed_max)
