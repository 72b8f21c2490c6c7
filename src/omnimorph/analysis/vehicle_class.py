"""What class a vehicle belongs to: the one definition for a single tilt and for a whole vehicle.

Source: Hamandi et al., "Design of multirotor aerial vehicles: A taxonomy based on input
allocation", IJRR 2021. Forces count at zero moment only: what rotors push while they turn the
vehicle as well holds no attitude, so a quadrotor with canted rotors is as uni-directional as one
without.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class ActuationKind(Enum):
    """How much of the wrench can be changed at once, from rank F and the number of rotors."""

    UNDER_ACTUATED = "under-actuated"
    """rank F < 6: there is a direction in which the wrench cannot be changed."""
    FULLY_ACTUATED = "fully actuated"
    """rank F = 6, with no thrusts to spare or only while the servos move."""
    REDUNDANT = "fully actuated, redundant"
    """rank A = 6 with more than six rotors: many thrusts make the same wrench."""


class ThrustKind(Enum):
    """In how many directions the total thrust can point at zero moment."""

    NONE = "no thrust at zero moment"
    """Every thrust turns the vehicle: the zero-moment force set is a point, or empty."""
    UNI_DIRECTIONAL = "uni-directional thrust"
    """Along one line of the body: the zero-moment force set has one dimension."""
    MULTI_DIRECTIONAL = "multi-directional thrust"
    """In a plane or in space, but the weight cannot be held in every attitude."""
    OMNIDIRECTIONAL = "omnidirectional"
    """In every attitude it can hover: the zero-moment force set holds the weight sphere."""


class VehicleClass(NamedTuple):
    """Both kinds.

    Attributes
    ----------
    actuation : ActuationKind
    thrust : ThrustKind

    Examples
    --------
    >>> str(VehicleClass(ActuationKind.FULLY_ACTUATED, ThrustKind.OMNIDIRECTIONAL))
    'fully actuated; omnidirectional'
    """

    actuation: ActuationKind
    thrust: ThrustKind

    def __str__(self) -> str:
        return f"{self.actuation.value}; {self.thrust.value}"


def actuation_kind(rank_thrust: int, rank_full: int, n_rotors: int) -> ActuationKind:
    """Return the kind that belongs to the ranks of A and F.

    Parameters
    ----------
    rank_thrust, rank_full : int
        Of A and of F = [A | ∂(A f)/∂α].
    n_rotors : int

    Examples
    --------
    >>> actuation_kind(6, 6, 8).value, actuation_kind(4, 6, 4).value, actuation_kind(4, 4, 8).value
    ('fully actuated, redundant', 'fully actuated', 'under-actuated')
    """
    if rank_full < 6:
        return ActuationKind.UNDER_ACTUATED
    if rank_thrust == 6 and n_rotors > 6:
        return ActuationKind.REDUNDANT
    return ActuationKind.FULLY_ACTUATED


def thrust_kind(dimension: int, radius: float, weight: float) -> ThrustKind:
    """Return the kind that belongs to a set of forces at zero moment.

    Parameters
    ----------
    dimension : int
        Of the set; −1 if it is empty.
    radius : float, N
        Of its inscribed sphere.
    weight : float, N
        m g.

    Examples
    --------
    >>> [thrust_kind(d, r, 10.0).value for d, r in ((1, 0.0), (3, 9.0), (3, 10.0))]
    ['uni-directional thrust', 'multi-directional thrust', 'omnidirectional']
    """
    # the slack lets the end of an interval of tilt, where they are equal, be part of it
    if dimension == 3 and radius >= (1.0 - 1e-9) * weight:
        return ThrustKind.OMNIDIRECTIONAL
    if dimension >= 2:
        return ThrustKind.MULTI_DIRECTIONAL
    return ThrustKind.UNI_DIRECTIONAL if dimension == 1 else ThrustKind.NONE
