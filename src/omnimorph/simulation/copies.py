"""Copies of parts of one's own, so that no two flights share what they remember."""

from __future__ import annotations

import copy
from functools import partial
from types import CellType, FunctionType, ModuleType
from typing import Any


def copied(part: Any, memo: dict[int, Any]) -> Any:
    """Return a deep copy, in which a function has its own copy of the variables that it shares.

    `copy.deepcopy` takes a function for a constant, though it may keep in such a variable what it
    remembers.

    Examples
    --------
    >>> def counting():
    ...     calls = []
    ...     return lambda: calls.append(0) or len(calls)
    >>> one = counting()
    >>> other = copied(one, {})
    >>> one(), one(), other()
    (1, 2, 1)
    """
    if id(part) in memo:
        return memo[id(part)]
    if isinstance(part, ModuleType):
        return part
    if isinstance(part, partial):
        given = [copied(one, memo) for one in part.args]
        named = {name: copied(one, memo) for name, one in part.keywords.items()}
        return partial(copied(part.func, memo), *given, **named)
    if not isinstance(part, FunctionType) or part.__closure__ is None:
        return copy.deepcopy(part, memo)
    cells = tuple(memo.setdefault(id(cell), CellType()) for cell in part.__closure__)
    new = FunctionType(part.__code__, part.__globals__, part.__name__, part.__defaults__, cells)
    vars(new).update(vars(part))
    new.__kwdefaults__, new.__qualname__ = part.__kwdefaults__, part.__qualname__
    memo[id(part)] = new
    for old, cell in zip(part.__closure__, cells, strict=True):
        if not _is_empty(old) and _is_empty(cell):
            cell.cell_contents = copied(old.cell_contents, memo)
    return new


def _is_empty(cell: CellType) -> bool:
    try:
        cell.cell_contents  # noqa: B018
    except ValueError:
        return True
    return False
