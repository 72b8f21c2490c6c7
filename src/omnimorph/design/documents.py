"""What all our TOML files have in common: found, read, checked, refused in one sentence.

Vehicle and scenario files pass through the same three steps ::

    file, text = find_document(name_or_path, catalogue, "vehicle", VehicleError)
    document = parse_toml(text, file, VehicleError)
    content = check_document(VehicleFile, document, file, VehicleError)

where `VehicleFile` is a pydantic model whose fields each have a `description` that can be read
after "it must be". pydantic itself is imported only when a document is checked.
"""

from __future__ import annotations

import os
import re
import tomllib
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from omnimorph.design.input_files import read_text
from omnimorph.errors import MISSING, InputError, legible, nearest_name, shown

_MOST_DEPTH = 20  # of tables and lists in one another; ours go down to 8
_LONG_KEY = re.compile(
    r"""(?<![\w"'-])(?>(?>[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){50}""",  # a.b.c. and so on
)

if TYPE_CHECKING:
    from pydantic import BaseModel
    from pydantic.fields import FieldInfo
    from pydantic_core import ErrorDetails

    Model = TypeVar("Model", bound=BaseModel)

Kind = TypeVar("Kind")


def record_or_file(
    value: object,
    kind: type[Kind],
    name: str,
    load: Callable[[str | os.PathLike[str]], Kind],
    error: type[InputError],
) -> Kind:
    """Return a record that the argument `name` is, or that `load` reads by its name or file.

    Anything else is refused with `error`.
    """
    if isinstance(value, kind):
        return value
    if isinstance(value, str | os.PathLike):
        return load(value)
    raise error.at("the call", name, value, f"a {kind.__name__}, or the name or file of one")


def catalogue_names(catalogue: Traversable) -> list[str]:
    """Return the names of the TOML files in a folder of the package, sorted, without ``.toml``."""
    names = [entry.name for entry in catalogue.iterdir()]
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def find_document(
    name_or_path: str | os.PathLike[str],
    catalogue: Traversable,
    kind: str,
    error: type[InputError],
) -> tuple[str, str]:
    """Return what a message should call a document, and its text.

    It is that of the catalogue if a name is known there, else a file; `kind` is what is looked for,
    such as "vehicle". Raises `error` if there is neither, or the file cannot be read.
    """
    if not isinstance(name_or_path, str | os.PathLike):
        raise error(f"{shown(name_or_path)} is neither the name nor the file of a {kind}.")
    known = catalogue_names(catalogue)
    name = os.fsdecode(name_or_path)
    if isinstance(name_or_path, str) and name in known:
        return f"{name}.toml", catalogue.joinpath(f"{name}.toml").read_text(encoding="utf-8")
    looks_like_a_path = (
        name.endswith(".toml") or os.sep in name or not isinstance(name_or_path, str)
    )
    if not looks_like_a_path and not os.path.exists(name):
        near = nearest_name(name, known)
        hint = f"did you mean {near} (known: {', '.join(known)})?"
        hint = hint if near else f"known are {', '.join(known)}."
        raise error(
            f"'{legible(name)}' is neither a {kind} of the catalogue nor a file; {hint}", value=name
        )
    return name, read_text(name, error)


def parse_toml(text: str, file: str | Path, error: type[InputError]) -> dict[str, Any]:
    """Parse TOML; raise `error` with the line and column if it is none, or nested too deeply."""
    try:
        # A key of many parts would take the parser the square of their number.
        document = tomllib.loads(text) if not _LONG_KEY.search(text) else None
        if document is not None and _depth(document) <= _MOST_DEPTH:
            return document
        reason = "Nested too deeply"
    except RecursionError:
        reason = "Nested too deeply"
    except ValueError as problem:  # tomllib's own error, or a number with too many digits
        reason = " ".join(str(problem).split())
    sentence = f"{legible(str(file))}: this file is not valid TOML: {legible(reason)}."
    raise error(sentence, file=str(file))


def _depth(document: object) -> int:
    """Return how deeply tables and lists stand in one another, however deep that is."""
    depth, level = 0, [document]
    while level:
        depth += 1
        below: list[object] = []
        for value in level:
            if isinstance(value, dict):
                below += value.values()
            elif isinstance(value, list):
                below += value
        level = below
    return depth


