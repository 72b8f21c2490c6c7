"""Parts of the loop that are one's own: objects written in Python that stand in for the core's.

::

    OwnParts(controller=MyController())                       an object of its protocol
    OwnParts(controller=PythonObject("my_module:MyController"))   as a file names it
"""

from __future__ import annotations

import copy
import importlib
import inspect
import json
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn, Self

from omnimorph.errors import InputError, ScenarioError
from omnimorph.protocols import (
    Allocator,
    Controller,
    Disturbance,
    Estimator,
    Plant,
    Sensors,
)
from omnimorph.reference.samples import SampledReference
from omnimorph.simulation.copies import copied

_AT_FIRST = ("physics_step", "control_period", "reset", "send", "step_physics")
_AFTER_RESET = ("motion", "speed", "tilt", "wrench")


NOT_BOTH = "fly takes a controller or an allocator, not both: a controller allocates."


class PartFailed(Exception):
    """A part of one's own could not go on; the flight ends here, and what has been flown is kept.

    Parameters
    ----------
    part : str
        Which, with its name.
    error : BaseException
        What it raised, or what is wrong with its answer.
    """

    def __init__(self, part: str, error: BaseException) -> None:
        super().__init__(part, error)
        self.part, self.error = part, error

    @property
    def what(self) -> str:
        """The error in a line, and where in the code it was raised."""
        said = type(self.error).__name__
        with suppress(Exception):  # an error of one's own may not even say what it is
            said = f"{said}: {self.error}"
        said = " ".join(said.split()).rstrip(".: ")
        trace = self.error.__traceback__
        if trace is None or trace.tb_next is None or isinstance(self.error, InputError):
            return said  # also where the call itself fails, as with other arguments
        while trace.tb_next is not None:
            trace = trace.tb_next
        return f"{said} ({Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno})"

    def refuse(self) -> NoReturn:
        """Raise what a user reads where nothing has been flown that could be kept."""
        if isinstance(self.error, InputError):
            raise self.error
        sentence = f"{self.part} failed before anything was flown: {self.what}."
        raise ScenarioError(sentence) from self.error


FAILURES = (Exception, SystemExit)
"""What a part of one's own may raise to fail; an interrupt is none of it."""


@dataclass(frozen=True)
class PythonObject:
    """An object that a file or a command names, ``my_module:MyController``.

    Attributes
    ----------
    object : str
        Module and name, with a colon between.
    options : mapping
        What a class is built with, by keyword, beside the scenario.
    folder : str
        Of the file that names it, where its module is looked for first; "" for nowhere.
    """

    object: str
    options: Mapping[str, Any] = field(default_factory=dict)
    folder: str = ""

    def checked(self, place: str, key: str, allow_code: bool) -> Self:
        """Return this, if it may run and is there; `place` and `key` say who names it.

        Raises
        ------
        ScenarioError
            If nobody has allowed code that files and texts name, and as `found`.
        """
        if not allow_code:
            raise ScenarioError(
                f"{place}: {key} {self.object} is code, which runs only if it is allowed: by "
                "--allow-code on the command line, by allow_code=True in Python.",
                file=place,
                key=key,
                value=self.object,
            )
        self.found(place, key)
        return self

    def found(self, place: str = "the scenario", key: str = "object") -> Any:
        """Import the module and return the object.

        Raises
        ------
        ScenarioError
            If the name is none, if the module cannot be imported, or has no such object.
        """
        name, _, attribute = self.object.partition(":")
        if not all(part.isidentifier() for part in (*name.split("."), *attribute.split("."))):
            allowed = "a module and an object in it, my_module:MyController"
            raise ScenarioError.at(place, key, self.object, allowed)
        try:
            found: Any = _module(name, self.folder)
            for part in attribute.split("."):
                found = getattr(found, part)
        except ScenarioError:
            raise
        except FAILURES as error:  # whatever a module does when it is imported
            why = f"{type(error).__name__}: {error}"
            raise ScenarioError(
                f"{place}: {key} {self.object} cannot be imported: {why}.", file=place, key=key
            ) from error
        if self.options and not inspect.isclass(found):
            raise ScenarioError.at(place, f"{key}: options", dict(self.options), "those of a class")
        return found

    def built(self, *arguments: Any) -> Any:
        """Return the object, for one flight: a class is called with the arguments and the options.

        What the module has made itself is copied, so that no other flight has changed it.

        Raises
        ------
        ScenarioError
            As `found`, and if the class raises or the object cannot be copied.
        """
        found = self.found()
        is_class = inspect.isclass(found)
        try:
            return found(*arguments, **self.options) if is_class else copy.deepcopy(found)
        except FAILURES as error:
            what, failed = "built" if is_class else "copied", PartFailed(self.object, error)
            raise ScenarioError(f"{self.object} cannot be {what}: {failed.what}.") from error

    def as_file(self) -> dict[str, Any]:
        """Return what a file would hold."""
        options = {"options": dict(self.options)} if self.options else {}
        return {"kind": "python", "object": self.object, **options}


_folders: set[Path] = set()  # that modules were imported from


def _module(name: str, folder: str) -> ModuleType:
    """Import a module, from a folder if it has it."""
    root = Path(folder).resolve()
    here = root.joinpath(*name.split("."))
    files = [one.resolve() for one in (here.with_suffix(".py"), here / "__init__.py")]
    if not folder or not any(one.is_file() for one in files):
        return importlib.import_module(name)
    for beside in root.glob("*.py"):  # it may import any of them
        source = getattr(sys.modules.get(beside.stem), "__file__", None)
        if source is not None and Path(source).resolve().parent in _folders - {root}:
            raise _other_in_use(beside.stem, folder)
    _folders.add(root)
    sys.path.insert(0, str(root))
    try:
        module = importlib.import_module(name)
    finally:
        with suppress(ValueError):  # the module has removed it
            sys.path.remove(str(root))
    source = getattr(module, "__file__", None)
    if source is None or Path(source).resolve() not in files:
        raise _other_in_use(name, folder)
    return module


