"""Each part of a page, one by one: what a plot, a frame, a scene and a design are made of."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.unit.test_viewer_curves import FLIGHTS, OMNIMORPH, TURN

import omnimorph as om
from omnimorph.analysis.hover import hover_power
from omnimorph.model.dynamics import GRAVITY
from omnimorph.model.geometry import propeller_radius, thrust_axes
from omnimorph.results.record import COLUMN
from omnimorph.viewer import colours
from omnimorph.viewer.charts import _limits, _Plot, charts_of
from omnimorph.viewer.design import ATTITUDES, Design, scales_of
from omnimorph.viewer.design_scene import DesignScene
from omnimorph.viewer.explorer_page import _class_rows, _legend
from omnimorph.viewer.flight_page import FlightPage
from omnimorph.viewer.frames import Flight, blade_turns, can_be_shown
from omnimorph.viewer.stage import Actor, camera_for, set_stage
from omnimorph.viewer.vehicle_solid import reach_of

ROW, TILT = 11, np.radians([40.0])
QUADROTOR = om.load_vehicle("quadrotor")


def node(server: Any, name: str) -> Any:
    """Return a part of the scene by its name."""
    return server.scene._handle_from_node_name[name]


# --- plots ----------------------------------------------------------------------------------------


def test_a_plot_has_the_title_the_lines_and_the_limits_of_its_chart(server: Any) -> None:
    for chart in charts_of(FLIGHTS):
        handle = _Plot(server, chart)._handle
        assert handle.title == chart.title
        series = handle.series[1:]
        labels = [curve.label for curve in chart.curves]
        labels += [f"limit {limit:.4g}" for limit in chart.limits]
        assert [one["label"] for one in series] == [*labels, "now"]
        assert len(handle.data) == len(series) + 1
        for one, curve in zip(series, chart.curves, strict=False):
            assert {name: one[name] for name in curve.style} == curve.style


def test_the_key_of_a_chart_has_the_colours_of_its_curves() -> None:
    for chart in charts_of(FLIGHTS):
        key = dict(chart.key)
        for curve in chart.curves:
            flight, _, part = curve.label.partition(" ")
            word = part.removeprefix("rotor ") if part.startswith("rotor") else flight
            assert curve.style["stroke"] == colours.css(key[word]), (chart.title, curve.label)
            assert ("dash" in curve.style) == (flight == "b")
        assert ("dotted: limits" in key) == bool(chart.limits)
    alone = charts_of(FLIGHTS[:1])
    assert [chart.key for chart in alone[:2]] == [(), ()]
    strokes = [chart.curves[0].style["stroke"].upper() for chart in (alone[0], alone[-1])]
    assert strokes == [COLUMN["p_WB"].colour, COLUMN["drag_power"].colour]


def test_limits_in_plots_are_those_of_the_vehicle() -> None:
    def limits(vehicle: om.Vehicle) -> tuple[list[float], list[float]]:
        flight = Flight(FLIGHTS[0].run, "a")
        flight.vehicle = vehicle
        return _limits(flight, COLUMN["tilt_actual"]), _limits(flight, COLUMN["speed"])

    tilts, speeds = limits(OMNIMORPH.replace(servo_angle_min=np.radians([-20.0])))
    assert tilts == pytest.approx([-20.0, 60.0])
    assert limits(om.load_vehicle("voliro"))[0] == []  # ±172° would flatten the curve
    _, one_way = limits(QUADROTOR)
    expected = np.array([QUADROTOR.speed_min[0], QUADROTOR.speed_max[0]]) / TURN
    np.testing.assert_allclose(one_way, expected, atol=1e-6)
    assert len(speeds) == 2


# --- frames ---------------------------------------------------------------------------------------


def test_every_number_of_a_frame_is_that_of_the_row() -> None:
    for flight in FLIGHTS:
        frame, run = flight.frame(ROW), flight.run
        step = run.provenance.physics_step
        for value, column in (
            (frame.time, run.time),
            (frame.p_WB, run.p_WB),
            (frame.desired_p_WB, run.desired_p_WB),
            (frame.tilt, run.tilt_actual),
            (frame.speed, run.speed),
            (frame.thrust, run.thrust_actual),
            (frame.active, run.active),
            (frame.power, run.drag_power),
        ):
            np.testing.assert_array_equal(value, column[ROW])
        turned = blade_turns(flight.vehicle, run.speed[: ROW + 1], step).sum(axis=0)
        np.testing.assert_allclose(frame.turns, turned)
        for wxyz, R in ((frame.wxyz, run.R_WB), (frame.desired_wxyz, run.desired_R_WB)):
            shown = Rotation.from_quat(wxyz, scalar_first=True).as_matrix()
            np.testing.assert_allclose(shown, R[ROW], atol=1e-12)


@pytest.mark.parametrize("name", ["p_WB", "R_WB", "speed", "tilt_actual"])
def test_a_row_that_is_not_finite_or_out_of_sight_cannot_be_shown(name: str) -> None:
    columns = {key: value.copy() for key, value in vars(FLIGHTS[0].run).items()
               if isinstance(value, np.ndarray)}  # fmt: skip
    assert can_be_shown(columns, slice(None)).all()
    columns[name][ROW].flat[-1] = np.nan
    columns["p_WB"][ROW + 2, 1] = -2e6
    assert np.flatnonzero(~can_be_shown(columns, slice(None))).tolist() == [ROW, ROW + 2]
    assert np.flatnonzero(~can_be_shown(columns, slice(ROW, ROW + 2))).tolist() == [0]


def test_blades_are_slowed_down_by_the_faster_sense() -> None:
    backwards = OMNIMORPH.replace(speed_max=0.5 * OMNIMORPH.speed_max)
    turns = blade_turns(backwards, backwards.speed_min, 1.0)
    np.testing.assert_allclose(np.abs(turns), TURN)


# --- the scene of a flight ------------------------------------------------------------------------


def test_trail_and_path_are_the_whole_way(server: Any) -> None:
    run, frame = FLIGHTS[0].run, FLIGHTS[0].frame(ROW)
    ground, camera = set_stage(server, [run.p_WB], reach_of(OMNIMORPH))
    actor = Actor(server, "/one", OMNIMORPH, np.zeros(3), ground, run.p_WB)

    def drawn(way: Any) -> Any:
        return np.stack([way[:-1], way[1:]], axis=1)

    np.testing.assert_allclose(node(server, "/one/path").points, drawn(run.p_WB), rtol=1e-6)
    actor.show(frame, run.p_WB[3 : ROW + 1])
    np.testing.assert_allclose(actor._trail.points, drawn(run.p_WB[3 : ROW + 1]), rtol=1e-6)
    for row in (2, 5, 7):
        actor.show(FLIGHTS[0].frame(row))
    np.testing.assert_allclose(actor._trail.points, drawn(run.p_WB[[2, 5, 7]]), rtol=1e-6)
    np.testing.assert_allclose(node(server, "/ground").position, (0.0, 0.0, ground))
    np.testing.assert_allclose(server.initial_camera.position, camera[0])
    np.testing.assert_allclose(server.initial_camera.look_at, camera[1])


def test_the_ghost_stands_at_the_tilt_nearest_to_zero(server: Any) -> None:
    vehicle = OMNIMORPH.replace(servo_angle_min=np.radians([20.0]))
    Actor(server, "/one", vehicle, np.zeros(3), 0.0)
    discs = node(server, "/one/ghost/discs")
    axes = Rotation.from_quat(discs.batched_wxyzs, scalar_first=True).as_matrix()[:, :, 2]
    np.testing.assert_allclose(axes, thrust_axes(vehicle, np.radians([20.0])), atol=1e-6)
    np.testing.assert_allclose(discs.batched_positions, vehicle.rotor_position, atol=1e-7)


def test_an_arrow_is_as_long_as_its_thrust(server: Any) -> None:
    """One and a half propeller radii for the share of the weight."""
    actor = Actor(server, "/one", OMNIMORPH, np.zeros(3), 0.0)
    frame = FLIGHTS[0].frame(ROW)
    actor.show(frame)
    begin, tip = np.moveaxis(np.asarray(actor.solid._arrows.points, dtype=np.float64), 1, 0)
    usual = OMNIMORPH.mass * GRAVITY / 8
    length = 1.5 * propeller_radius(OMNIMORPH) * np.abs(frame.thrust) / usual
    np.testing.assert_allclose(np.linalg.norm(tip - begin, axis=1), length, rtol=1e-3)


def test_a_page_begins_at_rest_with_all_of_it_shown(server: Any) -> None:
    page = FlightPage(server, FLIGHTS)
    found = {one.label: one.value for one in server.gui._gui_input_handle_from_uuid.values()}
    assert found == {
        "Play": False,
        "time, s": 0.0,
        "speed": "1 ×",
        "camera": "free",
        "desired pose": True,
        "thrusts": True,
        "trail": True,
    }
    assert (page.playback.is_playing, page.playback.speed, page.playback.time) == (False, 1.0, 0.0)


def test_what_the_camera_is_for_fills_the_view() -> None:
    middle = np.array([1.0, 2.0, 3.0])
    for reach in (0.5, 2.0):
        position, looks_at = camera_for(middle, reach)
        np.testing.assert_array_equal(looks_at, middle)
        seen = np.arcsin(reach / np.linalg.norm(position - middle))
        assert seen == pytest.approx(np.arcsin(np.sin(np.radians(25.0)) / 1.2))
        assert position[2] > middle[2]


# --- designs --------------------------------------------------------------------------------------


@pytest.mark.parametrize("base", [OMNIMORPH, QUADROTOR], ids=["both ways", "one way"])
def test_sliders_change_what_they_should_and_nothing_else(base: om.Vehicle) -> None:
    design = Design.of(base).changed(mass=2.0 * base.mass, speed=1.5, size=3.0)
    vehicle = design.vehicle()
    expected: dict[str, Any] = {
        "mass": 2.0 * base.mass,
        "tilt_mechanism_mass": 2.0 * base.tilt_mechanism_mass,
        "inertia": 2.0 * 9.0 * base.inertia,
        "rotor_position": 3.0 * base.rotor_position,
        "speed_max": 1.5 * base.speed_max,
        "speed_min": np.where(base.speed_min < 0.0, 1.5, 1.0) * base.speed_min,
    }
    for name in ("thrust_coefficient", "drag_coefficient", "rotor_axis", "spin_inertia"):
        expected[name] = getattr(base, name)
    for name, value in expected.items():
        np.testing.assert_allclose(getattr(vehicle, name), value, err_msg=name)
    if not base.n_servos:  # over all tilts takes longer
        power = om.analysis.platform(vehicle).hover_power_per_kg
        assert design.view().platform.hover_power_per_kg == power


def test_the_four_pictures_stand_where_their_words_are(server: Any) -> None:
    view = Design.of(OMNIMORPH, TILT).view()
    scene = DesignScene(server, view, scales_of(OMNIMORPH))
    vehicle, forces, moments, hover = (
        np.asarray(caption.position) - (0.0, 0.0, 1.22) for caption in scene._captions
    )
    for part in (scene._forces._mesh, scene._forces._edges, scene._weight, scene._inside):
        np.testing.assert_allclose(part.position, forces)
    for part in (scene._moments._mesh, scene._moments._edges, node(server, "/axes-moments")):
        np.testing.assert_allclose(part.position, moments)
    np.testing.assert_allclose(scene._solid.root.position, vehicle)
    np.testing.assert_allclose(node(server, "/axes-hover").position, hover)
    np.testing.assert_allclose(node(server, "/axes-forces").position, forces)
    tiles = scene._tiles.batched_positions - hover
    np.testing.assert_allclose(tiles, 0.9 * ATTITUDES, atol=1e-6)
    up = Rotation.from_quat(scene._tiles.batched_wxyzs, scalar_first=True).as_matrix()[:, :, 2]
    np.testing.assert_allclose(up, ATTITUDES, atol=1e-6)
    begin, tip = np.asarray(scene._witness.points, dtype=np.float64)[0]
    np.testing.assert_allclose(begin, forces, atol=1e-6)
    towards = (tip - begin) / np.linalg.norm(tip - begin)
    assert view.forces.reach(towards) == pytest.approx(view.forces.inscribed_radius, rel=1e-4)
    hubs = 0.72 * OMNIMORPH.rotor_position / np.linalg.norm(OMNIMORPH.rotor_position, axis=1).max()
    np.testing.assert_allclose(scene._solid._discs.batched_positions, hubs, atol=1e-6)


def test_attitudes_of_the_sphere_begin_level_and_cover_it() -> None:
    np.testing.assert_array_equal(ATTITUDES[:2], [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)])
    np.testing.assert_allclose(np.linalg.norm(ATTITUDES, axis=1), 1.0)
    np.testing.assert_allclose(ATTITUDES.mean(axis=0), 0.0, atol=0.01)
    level = hover_power(OMNIMORPH, TILT, ATTITUDES)[0]
    assert level == pytest.approx(om.analysis.hover(OMNIMORPH, TILT).power)


def test_the_class_is_that_of_all_tilts_and_of_this_one() -> None:
    view = Design.of(OMNIMORPH, np.radians([0.0])).view()
    reported = [(row.key, row.values) for row in _class_rows(view)]
    everywhere, here = str(view.platform.vehicle_class), str(view.actuation.vehicle_class)
    assert everywhere != here
    assert reported == [("class", [everywhere]), ("kind", [here])]
    many = _class_rows(view._replace(platform=replace(view.platform, n_servos=4)))
    numbers = (view.platform.radius_over_weight, view.platform.lateral_over_weight)
    assert [row.values[0] for row in many] == [everywhere, *(f"{n:.3g}" for n in numbers), here]
    (only,) = _class_rows(view._replace(platform=replace(view.platform, n_servos=0)))
    assert (only.label, only.values) == ("class", [here])


def test_a_legend_says_what_grey_means_only_where_there_is_some() -> None:
    assert "grey" not in _legend(100.0, 200.0, some_cannot=False)
    some = _legend(100.0, 200.0, some_cannot=True)
    assert "grey: it cannot hover there" in some
    assert some.index("100 W") < some.index("200 W")
    none = _legend(0.0, 0.0, some_cannot=True)
    assert "it hovers in no attitude" in none
    assert "0 W" not in none


def test_colours_of_instances_are_linear_in_the_light() -> None:
    """As the standard of sRGB has it: a middle grey of 188 is half of the light."""
    np.testing.assert_array_equal(colours.of_instances([(0, 188, 255)]), [(0, 128, 255)])
    np.testing.assert_array_equal(colours.of_instances((10, 10, 10), 2), np.full((2, 3), 1))
    quarter, full = colours.of_thrust([0.25, 1.0]).astype(float)
    rest = colours.of_thrust([0.0]).astype(float)[0]
    np.testing.assert_allclose(quarter, 0.5 * (rest + full), atol=1.0)
