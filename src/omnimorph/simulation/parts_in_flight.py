"""Parts of the loop that are written in Python, and may remember something, fly once at a time.

Shared by two flights at once, such a part would mix them up, differently each time.
"""

from __future__ import annotations

import inspect
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from omnimorph.errors import ScenarioError
from omnimorph.reference.samples import SampledReference

__all__ = ["in_flight"]

_lock = threading.Lock()
_flying: set[int] = set()  # identities of the parts under way


@contextmanager
def in_flight(parts: Mapping[str, object]) -> Iterator[None]:
    """Keep the parts of one flight, by name, from any other as long as it takes; None is no part.

    Raises
    ------
    ScenarioError
        If a part cannot be called, or is flying already.
    """
    mine = {}
    for name, part in parts.items():
        if part is not None and not callable(part):
            allowed = "an object that can be called, see omnimorph.protocols"
            raise ScenarioError.at("fly", name, part, allowed)
        if part is not None and not _is_stateless(part):
            mine[id(getattr(part, "__self__", part))] = name  # of a method, its object
    with _lock:
        for identity in mine.keys() & _flying:
            raise ScenarioError(
                f"fly: the {mine[identity]} is flying already; what it remembers belongs to one "
                "flight, so give each its own."
            )
        _flying.update(mine)
    try:
        yield
    finally:
        with _lock:
            _flying.difference_update(mine)


def _is_stateless(part: object) -> bool:
    """Return whether a part surely remembers nothing: a plain function or a frozen record."""
    if inspect.isfunction(part):
        return part.__closure__ is None
    settings = getattr(type(part), "__dataclass_params__", None)
    return isinstance(part, SampledReference) or (settings is not None and settings.frozen)
