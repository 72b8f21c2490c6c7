"""A run comes back from its file as it was, or one sentence says why not."""

from __future__ import annotations

import dataclasses
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray

from omnimorph.design.files import load_vehicle, vehicle_text
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import InputError, RunFileError
from omnimorph.results import Outcome, Performance, Provenance, Run, load_run
from omnimorph.results.atomic import replacing
from omnimorph.results.run import COLUMNS

NAMES = ["time", *(column.name for column in COLUMNS)]
OMNIMORPH = load_vehicle("omnimorph")


def without_servos(vehicle: Vehicle) -> Vehicle:
    """Return the vehicle with its tilt locked for good."""
    n, nothing = vehicle.n_rotors, np.zeros(0)
    return vehicle.replace(
        hinge_axis=np.zeros((n, 3)),
        rotor_servo=np.full(n, -1),
        servo_name=(),
        servo_angle_min=nothing,
        servo_angle_max=nothing,
        servo_rate_max=nothing,
        servo_time_constant=nothing,
        sources={},
    )


def random_run(rows: int = 20, vehicle: Vehicle = OMNIMORPH, seed: int = 3) -> Run:
    """Return a run full of random numbers."""
    rng = np.random.default_rng(seed)
    sizes = {"axis": 3, "axis_W": 3, "axis_B": 3, "wrench": 6}
    sizes |= {"rotor": vehicle.n_rotors, "servo": vehicle.n_servos}
    columns: dict[str, Any] = {
        column.name: rng.standard_normal((rows, *(sizes[dim] for dim in column.dims)))
        for column in COLUMNS
    }
    columns["active"] = rng.integers(-1, 2, (rows, vehicle.n_rotors)).astype(np.int8)
    provenance = Provenance(
        scenario_name="paper-case-a",
        scenario_text='{"title": "α and β"}',
        vehicle_text=vehicle_text(vehicle),
        plant_name="realistic",
        seed=2**64 - 1,
        flight=7,
        control_period=0.004,
        physics_step=0.001,
        version="0.1.0",
    )
    return Run(
        time=0.001 * np.arange(rows),
        **columns,
        outcome=Outcome.LOST,
        vehicle=vehicle,
        provenance=provenance,
        performance=Performance(wall_time=0.25, real_time_factor=180.0),
    )


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return the path of a stored run."""
    path = tmp_path / "run.nc"
    random_run().save(path)
    return path


def assert_same(loaded: Run, run: Run) -> None:
    """Check that two runs are equal to the last bit, the vehicle included."""
    for name in NAMES:
        one, other = getattr(loaded, name), getattr(run, name)
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other, strict=True)
    assert loaded.outcome is run.outcome
    assert loaded.performance == run.performance
    expected = dataclasses.replace(run.provenance, content_hash=run.content_hash)
    assert loaded.provenance == expected
    for field in dataclasses.fields(Vehicle):
        one, other = getattr(loaded.vehicle, field.name), getattr(run.vehicle, field.name)
        if field.name != "sources":
            np.testing.assert_array_equal(one, other)


def assert_refused(path: Path, reason: str) -> None:
    """Check that loading fails with one sentence that names file and reason."""
    with pytest.raises(RunFileError) as caught:
        load_run(path)
    sentence = str(caught.value)
    assert sentence.startswith(f"{path}: ")
    assert reason in sentence
    assert sentence.endswith(".")
    assert "\n" not in sentence


# --- there and back -----------------------------------------------------------------------------


@pytest.mark.parametrize("compression", [0, 1, 9])
def test_run_comes_back(tmp_path: Path, compression: int) -> None:
    run = random_run()
    run.save(tmp_path / "run.nc", compression=compression)
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
    assert_same(load_run(tmp_path / "run.nc"), run)


@pytest.mark.parametrize("rows", [1, 5000])
def test_short_and_long_runs_come_back(tmp_path: Path, rows: int) -> None:
    run = random_run(rows)
    run.save(tmp_path / "run.nc")
    assert_same(load_run(tmp_path / "run.nc"), run)


def test_run_without_servos_comes_back(tmp_path: Path) -> None:
    run = random_run(vehicle=without_servos(OMNIMORPH))
    run.save(tmp_path / "run.nc")
    loaded = load_run(tmp_path / "run.nc")
    assert loaded.tilt.shape == (20, 0)
    assert_same(loaded, run)


def test_numbers_that_are_not_finite_come_back(tmp_path: Path) -> None:
    run = random_run()
    speed = np.array(run.speed)
    speed[10:], speed[15:] = np.nan, -np.inf
    diverged = dataclasses.replace(run, speed=speed, outcome=Outcome.DIVERGED)
    diverged.save(tmp_path / "run.nc")
    assert_same(load_run(tmp_path / "run.nc"), diverged)


def test_long_texts_come_back(tmp_path: Path) -> None:
    """HDF5 keeps at most 64 KiB in an ordinary attribute; a resolved scenario can be longer."""
    run = random_run()
    long = dataclasses.replace(run.provenance, scenario_text="é" * 300_000)
    dataclasses.replace(run, provenance=long).save(tmp_path / "run.nc")
    assert load_run(tmp_path / "run.nc").provenance.scenario_text == long.scenario_text


def test_columns_may_be_views_of_one_table(tmp_path: Path) -> None:
    """A recording with one row of numbers a step is stored as if each column stood alone."""
    run = random_run()
    table = np.hstack((run.p_WB, run.v_WB, run.thrust))
    views = dataclasses.replace(
        run, p_WB=table[:, 0:3], v_WB=table[:, 3:6], thrust=table[:, 6:14][:, ::-1][:, ::-1]
    )
    assert not views.p_WB.flags.c_contiguous
    assert views.content_hash == run.content_hash
    views.save(tmp_path / "run.nc")
    assert_same(load_run(tmp_path / "run.nc"), run)


def test_metrics_of_the_loaded_run_are_the_same(file: Path) -> None:
    assert load_run(file).metrics == random_run().metrics


def test_loaded_run_can_be_stored_again(file: Path, tmp_path: Path) -> None:
    loaded = load_run(file)
    loaded.save(tmp_path / "again.nc")
    assert_same(load_run(tmp_path / "again.nc"), random_run())


# --- what others see ----------------------------------------------------------------------------


def test_xarray_sees_names_units_and_frames(file: Path) -> None:
    run = random_run()
    with xarray.open_dataset(file, engine="h5netcdf") as data:
        assert set(data.data_vars) == set(NAMES) - {"time"}
        np.testing.assert_array_equal(data.time, run.time)
        assert data.time.attrs["units"] == "s"
        for column in COLUMNS:
            variable = data[column.name]
            assert variable.dims == ("time", *column.dims)
            np.testing.assert_array_equal(variable, getattr(run, column.name))
            assert variable.attrs["units"] == column.units != ""
            assert variable.attrs["long_name"] == column.long_name != ""
            assert variable.attrs.get("frame", "") == column.frame
        np.testing.assert_array_equal(data.p_WB.sel(axis="z"), run.p_WB[:, 2])
        np.testing.assert_array_equal(data.R_WB.sel(axis_W="x", axis_B="z"), run.R_WB[:, 0, 2])
        torque = data.wrench_asked.sel(wrench="torque_y")
        np.testing.assert_array_equal(torque, run.wrench_asked[:, 4])
        assert data.servo.values.tolist() == list(run.vehicle.servo_name)
        assert data.attrs["schema_version"] == 1
        assert data.attrs["outcome"] == "lost"
        assert data.attrs["scenario"] == run.provenance.scenario_text
        assert data.attrs["content_hash"] == run.content_hash
        assert "wall_time_s" not in data.attrs
    with xarray.open_dataset(file, engine="h5netcdf", group="performance") as performance:
        assert performance.attrs == {"wall_time_s": 0.25, "real_time_factor": 180.0}


def test_round_trip_through_xarray(file: Path, tmp_path: Path) -> None:
    """A file that xarray wrote is still the same run; performance is in a group it left behind."""
    copied = tmp_path / "copied.nc"
    with xarray.open_dataset(file, engine="h5netcdf") as data:
        data.to_netcdf(copied, engine="h5netcdf")
    loaded = load_run(copied)
    assert np.isnan(loaded.performance.wall_time)
    assert_same(dataclasses.replace(loaded, performance=random_run().performance), random_run())


def test_what_depends_on_the_machine_is_apart() -> None:
    run = random_run()
    slow = dataclasses.replace(run, performance=Performance(wall_time=9.0, real_time_factor=5.0))
    assert slow.content_hash == run.content_hash


def test_hash_covers_everything_else() -> None:
    run = random_run()
    hashes = {run.content_hash}
    for name in NAMES:
        column = np.array(getattr(run, name))
        column.flat[-1] = np.nextafter(column.flat[-1], 9.0) if column.dtype.kind == "f" else 5
        hashes.add(dataclasses.replace(run, **{name: column}).content_hash)
    for name, value in (("seed", 1), ("version", "0.2.0"), ("physics_step", 0.002)):
        changed: Any = dataclasses.replace(run.provenance, **{name: value})
        hashes.add(dataclasses.replace(run, provenance=changed).content_hash)
    hashes.add(dataclasses.replace(run, outcome=Outcome.COMPLETED).content_hash)
    assert len(hashes) == 1 + len(NAMES) + 3 + 1


def test_hash_stays_the_same_over_versions_and_machines() -> None:
    run = random_run(rows=2, vehicle=without_servos(OMNIMORPH))
    exact = {
        name: np.arange(getattr(run, name).size, dtype=float).reshape(getattr(run, name).shape) / 8
        for name in NAMES
    }
    exact["active"] = np.zeros((2, 8))
    provenance = dataclasses.replace(run.provenance, vehicle_text="a vehicle")
    fixed: Any = {**exact, "provenance": provenance}
    expected = "ff97bc0afe10a34eb0321dab90bdce87e3871728fdbc066413d002f9bbb207ea"
    assert dataclasses.replace(run, **fixed).content_hash == expected


# --- nothing half-written -----------------------------------------------------------------------

WRITE_WITH_LITTLE_SPACE = """
import resource, sys
from pathlib import Path
from omnimorph.errors import RunFileError
from omnimorph.results import load_run
source, target, limit = sys.argv[1:]
run = load_run(source)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(limit), int(limit)))
try:
    run.save(target)
