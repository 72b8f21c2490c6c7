"""Each control of a page changes what it says, begins there, and all numbers go with it."""

from __future__ import annotations

import html
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.unit.test_viewer_curves import FLIGHTS, OMNIMORPH, random_flight

import omnimorph as om
from omnimorph.live.page import LivePage
from omnimorph.model.dynamics import GRAVITY
from omnimorph.protocols import FloatArray
from omnimorph.viewer import colours
from omnimorph.viewer.design import Design
from omnimorph.viewer.design_scene import power_range
from omnimorph.viewer.explorer_page import ExplorerPage, _size_of
from omnimorph.viewer.explorer_page import numbers_of as numbers_of_design
from omnimorph.viewer.flight_page import FlightPage, numbers_of
from omnimorph.viewer.frames import Flight
from omnimorph.viewer.tables import number_table, shown_number

TILT, QUADROTOR = np.radians([40.0]), om.load_vehicle("quadrotor")


def controls_of(server: Any) -> dict[str, Any]:
    """Return the controls of a page by their labels; to set a value is to move one."""
    return {handle.label: handle for handle in server.gui._gui_input_handle_from_uuid.values()}


# --- the explorer ---------------------------------------------------------------------------------

# Label of a slider -> what it is of the vehicle that is shown.
SLIDERS: dict[str, Callable[[Design], float]] = {
    "mass, kg": lambda design: design.vehicle().mass,
    "largest rotor speed, Hz": lambda design: design.vehicle().speed_max.max() / (2.0 * np.pi),
    "longest arm, mm": lambda design: (
        1e3 * np.linalg.norm(design.vehicle().rotor_position, axis=1).max()
    ),
}


def assert_all_of_it_is_shown(page: ExplorerPage, design: Design) -> None:
    """Hold that the numbers, the legend and the scene are those of a design."""
    view = design.view()
    assert page._numbers.content == number_table(numbers_of_design(view))
    least, most = (f"{shown_number(power)} W" for power in power_range(view.power))
    first, *_, last = re.findall(r"#[0-9a-f]{6}", page._legend.content.split("gradient")[1])
    assert page._legend.content.index(least) < page._legend.content.rindex(most)
    assert [first, last] == [colours.css(colour) for colour in colours.of_power([0.0, 1.0])]
    assert page.scene._weight.scale == pytest.approx(view.weight / page.scene._scales.force)


def test_sliders_of_the_explorer_are_the_numbers_they_name(server: Any) -> None:
    stretched = QUADROTOR.rotor_position * np.array([[1.0], [1.5], [1.0], [1.5]])
    page = ExplorerPage(server, QUADROTOR.replace(rotor_position=stretched))
    found = controls_of(server)
    assert "tilt, °" not in found
    for label, number in SLIDERS.items():
        slider = found[label]
        assert slider.value == pytest.approx(number(page.design)), label
        ends = np.array([slider.min, slider.max]) / slider.value
        assert ends == pytest.approx([0.3, 3.0], rel=0.2), label
        slider.value = 1.1 * slider.value
        assert number(page.design) == pytest.approx(slider.value), label
    assert page.design.zero_moment
    found["force set"].value = "moments free"
    assert not page.design.zero_moment
    assert_all_of_it_is_shown(page, page.design)


def test_the_slider_of_the_tilt_goes_from_limit_to_limit(server: Any) -> None:
    page = ExplorerPage(server, OMNIMORPH, TILT)
    slider = controls_of(server)["tilt, °"]
    limits = np.degrees([OMNIMORPH.servo_angle_min[0], OMNIMORPH.servo_angle_max[0]])
    assert (slider.min, slider.max) == pytest.approx(limits)
    assert slider.value == 40.0
    slider.value = 50.0
    np.testing.assert_allclose(page.design.tilt, np.radians([50.0]))
    assert_all_of_it_is_shown(page, page.design)
    assert _size_of(OMNIMORPH) == (1e3 * OMNIMORPH.rotor_position.max(), "half-edge, mm")


def test_another_vehicle_is_shown_whole_and_saved(server: Any, tmp_path: Path) -> None:
    page = ExplorerPage(server, OMNIMORPH, TILT, tmp_path)
    controls_of(server)["vehicle"].value = "quadrotor"
    found = controls_of(server)
    assert_all_of_it_is_shown(page, Design.of(QUADROTOR))
    assert found["mass, kg"].value == QUADROTOR.mass
    assert "tilt, °" not in found
    found["mass, kg"].value = 1.5 * QUADROTOR.mass
    for name in ("quadrotor-design", "quadrotor-design-2"):
        found["Save as TOML"].value = True
        assert om.load_vehicle(tmp_path / f"{name}.toml").mass == found["mass, kg"].value
        assert str(tmp_path / f"{name}.toml") in page._saved.content


