"""The file of a run: netCDF-4, written with h5py.

netCDF-4 is HDF5 with named dimensions, so the file opens in xarray, MATLAB, ncview and h5py. Each
column is a variable with its units, frame and long name; the dimensions are ``time``, ``axis``,
``axis_W`` and ``axis_B`` (rows and columns of a rotation matrix), ``rotor``, ``servo`` (absent, and
the tilt with it, if the vehicle has none) and ``wrench``. A logged column has the attribute
``logged`` and dimensions of its own. Attributes of the file hold outcome and provenance; what
depends on the machine is in the group ``performance``.

The netCDF libraries themselves take as long to load and to write as the whole flight takes to
compute; the few conventions that make an HDF5 file a netCDF-4 file are in `_add_dimensions`.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from omnimorph.design.input_files import open_input
from omnimorph.errors import InputError, OmnimorphError, RunFileError, legible
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.results.atomic import replacing
from omnimorph.results.hdf5 import OutputFile, fixed_text, plain, stored
from omnimorph.results.logged import LoggedColumn, as_columns, logged_sizes
from omnimorph.results.older_files import (
    SCHEMA_VERSION,
    WITH_LOGS,
    add_missing,
    free_name,
    names_in_file,
    schema_of,
)
from omnimorph.results.run import COLUMNS, Column, Outcome, Performance, Provenance, Run

__all__ = ["SCHEMA_VERSION", "hash_content", "load_run", "save_run"]

SCHEMA = "omnimorph run"

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_MOST_COMPRESSED = 1032  # by this gzip can shrink, and no more
_LOGGED = "logged"  # the attribute that says so
_AXES = ["x", "y", "z"]
_WRENCH = ["force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"]
# Attribute of the file -> field of the provenance; only files and displays carry units in names.
_ATTRIBUTES = {
    "omnimorph_version": "version",
    "scenario_name": "scenario_name",
    "scenario": "scenario_text",
    "vehicle": "vehicle_text",
    "plant": "plant_name",
    "seed": "seed",
    "flight": "flight",
    "control_period_s": "control_period",
    "physics_step_s": "physics_step",
}


def hash_content(run: Run, schema_version: int = SCHEMA_VERSION) -> str:
    """Return the SHA-256 of a run's columns, outcome and provenance, as hexadecimal text.

    Numbers enter as little-endian IEEE bytes, row by row, texts as JSON in ASCII; performance, and
    a hash the provenance may hold, do not enter, nor do columns newer than the schema. Logged
    columns enter in the order of their names, where there are any.
    """
    return _hash(vars(run), run.logged, run.outcome, run.provenance, schema_version)


def _hash(
    columns: Mapping[str, Any],
    logged: Mapping[str, LoggedColumn],
    outcome: Outcome,
    provenance: Provenance,
    version: int = SCHEMA_VERSION,
) -> str:
    told = dataclasses.asdict(provenance)
    del told["content_hash"]
    record = {"schema": SCHEMA, "outcome": outcome.name, "provenance": told}
    if logged:
        record["logged"] = {name: column.unit for name, column in logged.items()}
    digest = hashlib.sha256(json.dumps(record, sort_keys=True).encode())
    named = {"time": "time", **names_in_file(version)}
    arrays = {name: columns[column] for column, name in named.items()}
    for name, values in {
        **arrays,
        **{name: logged[name].values for name in sorted(logged)},
    }.items():
        array = stored(values)
        digest.update(f"{name} {array.dtype.str} {array.shape}".encode())
        digest.update(array.reshape(-1).view(np.uint8))
    return digest.hexdigest()


def save_run(run: Run, path: str | Path, *, compression: int = 0) -> None:
    """Write a run to a netCDF-4 file, as a whole or not at all: see `Run.save`."""
    if compression not in range(10):
        raise InputError.at("save", "compression", compression, "an integer from 0 to 9")
    import h5py

    with replacing(path) as temporary, OutputFile(temporary) as output:
        try:
            with h5py.File(output, "w", track_order=True) as file:
                _write(file, run, compression)
        except Exception:  # what HDF5 makes of a file that does not hold what it wrote
            if output.failure is None:
                raise
        if output.failure is not None:
            raise output.failure


def load_run(path: str | Path) -> Run:
    """Read a run from a file that `Run.save` wrote.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Run
        Equal to the one that was written, with the hash of its content in its provenance.

    Raises
    ------
    RunFileError
        If the file cannot be read, is cut off, is no netCDF-4 file or no run, was written by a
        newer schema, lacks a column, or was changed since: one sentence that names the file.
    TooLargeError
        If its columns are more than memory holds.
    """
    try:
        with open_input(path, partial(_unreadable, path)) as file:
            _check_signature(path, file.read(len(_HDF5_SIGNATURE)))
            return _read_hdf5(path, file)
    except OSError as error:
        raise _unreadable(path, (error.strerror or str(error)).lower()) from error


def _write(file: Any, run: Run, compression: int) -> None:
    file.attrs["title"] = fixed_text(f"omnimorph flight: {run.provenance.scenario_name}")
    file.attrs["schema"] = fixed_text(SCHEMA)
    file.attrs["schema_version"] = schema_of(run)
    file.attrs["outcome"] = fixed_text(run.outcome.name.lower())
    file.attrs["outcome_sentence"] = fixed_text(run.outcome_sentence)
    for attribute, name in _ATTRIBUTES.items():
        value = getattr(run.provenance, name)
        file.attrs[attribute] = fixed_text(value) if isinstance(value, str) else value
    file.attrs["content_hash"] = fixed_text(run.content_hash)
    scales = _add_dimensions(file, run)
    for column in COLUMNS:
        if all(dim in scales for dim in column.dims):
            _add_column(file, column, getattr(run, column.name), scales, compression)
    for column in as_columns(run.logged):
        data = _add_column(file, column, run[column.name], scales, compression)
        data.attrs[_LOGGED] = fixed_text("by the flight")
    group = file.create_group("performance", track_order=True)
    group.attrs["wall_time_s"] = run.performance.wall_time
    group.attrs["real_time_factor"] = run.performance.real_time_factor


def _add_dimensions(file: Any, run: Run) -> dict[str, Any]:
    """Add the dimensions: HDF5 scales, numbered as netCDF-4 wants them, that name their entries."""
    import h5py

    names = h5py.string_dtype()
    dimensions: dict[str, tuple[Any, str, str]] = {
        "time": (stored(run.time), "s", "time"),
        "axis": (np.array(_AXES, dtype=names), "", "axis of the frame"),
        "axis_W": (np.array(_AXES, dtype=names), "", "axis of the world W"),
        "axis_B": (np.array(_AXES, dtype=names), "", "axis of the body B"),
        "rotor": (np.arange(run.vehicle.n_rotors, dtype=np.int32), "1", "rotor, counted from 0"),
        "wrench": (np.array(_WRENCH, dtype=names), "", "component of force or torque"),
    }
    if run.vehicle.n_servos:
        dimensions["servo"] = (np.array(run.vehicle.servo_name, dtype=names), "", "servo")
    for name, length in logged_sizes(run.logged).items():
        dimensions[name] = (np.arange(length, dtype=np.int32), "1", "entry, counted from 0")
    scales = {}
    for number, (name, (values, units, long_name)) in enumerate(dimensions.items()):
        scale = file.create_dataset(name, data=values, track_order=True)
        scale.make_scale(name)
        scale.attrs["_Netcdf4Dimid"] = np.int32(number)
        scale.attrs["long_name"] = fixed_text(long_name)
        if units:
            scale.attrs["units"] = fixed_text(units)
        scales[name] = scale
    return scales


def _add_column(
    file: Any, column: Column, values: Any, scales: dict[str, Any], compression: int
) -> Any:
    options: dict[str, Any] = {}
    if compression:
        chunk = (min(len(values), 4096), *values.shape[1:])
        options = {"chunks": chunk, "compression": compression, "shuffle": True}
    data = file.create_dataset(column.name, data=stored(values), track_order=True, **options)
    for position, dim in enumerate(("time", *column.dims)):
        data.dims[position].attach_scale(scales[dim])
    data.attrs["units"] = fixed_text(column.units)
    data.attrs["long_name"] = fixed_text(column.long_name)
    if column.frame:
        data.attrs["frame"] = fixed_text(column.frame)
    if column.flags:
        data.attrs["flag_values"] = np.array([*column.flags], dtype=column.dtype)
        data.attrs["flag_meanings"] = fixed_text(" ".join(column.flags.values()))
    return data


def _read_hdf5(path: str | Path, file: Any) -> Run:
    import h5py

    try:
        with h5py.File(file, "r") as hdf5:
            return _read(path, hdf5)
    except OmnimorphError:
        raise
    except Exception as error:  # h5py passes on a broken file as nearly any exception
        told = " ".join(str(error).split()).strip("'\"") or type(error).__name__
        raise _unreadable(path, f"it is cut off or damaged ({told})") from error


def _read(path: str | Path, file: Any) -> Run:
    from omnimorph.design.files import parse_vehicle

    version = _schema_version(path, file.attrs)
    told = {name: _attribute(path, file, key) for key, name in _ATTRIBUTES.items()}
    told["content_hash"] = _attribute(path, file, "content_hash")
    outcome = _outcome(path, file)
    _check_size(path, file, version)
    columns = _columns(path, file, version)
    try:
        provenance = Provenance(**told)
        logged = _logged(file, version)
        if _hash(columns, logged, outcome, provenance, version) != provenance.content_hash:
            raise _unreadable(path, "its content does not match its hash: changed or damaged")
        vehicle = parse_vehicle(provenance.vehicle_text, f"{path}: vehicle", questioned=False)
        add_missing(columns, version, vehicle)
        return Run(
            **columns,
            outcome=outcome,
            vehicle=vehicle,
            provenance=provenance,
            performance=_performance(file),
            logged={free_name(name, version): column for name, column in logged.items()},
        )
    except RunFileError:
        raise
    except InputError as error:
        raise _unreadable(path, f"it does not hold a run ({str(error).rstrip('.')})") from error


def _check_size(path: str | Path, file: Any, version: int) -> None:
    """Refuse columns that claim more than the file holds, or than memory does, before any is read.

    HDF5 makes up the numbers that were never written, so that a small file can claim any size.
    """
    needed = 0
    for name in ("time", *names_in_file(version).values(), *_names_of_logged(file, version)):
        if name in file:
            data = file[name]
            chunk = math.prod(data.chunks or ()) * data.dtype.itemsize
            filters = data.id.get_create_plist().get_nfilters()
            held = data.id.get_storage_size() * (_MOST_COMPRESSED if filters else 1)
            if max(data.nbytes, chunk) > held or data.external:
                raise _unreadable(
                    path, f"it is cut off or damaged (it does not hold all of {name})"
                )
            needed += max(data.nbytes, 8 * data.size)
    refuse_more_than_memory(f"{path}: its columns", needed, "read a shorter run")


def _columns(path: str | Path, file: Any, version: int = SCHEMA_VERSION) -> dict[str, Any]:
    columns, names = {"time": _column(path, file, "time")}, names_in_file(version)
    for column in COLUMNS:
        if column.name not in names:
            continue
        if "servo" in column.dims and "servo" not in file:
            columns[column.name] = np.zeros((len(columns["time"]), 0))
        else:
            columns[column.name] = _column(path, file, names[column.name])
    return columns


def _names_of_logged(file: Any, version: int) -> list[str]:
    held = file.items() if version >= WITH_LOGS else ()
    return [name for name, data in held if _LOGGED in data.attrs and hasattr(data, "dtype")]


def _logged(file: Any, version: int) -> dict[str, LoggedColumn]:
    logged = {}
    for name in _names_of_logged(file, version):
        if file[name].dtype != np.float64:
            raise InputError.at("run", f"type of {legible(name)}", str(file[name].dtype), "float64")
        logged[name] = LoggedColumn(file[name][...], plain(file[name].attrs.get("units")))
    return logged


def _outcome(path: str | Path, file: Any) -> Outcome:
    name = str(_attribute(path, file, "outcome"))
    if name.upper() not in Outcome.__members__:
        allowed = f"one of {', '.join(Outcome.__members__).lower()}"
        raise RunFileError.at(path, "outcome", name, allowed)
    return Outcome[name.upper()]


def _performance(file: Any) -> Performance:
    told = file["performance"].attrs if "performance" in file else {}
    return Performance(
        wall_time=float(plain(told.get("wall_time_s", np.nan))),
        real_time_factor=float(plain(told.get("real_time_factor", np.nan))),
    )


def _check_signature(path: str | Path, start: bytes) -> None:
    if not start:
        raise _unreadable(path, "it is empty")
    if start != _HDF5_SIGNATURE:
        raise _unreadable(path, "it is not a netCDF-4 file")


def _schema_version(path: str | Path, attributes: Any) -> int:
    if plain(attributes.get("schema")) != SCHEMA:
        raise _unreadable(path, "it is a netCDF-4 or HDF5 file, but not a run of omnimorph")
    version = plain(attributes.get("schema_version"))
    if not isinstance(version, int) or version < 1:
        raise RunFileError.at(path, "schema_version", version, "an integer from 1 on")
    if version > SCHEMA_VERSION:
        writer = plain(attributes.get("omnimorph_version"))
        raise RunFileError(
            f"{path}: the run cannot be read: its schema version is {version} (by omnimorph "
            f"{writer}), but this one reads up to {SCHEMA_VERSION}; install a newer omnimorph.",
            file=str(path),
        )
    return version


def _attribute(path: str | Path, file: Any, key: str) -> Any:
    if key not in file.attrs:
        raise _unreadable(path, f"the attribute {key} is missing")
    return plain(file.attrs[key])


def _column(path: str | Path, file: Any, name: str) -> Any:
    if name not in file:
        raise _unreadable(path, f"the column {name} is missing")
    return file[name][...]


def _unreadable(path: str | Path, reason: str) -> RunFileError:
    return RunFileError(f"{path}: the run cannot be read: {reason}.", file=str(path))
