"""What becomes of the rows of a flight: the memory they take, logs of one's own, and the run."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from omnimorph import _core
from omnimorph.arrays import as_numbers
from omnimorph.design.files import vehicle_text
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.protocols import FloatArray
from omnimorph.reference.segments import SegmentReference
from omnimorph.results.columns import sizes_of
from omnimorph.results.logged import LoggedColumn
from omnimorph.results.run import COLUMNS, Outcome, Performance, Provenance, Run
from omnimorph.simulation.core_settings import physics_steps
from omnimorph.simulation.scenario import Scenario

__all__ = ["OUTCOMES", "FlownRows", "Logs", "as_run", "bytes_of_a_row", "bytes_of_flights"]

_BYTES_OF_A_SAMPLE = 800  # of a reference that is asked for every step, with what is copied
OUTCOMES = {
    _core.FlightStatus.COMPLETED: Outcome.COMPLETED,
    _core.FlightStatus.LOST: Outcome.LOST,
    _core.FlightStatus.DIVERGED: Outcome.DIVERGED,
    _core.FlightStatus.NOT_FINITE: Outcome.NOT_FINITE,
    _core.FlightStatus.PART_FAILED: Outcome.PART_FAILED,
}


def bytes_of_flights(scenario: Scenario, traces: int) -> int:
    """Return about how much memory flights need, so many of which are recorded.

    Raises
    ------
    ScenarioError
        As `physics_steps`.
    """
    rows, vehicle = physics_steps(scenario) + 1, scenario.vehicle
    needed = traces * rows * (bytes_of_a_row(vehicle) + 16 * vehicle.n_rotors)  # for its power
    if isinstance(scenario.reference, SegmentReference):
        return needed
    return rows * _BYTES_OF_A_SAMPLE + needed


class Flown(NamedTuple):
    """What a flight left behind: its columns, of which the first `rows` are filled."""

    columns: Mapping[str, Any]
    rows: int
    outcome: Outcome
    seed: int
    flight: int
    wall_time: float
    drag_coefficient: FloatArray  # (n,) of the vehicle that flew


def as_run(scenario: Scenario, flown: Flown, written: dict[str, Any]) -> Run:
    """Return the rows flown as a run; `written` is what the scenario does not say of it."""
    plant = scenario.plant
    time = np.arange(flown.rows, dtype=np.float64) * plant.physics_step
    columns = {name: column[: flown.rows] for name, column in flown.columns.items()}
    with np.errstate(all="ignore"):  # a flight that diverged holds what overflows
        speed = np.abs(columns["speed"])
        columns["drag_power"] = (speed * speed * speed) @ flown.drag_coefficient
    return Run(
        time=time,
        **columns,
        outcome=flown.outcome,
        vehicle=scenario.vehicle,
        provenance=Provenance(
            scenario_name=scenario.name,
            scenario_text=json.dumps(scenario.as_file() | written, sort_keys=True),
            vehicle_text=vehicle_text(scenario.vehicle),
            plant_name=plant.name,
            seed=flown.seed,
            flight=flown.flight,
            control_period=plant.control_period,
            physics_step=plant.physics_step,
            version=_version(),
        ),
        performance=Performance(
            wall_time=flown.wall_time,
            real_time_factor=float(time[-1]) / max(flown.wall_time, 1e-9),
        ),
    )


def bytes_of_a_row(vehicle: Vehicle) -> int:
    """Return how much memory a row of a recorded flight takes."""
    sizes = sizes_of(vehicle)
    return 8 + sum(column.bytes_of_a_row(sizes) for column in COLUMNS)  # 8 for its time


