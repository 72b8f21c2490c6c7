"""The box QP, judged by its optimality conditions as NumPy sees them, on many random problems."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from omnimorph import _core, textbook
from omnimorph.protocols import FloatArray

PROVEN = 1e-9  # largest KKT residual of a scaled problem


class Problem(NamedTuple):
    """Minimise ½ xᵀHx + gᵀx over lower ≤ x ≤ upper; H has a mean diagonal of 1."""

    H: FloatArray
    g: FloatArray
    lower: FloatArray
    upper: FloatArray


class Answer(NamedTuple):
    """What the core gives."""

    x: FloatArray
    active: FloatArray
    kkt_residual: float
    iterations: int


def solve(problem: Problem, start: FloatArray | None = None) -> Answer:
    """Solve in the core, from all variables free if no other start is given."""
    start = np.zeros(len(problem.g)) if start is None else start
    return Answer(*_core.solve_box_qp(*problem, start))


def kkt_residual(problem: Problem, x: FloatArray) -> float:
    """Largest entry of x − clip(x − (Hx + g)), which vanishes at the minimum alone."""
    H, g, lower, upper = problem
    return float(np.abs(x - np.clip(x - (H @ x + g), lower, upper)).max())


def random_hessian(generator: np.random.Generator, n: int, condition: float) -> FloatArray:
    """Symmetric positive definite, with eigenvalues spread evenly over their logarithm."""
    basis, _ = np.linalg.qr(generator.normal(size=(n, n)))
    eigenvalues = condition ** -np.linspace(0.0, 1.0, n)
    H = (basis * eigenvalues) @ basis.T
    H = 0.5 * (H + H.T)
    return np.asarray(H * (n / H.trace()))


def random_problem(
    generator: np.random.Generator, n: int, condition: float, at_bounds: int, degenerate: bool
) -> tuple[Problem, FloatArray]:
    """A problem with its solution: from the active bounds and their multipliers follows g.

    If it is degenerate, one of the multipliers is zero, or a free variable lies on its bound.
    """
    H = random_hessian(generator, n, condition)
    lower, upper = -generator.uniform(0.2, 1.0, n), generator.uniform(0.2, 1.0, n)
    order = generator.permutation(n)
    held, free = order[:at_bounds], order[at_bounds:]
    side = np.zeros(n)
    side[held] = generator.choice([-1.0, 1.0], at_bounds)
    middle, half = 0.5 * (upper + lower), 0.5 * (upper - lower)
    x = np.where(side == 0.0, middle + generator.uniform(-0.95, 0.95, n) * half, 0.0)
    x = np.where(side < 0.0, lower, np.where(side > 0.0, upper, x))
    multiplier = side * generator.uniform(0.01, 3.0, n)
    if degenerate and at_bounds > 0:
        multiplier[held[0]] = 0.0
    elif degenerate:
        x[free[0]] = upper[free[0]]
    return Problem(H, -(H @ x) - multiplier, lower, upper), x


@pytest.mark.parametrize("condition", [10.0, 1e3, 1e6])
def test_eight_rotors_with_none_to_all_bounds_active(condition: float) -> None:
    """12 000 problems in all, each with a known solution, from any start."""
    generator = np.random.default_rng(int(condition))
    seen: Counter[int] = Counter()
    for k in range(4000):
        at_bounds = k % 9
        problem, x = random_problem(generator, 8, condition, at_bounds, degenerate=k % 5 == 4)
        answer = solve(problem, generator.choice([-1.0, 0.0, 1.0], 8))
        assert answer.kkt_residual <= PROVEN
        assert kkt_residual(problem, answer.x) <= PROVEN
        # an error in x is that of the gradient, times the condition
        assert np.abs(answer.x - x).max() <= 1e-14 * condition + 1e-13
        seen[at_bounds] += 1
    assert set(seen) == set(range(9))


@pytest.mark.parametrize("n", range(1, 19))
def test_any_number_of_rotors(n: int) -> None:
    generator = np.random.default_rng(n)
    for k in range(150):
        condition = 10.0 ** generator.uniform(0.0, 6.0)
        problem, _ = random_problem(generator, n, condition, k % (n + 1), degenerate=k % 7 == 6)
        answer = solve(problem, generator.choice([-1.0, 0.0, 1.0], n))
        assert kkt_residual(problem, answer.x) <= PROVEN


@pytest.mark.parametrize("n", [8, 18])
def test_ill_conditioned_problems_with_a_far_target(n: int) -> None:
    """Most bounds are active at the minimum, and which ones is hard to guess."""
    generator = np.random.default_rng(100 + n)
    iterations = []
    for _ in range(1500):
        g = 10.0 ** generator.uniform(-2.0, 1.0) * generator.normal(size=n)
        H = random_hessian(generator, n, 1e6)
        problem = Problem(H, g, -np.ones(n), generator.uniform(0.2, 1.0, n))
        answer = solve(problem)
        assert kkt_residual(problem, answer.x) <= PROVEN
        iterations.append(answer.iterations)
    assert max(iterations) <= 20 * n


def test_a_start_changes_the_way_but_not_the_answer() -> None:
    generator = np.random.default_rng(7)
    for k in range(300):
        problem, _ = random_problem(generator, 8, 1e4, k % 9, degenerate=False)
        first = solve(problem)
        for start in (np.ones(8), -np.ones(8), generator.choice([-1.0, 0.0, 1.0], 8), first.active):
            again = solve(problem, start)
            np.testing.assert_array_equal(again.active, first.active)
            np.testing.assert_array_equal(again.x, first.x)
        assert again.iterations == 1  # the last start was the answer itself


def test_the_active_bounds_are_reported() -> None:
    problem = Problem(np.eye(3), np.array([-2.0, 0.5, 3.0]), -np.ones(3), np.ones(3))
    answer = solve(problem)
    np.testing.assert_array_equal(answer.x, [1.0, -0.5, -1.0])
    np.testing.assert_array_equal(answer.active, [1.0, 0.0, -1.0])
    assert answer.kkt_residual == 0.0


def test_no_variable_leaves_its_bounds_by_a_single_bit() -> None:
    generator = np.random.default_rng(8)
    for k in range(500):
        problem, _ = random_problem(generator, 8, 1e6, k % 9, degenerate=k % 2 == 0)
        answer = solve(problem)
        assert (problem.lower <= answer.x).all()
        assert (answer.x <= problem.upper).all()
        held = answer.active != 0.0
        bound = np.where(answer.active < 0.0, problem.lower, problem.upper)
        np.testing.assert_array_equal(answer.x[held], bound[held])


def test_equal_bounds_hold_a_variable() -> None:
    generator = np.random.default_rng(9)
    for _ in range(300):
        problem, _ = random_problem(generator, 8, 1e3, 3, degenerate=False)
        held = generator.random(8) < 0.5
        upper = np.where(held, problem.lower, problem.upper)
        problem = problem._replace(upper=upper)
        answer = solve(problem, generator.choice([-1.0, 0.0, 1.0], 8))
        np.testing.assert_array_equal(answer.x[held], problem.lower[held])
        assert kkt_residual(problem, answer.x) <= PROVEN


def test_rotors_that_can_only_push() -> None:
    """Bounds 0 ≤ x ≤ 1, and an unconstrained minimum that pulls with half of them."""
    generator = np.random.default_rng(10)
    for _ in range(300):
        H = random_hessian(generator, 8, 1e3)
        problem = Problem(H, generator.normal(size=8), np.zeros(8), np.ones(8))
        assert kkt_residual(problem, solve(problem).x) <= PROVEN


def test_agrees_with_the_textbook_and_with_scipy() -> None:
    generator = np.random.default_rng(11)
    for k in range(60):
        problem, _ = random_problem(generator, 8, 1e2, k % 9, degenerate=False)
        x = solve(problem).x
        reported, _ = textbook.solve_box_qp(*problem)
        np.testing.assert_allclose(x, reported, rtol=0.0, atol=1e-12)
        # ½ xᵀHx + gᵀx = ½ ‖Lᵀx + L⁻¹g‖² + constant, H = L Lᵀ
        L = np.linalg.cholesky(problem.H)
        bounds = (problem.lower, problem.upper)
        least = lsq_linear(L.T, -np.linalg.solve(L, problem.g), bounds, method="bvls", tol=1e-14)
        np.testing.assert_allclose(x, least.x, rtol=0.0, atol=1e-7)


def test_a_single_variable() -> None:
    for g, expected in ((-3.0, 1.0), (3.0, -1.0), (0.25, -0.25)):
        one = np.ones(1)
        answer = solve(Problem(np.eye(1), np.array([g]), -one, one))
        np.testing.assert_array_equal(answer.x, [expected])
