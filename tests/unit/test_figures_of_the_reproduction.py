"""The figures of the reproduction draw what was found, under the name of what it was found for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.unit.drawn import curves_of, levels_of, panels_of, xy
from tests.unit.reproduction_parts import (
    CLAIMS,
    LIMITS,
    NAMES,
    SHOWN,
    TURN,
    WORDS,
    A,
    B,
    bound_J,
    made_up_results,
    values_of,
)

from omnimorph.protocols import FloatArray
from omnimorph.results import curves
from omnimorph.studies.reproduction.figures import page
from omnimorph.studies.reproduction.figures.ablation import draw_ablation
from omnimorph.studies.reproduction.figures.flights import (
    degraded_flights,
    energy_rows,
    paper_means,
    variant_flights,
)
from omnimorph.studies.reproduction.figures.frontier import frontier
from omnimorph.studies.reproduction.figures.line_styles import LINE_STYLES
from omnimorph.studies.reproduction.figures.stand import stand
from omnimorph.studies.reproduction.figures.tilt_choice import (
    cost_gaps,
    energy_by_choice,
    tilt_by_choice,
)
from omnimorph.studies.reproduction.lost_thrust import KINDS, NOT_LOST, POSE_KEPT
from omnimorph.studies.reproduction.spread import share_interval

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CASES = {WORDS[A]: A, WORDS[B]: B}
FLIGHTS = made_up_results().flights


def dots_of(panel: Axes, mark: str, colour: str) -> FloatArray:
    """Return the values across at the unconnected marks of a kind and colour, from above."""
    lines = [one for one in panel.lines if (one.get_marker(), one.get_color()) == (mark, colour)]
    points = [xy(line) for line in lines if line.get_linestyle() == "None" or len(xy(line)) == 1]
    found = np.concatenate(points)
    across: FloatArray = found[np.argsort(found[:, 1], kind="stable"), 0]
    return across


# --- studies --------------------------------------------------------------------------------------


def test_ablation() -> None:
    found = made_up_results().ablation
    axes = draw_ablation(found).axes
    metrics = (
        "tilt_mean_deg",
        "drag_energy_paper",
        "position_error_mean_m",
        "attitude_error_paper",
    )
    keys = (None, "drag_energy", "position_error", "attitude_error")
    for panel, metric, key in zip(axes, metrics, keys, strict=True):
        for name, mark in ((A, "o"), (B, "s")):
            flown = [SHOWN[metric] * values_of(one.flown[name], metric) for one in found.conditions]
            drawn = dots_of(panel, mark, LINE_STYLES[name].colour)
            np.testing.assert_allclose(drawn, [values.mean() for values in flown], rtol=1e-9)
            ranges = [line for line in panel.lines if line.get_alpha() == 0.4]
            ends = np.concatenate(
                [xy(one)[:, 0] for one in ranges if one.get_color() == LINE_STYLES[name].colour]
            )
            expected = [[values.min(), values.max()] for values in flown]
            np.testing.assert_allclose(ends[np.isfinite(ends)].reshape(-1, 2), expected)
        dashed = {one.get_color(): xy(one)[0, 0] for one in panel.lines if one.is_dashed()}
        assert dashed == (
            {
                LINE_STYLES[A].colour: CLAIMS[f"{key}_a"].value,
                LINE_STYLES[B].colour: CLAIMS[f"{key}_b"].value,
            }
            if key
            else {}
        )
    names = [tick.get_text() for tick in axes[0].get_yticklabels()]
    assert [one for one in names if one in {row.label for row in found.conditions}] == [
        one.label for one in found.conditions
    ]


def test_stand() -> None:
    found = made_up_results().experiment
    speeds, *tests = stand(found).axes
    alone, others = (xy(line)[:, 1] for line in speeds.lines)
    assert (alone.max(), others.max()) == (pytest.approx(120.0), pytest.approx(72.0))
    claimed = {key: CLAIMS[key].value or 0.0 for key in ("force_alone", "force_together")}
    share = (CLAIMS["loss_at_50"].value or 0.0) / 100.0
    levels = (
        list(claimed.values()),
        [claimed["force_alone"], claimed["force_alone"] * (1.0 - share)],
    )
    for panel, one, at, tilt in zip(tests, found.tests, levels, ("0°", "50°"), strict=True):
        assert panel.get_title(loc="left") == f"tilt {tilt}"
        for (_, points), reading in zip(curves_of(panel), (one.alone, one.together), strict=False):
            settled = reading.time >= 0.5
            assert points[:, 1].mean() == pytest.approx(reading.thrust[settled].mean(), rel=1e-2)
            assert points[0, 0] >= 0.5, "the rotors turn"
        assert [xy(line)[0, 1] for line in panel.lines[2:]] == pytest.approx(at)
    words = [text.get_text() for panel in tests for text in panel.texts]
    assert words == [
        "the paper: 2.7 N",
        "the paper: 1.8 N",
        "the paper: 2.7 N",
        "the paper: 7 % less",
    ]


def test_frontiers_and_dead_rotors() -> None:
    found = made_up_results().degraded
    *panels, dead = panels_of(frontier(found))
    titles = [f"{kind}: {criterion}" for kind in KINDS for criterion in (NOT_LOST, POSE_KEPT)]
    assert [panel.get_title(loc="left") for panel in panels] == titles
    for panel in panels:
        kind, criterion = panel.get_title(loc="left").split(": ")
        shown = [one for one in found.frontiers if (one.kind, one.criterion) == (kind, criterion)]
        drawn_as = zip(panel.lines, panel.collections, panel.containers, strict=False)
        for one, (line, bars, named) in zip(shown, drawn_as, strict=True):
            losses = sorted(one.survived)
            shares = [one.survived[loss] for loss in losses]
            np.testing.assert_allclose(xy(line)[:, 0], 100.0 * np.array(losses))
            np.testing.assert_allclose(xy(line)[:, 1], [100.0 * met / n for met, n in shares])
            ends = [share_interval(*share) for share in shares]
            drawn = np.array(bars.get_segments())[:, :, 1]  # type: ignore[attr-defined]
            np.testing.assert_allclose(drawn, 100.0 * np.array(ends), atol=1e-9)
            assert line.get_color() == LINE_STYLES[one.scenario].colour
            assert line.is_dashed() == (one.speed_limit == LIMITS[1])
            words = f"{WORDS[one.scenario]}, ±{one.speed_limit / TURN:.0f} Hz"
            assert named.get_label() == words
        limits = {
            text.get_text(): xy(line)[0, 0]
            for text, line in zip(panel.texts, panel.lines[len(shown) :], strict=True)
        }
        assert limits == pytest.approx(
            {f"±{one.speed_limit / TURN:.0f} Hz": 100.0 * one.physical_limit for one in shown}
        )
    for ((name, criterion), shares), line, named in zip(
        found.dead.items(), dead.lines, dead.containers, strict=True
    ):
        assert named.get_label() == f"{WORDS[name]}, {criterion}"
        assert (line.get_color(), line.get_marker()) == (
            LINE_STYLES[name].colour,
            "o" if criterion == NOT_LOST else "D",
        )
        np.testing.assert_allclose(xy(line)[:, 1], [100.0 * met / n for met, n in shares])


def test_tilts_and_energies_by_the_choice() -> None:
    found = made_up_results().tilt_choice
    for panel, (case, name) in zip(panels_of(tilt_by_choice(found)), CASES.items(), strict=True):
        assert panel.get_ylabel() == f"{case}\ntilt (°)"
        drawn = dict(curves_of(panel))
        for one in found.choices:
            tilt = np.degrees(one.runs[name].tilt_actual[:, 0])
            np.testing.assert_allclose(drawn[one.label][:, 1], tilt)
        bound = found.lower_bound
        at, tilt = drawn["lower bound"].T
        np.testing.assert_allclose(tilt, np.degrees(np.interp(at, bound.time, bound.tilt)))
    (panel,) = energy_by_choice(found).axes
    for name, mark in ((A, "o"), (B, "s")):
        means = [values_of(one.flown[name], "drag_energy_paper").mean() for one in found.choices]
        np.testing.assert_allclose(dots_of(panel, mark, LINE_STYLES[name].colour), means)
    (bound_line,) = (line for line in panel.lines if line.is_dashed())
    assert xy(bound_line)[0, 0] == pytest.approx(bound_J() / TURN)
    assert [tick.get_text() for tick in panel.get_yticklabels()] == [
        one.label for one in found.choices
    ]


def test_gaps() -> None:
    found = made_up_results().tilt_choice
    (panel,) = cost_gaps(found.gaps).axes
    for one, line in zip(found.gaps, panel.lines, strict=True):
        assert line.get_label() == f"{WORDS[one.scenario]}: to {one.span}"
        assert line.get_color() == LINE_STYLES[one.scenario].colour
        x, share = xy(line).T
        for k in (0, 150, 250):
            assert share[k] == pytest.approx(100.0 * (one.gap > x[k] / 100.0).mean(), abs=0.3)


# --- flights --------------------------------------------------------------------------------------


def test_energies_of_each_flight() -> None:
    rows = {one.label: one for one in energy_rows(FLIGHTS)}
    assert len(rows) == len(NAMES)
    for name in NAMES:
        row = rows[WORDS[name]]
        np.testing.assert_array_equal(
            row.values, values_of(FLIGHTS.realistic[name], "drag_energy_paper")
        )
        perfect = FLIGHTS.perfect[name].metrics
        assert perfect is not None
        assert row.perfect == perfect.drag_energy_paper
        claimed = [
            one.value
            for one in CLAIMS.values()
            if dict(one.about) == {"scenario": name, "metric": "drag_energy_paper"}
        ]
        assert row.paper == (claimed[0] if claimed else None)
        assert row.line_style == LINE_STYLES[name]


def test_the_papers_means_are_in_the_look_of_their_case() -> None:
    for (label, distance, sine, line_style), (case, name), key in zip(
        paper_means(), CASES.items(), "ab", strict=True
    ):
        assert label == f"the paper's mean, {case}"
        assert line_style == LINE_STYLES[name]
        assert distance == CLAIMS[f"position_error_{key}"].value
        assert sine == CLAIMS[f"attitude_error_{key}"].value


def test_variants_and_degraded_flights_are_named_by_what_they_are() -> None:
    shown = variant_flights(FLIGHTS)
    assert [one.label for one in shown] == ["0.5 ms", "1 ms", "2 ms", "4 ms", "1 ms, noise"]
    assert [one.run for one in shown] == [one.run for one in FLIGHTS.variants]
    degraded = degraded_flights(made_up_results())
    runs: list[Any] = []
    for key, run in made_up_results().degraded_runs.items():
        case = CLAIMS[key].about["scenario"]
        runs += [(f"{WORDS[case]}, {CLAIMS[key].about['loss_percent']:g} % less", run)]
        runs += [(f"{WORDS[case]}, healthy", FLIGHTS.runs[case])]
    assert [(one.label, one.run) for one in degraded] == runs
    assert {one.line_style.colour for one in degraded[:2]} == {LINE_STYLES[A].colour}
    assert degraded[0].line_style != degraded[1].line_style


@pytest.mark.parametrize(
    ("name", "drawn"),
    [
        ("tilt", (0, 1)),
        ("power_and_energy", (0, 1, 4)),
        ("fixed_tilt", (3, 4)),
        ("trajectory", (0, 1)),
        ("errors", (0, 1)),
    ],
)
def test_figures_of_flights_draw_those_flights(name: str, drawn: tuple[int, ...]) -> None:
    figure = page._flight_drawings(made_up_results())[name][1]()
    panel = panels_of(figure)[-1]
    runs = [FLIGHTS.runs[NAMES[k]] for k in drawn]
    shown = [(label, points) for label, points in curves_of(panel) if label != "desired"]
    assert [label for label, _ in shown] == [WORDS[NAMES[k]] for k in drawn]
    for (_, points), run in zip(shown, runs, strict=True):
        if name == "tilt":
            np.testing.assert_allclose(points[:, 1], np.degrees(run.tilt_actual[:, 0]))
        elif name == "trajectory":
            np.testing.assert_allclose(points[:, 1], curves.rotation_about_x_deg(run.R_WB))
        elif name == "errors":
            np.testing.assert_allclose(points[:, 1], curves.attitude_error(run).sine)
        else:
            assert points[-1, 1] == pytest.approx(1e-3 * run.metrics.drag_energy_J)
    claimed = [CLAIMS[f"attitude_error_{case}"].value for case in "ab"]
    levels = {"tilt": [0.0, 60.0], "errors": claimed}.get(name, [])
    assert levels_of(panel) == pytest.approx(levels)
