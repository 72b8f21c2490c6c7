"""Flights against the clock: the core, the textbook, and parts of the loop written in Python."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from omnimorph import textbook
from omnimorph.control.allocators import JointTilt
from omnimorph.design.files import load_vehicle
from omnimorph.model.core import state_row
from omnimorph.model.dynamics import hover_thrust
from omnimorph.protocols import Command, Desired, FloatArray, State
from omnimorph.reference.segments import SegmentReference
from omnimorph.results.run import Run
from omnimorph.simulation.fly import fly
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import load_plant, load_scenario

TEXTBOOK_DURATION = 0.25  # s of Case A: enough steps for a rate, few enough to take turns
CONTROL_STEPS = 4000


class LoopTimes(NamedTuple):
    """One round of the closed loops, in physics steps a second where nothing else is said."""

    core_case_a: float
    core_case_b: float
    whole_call_case_a: float
    textbook: float
    realistic: float  # s for the 45 s flight
    difference: float  # m, largest between core and textbook over the textbook's steps


def time_loops() -> LoopTimes:
    """Fly both cases in the core and the beginning of Case A in the textbook, once each."""
    case_a, case_b = (load_scenario(f"paper-case-{case}") for case in "ab")
    began = time.perf_counter()
    run = fly(case_a, plant="perfect")
    whole = time.perf_counter() - began
    other = fly(case_b, plant="perfect")
    began = time.perf_counter()
    reference = textbook.fly(
        load_vehicle("omnimorph"),
        textbook.paper_reference(),
        textbook.PAPER_GAINS,
        textbook.CASE_A,
        textbook.PERFECT,
        TEXTBOOK_DURATION,
    )
    textbook_time = time.perf_counter() - began
    realistic = fly(case_a)
    steps = len(reference.time) - 1
    return LoopTimes(
        core_case_a=_steps_per_second(run),
        core_case_b=_steps_per_second(other),
        whole_call_case_a=(len(run.time) - 1) / whole,
        textbook=steps / textbook_time,
        realistic=realistic.performance.wall_time,
        difference=float(np.abs(run.p_WB[: steps + 1] - reference.p_WB).max()),
    )


def _steps_per_second(run: Run) -> float:
    return (len(run.time) - 1) / run.performance.wall_time


class ControlTimes(NamedTuple):
    """What one control step takes when it is called from Python, in s."""

    median: float
    almost_all: float  # 99 of 100 steps take less
    in_core: float  # mean, without Python in between


def time_control_steps() -> ControlTimes:
    """Step the controller through the states of a noisy flight, thrusts and tilt read each time."""
    scenario = load_scenario("paper-case-a")
    rows = _states_and_wishes(scenario, fly(scenario))
    spent = _seconds_a_step(scenario, rows)
    states, desired = (np.array(column) for column in zip(*rows, strict=True))
    controller = scenario.build_controller()
    began = time.perf_counter()
    controller.replay(states, desired)
    in_core = (time.perf_counter() - began) / len(rows)
    median, almost_all = np.percentile(spent, [50.0, 99.0]).tolist()
    return ControlTimes(median, almost_all, in_core)


JOINTLY = ("omnimorph", "voliro", "omav-12")
"""The vehicles whose thrusts and tilts are allocated jointly against the clock."""


def time_joint_steps() -> tuple[float, ...]:
    """Step joint allocation through noisy tours of `JOINTLY`; the median step of each, in s."""
    return tuple(
        float(np.median(_seconds_a_step(scenario, rows))) for scenario, rows in _joint_tours()
    )


@cache
def _joint_tours() -> list[tuple[Scenario, list[tuple[FloatArray, FloatArray]]]]:
    tours = []
    for name in JOINTLY:
        proposed = load_scenario("tour").for_vehicle(load_vehicle(name))
        rule = proposed.allocator
        if not isinstance(rule, JointTilt):
            rule = JointTilt(
                W1=rule.W1, W2_position=rule.W2_position, W2_attitude=rule.W2_attitude, W3=rule.W3
            )
        scenario = replace(proposed, allocator=rule, proposed=False)
        tours.append((scenario, _states_and_wishes(scenario, fly(scenario))))
    return tours


def _seconds_a_step(scenario: Scenario, rows: list[tuple[FloatArray, FloatArray]]) -> FloatArray:
    controller = scenario.build_controller()
    clock, spent = time.perf_counter_ns, []
    for state, desired in rows:
        began = clock()
        allocation = controller.step(state, desired)
        _, _ = allocation.thrust, allocation.tilt
        spent.append(clock() - began)
    return 1e-9 * np.array(spent)


def _states_and_wishes(scenario: Scenario, run: Run) -> list[tuple[FloatArray, FloatArray]]:
    """Return the (18,) states and (24,) desired motions of some control steps of a run."""
    reference = scenario.reference
    assert isinstance(reference, SegmentReference)
    wishes = reference.sample(run.time)
    step = max((len(run.time) - 1) // CONTROL_STEPS, 1)
    return [
        (state_row(run.p_WB[k], run.R_WB[k], run.v_WB[k], run.w_WB_B[k]), wishes[k].copy())
        for k in range(0, step * CONTROL_STEPS, step)
    ]


def time_python_loop() -> float:
    """Fly with a controller in Python that always answers the same; control steps a second."""
    scenario = replace(load_scenario("hover"), plant=load_plant("perfect"))
    vehicle, tilt = scenario.vehicle, scenario.tilt
    hover = Command(hover_thrust(vehicle, tilt), tilt)

    def answer(time: float, state: State, desired: Desired) -> Command:
        return hover

    return _steps_per_second(fly(scenario, controller=answer))
