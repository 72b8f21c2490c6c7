"""What the reproduction shows of its flights is theirs: made-up ones, of different numbers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from tests.unit.reproduction_parts import table

import omnimorph as om
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction.design import _counter_examples, _judge_conditions
from omnimorph.studies.reproduction.flights import PaperFlights, Variant
from omnimorph.studies.reproduction.spread import Spread
from omnimorph.studies.reproduction.verdicts import Verdict
from omnimorph.studies.reproduction.wording import FLIGHT_LABELS, spread_text

RUN = om.fly(om.load_scenario("hover"))
NAMES = list(FLIGHT_LABELS)
A, B = NAMES[:2]
GROUPS = ("realistic", "without_momentum", "pose_only", "in_wakes")


def flown(count: float) -> FlightResult:
    """A flight whose energies are known by one number."""
    return FlightResult(replace(RUN.metrics, drag_energy_paper=count, drag_energy_J=7.0 * count))


def made_up() -> PaperFlights:
    groups: dict[str, Any] = {
        group: {name: [flown(1000.0 * g + 100.0 * k + seed) for seed in (1, 3)]
                for k, name in enumerate(NAMES)}
        for g, group in enumerate(GROUPS, start=1)
    }  # fmt: skip
    return PaperFlights(
        seeds=range(2),
        runs={A: RUN},
        perfect={name: flown(50.0 + k) for k, name in enumerate(NAMES)},
        variants=[Variant(step=0.001, noise=0.0, run=RUN, b=flown(77.0))],
        **groups,
    )


def test_results_hold_each_flight_under_its_own_name() -> None:
    flights = made_up()
    shown = flights.as_dict()
    for g, group in enumerate(GROUPS, start=1):
        for k, name in enumerate(NAMES):
            spread = shown[group][name]["drag_energy_paper"]
            begin = 1000.0 * g + 100.0 * k
            assert (spread["mean"], spread["low"], spread["high"]) == (
                *(begin + 2.0, begin + 1.0, begin + 3.0),
            )
    for k, name in enumerate(NAMES):
        assert shown["perfect"][name]["drag_energy_paper"]["mean"] == 50.0 + k
    (variant,) = shown["variants"]
    assert variant[A] == RUN.metrics.as_dict()
    assert variant[B]["drag_energy_paper"] == 77.0
    assert shown["content_hash"] == {A: RUN.content_hash}


def test_energies_stand_in_the_row_of_their_flight_and_in_their_unit() -> None:
    flights = made_up()
    rows = {row[0]: row[1:] for row in table("energy", flights).rows}
    for k, words in enumerate(FLIGHT_LABELS.values()):
        for row, begin in ((words, 1000.0), (f"{words}, no rotor momentum", 2000.0)):
            mean = begin + 100.0 * k + 2.0
            count, joules, perfect = (cell.split()[0] for cell in rows[row][:3])
            assert float(count) == mean
            assert float(joules) == pytest.approx(7.0 * mean, abs=5.0)
            assert float(perfect) == 50.0 + k


def test_a_spread_is_shown_in_the_unit_of_its_factor() -> None:
    spread = Spread(0.001234, 0.00119, 0.00128, 0.000021, 20, 20)
    assert spread_text(spread, 1e3) == "1.23 ± 0.02 (1.19 … 1.28)"


def test_verdicts_on_the_design_follow_from_what_was_found() -> None:
    vehicle = om.load_vehicle("omnimorph")
    found = _judge_conditions(vehicle, _counter_examples(vehicle))
    judged = {one.claim.key: one for one in found}
    drag = judged["roll_from_drag"]
    assert "its roll and pitch rows 2" in drag.found
    assert drag.verdict is Verdict.CONTRADICTED
    for key in ("full_rank_at_0", "full_rank_at_90"):
        wrong = "not" in judged[key].found
        assert judged[key].verdict is (Verdict.CONTRADICTED if wrong else Verdict.PREDICTED)
