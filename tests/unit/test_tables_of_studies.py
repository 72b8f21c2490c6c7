"""Tables of hypotheses, less thrust and the choice of the tilt: each cell is what was found."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.reproduction_parts import (
    CLAIMS,
    LOSSES,
    SHOWN,
    TURN,
    W3,
    WORDS,
    A,
    B,
    above_the_bound,
    assert_rows,
    bound_J,
    kept,
    made_up_page,
    made_up_results,
    mean,
    shown,
    signed,
    table,
    text_of,
    values_of,
)

from omnimorph.report.tables import number
from omnimorph.studies.reproduction.lost_thrust import NOT_LOST, POSE_KEPT
from omnimorph.studies.reproduction.spread import spread_of
from omnimorph.studies.reproduction.wording import mean_text

FLIGHTS = made_up_results().flights


def test_hypotheses_and_what_speaks_against_them() -> None:
    found = made_up_results().hypotheses
    keys = [
        f"{kind}_error_{case}" for kind in ("position", "attitude") for case in ("a", "b", "w3")
    ]
    claims = [CLAIMS[key] for key in keys]
    factor = [1.0 if one.unit == "mm" else 1e3 for one in claims]
    theirs = [number(k * (one.value or 0.0), 3) for k, one in zip(factor, claims, strict=True)]
    rows, against = [["the paper", *theirs, "", ""]], []
    for one, within, standing, said in zip(
        found,
        (None, 2, 0, 6),
        ("as stated", "conjectured", "conjectured", "calibrated"),
        ("", "it is only half said", "nobody says so", "it was fitted"),
        strict=True,
    ):
        cells, near = [], 0
        for claim, k in zip(claims, factor, strict=True):
            flights = one.flown[claim.about["scenario"]]
            own = spread_of(flights, claim.about["metric"], SHOWN[claim.about["metric"]])
            cells.append(mean_text(own, k))
            near += abs(own.mean / (claim.value or 0.0) - 1.0) <= 0.1
        assert within in (None, near)
        rows.append([one.label, *cells, f"{near} of 6", standing])
        a, b = (mean(one.flown[name], "position_error_mean_m") for name in (A, B))
        third, second = (mean(one.flown[name], "attitude_error_paper") for name in (W3, B))
        reported = [said] if said else []
        if third > second:
            reported.append("‖e_R‖ of the third flight is above Case B's, and the paper's is below")
        off = [
            mean(one.flown[name], "drag_energy_paper") / (CLAIMS[f"drag_energy_{case}"].value or 0)
            for name, case in ((A, "a"), (B, "b"))
        ]
        energies = " and ".join(f"{100.0 * share - 100.0:+.0f} %" for share in off)
        reported.append(f"energies {energies} off the paper's in Cases A and B".replace("-", "−"))
        against.append([one.label, number(b / a, 2), "; ".join(reported)])
        data = one.as_dict()
        assert (data["explained"], data["objections"]) == (near, reported)
        assert data["ratio_of_position_errors"] == pytest.approx(b / a)
    assert_rows(
        table("hypotheses", found),
        rows,
        "",
        "A (mm)",
        "B (mm)",
        "W3 × 10 (mm)",
        "‖e_R‖, A (10⁻³)",
        "‖e_R‖, B (10⁻³)",
        "‖e_R‖, W3 × 10 (10⁻³)",
        "within 10 %",
        "verdict",
    )
    assert_rows(table("objections", found), against, "", "position error, B over A", "against it")


# --- less thrust ----------------------------------------------------------------------------------


def test_losses_and_their_data() -> None:
    found = made_up_results().degraded
    rows = []
    for one, data in zip(found.losses, found.as_dict()["losses"], strict=True):
        n = len(one.flown)
        shares = [[kept(one.flown, criterion), n] for criterion in (NOT_LOST, POSE_KEPT)]
        rows.append(
            [
                f"{WORDS[one.scenario]}, {CLAIMS[one.key].about['loss_percent']:g} % less",
                f"±{one.speed_limit / TURN:.0f}",
                *(f"{met} of {of}" for met, of in shares),
                shown(one.flown, "position_error_mean_m", 1e3),
                shown(one.flown, "attitude_error_paper"),
            ]
        )
        assert [data["not_lost"], data["pose_kept"]] == shares
        assert data["speed_limit_Hz"] == pytest.approx(one.speed_limit / TURN)
        for metric in ("position_error_mean_m", "attitude_error_paper"):
            assert data[metric]["mean"] == pytest.approx(values_of(one.flown, metric).mean())
    assert_rows(
        table("losses", found),
        rows,
        "",
        "speed limit (Hz)",
        "not lost",
        "pose kept",
        "position error, mean (mm)",
        "‖e_R‖, mean",
    )


def test_frontiers_and_dead_rotors_and_their_data() -> None:
    found = made_up_results().degraded
    data = found.as_dict()
    rows = []
    for one, reported in zip(found.frontiers, data["frontiers"], strict=True):
        low, high = one.bracket
        rows.append(
            [
                f"{WORDS[one.scenario]}, {one.kind}",
                one.criterion,
                f"±{one.speed_limit / TURN:.0f}",
                f"{100.0 * low:.1f} to {100.0 * high:.1f}",
                f"{100.0 * one.physical_limit:.1f}",
            ]
        )
        assert reported["bracket"] == [low, high]
        assert reported["survived"] == [[x, *one.survived[x]] for x in (0.2, 0.4, 0.6)]
        assert (reported["criterion"], reported["kind"]) == (one.criterion, one.kind)
        assert reported["physical_limit"] == one.physical_limit
        assert reported["speed_limit_Hz"] == pytest.approx(one.speed_limit / TURN)
    assert_rows(
        table("frontier", found),
        rows,
        "",
        "criterion",
        "speed limit (Hz)",
        "largest loss (%)",
        "physical limit (%)",
    )
    dead = [
        [f"{WORDS[name]}, {criterion}", *(f"{met} of {of}" for met, of in shares)]
        for (name, criterion), shares in found.dead.items()
    ]
    assert_rows(table("dead", found), dead, "", *(f"rotor {k}" for k in range(8)))
    reported = [(one["scenario"], one["criterion"], one["shares"]) for one in data["dead_rotor"]]
    assert reported == [(*key, [list(one) for one in shares]) for key, shares in found.dead.items()]
    expected = ("Case A with 35 % less", "Case B with 35 % less", "Case B with 30 % less")
    healthy = "Errors with less thrust (solid) beside the healthy flights (dotted): "
    assert f"{healthy}{', '.join(expected)}." in text_of(made_up_page())
    assert list(made_up_results().degraded_runs) == list(LOSSES)


# --- choosing the tilt ----------------------------------------------------------------------------


def test_methods_to_choose_the_tilt_and_their_data() -> None:
    found = made_up_results().tilt_choice
    data = found.as_dict()
    rows = []
    for one, reported in zip(found.choices, data["choices"], strict=True):
        row = [one.label]
        for name in (A, B):
            flights = one.flown[name]
            row += [
                shown(flights, "drag_energy_paper"),
                f"{signed(above_the_bound(flights))} %",
                shown(flights, "tilt_mean_deg"),
                shown(flights, "position_error_mean_m", 1e3),
            ]
            assert reported[name]["relative_to_lower_bound"] == pytest.approx(
                above_the_bound(flights)
            )
            for metric in ("drag_energy_paper", "tilt_mean_deg", "position_error_mean_m"):
                expected = values_of(flights, metric).mean()
                assert reported[name][metric]["mean"] == pytest.approx(expected)
        rows.append(row)
    tilt = float(np.degrees(np.mean(found.lower_bound.tilt)))
    rows.append(["lower bound", *2 * [number(bound_J() / TURN), "", number(tilt, 3), ""]])
    assert_rows(
        table("tilt_choice", found),
        rows,
        "",
        *(
            f"{case}, energy (“J”)" if k == 0 else words
            for case in ("Case A", "Case B")
            for k, words in enumerate(
                ("", "relative to the lower bound", "tilt, mean (°)", "position error, mean (mm)")
            )
        ),
    )
    assert data["lower_bound"] == pytest.approx(
        {"drag_energy_J": bound_J(), "drag_energy_paper": bound_J() / TURN, "tilt_mean_deg": tilt}
    )


def test_gaps_and_their_data() -> None:
    found = made_up_results().tilt_choice
    rows = []
    for one, reported in zip(found.gaps, found.as_dict()["gaps"], strict=True):
        above = float(np.mean(one.gap > 0.01))
        median = float(np.quantile(one.gap, 0.5))
        words = f"{WORDS[one.scenario]}, {one.span}"
        rows.append([words, number(100.0 * median, 2), f"{100.0 * above:.1f}"])
        assert reported == {
            "scenario": one.scenario,
            "span": one.span,
            "median": pytest.approx(median),
            "mean": pytest.approx(np.mean(one.gap)),
            "share_above_1_percent": above,
            "largest": one.gap.max(),
        }
    assert_rows(
        table("gaps", found),
        rows,
        "beside",
        "median of its excess cost (%)",
        "steps that cost over 1 % more (%)",
    )
