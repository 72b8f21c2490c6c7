"""What the pages show, without a browser: frames, plots, designs, pictures, and what is refused."""

from __future__ import annotations

import socket
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import omnimorph as om
from omnimorph.errors import InputError, VehicleError
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.thinning import envelope
from omnimorph.viewer import colours
from omnimorph.viewer.charts import PIECES, _on_common_times, charts_of
from omnimorph.viewer.design import ATTITUDES, Design, is_cube, scales_of
from omnimorph.viewer.explorer_page import numbers_of as numbers_of_design
from omnimorph.viewer.flight_page import _trail, notices, numbers_of
from omnimorph.viewer.frames import Flight, Playback, blade_turns
from omnimorph.viewer.pictures import _looking, browser, check_format, save_picture, save_video
from omnimorph.viewer.server import check_port, is_loopback

OMNIMORPH = om.load_vehicle("omnimorph")


@pytest.fixture(scope="module")
def flight() -> Flight:
    return Flight(om.fly(om.load_scenario("hover"), seed=1), "hover")


# --- flights ------------------------------------------------------------------------------------


def test_a_frame_is_the_row_of_the_run(flight: Flight) -> None:
    row = flight.row_at(0.7304)
    frame, run = flight.frame(row), flight.run
    assert frame.time == run.time[row] == pytest.approx(0.730)
    np.testing.assert_array_equal(frame.p_WB, run.p_WB[row])
    w, x, y, z = frame.wxyz
    up = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
    np.testing.assert_allclose(up, run.R_WB[row, :, 2], atol=1e-12)
    missed = run.R_WB[row] @ (run.wrench_asked[row, :3] - run.wrench_achieved[row, :3])
    np.testing.assert_allclose(frame.missed_W, missed)
    assert frame.position_error_mm == pytest.approx(flight.position_error_mm[row])
    assert frame.attitude_error_deg == pytest.approx(flight.attitude_error_deg[row])


def test_a_flight_that_diverged_is_shown_until_then(flight: Flight) -> None:
    broken = flight.run.p_WB.copy()
    broken[900:] = np.nan
    diverged = replace(flight.run, p_WB=broken)
    shown = Flight(diverged, "diverged")
    assert shown.row_at(1e9) == len(shown.run.time) - 1 == 899
    assert shown.duration == shown.run.time[-1]
    assert np.isfinite(shown.path).all()
    assert np.isfinite(shown.frame(899).wxyz).all()
    with pytest.raises(InputError, match="no moment of the run can be shown"):
        Flight(replace(flight.run, p_WB=np.full_like(broken, np.nan)), "nothing")


def test_times_outside_the_flight_are_its_ends(flight: Flight) -> None:
    assert flight.row_at(-1.0) == 0
    assert flight.row_at(1e9) == len(flight.run.time) - 1


def test_a_trail_is_the_way_of_the_last_seconds(flight: Flight) -> None:
    run = flight.run
    for row, first in ((4500, 1500), (2000, 0)):
        way = _trail(flight, row)
        assert 30 < len(way) <= 60
        np.testing.assert_array_equal(way[0], run.p_WB[first])
        np.testing.assert_array_equal(way[-1], run.p_WB[row])


def test_blades_turn_in_the_sense_of_the_rotor_and_no_faster_than_once_a_second() -> None:
    speed = np.where(np.arange(8) % 2, 1.0, -1.0) * OMNIMORPH.speed_max
    turns = blade_turns(OMNIMORPH, speed, 1.0)
    np.testing.assert_allclose(turns, 2 * np.pi * OMNIMORPH.rotor_spin * np.sign(speed))


def test_numbers_are_exact_to_their_last_digit(flight: Flight) -> None:
    frame = flight.frame(500)
    reported = {row.key: row.values[0] for row in numbers_of([flight], [frame])}
    assert reported["time"] == "0.500"
    assert reported["tilt"] == f"{np.degrees(flight.run.tilt_actual[500, 0]):.2f}"
    assert reported["power"] == f"{flight.run.drag_power[500]:.1f}"


