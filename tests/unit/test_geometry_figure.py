"""The figure of a design: hubs, axes and spins are those of the vehicle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.unit.analysis_parts import (
    NOT_MORPHING,
    OMNIMORPH,
    QUADROTOR,
    build_tilting_hexarotor,
)

import omnimorph as om
from omnimorph.model.geometry import propeller_radius, thrust_axes
from omnimorph.protocols import FloatArray
from omnimorph.report import style
from omnimorph.report.geometry_figure import box_edges, geometry
from omnimorph.report.vehicle_drawing import (
    HINGE_REACH,
    SPIN_COLOURS,
    camera,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OMNIDIRECTIONAL = math.atan(math.sqrt(2.0))
VEHICLES = {
    "omnimorph": (OMNIMORPH, [0.0, OMNIDIRECTIONAL]),
    "hexarotor": (build_tilting_hexarotor(), [0.0, 0.6, 1.2]),
    "quadrotor": (QUADROTOR, [0.0]),
    "one rotor": (NOT_MORPHING["one rotor"], [0.0]),
    "fixed": (NOT_MORPHING["fixed"], [0.0]),
}


def shapes_of(panel: Axes) -> list[tuple[FloatArray, str]]:
    """Return the outlines of the rotors in the order of drawing, with their colours."""
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_hex

    (rotors,) = (
        one
        for one in panel.collections
        if isinstance(one, PolyCollection) and one.get_zorder() == 10
    )
    faces = np.atleast_2d(rotors.get_facecolor())
    outlines = [np.asarray(path.vertices) for path in rotors.get_paths()]
    colours = [to_hex(tuple(face)) for face in faces.tolist()]
    return list(zip(outlines, colours, strict=True))


def by_depth(vehicle: om.Vehicle) -> list[int]:
    return [int(i) for i in np.argsort(vehicle.rotor_position @ camera().towards, kind="stable")]


def test_the_edges_of_a_cube_join_its_corners() -> None:
    edges = box_edges(OMNIMORPH.rotor_position)
    assert edges.shape == (12, 2, 3)
    np.testing.assert_allclose(np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1), 0.2124)
    ends = edges.reshape(-1, 3)
    for hub in OMNIMORPH.rotor_position:
        assert np.isclose(ends, hub).all(axis=1).sum() == 3
    assert len(box_edges(QUADROTOR.rotor_position)) == 0
    moved = OMNIMORPH.rotor_position + np.eye(8, 3) * 0.01
    assert len(box_edges(moved)) == 0
    assert len(box_edges(np.tile(QUADROTOR.rotor_position, (2, 1)))) == 0, "flat, hubs twice"


@pytest.mark.parametrize("tilt", [0.0, 0.6, OMNIDIRECTIONAL])
def test_rotors_are_drawn_as_they_are(tilt: float) -> None:
    panel = geometry(OMNIMORPH, [tilt]).axes[0]
    radius, view = propeller_radius(OMNIMORPH), camera()
    axes, shapes = thrust_axes(OMNIMORPH, tilt), shapes_of(panel)
    assert len(shapes) == 5 * 8, "disc, hinge, spin, thrust and hub of each"
    for k, i in enumerate(by_depth(OMNIMORPH)):
        hub = OMNIMORPH.rotor_position[i]
        disc, hinge, spin, thrust, dot = (points for points, _ in shapes[5 * k : 5 * k + 5])
        ends = hub + HINGE_REACH * radius * np.outer([-1.0, 1.0], OMNIMORPH.hinge_axis[i])
        np.testing.assert_allclose(hinge, view.seen(ends), atol=1e-12)
        tip = view.seen(hub + 1.15 * radius * axes[i])
        assert np.linalg.norm(thrust - tip, axis=1).min() < 1e-12
        across = np.linalg.norm(disc - view.seen(hub), axis=1)
        assert across.max() == pytest.approx(radius, rel=0.01)
        assert np.linalg.norm(dot - view.seen(hub), axis=1).max() == pytest.approx(0.07 * radius)
        assert shapes[5 * k + 2][1] == SPIN_COLOURS[bool(OMNIMORPH.rotor_spin[i] > 0)].lower()
        begin, head = spin[0] - view.seen(hub)[0], spin[19] - view.seen(hub)[0]
        turns = begin[0] * head[1] - begin[1] * head[0]  # > 0: counter-clockwise in the picture
        assert np.sign(turns) == OMNIMORPH.rotor_spin[i] * np.sign(axes[i] @ view.towards)


def test_axes_of_tilt_lie_along_the_edges_of_the_cube() -> None:
    edges = box_edges(OMNIMORPH.rotor_position)
    along = (edges[:, 1] - edges[:, 0]) / 0.2124
    for hub, hinge in zip(OMNIMORPH.rotor_position, OMNIMORPH.hinge_axis, strict=True):
        here = np.isclose(edges, hub).all(axis=2).any(axis=1)
        assert np.abs(along[here] @ hinge).max() == pytest.approx(1.0)


def test_thrust_axes_are_those_of_the_allocation() -> None:
    for vehicle, tilts in VEHICLES.values():
        A = om.allocation_matrix(vehicle, tilts[-1])
        np.testing.assert_allclose(thrust_axes(vehicle, tilts[-1]), A[:3].T, atol=1e-12)


@pytest.mark.parametrize("name", VEHICLES)
def test_every_hub_is_numbered_and_all_is_within_the_picture(name: str) -> None:
    vehicle, tilts = VEHICLES[name]
    figure = geometry(vehicle, tilts)
    style.as_svg(figure)
    figure.draw_without_rendering()
    width, height = figure.get_size_inches()
    inside = figure.get_tightbbox()
    assert width == style.WIDTH
    assert min(inside.x0, inside.y0) >= 0.0
    assert inside.x1 <= width
    assert inside.y1 <= height
    radius = propeller_radius(vehicle)
    for panel in figure.axes:
        words = {text.get_text(): text.get_position() for text in panel.texts}
        assert [w for w in words if w not in "xyz"] == [f"{i}" for i in range(vehicle.n_rotors)]
        for i, hub in enumerate(camera().seen(vehicle.rotor_position)):
            assert math.dist(words[f"{i}"], hub) < 0.4 * radius
        low, high = np.transpose([panel.get_xlim(), panel.get_ylim()])
        for points, _ in shapes_of(panel):
            assert (low <= points).all()
            assert (points <= high).all()
        assert min(float(text.get_fontsize()) for text in panel.texts) >= 8.0


def test_titles_and_legends_say_what_is_there() -> None:
    def words(name: str) -> tuple[list[str], list[str]]:
        figure = geometry(*VEHICLES[name])
        legend = [text.get_text() for text in figure.legends[0].get_texts()]
        return [panel.get_title() for panel in figure.axes], legend

    titles, legend = words("omnimorph")
    assert titles == ["tilt 0°: under-actuated", "tilt 54.74°: omnidirectional"]
    assert {"axis of tilt", "edge of the cube", "lower layer", "turns clockwise, k = −1"} <= set(
        legend
    )
    titles, legend = words("quadrotor")
    assert titles == ["under-actuated"]
    assert "axis of tilt" not in legend
    assert "propeller" in legend
    assert "turns clockwise, k = −1" not in words("one rotor")[1]
