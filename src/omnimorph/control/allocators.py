"""Allocation rules: how an acceleration becomes thrusts and a tilt under limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, Protocol

import numpy as np

from omnimorph.design.ranges import Range
from omnimorph.design.records import Record, choice, quantity
from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import FloatArray

Span = Literal["window", "range"]

_WEIGHT = "a number, or one for each rotor, none negative"

WEIGHTS = Range(1e-30, 1e30, or_zero=True)
"""Of every weight."""


@dataclass(frozen=True, kw_only=True)
class AllocationRule(Record):
    """Base of the rules that solve the paper's problem as a box QP in the thrusts.

    ::

        J = ‖u‖²_W1 + ‖q̈_r − q̈‖²_W2 + ‖u − u⁻‖²_W3       u = w|w| = f / c_f

    over ``f_min ≤ f ≤ f_max``, with the dynamics ``q̈ = M⁻¹(μ + J_R A(α) f)`` put in. In files the
    weights are those of the paper, for u in Hz²; here, as everywhere inside, for u in (rad/s)².

    Attributes
    ----------
    W1, W3 : float or (n,), s⁴/rad⁴
        Weights of the inputs and of their change from one control step to the next.
    W2_position : (3,), s⁴/m²
        Weights of the linear acceleration missed, in W.
    W2_attitude : (3,), s⁴/rad²
        Weights of the angular acceleration missed, in B.

    Notes
    -----
    Aboudorra et al. 2024, eqs. (15) and (16). Without W1 and W3 the QP would be singular where A
    is; the sum of both must be positive.
    """

    turns_servos: ClassVar[bool] = True

    W1: float | tuple[float, ...] = quantity("per_Hz4", WEIGHTS, _WEIGHT)
    W2_position: tuple[float, ...] = quantity(
        "s4_per_m2", WEIGHTS, "three numbers, none negative", length=3
    )
    W2_attitude: tuple[float, ...] = quantity(
        "s4_per_rad2", WEIGHTS, "three numbers, none negative", length=3
    )
    W3: float | tuple[float, ...] = quantity("per_Hz4", WEIGHTS, _WEIGHT)

    @classmethod
    def suits(cls, n_servos: int) -> bool:
        """Return whether the rule can be used for a vehicle of so many servos."""
        return True

    def core_rule(self) -> tuple[str, dict[str, object]]:
        """Return the core's name of the rule, and its settings there."""
        raise TypeError("only the rules made of it can allocate")

    def per_thrust(self, vehicle: Vehicle, name: str) -> FloatArray:
        """Return W1 or W3 as (n,) weights of thrust, 1/N²: W / c_f²."""
        weight = np.broadcast_to(np.asarray(getattr(self, name)), (vehicle.n_rotors,))
        return np.ascontiguousarray(weight / vehicle.thrust_coefficient**2)


@dataclass(frozen=True, kw_only=True)
class FixedTilt(AllocationRule):
    """The box QP at the tilt the vehicle starts with: what a vehicle that does not morph can do."""

    kind: ClassVar[str] = "fixed-tilt"
    turns_servos: ClassVar[bool] = False

    def core_rule(self) -> tuple[str, dict[str, object]]:
        """See `AllocationRule`."""
        return "fixed-tilt", {}


@dataclass(frozen=True, kw_only=True)
class ThreeCandidates(AllocationRule):
    """The paper's rule for one servo: the best of α⁻ − ε, α⁻ and α⁻ + ε.

    ε is the servo's rate limit times the control period; each candidate is held within the servo's
    limits; a tie goes to α⁻, so that a tilt that gains nothing does not move.
    """

    kind: ClassVar[str] = "three-candidates"

    @classmethod
    def suits(cls, n_servos: int) -> bool:
        """See `AllocationRule`."""
        return n_servos == 1

    def core_rule(self) -> tuple[str, dict[str, object]]:
        """See `AllocationRule`."""
        return "tilt-candidates", {"span": "window", "count": 3}


