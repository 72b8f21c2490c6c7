"""Logged columns: what a flight had recorded lives in its run, its file, its hash and its plots."""

from __future__ import annotations

import dataclasses
import html
import json
import math
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray
from tests.unit.conftest import build_random_run

import omnimorph as om
from omnimorph.errors import InputError, RunFileError
from omnimorph.results import store
from omnimorph.results.columns import sizes_of
from omnimorph.results.older_files import WITH_LOGS
from omnimorph.results.run import COLUMNS, Provenance
from omnimorph.results.saving import ATTRIBUTES, hash_of
from omnimorph.viewer.charts import _key_text, charts_of
from omnimorph.viewer.frames import Flight

ROWS = 20
RNG = np.random.default_rng(7)
WIND = om.LoggedColumn(RNG.standard_normal((ROWS, 3)), "m/s")
GAIN = om.LoggedColumn(RNG.standard_normal((ROWS, 6, 2)), "N m")
LIFT = om.LoggedColumn(np.where(np.arange(ROWS) < 5, np.nan, 8.0), "N")
PLAIN = build_random_run()
LOGGED = {"wind": WIND, "gain": GAIN, "lift": LIFT}
RUN = dataclasses.replace(PLAIN, logged=LOGGED)


def assert_same_logs(found: Any, wanted: Any) -> None:
    assert {*found} == {*wanted}
    for name, column in wanted.items():
        np.testing.assert_array_equal(found[name].values, column.values, strict=True)
        assert found[name].unit == column.unit


# --- the record ---------------------------------------------------------------------------------


def test_every_column_is_found_by_its_name() -> None:
    assert RUN["speed"] is RUN.speed
    assert RUN["time"] is RUN.time
    np.testing.assert_array_equal(RUN["wind"], WIND.values)
    with pytest.raises(InputError, match=r"spead is not a known key; did you mean speed \("):
        RUN["spead"]
    with pytest.raises(InputError, match="did you mean wind"):
        RUN["wnid"]
    with pytest.raises(InputError, match="outcome is not a known key"):
        RUN["outcome"]
    with pytest.raises(TypeError):
        iter(RUN)  # type: ignore[call-overload]


def test_logs_are_kept_as_they_are_and_read_only() -> None:
    given = np.zeros((ROWS, 2))
    column = om.LoggedColumn(given, "1")
    assert np.shares_memory(column.values, given)
    with pytest.raises(ValueError, match="read-only"):
        column.values[0, 0] = 1.0
    assert PLAIN.logged == {}
    assert_same_logs(pickle.loads(pickle.dumps(RUN)).logged, LOGGED)


def test_the_first_rows_of_a_run_have_their_logs() -> None:
    first = RUN.first_rows(7)
    for name in ("time", "R_WB", "active", "wind", "gain"):
        np.testing.assert_array_equal(first[name], RUN[name][:7])
    assert first.logged["gain"].unit == "N m"


@pytest.mark.parametrize(
    "name", ["2nd", "a b", "a.b", "", "größe", "_x", "x" * 101, "<b>", "a\n", 3]
)
def test_a_name_that_files_cannot_hold_is_refused(name: Any) -> None:
    with pytest.raises(InputError, match="but it must be up to 100 ASCII letters, digits and _"):
        dataclasses.replace(PLAIN, logged={name: LIFT})


TAKEN = [column.name for column in COLUMNS] + [*sizes_of(PLAIN.vehicle)]
TAKEN += ["time", "vehicle", "performance", "logged", "metrics", "save", "content_hash"]


@pytest.mark.parametrize("name", TAKEN)
def test_a_name_that_a_run_has_already_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=f'"{name}", but it must be a name that a run does not'):
        dataclasses.replace(PLAIN, logged={name: LIFT})


