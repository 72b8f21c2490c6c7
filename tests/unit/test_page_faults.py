"""What goes wrong in a page, and what it may write and show: a fault ends a live flight only."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from tests.visitor import CAMERA, Visitor, wait_until

import omnimorph as om
from omnimorph.live import page as live_page
from omnimorph.live.page import LivePage
from omnimorph.viewer import explorer_page
from omnimorph.viewer.explorer_page import ExplorerPage
from omnimorph.viewer.flight_page import FlightPage
from omnimorph.viewer.frames import Flight
from omnimorph.viewer.server import address_of, new_server, stop

HOVER = om.load_scenario("hover")


@pytest.fixture
def server() -> Iterator[Any]:
    started = new_server()
    yield started
    stop(started)


@pytest.fixture
def faults(server: Any) -> list[str]:
    reported: list[str] = []
    server.guard.on_fault(lambda error: reported.append(f"{type(error).__name__}: {error}"))
    return reported


def fails(*_: object) -> None:
    raise ValueError("this <went> wrong")


def flown(page: LivePage) -> tuple[threading.Thread, list[om.Run]]:
    """Fly a page in a thread of its own; return it, and where the run will be."""
    runs: list[om.Run] = []
    thread = threading.Thread(target=lambda: runs.append(page.fly()), daemon=True)
    thread.start()
    return thread, runs


def check_ended(run: om.Run, why: str, tmp_path: Path) -> None:
    """Check that a run ended by a fault, says which, and can be kept."""
    assert run.outcome is om.Outcome.PAGE_FAULT
    assert run.outcome.value == "The flight was ended by a fault of the page."
    assert 0.0 < run.time[-1] < HOVER.reference.duration
    events = json.loads(run.provenance.scenario_text)["events"]
    assert [(event["kind"], event["error"]) for event in events] == [("fault", why)]
    run.save(tmp_path / "run.nc")
    assert om.load_run(tmp_path / "run.nc").outcome is om.Outcome.PAGE_FAULT


def test_a_fault_of_a_control_ends_the_flight_with_what_was_flown(
    server: Any,
    faults: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    page = LivePage(server, HOVER)
    monkeypatch.setattr(page.pilot, "cut", fails)
    with Visitor(address_of(server)) as visitor:
        uuid = visitor.controls()["Cut its thrust"]
        thread, runs = flown(page)
        visitor.look()
        wait_until(lambda: page.flight.time > 0.1)
        visitor.set(uuid, True)
        thread.join(timeout=30.0)
    check_ended(runs[0], "ValueError: this <went> wrong", tmp_path)
    assert faults == ["ValueError: this <went> wrong"]
    shown = page._notice.content
    assert "ended by a fault of the page" in shown
    assert "this &lt;went&gt; wrong" in shown
    assert capfd.readouterr() == ("", "")


def test_a_fault_in_what_the_page_shows_ends_the_flight_too(
    server: Any, faults: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = LivePage(server, HOVER)
    with Visitor(address_of(server)) as visitor:
        thread, runs = flown(page)
        visitor.look()
        wait_until(lambda: page.flight.time > 0.1)
        monkeypatch.setattr(live_page, "_PACES", {})
        thread.join(timeout=30.0)
    check_ended(runs[0], "KeyError: 'real time'", tmp_path)
    assert faults == ["KeyError: 'real time'"]


def test_a_fault_after_the_flight_does_not_change_how_it_ended(
    server: Any, faults: list[str]
) -> None:
    page = LivePage(server, HOVER)
    page.pilot.advance(HOVER.reference.duration + 1.0)
    server.guard.fault(ValueError("too late"))
    assert page.as_run().outcome is om.Outcome.COMPLETED
    assert faults == ["ValueError: too late"]


def test_a_flight_that_is_shown_goes_on_after_a_fault(
    server: Any,
    faults: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    page = FlightPage(server, [Flight(om.fly(HOVER), "hover")])
    monkeypatch.setattr(page, "_change_speed", fails)
    monkeypatch.setattr(page, "_forget_followed", fails)
    with Visitor(address_of(server)) as visitor:
        visitor.look()
        found = visitor.controls()
        visitor.set(found["speed"], "2 ×")
        visitor.set(found["camera"], "follow")
        wait_until(lambda: len(faults) == 2)
        visitor.set(found["time, s"], 0.5)
        wait_until(lambda: page.playback.time == 0.5)
    assert capfd.readouterr() == ("", "")


def test_a_flight_that_plays_stops_at_a_fault_and_can_be_played_again(
    server: Any, faults: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    page = FlightPage(server, [Flight(om.fly(HOVER), "hover")])
    playing = threading.Thread(target=page.play, daemon=True)
    playing.start()
    with Visitor(address_of(server)) as visitor:
        visitor.look()
        play = visitor.controls()["Play"]
        with monkeypatch.context() as broken:
            broken.setattr(page.scene, "show", fails)
            visitor.set(play, True)
            wait_until(lambda: faults)
            assert not page.playback.is_playing
        visitor.set(play, True)
        wait_until(lambda: page.playback.time > 0.2)
    page.close()
    playing.join(timeout=30.0)
    assert faults == ["ValueError: this <went> wrong"]


def test_a_camera_in_the_middle_of_the_vehicle_does_not_stop_the_flight(
    server: Any, faults: list[str]
) -> None:
    page = FlightPage(server, [Flight(om.fly(HOVER), "hover")])
    frame = page.scene.show(0.0)[0]
    middle = page.scene.actors[0].middle(frame).tolist()
    with Visitor(address_of(server)) as visitor:
        visitor.say(**CAMERA | {"position": middle, "look_at": [middle[0] + 1.0, *middle[1:]]})
        wait_until(server.get_clients)
        found = visitor.controls()
        visitor.set(found["camera"], "follow")
        wait_until(lambda: page._followed is not None)
        visitor.set(found["time, s"], 0.5)
        wait_until(lambda: page.playback.time == 0.5 and page._slider.value == 0.5)
    assert faults == []


def test_a_design_that_is_explored_goes_on_after_a_fault(
    server: Any,
    faults: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    page = ExplorerPage(server, om.load_vehicle("quadrotor"))
    with Visitor(address_of(server)) as visitor:
        visitor.look()
        found = visitor.controls()
        with monkeypatch.context() as broken:
            broken.setattr(explorer_page, "vehicle_text", fails)
            visitor.set(found["Save as TOML"], True)
            wait_until(lambda: faults)
        visitor.set(found["mass, kg"], 1.5)
        wait_until(lambda: page.design.vehicle().mass == pytest.approx(1.5))
    assert capfd.readouterr() == ("", "")


def test_a_page_writes_so_many_files_and_no_more(
    server: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free_name = explorer_page._free_name

    def slowly(folder: Path, name: str) -> Path:
        path = free_name(folder, name)
        time.sleep(2e-3)  # in which another thread could find the same
        return path

    monkeypatch.setattr(explorer_page, "_free_name", slowly)
    out = tmp_path / "designs"
    page = ExplorerPage(server, om.load_vehicle("quadrotor"), out=out)
    with Visitor(address_of(server)) as visitor:
        visitor.look()
        uuid = visitor.controls()["Save as TOML"]
        for _ in range(130):  # from many threads at the same time
            visitor.set(uuid, True)
        wait_until(lambda: "the most that it may" in page._saved.content)
        visitor.set(uuid, True)
        wait_until(lambda: len(list(out.iterdir())) == 100)
    assert len(list(out.glob("quadrotor-design*.toml"))) == 100
    assert om.load_vehicle(out / "quadrotor-design-100.toml").name == "quadrotor-design"


def test_a_name_in_a_file_is_words_and_no_html(server: Any) -> None:
    nasty = "<img src=x onerror=alert(1)>"
    run = om.fly(HOVER)
    named = replace(run, provenance=replace(run.provenance, scenario_name=nasty))
    FlightPage(server, [Flight(named, nasty), Flight(run, "hover")])
    with Visitor(address_of(server)) as visitor:
        said = [message for message in visitor.shown() if message["type"].startswith("Gui")]
    texts = [message["props"].get("content", "") for message in said if "props" in message]
    texts += [message["updates"].get("content", "") for message in said if "updates" in message]
    assert any("&lt;img" in text for text in texts)
    assert not any("<img" in text for text in texts)
