"""Each cell of the reproduction's tables is the number that its row and its column name.

What was found is made up, so that no two numbers agree.
"""

from __future__ import annotations

import math

import pytest
from tests.unit.reproduction_parts import (
    CLAIMS,
    LIMITS,
    NAMES,
    SHOWN,
    TURN,
    W3,
    WORDS,
    A,
    B,
    above_the_bound,
    assert_rows,
    made_up_page,
    made_up_results,
    mean,
    per_cent,
    shown,
    signed,
    table,
    text_of,
    values_of,
)

from omnimorph.report.tables import number
from omnimorph.studies.reproduction.lost_thrust import KINDS, POSE_KEPT

FLIGHTS = made_up_results().flights


# --- flights --------------------------------------------------------------------------------------


def test_energies() -> None:
    rows = []
    for case, name in (("a", A), ("b", B)):
        row = [f"the paper, {WORDS[name]}"]
        for kind, factor in (("drag", TURN), ("acceleration", TURN**2)):
            value = CLAIMS[f"{kind}_energy_{case}"].value or 0.0
            row += [number(value, 5), number(factor * value), "—"]
        rows.append(row)
    for name in NAMES:
        for words, group in (
            (WORDS[name], FLIGHTS.realistic),
            (f"{WORDS[name]}, no rotor momentum", FLIGHTS.without_momentum),
        ):
            row = [words]
            for kind in ("drag", "acceleration"):
                row += [shown(group[name], f"{kind}_energy_{count}") for count in ("paper", "J")]
                perfect = FLIGHTS.perfect[name].metrics
                row.append(number(getattr(perfect, f"{kind}_energy_paper")))
            rows.append(row)
    found = table("energy", FLIGHTS)
    assert_rows(found, rows, *found.head)
    assert [head.rsplit(" ", 1)[-1] for head in found.head[1:]] == 2 * ["(“J”)", "(J)", "(“J”)"]
    assert [head.split()[0] for head in found.head[1:]] == [
        *("rotor", "rotor", "perfect", "acceleration", "acceleration", "perfect"),
    ]


def test_errors() -> None:
    factors = {
        "position_error_mean_m": 1e3,
        "position_error_rms_m": 1e3,
        "attitude_error_paper": 1e3,
        "attitude_error_rms_rad": math.degrees(1.0),
    }
    rows = [
        [words, *(shown(group[name], metric, factor) for metric, factor in factors.items())]
        for name in NAMES
        for words, group in (
            (WORDS[name], FLIGHTS.realistic),
            (f"{WORDS[name]}, no rotor momentum", FLIGHTS.without_momentum),
        )
    ]
    found = table("errors", FLIGHTS)
    assert_rows(
        found,
        rows,
        "",
        "position error, mean (mm)",
        "position error, RMS (mm)",
        "‖e_R‖, mean (10⁻³)",
        "attitude error, RMS (°)",
    )


def test_plants_that_ought_to_agree() -> None:
    rows = []
    for words, one in zip(
        ("0.5 ms", "1 ms", "2 ms", "4 ms", "1 ms, tiny noise"), FLIGHTS.variants, strict=True
    ):
        a, b = one.run.metrics, one.b.metrics
        assert b is not None
        numbers = (a.drag_energy_paper, a.tilt_mean_deg, b.drag_energy_paper)
        rows.append([f"step {words}", *map(number, numbers)])
    assert_rows(
        table("variants", FLIGHTS),
        rows,
        "perfect plant",
        "Case A (“J”)",
        "its tilt, mean (°)",
        "Case B (“J”)",
    )


def test_still_air_and_wakes() -> None:
    metrics = (
        "drag_energy_paper",
        "tilt_mean_deg",
        "position_error_mean_m",
        "attitude_error_paper",
    )
    rows = []
    for name in NAMES:
        row = [WORDS[name]]
        for metric in metrics:
            still, wakes = (
                mean(group[name], metric) for group in (FLIGHTS.realistic, FLIGHTS.in_wakes)
            )
            row.append(f"{number(still, 3)} → {number(wakes, 3)}")
        rows.append(row)
    assert_rows(
        table("wakes", FLIGHTS),
        rows,
        "",
        "rotor drag energy (“J”)",
        "tilt, mean (°)",
        "position error, mean (mm)",
        "‖e_R‖, mean",
    )


