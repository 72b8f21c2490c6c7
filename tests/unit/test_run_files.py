"""A file that holds no run, or a run that was spoilt: one sentence says what is wrong."""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from omnimorph.errors import RunFileError
from omnimorph.results.run import Run
from omnimorph.results.store import SCHEMA_VERSION, load_run


def assert_refused(path: Path, reason: str) -> None:
    """Check that loading fails with one sentence that names file and reason."""
    with pytest.raises(RunFileError) as caught:
        load_run(path)
    sentence = str(caught.value)
    assert sentence.startswith(f"{path}: ")
    assert reason in sentence
    assert sentence.endswith(".")
    assert "\n" not in sentence


def test_missing_file_and_folder(tmp_path: Path) -> None:
    assert_refused(tmp_path / "none.nc", "the run cannot be read: there is no such file")
    assert_refused(tmp_path, "the run cannot be read: it is a directory")


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
    file.attrs["schema_version"] = SCHEMA_VERSION + 1
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


def change_vehicle(file: Any) -> None:
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
        (write_with_newer_schema, f"its schema version is {SCHEMA_VERSION + 1} (by omnimorph 9.0)"),
        (write_with_odd_schema, 'schema_version is "first", but it must be an integer'),
        (rename_schema, "not a run of omnimorph"),
        (rename_outcome, 'outcome is "splendid", but it must be one of completed, under_way'),
        (cut_column, "its content does not match its hash"),
        (change_vehicle, "its content does not match its hash"),
        (make_seed_a_list, "seed is [1, 2], but it must be an integer"),
    ],
)
def test_spoilt_run(file: Path, spoil: Callable[[Any], None], reason: str) -> None:
    with h5py.File(file, "r+") as opened:
        spoil(opened)
    assert_refused(file, reason)


def test_run_with_a_vehicle_that_cannot_be(tmp_path: Path, random_run: Callable[..., Run]) -> None:
    run = random_run()
    text = run.provenance.vehicle_text.replace("mass_kg = ", "mass_kg = -")
    wrong = dataclasses.replace(run.provenance, vehicle_text=text)
    dataclasses.replace(run, provenance=wrong).save(tmp_path / "run.nc")
    assert_refused(tmp_path / "run.nc", "mass_kg is -1.315, but it must be")


def test_other_hdf5_file(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "other.nc", "w") as other:
        other["temperature"] = np.arange(3)
    assert_refused(tmp_path / "other.nc", "not a run of omnimorph")


def test_a_file_that_was_read_is_free_again(file: Path, tmp_path: Path) -> None:
    """Reading takes no lock and keeps nothing open."""
    first = load_run(file)
    shutil.copy(file, tmp_path / "copy.nc")
    file.unlink()
    assert load_run(tmp_path / "copy.nc").content_hash == first.content_hash
