"""Claims, failures and provenance on the reproduction's page, and all of its tables, once each."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace
from typing import Any

import pytest
from tests.unit.reproduction_parts import (
    CLAIMS,
    WORDS,
    A,
    B,
    assert_rows,
    flown,
    made_up_page,
    made_up_results,
    table,
    table_text,
    text_of,
)

import omnimorph as om
from omnimorph.report.tables import number, plant_table, trajectory_table
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.many_flights import Job
from omnimorph.studies.reproduction import page
from omnimorph.studies.reproduction.design import CounterExample
from omnimorph.studies.reproduction.plan import Plan
from omnimorph.studies.reproduction.verdicts import Basis, judge

FLIGHTS = made_up_results().flights


def test_claims_stand_beside_what_was_found() -> None:
    judged = [
        judge("drag_energy_a", basis=Basis.FLOWN, why="Why one.", command="", here=1900.0,
              low=1880.0, high=1930.0),
        judge("hover_lost_at", basis=Basis.DERIVED, why="Why two.", command="", here=72.49),
        judge("energy_order", basis=Basis.FLOWN, why="Why three.", command="", found="A < B",
              holds=False),
    ]  # fmt: skip
    for row in judged:
        reported = row.as_dict()
        assert reported.pop("paper") == row.claim.value
        assert reported.pop("verdict") == row.verdict.value
        for key in ("key", "text", "where", "rule", "unit"):
            assert reported.pop(key) == getattr(row.claim, key)
        assert reported == {key: getattr(row, key) for key in reported}
        assert len(reported) == 8
    one, two, three = (row.claim.text for row in judged)
    expected = [
        [one, "number", "2081 “J”", "1900 (1880 … 1930) “J”", "−8.7 %", "predicted"],
        [two, "number", "72°", "72.49°", "+0.7 %", "predicted"],
        [three, "order", "", "A < B", "", "contradicted"],
    ]
    expected[0][2] = f"{number(CLAIMS['drag_energy_a'].value, 5)} “J”"
    assert_rows(
        table("claims", judged),
        expected,
        "the paper says",
        "rule",
        "its number",
        "here",
        "difference",
        "verdict",
    )


def test_examples_decide_between_two_conditions() -> None:
    examples = [
        CounterExample(
            tilt=math.radians(90.0), thrusts="all alike", paper=5, ours=6, condition="x"
        ),
        CounterExample(tilt=0.0, thrusts="none", paper=4, ours=4, condition="y"),
    ]
    design: Any = SimpleNamespace(examples=examples)
    assert_rows(
        table("examples", design),
        [
            ["90°", "all alike", "5", "6", "x", "counter-example"],
            ["0°", "none", "4", "4", "y", "agrees"],
        ],
        *("tilt", "thrusts", "rank F by the paper", "rank F", "it is higher if and only if", ""),
    )


def test_flights_that_were_not_completed_are_counted_by_scenario_and_end() -> None:
    hover, tour = (om.load_scenario(name) for name in ("hover", "tour"))
    lost = [flown("lost", duration_s=time) for time in (3.0, 1.5)]
    groups = {
        "one": [
            (Job(hover, 0), flown()),
            (Job(hover, 1), lost[0]),
            (Job(hover, 2), lost[1]),
            (Job(tour, 0), FlightResult(None, "refused")),
        ],
        "two": [(Job(tour, 1), flown("not_finite", duration_s=0.25))],
    }
    assert_rows(
        table("failed", page.failures(groups)),
        [
            ["one", "hover", "lost", "2 of 3", "1.5 … 3.0"],
            ["one", "tour", "refused", "1 of 1", "—"],
            ["two", "tour", "not finite", "1 of 1", "0.2 … 0.2"],
        ],
        *("flown for", "flight", "how it ended", "how many", "after (s)"),
    )


def test_provenance_names_what_was_flown() -> None:
    reported = {row[0]: row[1] for row in table("provenance", FLIGHTS).rows}
    for name in (A, B):
        run = FLIGHTS.runs[name]
        assert reported[f"{WORDS[name]}, content hash"] == run.content_hash
        assert reported[f"{WORDS[name]}, by itself"] == f"omnimorph fly {name} --seed {2**64 - 1}"
        assert reported[WORDS[name]] == f"scenario {name}, plant realistic, seed {2**64 - 1}"
    assert reported["omnimorph"] == "0.1.0"


@pytest.mark.parametrize("quick", [True, False])
def test_the_command_makes_the_same_page_again(quick: bool) -> None:
    usual = Plan.quickly() if quick else Plan.whole()
    words = "omnimorph reproduce --out reproduction" + (" --quick" if quick else "")
    assert page.command(usual) == words


def test_each_table_stands_on_the_page_once() -> None:
    found, flights = made_up_results(), FLIGHTS
    parts = [one.split("</caption>") for one in made_up_page().split("<caption>")[1:]]
    built = {
        text_of(caption): [
            [text_of(cell) for cell in re.split(r"</t[hd]>", row)[:-1]]
            for row in rows.split("</tr>")[:-1]
        ]
        for caption, rows in parts
    }
    assert len(built) == len(parts)
    expected = [
        table("key", found),
        *(table(name, flights) for name in ("energy", "errors", "variants", "wakes")),
        *(table(name, found.hypotheses) for name in ("hypotheses", "objections")),
        table("ablation", found.ablation),
        table("lag", found.ablation.lag, flights),
        *(table(name, found.degraded) for name in ("losses", "frontier", "dead")),
        *(table(name, found.tilt_choice) for name in ("gaps", "tilt_choice")),
        table("provenance", flights),
        trajectory_table(flights.runs[A]),
        plant_table(flights.runs[A]),
    ]
    for one in expected:
        rows = [[" ".join(cell.split()) for cell in row] for row in (one.head, *one.rows)]
        assert built[one.caption] == rows
    sources = flights.runs[A].vehicle.sources
    assumed = {name.replace("_", " ") for name, source in sources.items() if source.assumed}
    shown = [
        {row[0] for row in rows[1:]}
        for caption, rows in built.items()
        if caption.startswith(("Assumed", "Published"))
    ]
    assert shown[0] == assumed | {"speed max"}
    assert shown[1] == {name.replace("_", " ") for name in sources} - shown[0]
    metrics = next(rows for caption, rows in built.items() if caption.startswith("Errors, en"))
    assert metrics[0] == ["", "Case A", "Case B", "unit"]


def test_the_results_in_markdown_hold_the_same_tables() -> None:
    found = made_up_results()
    text = page.results_text(found, [], "the command")
    shown = [
        *(table_text(name, FLIGHTS) for name in ("energy", "errors")),
        *(table_text(name, found.hypotheses) for name in ("hypotheses", "objections")),
        *(table_text(name, found.degraded) for name in ("losses", "frontier")),
    ]
    places = [text.index(one) for one in shown]
    assert places == sorted(places)
    assert text.startswith("# The paper's claims beside what comes out here\n\nWritten by `the c")
    assert text.endswith(shown[-1])
    assert "\n\n\n" not in text


def test_a_bar_in_a_cell_stays_in_its_cell() -> None:
    design: Any = SimpleNamespace(
        examples=[CounterExample(tilt=0.0, thrusts="|f| = 1", paper=4, ours=4, condition="a | b")]
    )
    assert "| \\|f\\| = 1 | 4 | 4 | a \\| b |" in table_text("examples", design)
    assert table("examples", design).rows[0][1:5] == ["|f| = 1", "4", "4", "a | b"]
