"""The commands that open a page, visited by a program: what it may do, and what is said of it."""

from __future__ import annotations

import json
import threading
import webbrowser
from pathlib import Path

import pytest
from tests.serving import served
from tests.visitor import Visitor, wait_until

import omnimorph as om
from omnimorph.cli.main import main
from omnimorph.live.pilot import Pilot


def test_a_flight_survives_who_talks_nonsense_to_it(tmp_path: Path) -> None:
    words = ("fly", "hover", "--view", "--seed", "3", "--out", "flown")
    with served(*words, folder=tmp_path) as command:
        with Visitor(command.url) as visitor:
            found = visitor.controls()
            visitor.look()
            visitor.set(found["pace"], "warp")
            visitor.say(type="ShareUrlRequest")
            visitor.send(b"\xc1")
            visitor.set(found["Cut its thrust"], "yes")
            visitor.set(found["pace"], "as fast as possible")
            wait_until((tmp_path / "flown" / "run.nc").exists)
        out, err = command.process.communicate(timeout=30.0)
    assert command.process.returncode == 0
    assert "The flight was completed." in out
    assert "omnimorph: 4 messages that no control of the page sends had no effect.\n" in err
    assert "Traceback" not in err
    run = om.load_run(tmp_path / "flown" / "run.nc")
    assert "events" not in json.loads(run.provenance.scenario_text)
    assert "seed 3" in out
    assert run.content_hash == om.fly(om.load_scenario("hover"), seed=3).content_hash


def test_a_flight_that_a_fault_of_the_page_ends_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The browser is a thread here: it presses a button whose action fails."""
    kept = tmp_path / "flown" / "run.nc"

    def fails(pilot: Pilot) -> None:
        raise RuntimeError("a bug\nof ours")

    def look(address: str) -> None:
        with Visitor(address) as visitor:
            found = visitor.controls()
            visitor.look()
            visitor.set(found["Restore all rotors"], True)
            wait_until(kept.exists)

    def opens(address: str) -> bool:
        threading.Thread(target=look, args=(address,)).start()
        return True

    monkeypatch.setattr(Pilot, "restore", fails)
    monkeypatch.setenv("BROWSER", "a thread")
    monkeypatch.setattr(webbrowser, "open", opens)
    assert main(["fly", "hover", "--view", "--port", "0", "--out", str(kept.parent)]) == 3
    said = capsys.readouterr()
    assert "The flight was ended by a fault of the page." in said.out
    first, fault, end = said.err.splitlines()
    assert "the page is at http://127.0.0.1:" in first
    assert fault == "omnimorph: a fault of the page, which is ours: RuntimeError: a bug of ours"
    assert end.startswith("omnimorph: hover: The flight was ended by a fault of the page. It flew")
    assert om.load_run(kept).outcome is om.Outcome.PAGE_FAULT
    assert json.loads((kept.parent / "metrics.json").read_text())["outcome"] == "page_fault"
