"""Finished flights, kept on disk as they finish, so that a study that was interrupted can go on.

A text file of one JSON object a line. A line says which flight it is (its key), what came of it,
and a hash over both: a line that was cut off, or changed by hand, is not believed and flown again.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import threading
from collections.abc import Sequence
from functools import cache, partial
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self, TextIO

import omnimorph
from omnimorph.design.files import vehicle_text
from omnimorph.design.input_files import open_input
from omnimorph.errors import RunFileError
from omnimorph.results.atomic import write_text
from omnimorph.results.metrics import Metrics
from omnimorph.simulation.scenario import Scenario
from omnimorph.version import __version__

_HEADER = json.dumps({"schema": "omnimorph flights", "schema_version": 1}) + "\n"


class FlightResult(NamedTuple):
    """What came of one flight.

    Attributes
    ----------
    metrics : Metrics or None
        Of the flight, also of one that was lost; None if it could not be flown at all.
    failure : str
        Why it could not, in a sentence; empty if it could.
    """

    metrics: Metrics | None
    failure: str = ""

    @property
    def completed(self) -> bool:
        """Whether the vehicle flew to the end."""
        return self.metrics is not None and self.metrics.outcome == "completed"

    @property
    def outcome(self) -> str:
        """How it ended, in a word or two."""
        return "not flown" if self.metrics is None else self.metrics.outcome.replace("_", " ")


def flight_keys(scenarios: Sequence[Scenario], seeds: Sequence[int]) -> list[str]:
    """Return for each flight the hash of all that decides it but the build: scenario and noise."""
    texts: dict[int, str] = {}  # by identity: one scenario is usually flown with many seeds
    for scenario in scenarios:
        if id(scenario) not in texts:
            content = json.dumps(scenario.as_file(), sort_keys=True)
            texts[id(scenario)] = content + vehicle_text(scenario.vehicle)
    flights = zip((texts[id(scenario)] for scenario in scenarios), seeds, strict=True)
    return [hashlib.sha256(f"{text}\n{seed}".encode()).hexdigest() for text, seed in flights]


@cache
def _build() -> str:
    """Return the hash of version and compiled core: a rebuilt one flies everything again."""
    core = next(Path(omnimorph.__file__).parent.glob("_core*.so"))
    return hashlib.sha256(__version__.encode() + core.read_bytes()).hexdigest()


def is_flight_log(path: Path) -> bool:
    """Return whether a file is a log of this kind, whatever its flights are."""
    try:
        with open_input(path, RunFileError) as file:
            return file.read(len(_HEADER)) == _HEADER.encode()
    except (OSError, RunFileError):
        return False


class FlightLog:
    """The flights of one study that are finished; may be used from several threads.

    Parameters
    ----------
    path : Path
        The file. What it holds of this build is read; the folder and the file are made when the
        first flight is added.

    Raises
    ------
    RunFileError
        If it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._file: TextIO | None = None
        self._flown: dict[str, FlightResult] = {}
        if path.exists():
            self._flown = dict(filter(None, map(_from_line, _lines(path))))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._file is not None:
            self._file.close()

    def __len__(self) -> int:
        return len(self._flown)

    def get(self, key: str) -> FlightResult | None:
        """Return what came of a flight, or None if it is not finished."""
        return self._flown.get(key)

    def add(self, key: str, flown: FlightResult) -> None:
        """Keep a finished flight: once this returns, an interrupt does not lose it.

        Raises
        ------
        RunFileError
            If it cannot be written.
        """
        with self._lock:
            try:
                if self._file is None:
                    self._file = self._opened()
                self._file.write(_as_line(key, flown))
                self._file.flush()
            except OSError as error:
                raise _refusal(self.path, error) from error
            self._flown[key] = flown

    def _opened(self) -> TextIO:
        """Return the file, open at its end; what was not believed is no longer in it."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        known = [_as_line(key, flown) for key, flown in self._flown.items()]
        write_text(self.path, "".join([_HEADER, *known]))
        return self.path.open("a", encoding="utf-8")


def _lines(path: Path) -> list[str]:
    """Return the lines of a log after its header."""
    try:
        with open_input(path, partial(_refused, path)) as file:
            return file.read().decode("utf-8", errors="replace").splitlines()[1:]
    except OSError as error:
        raise _refusal(path, error) from error


def _as_line(key: str, flown: FlightResult) -> str:
    metrics = flown.metrics and flown.metrics.as_dict()
    content = json.dumps(
        {"key": key, "build": _build(), "failure": flown.failure, "metrics": metrics}
    )
    seal = hashlib.sha256(content.encode()).hexdigest()
    return json.dumps({"flight": content, "sha256": seal}) + "\n"


def _from_line(line: str) -> tuple[str, FlightResult] | None:
    """Return the flight of a line; None if it is not as it was written, or of another build."""
    try:
        outer = json.loads(line)
        if hashlib.sha256(outer["flight"].encode()).hexdigest() != outer["sha256"]:
            return None
        content = json.loads(outer["flight"])
        if content["build"] != _build():
            return None
        return content["key"], FlightResult(_as_metrics(content["metrics"]), content["failure"])
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def _as_metrics(values: dict[str, Any] | None) -> Metrics | None:
    """Return metrics from a file, where null stands for what is no number."""
    if values is None:
        return None
    numbers: dict[str, Any] = {
        field.name: math.nan if values[field.name] is None else values[field.name]
        for field in dataclasses.fields(Metrics)
    }
    return Metrics(**numbers)


def _refusal(path: Path, error: OSError) -> RunFileError:
    return _refused(path, (error.strerror or str(error)).lower())


def _refused(path: Path, reason: str) -> RunFileError:
    return RunFileError(f"{path}: cannot be used: {reason}.", file=str(path))
