"""A set of forces or moments drawn as the solid, plane, line or point that it is.

The projection is the orthographic one of `vehicle_drawing.camera`, so a set and the vehicle beside
it are seen from the same side, lengths do not depend on the distance, and a sphere is a circle.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from omnimorph.analysis.polytope import Polytope
from omnimorph.protocols import FloatArray
from omnimorph.report.style import BLACK, legend_above
from omnimorph.report.tables import number
from omnimorph.report.vehicle_drawing import camera

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BEHIND, _INSIDE, _FRONT, _ABOVE = 2.0, 4.0, 6.0, 8.0  # order of drawing
_MANY = 200  # faces, of which one would not tell the back ones from the front ones
_DASHED = (0, (3.5, 2.0))
_AXIS: dict[str, Any] = {"color": "#333333", "linewidth": 0.9}


class SphereLook(NamedTuple):
    """A sphere about the zero vector: its radius in the unit of the set, and how it is drawn.

    Attributes
    ----------
    radius : float
        A sphere of radius 0 is not drawn.
    colour : str
        Of its outline and, thinly, of its inside.
    filled : bool
        Whether it lies inside the set, behind its front faces, or is an outline over everything.
    """

    radius: float
    colour: str
    filled: bool


class Stage(NamedTuple):
    """What several drawings share, so that they can be compared.

    Attributes
    ----------
    low, high : (2,) arrays
        Corners of the picture, in the unit of the sets; zero is inside.
    axis_length : (3,) array
        How long the body axes x, y, z are drawn.
    tick : float
        Distance of the dots on the axes, and length of the scale bar.
    unit : str
        "N" or "N m".
    """

    low: FloatArray
    high: FloatArray
    axis_length: FloatArray
    tick: float
    unit: str

    @property
    def slenderness(self) -> float:
        """Height of the picture over its width."""
        width, height = self.high - self.low
        return float(height / width)


def stage_for(polytopes: Sequence[Polytope], radii: Sequence[float], unit: str) -> Stage:
    """Return a stage on which all of some sets, and spheres about zero, have room."""
    corners = np.vstack([np.zeros((1, 3)), *(one.vertices for one in polytopes)])
    sphere = max([*radii, 0.0])
    largest = max(float(np.linalg.norm(corners, axis=1).max()), sphere) or 1.0
    axis_length = np.maximum(corners.max(axis=0), 1.25 * sphere) + 0.16 * largest
    tips = camera().seen(np.diag(axis_length))
    tips += 0.13 * largest * tips / np.linalg.norm(tips, axis=1, keepdims=True)  # room for letters
    seen = np.vstack([camera().seen(corners), tips])
    low = np.minimum(seen.min(axis=0), -sphere) - 0.05 * largest
    high = np.maximum(seen.max(axis=0), sphere) + 0.09 * largest
    low[1] -= 0.12 * (high[1] - low[1])  # for the scale bar
    high[0] = max(high[0], -low[0])  # zero in the middle, from left to right
    low[0] = -high[0]
    return Stage(low, high, axis_length, nice_length(0.3 * largest), unit)


def nice_length(about: float) -> float:
    """Return 1, 2 or 5 times a power of ten, the largest that is not above a positive number.

    Examples
    --------
    >>> nice_length(12.9), nice_length(0.07), nice_length(2.0)
    (10.0, 0.05, 2.0)
    """
    power = 10.0 ** math.floor(math.log10(about) + 1e-9)
    step = next(step for step in (5.0, 2.0, 1.0) if step * power <= about * (1 + 1e-9))
    return float(f"{step * power:.3g}")


def picture_panel(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Return a new panel of a figure without a layout engine, its place in inches."""
    across, high = figure.get_size_inches()
    place = (left / across, bottom / high, width / across, height / high)
    panel = figure.add_axes(place, xticks=[], yticks=[])  # ticks that nobody sees take time
    panel.axis("off")
    return panel


