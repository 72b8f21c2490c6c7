"""What can be done to a flight under way: pushes, cut rotors, another controller."""

from __future__ import annotations

import threading

import numpy as np

from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray
from omnimorph.simulation.loop import NO_PUSH, SteppedFlight
from omnimorph.simulation.scenario import Scenario

PUSH_SECONDS = 0.2
"""How long a push lasts."""


class Pilot:
    """Flies a `SteppedFlight` on, and does to it what is asked for meanwhile.

    What is done is noted in the provenance of the run. All methods may be called from any thread.

    Parameters
    ----------
    flight : SteppedFlight
        Under way.
    """

    def __init__(self, flight: SteppedFlight) -> None:
        self.flight = flight
        self.lock = threading.RLock()
        self._push = np.zeros(6)
        self._push_left = 0  # control steps
        self._cut: set[int] = set()

    @property
    def weight(self) -> float:
        """Of the vehicle, N."""
        return self.flight.scenario.vehicle.mass * GRAVITY

    def push(self, force_W: FloatArray) -> None:
        """Push the vehicle at its centre of mass for `PUSH_SECONDS`, (3,) N in W."""
        with self.lock:
            self._push = np.concatenate([force_W, np.zeros(3)])
            period = self.flight.scenario.plant.control_period
            self._push_left = max(round(PUSH_SECONDS / period), 1)
            force = np.asarray(force_W).tolist()
            self.flight.note("push", force_N=force, duration_s=PUSH_SECONDS)

    def cut(self, rotor: int) -> None:
        """Take all thrust from a rotor, counted from 0; it goes on turning."""
        with self.lock:
            self._cut.add(rotor)
            self._change_effectiveness()

    def restore(self) -> None:
        """Give all rotors their thrust again."""
        with self.lock:
            self._cut.clear()
            self._change_effectiveness()

    def take_controller_of(self, scenario: Scenario) -> None:
        """Go on with the controller of another scenario."""
        with self.lock:
            self.flight.change_controller(scenario)

    def advance(self, until: float) -> None:
        """Fly on to a time, s, or to the end."""
        with self.lock:
            flight = self.flight
            while not flight.is_over and flight.time < until:
                flight.step(self._push if self._push_left else NO_PUSH)
                self._push_left = max(self._push_left - 1, 0)

    def _change_effectiveness(self) -> None:
        share = np.ones(self.flight.scenario.vehicle.n_rotors)
        share[list(self._cut)] = 0.0
        self.flight.set_effectiveness(share)
