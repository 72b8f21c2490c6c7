"""Analyses against the clock, and beside them what is done where no exact answer is at hand.

There thrusts are sampled, over a grid of each rotor's least, middle and largest or at random, and
the inscribed sphere about zero is read off the convex hull of their forces.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from omnimorph.analysis import hover_map, inscribed_radius, sphere_directions, tilt_sweep
from omnimorph.design.files import load_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.allocation import allocation_matrix
from omnimorph.protocols import FloatArray

SAMPLES = 100_000
LITTLE = 0.01  # of the largest moment: what counts as none among random thrusts
EXACT_CALLS = 20  # to each hull, as they are so much shorter
TURNS = 5


class Sampled(NamedTuple):
    """One way of sampling: s for a radius, its error as a share, thrusts that it could use."""

    time: float
    error: float
    used: float


class RadiusTimes(NamedTuple):
    """One round of radii, exact ones in s a call and sampled ones beside them."""

    free: float  # moments free
    zero: float  # at zero moment
    grid: Sampled  # moments free, from here on
    drawn: Sampled
    drawn_zero: Sampled  # at zero moment: random thrusts that hardly make one
    projected: Sampled  # at zero moment: random thrusts, their moments taken away


class AnalysisTimes(NamedTuple):
    """What analyses over many tilts take, in s."""

    sweep: float
    hover_map: float


def time_radii(seed: int, turns: int = TURNS) -> RadiusTimes:
    """Find OmniMorph's radii exactly and by sampling, in turns, a new tilt each time: medians.

    Sampling is timed from the thrusts on, as the same serve at every tilt. The tilts are spread
    over 20 to 60°.
    """
    vehicle = load_vehicle("omnimorph")
    grid, drawn = thrust_grid(vehicle), random_thrusts(vehicle, SAMPLES, seed)
    ways: tuple[tuple[bool, FloatArray, Callable[[FloatArray, FloatArray], FloatArray]], ...] = (
        (False, grid, _all),
        (False, drawn, _all),
        (True, drawn, nearly_moment_free),
        (True, drawn, lambda A, thrust: projected(A, thrust, vehicle)),
    )
    exact, sampled = [], []
    for tilts in np.radians(np.linspace(20.0, 60.0, turns * EXACT_CALLS)).reshape(turns, -1):
        radii = [_exact_radii(vehicle, tilts, zero_moment) for zero_moment in (False, True)]
        exact.append([seconds for seconds, _ in radii])
        row = []
        for zero_moment, thrusts, chosen in ways:
            began = time.perf_counter()
            A = allocation_matrix(vehicle, tilts[-1])
            used = chosen(A, thrusts)
            radius = hull_radius(forces_of(A, used))
            seconds = time.perf_counter() - began
            row.append((seconds, abs(radius / radii[zero_moment][1] - 1.0), len(used)))
        sampled.append(row)
    free, zero = np.median(exact, axis=0).tolist()
    return RadiusTimes(free, zero, *(Sampled(*way) for way in np.median(sampled, axis=0).tolist()))


def time_analysis() -> AnalysisTimes:
    """Sweep OmniMorph's tilt from 0 to 90° and map its hover power, once each."""
    vehicle = load_vehicle("omnimorph")
    began = time.perf_counter()
    tilt_sweep(vehicle, np.radians(np.linspace(0.0, 90.0, 181)), beyond_limits=True)
    swept = time.perf_counter()
    hover_map(vehicle, sphere_directions(100), np.radians(np.linspace(0.0, 60.0, 61)))
    return AnalysisTimes(swept - began, time.perf_counter() - swept)


def thrust_grid(vehicle: Vehicle) -> FloatArray:
    """Return every combination of least, middle and largest thrusts: (3ⁿ, n), N."""
    low, high = vehicle.thrust_min, vehicle.thrust_max
    each = np.column_stack([low, 0.5 * (low + high), high])
    axes = np.meshgrid(*each, indexing="ij")
    thrusts: FloatArray = np.column_stack([axis.ravel() for axis in axes])
    return thrusts


def random_thrusts(vehicle: Vehicle, count: int, seed: int) -> FloatArray:
    """Return thrusts drawn uniformly from within the limits: (count, n), N."""
    limits = vehicle.thrust_min, vehicle.thrust_max
    numbers = np.random.default_rng(seed)
    thrusts: FloatArray = numbers.uniform(*limits, (count, vehicle.n_rotors))
    return thrusts


def nearly_moment_free(A: FloatArray, thrusts: FloatArray) -> FloatArray:
    """Return those of (N, n) thrusts that make at most 1 % of the largest moment among them."""
    moment = np.linalg.norm(_images(A[3:], thrusts), axis=1)
    little = np.flatnonzero(moment <= LITTLE * moment.max())
    return np.take(thrusts, little, axis=0)


def projected(A: FloatArray, thrusts: FloatArray, vehicle: Vehicle) -> FloatArray:
    """Return the nearest thrusts that make no moment, as far as they are within the limits."""
    T = A[3:]
    free = thrusts - _images(np.linalg.pinv(T) @ T, thrusts)
    within = (free >= vehicle.thrust_min) & (free <= vehicle.thrust_max)
    return free[within.all(axis=1)]


def forces_of(A: FloatArray, thrusts: FloatArray) -> FloatArray:
    """Return the forces that (N, n) thrusts make: (N, 3), N, in B."""
    return _images(A[:3], thrusts)


def hull_radius(points: FloatArray) -> float:
    """Return the radius of the inscribed sphere about zero of the hull of (N, 3) points.

    0 if zero is outside, or if the points are too few or too flat to have an inside.
    """
    from scipy.spatial import ConvexHull, QhullError

    if len(points) < 4:
        return 0.0
    try:
        hull = ConvexHull(points)
    except QhullError:
        return 0.0
    return max(float(-hull.equations[:, 3].max()), 0.0)


def _images(matrix: FloatArray, thrusts: FloatArray) -> FloatArray:
    """Return the matrix times each of (N, n) thrusts."""
    # Piece by piece, so small that BLAS keeps to one core, as the exact radius does.
    pieces = np.array_split(thrusts, max(len(thrusts) // 2000, 1))
    return np.concatenate([piece @ matrix.T for piece in pieces])


def _all(A: FloatArray, thrusts: FloatArray) -> FloatArray:
    return thrusts


def _exact_radii(vehicle: Vehicle, tilts: FloatArray, zero_moment: bool) -> tuple[float, float]:
    """Return s for each exact radius, the median, and the radius at the last tilt."""
    spent, radius = [], 0.0
    for tilt in tilts:
        began = time.perf_counter()
        radius = inscribed_radius(vehicle, tilt, zero_moment=zero_moment)
        spent.append(time.perf_counter() - began)
    return statistics.median(spent), radius
