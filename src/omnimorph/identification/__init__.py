"""Numbers of a vehicle file, from measurements and from drawings.

================  =============================================================================
`BenchData`       what a thrust bench recorded, checked; `read_bench` reads it from a CSV file
`fit_rotor`       thrust and drag coefficient, limits and time constants, with 95 % intervals
`assemble`        mass, centre of mass and inertia of boxes, cylinders and point masses
`load_parts`      the same parts from a TOML file
================  =============================================================================
"""

from __future__ import annotations

from omnimorph.identification.bench_data import BenchData, read_bench
from omnimorph.identification.inertia import (
    Box,
    Cylinder,
    MassProperties,
    PointMass,
    assemble,
    load_parts,
)
from omnimorph.identification.rotor_fit import RotorFit, fit_rotor

__all__ = [
    "BenchData",
    "Box",
    "Cylinder",
    "MassProperties",
    "PointMass",
    "RotorFit",
    "assemble",
    "fit_rotor",
    "load_parts",
    "read_bench",
]
