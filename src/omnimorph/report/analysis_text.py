"""Parts of what is said about an analysis: intervals, sums of thrusts, lost wrenches, ranks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from omnimorph.analysis.overview import AtTilt, VehicleAnalysis
from omnimorph.analysis.platform import Platform
from omnimorph.protocols import FloatArray
from omnimorph.report.tables import degrees, number

_WRENCH = (
    "force along x",
    "force along y",
    "force along z",
    "torque about x",
    "torque about y",
    "torque about z",
)


def listed(parts: Sequence[str]) -> str:
    """Return parts as a list in a sentence.

    Examples
    --------
    >>> listed(["roll"]), listed(["roll", "pitch", "yaw"])
    ('roll', 'roll, pitch and yaw')
    """
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def count_text(count: int, what: str) -> str:
    """Return a number with its noun: ``1 rotor``, ``8 rotors``, ``no servos``."""
    return f"{count or 'no'} {what}" + ("" if count == 1 else "s")


def intervals_text(intervals: FloatArray) -> str:
    """Return intervals of tilt, (K, 2), rad, as words.

    Examples
    --------
    >>> intervals_text(np.radians([[38.18, 60.0], [70.0, 70.0]]))
    'from 38.18° to 60° and at 70°'
    """
    parts = [
        f"from {degrees(begin)} to {degrees(end)}" if end - begin > 1e-9 else f"at {degrees(begin)}"
        for begin, end in intervals.tolist()
    ]
    return listed(parts)


def over_all_tilts_text(found: Platform) -> str:
    """Return the class and numbers of a vehicle over all its tilts, as `compare` shows them.

    Examples
    --------
    >>> import omnimorph as om
    >>> over_all_tilts_text(om.analysis.platform("omnimorph"))
    'fully actuated, redundant; omnidirectional; radius 1.31, sideways force 0.905 of the weight'
    """
    return (
        f"{found.vehicle_class}; radius {number(found.radius_over_weight, 3)}, sideways force "
        f"{number(found.lateral_over_weight, 3)} of the weight"
    )


def judged_text(found: Platform) -> str:
    """Return, for a vehicle of several servos, that it is judged with all at one tilt; else ""."""
    if not found.has_free_tilts:
        return ""
    return (
        f"This analysis judges all {found.n_servos} servos at one common tilt, or at the tilts "
        "asked for. With a tilt of its own for each servo, as omnimorph compare judges it: "
        f"{over_all_tilts_text(found)}."
    )


def condition_text(rows: FloatArray) -> str:
    """Return ``rows @ f ≠ 0`` as words: which sums of thrusts must not all be zero.

    Parameters
    ----------
    rows : (q, n) array
        One of `Actuation.conditions`; no rows stand for a condition that is never met.

    Examples
    --------
    >>> condition_text(np.array([[1.0, 0.0, -1.0], [0.0, 2.5, 0.0]]))
    'f₀ − f₂ or 2.5 f₁ not zero'
    """
    if not len(rows):
        return "never"
    return " or ".join(_sum_of_thrusts(row) for row in rows.tolist()) + " not zero"


def _sum_of_thrusts(row: Sequence[float]) -> str:
    terms = ""
    for i, factor in enumerate(row):
        if factor == 0.0:
            continue
        sign = "−" if factor < 0.0 else "+"
        size = "" if abs(abs(factor) - 1.0) < 1e-9 else f"{number(abs(factor), 3)} "
        name = "f" + "".join("₀₁₂₃₄₅₆₇₈₉"[int(digit)] for digit in str(i))
        if terms:
            terms += f" {sign} {size}{name}"
        else:
            terms = f"{sign if factor < 0.0 else ''}{size}{name}"
    return terms


def lost_text(lost: FloatArray) -> str:
    """Return the wrenches that no thrusts make, columns of a (6, q) array, as words.

    Along the axes of the body as far as they lie there, else their number.

    Examples
    --------
    >>> lost_text(np.eye(6)[:, :2])
    'force along x and force along y'
    """
    along = np.flatnonzero(np.linalg.norm(lost, axis=1) > 1.0 - 1e-9)
    names = [_WRENCH[k] for k in along]
    others = lost.shape[1] - len(names)
    if others:
        oblique = "a combination" if others == 1 else f"{others} combinations"
        names.append(f"{oblique} of forces and torques")
    return listed(names)


def singular_text(analysis: VehicleAnalysis) -> str:
    """Return where the rank of A falls: ``to 4 at 0° and 180°, to 5 at −90° and 90°``, or ""."""
    by_rank: dict[int, list[str]] = {}
    for one in sorted(analysis.singular, key=lambda one: (one.rank, one.tilt)):
        by_rank.setdefault(one.rank, []).append(degrees(one.tilt))
    return ", ".join(f"to {rank} at {listed(tilts)}" for rank, tilts in by_rank.items())


def rows_by_tilt(analysis: VehicleAnalysis) -> list[tuple[AtTilt, str]]:
    """Return the answers at the tilts that stand out, each once with all of its reasons."""
    rows: list[tuple[AtTilt, list[str]]] = []
    for one in analysis.at:
        near = next((why for row, why in rows if np.allclose(row.tilt, one.tilt, atol=1e-9)), None)
        if near is None:
            near = []
            rows.append((one, near))
        near += [reason for reason in one.why.split(", ") if reason and reason not in near]
    # tilts that all servos share in order; then one that differs from servo to servo
    rows.sort(key=lambda row: (len(set(row[0].tilt.tolist())) > 1, tuple(row[0].tilt)))
    return [(one, ", ".join(why)) for one, why in rows]
