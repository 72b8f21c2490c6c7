"""The figures of a fit: measurements over w|w| with the line, residuals over speed, steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.identification.coefficients import CoefficientFit
from omnimorph.identification.rotor_fit import RotorFit
from omnimorph.protocols import FloatArray
from omnimorph.report.style import (
    BLACK,
    BLUE,
    GREEN,
    LIMIT,
    PURPLE,
    SILVER,
    VERMILLION,
    legend_above,
    legend_entries,
    new_figure,
    styled,
)
from omnimorph.report.tables import number
from omnimorph.units import from_SI

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_DOTS = 1500  # of a curve: of longer ones every second, third ... row is drawn
_DOT: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 2.6, "alpha": 0.55}
_CROSS: dict[str, Any] = {"linestyle": "none", "marker": "x", "markersize": 5.0, "zorder": 4}
_FORCE, _TORQUE = "force (N)", "torque (N m)"
_MOST_STEPS = 12


@styled
def coefficients(fit: RotorFit) -> Figure:
    """Draw force and torque over w|w| (1000 Hz²): each row, the outliers, and the line fitted."""
    figure, axes = new_figure(3.0, 1, 2)
    square = _square_in_thousands(fit)
    for panel, one, measured, name in zip(
        axes[0], (fit.thrust, fit.drag), _measured(fit), (_FORCE, _TORQUE), strict=True
    ):
        _dots(panel, square, measured, one)
        _fitted_line(panel, square, one)
        panel.set_xlabel("w|w| (1000 Hz²)")
        panel.set_ylabel(name)
    legend_above(figure, *legend_entries(axes[0]))
    return figure


@styled
def residuals(fit: RotorFit) -> Figure:
    """Draw measured less fitted over the speed (Hz), with ± two standard deviations.

    Outliers beyond the panel are marked at its edge.
    """
    figure, axes = new_figure(3.8, 2, 1, sharex=True)
    speed = from_SI(fit.bench.speed, "Hz")
    for panel, one, name in zip(
        axes[:, 0], (fit.thrust, fit.drag), ("force", "torque"), strict=True
    ):
        kept = one.residual[~one.outlier]
        reach = 1.25 * max(float(np.abs(kept).max()), 2.0 * one.noise, 1e-12)
        _dots(panel, speed, np.clip(one.residual, -0.96 * reach, 0.96 * reach), one)
        panel.axhline(0.0, color=BLACK, linewidth=0.8)
        for sign in (-1.0, 1.0):
            label = "± 2 standard deviations" if sign > 0.0 else None
            panel.axhline(2.0 * sign * one.noise, **LIMIT, label=label)
        panel.set_ylim(-reach, reach)
        panel.set_ylabel(f"{name}, measured\nless fitted ({'N' if name == 'force' else 'N m'})")
    axes[-1, 0].set_xlabel("speed (Hz)")
    legend_above(figure, *legend_entries(axes[:, 0]))
    return figure


@styled
def steps(fit: RotorFit) -> Figure:
    """Draw steps that were fitted, as the share of the step done over the time since they began.

    The first 12 in each direction; for a fit with steps.
    """
    figure, axes = new_figure(3.0, 1, 2, sharey=True)
    for panel, up, constant in zip(
        axes[0], (True, False), (fit.time_constant_up, fit.time_constant_down), strict=True
    ):
        fitted = [step for step in fit.steps if step.up == up]
        word = "up" if up else "down"
        if constant is None:
            panel.set_title(f"no step {word} was fitted", loc="left")
            panel.set_xlabel("time (ms)")
            continue
        end = 6.0 * constant.value
        shown = np.linspace(0.0, end, 200)
        for step in fitted[:_MOST_STEPS]:
            # the curve itself tells where it would have begun
            time = fit.bench.time[step.begin : step.end] - fit.bench.time[step.first]
            start = float(fit.bench.speed[step.begin - 1])
            way = (fit.bench.speed[step.begin : step.end] - start) / (step.steady - start)
            tau = step.time_constant.value
            time = time + tau * np.log((start - step.steady) / step.amplitude)
            near = time <= end
            panel.plot(from_SI(time[near], "ms"), way[near], color=BLUE, label="measured", **_DOT)
        panel.plot(
            from_SI(shown, "ms"),
            1.0 - np.exp(-shown / constant.value),
            color=VERMILLION,
            label="fitted",
        )
        half = 0.5 * from_SI(constant.high - constant.low, "ms")
        value = f"{number(from_SI(constant.value, 'ms'))} ± {number(half, 2)} ms"
        panel.set_title(
            f"{word}: {value} ({len(fitted)} step{'s' if len(fitted) > 1 else ''})", loc="left"
        )
        panel.set_xlabel("time since the fitted curve began (ms)")
    axes[0, 0].set_ylabel("share of the step (–)")
    axes[0, 0].set_ylim(-0.15, 1.15)
    legend_above(figure, *legend_entries(axes[0]))
    return figure


def _square_in_thousands(fit: RotorFit) -> FloatArray:
    speed = from_SI(fit.bench.speed, "Hz")
    square: FloatArray = 1e-3 * speed * np.abs(speed)
    return square


def _measured(fit: RotorFit) -> tuple[FloatArray, FloatArray]:
    torque = fit.bench.torque
    return fit.bench.force, -torque if fit.torque_felt else torque


def _dots(panel: Axes, across: FloatArray, up: FloatArray, one: CoefficientFit) -> None:
    kept = np.flatnonzero(~one.outlier)
    kept = kept[:: max(1, -(-len(kept) // _MOST_DOTS))]
    panel.plot(across[kept], up[kept], color=BLUE, label="measured", **_DOT)
    if one.outlier.any():
        label = "left out"
        panel.plot(across[one.outlier], up[one.outlier], color=BLACK, label=label, **_CROSS)


def _fitted_line(panel: Axes, square: FloatArray, one: CoefficientFit) -> None:
    ends = [min(float(square.min()), 0.0), max(float(square.max()), 0.0)]
    ways = [(one.both, ends, "fitted", VERMILLION)]
    if one.separate and one.forward is not None and one.reverse is not None:
        ways = [
            (one.forward, [0.0, ends[1]], "fitted, forward", GREEN),
            (one.reverse, [ends[0], 0.0], "fitted, reverse", PURPLE),
        ]
    for way, x, label, colour in ways:
        slope = 1e3 * from_SI(way.value, "N_per_Hz2")
        panel.plot(x, [slope * end for end in x], color=colour, label=label, zorder=3)
    panel.axhline(0.0, color=SILVER, linewidth=0.6, zorder=0)
