"""Flights with less thrust than the controller believes in, and two questions asked of each.

The true thrust is a share of the nominal one for the same speed and drag. A flight need not be lost
because it cannot hold its pose: where position weighs more than attitude, the attitude is what is
given up. So two questions are asked: was it lost, and did it keep the pose?
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from omnimorph.design.files import load_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.simulation.effects import Effectiveness
from omnimorph.simulation.scenario import Scenario
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction.flights import with_effects

KINDS = ("all rotors", "lower rotors")
NOT_LOST, POSE_KEPT = "not lost", "pose kept"
KEPT_WITHIN_M, KEPT_WITHIN_DEG = 0.1, 10.0
"""A flight keeps the pose if it never is farther from the desired one, in metres and in degrees."""
_LATER = "omnimorph-2026"  # its public parameter file allows faster rotors


class Share(NamedTuple):
    """How many flights met a criterion, and how many there were."""

    met: int
    flown: int

    @property
    def at_least_half(self) -> bool:
        """Whether half of them did, or more."""
        return 2 * self.met >= self.flown


def degrade(scenario: Scenario, loss: float, kind: str = KINDS[0]) -> Scenario:
    """Return the scenario with a share of the thrust lost, of all rotors or of the lower ones."""
    lower = scenario.vehicle.rotor_position[:, 2] < 0.0
    lose = np.where(lower, loss, 0.0) if kind == "lower rotors" else np.full(len(lower), loss)
    return with_effects(scenario, Effectiveness(share=tuple((1.0 - lose).tolist())))


def with_speed_limit(scenario: Scenario, speed: float) -> Scenario:
    """Return the scenario with rotors that the controller and the plant let turn so fast."""
    n = scenario.vehicle.n_rotors
    vehicle = scenario.vehicle.replace(speed_min=np.full(n, -speed), speed_max=np.full(n, speed))
    return replace(scenario, vehicle=vehicle)


def speed_limits(vehicle: Vehicle) -> tuple[float, float]:
    """Return the two limits of rotor speed, rad/s: the paper's 37°, and the later prototype's."""
    return float(vehicle.speed_max[0]), float(load_vehicle(_LATER).speed_max[0])


def count_met(flown: Sequence[FlightResult], criterion: str) -> Share:
    """Return how many flights met a criterion, `NOT_LOST` or `POSE_KEPT`."""
    met = [one.completed if criterion == NOT_LOST else _keeps_pose(one) for one in flown]
    return Share(sum(met), len(met))


def _keeps_pose(one: FlightResult) -> bool:
    if one.metrics is None or not one.completed:
        return False
    near = one.metrics.position_error_max_m <= KEPT_WITHIN_M
    return near and one.metrics.attitude_error_max_rad <= math.radians(KEPT_WITHIN_DEG)
