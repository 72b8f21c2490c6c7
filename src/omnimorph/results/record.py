"""What one flight left behind: columns over time, how it ended, and where it comes from.

Row k of K belongs to the time t_k = k h, h the physics step; the last row is the final state. In
row k the motion, the rotors' actual speeds and thrusts, the actual tilt and the achieved wrench are
those at t_k; the desired motion, the command and the allocation are those of the step that begins
at t_k (a command is held between control steps).
"""

from __future__ import annotations

import enum
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import InputError
from omnimorph.protocols import FloatArray
from omnimorph.results.columns import Column, column, columns_of, described, sizes_of
from omnimorph.results.logged import LoggedColumn, checked


class Outcome(enum.Enum):
    """How a flight ended; the value is the sentence a user reads."""

    COMPLETED = "The flight was completed."
    UNDER_WAY = "The flight goes on; this is what has been flown so far."
    LOST = "The vehicle was lost: it strayed too far from its reference."
    NOT_FINITE = "The flight was ended: the controller gave a number that is not finite."
    DIVERGED = "The flight was ended: the state of the vehicle is no longer finite."
    PART_FAILED = "The flight was ended: a part of the loop written in Python failed."
    PAGE_FAULT = "The flight was ended by a fault of the page."


@dataclass(frozen=True, kw_only=True)
class Provenance:
    """Where a run comes from: enough to fly it again, the same on every machine.

    Attributes
    ----------
    scenario_name, scenario_text : str
        The scenario as it was flown, everything in it resolved, as JSON.
    vehicle_text : str
        The controller's vehicle, as a vehicle file.
    plant_name : str
        Such as ``perfect`` or ``realistic``.
    seed, flight : int
        Which noise: flight k of seed s is the same wherever it is flown; 0 … 2⁶⁴ − 1.
    control_period, physics_step : float
        In s.
    version : str
        Of omnimorph.
    content_hash : str
        SHA-256 over the columns, the outcome and this record, as `Run.content_hash` gives it; set
        in a run that was read from a file, "" in one that has not been stored.
    """

    scenario_name: str
    scenario_text: str
    vehicle_text: str
    plant_name: str
    seed: int
    flight: int
    control_period: float
    physics_step: float
    version: str
    content_hash: str = ""

    def __post_init__(self) -> None:
        for name in ("seed", "flight"):
            value = getattr(self, name)
            if not (isinstance(value, int) and 0 <= value < 2**64):
                raise InputError.at("provenance", name, value, "an integer from 0 to 2**64 - 1")
        for name in _TEXTS:
            text = getattr(self, name)
            if not isinstance(text, str) or _NOT_STORED.search(text):
                allowed = "text of Unicode characters without a null"
                raise InputError.at("provenance", name, text, allowed)
        for name in ("control_period", "physics_step"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError.at("provenance", name, value, "a positive number of seconds")

    @property
    def scenario(self) -> dict[str, Any]:
        """What was flown, much as a scenario file holds it; empty where the text is none."""
        try:
            content = json.loads(self.scenario_text)
        except (ValueError, RecursionError):
            return {}
        return content if isinstance(content, dict) else {}


_TEXTS = ("scenario_name", "scenario_text", "vehicle_text", "plant_name", "version")
_NOT_STORED = re.compile("[\0\ud800-\udfff]")  # a null, and half a pair of surrogates


@dataclass(frozen=True, kw_only=True)
class Performance:
    """How fast it was computed; depends on the machine, so it is kept apart.

    Attributes
    ----------
    wall_time : float
        Time the flight took to compute, s.
    real_time_factor : float
        Seconds flown per second of computing.
    """

    wall_time: float
    real_time_factor: float


_THRUST_LIMITS = ("thrust_min", "thrust_max")
_TILT_LIMITS = ("servo_angle_min", "servo_angle_max")
_WRENCH_UNITS = "N (force), N m (torque)"
_BODY_TO_WORLD = "W from B"


@dataclass(frozen=True, eq=False, kw_only=True)
class RunRecord:
    """One flight: K rows over time, how it ended, and where it comes from.

    The columns are declared below, each with what it is; its documentation follows from that.

    The arrays are kept, not copied: hand them over and do not write to them afterwards. Through the
    run they are read-only. n is the number of rotors, m of servos. ``run["speed"]`` is any column
    by its name, a logged one too.

    Raises
    ------
    InputError
        If a column does not have its shape, or a logged one has a name that is taken; of
        ``run[name]``, if there is no such column.

    Attributes
    ----------
    outcome : Outcome
        How the flight ended.
    vehicle : Vehicle
        The vehicle as the controller knows it.
    provenance : Provenance
        Where the run comes from.
    performance : Performance
        How fast it was computed.
    logged : mapping of str to LoggedColumn
        What the flight's own parts, or who stepped it, had recorded.
    time : (K,) array, s
        t_k = k times the physics step.
    """

    time: FloatArray
    p_WB: FloatArray = column("m", "axis", frame="W", long_name="position of the centre of mass")
    R_WB: FloatArray = column(
        "1",
        "axis_W",
        "axis_B",
        frame=_BODY_TO_WORLD,
        long_name="attitude, rotation matrix",
        more="Its columns are the axes of B in W.",
    )
    v_WB: FloatArray = column("m/s", "axis", frame="W", long_name="velocity of the centre of mass")
    w_WB_B: FloatArray = column("rad/s", "axis", frame="B", long_name="body rate")
    desired_p_WB: FloatArray = column("m", "axis", frame="W", long_name="desired position")
    desired_R_WB: FloatArray = column(
        "1",
        "axis_W",
        "axis_B",
        frame=_BODY_TO_WORLD,
        long_name="desired attitude, rotation matrix",
    )
    desired_v_WB: FloatArray = column("m/s", "axis", frame="W", long_name="desired velocity")
    desired_w_WB_B: FloatArray = column(
        "rad/s",
        "axis",
        frame="B desired",
        long_name="desired body rate",
        more="In the axes of the desired B.",
    )
    thrust_command: FloatArray = column(
        "N",
        "rotor",
        long_name="thrust commanded, along the rotor's axis",
        limits=_THRUST_LIMITS,
    )
    thrust_actual: FloatArray = column(
        "N",
        "rotor",
        long_name="actual thrust, along the rotor's axis",
        more="At its actual speed, by the true coefficient, less what damage and wakes take.",
        limits=_THRUST_LIMITS,
        since=2,
    )
    speed: FloatArray = column(
        "rad/s",
        "rotor",
        long_name="actual speed of the rotor",
        limits=("speed_min", "speed_max"),
        read_in="Hz",
    )
    tilt_command: FloatArray = column(
        "rad", "servo", long_name="tilt commanded", limits=_TILT_LIMITS, read_in="deg"
    )
    tilt_actual: FloatArray = column(
        "rad", "servo", long_name="actual tilt", limits=_TILT_LIMITS, read_in="deg"
    )
    wrench_asked: FloatArray = column(
        _WRENCH_UNITS,
        "wrench",
        frame="B",
        long_name="wrench the controller asked for",
        more="NaN if it asked for none.",
    )
    wrench_achieved: FloatArray = column(
        _WRENCH_UNITS, "wrench", frame="B", long_name="wrench the rotors made"
    )
    drag_power: FloatArray = column(
        "W",
        long_name="power against the drag of all rotors, by the true vehicle",
        more="Σ c_τ |w|³; the controller need not believe in the same coefficients.",
    )
    cost: FloatArray = column("1", long_name="cost of the allocation")
    kkt_residual: FloatArray = column(
        "1",
        long_name="KKT residual of the allocation, scaled problem",
        more="The proof that it is optimal.",
    )
    active: NDArray[np.int8] = column(
        "1",
        "rotor",
        long_name="limit at which the thrust was commanded",
        more="−1 at the lower, +1 at the upper, 0 between.",
        flags={-1: "lower_limit", 0: "free", 1: "upper_limit"},
    )
    outcome: Outcome
    vehicle: Vehicle = field(repr=False)
    provenance: Provenance
    performance: Performance
    logged: Mapping[str, LoggedColumn] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        sizes, rows = sizes_of(self.vehicle), np.size(self.time)
        if rows == 0:
            raise InputError.at("run", "number of rows", 0, "at least 1")
        self._keep("time", (rows,), np.float64)
        for declared in COLUMNS:
            self._keep(declared.name, declared.shape(rows, sizes), declared.dtype)
        object.__setattr__(
            self, "logged", checked(self.logged, rows, names_taken(type(self)) | {*sizes})
        )

    def _keep(self, name: str, shape: tuple[int, ...], dtype: type) -> None:
        array: NDArray[Any] = np.asarray(getattr(self, name), dtype=dtype).view()
        if array.shape != shape:
            raise InputError.at("run", f"shape of {name}", array.shape, str(shape))
        array.flags.writeable = False
        object.__setattr__(self, name, array)

    def __repr__(self) -> str:
        scenario, seconds = self.provenance.scenario_name, float(self.time[-1])
        name = self.outcome.name.lower()
        return f"Run({scenario!r}, {name} after {seconds:g} s, {len(self.time)} rows)"

    def __getitem__(self, name: str) -> NDArray[Any]:
        names = [*_NAMES, *self.logged]
        if name not in names:
            raise InputError.unknown_key("run", str(name), str(name), names)
        logged = self.logged.get(name)
        column: NDArray[Any] = logged.values if logged else getattr(self, name)
        return column

    __iter__ = None  # it is no sequence, though it has names in brackets

    def first_rows(self, rows: int) -> Self:
        """Return the run as far as its first rows."""
        columns: dict[str, Any] = {name: getattr(self, name)[:rows] for name in _NAMES}
        logged = {
            name: LoggedColumn(column.values[:rows], column.unit)
            for name, column in self.logged.items()
        }
        return replace(self, **columns, logged=logged)


COLUMNS: tuple[Column, ...] = columns_of(RunRecord)
"""Every column of a run but `time`, in the order in which they are stored and hashed."""
COLUMN = {column.name: column for column in COLUMNS}

_NAMES = ("time", *(column.name for column in COLUMNS))


def names_taken(kind: type[RunRecord]) -> set[str]:
    """Return the names that no logged column can have, beside those of dimensions."""
    return {*dir(kind), *(field.name for field in fields(kind))}


if RunRecord.__doc__ is not None:  # as under python -OO
    RunRecord.__doc__ = RunRecord.__doc__.rstrip() + "\n" + "".join(map(described, COLUMNS))
