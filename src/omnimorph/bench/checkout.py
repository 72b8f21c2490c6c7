"""The benchmarks that come with the repository only, such as the peers of ``bench --peers``."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from types import ModuleType

from omnimorph.errors import InputError
from omnimorph.version import __version__


def import_peers() -> ModuleType:
    """Import ``benchmarks.peers`` of the checkout this package lies in, or else we stand in.

    Code is imported from a folder that says in its ``pyproject.toml`` that it is this version of
    omnimorph, and from no other.

    Raises
    ------
    InputError
        If neither is such a checkout.
    """
    here = Path.cwd()
    root = find_checkout([*Path(__file__).parents, here, *here.parents])
    if root is None:
        raise InputError(
            "bench --peers: the peers are in benchmarks/peers of the repository, not in the "
            f"installed package; run it in a checkout of omnimorph {__version__}."
        )
    if str(root) not in sys.path:  # processes that are spawned look there, too
        sys.path.insert(0, str(root))
    return import_module("benchmarks.peers")


def find_checkout(folders: Iterable[Path]) -> Path | None:
    """Return the first of the folders that is a checkout of this version, None if none is."""
    for folder in folders:
        try:
            project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            continue
        named = project.get("project")
        if (
            isinstance(named, dict)
            and (named.get("name"), named.get("version")) == ("omnimorph", __version__)
            and (folder / "benchmarks" / "peers" / "__init__.py").is_file()
        ):
            return folder
    return None
