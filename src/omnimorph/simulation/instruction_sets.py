"""Which instruction set flies batches: the best that the processor has, or what a user asks for.

The core of `fly_many` is compiled for each or, tuned for one machine, for the best that it has. The
variable ``OMNIMORPH_SIMD`` names another.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import Any

from omnimorph import _core
from omnimorph.errors import InputError

VARIABLE = "OMNIMORPH_SIMD"


def _chosen() -> str:
    known = _core.instruction_sets()  # the best last
    if not known:
        raise InputError("omnimorph was built for another processor; install it again on this one.")
    asked = os.environ.get(VARIABLE, known[-1])
    if asked not in known:
        allowed = f"one that this processor has: {', '.join(known)}"
        raise InputError.at("the environment", VARIABLE, asked, allowed)
    return asked


INSTRUCTION_SET = _chosen()
"""The instruction set in use, such as ``x86-64-v3``."""


def batch_module() -> Any:
    """Return the compiled module that flies batches with this instruction set."""
    return import_module(f"omnimorph._batch_{INSTRUCTION_SET.replace('-', '_')}")
