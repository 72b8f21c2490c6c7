"""A line drawing of any vehicle at any tilt: hubs, arms and propellers as discs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from omnimorph.design.vehicle import Vehicle
from omnimorph.model.geometry import propeller_radius, thrust_axes
from omnimorph.protocols import FloatArray
from omnimorph.report.style import BLUE, GREY, SILVER, VERMILLION, YELLOW

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK = "#222222"
HINGE_LINE: Any = (0, (6.0, 1.8, 1.2, 1.8))
HINGE_REACH = 1.2
"""How far the axis of tilt is drawn to both sides of a hub, in propeller radii."""
SPIN_COLOURS = (VERMILLION, BLUE)
"""Of rotors that turn clockwise, and counter-clockwise, about their thrust axes."""

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

        An orthographic projection: nothing shrinks with its distance, a sphere is a circle.
        """
        return np.atleast_2d(np.asarray(points, dtype=np.float64)) @ self._picture

    @property
    def _picture(self) -> FloatArray:
        return np.column_stack([self.right, self.up])


class _Shape(NamedTuple):
    """A polygon or a line of B, (K, 3), and how it is drawn."""

    points: FloatArray
    face: Any
    edge: str
    width: float
    line: Any = "-"


def camera() -> Camera:
    """Return the camera of all drawings: it looks down a little from −y, with x to the right."""
    c, s = np.cos(_AZIMUTH), np.sin(_AZIMUTH)
    towards = np.array([c * np.cos(_ELEVATION), s * np.cos(_ELEVATION), np.sin(_ELEVATION)])
    right = np.array([-s, c, 0.0])
    return Camera(right=right, up=np.cross(towards, right), towards=towards)


def draw_vehicle(
    panel: Axes, vehicle: Vehicle, tilt: ArrayLike, *, explained: bool = False
) -> None:
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
    explained : bool
        Draw the thrust axes as arrows, and on each disc the axis about which it tilts and the
        direction in which it turns.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.lines import Line2D

    view = camera()
    hubs, axes = vehicle.rotor_position, thrust_axes(vehicle, tilt)
    rotor = _explained_rotor if explained else _plain_rotor
    shapes: list[_Shape] = []
    for i in np.argsort(hubs @ view.towards, kind="stable"):
        shapes += rotor(vehicle, int(i), axes[i])
    drawn = PolyCollection(
        [view.seen(shape.points) for shape in shapes],
        closed=False,
        facecolors=[shape.face for shape in shapes],
        edgecolors=[shape.edge for shape in shapes],
        linewidths=[shape.width for shape in shapes],
        linestyles=[shape.line for shape in shapes],
        zorder=10,
    )
    arms = np.full((vehicle.n_rotors, 3, 3), np.nan)  # from the middle to a hub, then pen up
    arms[:, 0], arms[:, 1] = 0.0, hubs
    panel.add_artist(Line2D(*view.seen(arms.reshape(-1, 3)).T, color=GREY, linewidth=2.2, zorder=2))
    panel.add_collection(drawn, autolim=False)
    radius = propeller_radius(vehicle)
    reach = 1.02 * (float(np.linalg.norm(hubs, axis=1).max()) + radius)
    panel.set_xlim(-reach, reach)
    panel.set_ylim(-0.95 * reach, 0.95 * reach)
    panel.set_aspect("equal")
    panel.axis("off")


def arrow(begin: FloatArray, along: FloatArray, head: float) -> FloatArray:
    """Return the outline of an arrow that is turned to the camera: (7, 3), from (3,) and (3,).

    `head` is the length of its head, in the unit of the others.
    """
    length = float(np.linalg.norm(along))
    forwards = along / length
    aside = np.cross(forwards, camera().towards)
    aside = head * aside / max(float(np.linalg.norm(aside)), 1e-9)
    shaft, neck, tip = 0.09 * aside, begin + (length - head) * forwards, begin + along
    side = [begin + shaft, neck + shaft, neck + 0.36 * aside]
    other = [neck - 0.36 * aside, neck - shaft, begin - shaft]
    return np.array([*side, tip, *other])


def _plain_rotor(vehicle: Vehicle, i: int, axis: FloatArray) -> list[_Shape]:
    hub, radius = vehicle.rotor_position[i], propeller_radius(vehicle)
    thrust = np.array([hub, hub + 0.55 * radius * axis])
    return [_disc(hub, axis, radius), _Shape(thrust, INK, INK, 1.1), _hub_dot(hub, radius)]


def _explained_rotor(vehicle: Vehicle, i: int, axis: FloatArray) -> list[_Shape]:
    hub, radius = vehicle.rotor_position[i], propeller_radius(vehicle)
    shapes = [_disc(hub, axis, radius)]
    if vehicle.rotor_servo[i] >= 0:
        hinge = HINGE_REACH * radius * vehicle.hinge_axis[i]
        shapes.append(_Shape(np.array([hub - hinge, hub + hinge]), "none", INK, 0.9, HINGE_LINE))
    spin = float(vehicle.rotor_spin[i])
    colour = SPIN_COLOURS[spin > 0]
    shapes.append(_Shape(hub + radius * _spin_arrow(axis, spin), colour, colour, 0.0))
    thrust = arrow(hub, 1.15 * radius * axis, 0.3 * radius)
    return [*shapes, _Shape(thrust, INK, INK, 0.0), _hub_dot(hub, radius)]


def _disc(hub: FloatArray, axis: FloatArray, radius: float) -> _Shape:
    face = (YELLOW if hub[2] > 1e-9 else SILVER, 0.75)
    return _Shape(hub + radius * _circle(49) @ _across(axis), face, "#333333c0", 0.9)


def _hub_dot(hub: FloatArray, radius: float) -> _Shape:
    dot = hub + 0.07 * radius * _circle(9) @ camera()._picture.T
    return _Shape(dot, INK, INK, 0.0)


def _spin_arrow(axis: FloatArray, spin: float) -> FloatArray:
    """Return a curved arrow on a disc of radius 1, on the side that is lower in the picture.

    It goes counter-clockwise about the thrust axis if the spin is +1.
    """
    lowest = _across(axis).T @ (_across(axis) @ -camera().up)
    lowest /= max(float(np.linalg.norm(lowest)), 1e-9)
    plane = np.array([lowest, np.cross(axis, lowest)])
    turn = np.radians(np.linspace(-62.0, 40.0, 18))
    turns = np.concatenate([turn, turn[-1:], np.radians([68.0]), turn[-1:], turn[::-1]])
    radii = np.concatenate([np.full(18, 0.73), [0.85, 0.69, 0.53], np.full(18, 0.65)])
    turns *= spin
    outline: FloatArray = (radii * np.array([np.cos(turns), np.sin(turns)])).T @ plane
    return outline


def _circle(corners: int) -> FloatArray:
    turn = np.linspace(0.0, 2.0 * np.pi, corners)
    return np.column_stack([np.cos(turn), np.sin(turn)])


def _across(axis: FloatArray) -> FloatArray:
    """Return two unit vectors across a unit vector: (2, 3)."""
    helper = np.eye(3)[int(np.abs(axis).argmin())]
    first = np.cross(axis, helper)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(axis, first)])