def test_saturated_rotors_and_missed_force_are_reported(flight: Flight) -> None:
    calm = flight.frame(500)._replace(active=np.zeros(8), missed_W=np.zeros(3))
    assert "limit" not in notices([flight], [calm])
    assert "not achieved" not in notices([flight], [calm])
    busy = calm._replace(active=np.array([0, 0, 1, 0, -1, 0, 0, 0.0]), missed_W=2.0 * np.ones(3))
    said = notices([flight], [busy])
    assert "rotor 2, 4" in said
    assert "force not achieved: 3.46 N" in said
    assert flight.run.outcome_sentence not in said
    assert "hover: " not in said
    last = flight.frame(len(flight.run.time) - 1)
    assert flight.run.outcome_sentence in notices([flight], [last])
    assert flight.run.outcome_sentence not in notices([flight], [last], False)
    assert flight.run.outcome_sentence in notices([flight], [calm], True)
    of_two = notices([flight, Flight(flight.run, "b")], [calm, busy]).split(">", 1)[1]
    assert of_two.startswith("b: at the limit: rotor 2, 4<br>b: force")


def test_playback_stops_at_the_end_and_starts_again() -> None:
    playback = Playback(1.0)
    playback.advance(5.0)
    assert playback.time == 0.0, "it does not play yet"
    playback.play()
    playback.speed = 2.0
    playback.advance(0.25)
    assert playback.time == 0.5
    playback.advance(5.0)
    assert (playback.time, playback.is_playing) == (1.0, False)
    playback.play()
    assert playback.time == 0.0
    playback.move_to(-3.0)
    assert playback.time == 0.0


# --- plots --------------------------------------------------------------------------------------


def test_an_envelope_keeps_every_extreme() -> None:
    rng = np.random.default_rng(0)
    time, values = np.linspace(0.0, 9.999, 10_000), rng.normal(size=(3, 10_000))
    t, v = envelope(time, values, 100)
    assert v.shape == (3, len(t))
    assert len(t) <= 200
    assert (np.diff(t) > 0).all()
    np.testing.assert_array_equal(v.max(axis=1), values.max(axis=1))
    np.testing.assert_array_equal(v.min(axis=1), values.min(axis=1))


def test_plots_show_errors_tilt_speeds_with_limits_and_power(flight: Flight) -> None:
    charts = charts_of([flight])
    titles = [chart.title for chart in charts]
    assert titles[:2] == ["position error, mm", "attitude error, °"]
    speeds = next(chart for chart in charts if chart.title.startswith("rotor speeds"))
    assert len(speeds.curves) == 8
    fastest = OMNIMORPH.speed_max[0] / (2 * np.pi)
    np.testing.assert_allclose(speeds.limits, [-fastest, fastest])
    assert charts[-1].title == "rotor drag power, W"
    assert PIECES > 0


def test_two_flights_share_their_plots(flight: Flight) -> None:
    other = Flight(om.fly(om.load_scenario("tour").for_vehicle(om.load_vehicle("tilt-hex"))), "b")
    charts = charts_of([flight, other])
    assert [len(chart.curves) for chart in charts] == [2, 2, 1, 8 + 6, 2]
    speeds = [word for word, _ in charts[3].key]
    assert speeds == [*"01234567", f"solid: {flight.name}", "dashed: b", "dotted: limits"]


def test_colours_of_several_servos_mean_the_same_in_both_flights() -> None:
    """A colour is a servo, whichever flight; whose it is, the line says."""
    scenario = om.load_scenario("tour").for_vehicle(om.load_vehicle("tilting-quad"))
    reference = SegmentReference((0, 0, 0), np.eye(3), [Segment(0.1)])
    run = om.fly(replace(scenario, reference=reference))
    tilts = charts_of([Flight(run, "a"), Flight(run, "b")])[2]
    key = dict(tilts.key)
    for curve in tilts.curves:
        servo = curve.label.split(" ", 1)[1]
        assert curve.style["stroke"] == colours.css(key[servo])
        assert ("dash" in curve.style) == curve.label.startswith("b")
    assert {"solid: a", "dashed: b"} <= key.keys()


def test_flights_with_other_steps_and_ends_are_drawn_at_their_own_times(flight: Flight) -> None:
    """As many rows, but twice as long: each curve is where its own time is, to its own end."""
    slow = replace(flight.run, time=2.0 * flight.run.time)
    power = charts_of([flight, Flight(slow, "slow")])[-1]
    time, (short, long) = _on_common_times(power)
    end = flight.run.time[-1]
    assert time[-1] > 1.9 * end
    assert np.isnan(short[time > 1.05 * end]).all()
    assert np.isfinite(long).all()
    at_half = np.interp(end, time, long)
    nearby = np.abs(slow.time - end) < 0.05 * end
    assert slow.drag_power[nearby].min() <= at_half <= slow.drag_power[nearby].max()


