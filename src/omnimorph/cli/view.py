"""Show a flight in 3-D beside its plots, two flights side by side, or a vehicle to explore."""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnimorph.cli import console
from omnimorph.cli.arguments import add_out, angles_in_degrees, number_at_least
from omnimorph.cli.page import add_page_arguments, announce, check_no_page, closing, served
from omnimorph.design.input_files import is_folder
from omnimorph.errors import InputError
from omnimorph.results.folder import replaced_text

if TYPE_CHECKING:
    from omnimorph.viewer.frames import Flight

SUMMARY = "look at a flight or at a vehicle in 3-D, in the browser or as a picture"
NEEDS = ("omnimorph.results.store", "omnimorph.analysis")

_PICTURE = (1600, 1200)
_VIDEO = (960, 720)
_PICTURES_A_SECOND = 15.0
_SLOWEST = 0.01


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument(
        "what",
        nargs="+",
        metavar="WHAT",
        help="a run (its .nc file or its folder), two runs side by side, or a vehicle: a name that "
        "`omnimorph vehicles` lists, or a TOML file",
    )
    parser.add_argument(
        "--tilt",
        type=angles_in_degrees,
        metavar="DEG",
        help="explore the vehicle from this tilt; with commas, one angle for each servo "
        "(default: where its radius at zero moment is largest, if it has one servo)",
    )
    add_out(parser, "where the page may save designs; without it they are only downloaded")
    add_page_arguments(parser)
    parser.add_argument(
        "--snapshot",
        type=Path,
        metavar="FILE",
        help="write a picture instead of opening a page: .png, .jpg or .webp",
    )
    parser.add_argument(
        "--video",
        type=Path,
        metavar="FILE",
        help="write the flight as a video instead: .gif, .webp, or .mp4 with ffmpeg",
    )
    parser.add_argument(
        "--at",
        type=number_at_least("--at", 0.0, "a number of seconds"),
        metavar="S",
        help="the moment of the snapshot (default: the middle of the flight)",
    )
    parser.add_argument(
        "--speed",
        type=number_at_least("--speed", _SLOWEST, f"a number from {_SLOWEST:g} on"),
        metavar="X",
        help="how fast the video goes (default: 1, as it was flown)",
    )


def answer(options: argparse.Namespace) -> console.Answer:
    """Open the page until Ctrl-C, or write the picture."""
    from omnimorph.viewer.server import viser_module

    viser_module()
    _check_together(options)
    if all(_is_run(what) for what in options.what):
        flights = _flights(options.what)
        _check_moment(options.at, max(flight.duration for flight in flights))
        if options.snapshot or options.video:
            return _pictures_of_flight(options, flights)
        return _flight_page(options, flights)
    vehicle, tilt = _vehicle(options)
    if options.snapshot:
        return _picture_of_design(options, vehicle, tilt)
    return _explorer_page(options, vehicle, tilt)


def _check_together(options: argparse.Namespace) -> None:
    """Refuse what cannot be shown together, before anything is read."""
    from omnimorph.viewer.pictures import PICTURE_FORMATS, VIDEO_FORMATS, browser, check_format

    runs = [_is_run(what) for what in options.what]
    if len(runs) > 2 or (len(runs) == 2 and not all(runs)):
        shown = " ".join(options.what)
        allowed = "one run, two runs, or one vehicle"
        raise InputError.at("the command line", "WHAT", shown, allowed)
    goes_with = {"video": "a run", "at": "a run", "tilt": "a vehicle", "out": "a vehicle"}
    for option, allowed in goes_with.items():
        if getattr(options, option) is not None and all(runs) == (allowed == "a vehicle"):
            raise InputError(
                f"the command line: --{option} goes with {allowed}, not with {options.what[0]}."
            )
    for option, needed in (("at", "snapshot"), ("speed", "video")):
        if getattr(options, option) is not None and getattr(options, needed) is None:
            raise InputError(
                f"the command line: --{option} goes with --{needed}, which is not given."
            )
    if options.snapshot or options.video:
        check_no_page(options, "a picture is drawn instead")
        if options.out is not None:
            raise InputError(
                "the command line: --out is for designs that a page saves, and a "
                "picture is drawn instead."
            )
    for option, formats in (("snapshot", PICTURE_FORMATS), ("video", VIDEO_FORMATS)):
        path = getattr(options, option)
        if path is not None:
            check_format(f"--{option}", path, formats)
            browser()


def _check_moment(at: float | None, duration: float) -> None:
    """Refuse a moment after the end of the flight, which would be a picture of another one."""
    if at is not None and at > duration:
        raise InputError.at("the command line", "--at", at, f"from 0 to {duration:g} s")


def _is_run(what: str) -> bool:
    path = Path(what)
    return path.suffix == ".nc" or (is_folder(path) and os.path.exists(path / "run.nc"))


