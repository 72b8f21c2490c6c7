"""What the tests of scenario and plant files share: the parts of a file, and its refusal."""

from __future__ import annotations

from pathlib import Path

import pytest

import omnimorph as om
from omnimorph.errors import InputError

TOP = """schema = 1
name = "mine"
vehicle = "omnimorph"
plant = "perfect"

[controller]
position_per_s2 = 300.0

[controller.allocator]
kind = "three-candidates"
W1_per_Hz4 = 1e-8
W2_position_s4_per_m2 = [3e6, 3e6, 3e6]
W2_attitude_s4_per_rad2 = [1e3, 1e3, 1e3]
W3_per_Hz4 = 1e-5
"""
SEGMENTS = """
[reference]
kind = "segments"
start_position_m = [0.0, 0.0, 1.2]

[[reference.segment]]
duration_s = 1.0
move_m = [0.0, 0.0, 0.1]
"""
WAYPOINTS = """
[reference]
kind = "waypoints"

[[reference.waypoint]]
time_s = 0.0
position_m = [0.0, 0.0, 1.2]

[[reference.waypoint]]
time_s = 2.0
position_m = [0.0, 0.1, 1.2]
"""
SAMPLES = """
[reference]
kind = "samples"
file = "poses.csv"
"""
PLANT = """schema = 1
name = "wobbly"

[plant]
physics_step_ms = 1.0
control_period_ms = 4.0
integrator = "runge-kutta-4"

[[plant.effect]]
kind = "rotor-lag"
up_ms = 20
"""
POSES = "time_s,x_m,y_m,z_m\n0,0,0,1\n1,0,0,1.5\n2,0,0,1\n"


def changed(text: str, old: str, new: str) -> str:
    """Return the text with the first `old` replaced by `new`."""
    assert old in text
    return text.replace(old, new, 1)


def refusal(folder: Path, text: str, reported_of: str = "mine.toml") -> InputError:
    """Return the error that a scenario file gives: one sentence that begins with a file."""
    file = folder / "mine.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        om.load_scenario(file)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(f"{folder / reported_of}: ")
    assert message.endswith((".", "?"))
    for jargon in ("pydantic", "Field", "str.", "dict", "NoneType", "Input should"):
        assert jargon not in message
    return caught.value
