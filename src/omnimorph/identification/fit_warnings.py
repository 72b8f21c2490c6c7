"""What a user of a fit should know before trusting it, in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from omnimorph.identification.bench_data import BenchData
from omnimorph.identification.coefficients import CoefficientFit
from omnimorph.identification.time_constants import StepFit
from omnimorph.identification.unit_hints import torque_hint
from omnimorph.protocols import FloatArray

_SHOWN = 12  # lines of outliers that a sentence names
_LARGE_OFFSET = 0.01  # of the largest force or torque
_CORRELATED = 0.3


def fit_warnings(
    bench: BenchData,
    thrust: CoefficientFit,
    drag: CoefficientFit,
    felt: bool,
    steps: Sequence[StepFit],
) -> tuple[str, ...]:
    """Return the sentences on what was fitted to a run; none if nothing is to be said.

    `felt` says whether the torque was turned round.
    """
    square = bench.speed * np.abs(bench.speed)
    torque = -bench.torque if felt else bench.torque
    found: list[str] = []
    for name, fit, measured in (("force", thrust, bench.force), ("torque", drag, torque)):
        found += _of_outliers(bench, name, fit)
        found += _of_offset(name, fit, square, measured)
        found += _of_correlation(name, fit)
        if fit.separate and fit.forward is not None and fit.reverse is not None:
            share = fit.reverse.value / fit.forward.value
            found.append(
                f"In reverse the coefficient of {name} is {share:.3g} times the forward one, more "
                "than chance explains; a vehicle file has one number for both."
            )
    if felt:
        found.append(
            "The torque has the sign opposite to the speed's: it is taken for what the bench "
            "feels, and its coefficient is given positive."
        )
    found += [hint] if (hint := torque_hint(drag.value.value / thrust.value.value)) else []
    return (*found, *_of_steps(bench, steps))


def _of_outliers(bench: BenchData, name: str, fit: CoefficientFit) -> Iterator[str]:
    lines = [str(bench.lines[row]) for row in np.flatnonzero(fit.outlier)]
    if lines:
        shown = ", ".join(lines[:_SHOWN])
        more = f" and {len(lines) - _SHOWN} more" if len(lines) > _SHOWN else ""
        yield (
            f"{len(lines)} of {len(fit.outlier)} rows were left out of the {name}, being beyond 5 "
            f"robust standard deviations: line{'s' if len(lines) > 1 else ''} {shown}{more}."
        )


def _of_offset(
    name: str, fit: CoefficientFit, square: FloatArray, measured: FloatArray
) -> Iterator[str]:
    """Report a sensor that was not zeroed: y = c w|w| + b fits clearly better."""
    x, y = square[~fit.outlier], fit.residual[~fit.outlier]
    design = np.column_stack([np.ones_like(x), x / np.abs(x).max()])
    solution, squares, rank, _ = np.linalg.lstsq(design, y, rcond=None)
    if rank < 2 or len(x) < 4 or not squares.size:
        return
    error = np.sqrt(squares[0] / (len(x) - 2) * np.linalg.inv(design.T @ design)[0, 0])
    offset, largest = float(solution[0]), float(np.abs(measured[~fit.outlier]).max())
    if abs(offset) > 4.0 * error and abs(offset) > _LARGE_OFFSET * largest:
        unit = "N" if name == "force" else "N m"
        yield (
            f"At rest the {name} would be {offset:.3g} {unit}, not 0, {abs(offset) / largest:.1%} "
            "of the largest: zero the sensor with the rotor at rest."
        )


def _of_correlation(name: str, fit: CoefficientFit) -> Iterator[str]:
    rest = fit.residual[~fit.outlier]
    rest = rest - rest.mean()
    size = float(rest @ rest)
    correlation = float(rest[1:] @ rest[:-1]) / size if size > 0.0 else 0.0
    significant = correlation * np.sqrt(len(rest)) > 4.0
    rounding = fit.noise < 1e-9 * abs(fit.value.value)
    if correlation > _CORRELATED and significant and not rounding:
        wider = np.sqrt((1.0 + correlation) / (1.0 - min(correlation, 0.999)))
        yield (
            f"Successive residuals of the {name} are alike (correlation {correlation:.2f}), so its "
            f"interval is too narrow, by a factor of about {wider:.2g}."
        )


def _of_steps(bench: BenchData, steps: Sequence[StepFit]) -> Iterator[str]:
    if bench.command is None:
        yield "There is no command, so there are no time constants."
        return
    for up, word in ((True, "up"), (False, "down")):
        if not any(step.up == up for step in steps):
            yield (
                f"No step {word} of the command could be fitted, so there is no time constant "
                f"{word}: a step must be held, and sampled 3 times or more in one time constant."
            )
