"""What stands in the scene of a page is the flight: poses, tilts, thrusts, ways, side by side."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.unit.test_viewer_curves import FLIGHTS, OMNIMORPH

import omnimorph as om
from omnimorph.analysis.hover import hover_power
from omnimorph.model.dynamics import GRAVITY
from omnimorph.model.geometry import thrust_axes
from omnimorph.viewer import colours
from omnimorph.viewer.design import ATTITUDES, Design, scales_of
from omnimorph.viewer.design_scene import DesignScene
from omnimorph.viewer.flight_page import FlightPage, FlightScene
from omnimorph.viewer.server import new_server, stop
from omnimorph.viewer.stage import FIELD_OF_VIEW
from omnimorph.viewer.vehicle_solid import VehicleSolid, reach_of

ROW, TILT = 11, np.radians([40.0])


@pytest.fixture(scope="module")
def server() -> Iterator[Any]:
    started = new_server()
    yield started
    stop(started)


@pytest.fixture(scope="module")
def scene(server: Any) -> FlightScene:
    scene = FlightScene(server, FLIGHTS)
    scene.show(FLIGHTS[0].run.time[ROW])
    return scene


def test_flights_stand_side_by_side(scene: FlightScene) -> None:
    first, second = (actor.beside for actor in scene.actors)
    np.testing.assert_array_equal(first, 0.0)
    assert second[0] > 2.0 * reach_of(OMNIMORPH)
    np.testing.assert_array_equal(second[1:], 0.0)
    frames = [flight.frame(ROW) for flight in FLIGHTS]
    for actor, frame in zip(scene.actors, frames, strict=True):
        np.testing.assert_allclose(actor.middle(frame), actor.beside + frame.p_WB)
    camera, looks_at = scene.close_up(frames)
    middles = [a.middle(f) for a, f in zip(scene.actors, frames, strict=True)]
    np.testing.assert_allclose(looks_at, np.mean(middles, axis=0))
    assert np.linalg.norm(camera - looks_at) > np.linalg.norm(second)


def test_poses_are_those_of_the_row(scene: FlightScene) -> None:
    for actor, flight in zip(scene.actors, FLIGHTS, strict=True):
        run = flight.run
        for root, p, R in (
            (actor.solid.root, run.p_WB[ROW], run.R_WB[ROW]),
            (actor.ghost.root, run.desired_p_WB[ROW], run.desired_R_WB[ROW]),
        ):
            np.testing.assert_allclose(root.position, p, rtol=1e-6)
            shown = Rotation.from_quat(root.wxyz, scalar_first=True).as_matrix()
            np.testing.assert_allclose(shown, R, atol=1e-6)


def test_rotors_are_tilted_and_their_thrusts_are_arrows(scene: FlightScene) -> None:
    for actor, flight in zip(scene.actors, FLIGHTS, strict=True):
        run, solid = flight.run, actor.solid
        axes = thrust_axes(OMNIMORPH, flight.frame(ROW).tilt)
        discs = Rotation.from_quat(solid._discs.batched_wxyzs, scalar_first=True).as_matrix()
        np.testing.assert_allclose(discs[:, :, 2], axes, atol=1e-6)
        thrust = run.thrust_actual[ROW]
        begin, tip = np.moveaxis(np.asarray(solid._arrows.points, dtype=np.float64), 1, 0)
        np.testing.assert_allclose(begin, OMNIMORPH.rotor_position, atol=1e-6)
        along = np.sum((tip - begin) * axes, axis=1)
        np.testing.assert_allclose(along / along[0], thrust / thrust[0], rtol=1e-3, atol=1e-5)
        assert along[0] * thrust[0] > 0.0
        at_limit = np.asarray(solid._rims.batched_scales) > 0.5
        np.testing.assert_array_equal(at_limit, run.active[ROW] != 0)


def test_the_missed_force_is_an_arrow_from_the_vehicle(scene: FlightScene) -> None:
    for actor, flight in zip(scene.actors, FLIGHTS, strict=True):
        frame = flight.frame(ROW)
        begin, tip = np.asarray(actor._missed.points, dtype=np.float64)[0]
        np.testing.assert_allclose(begin, frame.p_WB, rtol=1e-5)
        length = 2.0 * reach_of(OMNIMORPH) / (OMNIMORPH.mass * GRAVITY)
        np.testing.assert_allclose(tip - begin, length * frame.missed_W, atol=1e-5)


def test_the_trail_is_the_way_so_far(scene: FlightScene) -> None:
    for actor, flight in zip(scene.actors, FLIGHTS, strict=True):
        segments = np.asarray(actor._trail.points)
        way = flight.run.p_WB[: ROW + 1]
        np.testing.assert_allclose(segments[0, 0], way[0], rtol=1e-5)
        np.testing.assert_allclose(segments[-1, 1], way[-1], rtol=1e-5)
        np.testing.assert_array_equal(flight.path, flight.run.p_WB)


def test_what_goes_with_a_vehicle_in_the_scene(scene: FlightScene) -> None:
    """Its shadow below it, its name above it, the ghost only where it can be distinguished."""
    ground = min(0.0, min(f.run.p_WB[:, 2].min() for f in FLIGHTS) - 1.5 * reach_of(OMNIMORPH))
    for actor, flight in zip(scene.actors, FLIGHTS, strict=True):
        frame = flight.frame(ROW)
        x, y, _ = frame.p_WB
        np.testing.assert_allclose(actor._spot.position, (x, y, ground), atol=3e-3)
        assert actor._label is not None
        assert actor._label.text == flight.name
        above = np.asarray(actor._label.position) - frame.p_WB
        np.testing.assert_allclose(above[:2], 0.0, atol=1e-12)
        assert above[2] > reach_of(OMNIMORPH)
        assert actor.ghost.root.visible
        actor.show(frame._replace(position_error_mm=0.0, attitude_error_deg=0.5))
        assert not actor.ghost.root.visible
        weight = OMNIMORPH.mass * GRAVITY
        for share, shown in ((0.19, False), (0.21, True)):
            actor.show(frame._replace(missed_W=np.array([0.0, share * weight, 0.0])))
            assert actor._missed.visible == shown
        actor.show(frame)


def test_a_camera_sees_all_of_what_it_is_for(scene: FlightScene) -> None:
    """Every point of the flights lies within half the field of view; nothing is far too small."""
    position, looks_at = scene.camera
    ahead = (looks_at - position) / np.linalg.norm(looks_at - position)
    points = np.vstack([actor.beside + flight.run.p_WB
                        for actor, flight in zip(scene.actors, FLIGHTS, strict=True)])  # fmt: skip
    away = (points - position) / np.linalg.norm(points - position, axis=1)[:, None]
    angles = np.arccos(away @ ahead)
    assert 0.2 * FIELD_OF_VIEW < angles.max() < 0.5 * FIELD_OF_VIEW
    np.testing.assert_allclose(looks_at, 0.5 * (points.min(axis=0) + points.max(axis=0)))


def test_a_page_shows_the_moment_it_is_moved_to(server: Any) -> None:
    page = FlightPage(server, FLIGHTS)
    page.playback.move_to(float(FLIGHTS[0].run.time[ROW]))
    page._show()
    for k, flight in enumerate(FLIGHTS):
        power = f"{flight.run.drag_power[ROW]:.1f}"
        key = "power" + (f"-{k + 1}" if k else "")
        assert f'<td id="{key}"' in page._numbers.content
        cell = page._numbers.content.split(f'<td id="{key}"')[1].split("</td>")[0]
        assert cell.split(">")[1] == power
    assert page._slider.value == pytest.approx(FLIGHTS[0].run.time[ROW])


def test_a_vehicle_of_one_servo_is_explored_where_its_radius_is_largest() -> None:
    best = om.analysis.tilt_of_largest_radius(OMNIMORPH)
    np.testing.assert_array_equal(Design.of(OMNIMORPH).tilt, [best])


def test_what_the_explorer_shows_is_the_design(server: Any) -> None:
    design = Design.of(OMNIMORPH, TILT).changed(mass=1.2 * OMNIMORPH.mass)
    scales, view = scales_of(OMNIMORPH), design.view()
    scene = DesignScene(server, view, scales)
    forces = om.analysis.force_set(view.vehicle, view.tilt, zero_moment=True)
    moments = om.analysis.moment_set(view.vehicle, view.tilt)
    weight = 1.2 * OMNIMORPH.mass * GRAVITY
    assert scene._weight.scale == pytest.approx(weight / scales.force)
    assert scene._inside.scale == pytest.approx(forces.inscribed_radius / scales.force)
    begin, tip = np.asarray(scene._witness.points, dtype=np.float64)[0]
    assert np.linalg.norm(tip - begin) == pytest.approx(scene._inside.scale, rel=1e-4)
    vehicle, spheres, torques, _ = (caption.text for caption in scene._captions)
    assert "tilt 40.0°" in vehicle
    assert spheres == f"forces: inscribed sphere {forces.inscribed_radius:.4g} N"
    assert torques == f"moments: inscribed sphere {moments.inscribed_radius:.4g} N m"
    power = hover_power(view.vehicle, view.tilt, ATTITUDES)
    shades = np.asarray(scene._tiles.batched_colors)
    finite = np.isfinite(power)
    least, most = power[finite].min(), power[finite].max()
    expected = colours.of_instances(colours.of_power((power - least) / (most - least)))
    np.testing.assert_array_equal(shades, expected)


# --- parts of a scene -----------------------------------------------------------------------------


def test_a_rotor_has_the_colour_of_its_share_and_its_blades_turn_about_its_axis(
    server: Any,
) -> None:
    """The share is that of the limit in its sense; here backwards is the weaker one."""
    vehicle = OMNIMORPH.replace(speed_min=0.5 * OMNIMORPH.speed_min)
    solid = VehicleSolid(server, "/alone", vehicle)
    share = np.array([1.0, 0.4, 0.1, 0.0, -0.1, -0.4, -0.8, -1.0])
    thrust = np.where(share >= 0.0, share * vehicle.thrust_max, -share * vehicle.thrust_min)
    turns = np.linspace(0.0, 3.0, 8)
    solid.show(np.array([0.7]), thrust, turns, np.zeros(8))
    shades = colours.of_instances(colours.of_thrust(share))
    np.testing.assert_array_equal(solid._discs.batched_colors, shades)
    along = np.where((share < 0.0)[:, None], np.array(colours.VERMILLION), np.array(colours.BLUE))
    np.testing.assert_array_equal(solid._arrows.colors, colours.of_instances(along))
    discs, blades, rims = (
        Rotation.from_quat(part.batched_wxyzs, scalar_first=True)
        for part in (solid._discs, solid._blades, solid._rims)
    )
    axes = thrust_axes(vehicle, np.array([0.7]))
    turned = (blades * discs.inv()).as_rotvec()
    np.testing.assert_allclose(turned, turns[:, None] * axes, atol=1e-6)
    np.testing.assert_allclose(rims.as_quat(), discs.as_quat())
    for part in (solid._discs, solid._blades, solid._rims):
        np.testing.assert_allclose(part.batched_positions, vehicle.rotor_position, atol=1e-7)


@pytest.mark.parametrize("tilt", [0.0, 0.7])
def test_sets_are_drawn_to_scale_with_their_edges(server: Any, tilt: float) -> None:
    view = Design.of(OMNIMORPH, np.array([tilt])).view()
    scales = scales_of(OMNIMORPH)
    scene = DesignScene(server, view, scales)
    shown = ((scene._forces, view.forces, scales.force), (scene._moments, view.moments,
             scales.moment))  # fmt: skip
    for solid, polytope, unit in shown:
        assert solid._mesh.visible
        assert solid._edges.visible
        corners = polytope.vertices
        ends = unit * np.asarray(solid._edges.points, dtype=np.float64)
        middle = ends.mean(axis=1)
        if polytope.dimension == 3:  # Euler: V − E + F = 2
            assert len(ends) == len(corners) + len(polytope.facets) - 2
            slack = polytope.offsets - middle @ polytope.normals.T
            assert ((slack < 1e-4 * unit).sum(axis=1) >= 2).all()
            np.testing.assert_allclose(unit * solid._mesh.vertices, corners, atol=1e-5 * unit)
        gaps = np.linalg.norm(corners[:, None, None] - ends, axis=-1).min(axis=0)
        assert gaps.max() < 1e-5 * unit


def test_rotors_at_a_limit_of_level_hover_have_a_rim(server: Any) -> None:
    view = Design.of(OMNIMORPH, TILT).view()
    scene = DesignScene(server, view, scales_of(OMNIMORPH))
    share = np.array([1.0, 0.99, 0.5, 0.0, -0.5, -0.99, -1.0, 1.0])
    thrust = np.where(share > 0.0, share * OMNIMORPH.thrust_max, -share * OMNIMORPH.thrust_min)
    for feasible in (True, False):
        scene.show(view._replace(level=replace(view.level, thrust=thrust, feasible=feasible)))
        rims = np.asarray(scene._solid._rims.batched_scales) > 0.5
        np.testing.assert_array_equal(rims, (np.abs(share) == 1.0) & feasible)


def test_a_vehicle_is_drawn_to_the_scale_of_its_largest_sets() -> None:
    """Nothing that it makes at any tilt is drawn longer than one unit, and something nearly is."""
    scales, tilts = scales_of(OMNIMORPH), np.radians([0.0, 13.0, 30.0, 47.0, 60.0])
    farthest = [
        max(
            float(np.linalg.norm(polytope.vertices, axis=1).max())
            for polytope in (make(OMNIMORPH, np.array([tilt])) for tilt in tilts)
        )
        for make in (partial(om.analysis.force_set, zero_moment=True), om.analysis.moment_set)
    ]
    np.testing.assert_allclose([scales.force, scales.moment], farthest, rtol=0.02)
    assert scales.length == np.linalg.norm(OMNIMORPH.rotor_position, axis=1).max()


def test_a_set_that_becomes_empty_is_no_longer_shown(server: Any) -> None:
    view, uneven = Design.of(OMNIMORPH, TILT).view(), np.radians([10.0, 20.0, 30.0, 40.0])
    scene = DesignScene(server, view, scales_of(OMNIMORPH))
    parts = (scene._forces._mesh, scene._forces._edges, scene._inside, scene._witness)
    assert [part.visible for part in parts] == [True] * 4
    empty = om.analysis.force_set(om.load_vehicle("tilting-quad"), uneven, zero_moment=True)
    assert empty.is_empty
    scene.show(view._replace(forces=empty, sphere=None))
    assert [part.visible for part in parts] == [False] * 4
    assert scene._captions[1].text == "forces: inscribed sphere 0 N"
    scene.show(view)
    assert [part.visible for part in parts] == [True] * 4
