"""The design of a vehicle in one figure: where its rotors are, how they tilt and how they turn."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.analysis.actuation import ThrustKind, actuation
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.geometry import propeller_radius, thrust_axes
from omnimorph.protocols import FloatArray
from omnimorph.report.style import (
    GREEN,
    GREY,
    SILVER,
    VEIL,
    WIDTH,
    YELLOW,
    legend_above,
    new_figure,
    styled,
)
from omnimorph.report.tables import degrees
from omnimorph.report.vehicle_drawing import (
    HINGE_LINE,
    INK,
    SPIN_COLOURS,
    arrow,
    camera,
    draw_vehicle,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BESIDE = np.radians(50.0)
_EDGE: dict[str, Any] = {"color": GREY, "linewidth": 0.8, "linestyle": (0, (4.0, 2.5))}

_HINGE: dict[str, Any] = {"color": INK, "linewidth": 0.9, "linestyle": HINGE_LINE}
_DISC: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 8.0,
    "markeredgecolor": "#333333",
}
_GLYPH: dict[str, Any] = {"linestyle": "none", "markersize": 10.0, "markeredgewidth": 0.0}
_THRUST = _GLYPH | {"color": INK, "marker": r"$\rightarrow$", "markersize": 17.0}
_TURNS_LEFT, _TURNS_RIGHT = {"marker": r"$\circlearrowleft$"}, {"marker": r"$\circlearrowright$"}


@styled
def geometry(vehicle: Vehicle, tilts: Sequence[float]) -> Figure:
    """Draw a vehicle at a few tilts side by side, with all that its design consists of.

    Hubs are numbered from 0, as in arrays. On every propeller are its thrust axis, the axis about
    which it tilts and the direction in which it turns when its thrust is positive; in the middle
    is the body frame B. The edges of a box are dashed if the hubs are its corners.

    Parameters
    ----------
    vehicle : Vehicle
        Any; without servos there are no axes of tilt.
    tilts : sequence of float, rad
        Of all servos; two or three fit the page well.
    """
    seen = np.abs(camera().seen(vehicle.rotor_position)).max(axis=0)
    across, high = seen + 1.25 * propeller_radius(vehicle)
    height = min(WIDTH / len(tilts) * high / across, 4.0) + 0.75
    figure, axes = new_figure(height, 1, len(tilts))
    for panel, tilt in zip(axes[0], tilts, strict=True):
        _draw_box(panel, vehicle)
        draw_vehicle(panel, vehicle, tilt, explained=True)
        _draw_frame(panel, vehicle)
        _draw_numbers(panel, vehicle, tilt)
        panel.set_xlim(-across, across)
        panel.set_ylim(-high, high)
        kind = _kind(vehicle, tilt)
        panel.set_title(f"tilt {degrees(tilt)}: {kind}" if vehicle.n_servos else kind, pad=2.0)
    legend_above(figure, *_entries(vehicle), columns=3)
    return figure


def _kind(vehicle: Vehicle, tilt: float) -> str:
    found = actuation(vehicle, tilt)
    omnidirectional = found.thrust_kind is ThrustKind.OMNIDIRECTIONAL
    return found.thrust_kind.value if omnidirectional else found.kind.value


def box_edges(hubs: FloatArray) -> FloatArray:
    """Return the edges of the box whose eight corners are the hubs: (12, 2, 3), or (0, 2, 3).

    Parameters
    ----------
    hubs : (n, 3) array, m
        The box lies along the axes, else there is none.
    """
    low, high = hubs.min(axis=0), hubs.max(axis=0)
    corners = np.array(list(itertools.product(*zip(low, high, strict=True))))
    apart = np.linalg.norm(hubs[:, None] - corners[None], axis=2)
    near = apart < 1e-6 * float(np.linalg.norm(high - low))
    if len(hubs) != 8 or not (near.sum(axis=0) == 1).all():
        return np.empty((0, 2, 3))
    pairs = itertools.combinations(corners, 2)
    return np.array([pair for pair in pairs if np.count_nonzero(pair[0] != pair[1]) == 1])


def _draw_box(panel: Axes, vehicle: Vehicle) -> None:
    from matplotlib.collections import LineCollection

    edges = [camera().seen(edge) for edge in box_edges(vehicle.rotor_position)]
    panel.add_collection(LineCollection(edges, zorder=1, **_EDGE), autolim=False)


def _draw_frame(panel: Axes, vehicle: Vehicle) -> None:
    """Draw the axes x, y, z of the body as arrows from its middle."""
    from matplotlib.collections import PolyCollection

    length = 0.75 * propeller_radius(vehicle)
    arrows = [camera().seen(arrow(np.zeros(3), length * axis, 0.3 * length)) for axis in np.eye(3)]
    drawn = PolyCollection(arrows, facecolors=GREEN, edgecolors="white", linewidths=0.4, zorder=12)
    panel.add_collection(drawn, autolim=False)
    tips = camera().seen(length * np.eye(3))
    for name, (x, y) in zip("xyz", tips + 0.26 * length * _to_the_right(tips), strict=True):
        letter: dict[str, Any] = {"style": "italic", "color": GREEN, "weight": "bold"}
        panel.text(x, y, name, ha="center", va="center", zorder=13, bbox=VEIL, **letter)


def _draw_numbers(panel: Axes, vehicle: Vehicle, tilt: float) -> None:
    """Write the number of each rotor beside its hub, to the right of its thrust axis."""
    radius, thrust = propeller_radius(vehicle), camera().seen(thrust_axes(vehicle, tilt))
    spots = camera().seen(vehicle.rotor_position) + 0.36 * radius * _to_the_right(thrust)
    for i, (x, y) in enumerate(spots):
        style: dict[str, Any] = {"ha": "center", "va": "center", "weight": "bold", "zorder": 13}
        panel.text(x, y, f"{i}", bbox=VEIL, **style)


def _to_the_right(arrows: FloatArray) -> FloatArray:
    """Return unit vectors of the picture, (K, 2), in which words beside some arrows are clear."""
    c, s = np.cos(_BESIDE), np.sin(_BESIDE)
    turned = arrows @ np.array([[c, -s], [s, c]])
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    beside: FloatArray = turned / np.maximum(lengths, 1e-9)  # an arrow may point to the eye
    return beside


def _entries(vehicle: Vehicle) -> tuple[list[Any], list[str]]:
    """Return what the legend shows: marks and words, for what the drawing holds only."""
    from matplotlib.lines import Line2D

    upper, forwards = vehicle.rotor_position[:, 2] > 1e-9, vehicle.rotor_spin > 0
    sizes = np.ptp(vehicle.rotor_position, axis=0)
    box = "cube" if np.allclose(sizes, sizes[0]) else "box"
    clockwise, counter_clockwise = (_GLYPH | {"color": colour} for colour in SPIN_COLOURS)
    lower = "lower layer" if upper.any() else "propeller"
    entries: list[tuple[bool, str, dict[str, Any]]] = [
        (bool(upper.any()), "propeller, upper layer", _DISC | {"markerfacecolor": YELLOW}),
        (not upper.all(), lower, _DISC | {"markerfacecolor": SILVER}),
        (True, "thrust axis", _THRUST),
        (vehicle.n_servos > 0, "axis of tilt", _HINGE),
        (bool(forwards.any()), "turns counter-clockwise, k = +1", counter_clockwise | _TURNS_LEFT),
        (not forwards.all(), "turns clockwise, k = −1", clockwise | _TURNS_RIGHT),
        (len(box_edges(vehicle.rotor_position)) > 0, f"edge of the {box}", _EDGE),
    ]
    shown = [(Line2D([], [], **options), label) for there, label, options in entries if there]
    return [handle for handle, _ in shown], [label for _, label in shown]
