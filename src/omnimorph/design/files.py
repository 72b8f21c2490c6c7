"""Vehicle files: from TOML with units in its key names to a `Vehicle` in SI.

::

    schema = 1
    name = "my-drone"
    title = "A quadrotor"
    mass_kg = 1.28
    tilt_mechanism_mass_kg = 0.0                  # its part of the mass; 0, or no key: none known
    inertia_kg_m2 = [0.0115, 0.0114, 0.0194]      # or three rows of three numbers

    [rotor_defaults]                              # what all rotors share
    thrust_coefficient_N_per_Hz2 = 6.5e-4
    drag_coefficient_Nm_per_Hz2 = 1e-5
    speed_min_Hz = 16.0                           # or thrust_min_N and thrust_max_N
    speed_max_Hz = 100.0

    [[rotor]]
    position_m = [0.23, 0.0, 0.0]
    spin = "ccw"                                  # axis defaults to [0, 0, 1]
    ...

    [sources]
    mass_kg = "a kitchen scale"

`docs/notation.md` explains the quantities, `omnimorph.design.schema` lists every key.
"""

from __future__ import annotations

import os
from importlib import resources
from importlib.resources.abc import Traversable

from omnimorph.design.documents import catalogue_names, find_document, record_or_file
from omnimorph.design.reading import parse_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.design.writing import vehicle_text
from omnimorph.errors import VehicleError

__all__ = [
    "VehicleLike",
    "as_vehicle",
    "list_vehicles",
    "load_vehicle",
    "parse_vehicle",
    "vehicle_text",
]

VehicleLike = Vehicle | str | os.PathLike[str]
"""A vehicle, or the name or file of one."""


def list_vehicles() -> list[str]:
    """Return the names of the catalogue's vehicles, sorted."""
    return catalogue_names(_catalogue())


def load_vehicle(name_or_path: str | os.PathLike[str]) -> Vehicle:
    """Load a vehicle of the catalogue, or from a file.

    Parameters
    ----------
    name_or_path : str or path
        A name of `list_vehicles`, which goes first, or the path of a TOML file.

    Returns
    -------
    Vehicle
        Checked, in SI.

    Raises
    ------
    VehicleError
        If there is no such vehicle, or its file cannot be read or describes none; one sentence
        with the file, the key, the value and what is allowed.

    Examples
    --------
    >>> load_vehicle("omnimorph").n_rotors
    8
    """
    file, text = find_document(name_or_path, _catalogue(), "vehicle", VehicleError)
    return parse_vehicle(text, file)


def as_vehicle(vehicle: VehicleLike) -> Vehicle:
    """Return a vehicle that may be given as `load_vehicle` takes it; refuse anything else."""
    return record_or_file(vehicle, Vehicle, "vehicle", load_vehicle, VehicleError)


def _catalogue() -> Traversable:
    return resources.files("omnimorph.design") / "catalogue"
