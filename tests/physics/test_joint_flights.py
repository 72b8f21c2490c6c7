"""Vehicles with many servos fly with joint allocation, from a vehicle file and a scenario file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import omnimorph as om
from omnimorph.results.run import Run

ARMS = 30.0 + 60.0 * np.arange(6)  # degrees


def vehicle_text(pairs: bool = False) -> str:
    """Return a vehicle file like Voliro's: six arms, each with a servo, and one rotor or two.

    Kamel et al. 2018, with servos that are fast enough to roll at once. The mass and inertia of
    the pairs are such that they weigh on their rotors as the single ones do.
    """
    heavier = 2.0 if pairs else 1.0
    inertia = [heavier * part for part in (0.0242, 0.0248, 0.0455)]
    text = f"""schema = 1
name = "arms"
title = "Six arms, each with a servo"
mass_kg = {1.92 * heavier}
inertia_kg_m2 = {inertia}

[rotor_defaults]
thrust_coefficient_N_per_Hz2 = 4.05e-4
drag_coefficient_Nm_per_Hz2 = 6.48e-6
speed_min_Hz = 0.0
speed_max_Hz = 133.0
time_constant_up_ms = 12.5
time_constant_down_ms = 25.0
spin_inertia_kg_m2 = 1e-5

[assumed]
mass_kg = "as said above"
"""
    for k, degrees in enumerate(ARMS):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        spins = ("ccw", "cw") if k % 2 == 0 else ("cw", "ccw")
        for spin in spins if pairs else spins[:1]:
            text += f"""
[[rotor]]
position_m = [{0.375 * c}, {0.375 * s}, 0.0]
hinge = [{c}, {s}, 0.0]
servo = "arm{k}"
spin = "{spin}"
"""
    for k in range(6):
        text += f"""
[[servo]]
name = "arm{k}"
angle_min_deg = -170.0
angle_max_deg = 170.0
rate_max_deg_per_s = 570.0
"""
    return text


SCENARIO = """schema = 1
name = "roll-and-hold"
vehicle = "arms.toml"
plant = "perfect"

[controller.allocator]
kind = "joint-tilt"
W1_per_Hz4 = 1e-5
W2_position_s4_per_m2 = [3e4, 3e4, 3e4]
W2_attitude_s4_per_rad2 = [10.0, 10.0, 10.0]
W3_per_Hz4 = 1e-5

[reference]
kind = "segments"
start_position_m = [0.0, 0.0, 1.2]

[[reference.segment]]
duration_s = 2.0

[[reference.segment]]
duration_s = 2.0
rotation_axis_W = [1.0, 0.0, 0.0]
rotation_angle_deg = 60.0

[[reference.segment]]
duration_s = 3.0

[[reference.segment]]
duration_s = 2.0
move_m = [0.3, -0.3, 0.2]
"""


def flown(folder: Path, vehicle: str, scenario: str = SCENARIO) -> Run:
    """Write both files and fly the scenario."""
    (folder / "arms.toml").write_text(vehicle, encoding="utf-8")
    (folder / "roll-and-hold.toml").write_text(scenario, encoding="utf-8")
    return om.fly(om.load_scenario(folder / "roll-and-hold.toml"))


@pytest.mark.parametrize("pairs", [False, True])
def test_six_servos_hover_roll_by_60_degrees_and_hold_it(tmp_path: Path, pairs: bool) -> None:
    run = flown(tmp_path, vehicle_text(pairs))
    assert run.outcome is om.Outcome.COMPLETED
    assert run.metrics.position_error_max_m < 0.01
    assert run.metrics.kkt_residual_max <= 1e-9
    rolled = np.degrees(np.arctan2(run.R_WB[:, 2, 1], run.R_WB[:, 2, 2]))
    held = (run.time >= 4.2) & (run.time <= 7.0)
    np.testing.assert_allclose(rolled[held], 60.0, atol=0.1)
    np.testing.assert_allclose(run.tilt_actual[run.time < 2.0], 0.0, atol=1e-3)
    assert np.abs(run.tilt_actual[held]).max() > 0.5
    step = np.radians(570.0) * 1e-3
    assert np.abs(np.diff(run.tilt_command[:-1], axis=0)).max() <= step * (1.0 + 1e-9)
    assert np.abs(run.tilt_command).max() <= np.radians(170.0)


def test_with_noise_a_price_on_motion_calms_the_servos(tmp_path: Path) -> None:
    noisy = SCENARIO.replace('"perfect"', '"realistic"')
    free = flown(tmp_path, vehicle_text(), noisy)
    calm = flown(
        tmp_path, vehicle_text(), noisy.replace("[reference]", "W4 = 100.0\n\n[reference]")
    )
    travelled = [np.abs(np.diff(run.tilt_command[:-1], axis=0)).sum() for run in (free, calm)]
    assert travelled[1] < 0.8 * travelled[0]
    for run in (free, calm):
        assert run.outcome is om.Outcome.COMPLETED
        assert run.metrics.position_error_max_m < 0.02


@pytest.mark.parametrize("case", ["a", "b"])
def test_omnimorph_flies_the_paper_s_flight(case: str) -> None:
    scenario = om.load_scenario(f"paper-case-{case}")
    weights = {
        name: getattr(scenario.allocator, name)
        for name in ("W1", "W2_position", "W2_attitude", "W3")
    }
    run = om.fly(replace(scenario, allocator=om.JointTilt(**weights)))
    reported = om.fly(scenario)
    assert run.outcome is om.Outcome.COMPLETED
    assert run.metrics.kkt_residual_max <= 1e-9
    assert run.metrics.position_error_mean_m < 1e-3
    energy = reported.metrics.drag_energy_paper
    assert run.metrics.drag_energy_paper == pytest.approx(energy, rel=0.02)
    assert run.tilt_command.min() >= 0.0
    assert run.tilt_command.max() <= scenario.vehicle.servo_angle_max[0]