def set_legend(figure: Figure, sets: Mapping[str, str], spheres: Sequence[SphereLook]) -> None:
    """Put a legend below drawings of sets: the sets (name -> colour), and the spheres in them."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    entries: dict[str, Any] = {
        name: Patch(facecolor=colour, alpha=0.45, edgecolor=colour) for name, colour in sets.items()
    }
    for sphere in spheres:
        if sphere.filled and sphere.radius > 0.0:
            entries["inscribed sphere"] = Line2D([], [], color=sphere.colour, linewidth=1.1)
        elif not sphere.filled:
            options: dict[str, Any] = {
                "color": sphere.colour,
                "linewidth": 1.1,
                "linestyle": _DASHED,
            }
            entries[f"weight sphere, {number(sphere.radius)} N"] = Line2D([], [], **options)
    legend_above(figure, list(entries.values()), list(entries), where="lower left")


def draw_polytope(
    panel: Axes,
    polytope: Polytope,
    stage: Stage,
    *,
    colour: str,
    spheres: Sequence[SphereLook] = (),
    scale_bar: bool = True,
) -> None:
    """Draw a set of R³ into a panel that is then only a picture.

    A solid has faint back faces and translucent front faces, lighter the more they face the light;
    a plane is one such face, a line a thick stroke, a point a dot. The axes of the body are dotted
    inside the set, with a dot at each tick of the stage.

    Parameters
    ----------
    panel : Axes
        Where.
    polytope : Polytope
        Any set of R³, also an empty one.
    stage : Stage
        With the scale; sets on the same stage have the same.
    colour : str
        Of the set.
    spheres : sequence of SphereLook
        Spheres about the zero vector.
    scale_bar : bool
        Draw the length of a tick with its number and unit.
    """
    view = camera()
    _draw_body(panel, polytope, colour)
    _draw_axes(panel, polytope, stage)
    _draw_spheres(panel, spheres)
    panel.plot(*view.seen(np.zeros(3)).T, "o", color=BLACK, markersize=2.4, zorder=_INSIDE + 0.5)
    if polytope.is_empty:
        panel.text(0.5, 0.12, "none at all", ha="center", transform=panel.transAxes)
    if scale_bar:
        _draw_scale(panel, stage)
    panel.set_xlim(stage.low[0], stage.high[0])
    panel.set_ylim(stage.low[1], stage.high[1])
    panel.set_aspect("equal")
    panel.axis("off")


def _draw_body(panel: Axes, polytope: Polytope, colour: str) -> None:
    from matplotlib.collections import PolyCollection

    view = camera()
    corners = view.seen(polytope.vertices)
    if polytope.dimension in (0, 1):
        panel.plot(*corners.T, color=colour, linewidth=4.0, solid_capstyle="round", zorder=_INSIDE)
        panel.plot(*corners.T, "o", color=colour, markersize=3.6, zorder=_INSIDE)
        return
    faces = [corners[facet] for facet in polytope.facets]
    normals = polytope.normals[: len(faces)]
    if polytope.dimension == 2:  # the one face of a plate is seen from its front
        across = polytope.normals[-1]
        normals = np.copysign(1.0, across @ view.towards) * across[None]
    front = normals @ view.towards > 0.0
    back = ~front if len(faces) <= _MANY else np.zeros_like(front)
    thin = min(1.0, math.sqrt(40.0 / max(len(faces), 1)))
    for shown, alpha, edge, width, layer in (
        (back, 0.13, 0.3, 0.5 * thin, _BEHIND),
        (front, 0.38, 0.85, 0.7 * thin, _FRONT),
    ):
        drawn = PolyCollection(
            [face for face, wanted in zip(faces, shown, strict=True) if wanted],
            facecolors=_shaded(colour, normals[shown], alpha),
            edgecolors=[(*(0.55 * _rgb(colour)), edge)],
            linewidths=width,
            joinstyle="round",
            zorder=layer,
        )
        panel.add_collection(drawn, autolim=False)


def _draw_axes(panel: Axes, polytope: Polytope, stage: Stage) -> None:
    """Draw the axes of the body: dotted in the set, arrows from where they leave it."""
    from matplotlib.collections import PolyCollection
    from matplotlib.lines import Line2D

    view = camera()
    height = float(stage.high[1] - stage.low[1])
    inside: list[FloatArray] = []
    dots: dict[float, list[FloatArray]] = {_BEHIND - 1.0: [], _INSIDE: [], _FRONT + 1.0: []}
    arrows: dict[float, list[FloatArray]] = {_BEHIND - 1.0: [], _FRONT + 1.0: []}
    for along, length, name in zip(np.eye(3), stage.axis_length.tolist(), "xyz", strict=True):
        leaves_at = 0.0 if polytope.is_empty else min(polytope.reach(along), length)
        to_front = polytope.dimension < 3 or _leaves_to_the_front(polytope, along)
        layer = _FRONT + 1.0 if to_front else _BEHIND - 1.0
        begin, leaves, tip = view.seen(np.outer([0.0, leaves_at, length], along))
        forwards = (tip - begin) / float(np.linalg.norm(tip - begin))
        head = 0.032 * height * forwards
        sideways = 0.3 * np.array([-head[1], head[0]])
        inside += [begin, leaves, np.full(2, np.nan)]
        arrows[layer] += [leaves, tip, tip - head + sideways, tip - head - sideways, tip]
        ticks = np.arange(1, int(length / stage.tick + 1e-9) + 1) * stage.tick
        for tick in ticks.tolist():
            dots[_INSIDE if tick <= leaves_at else layer].append(view.seen(tick * along)[0])
        x, y = tip + 0.055 * height * forwards
        panel.text(x, y, name, ha="center", va="center", style="italic", zorder=_ABOVE)
    panel.add_artist(
        Line2D(*np.transpose(inside), linestyle=(0, (1.0, 1.6)), zorder=_INSIDE, **_AXIS)
    )
    for layer, points in arrows.items():
        shapes = np.reshape(points, (-1, 5, 2))
        drawn = PolyCollection(list(shapes), closed=False, zorder=layer, linewidths=0.9)
        drawn.set_color(_AXIS["color"])
        panel.add_collection(drawn, autolim=False)
    for layer, spots in dots.items():
        xs, ys = np.reshape(spots, (-1, 2)).T
        mark: dict[str, Any] = {"marker": "o", "markersize": 1.8, "linestyle": "none"}
        panel.add_artist(Line2D(xs, ys, color=_AXIS["color"], zorder=layer, **mark))


def _leaves_to_the_front(polytope: Polytope, along: FloatArray) -> bool:
    """Return whether a ray from zero leaves a solid through a face that is turned to the eye."""
    speed = polytope.normals @ along
    ahead = speed > 1e-12
    first = int((polytope.offsets[ahead] / speed[ahead]).argmin())
    return bool(polytope.normals[ahead][first] @ camera().towards > 0.0)


def _draw_spheres(panel: Axes, spheres: Sequence[SphereLook]) -> None:
    from matplotlib.patches import Circle

    for sphere in spheres:
        if sphere.radius <= 0.0:
            continue
        inside = (*_rgb(sphere.colour), 0.25) if sphere.filled else "none"
        drawn = Circle(
            (0.0, 0.0),
            sphere.radius,
            facecolor=inside,
            edgecolor=sphere.colour,
            linewidth=1.1,
            linestyle="-" if sphere.filled else _DASHED,
            zorder=_INSIDE - 0.5 if sphere.filled else _ABOVE,
        )
        panel.add_patch(drawn)


def _draw_scale(panel: Axes, stage: Stage) -> None:
    """Draw a bar as long as a tick; it holds for lengths across the line of sight."""
    width, height = stage.high - stage.low
    left, low = stage.low[0] + 0.015 * width, stage.low[1] + 0.015 * height
    panel.plot([left, left + stage.tick], [low, low], color=BLACK, linewidth=1.6, zorder=_ABOVE)
    label = f"{stage.tick:g} {stage.unit}"
    panel.text(left, low + 0.02 * height, label, ha="left", va="bottom")


def _shaded(colour: str, normals: FloatArray, alpha: float) -> list[tuple[float, ...]]:
    """Return a colour for each face, the lighter the more its normal points to the light."""
    view = camera()
    light = view.towards + 0.8 * view.up - 0.5 * view.right
    lit = np.clip(normals @ light / float(np.linalg.norm(light)), 0.0, 1.0)[:, None]
    shades = np.clip(_rgb(colour) * (0.75 + 0.25 * lit) + 0.45 * lit**2, 0.0, 1.0)
    return [(*shade, alpha) for shade in shades.tolist()]


def _rgb(colour: str) -> FloatArray:
    from matplotlib.colors import to_rgb

    return np.array(to_rgb(colour))
