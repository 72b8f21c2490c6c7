"""The small dense box QP that allocation solves, by itself."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from omnimorph import _core
from omnimorph.errors import InputError
from omnimorph.protocols import FloatArray

MOST_VARIABLES = 36


class BoxQpAnswer(NamedTuple):
    """An answer that proves itself.

    Attributes
    ----------
    x : (n,) array
        The minimiser.
    active : (n,) array
        −1 where x is at its lower bound, +1 at its upper one, 0 between.
    kkt_residual : float
        max |x − clip(x − (Hx + g))|: zero only at the minimum.
    iterations : int
        Linear systems solved.
    """

    x: FloatArray
    active: FloatArray
    kkt_residual: float
    iterations: int


def solve_box_qp(
    H: FloatArray,
    g: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    active: FloatArray | None = None,
) -> BoxQpAnswer:
    """Minimise ½ xᵀHx + gᵀx over lower ≤ x ≤ upper, H symmetric and positive definite, n ≤ 36.

    Block principal pivoting, and a primal active-set method where that does not settle (see
    ``core/include/omnimorph/control/box_qp.hpp``). Bounds and multipliers are judged to 1e-13, so H
    should have a mean of about 1 on its diagonal.

    Parameters
    ----------
    H : (n, n) array
    g, lower, upper : (n,) array
    active : (n,) array, optional
        Where to begin: −1, 0 or +1 for each variable; none at a bound by default.

    Raises
    ------
    InputError
        If the shapes do not fit.

    Examples
    --------
    >>> import numpy as np
    >>> answer = solve_box_qp(np.eye(2), np.array([-2.0, 0.5]), -np.ones(2), np.ones(2))
    >>> answer.x.tolist(), answer.active.tolist()
    ([1.0, -0.5], [1.0, 0.0])
    """
    n = np.size(g)
    start = np.zeros(n) if active is None else active
    vectors = [np.ascontiguousarray(part, dtype=np.float64) for part in (g, lower, upper, start)]
    matrix = np.ascontiguousarray(H, dtype=np.float64)
    if (
        not 1 <= n <= MOST_VARIABLES
        or matrix.shape != (n, n)
        or {v.shape for v in vectors} != {(n,)}
    ):
        shapes = ", ".join(str(np.shape(part)) for part in (H, g, lower, upper, start))
        allowed = f"(n, n) and then (n,), n from 1 to {MOST_VARIABLES}"
        raise InputError.at("the box QP", "shape of its parts", shapes, allowed)
    return BoxQpAnswer(*_core.solve_box_qp(matrix, *vectors))
