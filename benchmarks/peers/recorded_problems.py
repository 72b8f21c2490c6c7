"""The allocation problems of real control steps, as box QPs and in the paper's 14 variables."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from omnimorph import textbook
from omnimorph.bench.batches import fly_all
from omnimorph.control.allocators import ThreeCandidates
from omnimorph.protocols import FloatArray, State
from omnimorph.reference.rows import desired_from_row
from omnimorph.reference.segments import SegmentReference
from omnimorph.results.run import Run
from omnimorph.simulation.fly import fly
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import load_scenario
from omnimorph.simulation.variation import Uniform

__all__ = ["PaperForm", "Problem", "recorded_problems"]

RECOVERIES = 20


class PaperForm(NamedTuple):
    """The paper's problem as it stands: u in Hz² and q̈, with the dynamics as equations.

    min ½ yᵀHy + gᵀy over y = (u, q̈), rows · y = right, u within its bounds and q̈ free.
    """

    H: FloatArray  # (n + 6, n + 6)
    g: FloatArray  # (n + 6,)
    rows: FloatArray  # (6, n + 6)
    right: FloatArray  # (6,)
    lower: FloatArray  # (n,) Hz²
    upper: FloatArray  # (n,) Hz²
    to_shares: FloatArray  # (n,) u times this is the share of the largest thrust


class Problem(NamedTuple):
    """One control step's problem at the tilt before: min ½ xᵀHx + gᵀx, lower ≤ x ≤ upper.

    x are shares of the largest thrusts; H has a mean of 1 on its diagonal.
    """

    H: FloatArray
    g: FloatArray
    lower: FloatArray
    upper: FloatArray
    paper: PaperForm


def recorded_problems(count: int = 2000) -> list[Problem]:
    """Return problems that control steps posed, half of them where limits are often reached.

    A quarter each are evenly spaced over Cases A and B, flown with noise; the others are of the
    first half second in which OmniMorph comes back to hovering from up to half a metre and thirty
    degrees away.
    """
    problems: list[Problem] = []
    for name in ("paper-case-a", "paper-case-b"):
        scenario = load_scenario(name)
        problems += _of_run(scenario, fly(scenario), count // 4, 1.0)
    scenario = load_scenario("hover")
    away = {"start_position": Uniform(-0.3, 0.3), "start_attitude": Uniform(-0.3, 0.3)}
    flights = fly_all(scenario, RECOVERIES, vary=away, keep="all")
    for run in flights.runs.values():
        problems += _of_run(scenario, run, count // 2 // RECOVERIES, 0.1)
    return problems


def _of_run(scenario: Scenario, run: Run, count: int, share: float) -> list[Problem]:
    """Return the problems of some control steps in the first share of a run."""
    reference = scenario.reference
    assert isinstance(reference, SegmentReference)
    wishes = reference.sample(run.time)
    every = round(scenario.plant.control_period / scenario.plant.physics_step)
    last = share * (len(run.time) - 1)
    problems = []
    for k in (np.linspace(every, last, count).astype(int) // every * every).tolist():
        motion = State(run.p_WB[k], run.R_WB[k], run.v_WB[k], run.w_WB_B[k])
        before, tilt = run.thrust_command[k - every], run.tilt_command[k - every]
        problems.append(_at(scenario, motion, wishes[k], before, tilt))
    return problems


def _at(
    scenario: Scenario,
    motion: State,
    wish: FloatArray,
    previous: FloatArray,
    tilt: FloatArray,
) -> Problem:
    vehicle, rule = scenario.vehicle, scenario.allocator
    assert isinstance(rule, ThreeCandidates)
    acceleration = textbook.reference_acceleration(
        motion, desired_from_row(wish), textbook.PAPER_GAINS
    )
    demand = textbook.build_demand(vehicle, motion, acceleration)
    gain = demand.gain @ textbook.allocation_matrix(vehicle, tilt)  # (6, n): q̈ = … + gain f
    W1, W3 = (rule.per_thrust(vehicle, name) for name in ("W1", "W3"))  # 1/N²
    W2 = np.array([*rule.W2_position, *rule.W2_attitude])
    c = vehicle.thrust_coefficient * (2.0 * math.pi) ** 2  # N/Hz²
    scale = np.maximum(np.abs(vehicle.thrust_min), np.abs(vehicle.thrust_max))
    E = gain * scale
    H = (E.T * W2) @ E + np.diag((W1 + W3) * scale**2)
    g = -(E.T @ (W2 * demand.missing) + W3 * scale * previous)
    size = np.trace(H) / len(g)
    # y = (u, q̈): the cost without its constant, and q̈ − gain c u = q̈_r − missing
    paper = PaperForm(
        H=np.diag([*((W1 + W3) * c**2), *W2]),
        g=np.concatenate([-W3 * c * previous, -W2 * acceleration]),
        rows=np.hstack([-gain * c, np.eye(6)]),
        right=acceleration - demand.missing,
        lower=vehicle.thrust_min / c,
        upper=vehicle.thrust_max / c,
        to_shares=c / scale,
    )
    return Problem(
        H / size, g / size, vehicle.thrust_min / scale, vehicle.thrust_max / scale, paper
    )
