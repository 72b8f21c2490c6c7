"""Tables show the numbers behind them: one row that is not zero for each unit, cell by cell."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.unit.conftest import build_random_run
from tests.unit.drawn import panels_of, xy

import omnimorph as om
from omnimorph.protocols import FloatArray
from omnimorph.report.tables import (
    metrics_table,
    number,
    plant_table,
    source_table,
    trajectory_table,
)
from omnimorph.results.metrics import MEASURES
from omnimorph.studies.comparison import (
    Compared,
    _draw_numbers,
    compare,
    comparison_data,
    flight_table,
    platform_table,
)
from omnimorph.units import from_SI, unit_of

OMNIMORPH = om.load_vehicle("omnimorph")
# What people call the unit of a key; the others are shown as they are.
SHOWN = {"m": ("mm", "mm"), "rad": ("deg", "°"), "deg": ("deg", "°"), "": ("", "–")}
SHOWN |= {"deg_per_s": ("deg_per_s", "°/s")}


def shown_unit(key: str) -> tuple[str, str]:
    """Return the unit in which a metric is read, as a suffix and as it is written."""
    if key.endswith("_share"):
        return "percent", "%"
    if key.endswith("energy_paper"):
        return "", "“J”"
    unit = unit_of(key)
    return SHOWN.get(unit, (unit, unit))


@pytest.mark.parametrize("key", MEASURES)
def test_measures_are_read_in_the_unit_they_name(key: str) -> None:
    measure = MEASURES[key]
    unit, words = shown_unit(key)
    assert measure.unit == words
    assert measure.factor == pytest.approx(from_SI(1.0, unit) / from_SI(1.0, unit_of(key)))


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ("position_error", "position error"),
        ("attitude_error", "attitude error"),
        ("tilt_", "tilt"),
        ("_mean", "mean"),
        ("_rms", "root mean square"),
        ("_max", "largest|fastest"),
        ("_min", "smallest"),
        ("_last_second", "last second"),
        ("acceleration_energy", "accelerate"),
        ("drag_energy", "drag"),
        ("_paper", "paper"),
    ],
)
def test_measures_are_called_what_their_keys_say(part: str, words: str) -> None:
    for key, measure in MEASURES.items():
        if part in key:
            assert any(word in measure.label for word in words.split("|")), key


def test_every_metric_is_shown_in_its_row_and_column() -> None:
    keys = [key for key in MEASURES if key != "unproven_steps"]
    hover = om.fly(om.load_scenario("hover")).metrics
    numbers: list[dict[str, Any]] = [
        {key: begin + k / 7.0 for k, key in enumerate(keys)} for begin in (1.0, 2.0)
    ]
    first, second = (replace(hover, **one, unproven_steps=7) for one in numbers)
    table = metrics_table("", {"first": first, "second": second})
    rows = {row[0]: row[1:] for row in table.rows}
    for key, measure in MEASURES.items():
        cells = [number(measure.factor * getattr(one, key)) for one in (first, second)]
        assert rows[measure.label] == [*cells, measure.unit]
    assert table.head == ["", "first", "second", "unit"]


# --- plant, sources, trajectory -------------------------------------------------------------------

EFFECTS: dict[str, tuple[dict[str, Any], tuple[str, ...]]] = {
    "command-delay": ({"time_ms": 7.0}, ("time 7 ms",)),
    "rotor-lag": ({"up_ms": 21.0, "down_ms": 34.0}, ("up 21 ms", "down 34 ms")),
    "speed-limits": ({"largest_Hz": 150.0}, ("largest 150 Hz",)),
    "dead-band": (
        {"smallest_Hz": 12.0, "reversal_time_ms": 90.0},
        ("smallest 12 Hz", "reversal time 90 ms"),
    ),
    "effectiveness": ({"share": 0.9}, ("share 0.9",)),
    "model-mismatch": ({"mass": 1.1, "inertia": 0.8}, ("mass 1.1", "inertia 0.8")),
    "servo-lag": ({"time_constant_ms": 40.0}, ("time constant 40 ms",)),
    "servo-rate-limit": ({"rate_deg_per_s": 55.0}, ("rate 55°/s",)),
    "measurement-noise": (
        {"position_mm": 1.5, "velocity_cm_per_s": 2.5, "attitude_mrad": 3.5,
         "rate_mrad_per_s": 4.5},
        ("position 1.5 mm", "velocity 2.5 cm/s", "attitude 3.5 mrad", "rate 4.5 mrad/s"),
    ),
    "constant-wrench": (
        {"force_N": [1.0, 2.0, 3.0], "torque_Nm": [4.0, 5.0, 6.0]},
        ("force (1, 2, 3) N", "torque (4, 5, 6) N m"),
    ),
    "sine-wrench": (
        {"force_N": [1.0, 0.0, 0.0], "frequency_Hz": 3.0, "phase_deg": 20.0},
        ("frequency 3 Hz", "phase 20°"),
    ),
}  # fmt: skip
OWN_VALUES = {
    "rotor-lag": ("up 21 ms", "down 34 ms"),
    "speed-limits": ("speed min −160 Hz", "speed max 170 Hz"),
    "dead-band": ("dead band 11 Hz",),
    "servo-lag": ("servo time constant 45 ms",),
    "servo-rate-limit": ("servo rate max 85°/s",),
}
MARKED = OMNIMORPH.replace(  # a number of its own for each unit
    time_constant_up=np.full(8, 0.021),
    time_constant_down=np.full(8, 0.034),
    speed_min=np.full(8, -160.0 * 2 * np.pi),
    speed_max=np.full(8, 170.0 * 2 * np.pi),
    dead_band=np.full(8, 11.0 * 2 * np.pi),
    servo_time_constant=[0.045],
    servo_rate_max=[np.radians(85.0)],
    filter_cutoff=np.full(4, 13.0 * 2 * np.pi),
)


def rows_of_plant(*effects: dict[str, Any]) -> dict[str, str]:
    run = build_random_run(vehicle=MARKED)
    text = json.dumps({"plant": {"integrator": "semi-implicit-euler", "effects": effects}})
    provenance = replace(
        run.provenance, scenario_text=text, physics_step=0.0005, control_period=0.003
    )
    return {row[0]: row[1] for row in plant_table(replace(run, provenance=provenance)).rows}


def test_steps_and_periods_of_a_plant() -> None:
    rows = rows_of_plant()
    assert (rows["physics step"], rows["control period"]) == ("0.5 ms", "3 ms")


@pytest.mark.parametrize("kind", EFFECTS)
def test_numbers_of_an_effect_have_their_units(kind: str) -> None:
    numbers, reported = EFFECTS[kind]
    shown = rows_of_plant({"kind": kind, **numbers})[kind.replace("-", " ")]
    for words in reported:
        assert words in shown


def test_what_is_switched_on_is_named_and_what_is_off_is_not() -> None:
    for filtered in (True, False):
        noise = {"kind": "measurement-noise", "position_mm": 1.5, "filtered": filtered}
        shown = rows_of_plant(noise)["measurement noise"]
        assert shown == "position 1.5 mm" + (", filtered" if filtered else "")


@pytest.mark.parametrize("kind", OWN_VALUES)
def test_numbers_of_the_vehicle_have_their_units(kind: str) -> None:
    shown = rows_of_plant({"kind": kind})[kind.replace("-", " ")]
    for words in OWN_VALUES[kind]:
        assert words in shown


def per_Hz2(coefficient: FloatArray) -> str:
    return number(4.0 * np.pi**2 * float(coefficient[0]))


def test_every_field_of_a_vehicle_has_its_unit() -> None:
    reported = {
        "time_constant_up": "21 ms",
        "time_constant_down": "34 ms",
        "speed_min": "−160 Hz",
        "speed_max": "170 Hz",
        "dead_band": "11 Hz",
        "servo_time_constant": "45 ms",
        "servo_rate_max": "85°/s",
        "servo_angle_min": "0°",
        "servo_angle_max": "60°",
        "filter_cutoff": "13 Hz",
        "mass": f"{OMNIMORPH.mass:.4g} kg",
        "thrust_coefficient": f"{per_Hz2(OMNIMORPH.thrust_coefficient)} N/Hz²",
        "drag_coefficient": f"{per_Hz2(OMNIMORPH.drag_coefficient)} N m/Hz²",
        "spin_inertia": f"{number(OMNIMORPH.spin_inertia[0])} kg m²",
    }
    source = next(iter(OMNIMORPH.sources.values()))
    sourced = MARKED.replace(sources={**MARKED.sources, **dict.fromkeys(reported, source)})
    rows = source_table(sourced, "", list(reported)).rows
    assert {row[0]: row[1] for row in rows} == {k.replace("_", " "): v for k, v in reported.items()}
    assert {row[2] for row in rows} == {source.text}


def test_every_segment_of_a_trajectory_is_reported_at_its_time() -> None:
    segments = [
        {"duration_s": 2.0, "move_m": [0.0, 0.0, 1.5]},
        {"duration_s": 3.5},
        {"duration_s": 1.0, "rotation_angle_deg": -30.0, "rotation_axis_W": [1.0, 0.0, 0.0]},
        {"duration_s": 4.0, "move_m": [0.5, 0, 0], "rotation_angle_deg": 90.0},
    ]
    run = build_random_run()
    text = json.dumps({"reference": {"segment": segments}})
    table = trajectory_table(replace(run, provenance=replace(run.provenance, scenario_text=text)))
    assert table.rows == [
        ["0 to 2", "move by (0, 0, 1.5) m"],
        ["2 to 5.5", "rest"],
        ["5.5 to 6.5", "turn by −30° about (1, 0, 0)"],
        ["6.5 to 10.5", "move by (0.5, 0, 0) m and turn by 90° about (0, 0, 1)"],
    ]


# --- comparison -----------------------------------------------------------------------------------


@cache
def compared() -> list[Compared]:
    return compare([om.load_vehicle("quadrotor"), om.load_vehicle("omnicopter")], seed=1)


def test_cells_of_a_comparison_are_its_data() -> None:
    data = comparison_data(compared())["vehicles"]
    for shown, flown, reported in zip(
        platform_table(compared()).rows, flight_table(compared()).rows, data, strict=True
    ):
        keys = ("radius_over_weight", "lateral_over_weight", "hover_power_W_per_kg")
        numbers = [number(reported[key], 3) for key in ("mass_kg", *keys)]
        counts = [str(reported["rotors"]), str(reported["servos"])]
        assert shown[:-1] == [reported["vehicle"], *counts, *numbers]
        assert reported["actuation"] in shown[-1]
        assert reported["thrust"] in shown[-1]
        flight = reported["flight"]
        assert flown == [
            reported["vehicle"],
            reported["outcome"],
            number(1e3 * flight["position_error_mean_m"], 3),
            number(1e3 * flight["position_error_max_m"], 3),
            number(np.degrees(flight["attitude_error_mean_rad"]), 3),
            number(flight["drag_energy_J"] / reported["mass_kg"], 4),
        ]


def test_panels_of_a_comparison_are_its_data() -> None:
    data = comparison_data(compared())["vehicles"]
    panels = panels_of(_draw_numbers(compared()))
    expected = {
        "radius": [reported["radius_over_weight"] for reported in data],
        "sideways": [reported["lateral_over_weight"] for reported in data],
        "hover": [reported["hover_power_W_per_kg"] for reported in data],
        "position error": [1e3 * reported["flight"]["position_error_mean_m"] for reported in data],
    }
    for panel, (name, values) in zip(panels, expected.items(), strict=True):
        assert panel.get_xlabel().replace("\n", " ").startswith(name)
        dots = next(line for line in panel.lines if line.get_marker() == "o")
        np.testing.assert_array_equal(xy(dots), np.column_stack([values, range(len(data))]))
    rows = [tick.get_text() for tick in panels[0].get_yticklabels()]
    assert rows == [reported["vehicle"] for reported in data]


def test_a_comparison_flies_with_its_seed() -> None:
    quadrotor = compared()[0]
    tour = om.load_scenario("tour").for_vehicle(quadrotor.vehicle)
    assert quadrotor.flown == om.fly(tour, seed=1).metrics != om.fly(tour, seed=0).metrics
