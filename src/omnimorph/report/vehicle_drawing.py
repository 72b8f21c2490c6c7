"""A line drawing of any vehicle at any tilt: hubs, arms and propellers as discs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import FloatArray
from omnimorph.report.style import GREY, SILVER, YELLOW

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_vehicle", "propeller_radius"]

_AZIMUTH, _ELEVATION = np.radians(-62.0), np.radians(24.0)


def draw_vehicle(panel: Axes, vehicle: Vehicle, tilt: float) -> None:
    """Draw a vehicle, all servos at one tilt (rad), into a panel that is then only a picture.

    Discs are the propellers, the upper layer yellow, the rest grey; the short line on each is its
    thrust axis. The camera looks down a little from −y; what is farther away is drawn first.
    """
    from matplotlib.patches import Polygon

    right, up, towards = _camera()
    axes = _axes_at(vehicle, tilt)
    radius = propeller_radius(vehicle)
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    for hub, axis in zip(vehicle.rotor_position, axes, strict=True):
        first, second = _across(axis)
        rim = hub + radius * (np.outer(np.cos(turn), first) + np.outer(np.sin(turn), second))
        depth = float(hub @ towards)
        panel.plot(*_seen([np.zeros(3), hub], right, up), color=GREY, linewidth=2.2, zorder=2)
        disc = np.column_stack(_seen(rim, right, up))
        colour = YELLOW if hub[2] > 1e-9 else SILVER
        layer = 10.0 + depth / max(radius, 1e-9)
        drawn = Polygon(disc, facecolor=colour, edgecolor="#333333", linewidth=0.9, alpha=0.75)
        drawn.set_zorder(layer)
        panel.add_patch(drawn)
        tip = hub + 0.55 * radius * axis
        panel.plot(
            *_seen([hub, tip], right, up), color="#222222", linewidth=1.1, zorder=layer + 0.1
        )
        panel.plot(
            *_seen([hub], right, up), "o", color="#222222", markersize=2.0, zorder=layer + 0.2
        )
    reach = 1.02 * (float(np.linalg.norm(vehicle.rotor_position, axis=1).max()) + radius)
    panel.set_xlim(-reach, reach)
    panel.set_ylim(-0.95 * reach, 0.95 * reach)
    panel.set_aspect("equal")
    panel.axis("off")


def propeller_radius(vehicle: Vehicle) -> float:
    """Return a radius for the drawing, m: the largest with which no two discs touch, but for 4 %.

    Vehicles do not know their propellers. OmniMorph: 0.48 · 0.2124 m = 0.102 m, its 8 inches.
    """
    hubs = vehicle.rotor_position
    if len(hubs) == 1:
        return 0.1
    apart = np.linalg.norm(hubs[:, None] - hubs[None], axis=2)
    return 0.48 * float(apart[np.triu_indices(len(hubs), 1)].min())


def _axes_at(vehicle: Vehicle, tilt: float) -> FloatArray:
    z0, zC, zS = vehicle.thrust_axis_parts
    axes: FloatArray = z0 + zC * np.cos(tilt) + zS * np.sin(tilt)
    return axes


def _camera() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the unit vectors to the right, upwards and towards the eye, in B."""
    c, s = np.cos(_AZIMUTH), np.sin(_AZIMUTH)
    towards = np.array([c * np.cos(_ELEVATION), s * np.cos(_ELEVATION), np.sin(_ELEVATION)])
    right = np.array([-s, c, 0.0])
    return right, np.cross(towards, right), towards


def _seen(points: object, right: FloatArray, up: FloatArray) -> tuple[FloatArray, FloatArray]:
    points = np.atleast_2d(np.asarray(points, dtype=np.float64))
    return points @ right, points @ up


def _across(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors across a unit vector."""
    helper = np.eye(3)[int(np.abs(axis).argmin())]
    first = np.cross(axis, helper)
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)
