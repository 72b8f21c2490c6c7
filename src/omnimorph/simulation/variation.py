"""In what the flights of a batch differ: distributions, and the numbers drawn from them.

Each flight draws its own numbers from (seed, name of the parameter, number of the flight) alone, so
that it is the same however many fly beside it.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph import _core
from omnimorph.arrays import as_numbers
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects import ConstantWrench
from omnimorph.simulation.plant import PARTS_OF_STATE
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


class Distribution(Protocol):
    """Anything with the inverse of a distribution function, such as those of ``scipy.stats``."""

    def ppf(self, q: FloatArray) -> ArrayLike:
        """Return the values below which the shares q, in (0, 1), of all numbers are."""
        ...


@dataclass(frozen=True)
class Uniform(Distribution):
    """Every number from `low` to `high` alike.

    Examples
    --------
    >>> Uniform(0.9, 1.1).ppf(np.array([0.25])).tolist()
    [0.9500000000000001]
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        limits = as_numbers((self.low, self.high))
        if limits.shape != (2,) or not np.isfinite(limits).all() or limits[0] > limits[1]:
            raise ScenarioError.at("Uniform", "limits", (self.low, self.high), "finite, in order")

    def ppf(self, q: FloatArray) -> FloatArray:
        """Return the value at each share q."""
        return self.low + q * (self.high - self.low)


@dataclass(frozen=True)
class Normal(Distribution):
    """The normal distribution.

    Examples
    --------
    >>> Normal(1.0, 0.1).ppf(np.array([0.5])).tolist()
    [1.0]
    """

    mean: float
    deviation: float

    def __post_init__(self) -> None:
        numbers = as_numbers((self.mean, self.deviation))
        if numbers.shape != (2,) or not np.isfinite(numbers).all() or numbers[1] < 0.0:
            allowed = "a finite mean and a deviation that is not negative"
            raise ScenarioError.at("Normal", "numbers", (self.mean, self.deviation), allowed)

    def ppf(self, q: FloatArray) -> FloatArray:
        """Return the value at each share q."""
        from scipy.special import ndtri

        return np.asarray(self.mean + self.deviation * ndtri(q))


class _Parameter(NamedTuple):
    """One thing in which flights can differ."""

    width: int | None  # how many numbers; one a rotor for None
    allowed: str
    least: float = -math.inf
    effect: str | None = None  # the imperfection that the plant must have

    def refuses(self, values: FloatArray) -> NDArray[np.bool_]:
        """Return which of the numbers cannot be."""
        return ~(np.isfinite(values) & (values >= self.least))


_ABOVE_ZERO = math.ulp(0.0)
_PARAMETERS = {
    "mass": _Parameter(1, _FACTOR, _ABOVE_ZERO),
    "inertia": _Parameter(1, _FACTOR, _ABOVE_ZERO),
    "thrust_coefficient": _Parameter(None, _FACTOR, _ABOVE_ZERO),
    "drag_coefficient": _Parameter(None, _FACTOR, _ABOVE_ZERO),
    "effectiveness": _Parameter(None, "a share of the thrust, not negative", 0.0),
    "centre_of_mass": _Parameter(3, _FINITE),
    "rotor_lag": _Parameter(1, _FACTOR, _ABOVE_ZERO, "rotor-lag"),
    "noise": _Parameter(1, "a factor, not negative", 0.0, "measurement-noise"),
    "force": _Parameter(3, _FINITE),
    "torque": _Parameter(3, _FINITE),
    "start_position": _Parameter(3, _FINITE),
    "start_velocity": _Parameter(3, _FINITE),
    "start_attitude": _Parameter(3, _FINITE),
    "start_rate": _Parameter(3, _FINITE),
}
VARIABLE = tuple(_PARAMETERS)
"""Everything in which the flights of a batch can differ."""


