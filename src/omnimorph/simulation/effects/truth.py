"""What the true vehicle is like in single numbers, whatever its controller believes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from omnimorph.design.keys import FIELDS
from omnimorph.design.vehicle import Vehicle
from omnimorph.simulation.effects.effect import Effect
from omnimorph.units import from_SI


@dataclass(frozen=True, kw_only=True)
class TrueValues(Effect):
    """The true vehicle has these values; what they leave out is as the controller believes.

    `omnimorph.simulation.paths` makes it, from paths that begin with ``truth``; files do not.

    Attributes
    ----------
    values : tuple of (str, tuple of int, value)
        Field of the vehicle, indices within it (none for the whole field), and what is there, SI.

    Examples
    --------
    >>> from omnimorph.design import load_vehicle
    >>> heavier = TrueValues(values=(("mass", (), 1.5), ("thrust_coefficient", (3,), 4e-6)))
    >>> true = heavier.true_vehicle(load_vehicle("omnimorph"))
    >>> true.mass, float(true.thrust_coefficient[3])
    (1.5, 4e-06)
    """

    kind: ClassVar[str] = "truth"
    values: tuple[tuple[str, tuple[int, ...], Any], ...] = ()

    def true_vehicle(self, vehicle: Vehicle) -> Vehicle:
        """Return the vehicle with these values."""
        changes: dict[str, Any] = {}
        for field, at, value in self.values:
            changes[field] = np.array(changes.get(field, getattr(vehicle, field)))
            changes[field][at] = value
        return vehicle.replace(**changes)

    def as_file(self) -> dict[str, Any]:
        """Return every value under its field, with indices and unit."""
        content: dict[str, Any] = {"kind": self.kind}
        for field, at, value in self.values:
            unit = FIELDS[field].unit
            key = field + "".join(f"[{index}]" for index in at)
            content[f"{key}_{unit}" if unit else key] = from_SI(np.array(value), unit).tolist()
        return content
