"""Questions about a vehicle that need no time loop: what it can move and hold, at what cost.

========================  =====================================================================
`actuation`               ranks, null spaces, condition, classes; `singular_tilts`
`force_set`               forces, exactly; `moment_set`, `wrench_set`
`omnidirectional_range`   tilts at which every attitude can hover; `inscribed_radius`
`hover`                   thrusts of least power or norm; `hover_map` over attitude and tilt
`hover_in_wakes`          the same with rotors that blow on one another; `vehicle_in_wakes`
`mass_break_even`         whether a tilt mechanism pays for its mass
`sensitivity`             derivatives with respect to the design
`platform`                a vehicle in a few numbers; `lateral_reach`, `reach_over_tilts`
`tilt_sweep`, `analyze`   the main figures over the tilt, and everything at once
========================  =====================================================================
"""

from __future__ import annotations

from omnimorph.analysis.actuation import actuation, singular_tilts
from omnimorph.analysis.free_tilt import reach_over_tilts
from omnimorph.analysis.hover import hover, hover_map, sphere_directions
from omnimorph.analysis.morphing import (
    break_even_tilt,
    mass_break_even,
    mass_break_even_of,
    mechanism_share,
    solved_mass_break_even,
)
from omnimorph.analysis.omnidirectional import (
    inscribed_radius,
    level_hover_range,
    omnidirectional_range,
    tilt_of_largest_radius,
)
from omnimorph.analysis.overview import analyze
from omnimorph.analysis.platform import lateral_reach, platform
from omnimorph.analysis.sensitivity import sensitivity
from omnimorph.analysis.sweep import tilt_sweep
from omnimorph.analysis.wakes import hover_in_wakes, vehicle_in_wakes
from omnimorph.analysis.wrench_set import force_set, moment_set, wrench_set

__all__ = [
    "actuation",
    "analyze",
    "break_even_tilt",
    "force_set",
    "hover",
    "hover_in_wakes",
    "hover_map",
    "inscribed_radius",
    "lateral_reach",
    "level_hover_range",
    "mass_break_even",
    "mass_break_even_of",
    "mechanism_share",
    "moment_set",
    "omnidirectional_range",
    "platform",
    "reach_over_tilts",
    "sensitivity",
    "singular_tilts",
    "solved_mass_break_even",
    "sphere_directions",
    "tilt_of_largest_radius",
    "tilt_sweep",
    "vehicle_in_wakes",
    "wrench_set",
]
