"""Find the axes of seven uni-directional rotors that can push and turn in every direction.

A wrench map A of rank 6 with ``A b = 0`` for a strictly positive b makes every wrench with positive
thrusts: to any solution, as much of b can be added as is needed. With seven rotors that is the
least number (M. Tognon, A. Franchi, "Omnidirectional aerial vehicles with unidirectional
thrusters", IEEE RA-L 3, 2018). With all components of b equal the rotors share the internal thrust;
among such axes the ones with the least condition number of A are taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.protocols import FloatArray

_STARTS = 8
_EXACT = 1e-10


@dataclass(frozen=True, kw_only=True, eq=False)
class SevenRotors:
    """The proof that axes serve.

    Attributes
    ----------
    axes : (7, 3) array
        Unit vectors of thrust, in B.
    rank : int
        Of A with torques over the length of the arms.
    condition_number : float
        Of the same.
    imbalance : float
        Norm of ``A b`` for b of ones, relative to that of A: 0 if the thrusts cancel.
    """

    axes: FloatArray
    rank: int
    condition_number: float
    imbalance: float

    @property
    def holds(self) -> bool:
        """Whether every wrench can be made with positive thrusts."""
        return self.rank == 6 and self.imbalance < _EXACT


def sphere_hubs(radius: float) -> FloatArray:
    """Return hubs at the poles of a sphere and on its equator, 72° apart: (7, 3) array, m."""
    angle = np.radians(72.0 * np.arange(5))
    around = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(5)])
    return radius * np.vstack([[0.0, 0.0, 1.0], around, [0.0, 0.0, -1.0]])


def certificate(axes: ArrayLike, hubs: FloatArray, spins: FloatArray, kappa: float) -> SevenRotors:
    """Return rank, condition number and imbalance of axes.

    Parameters
    ----------
    axes : (7, 3) array
        Unit vectors.
    hubs : (7, 3) array, m
    spins : (7,) array
        +1 counter-clockwise, −1 clockwise.
    kappa : float, m
        Drag torque per thrust.
    """
    z = np.asarray(axes, dtype=np.float64)
    A = _whitened(z, hubs, spins, kappa)
    values = np.linalg.svd(A, compute_uv=False)
    return SevenRotors(
        axes=z,
        rank=int((values > 1e-9 * values[0]).sum()),
        condition_number=float(values[0] / values[5]),
        imbalance=float(np.linalg.norm(A.sum(axis=1)) / values[0]),
    )


def find_axes(hubs: FloatArray, spins: FloatArray, kappa: float, seed: int = 0) -> SevenRotors:
    """Return the best axes found from a number of random starts; the same for the same seed.

    Minimises the condition number over unit axes subject to ``A b = 0`` with equal b, by
    sequential quadratic programming.
    """
    from scipy.optimize import minimize

    generator = np.random.default_rng(seed)

    def axes_of(x: FloatArray) -> FloatArray:
        z = x.reshape(7, 3)
        return np.asarray(z / np.linalg.norm(z, axis=1, keepdims=True))

    def spread(x: FloatArray) -> float:
        values = np.linalg.svd(_whitened(axes_of(x), hubs, spins, kappa), compute_uv=False)
        return math.log(values[0] / max(values[5], 1e-12))

    def balance(x: FloatArray) -> FloatArray:
        return np.asarray(_whitened(axes_of(x), hubs, spins, kappa).sum(axis=1))

    best: SevenRotors | None = None
    for _ in range(_STARTS):
        found = minimize(
            spread,
            generator.standard_normal(21),
            method="SLSQP",
            constraints=[{"type": "eq", "fun": balance}],
            options={"maxiter": 400, "ftol": 1e-12},
        )
        one = certificate(_polished(axes_of(found.x), hubs, spins, kappa), hubs, spins, kappa)
        if one.holds and (best is None or one.condition_number < best.condition_number):
            best = one
    assert best is not None, "one of the starts succeeds for hubs in general position"
    return best


def _whitened(z: FloatArray, hubs: FloatArray, spins: FloatArray, kappa: float) -> FloatArray:
    """Return A with torques over the mean arm: (6, 7) array."""
    torque = np.cross(hubs, z) - kappa * spins[:, None] * z
    return np.vstack([z.T, torque.T / np.linalg.norm(hubs, axis=1).mean()])


def _polished(z: FloatArray, hubs: FloatArray, spins: FloatArray, kappa: float) -> FloatArray:
    """Return the nearest axes that cancel to rounding, by Newton's method of least change."""
    for _ in range(20):
        miss = _whitened(z, hubs, spins, kappa).sum(axis=1)
        slope = np.zeros((6, 21))
        for i in range(7):
            P = np.eye(3) - np.outer(z[i], z[i])
            for c in range(3):
                one = np.zeros((7, 3))
                one[i] = P[:, c]
                slope[:, 3 * i + c] = _whitened(one, hubs, spins, kappa).sum(axis=1)
        z = z - (np.linalg.pinv(slope) @ miss).reshape(7, 3)
        z = z / np.linalg.norm(z, axis=1, keepdims=True)
    return z
