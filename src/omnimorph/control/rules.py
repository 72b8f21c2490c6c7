"""Every allocation rule that a file can name."""

from __future__ import annotations

from omnimorph.control.allocators import (
    AllocationRule,
    ExhaustiveTilt,
    FixedTilt,
    JointTilt,
    ThreeCandidates,
)

RULES: tuple[type[AllocationRule], ...] = (
    ThreeCandidates,
    ExhaustiveTilt,
    JointTilt,
    FixedTilt,
)
