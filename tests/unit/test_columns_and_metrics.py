"""A recorded column and a metric are each declared once: everything else follows from that."""

from __future__ import annotations

import dataclasses
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import omnimorph as om
from omnimorph.errors import RunFileError
from omnimorph.protocols import FloatArray
from omnimorph.results import palette
from omnimorph.results.columns import sizes_of
from omnimorph.results.metrics import METRICS, Metrics, values_of
from omnimorph.results.record import COLUMN, COLUMNS
from omnimorph.results.run import Run
from omnimorph.results.store import SCHEMA_VERSION, load_run
from omnimorph.results.sums import FlightSums, sums_of_run
from omnimorph.simulation.instruction_sets import batch_module
from omnimorph.simulation.loop import SteppedFlight

PACKAGE = Path(om.__file__).parent
HOVER = om.load_scenario("hover")
SHORT = om.fly_many(HOVER, 2, keep=[0, 1])
ENDING = om.fly_many(dataclasses.replace(HOVER, lost_beyond=1e-6), 2, keep=[0, 1])

# What someone writes who wants another column and another metric: nothing but these two pieces.
NEW_COLUMN = """\
    motor_current: FloatArray = column(
        "A", "rotor", long_name="current of the rotor's motor", since={since}
    )
"""
NEW_METRIC = """\
    speed_max_rpm: float = metric(
        "Largest |w| of any rotor, in turns a minute.",
        Measure("fastest rotor, a minute", 1.0, "rpm"),
        lambda sums: sums.flown(30.0 * sums.speed_max / np.pi),
    )
"""
# What is then so, asked of the changed copy of the package; `sys.argv` names an older file.
QUESTIONS = """
import json, sys
import h5py
import numpy as np
import omnimorph as om
from conftest import build_random_run
from dataclasses import replace
from omnimorph.cli.fly import _measures
from omnimorph.errors import RunFileError
from omnimorph.report.tables import metrics_table
from omnimorph.results.metrics import Metrics
from omnimorph.results.many_metrics import metrics_from_sums
from omnimorph.results.run import Run
from omnimorph.simulation.instruction_sets import batch_module
from omnimorph.results.store import load_run
from omnimorph.simulation.recording import bytes_of_a_row

run = build_random_run()
run.save("new.nc")
again = load_run("new.nc")
try:
    older = load_run(sys.argv[1])
    said_of_older = [
        bool(np.isnan(older.motor_current).all()),
        older.provenance.content_hash,
    ]
except RunFileError as error:
    said_of_older = [str(error)]
with h5py.File("new.nc") as file:
    variable = file["motor_current"]
    kept = [
        int(file.attrs["schema_version"]),
        variable.attrs["units"].decode(),
        variable.attrs["long_name"].decode(),
        bool(np.array_equal(variable[...], run.motor_current)),
    ]
other = replace(run, motor_current=run.motor_current + 1.0)
n = np.arange(3.0)
sums = dict.fromkeys(batch_module().sum_names, n)
many = metrics_from_sums(sums, [run.outcome] * 3, physics_step=1e-3, n_servos=1)
run.metrics.write_json("metrics.json")
print(json.dumps({
    "package": om.__file__,
    "kept": kept,
    "read": bool(np.array_equal(again.motor_current, run.motor_current)),
    "hash": [run.content_hash == again.content_hash, run.content_hash == other.content_hash],
    "older": said_of_older,
    "bytes": bytes_of_a_row(run.vehicle),
    "documented": [
        "motor_current : (K, n) array, A\\n        Current of the rotor" in Run.__doc__,
        "speed_max_rpm : float\\n        Largest |w| of any rotor, in turns" in Metrics.__doc__,
    ],
    "metric": [run.metrics.speed_max_rpm, 30.0 / np.pi * float(np.abs(run.speed).max())],
    "json": json.load(open("metrics.json"))["speed_max_rpm"],
    "many": many.speed_max_rpm.tolist()[1:],
    "shown": [row for row in _measures(run.metrics.as_dict()) if "a minute" in row[0]],
    "table": [row for row in metrics_table("", {"a": run.metrics}).rows if "a minute" in row[0]],
}))
"""


def add(path: Path, piece: str, before: str) -> None:
    """Add a piece of text to a file, before a line that is in it once."""
    text = path.read_text(encoding="utf-8")
    assert text.count(before) == 1
    path.write_text(text.replace(before, piece + before), encoding="utf-8")


