"""A line drawing of any vehicle at any tilt: hubs, arms and propellers as discs."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import FloatArray
from omnimorph.report.style import GREY, SILVER, YELLOW

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Camera", "camera", "draw_vehicle", "propeller_radius"]

_AZIMUTH, _ELEVATION = np.radians(-62.0), np.radians(24.0)


class Camera(NamedTuple):
    """From where everything in B is looked at: three unit vectors at right angles, in B.

    Attributes
    ----------
    right, up : (3,) arrays
        What lies to the right and upwards in the picture.
    towards : (3,) array
        Towards the eye.
    """

    right: FloatArray
    up: FloatArray
    towards: FloatArray

    def seen(self, points: ArrayLike) -> FloatArray:
        """Return where points of B, (K, 3) or (3,), lie in the picture: (K, 2), in their unit.

        An orthographic projection: nothing shrinks with its distance, a ball is a circle.
        """
        return np.atleast_2d(np.asarray(points, dtype=np.float64)) @ self._picture

    @property
    def _picture(self) -> FloatArray:
        return np.column_stack([self.right, self.up])


def camera() -> Camera:
    """Return the camera of all drawings: it looks down a little from −y, with x to the right."""
    c, s = np.cos(_AZIMUTH), np.sin(_AZIMUTH)
    towards = np.array([c * np.cos(_ELEVATION), s * np.cos(_ELEVATION), np.sin(_ELEVATION)])
    right = np.array([-s, c, 0.0])
    return Camera(right=right, up=np.cross(towards, right), towards=towards)


def draw_vehicle(panel: Axes, vehicle: Vehicle, tilt: ArrayLike) -> None:
    """Draw a vehicle into a panel that is then only a picture.

    Discs are the propellers, the upper layer yellow, the rest grey; the short line on each is its
    thrust axis. What is farther away is drawn first.

    Parameters
    ----------
    panel : Axes
        Where.
    vehicle : Vehicle
        Any.
    tilt : float or (m,) array, rad
        Of all servos, or of each.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.lines import Line2D

    view = camera()
    radius = propeller_radius(vehicle)
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    circle = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    shapes: list[FloatArray] = []
    looks: list[tuple[str, float]] = []
    rotors = zip(vehicle.rotor_position, _axes_at(vehicle, tilt), strict=True)
    for hub, axis in sorted(rotors, key=lambda rotor: float(rotor[0] @ view.towards)):
        disc = hub + circle @ _across(axis)
        dot = hub + 0.07 * circle[::6] @ np.array([view.right, view.up])
        shapes += [disc, np.array([hub, hub + 0.55 * radius * axis]), dot]
        looks += [(YELLOW if hub[2] > 1e-9 else SILVER, 0.75), ("#222222", 1.0), ("#222222", 1.0)]
    drawn = PolyCollection(
        [view.seen(shape) for shape in shapes],
        facecolors=looks,
        edgecolors=["#333333c0", "#222222", "#222222"] * vehicle.n_rotors,
        linewidths=[0.9, 1.1, 0.0] * vehicle.n_rotors,
        zorder=10,
    )
    arms = np.full((vehicle.n_rotors, 3, 3), np.nan)  # from the middle to a hub, then pen up
    arms[:, 0], arms[:, 1] = 0.0, vehicle.rotor_position
    panel.add_artist(Line2D(*view.seen(arms.reshape(-1, 3)).T, color=GREY, linewidth=2.2, zorder=2))
    panel.add_collection(drawn, autolim=False)
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


def _axes_at(vehicle: Vehicle, tilt: ArrayLike) -> FloatArray:
    z0, zC, zS = vehicle.thrust_axis_parts
    servos = np.broadcast_to(np.asarray(tilt, dtype=np.float64), vehicle.n_servos)
    # a rotor that no servo tilts has index −1: it finds the zero at the end
    angle = np.append(servos, 0.0)[vehicle.rotor_servo][:, None]
    axes: FloatArray = z0 + zC * np.cos(angle) + zS * np.sin(angle)
    return axes


def _across(axis: FloatArray) -> FloatArray:
    """Return two unit vectors across a unit vector: (2, 3)."""
    helper = np.eye(3)[int(np.abs(axis).argmin())]
    first = np.cross(axis, helper)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(axis, first)])
