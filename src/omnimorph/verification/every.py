"""All cases, subject by subject, and the loop that runs them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from omnimorph.verification import (
    actuators,
    force_sets,
    hovering,
    integration,
    momentum,
    morphing,
    motors,
    noise,
    pushes,
    stand,
    symmetry,
    wrench_map,
)
from omnimorph.verification.case import Case, Result

__all__ = ["CASES", "run_cases"]

CASES: tuple[Case, ...] = (
    *wrench_map.CASES,
    *force_sets.CASES,
    *morphing.CASES,
    *integration.CASES,
    *momentum.CASES,
    *motors.CASES,
    *actuators.CASES,
    *pushes.CASES,
    *noise.CASES,
    *stand.CASES,
    *hovering.CASES,
    *symmetry.CASES,
)
"""Every case, from the model to the closed loop."""


def run_cases(
    progress: Callable[[int, int], None] | None = None, cases: Sequence[Case] = CASES
) -> list[Result]:
    """Run every case, one after the other.

    Parameters
    ----------
    progress : callable, optional
        Called after each case with the number done and the number of all.
    cases : sequence of Case
        Others than all.

    Returns
    -------
    list of Result
        In the order of the cases.
    """
    results = []
    for done, one in enumerate(cases, start=1):
        results.append(one.run())
        if progress is not None:
            progress(done, len(cases))
    return results