@pytest.mark.parametrize(
    ("values", "unit", "said"),
    [
        (3.0, "N", r"shape of the numbers is \(\)"),
        ("text", "N", r"shape of the numbers is \(\)"),
        ([[1.0], [1.0, 2.0]], "N", r"shape of the numbers is \(\)"),
        (np.zeros((20, 1, 1, 1, 1)), "N", "up to 3 dimensions after time"),
        (np.zeros((20, 0)), "N", "none of them empty"),
        (np.zeros(20), None, "unit is None"),
        (np.zeros(20), "N" * 41, "up to 40 characters"),
        (np.zeros(20), "N\n", "up to 40 characters"),
        (np.zeros(20), "<script>", "without <, > and &"),
        (np.zeros(20), "\ud800", "up to 40 characters"),
    ],
)
def test_what_is_no_column_is_refused(values: Any, unit: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        om.LoggedColumn(values, unit)


def test_a_log_has_a_row_for_each_of_the_runs() -> None:
    short = om.LoggedColumn(np.zeros(ROWS - 1), "N")
    with pytest.raises(InputError, match="number of rows of lift is 19, but it must be 20"):
        dataclasses.replace(PLAIN, logged={"lift": short})
    bare: Any = {"lift": np.zeros(ROWS)}
    with pytest.raises(InputError, match="but it must be a LoggedColumn"):
        dataclasses.replace(PLAIN, logged=bare)


# --- hash and file ------------------------------------------------------------------------------


def test_the_hash_covers_names_numbers_and_units_of_logs_but_not_their_order() -> None:
    other = om.LoggedColumn(np.where(LIFT.values == 8.0, 8.0 + 1e-15, LIFT.values), "N")
    logs: list[Any] = [{}, LOGGED, {"lift": LIFT}, {"Lift": LIFT}, {"lift": other}]
    logs += [{"lift": om.LoggedColumn(LIFT.values, "kN")}]
    hashes = [dataclasses.replace(PLAIN, logged=one).content_hash for one in logs]
    assert len({*hashes}) == len(logs)
    assert hashes[0] == PLAIN.content_hash
    turned = dict(reversed(LOGGED.items()))
    assert dataclasses.replace(PLAIN, logged=turned).content_hash == RUN.content_hash


def test_a_file_without_logs_is_as_before_and_one_with_them_asks_for_a_newer_reader(
    tmp_path: Path,
) -> None:
    schemas = []
    for run in (PLAIN, RUN):
        run.save(tmp_path / "run.nc")
        with h5py.File(tmp_path / "run.nc") as file:
            schemas.append(int(file.attrs["schema_version"]))
    assert schemas == [max(column.since for column in COLUMNS), WITH_LOGS]
    assert WITH_LOGS not in {column.since for column in COLUMNS}


@pytest.mark.parametrize("compression", [0, 4])
def test_logs_come_back(tmp_path: Path, compression: int) -> None:
    RUN.save(tmp_path / "run.nc", compression=compression)
    loaded = om.load_run(tmp_path / "run.nc")
    assert_same_logs(loaded.logged, LOGGED)
    assert loaded.provenance.content_hash == loaded.content_hash == RUN.content_hash
    loaded.save(tmp_path / "again.nc")
    assert_same_logs(om.load_run(tmp_path / "again.nc").logged, LOGGED)


def test_xarray_sees_logs_with_units_and_dimensions_of_their_own(tmp_path: Path) -> None:
    RUN.save(tmp_path / "run.nc")
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as data:
        assert data.gain.dims == ("time", "gain.1", "gain.2")
        assert data.lift.dims == ("time",)
        for name, column in LOGGED.items():
            np.testing.assert_array_equal(data[name], column.values)
            assert data[name].attrs["units"] == column.unit
            assert "logged" in data[name].attrs
        assert {name for name in data.data_vars if "logged" in data[name].attrs} == {*LOGGED}
        data.to_netcdf(tmp_path / "copied.nc", engine="h5netcdf")
    assert_same_logs(om.load_run(tmp_path / "copied.nc").logged, LOGGED)


def test_a_name_that_was_taken_since_is_kept_under_another() -> None:
    assert store._free_name("wind", 3) == "wind"
    assert store._free_name("first_rows", 3) == "first_rows_logged"
    assert store._free_name("speed", 3) == "speed", "a file that says so lies"
    assert store._free_name("thrust_actual", 1) == "thrust_actual_logged"


def put(name: str, values: Any, units: Any = "N") -> Callable[[h5py.File], None]:
    """Return what puts a logged column into a file."""

    def change(file: h5py.File) -> None:
        data = file.create_dataset(name, data=values)
        data.attrs.update({"logged": "by the flight", "units": units})

    return change


def remove_mark(file: h5py.File) -> None:
    del file["wind"].attrs["logged"]


def rename(file: h5py.File) -> None:
    file.move("wind", "w<i>nd")


def claim_too_much(file: h5py.File) -> None:
    data = file.create_dataset("huge", shape=(2**40,), dtype="f8", chunks=(1024,))
    data.attrs.update({"logged": "by the flight", "units": "N"})


def as_old_schema(file: h5py.File) -> None:
    file.attrs["schema_version"] = 2


def mark_a_column(file: h5py.File) -> None:
    file["speed"].attrs["logged"] = "by the flight"


def sign_again(file: h5py.File, version: int) -> None:
    """Let the hash be that of what the file now holds."""
    reported = {name: store._attribute("", file, key) for key, name in ATTRIBUTES.items()}
    parts = store._columns("", file, version), store._logged(file, version)
    outcome, provenance = store._outcome("", file), Provenance(**reported)
    file.attrs["content_hash"] = hash_of(*parts, outcome, provenance, version)


@pytest.mark.parametrize(
    ("change", "signed", "said"),
    [
        (put("other", np.zeros(ROWS)), False, "its content does not match its hash"),
        (remove_mark, False, "its content does not match its hash"),
        (as_old_schema, False, "its content does not match its hash"),
        (put("other", np.zeros(ROWS - 1)), True, "number of rows of other is 19"),
        (put("w<i>nd", np.zeros(ROWS)), True, "name of a logged column"),
        (rename, True, "name of a logged column"),
        (mark_a_column, True, "a name that a run does not have already"),
        (
            put("other", np.zeros(ROWS), "<b>N</b>"),
            False,
            'other: logged column: unit is "<b>N</b>"',
        ),
        (put("other", np.zeros(ROWS), np.zeros(3)), False, "unit is [0.0, 0.0, 0.0]"),
        (put("other", np.zeros((ROWS, 1, 1, 1, 1))), False, "up to 3 dimensions"),
        (put("other", 3.0), False, "shape of the numbers is ()"),
        (put("other", np.zeros(ROWS, dtype=np.int8)), False, "type of other is"),
        (put("other", np.zeros(ROWS, dtype="S3")), False, "type of other is"),
        (claim_too_much, False, "it does not hold all of huge"),
    ],
)
def test_a_file_that_lies_about_its_logs_is_refused(
    tmp_path: Path, change: Callable[[h5py.File], None], signed: bool, said: str
) -> None:
    RUN.save(tmp_path / "run.nc")
    with h5py.File(tmp_path / "run.nc", "r+") as file:
        change(file)
        if signed:
            sign_again(file, WITH_LOGS)
    with pytest.raises(RunFileError) as caught:
        om.load_run(tmp_path / "run.nc")
    sentence = str(caught.value)
    assert said in sentence
    assert sentence.startswith(f"{tmp_path / 'run.nc'}: the run cannot be read: ")
    assert sentence.endswith(".")
    assert "\n" not in sentence


# --- what is shown ------------------------------------------------------------------------------


def test_each_log_has_a_chart_with_its_name_and_unit() -> None:
    charts = charts_of([Flight(RUN, "mine")])
    wind, gain, lift = charts[-3:]
    assert (wind.title, lift.title) == ("wind, m/s", "lift, N")
    assert gain.title == "gain, N m (the first 8 of 12)"
    assert [curve.label for curve in wind.curves] == ["mine 0", "mine 1", "mine 2"]
    assert gain.curves[1].label == "mine 0, 1"
    for chart, column in ((wind, WIND), (gain, GAIN), (lift, LIFT)):
        rows = column.values.reshape(ROWS, -1).T
        for curve, row in zip(chart.curves, rows, strict=False):
            np.testing.assert_array_equal(curve.values, row)
    assert len(charts) == len(charts_of([Flight(PLAIN, "mine")])) + 3


def test_flights_share_the_chart_of_a_log_of_one_name_and_unit() -> None:
    other = {"wind": WIND, "lift": om.LoggedColumn(LIFT.values, "kN")}
    flights = [Flight(RUN, "<b>"), Flight(dataclasses.replace(PLAIN, logged=other), "b")]
    charts = {chart.title: chart for chart in charts_of(flights)}
    assert len(charts["wind, m/s"].curves) == 6
    assert [curve.label for curve in charts["lift, N"].curves] == ["<b>"]
    assert [curve.label for curve in charts["lift, kN"].curves] == ["b"]
    shown = _key_text(charts["wind, m/s"].key)
    assert html.escape("<b>") in shown
    assert "<b>" not in shown


# --- how a flight ended -------------------------------------------------------------------------


def failed(events: Any) -> str:
    text = json.dumps({"controller": {"kind": "python"}, "events": events})
    provenance = dataclasses.replace(PLAIN.provenance, scenario_text=text)
    outcome = om.Outcome.PART_FAILED
    return dataclasses.replace(PLAIN, provenance=provenance, outcome=outcome).outcome_sentence


FAILURE = {
    "kind": "failure",
    "part": "controller MyController",
    "error": "ValueError: boom (mine.py:3)",
    "time_s": 0.2,
}


def test_a_part_that_failed_is_named() -> None:
    expected = (
        "The flight was ended at 0.2 s: controller MyController failed with "
        "ValueError: boom (mine.py:3)."
    )
    assert failed([{"kind": "push"}, FAILURE]) == expected
    assert failed([FAILURE | {"error": FAILURE["error"] + "."}]) == expected  # type: ignore[operator]


@pytest.mark.parametrize(
    "events",
    [
        3,
        {"kind": "failure"},
        [3, "failure", None, [FAILURE]],
        [FAILURE | {"part": 3}],
        [FAILURE | {"error": None}],
        [FAILURE | {"time_s": "soon"}],
        [FAILURE | {"time_s": True}],
        [FAILURE | {"time_s": math.inf}],
        [FAILURE | {"time_s": 10**400}],
        [FAILURE | {"kind": "push"}],
    ],
)
def test_a_failure_reported_otherwise_is_said_in_general(events: Any) -> None:
    assert failed(events) == om.Outcome.PART_FAILED.value


def test_what_a_failure_says_steers_no_terminal_and_fills_no_page() -> None:
    said = failed([FAILURE | {"error": "\x1b[31m\n" + "x" * 100_000 + "\ud800"}])
    assert len(said) < 700
    assert said.isprintable()
