"""Write a vehicle file to start from."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from omnimorph.cli import console
from omnimorph.cli.arguments import positive_number
from omnimorph.design.new_vehicle import KINDS, new_vehicle_text
from omnimorph.errors import InputError

SUMMARY = "write a commented vehicle file that already flies, to start from"
NEEDS = ()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument("name", metavar="NAME", help="of the vehicle; the file is NAME.toml")
    parser.add_argument(
        "--rotors",
        type=positive_number("--rotors"),
        default=6,
        metavar="N",
        help="how many, on a circle (default: 6)",
    )
    parser.add_argument(
        "--kind",
        choices=KINDS,
        default="fixed",
        help="how they tilt: not at all, together by one servo, each by its own (default: fixed)",
    )


def answer(options: argparse.Namespace) -> console.Answer:
    """Write the file, unless there is one, and say what to do with it."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]*(?<!\.toml)", options.name):
        allowed = "letters, digits, `.`, `_` and `-`, a letter or digit first, without .toml"
        raise InputError.at("new-vehicle", "NAME", options.name, allowed)
    path = Path(f"{options.name}.toml")
    text = new_vehicle_text(options.name, options.rotors, options.kind)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise InputError(f"{path}: it is there already; it is not written over.") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}.") from error
    text = (
        f"Written: {path}. Look at it, then\n"
        f"  omnimorph analyze {path}\n  omnimorph fly tour --vehicle {path}"
    )
    return console.Answer(text=text, data={"file": str(path)})
