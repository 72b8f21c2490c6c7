"""Figures of a fit show the measurements, the line that was fitted and what was left out."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.physics.bench_runs import DRAG, THRUST, TURN, bench_run, lagged, staircase
from tests.unit.drawn import assert_in_sight, levels_of

from omnimorph.identification import BenchData, RotorFit, fit_rotor
from omnimorph.identification.coefficients import Estimate
from omnimorph.protocols import FloatArray
from omnimorph.report import fit_figures
from omnimorph.report.fit_data import fit_data, vehicle_lines
from omnimorph.report.fit_page import _table
from omnimorph.report.tables import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D


def curve(panel: Axes, label: str) -> Line2D:
    """The first curve of a panel with a label."""
    return next(line for line in panel.get_lines() if line.get_label() == label)


def points(line: Line2D) -> FloatArray:
    return np.asarray(line.get_xydata(), dtype=np.float64)


@pytest.fixture(scope="module")
def both_ways() -> RotorFit:
    """Forward and reverse differ in force, one row is wrong, the torque is what the bench feels."""
    speed = staircase() * np.where(np.arange(120) % 2, 1.0, -1.0)
    run = bench_run(speed)
    force = run.force * np.where(speed < 0.0, 0.8, 1.0)
    force[10] += 5.0
    return fit_rotor(bench_run(speed, force=force, torque=-run.torque))


@pytest.fixture(scope="module")
def stepped() -> RotorFit:
    """Steps of the command, and noise, so that every interval has a width."""
    time: FloatArray = np.arange(1600) / 500.0
    command = TURN * np.where((time // 0.4).astype(int) % 2, 120.0, 60.0)
    speed = lagged(time, command, 0.025, 0.045)
    speed = speed + np.random.default_rng(5).standard_normal(1600)
    return fit_rotor(replace(bench_run(speed), time=time, command=command))


def test_lines_have_the_slopes_fitted(both_ways: RotorFit) -> None:
    force, torque = fit_figures.coefficients(both_ways).axes
    thrust, drag = both_ways.thrust, both_ways.drag
    assert thrust.forward is not None
    assert thrust.reverse is not None
    for panel, label, estimate in (
        (force, "fitted, forward", thrust.forward),
        (force, "fitted, reverse", thrust.reverse),
        (torque, "fitted", drag.both),
    ):
        (x0, y0), (x1, y1) = points(curve(panel, label))
        assert (y1 - y0) / (x1 - x0) == pytest.approx(1e3 * TURN**2 * estimate.value)
    (left_out,) = points(curve(force, "left out"))
    w_Hz = both_ways.bench.speed[10] / TURN
    assert left_out == pytest.approx([1e-3 * w_Hz * abs(w_Hz), both_ways.bench.force[10]])
    assert len(points(curve(force, "measured"))) == 119
    turned = points(curve(torque, "measured"))
    assert (turned[:, 0] * turned[:, 1]).min() > 0.0


def test_nothing_lies_beyond_the_axes(both_ways: RotorFit) -> None:
    assert_in_sight(fit_figures.coefficients(both_ways))
    assert_in_sight(fit_figures.residuals(both_ways))


def test_residuals_are_measured_less_fitted(both_ways: RotorFit) -> None:
    panels = fit_figures.residuals(both_ways).axes
    for panel, fit in zip(panels, (both_ways.thrust, both_ways.drag), strict=True):
        shown = points(curve(panel, "measured"))[:, 1]
        assert shown == pytest.approx(fit.residual[~fit.outlier])
        assert panel.get_ylim()[1] > np.abs(shown).max()
    (left_out,) = points(curve(panels[0], "left out"))
    assert abs(left_out[1]) <= panels[0].get_ylim()[1]  # at the edge, not out of sight


@pytest.mark.parametrize("delay", [0.0, 0.03])
def test_steps_lie_on_the_curve_whatever_the_delay(delay: float) -> None:
    time: FloatArray = np.arange(1600) / 500.0
    command = TURN * np.where((time // 0.4).astype(int) % 2, 120.0, 60.0)
    speed = lagged(time, command, 0.025, 0.045, delay)
    fit = fit_rotor(
        BenchData(
            time=time,
            speed=speed,
            force=THRUST * speed**2,
            torque=DRAG * speed**2,
            command=command,
        )
    )
    figure = fit_figures.steps(fit)
    assert_in_sight(figure)
    for panel, tau_ms in zip(figure.axes, (25.0, 45.0), strict=True):
        shown = points(curve(panel, "measured"))
        since = shown[shown[:, 0] > 0.0]
        assert len(since) > 20
        assert since[:, 1] == pytest.approx(1.0 - np.exp(-since[:, 0] / tau_ms), abs=1e-4)


def test_limits_and_titles_are_those_of_the_fit(both_ways: RotorFit, stepped: RotorFit) -> None:
    for panel, fit in zip(
        fit_figures.residuals(both_ways).axes, (both_ways.thrust, both_ways.drag), strict=True
    ):
        assert levels_of(panel) == pytest.approx([-2.0 * fit.noise, 0.0, 2.0 * fit.noise])
    assert stepped.time_constant_up is not None
    assert stepped.time_constant_down is not None
    for panel, word, one in zip(
        fit_figures.steps(stepped).axes,
        ("up", "down"),
        (stepped.time_constant_up, stepped.time_constant_down),
        strict=True,
    ):
        count = sum(step.up == (word == "up") for step in stepped.steps)
        half = number(500.0 * (one.high - one.low), 2)
        title = f"{word}: {number(1e3 * one.value)} ± {half} ms ({count} steps)"
        assert panel.get_title("left") == title
        time, share = points(curve(panel, "fitted")).T
        assert share == pytest.approx(1.0 - np.exp(-1e-3 * time / one.value))


@pytest.mark.parametrize("name", ["both_ways", "stepped"])
def test_table_and_data_and_lines_are_the_fit(name: str, request: pytest.FixtureRequest) -> None:
    fit: RotorFit = request.getfixturevalue(name)
    data = fit_data(fit)
    rows = {row[0]: row[1:] for row in _table(fit).rows}
    lines = vehicle_lines(fit)

    def check(words: str, key: str, one: Estimate | None, factor: float, unit: str) -> None:
        """Hold that an estimate is reported in all three, in one unit."""
        if one is None:
            assert rows[words] == ["—", "", unit]
            return
        value, low, high = (factor * number for number in one)
        assert rows[words] == [number(value, 5), f"{number(low, 5)} to {number(high, 5)}", unit]
        reported = data[key]["both"] if "both" in data[key] else data[key]
        for way in ("forward", "reverse"):
            reported = data[key][way] if words.endswith(way) else reported
        assert reported == pytest.approx({"value": value, "low": low, "high": high})
        (line,) = (
            line.removeprefix("# in reverse: ")
            for line in lines.splitlines()
            if key in line and line.startswith("#") == words.endswith("reverse")
        )
        numbers = [float(word) for word in re.findall(r"(?<= )-?[\d.]+(?:e-?\d+)?(?= |$)", line)]
        half = 0.5 * (high - low)
        wanted = [value, 95.0, low, high] if "%:" not in line else [value, low, high]
        assert numbers[0] == pytest.approx(wanted[0], abs=0.02 * half, rel=1e-4)
        assert numbers[-2:] == pytest.approx(wanted[-2:], abs=0.02 * half, rel=1e-4)

    hertz = TURN**2
    for kind, unit, suffix, one in (
        ("thrust", "N/Hz²", "N_per_Hz2", fit.thrust),
        ("drag", "N m/Hz²", "Nm_per_Hz2", fit.drag),
    ):
        key = f"{kind}_coefficient_{suffix}"
        assert data[key]["separate"] is one.separate
        if one.separate:
            check(f"{kind} coefficient, forward", key, one.forward, hertz, unit)
            check(f"{kind} coefficient, reverse", key, one.reverse, hertz, unit)
        else:
            check(f"{kind} coefficient", key, one.both, hertz, unit)
    check("time constant up", "time_constant_up_ms", fit.time_constant_up, 1e3, "ms")
    check("time constant down", "time_constant_down_ms", fit.time_constant_down, 1e3, "ms")
    for words, key, value, factor, unit in (
        ("torque over force", "drag_to_thrust_m", fit.drag_to_thrust, 1e3, "mm"),
        ("lowest speed seen", "speed_min_Hz", fit.speed_min / TURN, 1.0, "Hz"),
        ("highest speed seen", "speed_max_Hz", fit.speed_max / TURN, 1.0, "Hz"),
        ("noise of the force, 1σ", "force_noise_N", fit.thrust.noise, 1.0, "N"),
        ("noise of the torque, 1σ", "torque_noise_Nm", fit.drag.noise, 1.0, "N m"),
    ):
        digits = 3 if words.startswith("noise") else 4
        assert rows[words] == [number(factor * value, digits), "", unit]
        assert data[key] == pytest.approx(value)
    assert f"speed_min_Hz = {fit.speed_min / TURN:.5g}  # the lowest" in lines
    assert f"speed_max_Hz = {fit.speed_max / TURN:.5g}  # the highest" in lines
    for reported, step in zip(data["steps"], fit.steps, strict=True):
        assert (reported["line"], reported["up"]) == (fit.bench.lines[step.begin], step.up)
        assert reported["time_constant_ms"]["value"] == pytest.approx(
            1e3 * step.time_constant.value
        )


def test_a_way_without_steps_says_so() -> None:
    time: FloatArray = np.arange(400) / 500.0
    command = TURN * np.where(time < 0.4, 60.0, 120.0)
    speed = lagged(time, command, 0.025, 0.045)
    force, torque = THRUST * speed**2, DRAG * speed**2
    run = BenchData(time=time, speed=speed, force=force, torque=torque, command=command)
    fit = fit_rotor(run)
    _, down = fit_figures.steps(fit).axes
    assert down.get_title("left") == "no step down was fitted"


def test_lines_for_a_vehicle_file_name_the_reverse_as_a_comment(both_ways: RotorFit) -> None:
    lines = vehicle_lines(both_ways).splitlines()
    assert lines[0].startswith("thrust_coefficient_N_per_Hz2 = 0.00043")
    assert lines[2].startswith("# in reverse: thrust_coefficient_N_per_Hz2 = 0.00034")
    data = fit_data(both_ways)
    assert data["thrust_coefficient_N_per_Hz2"]["separate"] is True
    assert data["force_outlier_lines"] == [11]
    assert data["torque_has_the_sign_of_the_speed"] is False
    assert data["time_constant_up_ms"] is None
