"""What is no number is reported in a sentence wherever a user hands over numbers."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import omnimorph as om
from omnimorph.arrays import as_numbers
from omnimorph.simulation.fly import measurement_noise

NOT_NUMBERS: list[Any] = [
    "x",
    b"1.5",
    1 + 1j,
    [[1], [1, 2]],
    {"a": 1},
    object(),
    10**400,
    np.zeros(5),
]
NUMBERS = {
    "beside",
    "count",
    "deviation",
    "directions",
    "force",
    "high",
    "low",
    "mean",
    "moment",
    "R_WB",
    "share",
    "start_tilt",
    "thrust",
    "tilt",
    "up",
}
GOOD: dict[str, Any] = {
    "vehicle": "omnimorph",
    "gains": om.TrackingGains(),
    "thrust": np.ones(8),
    "tilt": 0.3,
    "tilts": [0.3],
    "up": [[0.0, 0.0, 1.0]],
    "directions": [[0.0, 0.0, 1.0]],
    "low": 0.0,
    "high": 1.0,
    "mean": 0.0,
    "deviation": 1.0,
    "zero_moment": False,
    "share": 0.1,
    "count": 3,
    "quantity": "hover_power",
    "rule": om.load_scenario("hover").allocator,
    "state": np.hstack([np.zeros(3), np.eye(3).reshape(9), np.zeros(6)])[None],
    "acceleration": np.zeros((1, 6)),
    "previous_thrust": np.zeros((1, 8)),
}
ROOMS: list[Any] = [om, om.analysis]


def doors() -> Iterator[Any]:
    """Yield the callable and the argument of all functions that take numbers from a user."""
    for room in ROOMS:
        for name in room.__all__:
            thing = getattr(room, name)
            if not inspect.isfunction(thing) and thing not in (om.Uniform, om.Normal):
                continue
            for argument in sorted(NUMBERS & inspect.signature(thing).parameters.keys()):
                yield pytest.param(thing, argument, id=f"{name}-{argument}")


@pytest.mark.parametrize(("door", "argument"), list(doors()))
def test_what_is_no_number_is_reported(door: Callable[..., Any], argument: str) -> None:
    arguments = inspect.signature(door).parameters
    given = {key: value for key, value in GOOD.items() if key in arguments}
    if door is om.cost_over_tilt:
        given |= {"tilt": [[0.3]]}
    door(**given)
    for wrong in NOT_NUMBERS:
        with pytest.raises(om.OmnimorphError) as caught:
            door(**given | {argument: wrong})
        assert "but it must be " in str(caught.value)


def test_there_are_doors() -> None:
    names = {parameter.id for parameter in doors()}
    assert {"hover-R_WB", "force_set-moment", "Uniform-low", "allocation_matrix-tilt"} <= names
    assert len(names) > 25


@pytest.mark.parametrize("wrong", [*NOT_NUMBERS, None, np.full(6, np.nan), np.zeros((6, 1))])
def test_a_push_that_is_no_wrench_is_reported(wrong: Any) -> None:
    flight = om.SteppedFlight("hover")
    with pytest.raises(om.InputError, match=r"the flight: push is .* six finite numbers"):
        flight.step(wrong)
    with pytest.raises(om.InputError, match=r"the flight: effectiveness is .* 8 shares"):
        flight.set_effectiveness(wrong)
    assert flight.time == 0.0
    flight.step([0, 0, 1, 0, 0, 0])  # as good as an array
    assert flight.time > 0.0


@pytest.mark.parametrize("argument", ["seed", "flight", "steps"])
def test_noise_of_no_flight_is_reported(argument: str) -> None:
    for wrong in (-1, 10**400, 1.5, "x"):
        with pytest.raises(om.InputError, match=rf"{argument} is .* an integer from 0 to"):
            measurement_noise(**{"seed": 0, "flight": 0, "steps": 1} | {argument: wrong})  # type: ignore[arg-type]


@pytest.mark.parametrize("wrong", [3, None, "x", [1]])
def test_gains_that_are_none_are_reported(wrong: Any) -> None:
    with pytest.raises(om.InputError, match=r"gains is .* a TrackingGains, or"):
        om.stability_margins(wrong, "omnimorph")


@pytest.mark.parametrize("wrong", [1, True, ["mass"], np.zeros((2, 2)), object()])
def test_variations_that_are_no_mapping_are_reported(wrong: Any) -> None:
    with pytest.raises(om.InputError, match=r"vary is .* a mapping from some of mass"):
        om.fly_many("hover", 2, vary=wrong)


def test_a_text_is_no_number() -> None:
    assert np.isnan(as_numbers("1.5"))
    assert np.isnan(as_numbers(["1.5", 2.0]))
