"""A run comes back from its file as it was; a file that cannot be written is not there."""

from __future__ import annotations

import dataclasses
import gzip
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray
from tests.forked import Forked

import omnimorph as om
from omnimorph.design.files import load_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import InputError, RunFileError
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.atomic import replacing
from omnimorph.results.run import COLUMNS, Outcome, Performance, Run
from omnimorph.results.saving import hash_content
from omnimorph.results.store import load_run

NAMES = ["time", *(column.name for column in COLUMNS)]
OMNIMORPH = load_vehicle("omnimorph")
OLDER = Path(__file__).parent / "older_files"


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


# --- there and back -----------------------------------------------------------------------------


@pytest.mark.parametrize("compression", [0, 1, 9])
def test_run_comes_back(tmp_path: Path, compression: int, random_run: Callable[..., Run]) -> None:
    run = random_run()
    run.save(tmp_path / "run.nc", compression=compression)
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
    assert_same(load_run(tmp_path / "run.nc"), run)


@pytest.mark.parametrize("rows", [1, 5000])
def test_short_and_long_runs_come_back(
    tmp_path: Path, rows: int, random_run: Callable[..., Run]
) -> None:
    run = random_run(rows)
    run.save(tmp_path / "run.nc")
    assert_same(load_run(tmp_path / "run.nc"), run)


def test_run_without_servos_comes_back(tmp_path: Path, random_run: Callable[..., Run]) -> None:
    run = random_run(vehicle=without_servos(OMNIMORPH))
    run.save(tmp_path / "run.nc")
    loaded = load_run(tmp_path / "run.nc")
    assert loaded.tilt_actual.shape == (20, 0)
    assert_same(loaded, run)


def test_numbers_that_are_not_finite_come_back(
    tmp_path: Path, random_run: Callable[..., Run]
) -> None:
    run = random_run()
    speed = np.array(run.speed)
    speed[10:], speed[15:] = np.nan, -np.inf
    diverged = dataclasses.replace(run, speed=speed, outcome=Outcome.DIVERGED)
    diverged.save(tmp_path / "run.nc")
    assert_same(load_run(tmp_path / "run.nc"), diverged)


def test_long_texts_come_back(tmp_path: Path, random_run: Callable[..., Run]) -> None:
    """HDF5 keeps at most 64 KiB in an ordinary attribute; a resolved scenario can be longer."""
    run = random_run()
    long = dataclasses.replace(run.provenance, scenario_text="é" * 300_000)
    dataclasses.replace(run, provenance=long).save(tmp_path / "run.nc")
    assert load_run(tmp_path / "run.nc").provenance.scenario_text == long.scenario_text


def test_columns_may_be_views_of_one_table(tmp_path: Path, random_run: Callable[..., Run]) -> None:
    """A recording with one row of numbers a step is stored as if each column stood alone."""
    run = random_run()
    table = np.hstack((run.p_WB, run.v_WB, run.thrust_command))
    views = dataclasses.replace(
        run, p_WB=table[:, 0:3], v_WB=table[:, 3:6], thrust_command=table[:, 6:14][:, ::-1][:, ::-1]
    )
    assert not views.p_WB.flags.c_contiguous
    assert views.content_hash == run.content_hash
    views.save(tmp_path / "run.nc")
    assert_same(load_run(tmp_path / "run.nc"), run)


def test_metrics_of_the_loaded_run_are_the_same(file: Path, random_run: Callable[..., Run]) -> None:
    assert load_run(file).metrics == random_run().metrics


def test_loaded_run_can_be_stored_again(
    file: Path, tmp_path: Path, random_run: Callable[..., Run]
) -> None:
    loaded = load_run(file)
    loaded.save(tmp_path / "again.nc")
    assert_same(load_run(tmp_path / "again.nc"), random_run())


