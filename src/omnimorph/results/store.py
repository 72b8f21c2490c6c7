"""Reading the file of a run: what `omnimorph.results.saving` wrote, and older ones."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from omnimorph.design.input_files import open_input
from omnimorph.errors import InputError, OmnimorphError, RunFileError, legible
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.results.hdf5 import plain
from omnimorph.results.logged import LoggedColumn
from omnimorph.results.older_files import SCHEMA_VERSION, WITH_LOGS, add_missing, names_in_file
from omnimorph.results.record import COLUMNS, Outcome, Performance, Provenance, names_taken
from omnimorph.results.run import Run
from omnimorph.results.saving import ATTRIBUTES, LOGGED, SCHEMA, hash_of

__all__ = ["SCHEMA_VERSION", "load_run"]

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_MOST_COMPRESSED = 1032  # by this gzip can shrink, and no more


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


def _read_hdf5(path: str | Path, file: Any) -> Run:
    import h5py

    try:
        with h5py.File(file, "r") as hdf5:
            return _read(path, hdf5)
    except OmnimorphError:
        raise
    except Exception as error:  # h5py passes on a broken file as nearly any exception
        reason = " ".join(str(error).split()).strip("'\"") or type(error).__name__
        raise _unreadable(path, f"it is cut off or damaged ({reason})") from error


def _read(path: str | Path, file: Any) -> Run:
    from omnimorph.design.files import parse_vehicle

    version = _schema_version(path, file.attrs)
    held = {name: _attribute(path, file, key) for key, name in ATTRIBUTES.items()}
    held["content_hash"] = _attribute(path, file, "content_hash")
    outcome = _outcome(path, file)
    _check_size(path, file, version)
    columns = _columns(path, file, version)
    try:
        provenance = Provenance(**held)
        logged = _logged(file, version)
        if hash_of(columns, logged, outcome, provenance, version) != provenance.content_hash:
            raise _unreadable(path, "its content does not match its hash: changed or damaged")
        vehicle = parse_vehicle(provenance.vehicle_text, f"{path}: vehicle", questioned=False)
        add_missing(columns, version, vehicle)
        return Run(
            **columns,
            outcome=outcome,
            vehicle=vehicle,
            provenance=provenance,
            performance=_performance(file),
            logged={_free_name(name, version): column for name, column in logged.items()},
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
    return [name for name, data in held if LOGGED in data.attrs and hasattr(data, "dtype")]


def _logged(file: Any, version: int) -> dict[str, LoggedColumn]:
    logged = {}
    for name in _names_of_logged(file, version):
        if file[name].dtype != np.float64:
            raise InputError.at("run", f"type of {legible(name)}", str(file[name].dtype), "float64")
        try:
            logged[name] = LoggedColumn(file[name][...], plain(file[name].attrs.get("units")))
        except InputError as error:
            raise InputError(f"{legible(name)}: {error}") from None
    return logged


def _free_name(name: str, version: int) -> str:
    """Return the name of a logged column, with ``_logged`` behind one that was free back then."""
    is_taken = name in names_taken(Run) and name not in names_in_file(version).values()
    return f"{name}_logged" if is_taken else name


def _outcome(path: str | Path, file: Any) -> Outcome:
    name = str(_attribute(path, file, "outcome"))
    if name.upper() not in Outcome.__members__:
        allowed = f"one of {', '.join(Outcome.__members__).lower()}"
        raise RunFileError.at(path, "outcome", name, allowed)
    return Outcome[name.upper()]


def _performance(file: Any) -> Performance:
    held = file["performance"].attrs if "performance" in file else {}
    return Performance(
        wall_time=float(plain(held.get("wall_time_s", np.nan))),
        real_time_factor=float(plain(held.get("real_time_factor", np.nan))),
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
