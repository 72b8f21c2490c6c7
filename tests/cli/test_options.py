"""Each option of a command does what its help says, and so does leaving it out."""

from __future__ import annotations

import argparse
import re
from contextlib import chdir
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.cli.printed import answer_of

import omnimorph as om
from omnimorph.cli import reproduce, view
from omnimorph.cli.console import Progress
from omnimorph.cli.main import COMMANDS, parsed


def options_of(command: str) -> list[Any]:
    """Return the options that a command takes."""
    parser = argparse.ArgumentParser()
    COMMANDS[command].add_arguments(parser)
    return [action for action in parser._actions if action.dest != "help"]


@pytest.mark.parametrize("command", COMMANDS)
def test_defaults_are_those_that_the_help_names(command: str) -> None:
    for option in options_of(command):
        named = re.search(r"\(default: ([^\s,)]+)", option.help or "")
        if option.default is not None and named and not isinstance(option.default, bool):
            read = option.type or str
            assert read(named[1]) == option.default, option.option_strings


def test_a_flight_is_of_what_the_options_name(tmp_path: Path) -> None:
    words = ("fly", "hover", "--vehicle", "omnimorph-2026", "--plant", "perfect", "--seed", "5")
    with chdir(tmp_path):
        reported = answer_of(*words)
        alone = answer_of("fly", "hover", "--plant", "realistic-1")
    vehicle = om.load_vehicle("omnimorph-2026")
    expected = om.fly(om.load_scenario("hover").for_vehicle(vehicle, plant="perfect"), seed=5)
    assert reported.data["content_hash"] == expected.content_hash
    named = [reported.data[key] for key in ("scenario", "vehicle", "plant", "seed")]
    assert named == ["hover", "omnimorph-2026", "perfect", 5]
    assert "vehicle omnimorph-2026, plant perfect, seed 5" in reported.text
    assert (alone.data["plant"], alone.data["seed"]) == ("realistic-1", 0)
    assert (tmp_path / "runs" / "hover-omnimorph-2026-perfect-seed5" / "run.nc").is_file()


@pytest.mark.parametrize(("words", "seeds"), [((), 20), (("--quick",), 2), (("--seeds", "3"), 3)])
def test_a_reproduction_is_planned_as_asked(words: tuple[str, ...], seeds: int) -> None:
    plan = reproduce._plan(parsed(["reproduce", "--seed", "7", *words]))
    assert plan.seeds == range(7, 7 + seeds)
    assert plan.quick == ("--quick" in words)


@pytest.mark.parametrize("speed", [1.0, 2.5])
def test_a_video_goes_as_fast_as_asked(speed: float) -> None:
    """From the first moment of the flight to its last, in steps of a picture of 15 a second."""

    class Scene:
        duration, camera = 2.05, (np.zeros(3), np.ones(3))

        def __init__(self) -> None:
            self.shown: list[float] = []

        def show(self, seconds: float) -> None:
            self.shown.append(seconds)

    scene = Scene()
    with Progress("drawing") as progress:
        taken = list(view._moments(scene, lambda *words: words[:2], speed, progress))
    assert set(taken) == {view._VIDEO}
    assert len(taken) == view._count(scene.duration, speed) == len(scene.shown)
    assert scene.shown[0] == 0.0
    assert scene.shown[-1] == scene.duration
    np.testing.assert_allclose(np.diff(scene.shown)[:-1], speed / 15.0)
