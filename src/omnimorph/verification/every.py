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

_SUBJECTS = (
    *(wrench_map, force_sets, morphing, integration, momentum, motors),
    *(actuators, pushes, noise, stand, hovering, symmetry),
)

CASES: tuple[Case, ...] = tuple(
    one for subject in _SUBJECTS for one in vars(subject).values() if isinstance(one, Case)
)
"""Every case, from the model to the closed loop, in the order of its file."""


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
