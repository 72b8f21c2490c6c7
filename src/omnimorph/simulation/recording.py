"""What becomes of the rows of a flight: the memory they take, logs of one's own, and the run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from omnimorph import _core
from omnimorph.design.files import vehicle_text
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.protocols import FloatArray, Log
from omnimorph.reference.segments import SegmentReference
from omnimorph.results.columns import sizes_of
from omnimorph.results.logged import LoggedColumn, checked
from omnimorph.results.record import names_taken
from omnimorph.results.run import COLUMNS, Outcome, Performance, Provenance, Run
from omnimorph.simulation.core_settings import physics_steps
from omnimorph.simulation.own_parts import FAILURES, PartFailed, name_of
from omnimorph.simulation.scenario import Scenario
from omnimorph.version import __version__

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


class FlownRows(NamedTuple):
    """What a flight left behind: its columns, of which the first `rows` are filled."""

    columns: Mapping[str, Any]
    rows: int
    outcome: Outcome
    seed: int
    flight: int
    wall_time: float
    drag_coefficient: FloatArray  # (n,) of the vehicle that flew
    logged: Mapping[str, LoggedColumn] = MappingProxyType({})


def as_run(scenario: Scenario, flown: FlownRows, written: dict[str, Any]) -> Run:
    """Return the rows flown as a run; `written` is what the scenario does not say of it."""
    plant, engine = scenario.plant, scenario.own.plant
    time = np.arange(flown.rows, dtype=np.float64) * plant.physics_step
    columns = {name: column[: flown.rows] for name, column in flown.columns.items()}
    with np.errstate(all="ignore"):  # a flight that diverged holds what overflows
        speed = np.abs(columns["speed"])
        columns["drag_power"] = (speed * speed * speed) @ flown.drag_coefficient
    return Run(
        time=time,
        **columns,
        logged=flown.logged,
        outcome=flown.outcome,
        vehicle=scenario.vehicle,
        provenance=Provenance(
            scenario_name=scenario.name,
            scenario_text=json.dumps(scenario.as_file() | written, sort_keys=True),
            vehicle_text=vehicle_text(scenario.vehicle),
            plant_name=plant.name if engine is None else name_of(engine),
            seed=flown.seed,
            flight=flown.flight,
            control_period=plant.control_period,
            physics_step=plant.physics_step,
            version=__version__,
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


class Logs:
    """What is logged beside the columns of the core: one row a control step, held until the next.

    Parameters
    ----------
    steps, control_every : int
        Physics steps of the whole flight, and of a control step.
    vehicle : Vehicle
        Of the flight.
    """

    def __init__(self, steps: int, control_every: int, vehicle: Vehicle) -> None:
        self._control_steps, self._rows_of_run = steps // control_every + 2, steps + 1
        self._bytes_of_run = 0  # that all logs take there
        self._taken = names_taken(Run) | {*sizes_of(vehicle)}
        self._rows: dict[str, FloatArray] = {}
        self._units: dict[str, str] = {}
        self._logged: dict[str, NDArray[np.bool_]] = {}

    def log(self, name: str, value: object, unit: str, control_step: int) -> None:
        """Keep the numbers of a control step.

        Raises
        ------
        ScenarioError
            If they are none, if they had another shape or unit before, or if a run cannot have a
            column of this name.
        """
        if not isinstance(name, str):
            raise ScenarioError.at("the flight", "name of a log", name, "letters, digits and _")
        numbers = _as_log(name, value)
        if name not in self._rows:
            column = LoggedColumn(numbers[np.newaxis], unit)
            checked({name: column}, 1, self._taken)
            self._bytes_of_run += 8 * self._rows_of_run * numbers.size
            needed = 8 * self._control_steps * numbers.size + self._bytes_of_run
            refuse_more_than_memory("the flight: its logs", needed, "log less")
            self._rows[name] = np.full((self._control_steps, *numbers.shape), np.nan)
            self._units[name] = unit
            self._logged[name] = np.zeros(self._control_steps, dtype=bool)
        rows = self._rows[name]
        if numbers.shape != rows.shape[1:]:
            allowed = f"{rows.shape[1:]}, as in the control steps before"
            raise ScenarioError.at("the flight", f"shape of log {name}", numbers.shape, allowed)
        if unit != self._units[name]:
            allowed = f"{self._units[name]}, as before"
            raise ScenarioError.at("the flight", f"unit of log {name}", unit, allowed)
        rows[control_step] = numbers
        self._logged[name][control_step] = True

    def log_each(self, log: Log, control_step: int) -> None:
        """Keep numbers by name, alone or with a unit; see `log`."""
        for name, value in log.items():
            pair = isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str)
            number, unit = value if pair else (value, "1")
            self.log(name, number, unit, control_step)

    def log_all(self, part: str, log: Log, control_step: int) -> None:
        """Keep what a part of one's own wants recorded, numbers alone or with a unit.

        Raises
        ------
        PartFailed
            If it cannot be kept, see `log`.
        """
        try:
            self.log_each(log, control_step)
        except FAILURES as error:
            raise PartFailed(part, error) from error

    def columns(self, rows: int, control_every: int) -> dict[str, LoggedColumn]:
        """Return a column of so many rows for each name: what was logged, held until the next."""
        step_of_row = np.arange(rows) // control_every
        columns = {}
        for name, values in self._rows.items():
            steps = np.arange(self._control_steps)
            last = np.maximum.accumulate(np.where(self._logged[name], steps, -1))[step_of_row]
            held = values[last]
            held[last < 0] = np.nan
            columns[name] = LoggedColumn(held, self._units[name])
        return columns


def _as_log(name: str, value: object) -> FloatArray:
    """Return what is to be logged as an array; refuse what is no number."""
    try:
        array = np.asarray(value)
        if array.dtype.kind in "biuf" and array.size:
            return array.astype(np.float64)
    except ValueError:  # rows of different lengths
        pass
    raise ScenarioError.at("the flight", f"log {name}", value, "a number or an array of numbers")
