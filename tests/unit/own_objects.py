"""Minimal objects of each protocol, as one writes them who has read the protocols alone."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np

import omnimorph as om
from omnimorph.protocols import FloatArray
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.run import COLUMNS

MOVE = SegmentReference((0.0, 0.0, 1.0), np.eye(3), [Segment(0.2, (0.02, -0.02, 0.01))])
SHORT = replace(om.load_scenario("paper-case-a"), reference=MOVE)
"""0.2 s in the realistic plant, at 250 Hz control and 1 kHz physics."""


class Wall:
    """A plant that only forwards to another: `om.fly` sees nothing but its protocol."""

    def __init__(self, vehicle: om.Vehicle, plant: om.PlantModel) -> None:
        self._behind = om.SimulatedPlant(vehicle, plant)

    @property
    def physics_step(self) -> float:
        return self._behind.physics_step

    @property
    def control_period(self) -> float:
        return self._behind.control_period

    @property
    def motion(self) -> om.State:
        return self._behind.motion

    @property
    def speed(self) -> FloatArray:
        return self._behind.speed

    @property
    def tilt(self) -> FloatArray:
        return self._behind.tilt

    @property
    def wrench(self) -> FloatArray:
        return self._behind.wrench

    def reset(self, state: om.State, tilt: FloatArray, thrust: FloatArray, seed: int) -> None:
        self._behind.reset(state, tilt, thrust, seed)

    def send(self, command: om.Command) -> None:
        self._behind.send(command)

    def step_physics(self, steps: int, push: FloatArray) -> None:
        self._behind.step_physics(steps, push)


def wall(scenario: om.Scenario = SHORT) -> Wall:
    """Return a wall before the plant of a scenario."""
    return Wall(scenario.vehicle, scenario.plant)


class Counting:
    """A controller that remembers: it passes on to the paper's, and counts its calls."""

    def __init__(self, scenario: om.Scenario, gain: float = 1.0) -> None:
        self.paper = scenario.build_controller()
        self.calls, self.gain = 0, gain

    def __call__(self, time: float, state: om.State, desired: om.Desired) -> om.Command:
        self.calls += 1
        thrust, tilt = self.paper(time, state, desired)
        lift = (self.gain * thrust.sum(), "N")
        return om.Command(thrust, tilt, np.arange(6.0), {"calls": self.calls, "lift": lift})


class Lagging:
    """An estimator that remembers: it follows what is measured half of the way in each step."""

    def __init__(self, scenario: om.Scenario) -> None:
        self.p = scenario.reference(0.0).p_WB

    def __call__(self, time: float, measured: om.State, previous: om.Command) -> om.Estimate:
        self.p = 0.5 * (self.p + measured.p_WB)
        log = {"lag": (measured.p_WB - self.p, "m"), "previous": previous.thrust}
        return om.Estimate(self.p, *measured[1:], log=log)


def differing(one: om.Run, other: om.Run) -> list[str]:
    """Return the names of the columns that are not the same to the last bit."""
    names = ["time", *(column.name for column in COLUMNS)]
    mine, theirs = ({name: run[name] for name in (*names, *run.logged)} for run in (one, other))
    return [
        name
        for name in mine.keys() | theirs.keys()
        if name not in mine
        or name not in theirs
        or not np.array_equal(mine[name], theirs[name], equal_nan=True)
    ]


def in_another_process(code: str, data: bytes) -> bytes:
    """Run code in a process of its own; `data` is its input, what it writes out the answer."""
    command: list[Any] = [sys.executable, "-c", code]
    return subprocess.run(command, input=data, stdout=subprocess.PIPE, check=True).stdout
