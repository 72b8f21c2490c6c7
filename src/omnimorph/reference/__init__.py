"""Where the vehicle shall go: segments, waypoints and tables of poses.

Every reference satisfies the protocol `omnimorph.protocols.Reference`: it has a `duration` (s) and
returns the `Desired` motion when called with a time. `sample` evaluates one at many times at once.

- `SegmentReference`: from rest to rest, minimum jerk in each `Segment`;
- `segments_from_waypoints`: the same through poses at given times, resting at each;
- `SampledReference`: a smooth curve through a table (or a CSV file) of poses, without rests.
"""

from __future__ import annotations

from omnimorph.reference.samples import SampledReference
from omnimorph.reference.segments import Segment, SegmentReference, segments_from_waypoints

__all__ = ["SampledReference", "Segment", "SegmentReference", "segments_from_waypoints"]