def _flights(names: list[str]) -> list[Flight]:
    """Load runs; each is called by its scenario, or by its file where both would be the same."""
    from omnimorph import load_run
    from omnimorph.viewer.frames import Flight

    paths = [Path(name) / "run.nc" if is_folder(name) else Path(name) for name in names]
    runs = [load_run(path) for path in paths]
    called = [run.provenance.scenario_name or "flight" for run in runs]
    if len(set(called)) < len(called):
        called = [f"{name} {k + 1}" for k, name in enumerate(called)]
    return [Flight(run, name) for name, run in zip(called, runs, strict=True)]


def _vehicle(options: argparse.Namespace) -> tuple[Any, Any]:
    from omnimorph import load_vehicle
    from omnimorph.analysis.scaling import checked_tilt

    vehicle = load_vehicle(options.what[0])
    return vehicle, None if options.tilt is None else checked_tilt(vehicle, options.tilt)


def _flight_page(options: argparse.Namespace, flights: list[Flight]) -> console.Answer:
    from omnimorph.viewer.flight_page import FlightPage

    with served(options) as server:
        page = FlightPage(server, flights)
        with suppress(KeyboardInterrupt):
            announce(server, options, "Ctrl-C ends it")
            page.play()
    return _closed(options)


def _explorer_page(options: argparse.Namespace, vehicle: Any, tilt: Any) -> console.Answer:
    from threading import Event

    from omnimorph.viewer.explorer_page import ExplorerPage

    with served(options) as server:
        ExplorerPage(server, vehicle, tilt, options.out)
        with suppress(KeyboardInterrupt):
            announce(server, options, "Ctrl-C ends it")
            Event().wait()
    return _closed(options)


def _closed(options: argparse.Namespace) -> console.Answer:
    return console.Answer("The page is closed.", {"shown": options.what})


def _pictures_of_flight(options: argparse.Namespace, flights: list[Flight]) -> console.Answer:
    from omnimorph.viewer.flight_page import FlightScene
    from omnimorph.viewer.pictures import camera_in, check_length, save_picture, save_video, still
    from omnimorph.viewer.server import new_server

    replaced = replaced_text(*filter(None, (options.snapshot, options.video)))
    duration = max(flight.duration for flight in flights)
    moment = _moment(flights, options.at)
    speed = 1.0 if options.speed is None else options.speed
    if options.video:
        check_length(options.video, _count(duration, speed), *_VIDEO)
    with closing(new_server()) as server:
        scene = FlightScene(server, flights)
        files: list[Path] = []
        with camera_in(server) as take:
            if options.snapshot:
                frames = scene.show(moment)
                camera = scene.close_up(frames)
                save_picture(options.snapshot, still(take, *_PICTURE, *camera))
                files.append(options.snapshot)
            if options.video:
                with console.Progress("drawing") as progress:
                    pictures = _moments(scene, take, speed, progress)
                    save_video(options.video, pictures, _PICTURES_A_SECOND)
                files.append(options.video)
    ended = "" if options.snapshot is None else _ended_before(flights, moment)
    return _written(files, f"{ended}\n{replaced}".strip())


def _moment(flights: list[Flight], at: float | None) -> float:
    """Return the moment of a picture, s: that asked for, or the middle of the longer flight."""
    return 0.5 * max(flight.duration for flight in flights) if at is None else at


def _ended_before(flights: list[Flight], moment: float) -> str:
    """Return which flights of a picture had ended before its moment, s; "" if none had."""
    ended = [f"{one.name} at {one.duration:g} s" for one in flights if one.duration < moment]
    if not ended:
        return ""
    return f"the picture is of {moment:g} s; it shows the last moment of {' and '.join(ended)}."


def _moments(scene: Any, take: Any, speed: float, progress: console.Progress) -> Iterator[Any]:
    """Yield the pictures of a video."""
    count = _count(scene.duration, speed)
    for k in range(count):
        scene.show(min(k * speed / _PICTURES_A_SECOND, scene.duration))
        yield take(*_VIDEO, *scene.camera)
        progress(k + 1, count)


def _count(duration: float, speed: float) -> int:
    """Return the number of pictures of a video: from the first moment to the last."""
    return max(math.ceil(duration / speed * _PICTURES_A_SECOND), 1) + 1


def _picture_of_design(options: argparse.Namespace, vehicle: Any, tilt: Any) -> console.Answer:
    from omnimorph.viewer.design import Design, scales_of
    from omnimorph.viewer.design_scene import DesignScene
    from omnimorph.viewer.pictures import camera_in, save_picture, still
    from omnimorph.viewer.server import new_server

    replaced = replaced_text(options.snapshot)
    scales, view = scales_of(vehicle), Design.of(vehicle, tilt).view()
    with closing(new_server()) as server:
        scene = DesignScene(server, view, scales)
        with camera_in(server) as take:
            save_picture(options.snapshot, still(take, *_PICTURE, *scene.camera))
    return _written([options.snapshot], replaced)


def _written(files: list[Path], complaint: str) -> console.Answer:
    names = [str(file) for file in files]
    text = f"Written: {', '.join(names)}."
    return console.Answer(text, {"files": names}, complaint=complaint)
