"""What a flight writes to belongs to the flight: from Python it can be read, and no more."""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import omnimorph as om
from omnimorph import _core
from omnimorph.protocols import FloatArray
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.simulation.core_settings import core_settings_of
from omnimorph.simulation.plant import core_motion

HOVER = om.load_scenario("hover")


def columns_of_a_flight() -> dict[str, FloatArray]:
    flight = om.SteppedFlight(HOVER)
    flight.step()
    return dict(flight.columns)


def columns_of_a_run() -> dict[str, FloatArray]:
    run = om.fly(HOVER)
    return {name: getattr(run, name) for name in columns_of_a_flight()}


def columns_of_a_batch() -> dict[str, FloatArray]:
    run = om.fly_many(HOVER, 3, keep=[1]).runs[1]
    return {name: getattr(run, name) for name in columns_of_a_flight()}


@pytest.fixture(params=[columns_of_a_flight, columns_of_a_run, columns_of_a_batch])
def columns(request: pytest.FixtureRequest) -> dict[str, FloatArray]:
    """Columns whose flight is gone."""
    found: dict[str, FloatArray] = request.param()
    gc.collect()
    return found


def test_columns_cannot_be_taken_from_a_flight_under_way() -> None:
    flight = om.SteppedFlight(HOVER)
    for act in ("clear", "pop", "popitem", "update", "setdefault", "__setitem__", "__delitem__"):
        assert not hasattr(flight.columns, act)
    flight.step()
    whole = om.fly(HOVER)
    np.testing.assert_array_equal(flight.columns["p_WB"][:3], whole.p_WB[:3])


def test_columns_are_read_only_and_cannot_be_made_otherwise(columns: dict[str, FloatArray]) -> None:
    for name, column in columns.items():
        assert not column.flags.writeable, name
        with pytest.raises(ValueError, match="WRITEABLE"):
            column.flags.writeable = True
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 0
        owner = column
        while isinstance(owner.base, np.ndarray):
            owner = owner.base
        with pytest.raises(ValueError, match="own its data"):
            owner.resize((0,), refcheck=False)


def test_columns_outlive_their_flight(columns: dict[str, FloatArray]) -> None:
    kept = columns["p_WB"]
    columns.clear()
    gc.collect()
    np.testing.assert_array_equal(kept[0], HOVER.reference(0.0).p_WB)


def test_what_varies_is_copied_before_the_threads_start() -> None:
    """The factors a batch flies with are those it was given, whatever becomes of the array."""
    mass = np.array([0.9, 1.0, 1.1])
    varied = om.fly_many(HOVER, 3, vary={"mass": mass}, keep=[0])
    mass[:] = 5.0
    again = om.fly_many(HOVER, 3, vary={"mass": np.array([0.9, 1.0, 1.1])}, keep=[0])
    assert varied.runs[0].content_hash == again.runs[0].content_hash


# --- calls that nobody should make, and that must not end the interpreter -----------------------


@pytest.mark.parametrize(
    "changes",
    [
        {"steps": -1},
        {"steps": -(2**62)},
        {"steps": 2**62},
        {"steps": 2**31 + 1},
    ],
)
def test_rows_that_cannot_be_counted_are_refused(changes: dict[str, int]) -> None:
    parts = core_settings_of(HOVER).of_flight() | changes
    with pytest.raises(ValueError, match="a flight"):
        _core.new_flight(**parts, seed=0, flight=0, is_recorded=True)


def test_a_flight_without_a_step_between_commands_is_refused() -> None:
    parts = core_settings_of(HOVER)
    start = {
        "motion": core_motion(parts.start),
        "command": {"thrust": parts.thrust, "tilt": parts.tilt},
    }
    fields = HOVER.plant.core_fields(HOVER.vehicle)
    fields |= {"controller": parts.controller, "start": start, "control_every": 0}
    changed = parts.of_flight() | {"settings": _core.LoopSettings(fields)}
    with pytest.raises(ValueError, match="a flight"):
        _core.new_flight(**changed, seed=0, flight=0, is_recorded=True)


def test_a_flight_that_another_thread_flies_answers_nobody_else() -> None:
    """As many as get through fly one after the other, and the flight is as it would be alone."""
    long = replace(HOVER, reference=SegmentReference(np.zeros(3), np.eye(3), [Segment(60.0)]))
    flight = om.SteppedFlight(long)
    refused = []

    def fly() -> None:
        while not flight.is_over:
            flight.core.advance(1000)

    def ask() -> None:
        while not flight.is_over:
            flight.core.motion()

    def until_refused(call: Callable[[], None]) -> None:
        while True:
            try:
                return call()
            except RuntimeError as problem:
                refused.append(str(problem))

    threads = [
        threading.Thread(target=until_refused, args=(call,)) for call in (fly, fly, fly, ask)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(refused) == {"the flight is being flown in another thread"}
    assert flight.as_run().content_hash == om.fly(long).content_hash
