"""The facets and corners of a convex set of halfspaces, and a point inside it.

Everything here is in the coordinates of the flat in which the set has an interior.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from omnimorph import _core
from omnimorph.protocols import FloatArray

__all__ = ["Facets", "deepest_point", "facets_of", "polygon_area"]


class Facets(NamedTuple):
    """Corners and facets of a set.

    Attributes
    ----------
    vertices : (V, d) array
        In order around a set of two dimensions.
    rows, bounds : (F, d), (F,) arrays
        The irredundant halfspaces ``rows u ≤ bounds``, unit normals.
    polygons : tuple of F arrays of int
        Corners of each facet of a set of three dimensions, counter-clockwise from outside.
    """

    vertices: FloatArray
    rows: FloatArray
    bounds: FloatArray
    polygons: tuple[NDArray[np.int64], ...] = ()


def deepest_point(
    rows: FloatArray, bounds: FloatArray
) -> tuple[FloatArray, float, NDArray[np.int64]]:
    """Find a point well inside a set.

    Returns
    -------
    point : (d,) array
        Zero if that is well inside already, else the centre of a largest ball.
    depth : float
        Its least distance to a halfspace; negative if the set is empty.
    tight : array of int
        If the depth is zero, halfspaces that hold as equations all over the set.
    """
    d = rows.shape[1]
    least = float(bounds.min(initial=np.inf))
    if d == 0 or least > 1e-3 * float(np.abs(bounds).max(initial=0.0)):
        return np.zeros(d), least, np.empty(0, dtype=np.int64)
    from scipy.optimize import linprog

    scale = float(np.abs(bounds).max()) or 1.0
    with_depth = np.column_stack([rows, np.ones(len(rows))])
    found = linprog(
        np.r_[np.zeros(d), -1.0], A_ub=with_depth, b_ub=bounds / scale, bounds=(None, None)
    )
    tight = np.flatnonzero(found.ineqlin.marginals < -1e-9)
    return scale * found.x[:d], scale * float(found.x[d]), tight


def facets_of(rows: FloatArray, bounds: FloatArray) -> Facets:
    """Return the facets of a bounded set of at most three dimensions with zero in its interior.

    Parameters
    ----------
    rows, bounds : (F, d), (F,) arrays
        Halfspaces ``rows u ≤ bounds``, unit normals, all bounds positive; some may be superfluous.
    """
    d = rows.shape[1]
    if d == 0:
        return Facets(np.zeros((1, 0)), rows, bounds)
    if d == 1:
        low, high = (bounds[rows[:, 0] * side > 0.0].min() for side in (-1.0, 1.0))
        sides, ends = np.array([[-1.0], [1.0]]), np.array([low, high])
        return Facets(sides * ends[:, None], sides, ends)
    to_round = _rounding(rows, bounds)
    round_rows = rows @ np.linalg.inv(to_round)
    length = np.sqrt(np.einsum("fd,fd->f", round_rows, round_rows))
    unit, distances = round_rows / length[:, None], bounds / length
    if d == 2:  # the top of the prism over it
        unit = np.vstack([np.column_stack([unit, np.zeros(len(unit))]), [[0, 0, 1], [0, 0, -1]]])
        distances = np.r_[distances, 1.0, 1.0]
    corners, polygons, on = _core.facets(np.ascontiguousarray(unit), distances)
    vertices = corners[:, :d] @ np.linalg.inv(to_round).T
    if d == 2:
        edges = np.array([k for k in on if k < len(rows)])
        around = np.array(polygons[on.index(len(rows))])
        return Facets(vertices[around], rows[edges], bounds[edges])
    turn = 1 if np.linalg.det(to_round) > 0.0 else -1
    ordered = tuple(np.array(polygon[::turn]) for polygon in polygons)
    return Facets(vertices, rows[on], bounds[on], ordered)


def _rounding(rows: FloatArray, bounds: FloatArray) -> FloatArray:
    """Return the (d, d) map that makes the set about as large as 1 in every direction.

    In its coordinates the dual points n/h have the unit matrix as matrix of second moments.
    """
    dual = rows / bounds[:, None]
    spread, turn = np.linalg.eigh(dual.T @ dual / len(dual))
    return np.asarray(np.sqrt(spread)[:, None] * turn.T)


def polygon_area(polygon: FloatArray) -> float:
    """Return the area of a plane convex polygon in space, its corners in order."""
    spokes = polygon - polygon[0]
    return 0.5 * float(np.linalg.norm(np.cross(spokes[1:-1], spokes[2:]).sum(axis=0)))
