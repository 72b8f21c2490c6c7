"""A fit of a rotor as plain data, and as lines for a vehicle file."""

from __future__ import annotations

from typing import Any

import numpy as np

from omnimorph.identification.coefficients import CoefficientFit, Estimate
from omnimorph.identification.rotor_fit import RotorFit
from omnimorph.units import from_SI

FIT_SCHEMA = "omnimorph-fit-1"
"""What ``results.json`` says it is."""


def fit_data(fit: RotorFit) -> dict[str, Any]:
    """Return every number of a fit, the unit at the end of its key; None for what is not known.

    Parameters
    ----------
    fit : RotorFit
        Of any run.
    """
    lines = fit.bench.lines
    return {
        "schema": FIT_SCHEMA,
        "source": fit.bench.source,
        "rows": len(lines),
        "confidence_percent": 95.0,
        "thrust_coefficient_N_per_Hz2": _coefficient(fit.thrust, "N_per_Hz2"),
        "drag_coefficient_Nm_per_Hz2": _coefficient(fit.drag, "Nm_per_Hz2"),
        "drag_to_thrust_m": fit.drag_to_thrust,
        "torque_has_the_sign_of_the_speed": not fit.torque_felt,
        "force_noise_N": fit.thrust.noise,
        "torque_noise_Nm": fit.drag.noise,
        "force_outlier_lines": [lines[row] for row in np.flatnonzero(fit.thrust.outlier)],
        "torque_outlier_lines": [lines[row] for row in np.flatnonzero(fit.drag.outlier)],
        "speed_min_Hz": from_SI(fit.speed_min, "Hz"),
        "speed_max_Hz": from_SI(fit.speed_max, "Hz"),
        "time_constant_up_ms": _estimate(fit.time_constant_up, "ms"),
        "time_constant_down_ms": _estimate(fit.time_constant_down, "ms"),
        "steps": [
            {
                "line": lines[step.begin],
                "up": step.up,
                "time_constant_ms": _estimate(step.time_constant, "ms"),
            }
            for step in fit.steps
        ],
        "warnings": list(fit.warnings),
    }


def _coefficient(fit: CoefficientFit, unit: str) -> dict[str, Any]:
    return {
        "both": _estimate(fit.both, unit),
        "forward": _estimate(fit.forward, unit),
        "reverse": _estimate(fit.reverse, unit),
        "separate": fit.separate,
    }


def _estimate(estimate: Estimate | None, unit: str) -> dict[str, float] | None:
    if estimate is None:
        return None
    return {name: from_SI(value, unit) for name, value in estimate._asdict().items()}


def vehicle_lines(fit: RotorFit) -> str:
    """Return the fit as lines for ``[rotor_defaults]`` or ``[[rotor]]`` of a vehicle file.

    Numbers are rounded to a hundredth of the half width of their interval; it stands beside them.

    Parameters
    ----------
    fit : RotorFit
        Of any run.
    """
    lines = []
    for key, unit, estimate in (
        ("thrust_coefficient_N_per_Hz2", "N_per_Hz2", fit.thrust.value),
        ("drag_coefficient_Nm_per_Hz2", "Nm_per_Hz2", fit.drag.value),
    ):
        lines.append(_line(key, unit, estimate))
    for key, fitted in (("thrust", fit.thrust), ("drag", fit.drag)):
        if fitted.separate and fitted.reverse is not None:
            unit = "N_per_Hz2" if key == "thrust" else "Nm_per_Hz2"
            reverse = _line(f"{key}_coefficient_{unit}", unit, fitted.reverse)
            lines.append(f"# in reverse: {reverse}")
    lines.append(f"speed_min_Hz = {from_SI(fit.speed_min, 'Hz'):.5g}  # the lowest seen")
    lines.append(f"speed_max_Hz = {from_SI(fit.speed_max, 'Hz'):.5g}  # the highest seen")
    for key, constant in (
        ("time_constant_up_ms", fit.time_constant_up),
        ("time_constant_down_ms", fit.time_constant_down),
    ):
        if constant is not None:
            lines.append(_line(key, "ms", constant))
    return "\n".join(lines)


def _line(key: str, unit: str, estimate: Estimate) -> str:
    value, low, high = (from_SI(number, unit) for number in estimate)
    half = 0.5 * (high - low)
    digits = 10
    if half > 0.0:
        digits = min(max(int(np.ceil(np.log10(abs(value) / half))) + 2, 3), 10)
    return f"{key} = {value:.{digits}g}  # 95 %: {low:.{digits}g} to {high:.{digits}g}"
