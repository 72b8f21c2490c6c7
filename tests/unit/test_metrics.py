"""Metrics against flights whose numbers can be worked out by hand."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from omnimorph.design.files import load_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import RunFileError
from omnimorph.results.columns import sizes_of
from omnimorph.results.metrics import Metrics, metrics_from_run
from omnimorph.results.run import COLUMNS, Outcome, Performance, Provenance, Run

STEP = 0.001
TURN = 2.0 * math.pi
OMNIMORPH = load_vehicle("omnimorph")
KEYS = """
    position_error_mean_m position_error_rms_m position_error_max_m attitude_error_mean_rad
    attitude_error_rms_rad attitude_error_max_rad attitude_error_paper
    drag_energy_J drag_energy_paper acceleration_energy_J acceleration_energy_paper
    tilt_mean_deg tilt_max_deg tilt_min_deg
    saturated_share speed_max_Hz power_mean_W kkt_residual_max unproven_steps
    position_error_last_second_m attitude_error_last_second_rad duration_s outcome
"""


def resting_run(rows: int, vehicle: Vehicle = OMNIMORPH, **changes: Any) -> Run:
    """Return a run in which nothing moves, with some columns changed."""
    upright = np.tile(np.eye(3), (rows, 1, 1))
    sizes = sizes_of(vehicle)
    columns: dict[str, Any] = {one.name: np.zeros(one.shape(rows, sizes)) for one in COLUMNS}
    columns |= {"time": STEP * np.arange(rows), "R_WB": upright, "desired_R_WB": upright}
    del columns["drag_power"]
    provenance = Provenance(
        scenario_name="test",
        scenario_text="{}",
        vehicle_text="",
        plant_name="perfect",
        seed=0,
        flight=0,
        control_period=STEP,
        physics_step=STEP,
        version="0",
    )
    performance = Performance(wall_time=1.0, real_time_factor=1.0)
    fields: dict[str, Any] = {
        "outcome": Outcome.COMPLETED,
        "vehicle": vehicle,
        "provenance": provenance,
        "performance": performance,
    }
    given = {**columns, **fields, **changes}
    given.setdefault("drag_power", np.abs(given["speed"]) ** 3 @ vehicle.drag_coefficient)
    return Run(**given)


def turns_about(axis: list[float], angles: list[float]) -> Any:
    """Return the rotations about one axis, written out in full."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    a = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.array([np.eye(3) + np.sin(t) * a + (1 - np.cos(t)) * (a @ a) for t in angles])


def test_hover_at_60_degrees_costs_what_the_model_says() -> None:
    speed = np.full((1001, 8), 131.54 * TURN)
    metrics = resting_run(
        1001, speed=speed, tilt_actual=np.full((1001, 1), np.deg2rad(60.0))
    ).metrics
    assert metrics.duration_s == pytest.approx(1.0)
    assert metrics.power_mean_W == pytest.approx(315.09, rel=2e-4)
    assert metrics.drag_energy_J == pytest.approx(315.09, rel=2e-4)
    assert metrics.drag_energy_paper == pytest.approx(50.148, rel=2e-4)
    assert metrics.speed_max_Hz == pytest.approx(131.54)
    assert metrics.tilt_mean_deg == metrics.tilt_max_deg == pytest.approx(60.0)
    assert metrics.acceleration_energy_J == 0.0


def test_the_speed_at_the_start_costs_nothing() -> None:
    """Row 0 is where the flight begins: no step has been flown at its speed."""
    speed = np.zeros((3, 8))
    speed[0] = -500.0
    metrics = resting_run(3, speed=speed).metrics
    assert metrics.drag_energy_J == 0.0
    assert metrics.acceleration_energy_J == 0.0
    assert metrics.speed_max_Hz == pytest.approx(500.0 / TURN)


def test_only_speeding_up_costs_acceleration_energy() -> None:
    speed = np.zeros((6, 8))
    speed[:, 3] = [0.0, 100.0, 60.0, 60.0, -80.0, 0.0]
    inertia = OMNIMORPH.spin_inertia[3]
    expected = 0.5 * inertia * (100.0**2 + (80.0**2 - 60.0**2))
    metrics = resting_run(6, speed=speed).metrics
    assert metrics.acceleration_energy_J == pytest.approx(expected, rel=1e-12)
    assert metrics.acceleration_energy_paper == pytest.approx(expected / TURN**2, rel=1e-12)


