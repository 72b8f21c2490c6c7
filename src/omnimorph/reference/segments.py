"""References made of segments: from rest to rest, minimum jerk in position and in one rotation.

Within a segment of duration T that begins at t0 in the pose p0, R0, with u = (t - t0) / T::

    s(u) = 10 u³ - 15 u⁴ + 6 u⁵            the rest-to-rest polynomial of least jerk
    p    = p0 + s d                        d: the move, in W
    R    = exp(s φ [a]×) R0                a: the rotation axis, in W;  φ: the angle
    v    = ṡ d        w_B  = ṡ φ R0ᵀ a     (a rotation leaves its own axis alone: Rᵀ a = R0ᵀ a)
    v̇    = s̈ d        dw_B = s̈ φ R0ᵀ a

The next segment begins where the one before ended; after the last one the pose is held.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.design.ranges import UNIT_VECTOR, Range
from omnimorph.design.records import quantity
from omnimorph.errors import ScenarioError
from omnimorph.protocols import Desired, FloatArray
from omnimorph.reference import rows
from omnimorph.reference.ranges import ANGLES_DEG, APART, DURATIONS, MOVES, POSITIONS, TIMES

TABLE_LENGTH = 21
_TOLERANCE = 0.01  # of the length of a unit vector or quaternion, and of R Rᵀ

Number = TypeVar("Number", float, FloatArray)


@dataclass(frozen=True, eq=False, init=False)
class Segment:
    """One move from rest to rest.

    Parameters
    ----------
    duration : float
        How long it takes, s; positive.
    move_W : (3,) array, m, in W
        How far it goes.
    rotation_axis_W : (3,) array, in W
        Unit axis it turns about; normalised if its length is within 1 % of 1. Not used if the angle
        is 0.
    rotation_angle : float
        How far it turns about the axis, rad; any number of turns.

    Raises
    ------
    ScenarioError
        If a number is beyond its range or not finite, or the axis has no unit length.

    Examples
    --------
    >>> climb = Segment(3.0, move_W=(0.0, 0.0, 0.8))
    >>> flip = Segment(18.0, rotation_axis_W=(1.0, 0.0, 0.0), rotation_angle=2.0 * np.pi)
    """

    duration: float = quantity("s", DURATIONS, "a positive number of seconds", shape=())
    move_W: FloatArray = quantity(
        "m", MOVES, "three numbers of metres", shape=(3,), default=(0.0, 0.0, 0.0), word="move"
    )
    rotation_axis_W: FloatArray = quantity(
        "", UNIT_VECTOR, "a unit vector", shape=(3,), default=(0.0, 0.0, 1.0)
    )
    rotation_angle: float = quantity(
        "deg", ANGLES_DEG, "a number of degrees", shape=(), default=0.0
    )

    def __init__(
        self,
        duration: float,
        move_W: ArrayLike = (0.0, 0.0, 0.0),
        rotation_axis_W: ArrayLike = (0.0, 0.0, 1.0),
        rotation_angle: float = 0.0,
    ) -> None:
        T = float(_array("duration", duration, (), DURATIONS))
        angle = float(_array("rotation_angle", rotation_angle, (), ANGLES_DEG.in_SI("deg")))
        axis = _array("rotation_axis_W", rotation_axis_W, (3,))
        vars(self).update(
            duration=T,
            move_W=_array("move_W", move_W, (3,), MOVES),
            rotation_axis_W=axis if angle == 0 else _unit("rotation_axis_W", axis),
            rotation_angle=angle,
        )

    def as_file(self) -> dict[str, Any]:
        """Return the segment as a scenario file would hold it."""
        content: dict[str, Any] = {"duration_s": self.duration}
        if self.move_W.any():
            content["move_m"] = self.move_W.tolist()
        if self.rotation_angle:
            content["rotation_axis_W"] = self.rotation_axis_W.tolist()
            content["rotation_angle_deg"] = float(np.degrees(self.rotation_angle))
        return content


@dataclass(frozen=True, eq=False, init=False)
class SegmentReference:
    """A reference made of segments, one after the other.

    Parameters
    ----------
    start_p_WB : (3,) array, m, in W
        Position at time 0.
    start_R_WB : (3, 3) array
        Attitude at time 0.
    segments : iterable of Segment
        At least one.

    Raises
    ------
    ScenarioError
        If there is no segment, a number is not finite or the attitude is no rotation.

    Examples
    --------
    >>> up = SegmentReference((0.0, 0.0, 1.2), np.eye(3), [Segment(3.0, move_W=(0.0, 0.0, 0.8))])
    >>> up(1.5).p_WB.round(6).tolist(), up(1.5).v_WB.round(6).tolist()  # half way: v = 15/8 d/T
    ([0.0, 0.0, 1.6], [0.0, 0.0, 0.5])
    """

    start_p_WB: FloatArray
    start_R_WB: FloatArray
    segments: tuple[Segment, ...]

    def __init__(
        self, start_p_WB: ArrayLike, start_R_WB: ArrayLike, segments: Iterable[Segment]
    ) -> None:
        object.__setattr__(self, "start_p_WB", _array("start_p_WB", start_p_WB, (3,), POSITIONS))
        object.__setattr__(self, "start_R_WB", _rotation("start_R_WB", start_R_WB))
        object.__setattr__(self, "segments", tuple(segments))
        if not self.segments:
            raise ScenarioError("A trajectory of segments needs at least one segment.")
        for segment in self.segments:
            if not isinstance(segment, Segment):
                raise ScenarioError.at("trajectory", "segments", segment, "Segments")

    @property
    def duration(self) -> float:
        """Length of all segments together, s."""
        return self._starts[-1] + self.segments[-1].duration

    def as_file(self) -> dict[str, Any]:
        """Return the reference as a scenario file would hold it."""
        return {
            "kind": "segments",
            "start_position_m": self.start_p_WB.tolist(),
            "start_attitude": self.start_R_WB.tolist(),
            "segment": [segment.as_file() for segment in self.segments],
        }

    def as_table(self) -> FloatArray:
        """Return the segments as plain numbers, for the compiled core.

        Returns
        -------
        (number of segments, 21) array
            One row a segment: start time t0 (s), duration T (s), position p0 (3, m, in W) and
            attitude R0 (9, row by row) at its begin, move d (3, m, in W) before R0, then rotation
            axis (3, unit, in W) and angle (rad)::

                0: t0   1: T   2:5 p0   5:8 d   8:17 R0   17:20 axis_W   20: angle
        """
        return self._table.copy()

    def __call__(self, time: float) -> Desired:
        """Return the desired motion at `time` (s); before 0 and after the end it rests."""
        i = max(bisect_right(self._starts, time) - 1, 0)
        segment, row = self.segments[i], self._table[i]
        T, angle = segment.duration, segment.rotation_angle
        s, ds, dds = _minimum_jerk(min(max((time - self._starts[i]) / T, 0.0), 1.0))
        ds, dds = ds / T, dds / (T * T)
        axis_B, R0, R_sine, R_cosine = (part[i] for part in self._turning)
        d = row[5:8]
        return Desired(
            p_WB=row[2:5] + s * d,
            R_WB=R0 + np.sin(s * angle) * R_sine + (1.0 - np.cos(s * angle)) * R_cosine,
            v_WB=ds * d,
            w_WB_B=(ds * angle) * axis_B,
            a_WB=dds * d,
            dw_WB_B=(dds * angle) * axis_B,
        )

    def sample(self, times: ArrayLike) -> FloatArray:
        """Return the desired motion at many times, (K,), s, in any order.

        They are the (K, 24) rows that `omnimorph.reference.rows` describes.
        """
        t = np.asarray(times, dtype=np.float64)
        i = np.maximum(np.searchsorted(self._starts, t, side="right") - 1, 0)
        start, T, angle = (self._table[i, column] for column in (0, 1, 20))
        s, ds, dds = _minimum_jerk(np.clip((t - start) / T, 0.0, 1.0))
        ds, dds = ds / T, dds / (T * T)
        d = self._table[i, 5:8]
        axis_B, R0, R_sine, R_cosine = (part[i].reshape(t.size, -1) for part in self._turning)
        table = np.empty((t.size, rows.ROW_LENGTH))
        table[:, rows.POSITION] = self._table[i, 2:5] + s[:, None] * d
        table[:, rows.ATTITUDE] = (
            R0 + np.sin(s * angle)[:, None] * R_sine + (1.0 - np.cos(s * angle))[:, None] * R_cosine
        )
        table[:, rows.VELOCITY] = ds[:, None] * d
        table[:, rows.BODY_RATE] = (ds * angle)[:, None] * axis_B
        table[:, rows.ACCELERATION] = dds[:, None] * d
        table[:, rows.BODY_RATE_DERIVATIVE] = (dds * angle)[:, None] * axis_B
        return table

    @cached_property
    def _starts(self) -> list[float]:
        """When each segment begins, s."""
        starts = [0.0]
        for segment in self.segments[:-1]:
            starts.append(starts[-1] + segment.duration)
        return starts

    @cached_property
    def _table(self) -> FloatArray:
        """The rows of `as_table`."""
        table = np.zeros((len(self.segments), TABLE_LENGTH))
        p, R = self.start_p_WB, self.start_R_WB
        for row, start, segment in zip(table, self._starts, self.segments, strict=True):
            axis, angle = segment.rotation_axis_W, segment.rotation_angle
            row[0], row[1], row[20] = start, segment.duration, angle
            row[2:5], row[5:8], row[8:17], row[17:20] = p, segment.move_W, R.ravel(), axis
            p = p + row[5:8]
            R = rows.rotation_from_axis(axis, angle) @ R if angle != 0 else R
        return table

    @cached_property
    def _turning(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Per segment R0ᵀ a, R0, [a]× R0 and [a]×² R0: what Rodrigues' formula is made of."""
        R0 = self._table[:, 8:17].reshape(-1, 3, 3)
        axis = self._table[:, 17:20]
        a = np.array([rows.cross_matrix(one) for one in axis])
        return np.einsum("kij,ki->kj", R0, axis), R0, a @ R0, a @ a @ R0