def check_document(
    model: type[Model], document: Mapping[str, Any], file: str | Path, error: type[InputError]
) -> Model:
    """Return the content of a parsed document, checked against a pydantic model and typed.

    Raises `error` for the first thing that is wrong: an unknown key (with the nearest known one), a
    missing key, a wrong type, a number that is not finite or not allowed.
    """
    from pydantic import ValidationError

    try:
        return model.model_validate(document)
    except ValidationError as refused:
        first = min(refused.errors(), key=_urgency)
    raise _refusal(model, document, first, file, error)


def _urgency(detail: ErrorDetails) -> int:
    """Rank an error: another version of the format explains the rest, a misspelt key a lack."""
    if detail["loc"] == ("schema",) and detail["type"] != "missing":
        return 0
    return 1 if detail["type"] == "extra_forbidden" else 2


def _refusal(
    model: type[BaseModel],
    document: Mapping[str, Any],
    detail: ErrorDetails,
    file: str | Path,
    error: type[InputError],
) -> InputError:
    """Turn one error of pydantic into a sentence of ours."""
    place = _walk(model, document, detail["loc"])
    key = _key(place.steps)
    if detail["type"] == "extra_forbidden":
        known = dict.fromkeys(str(name) for choice in place.tables for name in _fields(choice))
        return error.unknown_key(file, key, str(detail["loc"][-1]), known)
    if detail["type"].startswith("union_tag") and isinstance(place.value, Mapping):
        name = str(detail["ctx"]["discriminator"]).strip("'")
        tags = ", ".join(str(tag) for choice in place.tables for tag in _tags(choice, name))
        found = place.value.get(name, MISSING)
        return error.at(file, f"{key}.{name}".removeprefix("."), found, f"one of {tags}")
    allowed = detail["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    if place.field is not None and place.field.description and detail["type"] != "value_error":
        allowed = place.field.description
    return error.at(file, key or "the file", place.value, allowed)


class _Place(NamedTuple):
    """Where in a document an error is."""

    steps: list[int | str]  # keys and indices from the root
    value: object  # what stands there, or MISSING
    field: FieldInfo | None  # the last field of a model on the way
    tables: list[type[BaseModel]]  # the models a table at, or just above, this place may follow


def _walk(
    model: type[BaseModel], document: Mapping[str, Any], location: tuple[int | str, ...]
) -> _Place:
    """Follow pydantic's location through the document and the models at once.

    A location also holds steps that are not in the document: the branch of a union.
    """
    steps: list[int | str] = []
    here: Any = document
    field: FieldInfo | None = None
    tables = [model]
    for count, step in enumerate(location, start=1):
        last = count == len(location)
        inside = isinstance(here, Mapping) and (step in here or last)
        if not (inside or (isinstance(step, int) and isinstance(here, Sequence))):
            chosen = [table for table in tables if step in (table.__name__, *_tags(table))]
            tables = chosen or tables
            continue
        found = [known[step] for table in tables if step in (known := _fields(table))]
        if found:
            field = found[0]
            tables = list(_tables_in(field.annotation))
        elif isinstance(step, int) and not tables:
            break  # one number of a list: the whole list is shown
        steps.append(step)
        here = here.get(step, MISSING) if isinstance(here, Mapping) else here[step]
    return _Place(steps, here, field, tables)


def _fields(table: type[BaseModel]) -> dict[int | str, FieldInfo]:
    """Return the fields of a model under the names that the file uses."""
    return {field.alias or name: field for name, field in table.model_fields.items()}


def _tags(table: type[BaseModel], name: str | None = None) -> Iterator[object]:
    """Yield what a model's fields, or the one of that name, must be word for word."""
    for key, field in _fields(table).items():
        if typing.get_origin(field.annotation) is typing.Literal and name in (None, key):
            yield from typing.get_args(field.annotation)


def _tables_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the models that an annotation such as ``list[Rotor]`` mentions."""
    if hasattr(annotation, "model_fields"):
        yield annotation
    for argument in typing.get_args(annotation):
        yield from _tables_in(argument)


def _key(steps: Sequence[int | str]) -> str:
    """Write a path as a key: ``rotor[2].axis``."""
    parts = [f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps]
    return "".join(parts).removeprefix(".")
