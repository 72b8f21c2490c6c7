"""The record of a flight: what it keeps, what it refuses."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from omnimorph.errors import InputError
from omnimorph.results.run import Outcome, Run


def test_run_is_read_only_but_leaves_the_arrays_it_was_given_alone(
    random_run: Callable[..., Run],
) -> None:
    run = random_run()
    with pytest.raises(ValueError, match="read-only"):
        run.p_WB[0, 0] = 1.0
    given = np.zeros((20, 3))
    kept = dataclasses.replace(run, p_WB=given)
    given[0, 0] = 1.0
    assert kept.p_WB[0, 0] == 1.0


def test_run_refuses_columns_of_another_shape(random_run: Callable[..., Run]) -> None:
    with pytest.raises(
        InputError, match=r"shape of thrust_command is \(20, 7\), but it must be \(20, 8\)"
    ):
        dataclasses.replace(random_run(), thrust_command=np.zeros((20, 7)))
    with pytest.raises(InputError, match="number of rows is 0"):
        random_run(rows=0)


@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [
        ("seed", -1, "an integer from 0 to"),
        ("flight", 2**64, "an integer from 0 to"),
        ("seed", 1.5, "an integer from 0 to"),
        ("scenario_name", "null\0", "text of Unicode characters without a null"),
        ("scenario_text", "half a pair \ud800", "text of Unicode characters"),
        ("version", 1, "text of Unicode characters"),
    ],
)
def test_provenance_refuses_what_cannot_be_stored(
    name: str, value: Any, allowed: str, random_run: Callable[..., Run]
) -> None:
    with pytest.raises(InputError, match=f"{name} is .* but it must be {allowed}"):
        dataclasses.replace(random_run().provenance, **{name: value})


@pytest.mark.parametrize("value", [0.0, float("nan"), -0.001])
def test_provenance_refuses_periods_that_are_none(
    value: float, random_run: Callable[..., Run]
) -> None:
    with pytest.raises(InputError, match="physics_step is"):
        dataclasses.replace(random_run().provenance, physics_step=value)


def test_every_outcome_is_a_sentence() -> None:
    for outcome in Outcome:
        assert outcome.value[0].isupper()
        assert outcome.value.endswith(".")


def test_run_shows_what_it_is(random_run: Callable[..., Run]) -> None:
    assert repr(random_run()) == "Run('paper-case-a', lost after 0.019 s, 20 rows)"
