"""A recorded column and a metric are each declared once: everything else follows from that."""

from __future__ import annotations

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
from omnimorph.results.columns import sizes_of
from omnimorph.results.metrics import METRICS, Metrics
from omnimorph.results.run import COLUMNS, Run
from omnimorph.results.store import SCHEMA_VERSION, load_run
from omnimorph.simulation.instruction_sets import batch_module
from omnimorph.simulation.stepped_flight import SteppedFlight

PACKAGE = Path(om.__file__).parent

# What someone writes who wants another column and another metric: nothing but these two pieces.
NEW_COLUMN = """\
    motor_current: FloatArray = column(
        "A", "rotor", long_name="current of the rotor's motor", since={since}
    )
"""
NEW_METRIC = """\
    current_max_mA: float = metric(
        "Largest current of any motor.",
        Measure("current of a motor, largest", 1.0, "mA"),
        lambda sums: 1e3 * sums.flown(sums.motor_current_max),
        motor_current_max=lambda rows: rows.column("motor_current").max(),
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
from omnimorph.results.metrics import METRICS, Metrics
from omnimorph.results.many_metrics import metrics_from_sums
from omnimorph.results.run import Run
from omnimorph.results.store import load_run
from omnimorph.simulation.loop_parts import bytes_of_a_row

run = build_random_run()
run.save("new.nc")
again = load_run("new.nc")
try:
    older = load_run(sys.argv[1])
    said_of_older = [
        bool(np.isnan(older.motor_current).all()),
        older.provenance.content_hash,
        older.metrics.as_dict()["current_max_mA"],
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
names = [name for one in METRICS for name in one.sums]
sums = dict.fromkeys(["rows", "last_rows", *names], n)
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
        "current_max_mA : float\\n        Largest current of any motor" in Metrics.__doc__,
    ],
    "metric": [run.metrics.current_max_mA, 1e3 * float(run.motor_current.max())],
    "json": json.load(open("metrics.json"))["current_max_mA"],
    "many": many.current_max_mA.tolist()[1:],
    "shown": [row for row in _measures(run.metrics.as_dict()) if "current of" in row[0]],
    "table": [row for row in metrics_table("", {"a": run.metrics}).rows if "current of" in row[0]],
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
    add(copy / "results" / "run.py", new_column, "    outcome: Outcome\n")
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
    assert reported["older"] == [True, load_run(older).content_hash, None]


def test_a_file_with_a_column_of_a_newer_omnimorph_asks_for_one(
    reported: dict[str, Any], older: Path
) -> None:
    newer = Path(reported["package"]).parent.parent / "new.nc"
    with pytest.raises(RunFileError, match=r"its schema version is .*install a newer omnimorph"):
        load_run(newer)


def test_a_new_metric_is_in_json_tables_batches_and_documentation(reported: dict[str, Any]) -> None:
    found, expected = reported["metric"]
    assert found == reported["json"] == pytest.approx(expected, rel=1e-15)
    assert reported["many"] == [1e3, 2e3]
    [shown], [row] = reported["shown"], reported["table"]
    assert shown[0] == row[0] == "current of a motor, largest"
    assert shown[2] == row[2] == "mA"
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
    declared = [name for metric in METRICS for name in metric.sums]
    assert len(declared) == len(set(declared)), "a sum belongs to one metric"
    assert sorted(batch_module().sum_names) == sorted([*declared, "rows", "last_rows"])


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