# --- designs ------------------------------------------------------------------------------------


def test_a_design_left_alone_is_the_vehicle() -> None:
    assert Design.of(OMNIMORPH).vehicle().mass == OMNIMORPH.mass
    np.testing.assert_array_equal(Design.of(OMNIMORPH).vehicle().inertia, OMNIMORPH.inertia)


def test_sliders_scale_as_physics_does() -> None:
    base = Design.of(OMNIMORPH, np.array([0.8]))
    radius = base.view().forces.inscribed_radius
    faster = base.changed(speed=1.2).view()
    assert faster.forces.inscribed_radius == pytest.approx(1.44 * radius)
    larger = base.changed(size=2.0).view()
    assert larger.forces.inscribed_radius > 0.0
    np.testing.assert_allclose(larger.vehicle.inertia, 4.0 * OMNIMORPH.inertia)
    heavier = base.changed(mass=2.0 * OMNIMORPH.mass).view()
    assert heavier.weight == pytest.approx(2.0 * base.view().weight)
    assert heavier.level.power == pytest.approx(2.0**1.5 * base.view().level.power, rel=1e-6)


def test_numbers_of_a_design_are_those_of_the_analysis() -> None:
    tilt = np.radians([50.0])
    reported = {
        row.key: row.values[0] for row in numbers_of_design(Design.of(OMNIMORPH, tilt).view())
    }
    forces = om.analysis.force_set(OMNIMORPH, tilt, zero_moment=True)
    assert reported["force-radius"] == f"{forces.inscribed_radius:.4g}"
    assert reported["hover-power"] == f"{om.analysis.hover(OMNIMORPH, tilt).power:.4g}"
    assert reported["rank"] == "6"
    assert reported["hovers"] == "all"
    # by symmetry several directions are as weak: the number beside the one shown
    normals, offsets = forces.normals, forces.offsets
    weakest = normals[offsets < forces.inscribed_radius * (1.0 + 1e-6)]
    shown, count = reported["weakest"].split("; one of ")
    assert int(count) == len(weakest) > 1
    assert np.abs(weakest - np.array(shown.split(", "), float)).max(axis=1).min() < 0.006


def test_the_sphere_says_where_it_can_hover() -> None:
    quadrotor = Design.of(om.load_vehicle("quadrotor")).view()
    finite = np.isfinite(quadrotor.power)
    assert not finite.any() or ATTITUDES[finite][:, 2].min() > 0.99, "level only"
    everywhere = Design.of(OMNIMORPH, np.radians([55.0])).view()
    assert np.isfinite(everywhere.power).all()


def test_only_a_cube_has_a_half_edge() -> None:
    assert is_cube(OMNIMORPH)
    assert not is_cube(om.load_vehicle("tilt-hex"))


def test_a_vehicle_that_makes_no_force_is_refused() -> None:
    one = om.load_vehicle("quadrotor")
    single = {
        name: getattr(one, name)[:1]
        for name in (
            *("rotor_position", "rotor_axis", "hinge_axis", "rotor_servo", "rotor_spin"),
            *("thrust_coefficient", "drag_coefficient", "speed_min", "speed_max", "dead_band"),
            *("time_constant_up", "time_constant_down", "spin_inertia"),
        )
    }
    lever = one.replace(**single, name="lever", sources={})
    with pytest.raises(VehicleError, match=r"vehicle lever: its rotors make no force"):
        scales_of(lever)


# --- colours ------------------------------------------------------------------------------------


def test_reversed_thrust_has_another_colour() -> None:
    forwards, nothing, backwards = colours.of_thrust([1.0, 0.0, -1.0])
    assert tuple(forwards) == colours.BLUE
    assert tuple(backwards) == colours.VERMILLION
    assert nothing.min() > 200


def test_more_power_is_lighter_and_none_is_grey() -> None:
    seen = colours.of_power([0.0, 0.25, 0.5, 0.75, 1.0, np.inf]).astype(float)
    luminance = seen @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(luminance[:5]) > 0).all()
    assert np.ptp(seen[5]) < 10


# --- servers and pictures -----------------------------------------------------------------------


