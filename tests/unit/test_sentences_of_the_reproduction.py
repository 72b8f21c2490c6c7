"""Sentences of the reproduction say the numbers that were found, and verdicts follow from them."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.unit.conftest import build_random_run
from tests.unit.reproduction_parts import (
    CLAIMS,
    LIMITS,
    SHOWN,
    TURN,
    W3,
    A,
    B,
    above_the_bound,
    flown,
    kept,
    listed_in,
    made_up_page,
    made_up_results,
    mean,
    text_of,
    values_of,
)

from omnimorph.protocols import FloatArray
from omnimorph.report.tables import number
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction import degraded, flight_claims, interference, page
from omnimorph.studies.reproduction.ablation import LESS, MORE, PERFECT
from omnimorph.studies.reproduction.flights import PaperFlights
from omnimorph.studies.reproduction.lost_thrust import NOT_LOST, POSE_KEPT
from omnimorph.studies.reproduction.rendering import render
from omnimorph.studies.reproduction.verdicts import Basis, Judged, Verdict, judge

FLIGHTS = made_up_results().flights
ANSWERS = flight_claims._ANSWERS


def numbers_of(text: str) -> list[str]:
    """Return the numbers of a sentence, in their order."""
    return re.findall(r"(?<![\w.])[−+-]?\d+(?:\.\d+)?(?:e−\d+)?", text)


def claimed(key: str) -> float:
    return CLAIMS[key].value or 0.0


# --- why ------------------------------------------------------------------------------------------


def test_what_makes_the_tilt_climb_and_the_errors_grow() -> None:
    found = made_up_results().ablation
    content = page.reasons(found, made_up_results().hypotheses)
    climbs, position, attitude, ratio = listed_in(render("reasons.html.j2", **content))
    tilt = {(one.group, one.label): mean(one.flown[A], "tilt_mean_deg") for one in found.conditions}
    ways = (
        (PERFECT, "nothing"),
        (PERFECT, "noise"),
        (LESS, "no measurement noise"),
        (MORE, "noise, filtered"),
    )
    assert numbers_of(climbs) == [f"{tilt[way]:.0f}" for way in ways]
    for text, metric in ((position, "position_error_mean_m"), (attitude, "attitude_error_paper")):
        own = [one for one in found.conditions if one.group != PERFECT]
        worst = sorted(own, key=lambda one: mean(one.flown[B], metric), reverse=True)[:3]
        places = [text.index(f"{one.label} (") for one in worst]
        assert places == sorted(places)
        for one in worst:
            shown = " and ".join(number(mean(one.flown[name], metric), 2) for name in (A, B))
            assert f"{one.label} ({shown}" in text
    ratios = [
        mean(one.flown[B], "position_error_mean_m") / mean(one.flown[A], "position_error_mean_m")
        for one in made_up_results().hypotheses[:2]
    ]
    theirs = claimed("position_error_b") / claimed("position_error_a")
    assert numbers_of(ratio) == [number(one, 2) for one in (*ratios, theirs)]


def test_the_summary_counts_and_names_what_it_says() -> None:
    judged = [
        judge("energy_order", basis=Basis.FLOWN, why="", command="", holds=False),
        judge("tracking_order", basis=Basis.FLOWN, why="", command="", holds=True),
        judge("acceleration_order", basis=Basis.FLOWN, why="", command="", holds=True),
    ]
    found = listed_in(render("key_points.html.j2", **page.summary(made_up_results(), judged)))
    points = {f"{head}.": text for head, _, text in (one.partition(". ") for one in found)}
    assert points["Verdicts."] == "Of 3 claims: 2 predicted and 1 contradicted."
    assert points["What does not hold."] == f"“{CLAIMS['energy_order'].text}”"
    near = [
        abs(mean(FLIGHTS.realistic[name], "drag_energy_paper") / claimed(key) - 1.0) <= 0.1
        for name, key in ((A, "drag_energy_a"), (B, "drag_energy_b"))
    ]
    assert f"{sum(near)} of 2" in points["Energies."]
    assert points["Errors."].endswith(
        "a conjecture explains 2 (rotor momentum and interference), a fit 6 (fitted)."
    )
    excess = [
        [above_the_bound(one.flown[name]) for one in made_up_results().tilt_choice.choices]
        for name in (A, B)
    ]
    largest = max(float(np.ptp(one)) for one in excess)
    assert f"by {100.0 * largest:.1f} percentage points" in points["The tilt."]


def test_what_is_an_artefact_is_reported_with_its_numbers() -> None:
    perfect = FLIGHTS.perfect[A].metrics
    assert perfect is not None
    ours, theirs = perfect.drag_energy_paper, claimed("drag_energy_a")
    near = abs(ours / theirs - 1.0) < 0.01
    where = "almost exactly the paper's" if near else "where the paper has"
    text = text_of(made_up_page())
    count = f"spends {number(ours)} in the paper's count, {where} {number(theirs, 5)}."
    assert count in text
    assert "or a noise of 1e−5 (m, m/s, rad, rad/s) is added." in text


# --- claims on flights ----------------------------------------------------------------------------


def ours(name: str, metric: str) -> float:
    return float(values_of(FLIGHTS.realistic[name], metric).mean())


def test_answers_say_the_numbers_of_the_flights() -> None:
    drag = {name: ours(name, "drag_energy_paper") for name in FLIGHTS.realistic}
    a, b, _, fixed_a, fixed_b = drag.values()
    fixed = 0.5 * (fixed_a + fixed_b)
    spin_up = {name: ours(name, "acceleration_energy_paper") for name in (B, W3)}
    error = {name: 1e3 * ours(name, "position_error_mean_m") for name in (A, B, W3)}
    sine = {name: 1e3 * ours(name, "attitude_error_paper") for name in (A, B)}
    shares = []
    for name in (A, B):
        own, other = (
            values_of(FLIGHTS.realistic[name], f"{kind}_energy_J")
            for kind in ("acceleration", "drag")
        )
        shares.append(f"{100.0 * float((own / (own + other)).mean()):.0f}")
    paper_saves = 1.0 - claimed("acceleration_energy_w3") / claimed("acceleration_energy_b")
    expected = {
        "energy_order": [
            *(f"{one:.0f}" for one in (b, fixed, a)),
            *(f"{a / b:.2f}", f"{claimed('drag_energy_a') / claimed('drag_energy_b'):.2f}"),
        ],
        "fixed_tilt_alike": [
            *(f"{one:.0f}" for one in (fixed_a, fixed_b)),
            f"{100.0 * abs(fixed_a / fixed_b - 1.0):.1f}",
        ],
        "tracking_order": [
            *(f"{error[name]:.2f}" for name in (A, B)),
            *(f"{sine[name]:.1f}e−3" for name in (A, B)),
        ],
        "acceleration_order": [f"{ours(name, 'acceleration_energy_paper'):.0f}" for name in (B, A)],
        "weight_on_change": [
            f"{100.0 - 100.0 * spin_up[W3] / spin_up[B]:.0f}",
            f"{100.0 * paper_saves:.0f}",
            *(f"{error[name]:.2f}" for name in (B, W3)),
        ],
        "acceleration_is_minor": shares,
    }
    for key, numbers in expected.items():
        assert numbers_of(ANSWERS[key](FLIGHTS).found) == numbers, key


def with_metrics(**by_metric: dict[str, float]) -> PaperFlights:
    """Return flights of which some metrics are these, by the name of the scenario."""
    changed: dict[str, list[FlightResult]] = {}
    for name, flights in FLIGHTS.realistic.items():
        wanted: dict[str, Any] = {
            metric: at[name] for metric, at in by_metric.items() if name in at
        }
        changed[name] = [
            one._replace(metrics=one.metrics and replace(one.metrics, **wanted)) for one in flights
        ]
    return replace(FLIGHTS, realistic=changed)


@pytest.mark.parametrize(
    ("key", "metrics"),
    [
        ("tracking_order", ("position_error_mean_m", "attitude_error_paper")),
        ("acceleration_order", ("acceleration_energy_paper",)),
    ],
)
def test_an_order_holds_the_way_the_paper_has_it(key: str, metrics: tuple[str, ...]) -> None:
    for low, high, holds in ((1.0, 2.0, True), (2.0, 1.0, False)):
        flights = with_metrics(**{metric: {A: low, B: high} for metric in metrics})
        assert ANSWERS[key](flights).holds is holds


def test_what_the_weight_on_change_saves_may_not_cost_an_error() -> None:
    for after, error, holds in ((0.5, 1.05, True), (2.0, 1.05, False), (0.5, 1.2, False)):
        flights = with_metrics(
            acceleration_energy_paper={B: 1.0, W3: after},
            position_error_mean_m={B: 1.0, W3: error},
        )
        assert ANSWERS["weight_on_change"](flights).holds is holds


def test_what_accelerates_is_minor_if_it_is_below_the_drag_in_joules() -> None:
    for share, holds in ((0.1, True), (1.5, False)):
        flights = with_metrics(
            acceleration_energy_J={A: share, B: share}, drag_energy_J={A: 1.0, B: 1.0}
        )
        assert ANSWERS["acceleration_is_minor"](flights).holds is holds


def test_fixed_tilts_are_alike_within_a_tenth_and_energies_in_order() -> None:
    a, b, _, fixed_a, fixed_b = FLIGHTS.realistic
    for other, alike in ((1.05, True), (1.2, False)):
        flights = with_metrics(drag_energy_paper={fixed_a: other, fixed_b: 1.0, a: 3.0, b: 0.5})
        assert ANSWERS["fixed_tilt_alike"](flights).holds is alike
        assert ANSWERS["energy_order"](flights).holds is True
    turned = with_metrics(drag_energy_paper={fixed_a: 1.0, fixed_b: 1.0, a: 0.5, b: 3.0})
    assert ANSWERS["energy_order"](turned).holds is False


def flights_at_known_tilts() -> tuple[PaperFlights, FloatArray]:
    """Level and upwards at 10°, level and sideways at 20°, not level at 30°; the start at 80°."""
    run = build_random_run(rows=70)
    time = np.linspace(0.0, 6.9, 70)
    level, aside = np.eye(3), np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])
    parts = np.repeat([0, 1, 2, 3, 0, 1, 2], 10)
    way = np.array([[0.0, 0.0, 0.5], [0.3, 0.0, 0.0], [0.2, 0.0, 0.2], [0.0, 0.4, 0.0]])[parts]
    tilt = np.array([10.0, 20.0, 30.0, 22.0])[parts]
    tilt[time < 1.0] = 80.0
    changed: Any = replace(
        run,
        time=time,
        desired_R_WB=np.where((parts == 2)[:, None, None], aside, level),
        desired_v_WB=way,
        tilt_actual=np.radians(tilt)[:, None],
    )
    return replace(FLIGHTS, runs={A: changed, B: changed}), tilt[time >= 5.0]


def test_the_tilt_is_reported_by_what_is_flown() -> None:
    flights, late = flights_at_known_tilts()
    of_b = ANSWERS["tilt_of_case_b"](flights)
    assert numbers_of(of_b.found) == ["10", f"{(20 + 20 + 22) / 3:.0f}", "30"]
    assert of_b.holds is True
    of_a = ANSWERS["tilt_of_case_a"](flights)
    reported = [5.0, late.min(), late.max(), late.mean(), 60.0]
    assert numbers_of(of_a.found) == [f"{one:.0f}" for one in reported]
    assert of_a.holds is False


def test_numbers_of_flights_are_judged_by_their_own_claim() -> None:
    found = flight_claims.judge_flights(flights_at_known_tilts()[0], made_up_results().hypotheses)
    judged = {one.claim.key: one for one in found}
    for key, one in judged.items():
        about = CLAIMS[key].about
        if "metric" not in about:
            continue
        flights = FLIGHTS.realistic[about["scenario"]]
        values = SHOWN[about["metric"]] * values_of(flights, about["metric"])
        assert (one.here, one.low, one.high) == pytest.approx(
            (values.mean(), values.min(), values.max())
        )
        assert one.found == "3 of 4 flights completed"
        if about["metric"] in ("position_error_mean_m", "attitude_error_paper"):
            case_a = key.endswith("_a")
            near = abs(one.here / (one.claim.value or 0.0) - 1.0) <= 0.1  # type: ignore[operator]
            named = "rotor momentum and interference" if case_a else "fitted"
            assert named in one.why
            expected = Verdict.CONJECTURED if case_a else Verdict.CALIBRATED
            assert one.verdict is (Verdict.PREDICTED if near else expected)
            value = number(one.claim.value, 3)
            assert f"{value} {one.claim.unit}".strip() in one.why


# --- claims on less thrust ------------------------------------------------------------------------


def test_losses_are_judged_by_both_criteria_at_both_limits() -> None:
    losses = made_up_results().degraded.losses
    judged = {one.claim.key: one for one in degraded._judge(losses)}
    for key in ("a_survives", "b_fails", "b_survives"):
        rows = [one for one in losses if one.key == key]
        reported = [
            f"at ±{one.speed_limit / TURN:.0f} Hz {kept(one.flown, NOT_LOST)} of {len(one.flown)} "
            f"are not lost, {kept(one.flown, POSE_KEPT)} keep the pose"
            for one in rows
        ]
        assert judged[key].found == "; ".join(reported)
    held = [one for one in losses if 2 * kept(one.flown, NOT_LOST) >= len(one.flown)]
    assert 0 < len(held) < len(losses)
    metrics = ("position_error_mean_m", "attitude_error_paper")
    distance, sine = (
        float(np.mean([mean(one.flown, metric) for one in held])) for metric in metrics
    )
    found = judged["position_most_affected"].found
    assert found == f"where it survives, {distance:.1f} mm and ‖e_R‖ {sine:.3f} on average"


@pytest.mark.parametrize(
    ("key", "at_170", "at_220", "verdict", "words"),
    [
        ("a_survives", "flies", "flies", Verdict.PREDICTED, "It holds at either"),
        ("a_survives", "lost", "lost", Verdict.CONTRADICTED, "It does not hold at either"),
        ("b_fails", "lost", "lost", Verdict.PREDICTED, "It holds at either"),
        ("a_survives", "lost", "flies", Verdict.CONJECTURED, "at ±220 Hz;"),
        ("b_fails", "lost", "flies", Verdict.CONJECTURED, "at ±170 Hz;"),
        ("b_survives", "strays", "strays", Verdict.ASSUMED, "At ±170 Hz and ±220 Hz it depends"),
        ("b_survives", "lost", "strays", Verdict.ASSUMED, "At ±220 Hz it depends"),
    ],
)
def test_a_claim_on_survival_follows_from_its_flights(
    key: str, at_170: str, at_220: str, verdict: Verdict, words: str
) -> None:
    fates = {
        "flies": flown(position_error_max_m=0.05, attitude_error_max_rad=0.1),
        "strays": flown(position_error_max_m=0.3),
        "lost": flown("lost"),
    }
    template = made_up_results().degraded.losses[0]
    losses = [
        replace(template, key=key, speed_limit=limit, flown=10 * [fates[fate]])
        for limit, fate in zip(LIMITS, (at_170, at_220), strict=True)
    ]
    judged: Judged = degraded._judge_loss(key, losses[::-1])
    assert judged.verdict is verdict
    assert words in judged.why


def test_forces_on_the_stand_are_judged_by_their_own_claim() -> None:
    found = made_up_results().experiment
    untilted, tilted = found.tests
    forces = {
        one.tilt: [r.thrust[r.time > r.time[-1] - 2.0].mean() for r in (one.alone, one.together)]
        for one in found.tests
    }
    judged = {one.claim.key: one for one in interference._judge(found.tests)}
    alone, together = forces[untilted.tilt]
    assert judged["force_alone"].here == pytest.approx(alone)
    assert judged["force_together"].here == pytest.approx(together)
    assert judged["loss_at_0"].here == pytest.approx(100.0 * (1.0 - together / alone))
    alone, together = forces[tilted.tilt]
    assert judged["loss_at_50"].here == pytest.approx(100.0 * (1.0 - together / alone))
    assert [one["tilt_deg"] for one in found.as_dict()["tests"]] == pytest.approx([0.0, 50.0])
    for one, data in zip(found.tests, found.as_dict()["tests"], strict=True):
        assert [data["force_alone_N"], data["force_together_N"]] == pytest.approx(forces[one.tilt])
        assert data["loss"] == pytest.approx(1.0 - forces[one.tilt][1] / forces[one.tilt][0])
