"""A reference without velocity and acceleration feed-forward, as set-points are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from omnimorph.protocols import Desired, FloatArray
from omnimorph.reference import rows
from omnimorph.reference.samples import SampledReference
from omnimorph.reference.segments import SegmentReference


@dataclass(frozen=True, eq=False)
class PoseOnly:
    """The poses of another reference, with velocities and accelerations that are always zero.

    A controller with proportional and derivative terms then brakes what it should follow: it lags
    behind a steady motion by ``velocity gain / position gain`` times its speed, whatever vehicle
    and plant are. Over a flight from rest to rest the mean error is that time times the path length
    over the duration.

    Parameters
    ----------
    reference : SegmentReference or SampledReference
        Where to be.

    Examples
    --------
    >>> import numpy as np
    >>> from omnimorph.reference.segments import Segment
    >>> line = SegmentReference((0, 0, 0), np.eye(3), [Segment(2.0, move_W=(1.0, 0.0, 0.0))])
    >>> desired = PoseOnly(line)(1.0)
    >>> desired.p_WB.tolist(), desired.v_WB.tolist(), line(1.0).v_WB.tolist()
    ([0.5, 0.0, 0.0], [0.0, 0.0, 0.0], [0.9375, 0.0, 0.0])
    """

    reference: SegmentReference | SampledReference

    @property
    def duration(self) -> float:
        """Length of the reference, s."""
        return self.reference.duration

    def as_file(self) -> dict[str, Any]:
        """Return the reference as a scenario file would hold it."""
        return self.reference.as_file() | {"pose_only": True}

    def __call__(self, time: float) -> Desired:
        """Return the pose at `time` (s), at rest."""
        return rows.desired_from_row(self.sample([time])[0])

    def sample(self, times: ArrayLike) -> FloatArray:
        """Return the poses at many times, (K,), s: (K, 24) rows, see `omnimorph.reference.rows`."""
        table = self.reference.sample(times)
        table[:, rows.VELOCITY.start :] = 0.0
        return table
