"""Figures of a fit show the measurements, the line that was fitted and what was left out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.physics.bench_runs import DRAG, THRUST, TURN, bench_run, lagged, staircase
from tests.unit.drawn import assert_in_sight

from omnimorph.identification import BenchData, RotorFit, fit_rotor
from omnimorph.protocols import FloatArray
from omnimorph.report import fit_figures
from omnimorph.report.fit_data import fit_data, vehicle_lines

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
