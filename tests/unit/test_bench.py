"""The measurements produce every number and tell where it is from; how fast is not asserted."""

from __future__ import annotations

import json
import math
import os
import sys

import pytest

from omnimorph.bench import BenchReport, Measurement, measure
from omnimorph.bench.measurement import shown
from omnimorph.bench.processes import ProcessCost, cost_of_import

NAMES = [
    "core_case_a_steps_per_s",
    "core_case_b_steps_per_s",
    "whole_call_case_a_steps_per_s",
    "textbook_steps_per_s",
    "core_over_textbook",
    "core_textbook_difference_m",
    "realistic_flight_s",
    "first_round_s",
    "control_step_us",
    "control_step_p99_us",
    "python_controller_steps_per_s",
    "cold_flight_s",
    "cold_flight_MB",
    "import_s",
    "help_s",
]


@pytest.fixture(scope="module")
def report() -> BenchReport:
    told: list[tuple[int, int]] = []
    report = measure(lambda done, total: told.append((done, total)), rounds=1)
    assert told == [(1, 1)]
    return report


def test_every_number_is_there(report: BenchReport) -> None:
    assert [row.name for row in report.measurements] == NAMES
    for row in report.measurements:
        assert len(row.samples) == 1
        assert math.isfinite(row.median)
        assert row.median >= 0.0
        assert row.unit
        assert row.what


def test_numbers_that_are_known_are_right(report: BenchReport) -> None:
    """Not how fast: what must hold on any machine."""
    assert report["core_textbook_difference_m"].median <= 1e-11
    speed, slow = report["core_case_a_steps_per_s"], report["textbook_steps_per_s"]
    assert report["core_over_textbook"].median == pytest.approx(speed.median / slow.median)
    assert report["control_step_p99_us"].median >= report["control_step_us"].median
    assert report["whole_call_case_a_steps_per_s"].median <= speed.median
    assert 10.0 < report["cold_flight_MB"].median < 2000.0


def test_it_can_be_read_by_programs_and_by_people(report: BenchReport) -> None:
    content = json.loads(json.dumps(report.as_dict(), allow_nan=False))
    assert [row["name"] for row in content["measurements"]] == NAMES
    assert content["measurements"][0]["target"] == 1.5e6
    assert content["provenance"]["cores"].endswith(f"of {os.cpu_count()}; every flight uses one")
    text = report.as_text()
    for row in report.measurements:
        assert row.what in text
    assert content["provenance"]["processor"] in text
    assert [len(row) for row in report.as_rows()] == [len(report.COLUMNS)] * len(NAMES)


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