def test_energies_of_each_rotor_use_its_own_coefficients() -> None:
    """A long random flight against the definition written out; blocks must not show."""
    rows = 5000
    factors = np.linspace(0.5, 2.0, 8)
    vehicle = OMNIMORPH.replace(
        drag_coefficient=OMNIMORPH.drag_coefficient * factors,
        spin_inertia=OMNIMORPH.spin_inertia * factors,
    )
    speed = np.random.default_rng(1).uniform(-900.0, 900.0, (rows, 8))
    metrics = resting_run(rows, vehicle, speed=speed).metrics
    drag = sum(
        STEP * vehicle.drag_coefficient[i] * np.sum(np.abs(speed[1:, i]) ** 3) for i in range(8)
    )
    gains = np.maximum(0.0, np.diff(speed**2, axis=0))
    spin_up = sum(0.5 * vehicle.spin_inertia[i] * np.sum(gains[:, i]) for i in range(8))
    assert metrics.drag_energy_J == pytest.approx(drag, rel=1e-12)
    assert metrics.drag_energy_paper == pytest.approx(drag / TURN, rel=1e-12)
    assert metrics.acceleration_energy_J == pytest.approx(spin_up, rel=1e-12)
    assert metrics.speed_max_Hz == pytest.approx(np.abs(speed).max() / TURN, rel=1e-12)


def test_position_error_is_a_distance() -> None:
    p = np.zeros((4, 3))
    p[1:3] = [0.003, 0.004, 0.0]
    metrics = resting_run(4, p_WB=p + 1.0, desired_p_WB=np.ones((4, 3))).metrics
    assert metrics.position_error_mean_m == pytest.approx(0.0025)
    assert metrics.position_error_rms_m == pytest.approx(0.005 / math.sqrt(2.0))
    assert metrics.position_error_max_m == pytest.approx(0.005)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-9, 1e-3, 1.0, 2.0, math.pi - 1e-9, math.pi])
def test_attitude_error_is_exact_from_nothing_to_half_a_turn(angle: float) -> None:
    base = turns_about([1.0, 2.0, 3.0], [0.7])[0]
    turned = base @ turns_about([-2.0, 1.0, 0.5], [angle])[0]
    metrics = resting_run(1, R_WB=base[None], desired_R_WB=turned[None]).metrics
    assert metrics.attitude_error_mean_rad == pytest.approx(angle, abs=3e-15)
    assert metrics.attitude_error_paper == pytest.approx(math.sin(angle), abs=3e-15)


def test_attitude_error_over_many_rows() -> None:
    angles = [*np.linspace(0.0, 3.0, 2500), *np.linspace(0.0, 3.0, 2500)]
    metrics = resting_run(5000, R_WB=turns_about([0.0, 1.0, 1.0], angles)).metrics
    assert metrics.attitude_error_mean_rad == pytest.approx(1.5, abs=1e-12)
    assert metrics.attitude_error_rms_rad == pytest.approx(
        math.sqrt(np.mean(np.square(angles))), abs=1e-12
    )
    assert metrics.attitude_error_max_rad == pytest.approx(3.0, abs=1e-12)
    assert metrics.attitude_error_paper == pytest.approx(np.mean(np.sin(angles)), abs=1e-12)


