"""Each case of `omnimorph verify`, by its name, and the machinery that runs them."""

from __future__ import annotations

import math

import pytest

from omnimorph.verification import CASES, Case, Result, run_cases
from omnimorph.verification.case import case, largest, order_of


@pytest.mark.parametrize("known", CASES, ids=lambda known: known.name)
def test_case(known: Case) -> None:
    result = known.run()
    shown = f"{result.value!r} {result.unit}, not {result.expected!r} ± {result.tolerance!r}"
    assert result.passed, f"{known.claim} Measured: {shown}."


def test_cases_are_named_once_and_say_what_they_claim() -> None:
    names = [known.name for known in CASES]
    assert len(set(names)) == len(names)
    for known in CASES:
        assert known.claim.endswith(".")
        assert known.source


@case("by hand")
def two_and_two() -> Result:
    """Two and two
    are four.

    Nobody doubts it.
    """
    return Result(value=2.0 + 2.0, expected=4.0, tolerance=0.0)


def test_a_case_is_made_of_a_function() -> None:
    assert two_and_two.name == "two-and-two"
    assert two_and_two.claim == "Two and two are four."
    assert two_and_two.source == "by hand"


def test_running_cases_tells_how_far_it_is() -> None:
    reported: list[tuple[int, int]] = []
    results = run_cases(
        progress=lambda done, of: reported.append((done, of)), cases=[two_and_two, CASES[0]]
    )
    assert reported == [(1, 2), (2, 2)]
    assert [result.name for result in results] == ["two-and-two", CASES[0].name]
    assert [result.claim for result in results] == [two_and_two.claim, CASES[0].claim]
    assert results[0].passed


@pytest.mark.parametrize(
    ("value", "passed"),
    [(1.0, True), (1.1, True), (0.9, True), (1.2, False), (math.nan, False), (math.inf, False)],
)
def test_a_result_passes_within_its_tolerance(value: float, passed: bool) -> None:
    assert Result(value=value, expected=1.0, tolerance=0.11).passed is passed


def test_largest_does_not_hide_what_is_not_a_number() -> None:
    assert largest([1.0, -3.0, 2.0]) == 3.0
    assert largest([]) == 0.0
    assert math.isnan(largest([1.0, math.nan, 2.0]))


def test_order_of_an_error_that_falls_with_the_cube() -> None:
    answers = [[1.0 + step**3, 2.0 - step**3] for step in (0.4, 0.2, 0.1)]
    assert order_of(answers) == pytest.approx(3.0)
