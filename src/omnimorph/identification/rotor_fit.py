"""The numbers of a rotor from one run on a thrust bench, each with its 95 % interval.

::

    fit = fit_rotor(read_bench("bench.csv"))
    fit.thrust.value                         # Estimate(value, low, high), N s²/rad²
    fit.time_constant_up, fit.warnings
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from omnimorph.design.keys import FIELDS
from omnimorph.errors import InputError
from omnimorph.identification.bench_data import STILL, BenchData, BenchLike, as_bench
from omnimorph.identification.coefficients import CoefficientFit, Estimate, fit_coefficient
from omnimorph.identification.fit_warnings import fit_warnings
from omnimorph.identification.time_constants import StepFit, combined, fit_steps
from omnimorph.identification.unit_hints import check_expected
from omnimorph.protocols import FloatArray
from omnimorph.units import from_SI

LEAST_ROWS = 8
"""So many rows must turn in a sense of rotation for it to be fitted."""
_MOVING = 0.02  # of the largest speed: slower rows count as at rest
_LEAST_RANGE = 1.2  # the fastest over the slowest moving row
_MOST_OUTLIERS = 0.2  # of all rows

Rows = NDArray[np.bool_]


@dataclass(frozen=True, eq=False, kw_only=True)
class RotorFit:
    """What one run on a bench says about a rotor.

    Attributes
    ----------
    bench : BenchData
        The run.
    thrust : CoefficientFit
        c_f of ``f = c_f w|w|``, N s²/rad².
    drag : CoefficientFit
        c_τ of ``τ = c_τ w|w|``, N m s²/rad², positive.
    torque_felt : bool
        Whether the torque has the sign opposite to the speed's: what the bench feels. Its residuals
        are then those of the torque turned round.
    speed_min, speed_max : float, rad/s
        The lowest and the highest speed seen, signed; 0 for a rotor that rested and never turned
        the other way round.
    time_constant_up, time_constant_down : Estimate or None, s
        None if no step of the command determines it.
    steps : tuple of StepFit
        The steps they come from.
    warnings : tuple of str
        Sentences.
    """

    bench: BenchData
    thrust: CoefficientFit
    drag: CoefficientFit
    torque_felt: bool
    speed_min: float
    speed_max: float
    time_constant_up: Estimate | None
    time_constant_down: Estimate | None
    steps: tuple[StepFit, ...]
    warnings: tuple[str, ...]

    @property
    def drag_to_thrust(self) -> float:
        """Torque over force, κ = c_τ/c_f, m."""
        return self.drag.value.value / self.thrust.value.value


def fit_rotor(
    bench: BenchLike,
    *,
    expected_thrust_coefficient: float | None = None,
    expected_drag_coefficient: float | None = None,
) -> RotorFit:
    """Fit the numbers of a rotor to a run on a bench.

    Parameters
    ----------
    bench : BenchData, str or path
        At least 8 rows that turn, of which the fastest turns 1.2 times as fast as the slowest; or
        the CSV file of them, see `read_bench`.
    expected_thrust_coefficient : float, N s²/rad², optional
        Of a rotor of about the same size: a wrong unit is then recognised by its factor.
    expected_drag_coefficient : float, N m s²/rad², optional
        The same for the drag; it distinguishes a wrong unit of speed from one of force.

    Returns
    -------
    RotorFit
        The sides are fitted together, and apart where they differ more than chance explains.

    Raises
    ------
    InputError
        If there are too few rows, the speed does not vary, a force has the sign opposite to the
        speed's, more than a fifth of the rows are outliers, or a coefficient differs from the one
        expected as if a unit were wrong.

    Examples
    --------
    A rotor of 1e-5 N s²/rad² and 1.5e-7 N m s²/rad², without noise:

    >>> speed = np.linspace(100.0, 800.0, 50)
    >>> bench = BenchData(
    ...     time=np.arange(50.0), speed=speed, force=1e-5 * speed**2, torque=1.5e-7 * speed**2
    ... )
    >>> fit = fit_rotor(bench)
    >>> round(fit.thrust.value.value, 12), round(fit.drag_to_thrust, 12), fit.speed_max
    (1e-05, 0.015, 800.0)

    Notes
    -----
    Force and torque are taken to follow the measured speed at once, and the speed to be exact: its
    noise makes the coefficients too small by about its relative variance. While a rotor speeds up,
    a bench that feels the motor's torque also feels its inertia; hold each speed for a while.
    """
    bench = as_bench(bench)
    sides = _sides(bench)
    square = bench.speed * np.abs(bench.speed)
    thrust = fit_coefficient(square, bench.force, sides)
    _check_signs(bench, thrust, sides)
    felt = _median_sign(square, bench.torque) < 0
    drag = fit_coefficient(square, -bench.torque if felt else bench.torque, sides)
    _check_fit(bench, "force", thrust)
    _check_fit(bench, "torque", drag)
    _check_size(bench, "force", thrust)
    _check_size(bench, "torque", drag)
    if expected_thrust_coefficient is not None:
        check_expected(
            bench.source,
            thrust.value.value,
            drag.value.value,
            expected_thrust_coefficient,
            expected_drag_coefficient,
        )
    speeds = bench.speed[~(thrust.outlier | drag.outlier)]
    low = float(speeds.min())
    steps: tuple[StepFit, ...] = ()
    if bench.command is not None:
        steps = fit_steps(bench.time, bench.speed, bench.command, bench.source)
    return RotorFit(
        bench=bench,
        thrust=thrust,
        drag=drag,
        torque_felt=felt,
        speed_min=low if sides[1].any() else max(low, 0.0),
        speed_max=float(speeds.max()) if sides[0].any() else min(float(speeds.max()), 0.0),
        time_constant_up=combined([step for step in steps if step.up]),
        time_constant_down=combined([step for step in steps if not step.up]),
        steps=steps,
        warnings=fit_warnings(bench, thrust, drag, felt, steps),
    )


def _sides(bench: BenchData) -> tuple[Rows, Rows]:
    """Return which rows turn forward and which in reverse; refuse what cannot be fitted."""
    size = np.abs(bench.speed)
    slowest = max(_MOVING * float(size.max(initial=0.0)), STILL)
    sides = (bench.speed > slowest, bench.speed < -slowest)
    counts = [int(side.sum()) for side in sides]
    most = max(counts)
    if most < LEAST_ROWS:
        found = f"{most} of {len(size)} rows"
        allowed = f"{LEAST_ROWS} or more rows that turn the same way round"
        raise InputError.at(bench.source, "what there is to fit", found, allowed)
    for name, side, count in zip(("forward", "reverse"), sides, counts, strict=True):
        if count < LEAST_ROWS:
            if count:
                lines = [bench.lines[row] for row in np.flatnonzero(side)]
                raise InputError(
                    f"{bench.source}: only {_rows(count)} ({_listed(lines)}) turn in {name}, but "
                    f"it must be none or {LEAST_ROWS} or more; is a sign wrong?",
                    file=bench.source,
                )
            continue
        slow, fast = float(size[side].min()), float(size[side].max())
        if fast < (1.0 - 1e-9) * _LEAST_RANGE * slow:  # 120 Hz are 1.2 times 100 Hz
            ends = [f"{from_SI(speed, 'Hz'):.4g}" for speed in (slow, fast)]
            raise InputError(
                f"{bench.source}: the {name} speeds do not vary enough, {ends[0]} to {ends[1]} Hz; "
                f"the fastest must be at least {_LEAST_RANGE:g} times the slowest.",
                file=bench.source,
            )
    return sides


def _check_signs(bench: BenchData, thrust: CoefficientFit, sides: tuple[Rows, Rows]) -> None:
    """Refuse forces against the direction in which the rotor blows."""
    for name, side in zip(("forward", "reverse"), sides, strict=True):
        wrong = np.flatnonzero(side & (bench.force * bench.speed < 0.0) & ~thrust.outlier)
        if 2 * len(wrong) > side.sum():
            raise InputError(
                f"{bench.source}: the force has the sign opposite to the speed's in "
                f"{len(wrong)} of {_rows(int(side.sum()))} that turn in {name}, the first on line "
                f"{bench.lines[wrong[0]]}; turn the sign of the column that is wrong.",
                file=bench.source,
                key="force",
            )


def _check_fit(bench: BenchData, name: str, fit: CoefficientFit) -> None:
    """Refuse a coefficient that is none, or that no vehicle may have."""
    lost = int(fit.outlier.sum())
    if lost > _MOST_OUTLIERS * len(fit.outlier):
        lines = [bench.lines[row] for row in np.flatnonzero(fit.outlier)]
        raise InputError(
            f"{bench.source}: {lost} of {_rows(len(fit.outlier))} are far from any {name} that "
            f"grows with the squared speed ({_listed(lines)}); at most a fifth may be.",
            file=bench.source,
            key=name,
        )
    ways = [way for way in (fit.forward, fit.reverse) if way is not None]
    if any(not way.low > 0.0 for way in ways):
        way = next(way for way in ways if not way.low > 0.0)
        raise InputError(
            f"{bench.source}: the {name} does not grow with the squared speed: its coefficient is "
            f"{way.value:.3g} in SI, with 95 % confidence from {way.low:.3g} to {way.high:.3g}; it "
            "must be positive.",
            file=bench.source,
            key=name,
        )


def _check_size(bench: BenchData, name: str, fit: CoefficientFit) -> None:
    """Refuse a coefficient that a vehicle file does not take: a column is in another unit."""
    attribute = {"force": "thrust_coefficient", "torque": "drag_coefficient"}[name]
    limits = FIELDS[attribute].limits_in_SI
    for way in (fit.both, fit.forward, fit.reverse):
        if way is not None and limits is not None and way.value not in limits:
            key = f"the coefficient of {name} over squared speed"
            raise InputError.at(bench.source, key, way.value, f"{limits} in SI")


def _median_sign(square: FloatArray, measured: FloatArray) -> float:
    """Return the sign that most of a quantity has beside the speed, weighted by the speed."""
    return float(np.sign(np.sum(np.sign(measured) * square)))


def _rows(count: int) -> str:
    return "1 row" if count == 1 else f"{count} rows"


def _listed(lines: list[int]) -> str:
    shown = ", ".join(str(line) for line in lines[:5])
    more = f" and {len(lines) - 5} more" if len(lines) > 5 else ""
    return f"line{'s' if len(lines) > 1 else ''} {shown}{more}"
