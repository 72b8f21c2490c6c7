"""Peers that are not installed: named, never an error."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from collections.abc import Iterator
from importlib import import_module
from typing import Any

__all__ = ["NotInstalled", "imported", "quiet"]


class NotInstalled(Exception):
    """A peer that cannot be imported; its text is the sentence that says so."""


def imported(package: str) -> Any:
    """Return a package by its name.

    Raises
    ------
    NotInstalled
        If it is not there, or does not work here.
    """
    try:
        with quiet():
            return import_module(package)
    except Exception as problem:  # whatever it does at import is not our mistake
        hint = "`pip install 'omnimorph[bench]'` brings it"
        raise NotInstalled(f"{package} is not measured: {problem}; {hint}.") from None


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Keep what a peer prints, compiled code included, from the terminal."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(stream) for stream in (1, 2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for stream in (1, 2):
            os.dup2(nowhere, stream)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for stream, copy in zip((1, 2), kept, strict=True):
            os.dup2(copy, stream)
            os.close(copy)
        os.close(nowhere)
