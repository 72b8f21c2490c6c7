"""The measurements produce every number and tell where it is from; how fast is not asserted."""

from __future__ import annotations

import json
import math
import os
import sys

import numpy as np
import pytest

from omnimorph.analysis import inscribed_radius
from omnimorph.bench import BenchReport, Measurement, measure
from omnimorph.bench.analysis import (
    forces_of,
    hull_radius,
    nearly_moment_free,
    projected,
    random_thrusts,
    thrust_grid,
)
from omnimorph.bench.measurement import shown
from omnimorph.bench.processes import ProcessCost, cost_of_import
from omnimorph.design import list_vehicles, load_vehicle
from omnimorph.model.allocation import allocation_matrix

NAMES = [
    "core_case_a_steps_per_s",
    "core_case_b_steps_per_s",
    "whole_call_case_a_steps_per_s",
    "textbook_steps_per_s",
    "core_over_textbook",
    "core_textbook_difference_m",
    "realistic_flight_s",
    "first_round_s",
    "many_perfect_steps_per_s",
    "many_over_textbook",
    "many_perfect_float32_steps_per_s",
    "many_threads_gain",
    "many_worn_steps_per_s",
    "many_realistic_flights_per_s",
    "many_largest_over_smallest",
    "control_step_us",
    "control_step_p99_us",
    "control_step_in_core_us",
    "joint_step_omnimorph_us",
    "joint_step_voliro_us",
    "joint_step_omav_12_us",
    "python_controller_steps_per_s",
    "free_moment_radius_us",
    "free_moment_radius_by_grid_us",
    "free_moment_radius_by_random_us",
    "zero_moment_radius_us",
    "zero_moment_radius_by_random_us",
    "zero_moment_radius_by_projection_us",
    "free_moment_grid_error_percent",
    "free_moment_random_error_percent",
    "zero_moment_random_error_percent",
    "zero_moment_projection_error_percent",
    "zero_moment_random_left",
    "tilt_sweep_s",
    "hover_map_s",
    "cold_analysis_page_s",
    "cold_analysis_page_MB",
    "cold_flight_s",
    "cold_flight_MB",
    "import_s",
    "help_s",
]


@pytest.fixture(scope="module")
def report() -> BenchReport:
    reported: list[tuple[int, int]] = []
    report = measure(lambda done, total: reported.append((done, total)), rounds=1)
    assert reported == [(1, 1)]
    return report


@pytest.mark.slow
def test_every_number_is_there(report: BenchReport) -> None:
    assert [row.name for row in report.measurements] == NAMES
    for row in report.measurements:
        assert len(row.samples) == 1
        assert math.isfinite(row.median)
        assert row.median >= 0.0
        assert row.unit
        assert row.what


@pytest.mark.slow
def test_numbers_that_are_known_are_right(report: BenchReport) -> None:
    """Not how fast: what must hold on any machine."""
    assert report["core_textbook_difference_m"].median <= 1e-11
    speed, slow = report["core_case_a_steps_per_s"], report["textbook_steps_per_s"]
    assert report["core_over_textbook"].median == pytest.approx(speed.median / slow.median)
    assert report["control_step_p99_us"].median >= report["control_step_us"].median
    assert report["whole_call_case_a_steps_per_s"].median <= speed.median
    assert 10.0 < report["cold_flight_MB"].median < 2000.0
    assert report["free_moment_grid_error_percent"].median <= 1e-10
    assert report["free_moment_random_error_percent"].median > 1.0
    assert report["zero_moment_random_left"].median < 100.0


@pytest.mark.slow
def test_it_can_be_read_by_programs_and_by_people(report: BenchReport) -> None:
    content = json.loads(json.dumps(report.as_dict(), allow_nan=False))
    assert [row["name"] for row in content["measurements"]] == NAMES
    assert content["measurements"][0]["target"] == 1.5e6
    assert content["provenance"]["cores"].endswith("a flight uses one, a batch all")
    text = report.as_text()
    for row in report.measurements:
        assert row.what in text
    assert content["provenance"]["processor"] in text
    assert [len(row) for row in report.as_rows()] == [len(report.COLUMNS)] * len(NAMES)


@pytest.mark.slow
def test_provenance_names_machine_versions_and_date(report: BenchReport) -> None:
    assert set(report.provenance) >= {"date", "processor", "cores", "system", "versions"}
    assert f"{sys.version_info.major}.{sys.version_info.minor}." in report.provenance["versions"]
    assert all(report.provenance.values())


def test_a_row_by_hand() -> None:
    row = Measurement(
        name="way_m", what="a way", unit="m", samples=(3.0, 1.0, 2.5), target=2.0, aim="at least"
    )
    assert (row.median, row.lowest, row.highest) == (2.5, 1.0, 3.0)
    assert row.as_row() == ["2.5", "1", "3", "m", "at least 2", "a way"]
    assert row.as_dict()["rounds"] == 3