@dataclass(frozen=True, kw_only=True)
class ExhaustiveTilt(AllocationRule):
    """For one servo, the best of many tilts: the search that the paper leaves for future work.

    In a ``window``, `candidates` tilts evenly spaced from α⁻ − ε to α⁻ + ε, each held within the
    servo's limits, are tried and the cheapest is commanded; three of them are `ThreeCandidates`.

    Over the ``range``, α⁻ and `candidates` tilts evenly spaced from the servo's least to its
    largest angle are tried; the tilt goes from α⁻ towards the cheapest, by at most ε, and the
    thrusts are the best at the tilt it comes to. The cost there may be above that at α⁻, if the way
    to the cheapest tilt leads over a hill.

    ε is the servo's rate limit times the control period. A tie goes to α⁻ in both, so that a tilt
    that gains nothing does not move.

    Attributes
    ----------
    span : "window" or "range"
        Where the tilts lie that are tried.
    candidates : int
        How many of them are evenly spaced: odd, so that α⁻ is the middle of a window, and from 3
        to 361. The time a control step takes grows with them: four cost little more than one.

    Raises
    ------
    ScenarioError
        If a field is not allowed.

    Examples
    --------
    OmniMorph's servo turns by 0.4° in a control step of 4 ms, so with five candidates the tilts
    tried from 30° are 29.6°, 29.8°, 30°, 30.2° and 30.4°:

    >>> ExhaustiveTilt(
    ...     span="window",
    ...     candidates=5,
    ...     W1=0.0,
    ...     W2_position=(3e4, 3e4, 3e4),
    ...     W2_attitude=(10.0, 10.0, 10.0),
    ...     W3=6e-9,
    ... ).as_file()["candidates"]
    5
    """

    kind: ClassVar[str] = "exhaustive-tilt"

    span: Span = choice(("window", "range"), '"window" or "range"')
    candidates: int = choice(range(3, 362, 2), "an odd whole number from 3 to 361")

    @classmethod
    def suits(cls, n_servos: int) -> bool:
        """See `AllocationRule`."""
        return n_servos == 1

    def core_rule(self) -> tuple[str, dict[str, object]]:
        """See `AllocationRule`."""
        return "tilt-candidates", {"span": self.span, "count": self.candidates}


@dataclass(frozen=True, kw_only=True)
class JointTilt(AllocationRule):
    """Thrusts and all tilts at once, for any number of servos: a local minimum of the true cost.

    ::

        J(f, α) = ‖u‖²_W1 + ‖q̈_r − q̈(f, α)‖²_W2 + ‖u − u⁻‖²_W3 + W4 Σ_j ((α_j − α_j⁻) / ε_j)²

    over ``f_min ≤ f ≤ f_max``, ``|α_j − α_j⁻| ≤ ε_j`` and the angle limits of the servos, where ε_j
    is the rate limit of servo j times the control period. The thrusts are eliminated by their box
    QP, exactly, and the tilts go downhill by Newton's method within their bounds; a step counts
    only if J itself falls. With one servo the descent begins at the best of the three candidates
    of `ThreeCandidates`, whose cost it therefore never exceeds (if W4 is 0); with several at the
    tilts as they are, so that it never costs more than keeping them.

    Attributes
    ----------
    W4 : float, without unit
        What it costs to turn one servo by all that a control step allows, ε_j. 0 by default: none
        is needed, because a tilt that gains nothing, such as that of a rotor at rest, stays where
        it is. A positive one calms tilts that follow the noise of the measurements.

    Raises
    ------
    ScenarioError
        If a field is not allowed.

    Notes
    -----
    J is not convex in the tilts, so the answer is a minimum among its neighbours, not of all tilts
    within reach. ``kkt_residual`` of its allocations is that of J in thrusts and tilts.

    Examples
    --------
    The weights of the paper's Case B, which decide clearly on the tilt:

    >>> JointTilt(
    ...     W1=6.4e-9,
    ...     W2_position=(3e4, 3e4, 3e4),
    ...     W2_attitude=(10.0, 10.0, 10.0),
    ...     W3=6.4e-9,
    ... ).as_file()["W4"]
    0.0
    """

    kind: ClassVar[str] = "joint-tilt"

    W4: float = quantity("", WEIGHTS, "a number, not negative", length=0, default=0.0)

    @classmethod
    def suits(cls, n_servos: int) -> bool:
        """See `AllocationRule`."""
        return n_servos > 0

    def core_rule(self) -> tuple[str, dict[str, object]]:
        """See `AllocationRule`."""
        return "joint-tilt", {"tilt_change_weight": self.W4}


class HoldsRule(Protocol):
    """What has an allocation rule: a scenario, or a proposed controller."""

    @property
    def allocator(self) -> AllocationRule:
        """How thrusts and tilt are found."""
        ...


RuleLike = AllocationRule | HoldsRule
"""An allocation rule, or what holds one."""