def test_key_numbers() -> None:
    choice = made_up_results().tilt_choice
    rows = []
    for words, metric, claim in (
        ("rotor drag energy (“J”)", "drag_energy_paper", "drag_energy"),
        ("energy to accelerate the rotors (“J”)", "acceleration_energy_paper",
         "acceleration_energy"),
        ("position error, mean (mm)", "position_error_mean_m", "position_error"),
        ("‖e_R‖, mean", "attitude_error_paper", "attitude_error"),
    ):  # fmt: skip
        row = [words]
        for name, case in ((A, "a"), (B, "b")):
            ours = mean(FLIGHTS.realistic[name], metric)
            row += [number(ours, 3), number(CLAIMS[f"{claim}_{case}"].value, 5)]
        rows.append(row)
    for one in choice.choices:
        above = [signed(above_the_bound(one.flown[name])) for name in (A, B)]
        words = f"energy relative to the lower bound, {one.label} (%)"
        rows.append([words, above[0], "—", above[1], "—"])
    for limit in LIMITS:
        row = [f"largest loss of thrust with the pose kept, at ±{limit / TURN:.0f} Hz (%)"]
        for name in (A, B):
            (found,) = (
                one
                for one in made_up_results().degraded.frontiers
                if (one.scenario, one.kind, one.criterion, one.speed_limit)
                == (name, KINDS[0], POSE_KEPT, limit)
            )
            row += [" to ".join(f"{100.0 * end:.1f}" for end in found.bracket), "—"]
        rows.append(row)
    shown_table = table("key", made_up_results())
    assert_rows(shown_table, rows, "", "Case A, here", "the paper", "Case B, here", "the paper")


# --- why ------------------------------------------------------------------------------------------


def test_ablation_and_its_data() -> None:
    found = made_up_results().ablation
    rows = [
        [
            f"{one.group}: {one.label}",
            *(
                " / ".join(number(mean(one.flown[name], metric), 3) for name in (A, B))
                for metric in SHOWN
            ),
        ]
        for one in found.conditions
    ]
    assert_rows(
        table("ablation", found),
        rows,
        "",
        "tilt, mean (°)",
        "rotor drag energy (“J”)",
        "energy to accelerate (“J”)",
        "position error, mean (mm)",
        "position error, RMS (mm)",
        "‖e_R‖, mean",
    )
    data = found.as_dict()
    for one, reported in zip(found.conditions, data["conditions"], strict=True):
        assert (reported["group"], reported["label"]) == (one.group, one.label)
        for name in (A, B):
            for metric in SHOWN:
                expected = values_of(one.flown[name], metric)
                assert reported[name][metric]["mean"] == pytest.approx(expected.mean())
    assert data["lag"]["attitude_error"] == pytest.approx(0.21 * 13.0 / 43.0)
    assert data["lag"]["position_error_m"] == pytest.approx(0.31 * 1.7 / 43.0)


def test_a_reference_without_feed_forward() -> None:
    lag = made_up_results().ablation.lag
    rows = []
    for words, claim, metric, closed in (
        ("‖e_R‖", "attitude_error", "attitude_error_paper", 0.21 * 13.0 / 43.0),
        ("position (mm)", "position_error", "position_error_mean_m", 1e3 * 0.31 * 1.7 / 43.0),
    ):
        for name, case in ((A, "a"), (B, "b"), (W3, "w3")):
            claimed = CLAIMS[f"{claim}_{case}"].value or 0.0
            without = mean(FLIGHTS.pose_only[name], metric)
            rows.append(
                [
                    f"{words}, {WORDS[name]}",
                    number(claimed),
                    number(mean(FLIGHTS.without_momentum[name], metric), 3),
                    shown(FLIGHTS.pose_only[name], metric, SHOWN[metric]),
                    number(closed, 3),
                    per_cent(without / claimed - 1.0),
                ]
            )
    assert_rows(
        table("lag", lag, FLIGHTS),
        rows,
        "mean error",
        "the paper",
        "as stated",
        "no feed-forward",
        "closed form",
        "difference",
    )
    sines = [CLAIMS[f"attitude_error_{case}"].value or 0.0 for case in ("a", "b", "w3")]
    text = text_of(made_up_page())
    assert "it lags by the ratio of its gains, 0.21 s in attitude and 0.31 s in position." in text
    assert "0.21 s × 13 rad ÷ 43 s for the attitude, 0.31 s × 1.7 m ÷ 43 s for the pos" in text
    shortest, longest = (number(0.21 * 13.0 / f(sines), 3) for f in (max, min))
    assert f"attitude errors takes {shortest} to {longest} s, a second estimate" in text
