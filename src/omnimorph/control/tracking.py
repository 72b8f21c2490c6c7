"""Pose tracking: the acceleration that leads back to the reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from omnimorph.design.ranges import Range
from omnimorph.design.records import Record, quantity
from omnimorph.protocols import FloatArray

Gain = float | tuple[float, ...]
_ALLOWED = "one number, or three (x, y, z), none negative"
_GAINS = Range(0.0, 1e12)


@dataclass(frozen=True, kw_only=True)
class TrackingGains(Record):
    """Gains of the pose controller, the paper's values by default.

    ::

        p̈_r = p̈_d + velocity (v_d − v) + position (p_d − p)
        ω̇_r = RᵀR_d ω̇_d − ω × RᵀR_d ω_d + rate (RᵀR_d ω_d − ω) + attitude e_R
        e_R  = ½ (RᵀR_d − R_dᵀR)^∨

    Attributes
    ----------
    position, attitude : float or three, 1/s²
        The paper's K_p2 and K_ω2.
    velocity, rate : float or three, 1/s
        The paper's K_p1 and K_ω1.

    Notes
    -----
    Aboudorra et al. 2024, eq. (14); the desired rate is carried into the vehicle's frame by RᵀR_d,
    which the paper leaves out. e_R vanishes at an attitude error of 180° too: there the controller
    does not turn back by itself.
    """

    kind: ClassVar[str] = "pose-tracking"

    position: Gain = quantity("per_s2", _GAINS, _ALLOWED, length=3, default=300.0)
    velocity: Gain = quantity("per_s", _GAINS, _ALLOWED, length=3, default=30.0)
    attitude: Gain = quantity("per_s2", _GAINS, _ALLOWED, length=3, default=100.0)
    rate: Gain = quantity("per_s", _GAINS, _ALLOWED, length=3, default=40.0)

    def axes(self, name: str) -> FloatArray:
        """Return the gain `name` as (3,) numbers, one for each axis."""
        return np.broadcast_to(np.asarray(getattr(self, name), dtype=np.float64), (3,)).copy()


class HoldsGains(Protocol):
    """What has gains: a scenario, or a proposed controller."""

    @property
    def gains(self) -> TrackingGains:
        """Of the pose controller."""
        ...


GainsLike = TrackingGains | HoldsGains
"""Gains, or what holds them."""
