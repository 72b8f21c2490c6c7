"""Random and symmetric vehicles for tests of wrench sets; linear programs over their thrusts."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from scipy.optimize import linprog
from tests.physics.small_vehicles import build_vehicle, random_vehicle

from omnimorph.design import Vehicle
from omnimorph.model.allocation import allocation_matrix
from omnimorph.protocols import FloatArray

STEP = np.radians(15.0)
LARGEST_SPEED = 600.0

# Least over largest speed: both ways, asymmetric, one way, and one way with a least thrust.
least_speeds = st.sampled_from([-1.0, -0.5, 0.0, 0.3])


@st.composite
def general_vehicles(draw: st.DrawFn, most: int = 9) -> Vehicle:
    """Draw a vehicle without any symmetry."""
    generator = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    vehicle = random_vehicle(generator, draw(st.integers(1, most)))
    return vehicle.replace(speed_min=draw(least_speeds) * vehicle.speed_max)


@st.composite
def lattice_vehicles(draw: st.DrawFn, most: int = 8) -> Vehicle:
    """Draw hubs of a 3 × 3 × 3 lattice and axes in steps of 15°; many coincide or are parallel."""
    on_lattice = st.tuples(*[st.integers(-1, 1)] * 3)
    n = draw(st.integers(1, most))
    hubs = draw(st.lists(on_lattice, min_size=n, max_size=n))
    steps = st.tuples(st.integers(0, 12), st.integers(0, 23))
    polar, azimuth = STEP * np.array(draw(st.lists(steps, min_size=1, max_size=n))).T
    level = np.sin(polar)
    axis = np.column_stack([level * np.cos(azimuth), level * np.sin(azimuth), np.cos(polar)])
    return build_vehicle(
        0.1062 * np.array(hubs),
        np.resize(axis, (n, 3)),
        rotor_spin=np.resize([1.0, draw(st.sampled_from([-1.0, 1.0]))], n),
        speed_max=LARGEST_SPEED,
        speed_min=draw(least_speeds) * LARGEST_SPEED,
    )


any_vehicles = general_vehicles() | lattice_vehicles()


def thrust_within(vehicle: Vehicle, generator: np.random.Generator) -> FloatArray:
    """Return random thrusts within the limits."""
    return generator.uniform(vehicle.thrust_min, vehicle.thrust_max)


class Programs:
    """Linear programs over the thrusts that make what is held.

    In units of the largest thrust, with each group of three rows of A of about unit size, and as
    exact as the solver can be. `size` is a length that no point of the set exceeds.
    """

    def __init__(self, vehicle: Vehicle, tilt: float, held: slice | None, value: ArrayLike) -> None:
        A = allocation_matrix(vehicle, tilt)
        self.thrust = float(max(np.abs(vehicle.thrust_min).max(), vehicle.thrust_max.max()))
        limits = np.column_stack([vehicle.thrust_min, vehicle.thrust_max])
        self.limits = limits / self.thrust
        self.free = A[3:] if held == slice(0, 3) else A[:3]
        rows = np.empty((0, vehicle.n_rotors)) if held is None else A[held]
        self.size = self.thrust * float(np.linalg.norm(self.free, axis=0).sum())
        size = float(np.abs(rows).max(initial=0.0)) or 1.0
        self.equal, self.value = rows / size, np.asarray(value) / (size * self.thrust)

    def support(self, direction: FloatArray) -> float:
        """Return how far the free part of the wrench extends along a direction; −inf if nowhere."""
        cost = direction @ self.free
        size = float(np.abs(cost).max()) or 1.0
        found = self._solve(-cost / size, self.equal, self.value)
        return size * self.thrust * -float(found.fun) if found.status == 0 else -np.inf

    def reach(self, direction: FloatArray) -> float:
        """Return the largest t ≥ 0 for which t times a direction can be made; 0 if there is none.

        Rows of t: free f = t direction.
        """
        size = float(np.abs(self.free).max())
        along = np.concatenate([-direction / size, np.zeros(len(self.equal))])
        rows = np.column_stack([np.vstack([self.free / size, self.equal]), along])
        value = np.concatenate([np.zeros(3), self.value])
        cost = np.append(np.zeros(len(self.limits)), -1.0)
        found = self._solve(cost, rows, value, np.vstack([self.limits, [0.0, np.inf]]))
        return self.thrust * -float(found.fun) if found.status == 0 else 0.0

    def least_slack(self, point: FloatArray) -> float:
        """Return the largest least distance to a limit, N, of any thrusts that make a point.

        The point is outside if it is negative.
        """
        n, size = len(self.limits), float(np.abs(self.free).max())
        rows = np.vstack([self.free / size, self.equal])
        value = np.concatenate([point / (size * self.thrust), self.value])
        one = np.ones((n, 1))
        found = self._solve(
            np.append(np.zeros(n), -1.0),
            np.column_stack([rows, np.zeros(len(rows))]),
            value,
            (None, None),
            A_ub=np.block([[np.eye(n), one], [-np.eye(n), one]]),
            b_ub=np.concatenate([self.limits[:, 1], -self.limits[:, 0]]),
        )
        assert found.status == 0, found.message
        return self.thrust * float(found.x[n])

    def _solve(
        self,
        cost: FloatArray,
        rows: FloatArray,
        value: FloatArray,
        bounds: Any = None,
        **upper: FloatArray,
    ) -> Any:
        finest = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
        return linprog(
            cost,
            A_eq=rows,
            b_eq=value,
            bounds=self.limits if bounds is None else bounds,
            options=finest,
            **upper,
        )
