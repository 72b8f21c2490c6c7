"""List the vehicles of the catalogue; or show one, with the source of every number."""

from __future__ import annotations

import argparse
import tomllib
from typing import TYPE_CHECKING, Any

from omnimorph.cli import console
from omnimorph.cli.arguments import one_of_the_list
from omnimorph.cli.console import counted

if TYPE_CHECKING:
    from omnimorph import Vehicle

SUMMARY = "list the vehicles, or show one with the source of every number"
NEEDS = ("omnimorph.design.schema",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    one_of_the_list(parser, "vehicle")


def answer(options: argparse.Namespace) -> console.Answer:
    """List the catalogue, or show one vehicle."""
    import omnimorph as om

    if options.vehicle is not None:
        return _one(om.load_vehicle(options.vehicle))
    vehicles = [om.load_vehicle(name) for name in om.list_vehicles()]
    rows = [
        [item.name, str(item.n_rotors), str(item.n_servos), console.number(item.mass), item.title]
        for item in vehicles
    ]
    header = ["name", "rotors", "servos", "mass_kg", "title"]
    text = console.table(rows, header=header, align="lrrr")
    return console.Answer(
        text=f"{text}\n\n`omnimorph vehicles NAME` shows where the numbers of one come from.",
        data=[
            {
                "name": item.name,
                "rotors": item.n_rotors,
                "servos": item.n_servos,
                "mass_kg": item.mass,
                "title": item.title,
            }
            for item in vehicles
        ],
    )


def _one(vehicle: Vehicle) -> console.Answer:
    from omnimorph.design import vehicle_text

    content = tomllib.loads(vehicle_text(vehicle))  # the numbers in the units that people read
    sections = [
        f"{vehicle.name}: {vehicle.title}".rstrip(": "),
        f"{counted(vehicle.n_rotors, 'rotor')}, {counted(vehicle.n_servos, 'servo')}; "
        "x forward, y left, z up from the centre of mass.",
        _rotors(content),
        "Every number and where it comes from; * marks those that nobody published and we assumed.",
        console.table(_numbers(content), header=["", "key", "value", "source"]),
    ]
    return console.Answer(text="\n\n".join(sections), data=content)


def _rotors(content: dict[str, Any]) -> str:
    """Return the table of what differs from rotor to rotor, counted from 0."""
    keys = list(dict.fromkeys(key for rotor in content["rotor"] for key in rotor))
    rows = [
        [str(index), *(_shown(rotor.get(key)) for key in keys)]
        for index, rotor in enumerate(content["rotor"])
    ]
    return console.table(rows, header=["rotor", *keys], align="r")


def _numbers(content: dict[str, Any]) -> list[list[str]]:
    """Return a row for each key: mark, key, value, source."""
    of_body = ("mass_kg", "tilt_mechanism_mass_kg", "inertia_kg_m2")
    values: dict[str, Any] = {key: content[key] for key in of_body if key in content}
    in_table = dict.fromkeys(key for rotor in content["rotor"] for key in rotor)
    values |= {f"rotor.{key}": "above" for key in in_table}
    values |= {f"rotor.{key}": value for key, value in content["rotor_defaults"].items()}
    for servo in content.get("servo", []):
        for key, value in servo.items():
            values.setdefault(f"servo.{key}", []).append(value)
    values["filter"] = list(content["filter"].values())
    rows = []
    for key, value in values.items():
        assumed = content["assumed"].get(key)
        none = "" if key == "servo.name" else "no source given"
        source = assumed or content["sources"].get(key, none)
        rows.append(["*" if assumed else "", key, _shown(value), source])
    return rows


def _shown(value: Any) -> str:
    if isinstance(value, list):
        items = [_shown(item) for item in value]
        return items[0] if len(items) == 1 else f"[{', '.join(items)}]"
    return console.number(value) if isinstance(value, int | float) else str(value or "—")
