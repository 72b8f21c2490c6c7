"""The error tree: what went wrong, in one sentence a user can act on.

Everything this package raises on purpose is an `OmnimorphError`. An `InputError` is the user's
mistake (the command line ends with exit code 2); it names where the mistake is, the key, the value
found and what is allowed::

    OmnimorphError
    └── InputError            a file, argument or value that cannot be used
        ├── VehicleError      ... of a vehicle
        ├── ScenarioError     ... of a scenario
        └── RunFileError      ... of a stored run

An `UnlikelyUnitWarning` is no error: the numbers are used as they stand.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final, Self

_LONGEST_MESSAGE, _LONGEST_PART, _LONGEST_SHOWN = 1500, 200, 80  # characters
_MOST_SHOWN = 100  # entries of a list of which the first characters are shown


class _Missing:
    """The type of `MISSING`."""

    def __repr__(self) -> str:
        return "missing"


MISSING: Final = _Missing()
"""Stands for the value of a key that is not there: ``mass_kg is missing, but it must be ...``."""


class UnlikelyUnitWarning(UserWarning):
    """A number of a vehicle looks like one in another unit, which the warning names.

    To be silent of it: ``warnings.simplefilter("ignore", omnimorph.UnlikelyUnitWarning)``.
    """


class OmnimorphError(Exception):
    """Base of every error raised on purpose by this package.

    Parameters
    ----------
    message : str
        The sentence. It is kept on one line and at a few lines' length, and what would steer a
        terminal is spelt out, whatever it quotes.
    """

    def __init__(self, message: str) -> None:
        super().__init__(legible(message, _LONGEST_MESSAGE))


class InputError(OmnimorphError):
    """The user's mistake, stated in one sentence.

    Parameters
    ----------
    message : str
        The sentence.
    file, key, value, allowed
        Its parts, kept for programs that want to point at the mistake; None where there is none.

    Attributes
    ----------
    file : str or None
        The file (or other place) in which the mistake is.
    key : str or None
        The key of the mistaken entry, such as ``rotor[2].axis``; entries are counted from 0.
    value : object
        The value found, `MISSING` if there is none.
    allowed : str or None
        What would have been right, to be read after "it must be".
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | None = None,
        key: str | None = None,
        value: object = None,
        allowed: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = file
        self.key = key
        self.value = value
        self.allowed = allowed

    @classmethod
    def at(cls, file: str | Path, key: str, value: object, allowed: str) -> Self:
        """Build the error from its parts.

        Parameters
        ----------
        file : str or Path
            The file, or other place, in which the mistake is.
        key : str
            The mistaken key.
        value : object
            The value found, or `MISSING`.
        allowed : str
            What is allowed, to be read after "it must be".

        Returns
        -------
        InputError
            An error of the class it is called on.

        Examples
        --------
        >>> print(VehicleError.at("my.toml", "mass_kg", -1.0, "a positive number of kilograms"))
        my.toml: mass_kg is -1.0, but it must be a positive number of kilograms.
        """
        place, name = legible(str(file)), legible(key)
        sentence = f"{place}: {name} is {shown(value)}, but it must be {allowed}."
        return cls(sentence, file=str(file), key=key, value=value, allowed=allowed)

    @classmethod
    def unknown_key(cls, file: str | Path, key: str, name: str, known: Iterable[str]) -> Self:
        """Build the error for a key nobody knows, with the nearest known one.

        Parameters
        ----------
        file : str or Path
            The file in which the key stands.
        key : str
            The unknown key with the tables around it, such as ``rotor[0].axs``.
        name : str
            Its last part, ``axs``, which is compared with the known names.
        known : iterable of str
            The names allowed in its place.

        Examples
        --------
        >>> print(InputError.unknown_key("my.toml", "rotor[0].axs", "axs", ["axis", "spin"]))
        my.toml: rotor[0].axs is not a known key; did you mean axis (allowed here: axis, spin)?
        """
        names = list(known)
        listed = ", ".join(names) or "nothing"
        near = nearest_name(name, names)
        hint = f"did you mean {near} (allowed here: {listed})?" if near else f"allowed: {listed}."
        sentence = f"{legible(str(file))}: {legible(key)} is not a known key; {hint}"
        return cls(sentence, file=str(file), key=key, allowed=f"one of {listed}")


class VehicleError(InputError):
    """A vehicle, or a vehicle file, that cannot be used."""


class ScenarioError(InputError):
    """A scenario, or a scenario file, that cannot be used."""


class RunFileError(InputError):
    """A stored run that cannot be read or written."""


class TooLargeError(InputError):
    """What needs more memory than there is; on another machine it may be none."""


def nearest_name(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that a misspelt one most likely meant, or None if none is near.

    Examples
    --------
    >>> nearest_name("mas_kg", ["mass_kg", "name"])
    'mass_kg'
    """
    if len(name) > _LONGEST_PART:
        return None
    names = list(known)
    by_lower_case = {known_name.lower(): known_name for known_name in reversed(names)}
    near = difflib.get_close_matches(name.lower(), list(by_lower_case), n=1, cutoff=0.6)
    return by_lower_case[near[0]] if near else None


def legible(text: str, longest: int = _LONGEST_PART) -> str:
    r"""Return a text as a message may quote it: on one line, without its middle if it is too long.

    Characters that a terminal would not show, but obey, are spelt out.

    Examples
    --------
    >>> legible("red \x1b[31m\nand so on"), legible("a" * 1000, 7)
    ('red \\x1b[31m and so on', 'aaa…aaa')
    """
    if len(text) > longest:
        half = (longest - 1) // 2
        text = f"{text[:half]}…{text[-half:]}"
    line = " ".join(text.split())
    if line.isprintable():
        return line
    spelt = (c if c.isprintable() else c.encode("unicode_escape").decode() for c in line)
    return "".join(spelt)


def shown(value: Any) -> str:
    """Return a value as a message shows it: on one line, as the file writes it, not too long.

    Examples
    --------
    >>> shown(True), shown("cw"), shown([1.0, 2.0])
    ('true', '"cw"', '[1.0, 2.0]')
    """
    several = isinstance(value, list | tuple) or getattr(value, "ndim", 0) > 0
    if several and len(value) > _MOST_SHOWN:
        value = value[:_MOST_SHOWN]
    if hasattr(value, "tolist"):  # an array or number of NumPy
        value = value.tolist()
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, str):
        start = value[: _LONGEST_SHOWN + 1]
        text = f'"{start}"' if start.isprintable() else repr(start)
    elif isinstance(value, int) and value.bit_length() > _LONGEST_SHOWN:
        text = "a number too long to show"
    else:
        try:
            text = repr(value) if isinstance(value, list | tuple | dict) else str(value)
        except (ValueError, RecursionError):  # integers of thousands of digits, or lists as deep
            text = "too long to show"
        except Exception:  # what a class of one's own raises
            text = f"a {type(value).__name__} that cannot be shown"
    text = legible(text, 10 * _LONGEST_SHOWN)
    return text if len(text) <= _LONGEST_SHOWN else text[: _LONGEST_SHOWN - 1] + "…"