def segments_from_waypoints(
    times: ArrayLike, positions: ArrayLike, quaternions_wxyz: ArrayLike | None = None
) -> SegmentReference:
    """Build a reference that rests in given poses at given times.

    Between two poses it moves by minimum jerk, turning the shorter way about the axis of
    R_next R_previousᵀ. If the first time is later than 0, the first pose is held until then.

    Parameters
    ----------
    times : (K,) array
        In s, from 0 on, strictly increasing; at least two.
    positions : (K, 3) array, m, in W
        Where it rests.
    quaternions_wxyz : (K, 4) array, optional
        Attitudes in which it rests; within 1 % of unit length, normalised. Level if left out.

    Returns
    -------
    SegmentReference

    Raises
    ------
    ScenarioError
        If the numbers are not finite, the shapes do not fit, the times do not increase or a
        quaternion is far from unit length.

    Examples
    --------
    >>> there_and_back = segments_from_waypoints([0, 2, 4], [[0, 0, 1], [1, 0, 1], [0, 0, 1]])
    >>> there_and_back(2.0).p_WB.tolist()
    [1.0, 0.0, 1.0]
    """
    t = _array("times", times, None, TIMES)
    if t.ndim != 1 or t.size < 2 or np.any(np.diff(t) < APART):
        allowed = f"two or more seconds from 0 on, each at least {APART:g} s after the one before"
        raise ScenarioError.at("waypoints", "times", t, allowed)
    p = _array("positions", positions, (t.size, 3), POSITIONS)
    level = np.tile([1.0, 0.0, 0.0, 0.0], (t.size, 1))
    q = level if quaternions_wxyz is None else quaternions_wxyz
    q = _unit("quaternions_wxyz", _array("quaternions_wxyz", q, (t.size, 4)))
    segments = [Segment(float(t[0]))] if t[0] > 0 else []
    for k in range(t.size - 1):
        axis, angle = rows.relative_rotation(q[k], q[k + 1])
        segments.append(Segment(float(t[k + 1] - t[k]), p[k + 1] - p[k], axis, angle))
    return SegmentReference(p[0], rows.rotation_from_quaternion(q[0]), segments)


