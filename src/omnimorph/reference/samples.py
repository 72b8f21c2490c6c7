"""References through measured or planned poses: a table, usually a CSV file.

Position follows the natural cubic spline through the samples: velocity and acceleration are
continuous, the acceleration is zero at both ends. Attitude follows SciPy's `RotationSpline`: the
body rate and its derivative are continuous. Nothing is brought to rest: a table that begins with a
jump in speed makes a reference that does. Before the first and after the last sample the pose is
held, at rest.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.arrays import as_numbers
from omnimorph.design.csv_tables import read_csv_table
from omnimorph.design.input_files import is_file
from omnimorph.design.ranges import UNIT_VECTOR
from omnimorph.errors import MISSING, ScenarioError
from omnimorph.protocols import Desired, FloatArray, Reference
from omnimorph.reference import rows
from omnimorph.reference.ranges import APART, MOST_POSES, POSITIONS, TIMES

ReferenceLike = Reference | str | os.PathLike[str]
"""A reference, or a CSV file of poses."""

POSE_COLUMNS = ("time_s", "x_m", "y_m", "z_m")
QUATERNION_COLUMNS = ("qw", "qx", "qy", "qz")
RANGES = (
    {"time_s": TIMES}
    | dict.fromkeys(POSE_COLUMNS[1:], POSITIONS)
    | dict.fromkeys(QUATERNION_COLUMNS, UNIT_VECTOR)
)
"""Column -> the range of its numbers."""
_QUATERNION_TOLERANCE = 0.01
_LARGEST_TURN = math.radians(170.0)


class SampledReference:
    """A smooth curve through poses at given times.

    Parameters
    ----------
    times : (K,) array
        In s, from 0 on, each at least 1 µs after the one before; from 2 to 100 000.
    positions : (K, 3) array, m, in W
        Positions of the centre of mass.
    quaternions_wxyz : (K, 4) array, optional
        Attitudes; each within 1 % of unit length, normalised. Level if left out.
    source : str, optional
        What messages call the table.

    Raises
    ------
    ScenarioError
        If a number is beyond its range, the times do not increase, a quaternion is far from unit
        length, or two successive attitudes differ by more than 170°: near 180° the way round is
        ambiguous.

    Examples
    --------
    >>> line = SampledReference([0.0, 1.0, 2.0], [[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    >>> line(0.5).p_WB.tolist(), line(0.5).v_WB.tolist(), line(3.0).v_WB.tolist()
    ([0.5, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    """

    def __init__(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        quaternions_wxyz: ArrayLike | None = None,
        *,
        source: str = "samples",
    ) -> None:
        t = as_numbers(times)
        if t.ndim != 1 or t.size < 2:
            raise ScenarioError.at(source, "times", t, "at least two times")
        p = as_numbers(positions)
        level = np.tile([1.0, 0.0, 0.0, 0.0], (t.size, 1))
        q = level if quaternions_wxyz is None else as_numbers(quaternions_wxyz)
        if p.shape != (t.size, 3):
            raise ScenarioError.at(source, "positions", p, f"of shape ({t.size}, 3)")
        if q.shape != (t.size, 4):
            raise ScenarioError.at(source, "quaternions_wxyz", q, f"of shape ({t.size}, 4)")
        table = np.column_stack((t, p, q))
        _check(table, source, [f"sample {k}" for k in range(t.size)])
        self._build(table)

    @classmethod
    def from_csv(cls, path: str | Path) -> Self:
        """Read the poses from a CSV file.

        Parameters
        ----------
        path : str or Path
            A text file whose first line names the columns: ``time_s, x_m, y_m, z_m`` and, if the
            attitude is not level all the time, ``qw, qx, qy, qz``; in any order. One pose a line.

        Raises
        ------
        ScenarioError
            If the file cannot be read or a number in it cannot be used: one sentence that names the
            file, line, column and value and says what is allowed.
        """
        table, lines = _read_csv(path)
        if len(table) < 2:
            sentence = f"{path}: it holds {len(table)} poses, but it must hold 2 or more."
            raise ScenarioError(sentence, file=str(path))
        _check(table, str(path), lines)
        reference = cls.__new__(cls)
        reference._build(table)
        return reference

    def as_file(self) -> dict[str, Any]:
        """Return the samples, to be kept with a run."""
        return {
            "kind": "samples",
            "columns": "time_s x_m y_m z_m qw qx qy qz",
            "rows": self._table.tolist(),
        }

    @property
    def duration(self) -> float:
        """Time of the last sample, s."""
        return float(self._times[-1])

    def __call__(self, time: float) -> Desired:
        """Return the desired motion at `time` (s)."""
        return rows.desired_from_row(self.sample([time])[0])

    def sample(self, times: ArrayLike) -> FloatArray:
        """Return the desired motion at many times, (K,), s, in any order.

        They are the (K, 24) rows that `omnimorph.reference.rows` describes.
        """
        t = np.asarray(times, dtype=np.float64)
        inside = np.clip(t, self._times[0], self._times[-1])
        table = np.empty((t.size, rows.ROW_LENGTH))
        table[:, rows.POSITION] = self._position(inside)
        table[:, rows.VELOCITY] = self._position(inside, 1)
        table[:, rows.ACCELERATION] = self._position(inside, 2)
        table[:, rows.ATTITUDE] = self._attitude(inside).as_matrix().reshape(-1, 9)
        table[:, rows.BODY_RATE] = self._attitude(inside, 1)
        table[:, rows.BODY_RATE_DERIVATIVE] = self._attitude(inside, 2)
        table[t != inside, 12:] = 0.0  # held at rest
        return table

    def _build(self, table: FloatArray) -> None:
        # SciPy takes a second to load, so only those who use a table of poses wait for it.
        from scipy.interpolate import CubicSpline
        from scipy.spatial.transform import Rotation, RotationSpline

        self._table = table
        self._times: FloatArray = table[:, 0].copy()
        attitudes = Rotation.from_quat(table[:, 4:8], scalar_first=True)
        self._position: Any = CubicSpline(self._times, table[:, 1:4], bc_type="natural")
        self._attitude: Any = RotationSpline(self._times, attitudes)


def _check(table: FloatArray, source: str, places: Sequence[str]) -> None:
    """Refuse a table of time, position and quaternion; `places` says where each row stands."""
    if len(table) > MOST_POSES:
        raise ScenarioError.at(source, "number of poses", len(table), f"at most {MOST_POSES}")
    limits = list(RANGES.values())
    least, most = np.array([limit[:2] for limit in limits]).T
    wrong = np.argwhere(~((table >= least) & (table <= most)))
    if len(wrong):
        row, column = (int(index) for index in wrong[0])
        key, value = f"{places[row]}, column {list(RANGES)[column]}", float(table[row, column])
        raise ScenarioError.at(source, key, value, f"a number {limits[column]}")
    times = table[:, 0]
    late = np.flatnonzero(np.diff(times) < APART)
    if late.size:
        row = int(late[0]) + 1
        allowed = f"later than the time before it, {times[row - 1]} s, by {APART:g} s or more"
        raise ScenarioError.at(source, f"{places[row]}, column time_s", float(times[row]), allowed)
    _check_attitudes(table[:, 4:8], source, places)


def _check_attitudes(q: FloatArray, source: str, places: Sequence[str]) -> None:
    length = np.linalg.norm(q, axis=1)
    far = np.flatnonzero(np.abs(length - 1.0) > _QUATERNION_TOLERANCE)
    if far.size:
        row = int(far[0])
        key = f"{places[row]}, column {QUATERNION_COLUMNS[0]} to {QUATERNION_COLUMNS[3]}"
        raise ScenarioError.at(source, key, q[row], "a quaternion of unit length within 1 %")
    unit = q / length[:, None]
    # The half angle between successive attitudes, from |q0 ∓ q1|: exact near 0 and near 180°.
    apart = np.linalg.norm(unit[1:] - unit[:-1], axis=1)
    opposed = np.linalg.norm(unit[1:] + unit[:-1], axis=1)
    turn = 4.0 * np.arctan2(np.minimum(apart, opposed), np.maximum(apart, opposed))
    large = np.flatnonzero(turn > _LARGEST_TURN)
    if large.size:
        row = int(large[0]) + 1
        key = f"{places[row]}, turn from the attitude before"
        value = f"{math.degrees(turn[row - 1]):.1f}°"
        raise ScenarioError(
            f"{source}: {key} is {value}, but it must be at most 170°; give more poses in between.",
            file=source,
            key=key,
            value=value,
            allowed="at most 170°",
        )


def as_reference(place: str, reference: ReferenceLike) -> Reference:
    """Return a reference that may be given, at a `place`, as a CSV file of poses; or refuse it."""
    if isinstance(reference, str | os.PathLike) and is_file(reference):
        return SampledReference.from_csv(os.fsdecode(reference))
    try:
        if callable(reference) and hasattr(reference, "duration"):
            return reference
    except Exception as error:
        why = f"{type(error).__name__}: {error}"
        raise ScenarioError(f"{place}: the duration of the reference failed with {why}.") from error
    allowed = "a reference, which has a duration and is called with a time, or a CSV file"
    raise ScenarioError.at(place, "reference", reference, allowed)


def _read_csv(path: str | Path) -> tuple[FloatArray, list[str]]:
    """Return the (K, 8) table of time, position, quaternion, and the line of each row."""
    content = read_csv_table(path, partial(_check_header, path), RANGES, ScenarioError)
    table = np.zeros((len(content.rows), 8))
    table[:, 4] = 1.0
    order = [(*POSE_COLUMNS, *QUATERNION_COLUMNS).index(name) for name in content.columns]
    table[:, order] = content.rows
    return table, [f"line {line}" for line in content.lines]


def _check_header(path: str | Path, columns: Sequence[str]) -> None:
    known = (*POSE_COLUMNS, *QUATERNION_COLUMNS)
    with_attitude = any(name in QUATERNION_COLUMNS for name in columns)
    for name in known if with_attitude else POSE_COLUMNS:
        if name not in columns:
            allowed = f"there: the first line names the columns {', '.join(POSE_COLUMNS)}"
            allowed += f" and, all or none, {', '.join(QUATERNION_COLUMNS)}"
            raise ScenarioError.at(path, f"line 1, column {name}", MISSING, allowed)
    for name in columns:
        if name not in known:
            raise ScenarioError.unknown_key(path, f"line 1, column {name!r}", name, known)
