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
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from omnimorph.errors import InputError
from omnimorph.results.atomic import replacing
from omnimorph.results.columns import Column
from omnimorph.results.hdf5 import OutputFile, fixed_text, stored
from omnimorph.results.logged import LoggedColumn, as_columns, logged_sizes
from omnimorph.results.older_files import SCHEMA_VERSION, names_in_file, schema_of
from omnimorph.results.record import COLUMNS, Outcome, Provenance, RunRecord

SCHEMA = "omnimorph run"
LOGGED = "logged"  # the attribute that says so
_AXES = ["x", "y", "z"]
_WRENCH = ["force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"]
# Attribute of the file -> field of the provenance; only files and displays carry units in names.
ATTRIBUTES = {
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


def hash_content(run: RunRecord, schema_version: int = SCHEMA_VERSION) -> str:
    """Return the hash of a run: see `hash_of`."""
    return hash_of(vars(run), run.logged, run.outcome, run.provenance, schema_version)


def hash_of(
    columns: Mapping[str, Any],
    logged: Mapping[str, LoggedColumn],
    outcome: Outcome,
    provenance: Provenance,
    version: int = SCHEMA_VERSION,
) -> str:
    """Return the SHA-256 of what a run is made of, as hexadecimal text.

    Numbers enter as little-endian IEEE bytes, row by row, texts as JSON in ASCII; a hash that the
    provenance may hold does not enter, nor do columns newer than the schema. Logged columns enter
    in the order of their names, where there are any.
    """
    held = dataclasses.asdict(provenance)
    del held["content_hash"]
    record = {"schema": SCHEMA, "outcome": outcome.name, "provenance": held}
    if logged:
        record["logged"] = {name: column.unit for name, column in logged.items()}
    digest = hashlib.sha256(json.dumps(record, sort_keys=True).encode())
    named = {"time": "time", **names_in_file(version)}
    arrays = {name: columns[column] for column, name in named.items()}
    arrays |= {name: logged[name].values for name in sorted(logged)}
    for name, values in arrays.items():
        array = stored(values)
        digest.update(f"{name} {array.dtype.str} {array.shape}".encode())
        digest.update(array.reshape(-1).view(np.uint8))
    return digest.hexdigest()


def save_run(
    run: RunRecord, path: str | Path, sentence: str, content_hash: str, *, compression: int = 0
) -> None:
    """Write a run to a netCDF-4 file, as a whole or not at all: see `Run.save`.

    The file says in a sentence how the flight ended, and holds the hash of its content.
    """
    if compression not in range(10):
        raise InputError.at("save", "compression", compression, "an integer from 0 to 9")
    import h5py

    with replacing(path) as temporary, OutputFile(temporary) as output:
        try:
            with h5py.File(output, "w", track_order=True) as file:
                _write(file, run, sentence, content_hash, compression)
        except Exception:  # what HDF5 makes of a file that does not hold what it wrote
            if output.failure is None:
                raise
        if output.failure is not None:
            raise output.failure


def _write(file: Any, run: RunRecord, sentence: str, content_hash: str, compression: int) -> None:
    file.attrs["title"] = fixed_text(f"omnimorph flight: {run.provenance.scenario_name}")
    file.attrs["schema"] = fixed_text(SCHEMA)
    file.attrs["schema_version"] = schema_of(run)
    file.attrs["outcome"] = fixed_text(run.outcome.name.lower())
    file.attrs["outcome_sentence"] = fixed_text(sentence)
    for attribute, name in ATTRIBUTES.items():
        value = getattr(run.provenance, name)
        file.attrs[attribute] = fixed_text(value) if isinstance(value, str) else value
    file.attrs["content_hash"] = fixed_text(content_hash)
    scales = _add_dimensions(file, run)
    for column in COLUMNS:
        if all(dim in scales for dim in column.dims):
            _add_column(file, column, getattr(run, column.name), scales, compression)
    for column in as_columns(run.logged):
        data = _add_column(file, column, run[column.name], scales, compression)
        data.attrs[LOGGED] = fixed_text("by the flight")
    group = file.create_group("performance", track_order=True)
    group.attrs["wall_time_s"] = run.performance.wall_time
    group.attrs["real_time_factor"] = run.performance.real_time_factor


def _add_dimensions(file: Any, run: RunRecord) -> dict[str, Any]:
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