def _other_in_use(name: str, folder: str) -> ScenarioError:
    return ScenarioError(
        f"the module {name} in {folder} cannot be imported, because another {name} is in use; "
        "give it another name."
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class OwnParts:
    """What of the loop is one's own: objects of their protocols, or `PythonObject`; None is not.

    Attributes
    ----------
    plant : Plant, optional
        An engine that flies instead of the scenario's plant, whose sensors and estimator stay.
    sensors, estimator, controller : optional
        Instead of those of the scenario.
    allocator : Allocator, optional
        Gets its accelerations from the scenario's tracking.
    disturbance : Disturbance, optional
        Beside the forces of the plant.

    Raises
    ------
    ScenarioError
        If a part does not have what its protocol says, or if there are a controller, which
        allocates, and an allocator.
    """

    plant: Plant | PythonObject | None = None
    sensors: Sensors | PythonObject | None = None
    estimator: Estimator | PythonObject | None = None
    controller: Controller | PythonObject | None = None
    allocator: Allocator | PythonObject | None = None
    disturbance: Disturbance | PythonObject | None = None

    def __post_init__(self) -> None:
        for name, part in self.given().items():
            if isinstance(part, PythonObject):
                continue
            if inspect.isclass(part):
                allowed = f"an object of that class, such as {part.__name__}(...)"
                raise ScenarioError.at("fly", name, part, allowed)
            if name == "plant":
                check_plant(part, _AT_FIRST)
            elif not callable(part):
                allowed = f"a record, name or file for the {name}, or an object that can be called"
                raise ScenarioError.at("fly", name, part, allowed)
        if self.controller is not None and self.allocator is not None:
            raise ScenarioError(NOT_BOTH)

    def given(self) -> dict[str, Any]:
        """Return the parts that are there, by name."""
        parts = {one.name: getattr(self, one.name) for one in fields(self)}
        return {name: part for name, part in parts.items() if part is not None}

    def __deepcopy__(self, memo: dict[int, Any]) -> OwnParts:
        """Return copies for another flight.

        Raises
        ------
        ScenarioError
            If a part cannot be copied.
        """
        copies = {}
        for name, part in self.given().items():
            try:
                copies[name] = copied(part, memo)
            except FAILURES as error:
                why = f"{type(error).__name__}: {error}"
                raise ScenarioError(
                    f"the {name} cannot be copied for another flight, because {why}."
                ) from error
        return OwnParts(**copies)

    def built(self, scenario: Any) -> OwnParts:
        """Return them ready to fly: what a file names as a class is built for the scenario."""
        named = {
            name: part.built(scenario)
            for name, part in self.given().items()
            if isinstance(part, PythonObject)
        }
        return replace(self, **named) if named else self


def check_plant(plant: Any, names: Sequence[str] = _AFTER_RESET) -> None:
    """Refuse a plant that lacks what its protocol says; some may come with its first `reset`."""
    try:
        missing = [one for one in names if not hasattr(plant, one)]
    except FAILURES as error:
        PartFailed(named("plant", plant), error).refuse()
    if missing:
        lacking = ", ".join(missing)
        allowed = f"a PlantModel, the name or file of one, or an object that has {lacking}"
        raise ScenarioError.at("fly", "plant", plant, allowed)


def described(part: object) -> dict[str, Any]:
    """Return a part of the loop as a file would hold it; of one written in Python, its name."""
    as_file: Callable[[], dict[str, Any]] | None = getattr(part, "as_file", None)
    if as_file is not None:
        with suppress(Exception):  # a class of one's own may mean something else by it
            return dict(json.loads(json.dumps(as_file(), default=str)))
    return {"kind": "python", "name": getattr(part, "__qualname__", type(part).__qualname__)}


def name_of(part: object) -> str:
    """Return what a part of one's own is called: its class, or as a file names it."""
    written = described(part)
    return str(written.get("name") or written.get("object") or written.get("kind", ""))


def named(kind: str, part: object) -> str:
    """Return what a message calls a part of one's own: ``controller MyController``."""
    return f"{kind} {name_of(part)}".strip()


_lock = threading.Lock()
_flying: set[int] = set()  # identities of the parts under way


@contextmanager
def in_flight(parts: Mapping[str, object]) -> Iterator[None]:
    """Keep the parts of one flight, by name, from any other as long as it takes.

    Parts that may remember something fly once at a time: shared by two flights at once, such a part
    would mix them up, differently each time.

    Raises
    ------
    ScenarioError
        If a part is flying already.
    """
    mine = {}
    for name, part in parts.items():
        while isinstance(part, partial):
            part = part.func
        if not _is_stateless(part):
            mine[id(getattr(part, "__self__", part))] = name  # of a method, its object
    with _lock:
        for identity in mine.keys() & _flying:
            raise ScenarioError(
                f"fly: the {mine[identity]} is flying already; what it remembers belongs to one "
                "flight, so give each its own."
            )
        _flying.update(mine)
    try:
        yield
    finally:
        with _lock:
            _flying.difference_update(mine)


def _is_stateless(part: object) -> bool:
    """Return whether a part surely remembers nothing: a plain function or a frozen record."""
    if inspect.isfunction(part):
        return part.__closure__ is None
    settings = getattr(type(part), "__dataclass_params__", None)
    return isinstance(part, SampledReference) or (settings is not None and settings.frozen)
