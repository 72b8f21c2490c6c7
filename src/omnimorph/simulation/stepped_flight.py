"""A scenario flown a control step at a time, and recorded like any other flight."""

from __future__ import annotations

import math
from time import perf_counter
from types import MappingProxyType
from typing import Any

import numpy as np

from omnimorph import _core
from omnimorph.arrays import as_numbers
from omnimorph.control.controller import core_settings
from omnimorph.errors import ScenarioError
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.protocols import Command, FloatArray
from omnimorph.results.run import Outcome, Run
from omnimorph.simulation.effects import Effectiveness
from omnimorph.simulation.loop_parts import (
    OUTCOMES,
    Flown,
    as_run,
    bytes_of_flights,
    loop_parts,
    physics_steps,
)
from omnimorph.simulation.scenario_files import ScenarioLike, as_scenario
from omnimorph.simulation.whole_number import whole_number

__all__ = ["NO_PUSH", "SteppedFlight"]

NO_PUSH = np.zeros(6)


class SteppedFlight:
    """A flight under way, which can be pushed, damaged and given another controller.

    Left alone it is the flight that `fly` returns, to the last bit.

    Parameters
    ----------
    scenario : Scenario, str or path
        What is flown, or its name or file.
    seed, flight : int
        Which noise.

    Raises
    ------
    ScenarioError
        If a number or the reference cannot be flown.
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

    def __init__(self, scenario: ScenarioLike, *, seed: int = 0, flight: int = 0) -> None:
        self.scenario = scenario = as_scenario(scenario)
        self._seed = whole_number("fly", "seed", seed, 64)
        self._flight = whole_number("fly", "flight", flight, 32)
        refuse_more_than_memory(
            f"{scenario.name}: the {physics_steps(scenario) + 1} rows of the flight",
            bytes_of_flights(scenario, 1),
            "fly for less time or with longer physics steps",
        )
        parts = loop_parts(scenario)
        self.steps, self.control_every = parts.steps, parts.control_every
        self.settings = parts.controller
        self.start_command = Command(parts.thrust, parts.tilt)
        self.core = _core.new_flight(
            **parts.of_flight(), seed=self._seed, flight=self._flight, is_recorded=True
        )
        self.columns = MappingProxyType(self.core.columns())
        self.notes: dict[str, Any] = {}
        self._began = perf_counter()

    @property
    def time(self) -> float:
        """Time flown, s."""
        return self.core.step * self.scenario.plant.physics_step

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

    def step(self, push: FloatArray = NO_PUSH) -> None:
        """Fly one control period with the core's controller.

        Parameters
        ----------
        push : (6,) array
            A wrench from outside, held over the period: force (N, in W), torque (N m, in B).

        Raises
        ------
        ScenarioError
            If the push is not six finite numbers.
        """
        wrench = as_numbers(push)
        if wrench.shape != (6,) or not np.isfinite(wrench).all():
            allowed = "six finite numbers, force in W and torque in B"
            raise ScenarioError.at("the flight", "push", push, allowed)
        if self.core.step < self.steps:
            self.core.control(self.core.measure(), self.core.desired())
        self.core.integrate(self.control_every, wrench)

    def change_controller(self, scenario: ScenarioLike) -> None:
        """Go on with the controller of another scenario, from the last command.

        Raises
        ------
        ScenarioError
            If it is for another vehicle, or its allocator does not fit.
        """
        mine, other = self.scenario, as_scenario(scenario)
        if other.vehicle.name != mine.vehicle.name:
            allowed = f"one for {mine.vehicle.name}, which is flying"
            raise ScenarioError.at(other.name, "vehicle", other.vehicle.name, allowed)
        settings = core_settings(
            mine.vehicle,
            other.gains,
            other.allocator,
            mine.plant.control_period,
            other.lateral_force,
        )
        self.core.change_controller(settings)
        self.note("controller", scenario=other.name, attitude_gives_way=other.attitude_gives_way)

    def set_effectiveness(self, share: FloatArray) -> None:
        """Let each rotor give a share of its thrust from now on: 1 what the plant gives, 0 none.

        Raises
        ------
        ScenarioError
            If they are not one share a rotor, finite and not negative.
        """
        shares = as_numbers(share)
        n = self.scenario.vehicle.n_rotors
        if shares.shape != (n,) or not (np.isfinite(shares) & (shares >= 0.0)).all():
            allowed = f"{n} shares of the thrust, finite and not negative"
            raise ScenarioError.at("the flight", "effectiveness", share, allowed)
        self.core.set_effectiveness(shares * self._shares_of_plant())
        self.note("effectiveness", share=shares.tolist())

    def _shares_of_plant(self) -> FloatArray:
        shares = np.ones(self.scenario.vehicle.n_rotors)
        for effect in self.scenario.plant.effects:
            if isinstance(effect, Effectiveness):
                shares *= effect.share
        return shares

    def stored_state(self) -> bytes:
        """Return the state of the flight: all that it needs to go on the same to the last bit.

        The scenario, the reference and what `set_effectiveness` or `change_controller` did are not
        part of it, nor are the rows flown.
        """
        return self.core.store()

    def restore(self, state: bytes) -> None:
        """Go on from a state that a flight of the same scenario has stored.

        Of one like it (another mass, another noise) it goes on with the numbers of this flight.
        Rows before it that this flight has not flown itself are NaN.

        Raises
        ------
        ScenarioError
            If the state is of another version of omnimorph, of a flight with other counts of rotors
            and servos or other time steps, or broken.

        Examples
        --------
        >>> import omnimorph as om
        >>> flight, branch = om.SteppedFlight("hover"), om.SteppedFlight("hover")
        >>> flight.step()
        >>> branch.restore(flight.stored_state())
        >>> branch.time == flight.time
        True
        """
        try:
            self.core.restore(memoryview(state).tobytes())
        except (TypeError, ValueError) as problem:
            allowed = "what a flight of the same scenario has stored"
            raise ScenarioError(
                f"the state of the flight cannot be used, because {problem}; it must be {allowed}."
            ) from None
        self.note("restored")

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
        flown = Flown(
            self.columns,
            self.row + 1,
            self.outcome,
            self._seed,
            self._flight,
            max(perf_counter() - self._began, math.ulp(1.0)),
            truth.drag_coefficient,
        )
        return as_run(self.scenario, flown, self.notes)
