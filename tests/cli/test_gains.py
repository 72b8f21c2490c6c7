"""`omnimorph gains` and `omnimorph fly --vehicle`."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star

import omnimorph as om
from omnimorph.design import vehicle_text

Program = Callable[..., "subprocess.CompletedProcess[str]"]
LAGGED = {"time_constant_up": 0.02, "time_constant_down": 0.02}


def test_what_is_printed_is_what_is_flown(program: Program, tmp_path: Path) -> None:
    """The printed tables, put into a scenario file, are the proposal to six digits."""
    done = program("gains", "omnimorph")
    assert (done.returncode, done.stderr) == (0, "")
    assert "yaw: k = 121.9/s², the lag of 22 ms" in done.stdout
    toml = done.stdout[done.stdout.index("[controller]\n") :]
    text = f'schema = 1\nname = "mine"\nbase = "hover"\n{toml}'
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    reported = om.load_scenario(tmp_path / "mine.toml")
    proposed = om.propose_controller(reported.vehicle)
    assert reported.gains.axes("rate") == pytest.approx(proposed.gains.axes("rate"), rel=1e-5)
    np.testing.assert_allclose(reported.allocator.W1, proposed.allocator.W1, rtol=1e-5)
    assert reported.allocator.kind == proposed.allocator.kind


def test_gains_for_programs(program: Program) -> None:
    done = program("gains", "omnimorph", "--period-ms", "2", "--delay-ms", "10", "--json")
    found = json.loads(done.stdout)
    vehicle = om.load_vehicle("omnimorph")
    gains = om.propose_controller(vehicle, 0.002, 0.010).gains
    margins = om.stability_margins(gains, vehicle, 0.002, 0.010)
    assert (found["control_period_ms"], found["delay_ms"]) == (2.0, 10.0)
    assert found["controller"]["attitude_per_s2"] == list(gains.axes("attitude"))
    assert found["margins"]["axis"] == ["x", "y", "z", "roll", "pitch", "yaw"]
    assert found["margins"]["delay_margin_ms"] == pytest.approx(1e3 * margins.delay_margin)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["omnimorph", "--delay-ms", "600"], "delay is 0.6, but it must be at most"),
        (["omnimorph", "--delay-ms", "-1"], '--delay-ms is "-1", but it must be a number'),
        (["omnimorph", "--period-ms", "0"], '--period-ms is "0", but it must be a number of'),
        (["omnimorph", "--period-ms", "soon"], '--period-ms is "soon", but it must be a number of'),
        (["omnimorf"], "omnimorph"),
        (["heavy.toml"], "it cannot hover level"),
    ],
)
def test_what_cannot_be_proposed(
    program: Program, tmp_path: Path, words: list[str], expected: str
) -> None:
    heavy = build_star(4, mass=2.0, name="heavy")
    (tmp_path / "heavy.toml").write_text(vehicle_text(heavy), encoding="utf-8")
    done = program("gains", *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert expected in done.stderr
    assert done.stderr.count("\n") == 1


def test_fly_another_vehicle(program: Program, tmp_path: Path) -> None:
    quadrotor = build_star(4, name="quad", **LAGGED)
    (tmp_path / "quad.toml").write_text(vehicle_text(quadrotor), encoding="utf-8")
    done = program("fly", "tour", "--vehicle", "quad.toml", "--seed", "1")
    assert (done.returncode, done.stderr) == (0, "")
    assert "vehicle quad, plant realistic, seed 1" in done.stdout
    run = om.load_run(tmp_path / "runs" / "tour-quad-seed1" / "run.nc")
    assert run.vehicle.n_rotors == 4
    refused = program("fly", "paper-case-a", "--vehicle", "quad.toml")
    assert refused.returncode == 2
    assert "does not fit vehicle quad with 0 servos; fly tour, or another scenario" in (
        refused.stderr
    )
    assert not (tmp_path / "runs" / "paper-case-a-quad-seed0").exists()
