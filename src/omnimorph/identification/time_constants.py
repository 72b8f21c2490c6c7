"""Time constants of a rotor, from how its speed follows steps of the command.

After a step the speed of a first-order lag is ``w(t) = a + b e^{−t/τ}``. For each step a, b and τ
come from least squares: a and b in closed form for a given τ, and τ by minimising over it. As a and
b are free, a delay before the rise and a steady speed that misses the command change nothing. Steps
towards faster speeds give the time constant up, the others the one down, as in the plant's
`RotorLag`; the mean of several is weighted by their certainty, and its interval widened where they
scatter more than each alone admits (the ratio of Birge).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from omnimorph.errors import InputError
from omnimorph.identification.coefficients import Estimate
from omnimorph.protocols import FloatArray

_LEAST_STEP = 0.05  # of the largest command: smaller changes are not taken for steps
_BEGUN = 0.10  # of the way: rows before are left out, so that a delay does no harm
_LEAST_ROWS = 8  # from there on
_LEAST_IN_RISE = 3  # of those within one time constant
_GRID = 60
_MOST_STEPS = 1000


@dataclass(frozen=True, eq=False, kw_only=True)
class StepFit:
    """How the speed followed one step of the command.

    Attributes
    ----------
    begin, end : int
        Rows from the step to the next, the last not included.
    up : bool
        Whether the rotor was commanded to turn faster.
    first : int
        The row from which on the curve is fitted.
    time_constant : Estimate, s
        τ with its 95 % interval.
    steady, amplitude : float, rad/s
        a, and b at the time of the row `first`.
    """

    begin: int
    end: int
    up: bool
    first: int
    time_constant: Estimate
    steady: float
    amplitude: float

    def speed(self, time: FloatArray) -> FloatArray:
        """Return the fitted speed, rad/s, at times (s) counted from the row `first`."""
        fitted: FloatArray = self.steady + self.amplitude * np.exp(-time / self.time_constant.value)
        return fitted


def fit_steps(
    time: FloatArray, speed: FloatArray, command: FloatArray, source: str = "the bench data"
) -> tuple[StepFit, ...]:
    """Fit every step of the command that can be fitted, by time (s) and speeds (rad/s), (K,) each.

    Steps through zero, those with fewer than 8 rows, or fewer than 3 within the time constant, and
    those whose interval reaches zero are left out.

    Raises
    ------
    InputError
        If the command has more than 1000 steps: it is then no command, or a noisy one.
    """
    least = _LEAST_STEP * float(np.abs(command).max(initial=0.0))
    starts = np.flatnonzero(np.abs(np.diff(command)) > max(least, 1e-9)) + 1
    if len(starts) > _MOST_STEPS:
        allowed = f"at most {_MOST_STEPS}; without the column no time constants are fitted"
        raise InputError.at(source, "number of steps of the command", len(starts), allowed)
    found = []
    for begin, end in pairwise([*starts.tolist(), len(time)]):
        before, after = float(command[begin - 1]), float(command[begin])
        if before * after >= 0.0:  # a reversal follows both time constants, one after the other
            up = abs(after) > abs(before)
            found.append(_fit_step(time, speed, begin, end, up))
    return tuple(step for step in found if step is not None)


def combined(steps: Sequence[StepFit]) -> Estimate | None:
    """Return the time constant of several steps, s; None if there are none."""
    if not steps:
        return None
    estimates = [step.time_constant for step in steps]
    values = np.array([one.value for one in estimates])
    halves = np.array([0.5 * (one.high - one.low) for one in estimates])
    weights = np.maximum(halves, 1e-12 * values) ** -2.0
    value = float(weights @ values / weights.sum())
    half = 1.0 / math.sqrt(float(weights.sum()))
    if len(steps) > 1:
        from scipy.special import stdtrit

        # the scatter in units of one standard deviation, of which a half interval holds 1.96
        scatter = 1.96**2 * float(weights @ (values - value) ** 2) / (len(steps) - 1)
        if scatter > 1.0:
            half *= math.sqrt(scatter) * float(stdtrit(len(steps) - 1, 0.975)) / 1.96
    return Estimate(value, value - half, value + half)


def _fit_step(
    time: FloatArray, speed: FloatArray, begin: int, end: int, up: bool
) -> StepFit | None:
    """Fit one step; None if it has too few rows or the speed does not follow."""
    from scipy.optimize import minimize_scalar
    from scipy.special import stdtrit

    start = float(speed[begin - 1])
    settled = float(np.median(speed[begin + (end - begin) // 2 : end]))
    way = (speed[begin:end] - start) / (settled - start) if settled != start else speed[begin:end]
    # One row after the first that has clearly moved: the choice then owes nothing to its noise.
    first = begin + int(np.argmax(way > _BEGUN)) + 1
    if settled == start or not (way > _BEGUN).any() or end - first < _LEAST_ROWS:
        return None
    since, measured = time[first:end] - time[first], speed[first:end]

    def cost(log_tau: float) -> float:
        return _linear_part(since, measured, math.exp(log_tau))[2]

    shortest = math.log(float(np.diff(since).min()) / 10.0)
    grid = np.linspace(shortest, math.log(10.0 * float(since[-1])), _GRID)
    best = int(np.argmin([cost(x) for x in grid]))
    if best in (0, _GRID - 1):
        return None
    bracket = (grid[best - 1], grid[best + 1])
    tau = math.exp(
        minimize_scalar(cost, bounds=bracket, method="bounded", options={"xatol": 1e-9}).x
    )
    steady, amplitude, squares = _linear_part(since, measured, tau)
    fall = np.exp(-since / tau)
    if np.count_nonzero(since < tau) < _LEAST_IN_RISE or amplitude * (settled - start) >= 0.0:
        return None
    slope = np.column_stack([np.ones_like(fall), fall, amplitude * fall * since / tau**2])
    scale = np.abs(slope).max(axis=0)
    spread = squares / (len(since) - 3) * np.linalg.pinv((slope / scale).T @ (slope / scale))
    half = float(stdtrit(len(since) - 3, 0.975)) * math.sqrt(spread[2, 2]) / float(scale[2])
    if half >= tau:  # the rows do not tell it from an instant
        return None
    return StepFit(
        begin=begin,
        end=end,
        up=up,
        first=first,
        time_constant=Estimate(tau, tau - half, tau + half),
        steady=steady,
        amplitude=amplitude,
    )


def _linear_part(since: FloatArray, speed: FloatArray, tau: float) -> tuple[float, float, float]:
    """Return the a and b of least squares for a given τ, and that sum of squares."""
    fall = np.exp(-since / tau)
    centred = fall - fall.mean()
    size = float(centred @ centred)
    b = float(centred @ speed) / size if size > 0.0 else 0.0
    a = float(speed.mean() - b * fall.mean())
    rest = speed - a - b * fall
    return a, b, float(rest @ rest)