def test_a_file_of_the_first_schema_is_read_as_it_was_written(tmp_path: Path) -> None:
    """The file holds 8 ms of `hover`, seed 11, and the hash that its writer gave the run."""
    older = tmp_path / "older.nc"
    older.write_bytes(gzip.decompress((OLDER / "run-schema-1.nc.gz").read_bytes()))
    with h5py.File(older) as file:
        assert file.attrs["schema_version"] == 1
        thrust, tilt = file["thrust"][...], file["tilt"][...]
    run = load_run(older)
    reported = "c28e854664b58d3b4722470e6f73fe433e36726100ce211d76e795db0cb6b719"
    assert run.provenance.content_hash == reported
    np.testing.assert_array_equal(run.thrust_command, thrust)
    np.testing.assert_array_equal(run.tilt_actual, tilt)
    assert np.ptp(thrust) > 0.1
    assert np.ptp(tilt) > 0.01
    assert np.isnan(run.thrust_actual).all(), "nobody recorded it"
    assert run.metrics.drag_energy_J == pytest.approx(0.8843348400165029, rel=1e-14)
    run.save(tmp_path / "again.nc")
    assert_same(load_run(tmp_path / "again.nc"), run)


def test_a_file_of_the_version_before_loads_and_is_flown_again_the_same(tmp_path: Path) -> None:
    """It holds 20 ms of Case A's controller, seed 7, and the hash that its writer gave the run."""
    older = tmp_path / "older.nc"
    older.write_bytes(gzip.decompress((OLDER / "run-schema-2.nc.gz").read_bytes()))
    run = load_run(older)
    written = "5ccad49b56361e78baa3550594a1f61873710bf3a98bd388c6e0605756d9dc86"
    assert run.provenance.content_hash == run.content_hash == written
    assert run.metrics.position_error_mean_m == pytest.approx(0.004998526113483663, rel=1e-14)
    assert run.logged == {}
    run.save(tmp_path / "again.nc")
    assert_same(load_run(tmp_path / "again.nc"), run)
    way = SegmentReference((0.0, 0.0, 1.0), np.eye(3), [Segment(0.02, (0.01, 0.0, 0.0))])
    case = om.load_scenario("paper-case-a")
    again = om.fly(dataclasses.replace(case, reference=way, name="of the version before"), seed=7)
    for name in NAMES:
        np.testing.assert_array_equal(getattr(again, name), getattr(run, name), err_msg=name)


@pytest.mark.parametrize("name", ["speed", "thrust", "tilt_command"])
def test_a_file_of_the_first_schema_that_was_changed_is_refused(tmp_path: Path, name: str) -> None:
    older = tmp_path / "older.nc"
    older.write_bytes(gzip.decompress((OLDER / "run-schema-1.nc.gz").read_bytes()))
    with h5py.File(older, "r+") as file:
        file[name][3, 0] += 1e-9
    with pytest.raises(RunFileError, match="its content does not match its hash"):
        load_run(older)


# --- what others see ----------------------------------------------------------------------------


def test_xarray_sees_names_units_and_frames(file: Path, random_run: Callable[..., Run]) -> None:
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
        assert data.attrs["schema_version"] == max(column.since for column in COLUMNS)
        assert data.attrs["outcome"] == "lost"
        assert data.attrs["scenario"] == run.provenance.scenario_text
        assert data.attrs["content_hash"] == run.content_hash
        assert "wall_time_s" not in data.attrs
    with xarray.open_dataset(file, engine="h5netcdf", group="performance") as performance:
        assert performance.attrs == {"wall_time_s": 0.25, "real_time_factor": 180.0}


def test_round_trip_through_xarray(
    file: Path, tmp_path: Path, random_run: Callable[..., Run]
) -> None:
    """A file that xarray wrote is still the same run; performance is in a group it left behind."""
    copied = tmp_path / "copied.nc"
    with xarray.open_dataset(file, engine="h5netcdf") as data:
        data.to_netcdf(copied, engine="h5netcdf")
    loaded = load_run(copied)
    assert np.isnan(loaded.performance.wall_time)
    assert_same(dataclasses.replace(loaded, performance=random_run().performance), random_run())


def test_what_depends_on_the_machine_is_apart(random_run: Callable[..., Run]) -> None:
    run = random_run()
    slow = dataclasses.replace(run, performance=Performance(wall_time=9.0, real_time_factor=5.0))
    assert slow.content_hash == run.content_hash


