"""In what the flights of a batch differ: keys, and paths of the scenario's own numbers.

A key, such as ``mass``, changes the core's fields of all flights at once; a path, such as
``truth.mass``, changes the scenario, and from it follow the core's fields of each flight just as
for a flight alone. Both end as rows of fields of the core.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph import _core
from omnimorph.errors import InputError, ScenarioError
from omnimorph.protocols import FloatArray
from omnimorph.simulation.core_rows import ALIKE, PAIRS, CoreRows, numbers_of_core
from omnimorph.simulation.core_settings import CoreSettings
from omnimorph.simulation.distributions import Distribution, Normal, Uniform, numbers_drawn
from omnimorph.simulation.effects import ConstantWrench
from omnimorph.simulation.paths import replaced, shape_at
from omnimorph.simulation.scenario import Scenario

__all__ = [
    "VARIABLE",
    "Distribution",
    "Normal",
    "Uniform",
    "Variation",
    "draw",
    "numbers_of_a_flight",
]

_FACTOR = "a positive factor"
_FINITE = "finite"


class _Key(NamedTuple):
    """One thing beside the scenario's own numbers in which flights can differ."""

    change: Callable[[CoreRows, FloatArray], None]  # of the core's fields, by (n, width) numbers
    width: int | None  # how many numbers; one a rotor for None
    allowed: str
    least: float = -math.inf
    effect: str | None = None  # the imperfection that the plant must have

    def refuses(self, values: FloatArray) -> NDArray[np.bool_]:
        """Return which of the numbers cannot be."""
        return ~(np.isfinite(values) & (values >= self.least))


def _scaled(*paths: str) -> Callable[[CoreRows, FloatArray], None]:
    def change(rows: CoreRows, factor: FloatArray) -> None:
        for path in paths:
            rows[path] = rows[path] * factor

    return change