def test_shares_and_extremes() -> None:
    active = np.zeros((8, 8), dtype=np.int8)
    active[2, 0], active[5, 7], active[5, 1] = 1, -1, 1
    tilt = np.deg2rad([[0.0], [10.0], [20.0], [30.0], [40.0], [50.0], [60.0], [30.0]])
    residual = np.array([1e-12, 3e-10, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    metrics = resting_run(8, active=active, tilt_actual=tilt, kkt_residual=residual).metrics
    assert metrics.saturated_share == 0.25
    assert metrics.tilt_mean_deg == pytest.approx(30.0)
    assert metrics.tilt_max_deg == pytest.approx(60.0)
    assert metrics.tilt_min_deg == 0.0
    assert metrics.kkt_residual_max == 3e-10


def test_tilts_of_several_servos_count_alike() -> None:
    tilt = np.deg2rad([[0.0, 10.0, 20.0, 30.0, 40.0, 50.0], [10.0, 10.0, 10.0, 10.0, 10.0, 10.0]])
    metrics = resting_run(2, load_vehicle("voliro"), tilt_actual=tilt).metrics
    assert metrics.tilt_mean_deg == pytest.approx(17.5)
    assert metrics.tilt_max_deg == pytest.approx(50.0)
    assert metrics.tilt_min_deg == 0.0


def test_a_residual_that_is_not_a_number_is_not_lost_among_others() -> None:
    for row in range(4):
        residual = np.full(4, 1e-12)
        residual[row] = np.nan
        assert math.isnan(resting_run(4, kkt_residual=residual).metrics.kkt_residual_max)


def test_control_steps_that_are_not_proven_are_counted_once_each() -> None:
    """Four physics steps to a control step, and the last row decides nothing."""
    residual = np.repeat([1e-12, 2e-9, 1e-10, 1e-1, 1e-12, 5.0], 4)[:21]
    run = resting_run(21, kkt_residual=residual)
    four = dataclasses.replace(run.provenance, control_period=4 * run.provenance.physics_step)
    assert dataclasses.replace(run, provenance=four).metrics.unproven_steps == 2
    single = dataclasses.replace(four, scenario_text='{"precision": "float32"}')
    assert dataclasses.replace(run, provenance=single).metrics.unproven_steps == 1
    lost = dataclasses.replace(run, provenance=four, outcome=Outcome.LOST)
    assert lost.metrics.unproven_steps == 3


def test_without_a_residual_nothing_is_known_of_proofs() -> None:
    """But a flight whose first decision failed has none that is not proven."""
    for outcome in (Outcome.COMPLETED, Outcome.LOST, Outcome.PART_FAILED):
        run = resting_run(3, kkt_residual=np.full(3, np.nan), outcome=outcome)
        assert math.isnan(run.metrics.unproven_steps)
    failed = resting_run(1, kkt_residual=np.full(1, np.nan), outcome=Outcome.NOT_FINITE)
    assert failed.metrics.unproven_steps == 0


def test_the_last_second_is_judged_alone() -> None:
    rows = 5001  # five seconds
    p = np.zeros((rows, 3))
    p[-1000:, 0] = 0.3
    p[:-1000, 0] = 7.0
    run = resting_run(rows, p_WB=p, desired_p_WB=np.zeros((rows, 3)))
    assert run.metrics.position_error_last_second_m == pytest.approx(0.3)
    assert run.metrics.attitude_error_last_second_rad == 0.0
    lost = dataclasses.replace(run, outcome=Outcome.LOST)
    assert math.isnan(lost.metrics.position_error_last_second_m)


def test_vehicle_without_servos_has_no_tilt() -> None:
    nothing = np.zeros(0)
    fixed = OMNIMORPH.replace(
        hinge_axis=np.zeros((8, 3)),
        rotor_servo=np.full(8, -1),
        servo_name=(),
        servo_angle_min=nothing,
        servo_angle_max=nothing,
        servo_rate_max=nothing,
        servo_time_constant=nothing,
        sources={},
    )
    metrics = resting_run(5, fixed).metrics
    assert metrics.as_dict()["tilt_mean_deg"] is None


@pytest.mark.parametrize("column", ["p_WB", "R_WB", "desired_p_WB", "speed", "tilt_actual"])
def test_a_diverged_flight_is_measured_as_far_as_it_is_finite(column: str) -> None:
    flown = resting_run(100, speed=np.full((100, 8), 500.0), p_WB=np.full((100, 3), 0.1))
    values = np.array(getattr(flown, column))
    values[60:] = np.nan
    values[80:] = np.inf
    changes: Any = {"outcome": Outcome.DIVERGED, column: values}
    diverged = dataclasses.replace(flown, **changes)
    cut = resting_run(60, speed=np.full((60, 8), 500.0), p_WB=np.full((60, 3), 0.1))
    expected = dataclasses.replace(cut, outcome=Outcome.DIVERGED).metrics
    assert diverged.metrics.as_dict() == expected.as_dict()


def test_numbers_too_large_to_square_become_null() -> None:
    metrics = resting_run(3, p_WB=np.full((3, 3), 1e200)).metrics
    assert metrics.position_error_max_m == metrics.position_error_mean_m == math.inf
    assert metrics.as_dict()["position_error_max_m"] is None


def test_a_flight_of_one_row_has_no_mean_power() -> None:
    metrics = resting_run(1).metrics
    assert metrics.duration_s == 0.0
    assert metrics.drag_energy_J == 0.0
    assert metrics.as_dict()["power_mean_W"] is None


def test_a_flight_without_a_finite_row_has_no_numbers_but_an_outcome() -> None:
    run = resting_run(2, desired_p_WB=np.full((2, 3), np.nan), outcome=Outcome.NOT_FINITE)
    values = run.metrics.as_dict()
    assert values.pop("outcome") == "not_finite"
    assert values.pop("duration_s") == 0.0
    assert values.pop("unproven_steps") == 0
    assert set(values.values()) == {None}


def test_metrics_are_kept_and_the_same_again() -> None:
    run = resting_run(10)
    assert run.metrics is run.metrics
    assert metrics_from_run(run) == run.metrics


def test_json_has_the_promised_keys(tmp_path: Path) -> None:
    run = resting_run(1)
    run.metrics.write_json(tmp_path / "metrics.json")
    assert [path.name for path in tmp_path.iterdir()] == ["metrics.json"]
    text = (tmp_path / "metrics.json").read_text(encoding="utf-8")
    values = json.loads(text)
    assert list(values) == [field.name for field in dataclasses.fields(Metrics)]
    assert [key for key in values if key in KEYS.split()] == KEYS.split()
    assert values["outcome"] == "completed"
    assert values["power_mean_W"] is None
    assert "NaN" not in text


def test_json_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    target = tmp_path / "missing" / "metrics.json"
    with pytest.raises(RunFileError, match=r"metrics\.json: it cannot be written: No such file"):
        resting_run(1).metrics.write_json(target)
