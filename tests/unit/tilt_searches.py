"""What the tests of searched tilts share: random control steps, and their answers by DAQP."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

import omnimorph as om
from omnimorph import textbook
from omnimorph.control.allocators import AllocationRule
from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import FloatArray
from omnimorph.results.run import Run
from omnimorph.simulation.scenario import Scenario
from omnimorph.units import to_SI

CASE_A: dict[str, Any] = {
    "W1": to_SI(1e-8, "per_Hz4"),
    "W2_position": (3e6, 3e6, 3e6),
    "W2_attitude": (1e3, 1e3, 1e3),
    "W3": to_SI(1e-5, "per_Hz4"),
}
CASE_B = CASE_A | {
    "W1": to_SI(1e-5, "per_Hz4"),
    "W2_position": (3e4, 3e4, 3e4),
    "W2_attitude": (10.0, 10.0, 10.0),
}
WEIGHTS = {"a": CASE_A, "b": CASE_B}
TOLD = {"a": textbook.CASE_A, "b": textbook.CASE_B}


class ControlStep(NamedTuple):
    """A control step: where the vehicle is, what is asked of it, and the command before."""

    state: om.State
    acceleration: FloatArray  # (6,) m/s², rad/s²
    thrust: FloatArray  # (n,) N
    tilt: float  # rad

    @property
    def row(self) -> FloatArray:
        """The state as one row of 18 numbers."""
        return np.concatenate([part.ravel() for part in self.state])


def random_step(generator: np.random.Generator, vehicle: Vehicle) -> ControlStep:
    """Return a step in any attitude, from any thrusts and any tilt within the limits."""
    state = om.State(
        generator.normal(size=3),
        np.asarray(Rotation.random(random_state=generator).as_matrix()),
        generator.normal(size=3),
        generator.normal(size=3),
    )
    acceleration = generator.normal(size=6) * np.repeat([2.0, 5.0], 3)
    thrust = generator.uniform(0.5 * vehicle.thrust_min, 0.5 * vehicle.thrust_max)
    tilt = generator.uniform(vehicle.servo_angle_min[0], vehicle.servo_angle_max[0])
    return ControlStep(state, acceleration, thrust, tilt)


def answer_of_rule(vehicle: Vehicle, rule: AllocationRule, period: float, step: ControlStep) -> Any:
    """Return the allocation of a rule for one control step."""
    gains = om.TrackingGains()
    controller = om.PoseController(vehicle, gains, rule, period, step.tilt, step.thrust)
    return controller.allocate(step.acceleration, step.state)


def flown_by_textbook(
    vehicle: Vehicle, case: str, step: ControlStep, tilt: float
) -> textbook.Allocation:
    """Return the best thrusts at one tilt as NumPy and DAQP find them."""
    demand = textbook.build_demand(vehicle, step.state, step.acceleration)
    return textbook.allocate(vehicle, np.array([tilt]), demand, step.thrust, TOLD[case])


def costs_shown(vehicle: Vehicle, case: str, step: ControlStep, tilts: ArrayLike) -> FloatArray:
    """Return the costs of the best thrusts at many tilts as NumPy and DAQP find them."""
    angles = np.asarray(tilts).tolist()
    return np.array([flown_by_textbook(vehicle, case, step, tilt).cost for tilt in angles])


def window_of(vehicle: Vehicle, tilt: float, epsilon: float, count: int) -> FloatArray:
    """Return the tilts of a window, the middle one first."""
    around = tilt + epsilon * np.linspace(-1.0, 1.0, count)
    tilts = np.concatenate([[tilt], np.delete(around, count // 2)])
    return tilts.clip(vehicle.servo_angle_min[0], vehicle.servo_angle_max[0])


def range_of(vehicle: Vehicle, tilt: float, count: int) -> FloatArray:
    """Return a tilt, then those evenly spaced over the servo's range."""
    low, high = float(vehicle.servo_angle_min[0]), float(vehicle.servo_angle_max[0])
    return np.concatenate([[tilt], np.linspace(low, high, count)])


def steps_of(run: Run, scenario: Scenario, every: int) -> list[ControlStep]:
    """Return control steps of a flight: its states, what they ask for, the command before."""
    held = round(run.provenance.control_period / run.provenance.physics_step)
    steps = []
    for k in range(held, len(run.time) - 1, every * held):
        state = om.State(run.p_WB[k], run.R_WB[k], run.v_WB[k], run.w_WB_B[k])
        desired = scenario.reference(float(run.time[k]))
        wanted = textbook.reference_acceleration(state, desired, textbook.PAPER_GAINS)
        before = float(run.tilt_command[k - 1, 0])
        steps.append(ControlStep(state, wanted, run.thrust_command[k - 1], before))
    return steps


EPSILON = math.radians(100.0) * 0.004
"""How far OmniMorph's tilt may move in a control step of 4 ms, rad."""
