"""The closed loop, stepped from Python.

::

    sense -> estimate -> track -> allocate -> act

All of it is the core's, and a flight in Python is the flight in the core, but for what is one's own
(`own_parts`): each such part takes the place of one stage.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from time import perf_counter
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.arrays import as_numbers
from omnimorph.control.controller import core_settings
from omnimorph.errors import ScenarioError
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.model.stored_state import Storable
from omnimorph.protocols import Command, FloatArray, State
from omnimorph.results.run import Outcome, Run
from omnimorph.simulation.core_settings import core_settings_of, physics_steps
from omnimorph.simulation.effects import Effectiveness
from omnimorph.simulation.own_parts import PartFailed
from omnimorph.simulation.recording import OUTCOMES, FlownRows, Logs, as_run, bytes_of_flights
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import ScenarioLike, as_scenario
from omnimorph.simulation.stages import NO_PUSH, Stages, at_steps_of, six_numbers
from omnimorph.simulation.whole_number import whole_number

__all__ = ["NO_PUSH", "Progress", "SteppedFlight"]

Progress = Callable[[float, float], None]
"""Called now and then with the time flown and the duration, s."""
_STEPS_BETWEEN_REPORTS = 2000


class SteppedFlight(Storable):
    """A flight under way, which can be pushed, damaged, commanded, logged, copied and stored.

    Left alone it is the flight that `fly` returns, to the last bit. `copy.copy` and `pickle` make a
    branch that flies on by itself, with copies of the parts that are one's own.

    Parameters
    ----------
    scenario : Scenario, str or path
        What is flown, or its name or file.
    seed, flight : int
        Which noise.

    Raises
    ------
    ScenarioError
        If a number, the reference or a part cannot be flown.
    TooLargeError
        If it has more rows than memory holds.

    Attributes
    ----------
    columns : mapping of str to array
        Of a run, by name, read-only, filled up to `row`; rows after that are not yet flown.
    notes : dict
        What the run's provenance says beside the scenario; what is done to the flight is in it.

    Examples
    --------
    >>> import omnimorph as om
    >>> flight = om.SteppedFlight(om.load_scenario("hover"))
    >>> flight.step()
    >>> flight.time, flight.is_over, flight.row
    (0.004, False, 3)
    """

    kind = "flight"

    def __init__(self, scenario: ScenarioLike, *, seed: int = 0, flight: int = 0) -> None:
        seed = whole_number("fly", "seed", seed, 64)
        flight = whole_number("fly", "flight", flight, 32)
        scenario = as_scenario(scenario)
        self._own = scenario.own.built(scenario)
        self.scenario = at_steps_of(self._own.plant, scenario)
        self._seed, self._flight = seed, flight
        self._begin()
        self._stages.begin(seed, flight)

    def _begin(self) -> None:
        """Set up the flight in the core, and what is recorded of it."""
        scenario = self.scenario
        refuse_more_than_memory(
            f"{scenario.name}: the {physics_steps(scenario) + 1} rows of the flight",
            bytes_of_flights(scenario, 1),
            "fly for less time or with longer physics steps",
        )
        parts = core_settings_of(scenario)
        self.steps, self.control_every = parts.steps, parts.control_every
        self.core = self._in_core = _core.new_flight(
            **parts.of_flight(), seed=self._seed, flight=self._flight, is_recorded=True
        )
        self._stages = Stages(self.core, parts, scenario, self._own)
        self.columns = MappingProxyType(self.core.columns())
        self.notes: dict[str, Any] = {}
        control_steps = self.steps // self.control_every + 2
        self._logs = Logs(control_steps, self.steps + 1, scenario.vehicle)
        self._shares: FloatArray | None = None  # of the thrust, since `set_effectiveness`
        self._controller_of: Scenario | None = None  # since `change_controller`
        self._began = perf_counter()

    @property
    def time(self) -> float:
        """Time flown, s."""
        return self._stages.time

    @property
    def duration(self) -> float:
        """Of the whole flight, s."""
        return self.steps * self.scenario.plant.physics_step

    @property
    def is_over(self) -> bool:
        """Whether the flight has ended, one way or another."""
        return self.core.status != _core.FlightStatus.FLYING

    @property
    def row(self) -> int:
        """The last row of `columns` that is flown."""
        return self.core.step if self.is_over else max(self.core.step - 1, 0)

    @property
    def outcome(self) -> Outcome:
        """How it ended, or that it goes on."""
        return OUTCOMES[self.core.status] if self.is_over else Outcome.UNDER_WAY

    @property
    def state(self) -> State:
        """The true motion now, with the rotors' speeds, the tilt and the acceleration."""
        return self._stages.true_state()

    def step(
        self,
        push: ArrayLike = NO_PUSH,
        *,
        command: Command | None = None,
        demand: ArrayLike | None = None,
    ) -> None:
        """Fly one control period.

        Without a command or a demand the flight's own controller decides.

        Parameters
        ----------
        push : (6,) array
            A wrench from outside, held over the period: force (N, in W), torque (N m, in B).
        command : Command, optional
            What the actuators shall do, instead of what the controller would decide.
        demand : (6,) array, optional
            The acceleration that the allocator shall answer, instead of the controller's: linear
            (m/s², in W), then angular (rad/s², in B).

        Raises
        ------
        ScenarioError
            If the push or the demand is not six finite numbers, or the command does not fit; if a
            part of one's own gives what cannot be flown in the very first step. Later that ends the
            flight, and what has been flown is kept.

        Examples
        --------
        >>> import numpy as np, omnimorph as om
        >>> flight = om.SteppedFlight("hover")
        >>> flight.step(command=om.Command(np.full(8, 1.7), np.zeros(1)))
        >>> flight.step(demand=[0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        >>> flight.columns["thrust_command"][0, :2].tolist()
        [1.7, 1.7]
        """
        if command is not None and demand is not None:
            raise ScenarioError("the flight takes a command or a demand, not both.")
        wrench = six_numbers("the flight", "push", push)
        if demand is not None:
            demand = six_numbers("the flight", "demand", demand)
        self._step(wrench, command, demand)

    def _step(
        self,
        push: FloatArray,
        command: Command | None = None,
        demand: FloatArray | None = None,
    ) -> None:
        if self.is_over:
            return
        began = self.core.step
        try:
            if began < self.steps:
                for part, log in self._stages.decide(command, demand):
                    self._logs.log_all(part, log, began // self.control_every)
            if not self.is_over:
                self._stages.move(push)
        except PartFailed as failed:
            if began == 0:  # nothing has been flown that could be lost
                failed.refuse()
            self.note("failure", part=failed.part, error=failed.what)
            self.core.end_here(_core.FlightStatus.PART_FAILED)

    def fly(self, progress: Progress | None = None) -> None:
        """Fly on to the end, stopping now and then to report and to notice an interrupt."""
        while not self.is_over:
            if self._stages.are_of_core:
                self.core.advance(_STEPS_BETWEEN_REPORTS)
            else:
                until = self.core.step + _STEPS_BETWEEN_REPORTS
                while self.core.step < until and not self.is_over:
                    self._step(NO_PUSH)
            if progress is not None:
                progress(self.time, self.duration)

    def log(self, name: str, value: ArrayLike, unit: str = "1") -> None:
        """Record numbers of one's own from now on, until the next are logged.

        They become a column of the run, of its file and of its plots.

        Parameters
        ----------
        name : str
            Of the column.
        value : number or array
            Of the same shape each time.
        unit : str
            As it is to be shown.

        Raises
        ------
        ScenarioError, InputError
            If it is no number, changes its shape or unit, or a run cannot have such a column.

        Examples
        --------
        >>> import omnimorph as om
        >>> flight = om.SteppedFlight("hover")
        >>> flight.log("battery", 16.2, unit="V")
        >>> flight.step()
        >>> flight.as_run()["battery"].tolist()
        [16.2, 16.2, 16.2, 16.2]
        """
        self._logs.log(name, value, unit, -(-self.core.step // self.control_every))

    def change_controller(self, scenario: ScenarioLike) -> None:
        """Go on with the controller of another scenario, from the last command.

        A controller or an allocator of one's own is asked no more.

        Raises
        ------
        ScenarioError
            If it is for another vehicle, its allocator does not fit, or its controller is written
            in Python.
        """
        mine, other = self.scenario, as_scenario(scenario)
        if other.vehicle.name != mine.vehicle.name:
            allowed = f"one for {mine.vehicle.name}, which is flying"
            raise ScenarioError.at(other.name, "vehicle", other.vehicle.name, allowed)
        if other.own.controller is not None or other.own.allocator is not None:
            allowed = "one of the core; a part written in Python flies from the start"
            raise ScenarioError.at(other.name, "controller", "written in Python", allowed)
        settings = core_settings(
            mine.vehicle,
            other.gains,
            other.allocator,
            mine.plant.control_period,
            other.lateral_force,
        )
        self.core.change_controller(settings)
        self._stages.change_controller(settings)
        self._controller_of = other
        self.note("controller", scenario=other.name, attitude_gives_way=other.attitude_gives_way)

    def set_effectiveness(self, share: FloatArray) -> None:
        """Let each rotor give a share of its thrust from now on: 1 what the plant gives, 0 none.

        Raises
        ------
        ScenarioError
            If they are not one share a rotor, finite and not negative, or an engine of one's own
            flies, which decides that itself.
        """
        shares = as_numbers(share)
        n = self.scenario.vehicle.n_rotors
        if shares.shape != (n,) or not (np.isfinite(shares) & (shares >= 0.0)).all():
            allowed = f"{n} shares of the thrust, finite and not negative"
            raise ScenarioError.at("the flight", "effectiveness", share, allowed)
        if self._own.plant is not None:
            allowed = "left to the plant, which is written in Python"
            raise ScenarioError.at("the flight", "effectiveness", share, allowed)
        of_plant = np.ones(n)
        for effect in self.scenario.plant.effects:
            if isinstance(effect, Effectiveness):
                of_plant *= effect.share
        self.core.set_effectiveness(shares * of_plant)
        self._shares = shares
        self.note("effectiveness", share=shares.tolist())

    def restore(self, state: bytes) -> None:
        """Go on from a state that a flight of the same scenario has stored.

        The scenario, the reference, parts of one's own, what `set_effectiveness` or
        `change_controller` did and the rows flown are not part of it: `copy.copy` and `pickle` keep
        all of that. Of a flight like it (another mass, another noise) it goes on with the numbers
        of this one. Rows before it that this flight has not flown itself are NaN.

        Raises
        ------
        ScenarioError
            If the state is of another version of omnimorph, of a flight with other counts of rotors
            and servos or other time steps, or broken; if an engine of one's own flies, whose state
            is not in it.

        Examples
        --------
        >>> import omnimorph as om
        >>> flight, branch = om.SteppedFlight("hover"), om.SteppedFlight("hover")
        >>> flight.step()
        >>> branch.restore(flight.stored_state())
        >>> branch.time == flight.time
        True
        """
        if self._own.plant is not None:
            raise ScenarioError(
                "the flight cannot be restored, because its plant is written in Python and its "
                "state is not in what was stored; copy or pickle the flight instead."
            )
        super().restore(state)
        self.note("restored")

    def __getstate__(self) -> dict[str, Any]:
        rows = self.row + 1
        return {
            "scenario": self.scenario,
            "own": self._own,
            "noise": (self._seed, self._flight),
            "core": self.stored_state(),
            "columns": {name: column[:rows] for name, column in self.columns.items()},
            "notes": self.notes,
            "logs": self._logs,
            "changed": (self._shares, self._controller_of),
            "elapsed": perf_counter() - self._began,
        }

    def __setstate__(self, kept: dict[str, Any]) -> None:
        self.scenario, self._own = kept["scenario"], kept["own"]
        self._seed, self._flight = kept["noise"]
        self._begin()
        shares, controller_of = kept["changed"]
        if controller_of is not None:
            self.change_controller(controller_of)
        if shares is not None:
            self.set_effectiveness(shares)
        super().restore(kept["core"])
        self.core.put_rows({name: np.array(rows) for name, rows in kept["columns"].items()})
        self.notes, self._logs = kept["notes"], kept["logs"]
        self._began = perf_counter() - kept["elapsed"]

    def __copy__(self) -> SteppedFlight:
        return copy.deepcopy(self)  # what is one's own remembers its own flight

    def note(self, kind: str, **what: Any) -> None:
        """Note in the provenance what was done to the flight, and when."""
        event = {"kind": kind, "time_s": round(self.time, 9), **what}
        self.notes.setdefault("events", []).append(event)

    def as_run(self) -> Run:
        """Return the rows flown so far as a run.

        Raises
        ------
        ScenarioError
            Before the first step: there is no row yet.
        """
        if self.core.step == 0 and not self.is_over:
            raise ScenarioError(f"{self.scenario.name}: nothing has been flown yet; step first.")
        truth = self.scenario.plant.true_vehicle(self.scenario.vehicle)
        flown = FlownRows(
            self.columns,
            self.row + 1,
            self.outcome,
            self._seed,
            self._flight,
            max(perf_counter() - self._began, math.ulp(1.0)),
            truth.drag_coefficient,
            self._logs.columns(self.row + 1, self.control_every),
        )
        return as_run(self.scenario, flown, self.notes)