@pytest.fixture(scope="module")
def older(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a file that was written before there was the new column."""
    path = tmp_path_factory.mktemp("older") / "older.nc"
    flight = SteppedFlight("hover")
    flight.step()
    flight.as_run().save(path)
    return path


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory, older: Path) -> dict[str, Any]:
    """Return the answers of a copy of the package with a new column and a new metric."""
    folder = tmp_path_factory.mktemp("changed")
    copy = folder / "omnimorph"
    left_out = shutil.ignore_patterns("*.so", "*.pyd", "__pycache__")
    shutil.copytree(PACKAGE, copy, ignore=left_out)
    for library in [*PACKAGE.glob("*.so"), *PACKAGE.glob("*.pyd")]:
        os.symlink(library, copy / library.name)
    new_column = NEW_COLUMN.format(since=SCHEMA_VERSION + 1)
    add(copy / "results" / "record.py", new_column, "    outcome: Outcome\n")
    add(copy / "results" / "metrics.py", NEW_METRIC, "    outcome: str\n")
    paths = os.pathsep.join([str(folder), str(Path(__file__).parent)])
    done = subprocess.run(
        [sys.executable, "-c", QUESTIONS, str(older)],
        env={**os.environ, "PYTHONPATH": paths},
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    answers: dict[str, Any] = json.loads(done.stdout)
    assert Path(answers["package"]).parent == copy
    return answers


def test_a_new_column_is_in_file_hash_memory_and_documentation(reported: dict[str, Any]) -> None:
    schema, units, long_name, same = reported["kept"]
    assert (schema, units, same) == (SCHEMA_VERSION + 1, "A", True)
    assert long_name == "current of the rotor's motor"
    assert reported["read"]
    assert reported["hash"] == [True, False]
    assert reported["documented"][0]
    vehicle = om.load_vehicle("omnimorph")
    sizes = sizes_of(vehicle)
    today = 8 + sum(column.bytes_of_a_row(sizes) for column in COLUMNS)
    assert reported["bytes"] == today + 8 * vehicle.n_rotors


def test_files_from_before_a_column_stay_readable(reported: dict[str, Any], older: Path) -> None:
    """Their hash, which knows nothing of it, still holds; what nobody recorded is NaN."""
    assert reported["older"] == [True, load_run(older).content_hash]


def test_a_file_with_a_column_of_a_newer_omnimorph_asks_for_one(
    reported: dict[str, Any], older: Path
) -> None:
    newer = Path(reported["package"]).parent.parent / "new.nc"
    with pytest.raises(RunFileError, match=r"its schema version is .*install a newer omnimorph"):
        load_run(newer)


def test_a_new_metric_is_in_json_tables_batches_and_documentation(reported: dict[str, Any]) -> None:
    found, expected = reported["metric"]
    assert found == reported["json"] == pytest.approx(expected, rel=1e-15)
    assert reported["many"] == pytest.approx([30.0 / np.pi, 60.0 / np.pi], rel=1e-15)
    [shown], [row] = reported["shown"], reported["table"]
    assert shown[0] == row[0] == "fastest rotor, a minute"
    assert shown[2] == row[2] == "rpm"
    assert reported["documented"][1]


# --- what is declared here and in the core ------------------------------------------------------


def test_the_core_records_every_column_that_is_declared() -> None:
    """All but the power, which the core does not record: it follows from the speeds."""
    columns = SteppedFlight("hover").columns
    assert {*columns} | {"drag_power"} == {column.name for column in COLUMNS}
    sizes = sizes_of(om.load_scenario("hover").vehicle)
    for column in COLUMNS:
        if column.name in columns:
            found = columns[column.name]
            assert found.shape == column.shape(len(found), sizes), column.name
            assert found.dtype == column.dtype, column.name


def test_the_core_adds_up_every_sum_that_a_metric_is_made_of() -> None:
    """And nothing else: the names that the metrics read are those of the core, however it flew."""
    read = {"rows", "last_rows", "control_steps", "steps_with_residual"}  # by `FlightSums` itself

    class NotedSums(FlightSums):
        def __getattr__(self, name: str) -> FloatArray:
            read.add(name)
            return super().__getattr__(name)

    run = SHORT.runs[0]
    sums = {name: np.array([value]) for name, value in sums_of_run(run).items()}
    values_of(NotedSums(sums, [run.outcome], 1e-3, 1))
    assert read == {*batch_module().sum_names} == {*sums}


@pytest.mark.parametrize("flights", [SHORT, ENDING], ids=["completed", "lost"])
def test_a_flight_has_the_same_metrics_from_its_columns_as_while_it_flew(flights: Any) -> None:
    """To the last bit, but for the power, which a run holds as NumPy computes it."""
    for row, number in enumerate(flights.number):
        found = flights.runs[number].metrics.as_dict()
        for name, value in flights.metrics[row].as_dict().items():
            if "drag" in name or "power" in name:
                assert found[name] == pytest.approx(value, rel=1e-13), name
            else:
                assert found[name] == value, name
    whole = flights is SHORT
    assert {run.outcome is om.Outcome.COMPLETED for run in flights.runs.values()} == {whole}


def test_every_column_and_metric_says_what_it_is() -> None:
    for column in COLUMNS:
        assert f"    {column.name} : (" in (Run.__doc__ or "")
        assert column.long_name
        assert column.units
        nothing = column.unrecorded(1, dict.fromkeys(column.dims, 1))
        assert column.flags or np.isnan(nothing).all()
    for metric in METRICS:
        assert metric.meaning.endswith(".")
        assert f"    {metric.name} : float\n" in (Metrics.__doc__ or "")


def test_limits_and_units_of_columns_are_those_of_the_vehicle() -> None:
    vehicle, sizes = HOVER.vehicle, sizes_of(HOVER.vehicle)
    bounded = {column.name for column in COLUMNS if column.limits}
    assert bounded == {"thrust_command", "thrust_actual", "speed", "tilt_command", "tilt_actual"}
    for column in COLUMNS:
        assert column.colour in vars(palette).values()
        if column.limits:
            for limits in column.limits_of(vehicle):
                assert limits.shape == column.shape(1, sizes)[1:], column.name
    speed, tilt, power = (COLUMN[name] for name in ("speed", "tilt_actual", "drag_power"))
    assert [one.unit_read for one in (speed, tilt, power)] == ["Hz", "°", "W"]
    assert speed.as_read(np.array([2.0 * np.pi])) == pytest.approx([1.0], rel=1e-15)
    assert tilt.limits_of(vehicle)[1] == pytest.approx(np.degrees(vehicle.servo_angle_max))
    assert power.as_read(np.array([3.0])).tolist() == [3.0]
