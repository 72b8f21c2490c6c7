"""Measurement noise: its statistics, its filters, and what it depends on."""

from __future__ import annotations

from functools import cache

import numpy as np

from omnimorph.protocols import FloatArray, State
from omnimorph.simulation.effects import MeasurementNoise
from omnimorph.simulation.fly import measurement_noise
from omnimorph.simulation.plant import PlantModel, SimulatedPlant
from omnimorph.verification.case import Result, case, largest
from omnimorph.verification.setting import TURN, command, omnimorph, plant_with

_STEPS = 20_000
_NORMAL = "the standard normal distribution, 240 000 numbers, five standard errors"
_NOISE = MeasurementNoise(position=1e-3, velocity=2e-3, attitude=3e-3, rate=1e-2)
_DEVIATIONS = np.repeat([1e-3, 2e-3, 3e-3, 1e-2], 3)


@cache
def _normals() -> FloatArray:
    return measurement_noise(seed=11, flight=3, steps=_STEPS)


@case(_NORMAL)
def noise_has_no_mean() -> Result:
    """The numbers behind the noise have mean 0."""
    return Result(value=float(_normals().mean()), tolerance=5.0 / np.sqrt(12 * _STEPS))


@case(_NORMAL)
def noise_has_unit_variance() -> Result:
    """They have variance 1."""
    error = 5.0 * np.sqrt(2.0 / (12 * _STEPS))
    return Result(value=float(_normals().var()), expected=1.0, tolerance=float(error))


@case(_NORMAL)
def noise_is_normal() -> Result:
    """Their fourth moment is 3, as of a normal distribution."""
    error = 5.0 * np.sqrt(96.0 / (12 * _STEPS))
    return Result(value=float(np.mean(_normals() ** 4)), expected=3.0, tolerance=float(error))


@case("independent samples: every correlation within five standard errors of zero")
def noise_is_independent() -> Result:
    """Axes, steps, flights and seeds, large ones too, are independent of one another."""
    here = _normals()
    others = [
        measurement_noise(seed, flight, _STEPS) for seed, flight in ((11, 4), (12, 3), (3, 11))
    ]
    others.append(measurement_noise(11 + 2**32, 3, _STEPS))
    others.append(np.roll(here, 1, axis=0))
    joined = np.corrcoef(np.hstack([here, *others]).T)
    return Result(value=largest(joined - np.eye(len(joined))), tolerance=5.5 / np.sqrt(_STEPS))


@case("definition: p + n, v + n, R exp([n]×), ω + n")
def measured_is_motion_plus_noise() -> Result:
    """What is measured is the motion with the documented numbers times the deviations on it."""
    plant = plant_with(_NOISE, flight=5)
    numbers, errors = measurement_noise(seed=0, flight=5, steps=50), []
    for row in numbers * _DEVIATIONS:
        errors.append(_noise(plant.state, plant.measure()) - row)
        plant.step_physics()
    return Result(value=largest(errors), tolerance=1e-12)


@case("closed form: variance σ² g / (2 − g), g = 1 − e^(−T ω_c)")
def filtered_noise_has_the_filters_variance() -> Result:
    """Through the vehicle's filters the noise has the variance of a first-order low pass."""
    cutoff = np.array([40.0, 80.0, 160.0, 0.0]) * TURN
    rows = _filtered_noise(cutoff, 20_000)[100:] / _DEVIATIONS
    gain = np.repeat(np.where(cutoff > 0.0, 1.0 - np.exp(-1e-3 * cutoff), 1.0), 3)
    ratio = rows.var(axis=0) / (gain / (2.0 - gain))
    # T seconds hold about T ω_c / 2 independent samples, N; the variance is known to (2 / N)^½.
    error = 5.0 * float(np.sqrt(4.0 / (20.0 * cutoff[0])))
    return Result(value=largest(ratio - 1.0), tolerance=error)


@case("definition: n_f ← n_f + g (n − n_f), from rest")
def filtered_noise_is_the_white_noise_filtered() -> Result:
    """The filters see the very numbers that white noise is made of."""
    cutoff = np.array([5.0, 10.0, 20.0, 0.0]) * TURN
    gain = np.repeat(np.where(cutoff > 0.0, 1.0 - np.exp(-1e-3 * cutoff), 1.0), 3)
    memory, expected = np.zeros(12), []
    for row in measurement_noise(seed=0, flight=0, steps=200) * _DEVIATIONS:
        memory = memory + gain * (row - memory)
        expected.append(memory)
    return Result(value=largest(_filtered_noise(cutoff, 200) - expected), tolerance=1e-12)


@case("definition: one draw a control step")
def measuring_twice_gives_the_same() -> Result:
    """Measuring twice within a control step gives the same, with filters and without."""
    vehicle = omnimorph().replace(filter_cutoff=np.full(4, 10.0 * TURN))
    errors = []
    for filtered in (False, True):
        noise = MeasurementNoise(position=1e-3, rate=1e-2, filtered=filtered)
        plant = SimulatedPlant(vehicle, PlantModel(effects=(noise,)))
        for _ in range(5):
            first, second = plant.measure(), plant.measure()
            errors += [largest(a - b) for a, b in zip(first, second, strict=True)]
            plant.step(command(1.6))
    return Result(value=max(errors), tolerance=0.0)


@case("definition: the noise of step k depends on (seed, flight, k) alone")
def measuring_seldom_gives_the_same() -> Result:
    """Measuring at some control steps gives what measuring at all of them gives there."""
    vehicle = omnimorph().replace(filter_cutoff=np.full(4, 10.0 * TURN))
    noise = MeasurementNoise(position=1e-3, velocity=1e-2, filtered=True)
    often, seldom = (SimulatedPlant(vehicle, PlantModel(effects=(noise,))) for _ in range(2))
    errors = []
    for k in range(30):
        measured = often.measure()
        if k in (2, 3, 17, 29):
            errors += [largest(a - b) for a, b in zip(measured, seldom.measure(), strict=True)]
        often.step_physics()
        seldom.step_physics()
    return Result(value=max(errors), tolerance=0.0)


def _filtered_noise(cutoff: FloatArray, steps: int) -> FloatArray:
    """Return (steps, 12) numbers: what filtered noise adds to the motion of a plant."""
    vehicle = omnimorph().replace(filter_cutoff=cutoff)
    noise = MeasurementNoise(position=1e-3, velocity=2e-3, attitude=3e-3, rate=1e-2, filtered=True)
    plant = SimulatedPlant(vehicle, PlantModel(effects=(noise,)))
    rows = np.empty((steps, 12))
    for row in rows:
        row[:] = _noise(plant.state, plant.measure())
        plant.step_physics()
    return rows


def _noise(truth: State, measured: State) -> FloatArray:
    """Return the 12 numbers by which a measurement differs from the motion."""
    turn = truth.R_WB.T @ measured.R_WB
    skew = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    sine = float(np.linalg.norm(skew))
    angle = skew * (np.arcsin(sine) / sine) if sine > 0.0 else skew
    parts = [measured.p_WB - truth.p_WB, measured.v_WB - truth.v_WB, angle]
    return np.concatenate([*parts, measured.w_WB_B - truth.w_WB_B])
