"""Solvers of small quadratic programs on the same recorded problems: time beside accuracy."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from benchmarks.peers.missing import imported
from benchmarks.peers.recorded_problems import Problem
from omnimorph.control.box_qp import solve_box_qp
from omnimorph.protocols import FloatArray

__all__ = ["SOLVERS", "Answers", "Solve", "exact_answers", "solve_all"]

WRONG_BEYOND = 1e-3  # of the largest thrust

Solve = Callable[[Problem], tuple[FloatArray, bool]]
"""Answers a problem with shares of the largest thrusts, and whether it claims to have solved it."""


class Answers(NamedTuple):
    """What one solver made of all problems."""

    seconds: FloatArray  # of each problem
    errors: FloatArray  # largest error of a thrust, as a share of the largest
    claimed: FloatArray  # whether it said that it had solved it

    @property
    def wrong(self) -> int:
        """How many answers it called solved that are not."""
        return int(np.sum(self.claimed * (self.errors > WRONG_BEYOND)))


def exact_answers(problems: list[Problem]) -> list[FloatArray]:
    """Return the exact answers, each proved by its KKT residual.

    Raises
    ------
    RuntimeError
        If one is not proved to 1e-12.
    """
    answers = []
    for problem in problems:
        x, _, residual, _ = solve_box_qp(problem.H, problem.g, problem.lower, problem.upper)
        if not residual < 1e-12:
            raise RuntimeError(f"A recorded problem has no exact answer: residual {residual}.")
        answers.append(x)
    return answers


def solve_all(solve: Solve, problems: list[Problem], exact: list[FloatArray]) -> Answers:
    """Solve every problem with one solver, each by itself against the clock."""
    clock = time.perf_counter_ns
    seconds, errors, claimed = np.empty((3, len(problems)))
    for k, problem in enumerate(problems):
        began = clock()
        x, solved = solve(problem)
        seconds[k] = 1e-9 * (clock() - began)
        errors[k] = np.abs(x - exact[k]).max() if np.isfinite(x).all() else np.inf
        claimed[k] = solved
    return Answers(seconds, errors, claimed)


def _ours() -> Solve:
    def solve(problem: Problem) -> tuple[FloatArray, bool]:
        x, _, residual, _ = solve_box_qp(problem.H, problem.g, problem.lower, problem.upper)
        return x, residual < 1e-9

    return solve


def _daqp() -> Solve:
    daqp = imported("daqp")
    nothing = np.zeros((0, 8))

    def solve(problem: Problem) -> tuple[FloatArray, bool]:
        x, _, flag, _ = daqp.solve(problem.H, problem.g, nothing, problem.upper, problem.lower)
        return x, flag > 0

    return solve


def _osqp() -> Solve:
    osqp = imported("osqp")
    from scipy import sparse

    def solve(problem: Problem) -> tuple[FloatArray, bool]:
        solver = osqp.OSQP()
        solver.setup(
            sparse.csc_matrix(np.triu(problem.H)),
            problem.g,
            sparse.eye(len(problem.g), format="csc"),
            problem.lower,
            problem.upper,
            verbose=False,
        )
        answer = solver.solve()
        return np.asarray(answer.x), answer.info.status == "solved"

    return solve


def _proxqp() -> Solve:
    proxsuite = imported("proxsuite")
    dense = proxsuite.proxqp.dense

    def solve(problem: Problem) -> tuple[FloatArray, bool]:
        qp = dense.QP(len(problem.g), 0, 0, True)
        qp.init(problem.H, problem.g, l_box=problem.lower, u_box=problem.upper)
        qp.solve()
        solved = qp.results.info.status == proxsuite.proxqp.PROXQP_SOLVED
        return np.asarray(qp.results.x), bool(solved)

    return solve


def _qpoases() -> Solve:
    """Return qpOASES with its options for predictive control, on the paper's own variables."""
    casadi = imported("casadi")
    variables, equations = 14, 6
    shape = {
        "h": casadi.Sparsity.dense(variables, variables),
        "a": casadi.Sparsity.dense(equations, variables),
    }
    options = {"error_on_fail": False, "printLevel": "none", "sparse": False} | _MPC
    solver = casadi.conic("paper", "qpoases", shape, options)

    def solve(problem: Problem) -> tuple[FloatArray, bool]:
        paper = problem.paper
        free = np.full(equations, np.inf)
        answer = solver(
            h=paper.H,
            g=paper.g,
            a=paper.rows,
            lba=paper.right,
            uba=paper.right,
            lbx=np.concatenate([paper.lower, -free]),
            ubx=np.concatenate([paper.upper, free]),
        )
        u = np.asarray(answer["x"]).reshape(-1)[: len(paper.lower)]
        return u * paper.to_shares, bool(solver.stats()["success"])

    return solve


# What qpOASES::Options::setToMPC sets (its manual, section on options).
_MPC: dict[str, Any] = {
    "enableRamping": False,
    "enableFarBounds": True,
    "enableFlippingBounds": False,
    "enableRegularisation": True,
    "enableNZCTests": False,
    "enableDriftCorrection": 0,
    "enableEqualities": True,
    "terminationTolerance": 1.0e7 * np.finfo(float).eps,
    "initialStatusBounds": "inactive",
    "numRegularisationSteps": 1,
    "numRefinementSteps": 0,
}

SOLVERS: dict[str, tuple[str, Callable[[], Solve]]] = {
    "omnimorph": ("omnimorph, called from Python as all of them", _ours),
    "daqp": ("DAQP", _daqp),
    "osqp": ("OSQP, its own tolerances", _osqp),
    "proxsuite": ("ProxQP, its own tolerances", _proxqp),
    "casadi": ("qpOASES in the paper's 14 variables, options for predictive control", _qpoases),
}
"""By the package that brings it: what it is called, and what makes it."""