def _moved(path: str, at: slice = slice(None)) -> Callable[[CoreRows, FloatArray], None]:
    def change(rows: CoreRows, values: FloatArray) -> None:
        moved = np.tile(rows[path], (len(values) // len(rows[path]), 1))
        moved[:, at] += values
        rows[path] = moved

    return change


def _set_effectiveness(rows: CoreRows, share: FloatArray) -> None:
    rows["plant.effectiveness"] = share


def _move_centre_of_mass(rows: CoreRows, centre: FloatArray) -> None:
    hubs = rows["plant.vehicle.position"]
    moved = hubs.reshape(len(hubs), -1, 3) - centre[:, np.newaxis, :]
    rows["plant.vehicle.position"] = moved.reshape(len(centre), -1)


def _turn_start(rows: CoreRows, turns: FloatArray) -> None:
    R = rows["start.motion.R"].reshape(3, 3)
    turned = [R @ _core.rotation_exponential(turn) for turn in turns]
    rows["start.motion.R"] = np.reshape(turned, (len(turns), 9))


_ABOVE_ZERO = math.ulp(0.0)
_TRUTH, _PUSH = "plant.vehicle.", "plant.constant-wrench.constant"
_LAGS = _scaled("plant.rotor-lag.up", "plant.rotor-lag.down")
_KEYS = {
    "mass": _Key(_scaled(_TRUTH + "mass"), 1, _FACTOR, _ABOVE_ZERO),
    "inertia": _Key(_scaled(_TRUTH + "inertia"), 1, _FACTOR, _ABOVE_ZERO),
    "thrust_coefficient": _Key(_scaled(_TRUTH + "thrust_coefficient"), None, _FACTOR, _ABOVE_ZERO),
    "drag_coefficient": _Key(_scaled(_TRUTH + "drag_coefficient"), None, _FACTOR, _ABOVE_ZERO),
    "effectiveness": _Key(_set_effectiveness, None, "a share of the thrust, not negative", 0.0),
    "centre_of_mass": _Key(_move_centre_of_mass, 3, _FINITE),
    "rotor_lag": _Key(_LAGS, 1, _FACTOR, _ABOVE_ZERO, "rotor-lag"),
    "noise": _Key(
        _scaled("measurement-noise.deviation"),
        1,
        "a factor, not negative",
        0.0,
        "measurement-noise",
    ),
    "force": _Key(_moved(_PUSH, slice(0, 3)), 3, _FINITE),
    "torque": _Key(_moved(_PUSH, slice(3, 6)), 3, _FINITE),
    "start_position": _Key(_moved("start.motion.p"), 3, _FINITE),
    "start_velocity": _Key(_moved("start.motion.v"), 3, _FINITE),
    "start_attitude": _Key(_turn_start, 3, _FINITE),
    "start_rate": _Key(_moved("start.motion.w"), 3, _FINITE),
}
VARIABLE = tuple(_KEYS)
"""Everything in which the flights of a batch can differ, beside numbers of the scenario."""

_TOGETHER = "the flights of a batch step together"
_TABLE = "its table is one for all flights of a batch"
_SINE = "its sine is computed once for all flights of a batch"
SHARED = {
    "plant.physics_step": _TOGETHER,
    "plant.control_period": _TOGETHER,
    "plant.command-delay.time": "a delay is counted in steps, and " + _TOGETHER,
    "plant.sine-wrench.frequency": _SINE,
    "plant.sine-wrench.phase": _SINE,
    "plant.wrench-profile.times": _TABLE,
    "plant.wrench-profile.force": _TABLE,
    "plant.wrench-profile.torque": _TABLE,
    "controller.allocator.candidates": "all flights of a batch try equally many tilts side by side",
    "lost_beyond": "a batch has one bound beyond which its flights are lost",
}
"""Paths whose numbers all flights of a batch share, and why."""
_ALL_OR_NONE = {
    PAIRS: "all flights of a batch share which rotors are in line",
    ALIKE: "W2_position weighs all directions alike either in all flights of a batch or in none",
    "controller.tracking.position-first.lateral_force": (
        "the attitude gives way either in all flights of a batch or in none"
    ),
}


class Variation:
    """The numbers in which flights differ, drawn and checked.

    Attributes
    ----------
    drawn : dict of str to array
        By key or path: (n,) for a single number, (n, ...) for several.
    flights : int
        How many, n.
    """

    def __init__(
        self, scenario: Scenario, drawn: dict[str, FloatArray], first: int, flights: int
    ) -> None:
        self.drawn, self.flights = drawn, flights
        self._scenario, self._first = scenario, first
        self._paths = [name for name in drawn if name not in _KEYS]

    @cached_property
    def flown(self) -> Scenario:
        """The scenario of the first flight, with every effect in which flights differ."""
        return self._with_paths(self._pushed, 0)

    def scenario_of(self, row: int) -> Scenario:
        """Return the scenario of one flight: with its numbers at the paths, without the keys."""
        return self._with_paths(self._scenario, row)

    def for_core(self, parts: CoreSettings) -> dict[str, FloatArray]:
        """Return a row for each flight of every field of the core in which they differ.

        `parts` are those of `flown`, the first flight.

        Raises
        ------
        ScenarioError
            If a flight's numbers are not possible, or must be those of all flights.
        """
        rows = CoreRows(parts, self.flown, self.flights)
        for row in range(1, self.flights if self._paths else 1):
            scenario = self._with_paths(self._pushed, row)
            shared = rows.put(row, numbers_of_core(scenario, parts.start))
            if shared is not None:
                raise self._must_be_shared(row, shared)
        for name in self.drawn:
            if name in _KEYS:
                _KEYS[name].change(rows, self.drawn[name].reshape(self.flights, -1))
        return rows.differing

    def of_flight(self, row: int) -> dict[str, object]:
        """Return the numbers of one flight, as JSON holds them."""
        return {name: values[row].tolist() for name, values in self.drawn.items()}

    @cached_property
    def _pushed(self) -> Scenario:
        """The scenario, with a constant wrench for the keys to add to if they do."""
        effects = self._scenario.plant.effects
        pushed = not {"force", "torque"}.isdisjoint(self.drawn)
        if not pushed or any(isinstance(effect, ConstantWrench) for effect in effects):
            return self._scenario
        plant = replace(self._scenario.plant, effects=(*effects, ConstantWrench()))
        return replace(self._scenario, plant=plant)

    def _with_paths(self, scenario: Scenario, row: int) -> Scenario:
        """Return a scenario with the numbers of one flight at the paths."""
        if not self._paths:
            return scenario
        try:
            mine = replaced(scenario, {path: self.drawn[path][row] for path in self._paths})
        except InputError as refused:
            place = f"vary, flight {self._first + row}"
            raise ScenarioError(
                f"{place}: {refused}",
                file=place,
                key=refused.key,
                value=refused.value,
                allowed=refused.allowed,
            ) from None
        decide = ("vehicle", "allocator", "start_tilt")
        if all(getattr(mine, name) is getattr(scenario, name) for name in decide):
            vars(mine)["lateral_force"] = scenario.lateral_force  # whose search takes its time
        return mine

    def _must_be_shared(self, row: int, field: str) -> ScenarioError:
        """Return the refusal of numbers that make flights differ in what a batch shares."""
        why = _ALL_OR_NONE.get(field, f"the core has one {field} for all flights of a batch")
        place = f"vary, flights {self._first} and {self._first + row}"
        return _shared(place, " with ".join(self._paths), f"vary so, because {why}")


def _shared(place: str, path: str, why: str) -> ScenarioError:
    """Return the refusal of numbers that must be those of all flights."""
    alone = "fly each alone, om.fly(om.replaced(scenario, {path: value}))"
    sentence = f"{place}: {path} cannot {why}; {alone}."
    return ScenarioError(sentence, file=place, key=path, allowed="the same for all flights")


def numbers_of_a_flight(vary: Mapping[str, Any], scenario: Scenario) -> int:
    """Return how many numbers are drawn for each flight.

    Raises
    ------
    ScenarioError
        If what is asked for is no mapping, or a key or path is not known.
    """
    if not isinstance(vary, Mapping):
        allowed = f"a mapping from some of {', '.join(VARIABLE)}, or paths, to numbers"
        raise ScenarioError.at("fly_many", "vary", vary, allowed)
    return sum(math.prod(_shape(name, scenario)) for name in vary)


def draw(
    vary: Mapping[str, Distribution | ArrayLike], scenario: Scenario, seed: int, first: int, n: int
) -> Variation:
    """Draw what `vary` asks for, for flights first … first + n − 1.

    Raises
    ------
    ScenarioError
        If a key or path is not known, has no meaning for the plant or is of what a batch shares, if
        an array does not have a row for each flight, or if a number of a key cannot be; it names
        the flight.
    """
    drawn = {}
    for name, wanted in vary.items():
        shape = (n, *_shape(name, scenario))
        if name in _KEYS:
            _check_effect(name, scenario)
            drawn[name] = numbers_drawn(name, wanted, seed, first, shape)
            _check_key(name, drawn[name], first)
        else:
            path, _, _ = name.partition("[")
            if path in SHARED:
                raise _shared("vary", name, f"vary, because {SHARED[path]}")
            drawn[name] = numbers_drawn(name, wanted, seed, first, shape, one_for_all=True)
    return Variation(scenario, drawn, first, n)


def _shape(name: str, scenario: Scenario) -> tuple[int, ...]:
    """Return the shape of the numbers of one flight at a key or path."""
    if name not in _KEYS:
        return shape_at(scenario, name, VARIABLE)
    width = _KEYS[name].width or scenario.vehicle.n_rotors
    return () if width == 1 else (width,)


def _check_effect(name: str, scenario: Scenario) -> None:
    """Refuse a key of an effect that the plant does not have."""
    plant, effect = scenario.plant, _KEYS[name].effect
    if effect is not None and effect not in {one.kind for one in plant.effects}:
        allowed = f"left out, because plant {plant.name} has no {effect}"
        raise ScenarioError.at("vary", name, "given", allowed)


def _check_key(name: str, values: FloatArray, first: int) -> None:
    """Refuse numbers of a key that cannot be, and name the flight."""
    refused = _KEYS[name].refuses(values).reshape(len(values), -1).any(axis=1)
    if refused.any():
        row = int(np.argmax(refused))
        place = f"vary, flight {first + row}"
        raise ScenarioError.at(place, name, values[row], _KEYS[name].allowed)
