"""How far, how long and how often a reference may go: what its numbers must be within."""

from __future__ import annotations

from omnimorph.design.ranges import Range

DURATIONS = Range(1e-6, 1e6)
"""Of a segment, s."""
TIMES = Range(0.0, 1e6)
"""Of a waypoint or sample, s."""
APART = 1e-6
"""Two of them are this far apart at least, s."""
POSITIONS = Range(-1e6, 1e6)
"""Each coordinate, m."""
MOVES = Range(-2e6, 2e6)
"""How far a segment goes along each axis, m: from any position to any other."""
ANGLES_DEG = Range(-1e6, 1e6)
"""How far a segment turns, degrees."""
MOST_POSES = 100_000
"""Of a sampled reference."""