def test_a_port_in_use_is_refused_and_a_free_one_found() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"port {port} is in use; name another with --port"):
            check_port("127.0.0.1", port)
    assert check_port("127.0.0.1", 0) > 0


def test_an_address_elsewhere_is_refused() -> None:
    for host in ("192.0.2.1", "", "a..b", "no such host"):
        with pytest.raises(InputError, match="--host"):
            check_port(host, 0)


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.9.10", "localhost", "LocalHost", "::1"])
def test_loopback_is_known(host: str) -> None:
    assert is_loopback(host)


@pytest.mark.parametrize(
    "host",
    [
        "0.0.0.0",
        "192.0.2.1",
        "127.evil.example",
        "127.0.0.1.evil.example",
        "localhost.evil.example",
    ],
)
def test_what_only_begins_like_loopback_is_none(host: str) -> None:
    assert not is_loopback(host)


def test_no_browser_is_reported_with_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("OMNIMORPH_BROWSER", raising=False)
    with pytest.raises(InputError, match="install Chromium or Chrome"):
        browser()
    monkeypatch.setenv("OMNIMORPH_BROWSER", "no-such-browser")
    with pytest.raises(InputError, match="OMNIMORPH_BROWSER"):
        browser()


def test_an_ending_that_cannot_be_written_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match=r"\.gif, \.webp, \.mp4"):
        check_format("--video", Path("flight.avi"), (".gif", ".webp", ".mp4"))
    monkeypatch.setenv("PATH", "")
    with pytest.raises(InputError, match="ffmpeg must be installed"):
        check_format("--video", Path("flight.mp4"), (".gif", ".webp", ".mp4"))


def test_a_camera_looks_ahead_and_stands_upright() -> None:
    """Its z goes to what it looks at, its x is level to the right, its y downwards."""
    position, at = np.array([1.0, -3.0, 2.0]), np.array([0.5, 1.0, 0.0])
    w, *xyz = _looking(position, at)
    x, y, z = Rotation.from_quat([*xyz, w]).as_matrix().T
    np.testing.assert_allclose(z, (at - position) / np.linalg.norm(at - position))
    assert x[2] == pytest.approx(0.0)
    assert y[2] < 0.0
    np.testing.assert_allclose(np.cross(x, y), z)


@pytest.mark.parametrize("ending", ["png", "jpg", "webp"])
def test_pictures_are_written_in_their_format(ending: str, tmp_path: Path) -> None:
    from PIL import Image

    pixels = np.full((48, 64, 3), (0, 114, 178), dtype=np.uint8)
    save_picture(tmp_path / f"t.{ending}", pixels)
    back = np.asarray(Image.open(tmp_path / f"t.{ending}").convert("RGB")).astype(int)
    assert back.shape == (48, 64, 3)
    assert np.abs(back - pixels).max() <= 6


@pytest.mark.parametrize("ending", ["gif", "webp"])
def test_videos_have_their_pictures(ending: str, tmp_path: Path) -> None:
    from PIL import Image

    moving = [np.full((30, 40, 3), 20 * k, dtype=np.uint8) for k in range(5)]
    save_video(tmp_path / f"t.{ending}", moving, 20.0)
    with Image.open(tmp_path / f"t.{ending}") as video:
        assert getattr(video, "n_frames", 1) == 5
        assert video.size == (40, 30)
        if ending == "gif":
            assert video.info["duration"] == 50


@pytest.mark.slow
def test_a_video_by_ffmpeg_plays_as_long_as_it_should(tmp_path: Path) -> None:
    moving = [np.full((48, 64, 3), 8 * k, dtype=np.uint8) for k in range(30)]
    save_video(tmp_path / "t.mp4", moving, 20.0)
    asked = ["ffprobe", "-v", "error", "-show_entries", "format=duration", "-of", "csv=p=0"]
    reported = subprocess.run([*asked, str(tmp_path / "t.mp4")], capture_output=True, text=True)
    assert float(reported.stdout) == pytest.approx(1.5, abs=0.06), reported.stderr


@pytest.mark.slow
def test_what_ffmpeg_cannot_write_is_reported_with_its_reason(tmp_path: Path) -> None:
    odd = [np.zeros((7, 9, 3), dtype=np.uint8)] * 3
    with pytest.raises(InputError, match="ffmpeg could not write the video"):
        save_video(tmp_path / "t.mp4", odd, 20.0)
    assert not (tmp_path / "t.mp4").exists()
