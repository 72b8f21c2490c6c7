"""Attitudes on two discs, and what hovering in them costs: what `attitude_figures` draws.

An attitude is the vertical seen from the body, ``up = R_WBᵀ e3``: turning about the vertical costs
nothing. All attitudes fit on two discs, the hemispheres of up, each in Lambert's equal-area
projection: a share of the disc is the same share of the attitudes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from omnimorph.analysis.hover import hover_map
from omnimorph.analysis.polytope import Polytope
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray


class AttitudeGrid(NamedTuple):
    """The attitudes of both discs on a square grid, a little beyond their rim.

    Attributes
    ----------
    side : (K,) array
        Coordinates of the grid in the disc, whose radius is 1; the middle is one of them.
    shown : (K, K) array of bool
        Which points of the square are used.
    up : (2, D, 3) array
        The vertical seen from the body at these: on the upper disc, then on the lower.
    """

    side: FloatArray
    shown: NDArray[np.bool_]
    up: FloatArray

    def on_discs(self, values: FloatArray) -> FloatArray:
        """Return (2, K, K) values from those at `up`, (2 D,); not a number where there is none."""
        square = np.full((2, *self.shown.shape), np.nan)
        square[:, self.shown] = values.reshape(2, -1)
        return square


def attitude_grid(count: int) -> AttitudeGrid:
    """Return the attitudes of both discs, about 0.9 count² on each.

    With ρ the distance from the middle, up leans by θ with ρ = √2 sin(θ/2): 0 is upright (on the
    lower disc upside down), 1 is on its side. To the right in the disc is x, upwards y.
    """
    side = np.linspace(-1.08, 1.08, count)
    x, y = np.meshgrid(side, side)
    shown = x**2 + y**2 <= 1.15
    stretch = np.sqrt(2.0 - x[shown] ** 2 - y[shown] ** 2)
    height = 1.0 - x[shown] ** 2 - y[shown] ** 2
    upper = np.column_stack([x[shown] * stretch, y[shown] * stretch, height])
    return AttitudeGrid(side, shown, np.stack([upper, upper * [1.0, 1.0, -1.0]]))


def best_tilt_on(vehicle: Vehicle, tilts: FloatArray, up: FloatArray) -> FloatArray:
    """Return the tilt, rad, of least hover power in D attitudes: (D,); not a number if none can.

    The best of evenly spaced tilts, common to all servos, and the vertex of the parabola through
    it and its neighbours if all three can hover.
    """
    power = hover_map(vehicle, up, tilts).power
    best = power.argmin(axis=1)
    found = np.where(np.isfinite(power.min(axis=1)), tilts[best], np.nan)
    inner = np.flatnonzero((best > 0) & (best < len(tilts) - 1))
    before, here, after = (power[inner, best[inner] + step] for step in (-1, 0, 1))
    smooth = np.isfinite(before) & np.isfinite(after)
    before, here, after = before[smooth], here[smooth], after[smooth]
    bend = np.maximum(before - 2.0 * here + after, 1e-300)
    found[inner[smooth]] += 0.5 * (tilts[1] - tilts[0]) * (before - after) / bend
    return found


def weight_inside(vehicle: Vehicle, one: Polytope, up: FloatArray) -> FloatArray:
    """Return how far inside a set of forces the weight is, N: (D,); −inf for a degenerate set."""
    if one.dimension < 3:
        return np.full(len(up), -np.inf)
    reach = vehicle.mass * GRAVITY * up @ one.normals.T
    return np.asarray((one.offsets - reach).min(axis=1))


def few_attitudes(up: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the cheapest attitude of each disc, if so few can hover that no area would be seen."""
    chosen = []
    if np.isfinite(values).sum() <= 6:
        for sign in (1.0, -1.0):
            half = np.flatnonzero(np.isfinite(values) & (sign * up[:, 2] >= 0.0))
            chosen += [int(half[values[half].argmin()])] if len(half) else []
    return up[chosen], values[chosen]


def softened(grid: AttitudeGrid, can: NDArray[np.bool_]) -> FloatArray:
    """Return where it can hover as numbers, positive where it can, that make no stairs: (2 D,).

    Weights 1, 2, 1 across and along; a row of single cells just remains.
    """
    square = np.nan_to_num(grid.on_discs(can.astype(np.float64)))
    for axis in (1, 2):
        square = np.roll(square, 1, axis) + 2.0 * square + np.roll(square, -1, axis)
    soft: FloatArray = square[:, grid.shown].ravel() / 16.0 - 0.4
    return soft


def grown(square: FloatArray) -> FloatArray:
    """Return a grid whose numbers have spread by three cells into where there are none.

    So that colours reach under the edge of the grey.
    """
    full = square.copy()
    for _ in range(3):
        known = np.isfinite(full)
        padded = np.pad(np.where(known, full, 0.0), 1)
        weights = np.pad(known.astype(np.float64), 1)
        rows, columns = square.shape
        around = [(i, j) for i in range(3) for j in range(3)]
        total = sum(padded[i : i + rows, j : j + columns] for i, j in around)
        count = sum(weights[i : i + rows, j : j + columns] for i, j in around)
        mean = np.divide(total, count, out=np.full_like(full, np.nan), where=count > 0.0)
        full = np.where(known, full, mean)
    return full
