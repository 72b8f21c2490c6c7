"""Wrong units, recognised by the factor they leave behind.

A speed written in another unit than its column says is off by a factor of 2π, 60 or 60/2π, a
coefficient of force or torque per squared speed by its square. `check_ratio` finds the first beside
a second speed, `check_expected` the second beside coefficients that were expected, and
`torque_hint` a torque that does not fit its force.
"""

from __future__ import annotations

import math

from omnimorph.design.unit_doubts import USUAL_KAPPA
from omnimorph.errors import InputError
from omnimorph.units import SPEED_SLIPS, SPEED_UNITS, unit_of

_CLOSE = 0.05  # relative: two readings of one speed
_ALIKE = 0.35  # relative: two propellers of one kind; (2π)² = 39 and 60²/(2π)² = 91 stay apart
_TORQUE_UNITS = {"N cm": 1e-2, "N mm": 1e-3, "kgf cm": 9.80665e-2, "oz in": 7.0616e-3}
_FORCE_UNITS = {"gf": 9.80665e-3, "kgf": 9.80665, "lbf": 4.44822}


def check_ratio(path: str, first: str, second: str, ratio: float) -> None:
    """Refuse two columns whose speeds differ, within 5 %, by the factor between two units.

    `ratio` says how many times the second the first is, both converted as the units at the end of
    their names say. The refusal names the units that the numbers look like.
    """
    suspects = []
    if not 0.0 < ratio < math.inf:  # one of them rests all the time
        return
    for name, too_large in ((first, ratio), (second, 1.0 / ratio)):
        for mistake in SPEED_SLIPS:
            near = abs(too_large / mistake.factor - 1.0) < _CLOSE
            if near and mistake.said == unit_of(name):
                suspects.append(f"the numbers under {name} look like {SPEED_UNITS[mistake.meant]}")
    if suspects:
        words = next(m.words for m in SPEED_SLIPS if abs(ratio / m.factor - 1.0) < _CLOSE)
        sentence = f"{path}: {first} is {ratio:.4g} times {second}, which is {words}: "
        sentence += f"{', or '.join(suspects)}."
        raise InputError(sentence, file=path, key=first, value=ratio)


def check_expected(
    source: str, thrust: float, drag: float, thrust_expected: float, drag_expected: float | None
) -> None:
    """Refuse coefficients that differ from those expected by the factor of a wrong unit.

    All are in SI. They do if the ratio is within 35 % of the square of a factor between units of
    speed, or of the factor of a unit of force; the refusal names the unit that is likely.
    """
    ratio = thrust / thrust_expected
    drag_ratio = ratio if drag_expected is None else drag / drag_expected
    for mistake in SPEED_SLIPS:
        too_large = mistake.factor**-2
        if all(_alike(found, too_large) for found in (ratio, drag_ratio)):
            raise InputError(
                f"{source}: the thrust coefficient is {ratio:.3g} times the one expected, about "
                f"{mistake.of_coefficient}: the speeds look like {SPEED_UNITS[mistake.meant]} "
                f"where {SPEED_UNITS[mistake.said]} is said.",
                file=source,
                key="speed",
                value=ratio,
            )
    for unit, size in _FORCE_UNITS.items():
        if _alike(ratio, 1.0 / size) and (drag_expected is None or _alike(drag_ratio, 1.0)):
            raise InputError(
                f"{source}: the thrust coefficient is {ratio:.3g} times the one expected; the "
                f"forces look like {unit} where N is said.",
                file=source,
                key="force",
                value=ratio,
            )


def _alike(found: float, factor: float) -> bool:
    return found > 0.0 and abs(math.log(found / factor)) < _ALIKE


def torque_hint(drag_to_thrust: float) -> str:
    """Return a sentence on a torque that does not fit its force, "" if it does.

    Torque over force, κ = c_τ/c_f, is a length, m, that grows with the propeller: 0.005 to 0.05 m
    for those of 4 to 30 inches. The unit of the speed does not change it.
    """
    low, high = USUAL_KAPPA
    if low <= drag_to_thrust <= high:
        return ""
    sentence = f"Torque over force is {drag_to_thrust:.3g} m, and {low:g} to {high:g} m is usual"
    likely = [
        f"torque in {unit} ({drag_to_thrust * size:.2g} m)"
        for unit, size in _TORQUE_UNITS.items()
        if low <= drag_to_thrust * size <= high
    ]
    likely += [
        f"force in {unit} ({drag_to_thrust / size:.2g} m)"
        for unit, size in _FORCE_UNITS.items()
        if low <= drag_to_thrust / size <= high
    ]
    return f"{sentence}; it would be with {' or '.join(likely)}." if likely else f"{sentence}."
