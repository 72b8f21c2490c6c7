"""The closed loop at rest: where OmniMorph can hover it does, and where it cannot it sags."""

from __future__ import annotations

from functools import cache

import numpy as np

from omnimorph.control.tracking import TrackingGains
from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray
from omnimorph.reference.rows import rotation_from_quaternion
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.run import Outcome, Run
from omnimorph.simulation.fly import fly
from omnimorph.simulation.plant import PlantModel
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import load_scenario
from omnimorph.verification.case import Result, case, largest
from omnimorph.verification.setting import PRECISE_RULE, omnimorph

_HELD = 1e-9  # m and rad


def hover_scenario(tilt: float, R_WB: FloatArray, duration: float = 4.0) -> Scenario:
    """Return a scenario that rests at one tilt in one attitude, in the perfect plant."""
    return Scenario(
        name="hover in an attitude",
        vehicle=omnimorph(),
        plant=PlantModel(),
        gains=TrackingGains(),
        allocator=PRECISE_RULE,
        reference=SegmentReference((0.0, 0.0, 1.2), R_WB, [Segment(duration)]),
        start_tilt=tilt,
    )


def can_hover(tilt: float, R_WB: FloatArray) -> bool:
    """Return whether thrusts within limits hold the weight without a moment: a linear programme."""
    from scipy.optimize import linprog

    vehicle = omnimorph()
    weight = R_WB.T @ np.array([0.0, 0.0, vehicle.mass * GRAVITY])
    limits = np.column_stack([vehicle.thrust_min, vehicle.thrust_max])
    needed = np.concatenate([weight, np.zeros(3)])
    answer = linprog(np.zeros(8), A_eq=allocation_matrix(vehicle, tilt), b_eq=needed, bounds=limits)
    return bool(answer.status == 0)


def attitudes(number: int, seed: int) -> list[FloatArray]:
    """Return attitudes spread evenly over all rotations."""
    quaternions = np.random.default_rng(seed).normal(size=(number, 4))
    return [rotation_from_quaternion(q / np.linalg.norm(q)) for q in quaternions]


def _miss(run: Run) -> float:
    """Return how far a flight is from its reference at the end: the larger of m and rad."""
    if run.outcome is not Outcome.COMPLETED:
        return np.inf
    p = largest(run.p_WB[-1] - run.desired_p_WB[-1])
    return max(p, largest(run.R_WB[-1] - run.desired_R_WB[-1]))


@case("equilibrium: 8 f cos α = m g")
def hover_holds_at_every_tilt() -> Result:
    """Level hover holds at each of 25 fixed tilts from 0 to 60°: the pose after 4 s is right."""
    tilts = np.radians(np.linspace(0.0, 60.0, 25))
    missed = [_miss(fly(hover_scenario(float(tilt), np.eye(3)))) for tilt in tilts]
    return Result(value=max(missed), tolerance=_HELD, unit="m, rad")


@case("the zero-moment force set holds every direction at these tilts, by linear programming")
def hover_holds_in_every_attitude() -> Result:
    """At 45° and 54.74° of tilt hover holds in each of 20 attitudes spread over all rotations."""
    missed = []
    for tilt in (np.pi / 4, float(np.arctan(np.sqrt(2.0)))):
        for R_WB in attitudes(20, seed=4):
            held = _miss(fly(hover_scenario(tilt, R_WB)))
            missed.append(held if can_hover(tilt, R_WB) else np.inf)
    return Result(value=max(missed), tolerance=_HELD, unit="m, rad")


@cache
def _at_thirty_degrees() -> tuple[list[Run], list[Run]]:
    """Fly 40 attitudes at 30° of tilt: those inside the zero-moment force set, those outside."""
    inside: list[Run] = []
    outside: list[Run] = []
    for R_WB in attitudes(40, seed=9):
        run = fly(hover_scenario(np.pi / 6, R_WB, duration=3.0))
        (inside if can_hover(np.pi / 6, R_WB) else outside).append(run)
    return inside, outside


@case("membership in the zero-moment force set, by linear programming")
def hover_holds_inside_the_force_set() -> Result:
    """At 30° of tilt hover holds in those of 40 attitudes that the force set holds."""
    inside, outside = _at_thirty_degrees()
    missed = [_miss(run) for run in inside] if inside and outside else [np.inf]
    return Result(value=max(missed), tolerance=1e-6, unit="m, rad")


@case("membership in the zero-moment force set, by linear programming")
def hover_fails_outside_the_force_set() -> Result:
    """In the others it fails: the vehicle is lost or hangs at least a centimetre from its place."""
    _, outside = _at_thirty_degrees()
    held = sum(_miss(run) < 0.01 for run in outside) if outside else 1
    return Result(value=held, tolerance=0.0, unit="flights")


@case("closed form: with free moments the sideways force at 20° is below the weight")
def knife_edge_sags_at_a_small_tilt() -> Result:
    """Rolled by 90° at 20° of tilt the vehicle cannot carry its weight: it sinks, and is lost."""
    roll = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    run = fly(hover_scenario(np.radians(20.0), roll))
    sank = run.outcome is Outcome.LOST and run.p_WB[-1, 2] < run.desired_p_WB[-1, 2] - 0.5
    return Result(value=float(sank), expected=1.0, tolerance=0.0)


@case("determinism: the same arithmetic on the same numbers")
def flights_repeat_to_the_last_bit() -> Result:
    """A noisy flight flown again, alone or after others, is the same: its content hash repeats."""
    scenario = load_scenario("hover")
    first = fly(scenario, seed=3, flight=7).content_hash
    others = {
        fly(scenario, seed=seed, flight=k).content_hash for seed, k in ((3, 8), (4, 7), (7, 3))
    }
    again = fly(scenario, seed=3, flight=7, progress=lambda time, duration: None).content_hash
    same = first == again and first not in others and len(others) == 3
    return Result(value=float(same), expected=1.0, tolerance=0.0)
