"""What the attributes of `Vehicle` are called in a vehicle file."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["AS_THRUST", "FILE_KEYS", "FILTER_KEYS", "ROTOR_NUMBERS", "SERVO_NUMBERS"]

FILE_KEYS: Mapping[str, str] = {
    "name": "name",
    "title": "title",
    "mass": "mass_kg",
    "tilt_mechanism_mass": "tilt_mechanism_mass_kg",
    "inertia": "inertia_kg_m2",
    "rotor_position": "rotor.position_m",
    "rotor_axis": "rotor.axis",
    "hinge_axis": "rotor.hinge",
    "rotor_servo": "rotor.servo",
    "rotor_spin": "rotor.spin",
    "thrust_coefficient": "rotor.thrust_coefficient_N_per_Hz2",
    "drag_coefficient": "rotor.drag_coefficient_Nm_per_Hz2",
    "speed_min": "rotor.speed_min_Hz",
    "speed_max": "rotor.speed_max_Hz",
    "dead_band": "rotor.dead_band_Hz",
    "time_constant_up": "rotor.time_constant_up_ms",
    "time_constant_down": "rotor.time_constant_down_ms",
    "spin_inertia": "rotor.spin_inertia_kg_m2",
    "servo_name": "servo.name",
    "servo_angle_min": "servo.angle_min_deg",
    "servo_angle_max": "servo.angle_max_deg",
    "servo_rate_max": "servo.rate_max_deg_per_s",
    "servo_time_constant": "servo.time_constant_ms",
    "filter_cutoff": "filter",
}
"""Attribute of `Vehicle` -> its key in the file, as messages and ``[sources]`` call it."""

FILTER_KEYS = (
    "position_cutoff_Hz",
    "velocity_cutoff_Hz",
    "attitude_cutoff_Hz",
    "rate_cutoff_Hz",
)
"""Keys of ``[filter]`` in the order of `Vehicle.filter_cutoff`."""

ROTOR_NUMBERS = (
    "thrust_coefficient",
    "drag_coefficient",
    "speed_min",
    "speed_max",
    "dead_band",
    "time_constant_up",
    "time_constant_down",
    "spin_inertia",
)
"""Attributes that ``[rotor_defaults]`` may give for all rotors."""

SERVO_NUMBERS = ("servo_angle_min", "servo_angle_max", "servo_rate_max", "servo_time_constant")
"""Attributes that are one number a servo."""

AS_THRUST: Mapping[str, str] = {"speed_min_Hz": "thrust_min_N", "speed_max_Hz": "thrust_max_N"}
"""Key of a limit given as a speed -> its key when it is given as a thrust."""
