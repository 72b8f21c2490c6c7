"""Vehicles for the tests of reports on analyses, and what omnimorph comes to."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

import omnimorph as om
from omnimorph.analysis import analyze
from omnimorph.analysis.overview import VehicleAnalysis
from omnimorph.protocols import FloatArray

OMNIMORPH = om.load_vehicle("omnimorph")
NO_SERVOS: dict[str, Any] = {
    "servo_name": (),
    "servo_angle_min": [],
    "servo_angle_max": [],
    "servo_rate_max": [],
    "servo_time_constant": [],
}


def build_multirotor(angles: FloatArray, **changes: Any) -> om.Vehicle:
    """Build rotors on a circle, all upright, in alternating directions; with changes."""
    n = len(angles)
    around = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(n)])
    values: dict[str, Any] = {
        "name": f"rotors-{n}",
        "title": "For tests",
        "mass": 1.0,
        "inertia": np.diag([0.01, 0.01, 0.02]),
        "rotor_position": 0.25 * around,
        "rotor_axis": [[0.0, 0.0, 1.0]] * n,
        "hinge_axis": [[0.0] * 3] * n,
        "rotor_servo": [-1] * n,
        "rotor_spin": np.resize([1.0, -1.0], n),
        "thrust_coefficient": [1e-5] * n,
        "drag_coefficient": [2e-7] * n,
        "speed_min": [0.0] * n,
        "speed_max": [800.0] * n,
        "dead_band": [0.0] * n,
        "time_constant_up": [0.02] * n,
        "time_constant_down": [0.02] * n,
        "spin_inertia": [1e-5] * n,
        "filter_cutoff": [0.0] * 4,
    }
    return om.Vehicle(**(values | NO_SERVOS | changes))


def build_tilting_hexarotor() -> om.Vehicle:
    """Build a hexarotor whose arms turn, each by a servo of its own; reversible rotors."""
    angles = np.radians(np.arange(0.0, 360.0, 60.0))
    return build_multirotor(
        angles,
        mass=1.6,
        hinge_axis=np.column_stack([np.cos(angles), np.sin(angles), np.zeros(6)]),
        rotor_servo=range(6),
        speed_min=[-800.0] * 6,
        servo_name=[f"arm{i}" for i in range(6)],
        servo_angle_min=[math.radians(-20.0)] * 6,
        servo_angle_max=[math.radians(70.0)] * 6,
        servo_rate_max=[3.0] * 6,
        servo_time_constant=[0.0] * 6,
    )


def build_fixed_omnimorph(tilt: float) -> om.Vehicle:
    """Build OmniMorph with its rotors fixed at a tilt, and without the mechanism."""
    z0, zC, zS = OMNIMORPH.thrust_axis_parts
    return OMNIMORPH.replace(
        name="fixed",
        title="For tests",
        mass=1.128,
        tilt_mechanism_mass=0.0,
        rotor_axis=z0 + zC * math.cos(tilt) + zS * math.sin(tilt),
        hinge_axis=np.zeros((8, 3)),
        rotor_servo=[-1] * 8,
        sources={},
        **NO_SERVOS,
    )


QUADROTOR = build_multirotor(np.radians([45.0, 135.0, 225.0, 315.0]))
NOT_MORPHING = {
    "quadrotor": QUADROTOR,
    "too heavy": QUADROTOR.replace(mass=9.0),
    "one rotor": build_multirotor(np.zeros(1)),
    "fixed": build_fixed_omnimorph(math.atan(math.sqrt(2.0))),
}


@functools.cache
def analysis_of_omnimorph() -> VehicleAnalysis:
    """Return the analysis that all these tests read, made once."""
    return analyze(OMNIMORPH)