def _minimum_jerk(u: Number) -> tuple[Number, Number, Number]:
    """Return s, ds/du and d²s/du² of the minimum-jerk polynomial at u, from 0 to 1."""
    rest = 1 - u
    s = u * u * u * (10 + u * (6 * u - 15))
    return s, 30 * u * u * rest * rest, 60 * u * rest * (rest - u)


def _array(
    name: str, value: ArrayLike, shape: tuple[int, ...] | None, limits: Range | None = None
) -> FloatArray:
    """Return `value` as a read-only array of finite numbers, of a shape and range if asked for."""
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ScenarioError.at("trajectory", name, value, "numbers") from None
    if shape is not None and array.shape != shape:
        allowed = f"of shape {shape}" if shape else "one number"
        raise ScenarioError.at("trajectory", name, value, allowed)
    if not np.all(np.isfinite(array)):
        raise ScenarioError.at("trajectory", name, value, "finite")
    if limits is not None and not ((array >= limits.least) & (array <= limits.most)).all():
        raise ScenarioError.at("trajectory", name, value, f"{limits} in SI")
    return _read_only(array)


def _unit(name: str, vectors: FloatArray) -> FloatArray:
    """Return vectors of nearly unit length (along the last axis) with unit length."""
    with np.errstate(over="ignore"):
        length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    if np.any(np.abs(length - 1.0) > _TOLERANCE):
        raise ScenarioError.at("trajectory", name, vectors, "of unit length within 1 %")
    return _read_only(np.asarray(vectors / length))


def _rotation(name: str, value: ArrayLike) -> FloatArray:
    """Return a matrix that is nearly a rotation, made exactly one."""
    R = _array(name, value, (3, 3))
    near_unit = np.max(np.abs(R)) < 2.0  # so that the product below cannot overflow
    if not near_unit or np.max(np.abs(R @ R.T - np.eye(3))) > _TOLERANCE or np.linalg.det(R) < 0:
        raise ScenarioError.at("trajectory", name, value, "a rotation matrix")
    left, _, right = np.linalg.svd(R)
    nearest: FloatArray = left @ right
    # An exact rotation, such as the identity, stays what it was to the last digit.
    return R if np.max(np.abs(nearest - R)) < 1e-15 else _read_only(nearest)


def _read_only(array: FloatArray) -> FloatArray:
    array.flags.writeable = False
    return array
