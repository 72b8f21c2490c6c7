"""Cases with known answers: one source for the tests and for ``omnimorph verify``.

Each case makes one claim about the model or the simulation, measures it through the public names,
and compares with a number that is known from elsewhere: a closed form, a law of conservation, a
published figure. ::

    for result in run_cases():
        print(result.name, "passed" if result.passed else "FAILED", result.value)

A case is written once, in the file of its subject, as a function with the claim for its docstring.
"""

from __future__ import annotations

from omnimorph.verification.case import Case, Result
from omnimorph.verification.every import CASES, run_cases

__all__ = ["CASES", "Case", "Result", "run_cases"]