def test_hash_covers_everything_else(random_run: Callable[..., Run]) -> None:
    run = random_run()
    hashes = {run.content_hash}
    for name in NAMES:
        column = np.array(getattr(run, name))
        column.flat[-1] = np.nextafter(column.flat[-1], 9.0) if column.dtype.kind == "f" else 5
        changes: Any = {name: column}
        hashes.add(dataclasses.replace(run, **changes).content_hash)
    for changes in ({"seed": 1}, {"version": "0.2.0"}, {"physics_step": 0.002}):
        provenance = dataclasses.replace(run.provenance, **changes)
        hashes.add(dataclasses.replace(run, provenance=provenance).content_hash)
    hashes.add(dataclasses.replace(run, outcome=Outcome.COMPLETED).content_hash)
    assert len(hashes) == 1 + len(NAMES) + 3 + 1


def test_hash_stays_the_same_over_versions_and_machines(random_run: Callable[..., Run]) -> None:
    run = random_run(rows=2, vehicle=without_servos(OMNIMORPH))
    exact = {
        name: np.arange(getattr(run, name).size, dtype=float).reshape(getattr(run, name).shape) / 8
        for name in NAMES
    }
    exact["active"] = np.zeros((2, 8))
    provenance = dataclasses.replace(run.provenance, vehicle_text="a vehicle")
    fixed: Any = {**exact, "provenance": provenance}
    expected = "558d6b9dc38170d4c2cdf66b45e642f96d0dbeb53bbea8d6d27748a008654615"
    assert hash_content(dataclasses.replace(run, **fixed), 2) == expected


# --- nothing half-written -----------------------------------------------------------------------

WRITE_WITH_LITTLE_SPACE = """
run = load_run("source.nc")
most = resource.getrlimit(resource.RLIMIT_FSIZE)
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most[1]))
try:
    run.save("full/run.nc")
except RunFileError as error:
    resource.setrlimit(resource.RLIMIT_FSIZE, most)
    print(error)
"""


@pytest.fixture(scope="module")
def forked() -> Iterator[Forked]:
    imports = "import resource, h5py; from omnimorph.errors import RunFileError"
    process = Forked(f"{imports}; from omnimorph.results.store import load_run", dict(os.environ))
    yield process
    process.close()


@pytest.mark.parametrize("share", [0.0, 0.001, 0.2, 0.5, 0.9, 0.999])
def test_no_space_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, share: float, random_run: Callable[..., Run], forked: Forked
) -> None:
    """The process may write less than the file needs, as on a disk that is full."""
    random_run(500).save(tmp_path / "source.nc")
    folder = tmp_path / "full"
    folder.mkdir()
    target = folder / "run.nc"
    target.write_text("older")
    limit = int(share * (tmp_path / "source.nc").stat().st_size)
    result = forked.run(f"limit = {limit}\n" + WRITE_WITH_LITTLE_SPACE, tmp_path)
    assert (result.returncode, result.stderr) == (0, "")
    assert result.stdout == f"{Path('full/run.nc')}: it cannot be written: File too large.\n"
    assert [path.name for path in folder.iterdir()] == ["run.nc"]
    assert target.read_text() == "older"


@pytest.mark.parametrize("name", ["missing/run.nc", "folder"])
def test_a_place_that_cannot_be_written_is_one_sentence(
    tmp_path: Path, name: str, random_run: Callable[..., Run]
) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(RunFileError, match=f"{name}: it cannot be written: .*\\.$"):
        random_run().save(tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


def write_half(target: Path) -> None:
    with replacing(target) as temporary:
        temporary.write_text("half")
        raise KeyboardInterrupt


def test_an_interrupt_leaves_nothing_half(tmp_path: Path) -> None:
    target = tmp_path / "text"
    with pytest.raises(KeyboardInterrupt):
        write_half(target)
    assert list(tmp_path.iterdir()) == []


def test_a_link_is_followed(tmp_path: Path, random_run: Callable[..., Run]) -> None:
    (tmp_path / "link.nc").symlink_to(tmp_path / "run.nc")
    random_run().save(tmp_path / "link.nc")
    assert (tmp_path / "link.nc").is_symlink()
    assert_same(load_run(tmp_path / "run.nc"), random_run())


@pytest.mark.parametrize("compression", [-1, 10])
def test_compression_has_ten_levels(
    tmp_path: Path, compression: int, random_run: Callable[..., Run]
) -> None:
    with pytest.raises(InputError, match="compression is"):
        random_run().save(tmp_path / "run.nc", compression=compression)
    assert list(tmp_path.iterdir()) == []
