"""What stands in the scene of a page is the flight: poses, tilts, thrusts, ways, side by side."""

from __future__ import annotations

from collections.abc import Iterator
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
from omnimorph.viewer.vehicle_solid import reach_of

ROW = 11


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
    design = Design.of(OMNIMORPH, np.radians([40.0])).changed(mass=1.2 * OMNIMORPH.mass)
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
