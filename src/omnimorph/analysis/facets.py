"""The facets and corners of a convex set of halfspaces, and a point inside it.

Everything here is in the coordinates of the affine subspace in which the set has an interior.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from omnimorph import _core
from omnimorph.protocols import FloatArray


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
    rows: FloatArray, bounds: FloatArray, size: float
) -> tuple[FloatArray, float, NDArray[np.int64]]:
    """Find the centre of an inscribed sphere of a set of about this size.

    Returns
    -------
    point : (d,) array
        The centre.
    depth : float
        Its least distance to a halfspace; negative if the set is empty.
    tight : array of int
        If the depth is zero, halfspaces that hold as equations all over the set.
    """
    from scipy.optimize import linprog

    d, scale = rows.shape[1], size or 1.0
    with_depth = np.column_stack([rows, np.ones(len(rows))])
    found = linprog(
        np.r_[np.zeros(d), -1.0],
        A_ub=with_depth,
        b_ub=bounds / scale,
        bounds=(None, None),
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    tight = np.flatnonzero(found.ineqlin.marginals < -1e-9)
    # The solver stops within its tolerance; these halfspaces are all equally far, to rounding.
    rest = bounds[tight] - with_depth[tight] @ (scale * found.x)
    point = (scale * found.x + np.linalg.lstsq(with_depth[tight], rest, rcond=1e-9)[0])[:d]
    return point, float((bounds - rows @ point).min()), tight


def middle_point(rows: FloatArray, bounds: FloatArray) -> FloatArray:
    """Return a point well inside a set in every direction, however thin the set; zero is inside.

    It is about where the product of the distances to all halfspaces is largest (the analytic
    centre), which no stretching moves; the centre of an inscribed sphere may lie at the end of
    a thin set.
    """
    x = np.zeros(rows.shape[1])
    for _ in range(100):
        dual = rows / (bounds - rows @ x)[:, None]
        step = -np.linalg.lstsq(dual, np.ones(len(dual)), rcond=None)[0]
        nearer = dual @ step
        if float(nearer @ nearer) < 0.01:
            break
        x = x + step / (1.0 + float(nearer.max()))
    return x


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
    _, spread, turn = np.linalg.svd(dual / np.sqrt(len(dual)), full_matrices=False)
    return np.asarray(spread[:, None] * turn)