def test_numbers_are_shown_with_three_digits() -> None:
    numbers = (1_234_567.0, 45_123.0, 1234.0, 0.3456, 2.1e-14, math.nan)
    assert [shown(number) for number in numbers] == [
        "1.23 M",
        "45.1 k",
        "1234",
        "0.346",
        "2.1e-14",
        "—",
    ]


def test_peak_memory_is_that_of_the_process_and_not_of_its_parent() -> None:
    ballast = bytearray(os.urandom(1024)) * (400 * 1024)  # 400 MB that a child must not count
    cost = cost_of_import()
    assert isinstance(cost, ProcessCost)
    assert len(ballast) == 400 * 1024 * 1024
    assert 1.0 < cost.memory < 200.0
    assert cost.wall > 0.0


# --- what the exact radius is compared with ---------------------------------------------------

TILTS = np.radians([20.0, 37.0, 54.7356, 60.0]).tolist()
OMNIMORPH = load_vehicle("omnimorph")


@pytest.mark.parametrize("tilt", TILTS)
def test_grid_of_thrusts_has_the_corners_and_so_the_exact_radius(tilt: float) -> None:
    thrusts = thrust_grid(OMNIMORPH)
    assert thrusts.shape == (3**8, 8)
    assert len(np.unique(thrusts, axis=0)) == 3**8
    exact = inscribed_radius(OMNIMORPH, tilt, zero_moment=False)
    found = hull_radius(forces_of(allocation_matrix(OMNIMORPH, tilt), thrusts))
    assert found == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("tilt", TILTS)
def test_random_thrusts_never_reach_the_exact_radius(tilt: float) -> None:
    A = allocation_matrix(OMNIMORPH, tilt)
    for seed in range(3):
        thrusts = random_thrusts(OMNIMORPH, 20_000, seed)
        assert (np.abs(thrusts) <= OMNIMORPH.thrust_max).all()
        free = inscribed_radius(OMNIMORPH, tilt, zero_moment=False)
        assert 0.5 * free < hull_radius(forces_of(A, thrusts)) < free
        left = projected(A, thrusts, OMNIMORPH)
        np.testing.assert_allclose(left @ A[3:].T, 0.0, atol=1e-13)
        assert (np.abs(left) <= OMNIMORPH.thrust_max).all()
        zero = inscribed_radius(OMNIMORPH, tilt, zero_moment=True)
        assert 0.5 * zero < hull_radius(forces_of(A, left)) < zero < free


def test_more_random_thrusts_come_nearer() -> None:
    A, exact = (
        allocation_matrix(OMNIMORPH, 0.7),
        inscribed_radius(OMNIMORPH, 0.7, zero_moment=False),
    )
    thrusts = random_thrusts(OMNIMORPH, 100_000, seed=0)
    short = [exact - hull_radius(forces_of(A, thrusts[:n])) for n in (100, 1000, 10_000, 100_000)]
    assert short == sorted(short, reverse=True)
    assert short[-1] > 0.02 * exact


def test_few_random_thrusts_are_nearly_free_of_moment() -> None:
    A = allocation_matrix(OMNIMORPH, 0.7)
    thrusts = random_thrusts(OMNIMORPH, 100_000, seed=0)
    left = nearly_moment_free(A, thrusts)
    largest = np.linalg.norm(thrusts @ A[3:].T, axis=1).max()
    assert (np.linalg.norm(left @ A[3:].T, axis=1) <= 0.01 * largest).all()
    assert len(left) < 100


@pytest.mark.parametrize("name", [n for n in list_vehicles() if load_vehicle(n).n_rotors <= 8])
def test_grid_and_exact_radius_agree_on_other_vehicles(name: str) -> None:
    vehicle = load_vehicle(name)
    A = allocation_matrix(vehicle, vehicle.servo_angle_max)
    exact = inscribed_radius(vehicle, vehicle.servo_angle_max, zero_moment=False)
    assert hull_radius(forces_of(A, thrust_grid(vehicle))) == pytest.approx(exact, rel=1e-9)


def test_radius_of_a_hull() -> None:
    cube = thrust_grid(OMNIMORPH)[:, :3] / OMNIMORPH.thrust_max[:3]  # |x|, |y|, |z| ≤ 1
    assert hull_radius(2.0 * cube) == pytest.approx(2.0, rel=1e-12)
    assert hull_radius(cube + np.array([0.5, 0.0, -0.75])) == pytest.approx(0.25, rel=1e-12)
    assert hull_radius(cube + np.array([3.0, 0.0, 0.0])) == 0.0  # zero is outside
    assert hull_radius(cube * [1.0, 1.0, 0.0]) == 0.0  # a plate
    assert hull_radius(cube[:3]) == 0.0
    assert hull_radius(cube[:0]) == 0.0
