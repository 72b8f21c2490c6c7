"""Arguments that several commands take, read and checked."""

from __future__ import annotations

import argparse
import math
from argparse import ArgumentParser
from collections.abc import Callable
from pathlib import Path

from omnimorph.errors import InputError

_LARGEST = 2**64 - 1
_LARGEST_ANGLE = math.radians(1e5)
_MOST = 10_000


def allow_code(parser: argparse._ActionsContainer) -> None:
    """Add the argument without which code that a file or an argument names is refused."""
    parser.add_argument(
        "--allow-code",
        action="store_true",
        help="run code that the scenario or an argument names; without it, it is refused",
    )


def angles_in_degrees(text: str) -> list[float] | float:
    """Read ``--tilt``: one angle, or one for each servo with commas between; return radians.

    Raises
    ------
    InputError
        If it is no number, or not finite.

    Examples
    --------
    >>> angles_in_degrees("180")
    3.141592653589793
    """
    try:
        angles = [math.radians(float(part)) for part in text.split(",")]
    except ValueError:
        angles = [math.nan]
    if not all(abs(angle) <= _LARGEST_ANGLE for angle in angles):
        allowed = "a number of degrees, or one for each servo with commas between, from -1e5 to 1e5"
        raise InputError.at("the command line", "--tilt", text, allowed)
    return angles[0] if len(angles) == 1 else angles


def folder(text: str) -> Path:
    """Read the name of a folder; an empty one is refused: it stands for a variable nobody set."""
    if not text:
        raise InputError.at("the command line", "--out", text, "the name of a folder")
    return Path(text)


def milliseconds(option: str, least: float, most: float) -> Callable[[str], float]:
    """Return a function that reads milliseconds within limits as seconds, and names the option.

    Examples
    --------
    >>> milliseconds("--delay-ms", 0.0, 1e6)("20")
    0.02
    """
    allowed = f"a number of milliseconds, from {least:g} to {most:g}"
    read = number_at_least(option, least, allowed)

    def within(text: str) -> float:
        value = read(text)
        if value > most:
            raise InputError.at("the command line", option, text, allowed)
        return 1e-3 * value

    return within


def number_at_least(option: str, least: float, allowed: str) -> Callable[[str], float]:
    """Return a function that reads a finite number, and says what is allowed if it is too small.

    Examples
    --------
    >>> number_at_least("--at", 0.0, "a number of seconds")("31.5")
    31.5
    """

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value >= least):
            raise InputError.at("the command line", option, text, allowed)
        return value

    return read


def add_out(parser: ArgumentParser, help: str) -> None:
    """Add ``--out``, the folder into which a command writes."""
    parser.add_argument("--out", type=folder, metavar="DIR", help=help)


def add_vehicle(parser: ArgumentParser) -> None:
    """Add the vehicle that a command is about."""
    named = "a name that `omnimorph vehicles` lists, or a TOML file"
    parser.add_argument("vehicle", metavar="VEHICLE", help=named)


def one_of_the_list(parser: ArgumentParser, what: str) -> None:
    """Add the optional argument of a command that lists a catalogue, or shows one entry of it."""
    parser.add_argument(
        what,
        nargs="?",
        metavar=what.upper(),
        help="show this one: a name of the list, or a TOML file",
    )


def positive_number(option: str) -> Callable[[str], int]:
    """Return a function that reads how many, up to 10 000, and names the option if it cannot.

    Examples
    --------
    >>> positive_number("--seeds")("5")
    5
    """
    return lambda text: _whole_number(
        option, text, 1, f"a positive integer, at most {_MOST}", _MOST
    )


def seed_number(text: str) -> int:
    """Read a seed: an integer from 0 to 2⁶⁴ − 1.

    Raises
    ------
    InputError
        If it is none.

    Examples
    --------
    >>> seed_number("7")
    7
    """
    return _whole_number("--seed", text, 0, f"an integer from 0 to {_LARGEST}")


def port_number(text: str) -> int:
    """Read a port; 0 stands for any that is free.

    Raises
    ------
    InputError
        If it is none.

    Examples
    --------
    >>> port_number("8080")
    8080
    """
    return _whole_number("--port", text, 0, "a number from 0 to 65535", most=65535)


def _whole_number(option: str, text: str, least: int, allowed: str, most: int = _LARGEST) -> int:
    try:
        number = int(text)
    except ValueError:
        number = -1
    if not least <= number <= most:
        raise InputError.at("the command line", option, text, allowed)
    return number