except RunFileError as error:
    print(error)
"""


@pytest.mark.parametrize("share", [0.0, 0.001, 0.2, 0.5, 0.9, 0.999])
def test_no_space_leaves_the_old_file_and_nothing_else(tmp_path: Path, share: float) -> None:
    """The process may write less than the file needs, as on a disk that is full."""
    random_run(500).save(tmp_path / "source.nc")
    folder = tmp_path / "full"
    folder.mkdir()
    target = folder / "run.nc"
    target.write_text("older")
    limit = int(share * (tmp_path / "source.nc").stat().st_size)
    result = subprocess.run(
        [sys.executable, "-c", WRITE_WITH_LITTLE_SPACE, tmp_path / "source.nc", target, str(limit)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (result.returncode, result.stderr) == (0, "")
    assert result.stdout == f"{target}: it cannot be written: File too large.\n"
    assert [path.name for path in folder.iterdir()] == ["run.nc"]
    assert target.read_text() == "older"


@pytest.mark.parametrize("name", ["missing/run.nc", "folder"])
def test_a_place_that_cannot_be_written_is_one_sentence(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(RunFileError, match=f"{name}: it cannot be written: .*\\.$"):
        random_run().save(tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


def test_an_interrupt_leaves_nothing_half(tmp_path: Path) -> None:
    target = tmp_path / "text"
    with pytest.raises(KeyboardInterrupt), replacing(target) as temporary:
        temporary.write_text("half")
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "link.nc").symlink_to(tmp_path / "run.nc")
    random_run().save(tmp_path / "link.nc")
    assert (tmp_path / "link.nc").is_symlink()
    assert_same(load_run(tmp_path / "run.nc"), random_run())


@pytest.mark.parametrize("compression", [-1, 10])
def test_compression_has_ten_levels(tmp_path: Path, compression: int) -> None:
    with pytest.raises(InputError, match="compression is"):
        random_run().save(tmp_path / "run.nc", compression=compression)
    assert list(tmp_path.iterdir()) == []


# --- files that are no runs ---------------------------------------------------------------------


def test_missing_file_and_folder(tmp_path: Path) -> None:
    assert_refused(tmp_path / "none.nc", "it cannot be read: No such file or directory")
    assert_refused(tmp_path, "it cannot be read: Is a directory")


@pytest.mark.parametrize(
    ("content", "reason"),
    [(b"", "it is empty"), (b"time,x\n0,1\n", "not a netCDF-4 file"), (b"\x89HDF", "not a netCDF")],
)
def test_other_files(tmp_path: Path, content: bytes, reason: str) -> None:
    (tmp_path / "other.nc").write_bytes(content)
    assert_refused(tmp_path / "other.nc", reason)


@pytest.mark.parametrize("share", [0.001, 0.1, 0.5, 0.9, 0.9999])
def test_truncated_file(file: Path, share: float) -> None:
    content = file.read_bytes()
    file.write_bytes(content[: int(share * len(content))])
    assert_refused(file, "it is cut off or damaged")


def remove_column(file: Any) -> None:
    del file["speed"]


def remove_attribute(file: Any) -> None:
    del file.attrs["seed"]


def change_number(file: Any) -> None:
    file["speed"][3, 4] += 1e-9


def change_text(file: Any) -> None:
    file.attrs["scenario"] = "{}"


def write_with_newer_schema(file: Any) -> None:
    file.attrs["schema_version"] = 2
    file.attrs["omnimorph_version"] = "9.0"


def write_with_odd_schema(file: Any) -> None:
    file.attrs["schema_version"] = "first"


def rename_schema(file: Any) -> None:
    file.attrs["schema"] = "weather"


def rename_outcome(file: Any) -> None:
    file.attrs["outcome"] = "splendid"


def cut_column(file: Any) -> None:
    shorter = file["cost"][:-1]
    del file["cost"]
    file["cost"] = shorter


def spoil_vehicle(file: Any) -> None:
    file.attrs["vehicle"] = "mass_kg = -1"


def make_seed_a_list(file: Any) -> None:
    file.attrs["seed"] = [1, 2]


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (remove_column, "the column speed is missing"),
        (remove_attribute, "the attribute seed is missing"),
        (change_number, "its content does not match its hash"),
        (change_text, "its content does not match its hash"),
        (write_with_newer_schema, "its schema version is 2 (by omnimorph 9.0)"),
        (write_with_odd_schema, 'schema_version is "first", but it must be an integer'),
        (rename_schema, "not a run of omnimorph"),
        (rename_outcome, 'outcome is "splendid", but it must be one of completed, lost'),
        (cut_column, "shape of cost is (19,), but it must be (20,)"),
        (spoil_vehicle, "it does not hold a run"),
        (make_seed_a_list, "seed is [1, 2], but it must be an integer"),
    ],
)
def test_spoilt_run(file: Path, spoil: Callable[[Any], None], reason: str) -> None:
    with h5py.File(file, "r+") as opened:
        spoil(opened)
    assert_refused(file, reason)


def test_other_hdf5_file(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "other.nc", "w") as other:
        other["temperature"] = np.arange(3)
    assert_refused(tmp_path / "other.nc", "not a run of omnimorph")


def test_a_file_being_read_can_be_copied_over(file: Path, tmp_path: Path) -> None:
    """Reading takes no lock and keeps nothing open."""
    first = load_run(file)
    shutil.copy(file, tmp_path / "copy.nc")
    file.unlink()
    assert_same(load_run(tmp_path / "copy.nc"), first)


# --- the record itself --------------------------------------------------------------------------


def test_run_is_read_only_but_leaves_the_arrays_it_was_given_alone() -> None:
    run = random_run()
    with pytest.raises(ValueError, match="read-only"):
        run.p_WB[0, 0] = 1.0
    given = np.zeros((20, 3))
    kept = dataclasses.replace(run, p_WB=given)
    given[0, 0] = 1.0
    assert kept.p_WB[0, 0] == 1.0


def test_run_refuses_columns_of_another_shape() -> None:
    with pytest.raises(InputError, match=r"shape of thrust is \(20, 7\), but it must be \(20, 8\)"):
        dataclasses.replace(random_run(), thrust=np.zeros((20, 7)))
    with pytest.raises(InputError, match="number of rows is 0"):
        random_run(rows=0)


@pytest.mark.parametrize(("name", "value"), [("seed", -1), ("flight", 2**64), ("seed", 1.5)])
def test_provenance_refuses_what_cannot_be_stored(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=f"{name} is .*an integer from 0"):
        dataclasses.replace(random_run().provenance, **{name: value})


@pytest.mark.parametrize("value", [0.0, float("nan"), -0.001])
def test_provenance_refuses_periods_that_are_none(value: float) -> None:
    with pytest.raises(InputError, match="physics_step is"):
        dataclasses.replace(random_run().provenance, physics_step=value)


def test_every_outcome_is_a_sentence() -> None:
    for outcome in Outcome:
        assert outcome.value[0].isupper()
        assert outcome.value.endswith(".")


def test_run_shows_what_it_is() -> None:
    assert repr(random_run()) == "Run('paper-case-a', lost after 0.019 s, 20 rows)"
