"""What is drawn of a run: curves over time, in the units people read."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.results.run import Run

_DIRECTIONS = ("x", "y", "z")


class AttitudeError(NamedTuple):
    """The attitude error over time, (K,) arrays."""

    angle_deg: FloatArray  # geodesic angle between R and R_d, 0 to 180 degrees
    sine: FloatArray  # ‖e_R‖, what the paper calls attitude error: the sine of that angle


class Phase(NamedTuple):
    """One part of the flight: from when to when (s), and a label of a few letters."""

    begin: float
    end: float
    label: str


def position_error_mm(run: Run) -> FloatArray:
    """Return ‖p − p_d‖ in mm, (K,)."""
    distance: FloatArray = 1e3 * np.linalg.norm(run.p_WB - run.desired_p_WB, axis=1)
    return distance


def attitude_error(run: Run) -> AttitudeError:
    """Return the geodesic angle and ‖e_R‖, e_R = ½ (Rᵀ R_d − R_dᵀ R)^∨.

    tan θ = ‖e_R‖ / ((tr(Rᵀ R_d) − 1) / 2) is exact for every angle, small ones included.
    """
    return attitude_error_between(run.R_WB, run.desired_R_WB)


def attitude_error_between(R: FloatArray, R_d: FloatArray) -> AttitudeError:
    """Return the same between attitudes, (K, 3, 3) each."""
    E = np.swapaxes(R, 1, 2) @ R_d
    e_R = 0.5 * np.stack(
        [E[:, 2, 1] - E[:, 1, 2], E[:, 0, 2] - E[:, 2, 0], E[:, 1, 0] - E[:, 0, 1]]
    )
    sine = np.linalg.norm(e_R, axis=0)
    cosine = 0.5 * (np.trace(E, axis1=1, axis2=2) - 1.0)
    return AttitudeError(np.degrees(np.arctan2(sine, cosine)), sine)


def rotation_about_x_deg(R: FloatArray) -> FloatArray:
    """Return the angle about x of attitudes (K, 3, 3), degrees, without jumps at ±180.

    For R = exp(φ [x]×) it is φ; other rotations are projected: atan2(R₃₂, R₂₂).

    Examples
    --------
    >>> phi = np.radians([0.0, 90.0, 179.0, 270.0])
    >>> c, s, o = np.cos(phi), np.sin(phi), np.zeros(4)
    >>> R = np.stack([o + 1, o, o, o, c, -s, o, s, c], axis=1).reshape(4, 3, 3)
    >>> rotation_about_x_deg(R).round(9).tolist()
    [0.0, 90.0, 179.0, 270.0]
    """
    return np.degrees(np.unwrap(np.arctan2(R[:, 2, 1], R[:, 1, 1])))


def drag_energy_J(run: Run) -> FloatArray:
    """Return the rotor drag energy since the start, in J, (K,); its end is the metric."""
    energy: FloatArray = np.cumsum(run.drag_power) * run.provenance.physics_step
    energy -= energy[0]  # the speed in a row acted over the step before it: row 0 over none
    return energy


def phases(run: Run) -> list[Phase]:
    """Return the segments of the run's reference with short labels; none if it has no segments.

    A label is the axis of the move with its sign (``+y``), the angle of the turn (``30°``), or
    ``rest``.
    """
    found, begin = [], 0.0
    try:
        for segment in run.provenance.scenario.get("reference", {}).get("segment", []):
            end = begin + float(segment["duration_s"])
            found.append(Phase(begin, end, _label(segment)))
            begin = end
    except (AttributeError, KeyError, TypeError, ValueError, IndexError):
        return []  # a file of another writer
    return found


def _label(segment: dict[str, object]) -> str:
    angle = float(segment.get("rotation_angle_deg", 0.0))  # type: ignore[arg-type]
    move = np.asarray(segment.get("move_m", np.zeros(3)), dtype=np.float64)
    if angle:
        return f"{angle:+.0f}°".replace("-", "−")
    if move.any():
        axis = int(np.abs(move).argmax())
        return ("+" if move[axis] > 0 else "−") + _DIRECTIONS[axis]
    return "rest"