def test_a_design_of_one_way_rotors_has_its_own_lift_and_weakest_direction(server: Any) -> None:
    """Up and down, and the two limits, are alike in a vehicle whose rotors turn both ways."""
    one_way = OMNIMORPH.replace(speed_min=0.3 * OMNIMORPH.speed_min)
    view = Design.of(one_way, TILT).view()
    reported = {row.key: row.values[0] for row in numbers_of_design(view)}
    forces = om.analysis.force_set(one_way, TILT, zero_moment=True)
    assert reported["lift"] == shown_number(forces.vertices[:, 2].max())
    free = Design.of(one_way, TILT).changed(zero_moment=False).view().forces
    assert free.volume == pytest.approx(
        om.analysis.force_set(one_way, TILT, zero_moment=False).volume
    )
    assert reported["moment-radius"] == shown_number(view.moments.inscribed_radius)
    assert reported["weight"] == shown_number(one_way.mass * GRAVITY)


# --- a flight that was flown ----------------------------------------------------------------------


def test_controls_of_a_flight_change_what_they_say(server: Any) -> None:
    page = FlightPage(server, FLIGHTS)
    found, step = controls_of(server), FLIGHTS[0].run.provenance.physics_step
    slider = found["time, s"]
    assert (slider.min, slider.max, slider.step) == (0.0, FLIGHTS[0].duration, step)
    for word in found["speed"].options:
        found["speed"].value = word
        assert page.playback.speed == float(word.split()[0])
    for plays, word in ((True, "Pause"), (False, "Play")):
        found["Play"].value = True
        page._show()
        assert (page.playback.is_playing, found["Play"].label) == (plays, word)
    parts: dict[str, Callable[[Any], Any]] = {
        "desired pose": lambda actor: actor.ghost.root,
        "thrusts": lambda actor: actor.solid._arrows,
        "trail": lambda actor: actor._trail,
    }
    for label in parts:
        for shown in (False, True):
            found[label].value = shown
            for other, part in parts.items():
                seen = [part(actor).visible for actor in page.scene.actors]
                assert seen == [shown or other != label] * 2, (label, other)


class Watched:
    """A server whose page one visitor looks at."""

    def __init__(self, server: Any, start: FloatArray) -> None:
        self._server = server
        self.camera = SimpleNamespace(position=start, look_at=np.zeros(3))
        self.get_clients = lambda: {0: SimpleNamespace(camera=self.camera)}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._server, name)


def test_a_camera_that_follows_goes_as_far_as_the_vehicle(server: Any) -> None:
    start, run = np.array([1.0, 2.0, 3.0]), FLIGHTS[0].run
    watched = Watched(server, start)
    page = FlightPage(watched, FLIGHTS[:1])
    controls_of(server)["camera"].value = "follow"
    for row in (3, 8):
        page.playback.move_to(float(run.time[row]))
        page._show()
        np.testing.assert_allclose(watched.camera.look_at, run.p_WB[row])
        way = run.p_WB[row] - run.p_WB[0]
        np.testing.assert_allclose(watched.camera.position, start + way)


def test_no_row_is_left_out_beside_a_vehicle_without_servos() -> None:
    fixed = Flight(random_flight(5, om.load_vehicle("odar-8")), "fixed")
    alone = numbers_of(FLIGHTS[:1], [FLIGHTS[0].frame(3)])
    both = numbers_of([FLIGHTS[0], fixed], [FLIGHTS[0].frame(3), fixed.frame(3)])
    assert [(row.key, row.values[0]) for row in both] == [(r.key, r.values[0]) for r in alone]
    assert next(row.values[1] for row in both if row.key == "tilt") == "—"


# --- a flight under way ---------------------------------------------------------------------------


def test_controls_of_a_live_flight_change_what_they_say(server: Any) -> None:
    page = LivePage(server, om.load_scenario("hover"))
    found, weight = controls_of(server), OMNIMORPH.mass * GRAVITY
    strength = found["push, N"]
    assert strength.value == pytest.approx(weight, abs=0.05)
    assert strength.max == pytest.approx(3.0 * weight, abs=0.2)
    strength.value = 5.0
    ways = {"−x": 0, "+y": 1, "−y": 1, "down": 2, "up": 2, "+x": 0}
    for word, axis in ways.items():
        found["for 0.2 s"].value = word
        force = np.zeros(3)
        force[axis] = -5.0 if word[0] in "−d" else 5.0
        np.testing.assert_array_equal(page.flight.notes["events"][-1]["force_N"], force)
        assert page.flight.notes["events"][-1]["duration_s"] == 0.2
    found["rotor"].value = "rotor 5"
    found["Cut its thrust"].value = True
    assert page.flight.notes["events"][-1]["share"] == [1, 1, 1, 1, 1, 0, 1, 1]
    found["Restore all rotors"].value = True
    assert page.flight.notes["events"][-1]["share"] == [1] * 8
    assert found["controller"].value == found["controller"].options[0] == "hover"
    for name in found["controller"].options[1:3]:
        assert om.load_scenario(name).vehicle.name == "omnimorph"
    found["controller"].value = "paper-case-b"
    assert page.flight.notes["events"][-1]["scenario"] == "paper-case-b"
    assert html.escape("controller of paper-case-b") in page._done_to_it()
    for word, pace in (("a tenth", 0.1), ("half", 0.5), ("real time", 1.0)):
        found["pace"].value = word
        before = page.flight.time
        page._advance(0.2)
        assert page.flight.time - before == pytest.approx(0.2 * pace, abs=0.0041)
    found["Pause"].value = True
    assert (found["Pause"].label, page._is_running) == ("Go on", False)