class Variation:
    """The numbers in which flights differ, drawn and checked.

    Attributes
    ----------
    drawn : dict of str to array
        (n,) for a parameter of one number, (n, width) otherwise.
    """

    def __init__(self, drawn: dict[str, FloatArray], flights: int) -> None:
        self.drawn, self.flights = drawn, flights

    def flown(self, scenario: Scenario) -> Scenario:
        """Return the scenario with every effect in it in which flights differ."""
        effects = scenario.plant.effects
        pushed = not {"force", "torque"}.isdisjoint(self.drawn)
        if not pushed or any(isinstance(effect, ConstantWrench) for effect in effects):
            return scenario
        return replace(
            scenario, plant=replace(scenario.plant, effects=(*effects, ConstantWrench()))
        )

    def for_core(self, scenario: Scenario, start: FloatArray) -> dict[str, FloatArray]:
        """Return a row for each flight of every field of the core in which they differ.

        `start` holds the 18 numbers of the state near which all of them begin.
        """
        fields = scenario.plant.core_fields(scenario.vehicle)
        truth = scenario.plant.true_vehicle(scenario.vehicle)
        rows: dict[str, FloatArray] = {}
        for name, values in self.drawn.items():
            factor = values.reshape(self.flights, -1)
            if name in ("mass", "thrust_coefficient", "drag_coefficient"):
                rows[f"plant.vehicle.{name}"] = getattr(truth, name) * factor
            elif name == "inertia":
                rows["plant.vehicle.inertia"] = truth.inertia.reshape(1, 9) * factor
            elif name == "effectiveness":
                rows["plant.effectiveness"] = factor
            elif name == "centre_of_mass":
                hubs = truth.rotor_position - factor[:, np.newaxis, :]
                rows["plant.vehicle.position"] = hubs.reshape(self.flights, -1)
            elif name == "rotor_lag":
                for way, tau in fields["plant"]["rotor-lag"].items():
                    rows[f"plant.rotor-lag.{way}"] = tau * factor
            elif name == "noise":
                deviation = fields["measurement-noise"]["deviation"]
                rows["measurement-noise.deviation"] = deviation * factor
        if "force" in self.drawn or "torque" in self.drawn:
            nothing = np.zeros((self.flights, 3))
            push = np.hstack([self.drawn.get(name, nothing) for name in ("force", "torque")])
            others = fields["plant"].get("constant-wrench", {"constant": np.zeros(6)})
            rows["plant.constant-wrench.constant"] = others["constant"] + push
        starts = self._starts(start)
        rows |= {f"start.motion.{name}": starts[:, part] for name, part in PARTS_OF_STATE.items()}
        return {path: np.ascontiguousarray(numbers) for path, numbers in rows.items()}

    def _starts(self, start: FloatArray) -> FloatArray:
        """Return the (n, 18) states that the flights start from, near one of 18 numbers."""
        rows = np.tile(start, (self.flights, 1))
        for name, part in (("position", "p"), ("velocity", "v"), ("rate", "w")):
            rows[:, PARTS_OF_STATE[part]] += self.drawn.get(f"start_{name}", 0.0)
        if "start_attitude" in self.drawn:
            R = start[3:12].reshape(3, 3)
            for row, turn in zip(rows, self.drawn["start_attitude"], strict=True):
                row[3:12] = (R @ _core.rotation_exponential(turn)).reshape(9)
        return rows

    def of_flight(self, row: int) -> dict[str, object]:
        """Return the numbers of one flight, as JSON holds them."""
        return {name: values[row].tolist() for name, values in self.drawn.items()}


def numbers_of_a_flight(vary: Mapping[str, Any], vehicle: Vehicle) -> int:
    """Return how many numbers are drawn for each flight; unknown names count for nothing.

    Raises
    ------
    ScenarioError
        If what is asked for is no mapping.
    """
    if not isinstance(vary, Mapping):
        allowed = f"a mapping from some of {', '.join(VARIABLE)} to numbers"
        raise ScenarioError.at("fly_many", "vary", vary, allowed)
    known = [_PARAMETERS[name] for name in vary if name in _PARAMETERS]
    return sum(parameter.width or vehicle.n_rotors for parameter in known)


def draw(
    vary: Mapping[str, Distribution | ArrayLike], scenario: Scenario, seed: int, first: int, n: int
) -> Variation:
    """Draw what `vary` asks for, for flights first … first + n − 1.

    Raises
    ------
    ScenarioError
        If a parameter is not known or has no meaning for the plant, if an array does not have a row
        for each flight, or if a number makes an impossible vehicle; it names the flight.
    """
    effects = {effect.kind for effect in scenario.plant.effects}
    drawn = {}
    for name, wanted in vary.items():
        if name not in _PARAMETERS:
            raise ScenarioError.unknown_key("vary", str(name), str(name), VARIABLE)
        parameter = _PARAMETERS[name]
        if parameter.effect is not None and parameter.effect not in effects:
            allowed = f"left out, because plant {scenario.plant.name} has no {parameter.effect}"
            raise ScenarioError.at("vary", name, "given", allowed)
        width = parameter.width or scenario.vehicle.n_rotors
        values = _values(name, wanted, seed, first, n, width)
        refused = parameter.refuses(values).reshape(n, -1).any(axis=1)
        if refused.any():
            row = int(np.argmax(refused))
            place = f"vary, flight {first + row}"
            raise ScenarioError.at(place, name, values[row], parameter.allowed)
        drawn[name] = values
    return Variation(drawn, n)


def _values(
    name: str, wanted: Distribution | ArrayLike, seed: int, first: int, n: int, width: int
) -> FloatArray:
    """Return the numbers of one parameter, (n,) or (n, width)."""
    shape = (n,) if width == 1 else (n, width)
    ppf = getattr(wanted, "ppf", None)
    try:
        if ppf is not None:
            values = np.asarray(ppf(_shares(name, seed, first, shape)), dtype=np.float64)
        else:
            values = np.array(wanted, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):  # not numbers
        values = np.zeros(0)
    if values.shape != shape:
        what = "a distribution (om.Uniform, om.Normal, scipy.stats)"
        rows = f"{n} numbers" if width == 1 else f"{n} rows of {width} numbers"
        found = wanted if values.size == 0 else f"of shape {values.shape}"
        raise ScenarioError.at("vary", name, found, f"{what} or an array of {rows}")
    return values


def _shares(name: str, seed: int, first: int, shape: tuple[int, ...]) -> FloatArray:
    """Return numbers in (0, 1), each flight's own."""
    width = math.prod(shape[1:])
    bits = np.random.Philox(key=[seed, zlib.crc32(name.encode())])
    skipped = first * width  # one number each, four of them to a count of the generator
    bits.advance(skipped // 4)
    generator = np.random.Generator(bits)
    numbers = generator.random(skipped % 4 + math.prod(shape))[skipped % 4 :]
    return np.maximum(numbers, 2.0**-54).reshape(shape)
