"""Peers that are not installed: named, never an error."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = ["NotInstalled", "imported"]


class NotInstalled(Exception):
    """A peer that cannot be imported; its text is the sentence that tells so."""


def imported(package: str) -> Any:
    """Return a package by its name.

    Raises
    ------
    NotInstalled
        If it is not there, or does not work here.
    """
    try:
        return import_module(package)
    except Exception as problem:  # whatever it does at import is not our mistake
        hint = "`pip install 'omnimorph[bench]'` brings it"
        raise NotInstalled(f"{package} is not measured: {problem}; {hint}.") from None
