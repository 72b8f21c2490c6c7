"""The fields of the core's loop in which the flights of a batch differ, a row for each flight."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.model.core import core_fields
from omnimorph.model.interference import stacked_pairs
from omnimorph.protocols import FloatArray
from omnimorph.simulation.core_settings import CoreSettings, loop_fields
from omnimorph.simulation.scenario import Scenario

PAIRS = "plant.interference.pairs"
"""Which rotors are in line: the core finds it once for all flights in a register's lanes."""
ALIKE = "controller.allocation.weights.alike"
"""Whether W2 weighs all directions of force alike, in double and in single precision: if it does in
all lanes the core looks at accelerations in B, otherwise in W, which rounds otherwise."""
_BYTES_OF_A_NUMBER = 16  # with its copy in the core


class CoreRows:
    """A row for each flight of every field of the core in which some of them differ.

    Fields are read and written by their path, with a row for each flight, or one row for all. It
    begins with the settings and the scenario of the first of n flights.

    Attributes
    ----------
    differing : dict of str to (n, width) array
        What `start` of the core's batches takes as its variation.
    """

    def __init__(self, parts: CoreSettings, scenario: Scenario, flights: int) -> None:
        self._flights = flights
        self._of_all = numbers_of_core(scenario, parts.start)
        self._bytes = {path: numbers.tobytes() for path, numbers in self._of_all.items()}
        self._may_differ = {path for path, _, varies in parts.settings.places() if varies}
        self.differing: dict[str, FloatArray] = {}

    def __getitem__(self, path: str) -> FloatArray:
        """Return the (n, width) numbers of a field, or (1, width) of one that all share."""
        rows = self.differing.get(path)
        return self._of_all[path].reshape(1, -1) if rows is None else rows

    def __setitem__(self, path: str, rows: FloatArray) -> None:
        """Replace the (n, width) numbers of a field."""
        self.differing[path] = np.ascontiguousarray(rows)

    def put(self, row: int, numbers: Mapping[str, NDArray[Any]]) -> str | None:
        """Put in all numbers of a flight; return the path of one that must be that of all flights.

        Raises
        ------
        TooLargeError
            If the rows are more than memory holds.
        """
        only_some = self._of_all.keys() ^ numbers.keys()
        if only_some:
            return min(only_some)
        for path, value in numbers.items():
            if value.tobytes() == self._bytes[path]:
                continue
            if path not in self._may_differ:
                return path
            if path not in self.differing:
                self._take_room(path, value.size)
            self.differing[path][row] = value.reshape(-1)
        return None

    def _take_room(self, path: str, width: int) -> None:
        of_a_flight = width + sum(rows.shape[1] for rows in self.differing.values())
        refuse_more_than_memory(
            f"fly_many: {self._flights} flights with {of_a_flight} numbers of their own each",
            self._flights * of_a_flight * _BYTES_OF_A_NUMBER,
            "fly fewer",
        )
        self.differing[path] = np.tile(self._of_all[path].reshape(1, -1), (self._flights, 1))


def numbers_of_core(scenario: Scenario, start: FloatArray) -> dict[str, NDArray[Any]]:
    """Return every field of the core's loop by its path, and what else the flights share.

    The scenario starts from the (18,) state `start`.
    """
    fields = loop_fields(scenario, start)
    truth = scenario.plant.true_vehicle(scenario.vehicle)
    fields["controller"]["model"] = core_fields(scenario.vehicle)
    fields["plant"]["vehicle"] = core_fields(truth)
    found = dict(_flat(fields))
    found["lost_beyond"] = np.asarray(scenario.lost_beyond)
    weights = found["controller.allocation.weights.acceleration"][:3]
    alike = [len(set(weights.astype(kind).tolist())) == 1 for kind in (np.float64, np.float32)]
    found[ALIKE] = np.array(alike)
    if "plant.interference.model" in found:
        found[PAIRS] = np.asarray(stacked_pairs(truth))
    return found


def _flat(fields: Mapping[str, Any], place: str = "") -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield every field by its path, numbers in float64; of a choice those of what is chosen."""
    for name, value in fields.items():
        if isinstance(value, tuple):
            yield from _flat(dict([value]), f"{place}{name}.")
        elif isinstance(value, Mapping):
            yield from _flat(value, f"{place}{name}.")
        else:
            array = np.asarray(value)
            yield place + name, array if array.dtype.kind == "U" else array.astype(np.float64)
