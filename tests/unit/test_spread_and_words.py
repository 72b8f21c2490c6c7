"""Numbers over seeds: intervals against closed forms, and how the page writes them."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from scipy.stats import binomtest, t

import omnimorph as om
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction.printed_matrix import as_text, factors_of
from omnimorph.studies.reproduction.spread import Spread, share_interval, spread_of
from omnimorph.studies.reproduction.verdicts import range_text
from omnimorph.studies.reproduction.wording import difference_text, spread_text

ONE = om.fly(om.load_scenario("hover")).metrics


def flown(*tilts: float, lost: int = 0) -> list[FlightResult]:
    completed = [FlightResult(replace(ONE, tilt_mean_deg=tilt)) for tilt in tilts]
    return completed + lost * [FlightResult(replace(ONE, tilt_mean_deg=1e9, outcome="lost"))]


def test_the_interval_is_students() -> None:
    found = spread_of(flown(1.0, 2.0, 4.0), "tilt_mean_deg", 10.0)
    deviation = math.sqrt((4 / 3) ** 2 + (1 / 3) ** 2 + (5 / 3) ** 2) / math.sqrt(2)
    assert found.mean == pytest.approx(70 / 3)
    assert (found.low, found.high) == (10.0, 40.0)
    assert found.half_width == pytest.approx(10 * t.ppf(0.975, 2) * deviation / math.sqrt(3))


def test_flights_that_were_lost_are_counted_and_not_averaged() -> None:
    found = spread_of([*flown(3.0, lost=2), FlightResult(None, "refused.")], "tilt_mean_deg")
    assert (found.mean, found.flights, found.completed) == (3.0, 4, 1)
    assert math.isnan(found.half_width)
    nothing = spread_of(flown(lost=2), "tilt_mean_deg")
    assert math.isnan(nothing.mean)
    assert spread_text(nothing) == "none of 2"


@pytest.mark.parametrize(("met", "of"), [(0, 10), (3, 10), (10, 10), (1, 2)])
def test_the_interval_of_a_share_is_wilsons(met: int, of: int) -> None:
    expected = binomtest(met, of).proportion_ci(method="wilson")
    assert share_interval(met, of) == pytest.approx((expected.low, expected.high), abs=1e-12)


@pytest.mark.parametrize(
    ("spread", "text"),
    [
        (Spread(1736.5, 1708.8, 1764.3, 12.3, 20, 20), "1736 ± 12 (1709 … 1764)"),
        (Spread(0.0655, 0.0654, 0.0655, 1e-5, 5, 4), "0.06550 ± 0.00001 (0.06540 … 0.06550)"
         ", 4 of 5"),
        (Spread(-3.0, -3.0, -3.0, math.nan, 2, 1), "−3, 1 of 2"),
    ],
)  # fmt: skip
def test_spreads_in_words(spread: Spread, text: str) -> None:
    assert spread_text(spread) == text


def test_differences_in_words() -> None:
    assert difference_text(0.0) == "none"
    assert difference_text(None) == "—"
    assert difference_text(-0.98) == "50 × smaller"
    assert difference_text(0.056) == "+5.6 %"
    assert range_text(math.nan, math.nan, math.nan) == "—"


def test_formulas_go_there_and_back() -> None:
    for text in ("-Lc + ks", "Lc - ks", "s", "-c", "0", "-Ls - kc"):
        assert factors_of(as_text(factors_of(text)).replace("−", "-").replace("κ", "k").replace(
            "L ", "L").replace("k ", "k")) == factors_of(text)  # fmt: skip
