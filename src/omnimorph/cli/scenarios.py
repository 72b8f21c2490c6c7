"""List the scenarios; or show one with everything that is flown."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from typing import Any

from omnimorph.cli import console
from omnimorph.cli.arguments import allow_code, one_of_the_list

SUMMARY = "list the scenarios, or show one with everything in it"
NEEDS = ("omnimorph.simulation.scenario_schema",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    one_of_the_list(parser, "scenario")
    allow_code(parser)


def answer(options: argparse.Namespace) -> console.Answer:
    """List the scenarios, or show one."""
    import omnimorph as om

    if options.scenario is not None:
        return _one(om.load_scenario(options.scenario, allow_code=options.allow_code))
    found = [
        {
            "name": item.name,
            "duration_s": item.reference.duration,
            "vehicle": item.vehicle.name,
            "plant": item.plant.name,
            "title": item.title,
        }
        for item in map(om.load_scenario, om.list_scenarios())
    ]
    rows = [[_shown(value) for value in item.values()] for item in found]
    text = console.table(rows, header=list(found[0]), align="lr")
    return console.Answer(text=f"{text}\n\n`omnimorph fly NAME` flies one.", data=found)


def _one(scenario: Any) -> console.Answer:
    content = json.loads(json.dumps(scenario.as_file()))
    title = f"{scenario.name}: {scenario.title}".rstrip(": ")
    rows = [[key, value] for key, value in _leaves(content) if key not in ("name", "title")]
    lasts = f"It lasts {scenario.reference.duration:g} s."
    return console.Answer(text=f"{title}\n{lasts}\n\n{console.table(rows)}", data=content)


def _leaves(content: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield every value of a nested document with its key: ``plant.effects[0].kind``."""
    if isinstance(content, dict):
        for key, value in content.items():
            yield from _leaves(value, f"{path}.{key}".removeprefix("."))
    elif isinstance(content, list) and any(isinstance(item, dict) for item in content):
        for index, value in enumerate(content):
            yield from _leaves(value, f"{path}[{index}]")
    else:
        yield path, _shown(content)


def _shown(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(_shown(item) for item in value)}]"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    return console.number(value)
