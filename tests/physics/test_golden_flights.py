"""Flights are what they were, to the last bit: alone, many at once, by hand, lost ones too.

Which they are is in `golden_flights`, which also writes their values anew.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.physics.golden_flights import FLIGHTS
from tests.physics.golden_values import differing, hash_of, kept_values, values_of

KEPT = kept_values()


def test_there_are_values_of_these_flights_and_of_no_other() -> None:
    assert list(KEPT) == list(FLIGHTS)


@pytest.mark.parametrize("name", FLIGHTS)
def test_the_flight_is_the_same_to_the_last_bit(name: str) -> None:
    assert differing(values_of(FLIGHTS[name]()), KEPT[name]) == []


# --- what is noticed ----------------------------------------------------------------------------


@pytest.mark.parametrize("column", ["p_WB", "tilt_actual", "cost", "active", "outcome"])
def test_one_bit_of_one_number_is_noticed_and_named(column: str) -> None:
    name = "9 rotors" if column != "tilt_actual" else "vehicle voliro"
    trace: dict[str, Any] = dict(FLIGHTS[name]()[0])
    if column == "outcome":
        trace[column] = "LOST"
    else:
        trace[column] = np.array(trace[column], dtype=np.float64)
        trace[column].flat[7] = np.nextafter(trace[column].flat[7], np.inf)
    assert differing(values_of([trace]), KEPT[name]) == [column]


def test_the_sign_of_a_zero_counts_and_that_of_what_is_no_number_does_not() -> None:
    assert hash_of([[0.0]]) != hash_of([[-0.0]])
    assert hash_of([[np.nan]]) == hash_of([[-np.nan]])


def test_a_flight_that_is_missing_in_a_batch_is_noticed() -> None:
    traces = FLIGHTS["9 rotors, many"]()
    assert len(differing(values_of(traces[:-1]), values_of(traces))) == len(traces[0]) - 1


def test_a_column_that_is_no_longer_there_is_named() -> None:
    assert differing({"p_WB": "1"}, {"p_WB": "1", "cost": "2"}) == ["cost"]
