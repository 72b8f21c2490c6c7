"""The public face: every name in omnimorph.__all__ is there and documented; importing is free."""

from __future__ import annotations

import importlib
import inspect
import subprocess
import sys
import types

import pytest

import omnimorph


@pytest.mark.parametrize("name", sorted(omnimorph.__all__))
def test_public_name_is_there_and_documented(name: str) -> None:
    thing = getattr(omnimorph, name)
    if inspect.isclass(thing) or inspect.isroutine(thing) or isinstance(thing, types.ModuleType):
        text = inspect.getdoc(thing)
        assert text, f"omnimorph.{name} has no docstring"
        assert not text.startswith(f"{name}("), f"omnimorph.{name} has only the generated docstring"


@pytest.mark.parametrize(
    "name",
    [
        "load_vehicle",
        "list_vehicles",
        "allocation_matrix",
        "full_allocation_matrix",
        "load_scenario",
        "list_scenarios",
        "fly",
        "load_run",
    ],
)
def test_promised_name_is_exported(name: str) -> None:
    assert name in omnimorph.__all__


def test_names_are_listed_once_and_shown_by_dir() -> None:
    assert len(omnimorph.__all__) == len(set(omnimorph.__all__))
    assert set(omnimorph.__all__) <= set(dir(omnimorph))


def test_star_import_brings_exactly_the_public_names() -> None:
    bag: dict[str, object] = {}
    exec("from omnimorph import *", bag)
    assert set(omnimorph.__all__) <= set(bag)


def test_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no_such_name"):
        importlib.import_module("omnimorph").no_such_name  # noqa: B018


def test_importing_does_no_work() -> None:
    program = (
        "import sys, omnimorph\n"
        "print(sorted({name.split('.')[0] for name in sys.modules}))\n"
        "print('omnimorph._core' in sys.modules)"
    )
    answer = subprocess.run(
        [sys.executable, "-W", "error", "-c", program], capture_output=True, text=True, check=True
    )
    loaded, core = answer.stdout.splitlines()
    heavy = ["numpy", "scipy", "daqp", "pydantic", "h5py", "matplotlib", "jinja2", "rich"]
    assert [name for name in heavy if f"'{name}'" in loaded] == []
    assert core == "False"
