"""How claims of the paper are judged: by the rule of their kind, also where nothing came out."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

import omnimorph as om
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.flight_claims import judge_flights
from omnimorph.studies.reproduction.flights import SCENARIOS, PaperFlights
from omnimorph.studies.reproduction.hypotheses import CASES, Hypothesis
from omnimorph.studies.reproduction.verdicts import RULES, Basis, Verdict, judge, verdict_of

HOVER = om.fly(om.load_scenario("hover"))
LOST = FlightResult(replace(HOVER.metrics, outcome="lost"))


def test_every_claim_has_a_rule_that_is_stated() -> None:
    assert {claim.rule for claim in paper.claims().values()} == set(RULES)


@pytest.mark.parametrize(
    ("holds", "basis", "explained", "verdict"),
    [
        (True, Basis.DERIVED, None, Verdict.PREDICTED),
        (True, Basis.FLOWN, None, Verdict.PREDICTED),
        (True, Basis.CHOSEN, None, Verdict.CALIBRATED),
        (True, Basis.ASSUMED, None, Verdict.ASSUMED),
        (None, Basis.FLOWN, None, Verdict.ASSUMED),
        (False, Basis.DERIVED, None, Verdict.CONTRADICTED),
        (False, Basis.FLOWN, None, Verdict.NOT_EXPLAINED),
        (False, Basis.CHOSEN, None, Verdict.NOT_EXPLAINED),
        (False, Basis.FLOWN, Verdict.CONJECTURED, Verdict.CONJECTURED),
        (False, Basis.FLOWN, Verdict.CALIBRATED, Verdict.CALIBRATED),
    ],
)
def test_a_number_is_worth_what_it_rests_on(
    holds: bool | None, basis: Basis, explained: Verdict | None, verdict: Verdict
) -> None:
    assert verdict_of("number", holds, basis, explained) is verdict
    if holds is False and explained is None:
        assert verdict_of("order", holds, basis) is Verdict.CONTRADICTED


def test_a_number_is_judged_by_its_distance_whatever_its_sign_of_error() -> None:
    def verdict(here: float) -> Verdict:
        return judge("force_alone", here=here, basis=Basis.DERIVED, why="", command="").verdict

    assert [verdict(2.7 * share) for share in (0.91, 1.09)] == 2 * [Verdict.PREDICTED]
    assert [verdict(2.7 * share) for share in (0.89, 1.11)] == 2 * [Verdict.CONTRADICTED]
    assert verdict(math.nan) is Verdict.ASSUMED


def test_a_bound_must_allow_what_the_paper_allows() -> None:
    def verdict(here: float) -> Verdict:
        return judge("break_even_30", here=here, basis=Basis.DERIVED, why="", command="").verdict

    assert verdict(15.47) is Verdict.CONTRADICTED
    assert verdict(15.6) is Verdict.PREDICTED
    assert verdict(20.0) is Verdict.PREDICTED


def test_flights_of_which_none_was_completed_settle_nothing() -> None:
    lost = {name: [LOST, LOST] for name in SCENARIOS}
    flights = PaperFlights(
        seeds=range(2),
        runs={},
        realistic=lost,
        perfect={},
        without_momentum=lost,
        pose_only=lost,
        in_wakes=lost,
        variants=[],
    )
    only = {name: lost[name] for name in CASES}
    hypothesis = Hypothesis(label="lost", verdict=Verdict.CONJECTURED, against="", flown=only)
    assert hypothesis.objections == []
    rows = judge_flights(flights, [hypothesis])
    assert {row.verdict for row in rows} == {Verdict.ASSUMED}
    for row in rows:
        assert "nan" not in f"{row.found} {row.why} {row.sentence}"
