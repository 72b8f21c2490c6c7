"""Warnings of a fit in their own words and numbers, and what is just allowed."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from tests.physics.bench_runs import THRUST, TURN, bench_run, staircase
from tests.unit.test_bench_data import refusal

from omnimorph.errors import InputError
from omnimorph.identification import fit_rotor
from omnimorph.identification.time_constants import fit_steps
from omnimorph.protocols import FloatArray
from omnimorph.units import to_SI


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_just_enough_rows_that_vary_just_enough_are_fitted(sign: float) -> None:
    """What messages say is allowed is allowed: 8 rows, the fastest 1.2 times the slowest."""
    few = sign * TURN * np.linspace(100.0, 120.0, 8)
    fit = fit_rotor(bench_run(few, force_noise=0.0, torque_noise=0.0))
    assert fit.thrust.both.value == pytest.approx(THRUST)
    assert "1.2 times the slowest" in refusal(bench_run(few * np.linspace(1.0, 0.999, 8)))
    both = np.concatenate([few, -few, few])
    fit = fit_rotor(bench_run(both, force_noise=0.0, torque_noise=0.0))
    assert fit.thrust.reverse is not None
    assert "only 7 rows" in refusal(bench_run(np.delete(both, 8)))


def test_sensor_that_was_not_zeroed() -> None:
    run = bench_run(staircase())
    fit = fit_rotor(bench_run(staircase(), force=run.force + 0.4))
    (sentence,) = (
        reported for reported in fit.warnings if reported.startswith("At rest the force would be ")
    )
    found = re.fullmatch(
        r"At rest the force would be ([\d.]+) N, not 0, ([\d.]+)% of the largest: zero the sensor "
        "with the rotor at rest.",
        sentence,
    )
    assert found is not None
    assert float(found[1]) == pytest.approx(0.4, abs=0.05)
    assert float(found[2]) == pytest.approx(
        100.0 * float(found[1]) / fit.bench.force.max(), abs=0.1
    )


def test_noise_that_drifts_is_reported() -> None:
    random = np.random.default_rng(0)
    drift = np.convolve(random.standard_normal(2020), np.ones(20) / 4.5, "valid")[:2000]
    speed = staircase(2000)
    run = bench_run(speed, force=THRUST * speed**2 + 0.05 * drift)
    fit = fit_rotor(run)
    (reported,) = (
        one for one in fit.warnings if one.startswith("Successive residuals of the force")
    )
    rest = fit.thrust.residual[~fit.thrust.outlier]
    alike = float(np.corrcoef(rest[1:], rest[:-1])[0, 1])
    wider = math.sqrt((1.0 + alike) / (1.0 - alike))
    assert reported == (
        f"Successive residuals of the force are alike (correlation {alike:.2f}), so its interval "
        f"is too narrow, by a factor of about {wider:.2g}."
    )


def test_as_many_steps_as_are_allowed_are_taken() -> None:
    """A command that steps at every row, which no speed follows."""
    for steps, allowed in ((1000, True), (1001, False)):
        command = to_SI(np.where(np.arange(steps + 1) % 2, 120.0, 60.0), "Hz")
        time: FloatArray = np.arange(steps + 1) / 100.0
        if allowed:
            assert fit_steps(time, command, command) == ()
            continue
        with pytest.raises(InputError, match="but it must be at most 1000;"):
            fit_steps(time, command, command)
