"""What people call each metric, and the unit they read it in: one list for screens and reports."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

__all__ = ["MEASURES", "Measure"]


class Measure(NamedTuple):
    """How a metric is shown: its words, the factor from the metric to the unit, and that unit."""

    words: str
    factor: float
    unit: str


MEASURES: Mapping[str, Measure] = {
    "position_error_mean_m": Measure("position error, mean", 1e3, "mm"),
    "position_error_rms_m": Measure("position error, root mean square", 1e3, "mm"),
    "position_error_max_m": Measure("position error, largest", 1e3, "mm"),
    "attitude_error_mean_rad": Measure("attitude error, mean angle", math.degrees(1.0), "°"),
    "attitude_error_rms_rad": Measure(
        "attitude error, root mean square angle", math.degrees(1.0), "°"
    ),
    "attitude_error_max_rad": Measure("attitude error, largest angle", math.degrees(1.0), "°"),
    "attitude_error_paper": Measure("attitude error, mean ‖e_R‖ (the paper's)", 1.0, "–"),
    "drag_energy_J": Measure("rotor drag energy", 1.0, "J"),
    "drag_energy_paper": Measure("rotor drag energy, the paper's count", 1.0, "“J”"),
    "acceleration_energy_J": Measure("energy to accelerate the rotors", 1.0, "J"),
    "acceleration_energy_paper": Measure(
        "energy to accelerate the rotors, the paper's count", 1.0, "“J”"
    ),
    "power_mean_W": Measure("rotor drag power, mean", 1.0, "W"),
    "tilt_mean_deg": Measure("tilt, mean", 1.0, "°"),
    "tilt_min_deg": Measure("tilt, smallest", 1.0, "°"),
    "tilt_max_deg": Measure("tilt, largest", 1.0, "°"),
    "speed_max_Hz": Measure("fastest rotor", 1.0, "Hz"),
    "saturated_share": Measure("share of time with a rotor at its limit", 100.0, "%"),
    "kkt_residual_max": Measure("largest KKT residual of the allocation", 1.0, "–"),
    "unproven_steps": Measure("control steps whose allocation is not proven", 1.0, "–"),
    "position_error_last_second_m": Measure("position error over the last second", 1e3, "mm"),
    "attitude_error_last_second_rad": Measure(
        "attitude error over the last second", math.degrees(1.0), "°"
    ),
    "duration_s": Measure("time flown", 1.0, "s"),
}
"""Key of ``metrics.json`` -> how it is shown, in the order in which people read them."""
