"""Pictures and videos of a page's scene, drawn by a browser without a window."""

from __future__ import annotations

import itertools
import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnimorph.errors import InputError
from omnimorph.machine.children import started
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.protocols import FloatArray
from omnimorph.results.atomic import replacing
from omnimorph.viewer.server import address_of
from omnimorph.viewer.shapes import wxyz_of
from omnimorph.viewer.stage import FIELD_OF_VIEW

PICTURE_FORMATS = (".png", ".jpg", ".webp")
VIDEO_FORMATS = (".gif", ".webp", ".mp4")

_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
_MOST_TRIES = 8
_BYTES_OF_A_PIXEL = 5  # of a video that is written when all of its pictures are there
_PATIENCE = 60.0  # s for the browser to open the page, and for one picture

Camera = Callable[[int, int, FloatArray, FloatArray], NDArray[np.uint8]]
"""Takes a picture, (height, width, 3), of so many pixels across and high from a (3,) point towards
another."""


def browser() -> str:
    """Return the program that draws the pictures.

    Raises
    ------
    InputError
        If there is none.
    """
    named = os.environ.get("OMNIMORPH_BROWSER")
    for name in [named] if named else _BROWSERS:
        found = shutil.which(name)
        if found:
            return found
    if named:
        allowed = "a Chromium or Chrome that can be started"
        raise InputError.at("the environment", "OMNIMORPH_BROWSER", named, allowed)
    raise InputError(
        "no browser to draw the picture with: install Chromium or Chrome (apt-get install "
        "chromium), or name one in OMNIMORPH_BROWSER."
    )


def check_format(option: str, path: Path, formats: Sequence[str]) -> None:
    """Refuse a file that cannot be written, before hours are spent on what goes there.

    Raises
    ------
    InputError
        If its ending is not among the formats, its video takes a program that is not installed, or
        its folder is not there.
    """
    if path.suffix.lower() not in formats:
        allowed = f"a file that ends in {', '.join(formats)}"
        raise InputError.at("the command line", option, str(path), allowed)
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        allowed = "a .gif or .webp, or ffmpeg must be installed for .mp4"
        raise InputError.at("the command line", option, str(path), allowed)
    if not path.parent.is_dir():
        allowed = "a file in a folder that is there"
        raise InputError.at("the command line", option, str(path), allowed)


def check_length(path: Path, pictures: int, width: int, height: int) -> None:
    """Refuse a video whose pictures, which wait in memory but for ``.mp4``, are more than it holds.

    Raises
    ------
    TooLargeError
        If they are.
    """
    if path.suffix.lower() != ".mp4":
        needed = pictures * width * height * _BYTES_OF_A_PIXEL
        instead = "write an .mp4, or let it go faster"
        refuse_more_than_memory(f"{path}: {pictures} pictures", needed, instead)


@contextmanager
def camera_in(server: Any) -> Iterator[Camera]:
    """Open a server's page in a browser without a window; give what takes its pictures.

    Parameters
    ----------
    server : viser.ViserServer
        Whose scene.

    Raises
    ------
    InputError
        If there is no browser, or it does not open the page.
    """
    program = browser()
    server.guard.takes_pictures = True
    with started([program, *_options(), address_of(server)]) as process:
        client = _first_client(server, process, program)

        def take(
            width: int, height: int, position: FloatArray, look_at: FloatArray
        ) -> NDArray[np.uint8]:
            try:
                drawn = client.get_render(
                    height,
                    width,
                    position=position,
                    wxyz=_looking(position, look_at),
                    fov=FIELD_OF_VIEW,
                    transport_format="png",
                    timeout=_PATIENCE,
                )
            except (RuntimeError, TimeoutError):  # it crashed, was ended, or cannot draw
                raise _no_picture(program, "did not draw the picture") from None
            return _on_white(drawn)

        # the first one compiles what draws
        take(64, 48, np.array([0.0, -3.0, 1.0]), np.zeros(3))
        yield take


def still(
    take: Camera, width: int, height: int, position: FloatArray, look_at: FloatArray
) -> NDArray[np.uint8]:
    """Return a picture in which all is there: taken until two in a row are the same.

    Letters, and what has only just entered the scene, come into the browser's pictures late.
    """
    before = take(width, height, position, look_at)
    for _ in range(_MOST_TRIES):
        time.sleep(0.3)
        now = take(width, height, position, look_at)
        if np.array_equal(before, now):
            break
        before = now
    return before


def save_picture(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write a picture, as a whole or not at all, in the format of its ending."""
    from PIL import Image

    with replacing(path) as temporary:
        Image.fromarray(pixels).save(temporary, format=_pillow_format(path))


def save_video(path: Path, pictures: Iterable[NDArray[np.uint8]], per_second: float) -> None:
    """Write a video, as a whole or not at all, in the format of its ending.

    Parameters
    ----------
    path : Path
        One of `VIDEO_FORMATS`; ``.mp4`` by ffmpeg.
    pictures : iterable of (height, width, 3) arrays
        In their order, at least one.
    per_second : float
        How many are shown in a second.

    Raises
    ------
    InputError
        If ffmpeg cannot write it.
    """
    with replacing(path) as temporary:
        if path.suffix.lower() == ".mp4":
            _write_with_ffmpeg(temporary, pictures, per_second)
        else:
            _write_with_pillow(temporary, _pillow_format(path), pictures, per_second)


def _options() -> list[str]:
    options = ["--headless=new", "--no-first-run", "--disable-extensions", "--mute-audio"]
    options += ["--user-data-dir=."]  # the folder it is given
    # A picture may be larger than the window, and a small window leaves more time for it.
    options += ["--window-size=400,300", "--hide-scrollbars"]
    options += ["--enable-unsafe-swiftshader"]  # where there is no GPU, it draws in software
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        options.append("--no-sandbox")  # Chromium refuses to start for root with it
    return options


def _first_client(server: Any, process: subprocess.Popen[str], program: str) -> Any:
    began = time.monotonic()
    while time.monotonic() - began < _PATIENCE and process.poll() is None:
        for client in server.get_clients().values():
            return client
        time.sleep(0.02)
    raise _no_picture(program, "did not open the page")


def _no_picture(program: str, why: str) -> InputError:
    return InputError(
        f"{program} {why}; name another browser in OMNIMORPH_BROWSER, or open the page yourself "
        "and take a screenshot."
    )


def _looking(position: FloatArray, at: FloatArray) -> FloatArray:
    """Return the attitude of a camera that looks along its z with its y downwards, as wxyz."""
    ahead = (at - position) / np.linalg.norm(at - position)
    right = np.cross(ahead, np.array([0.0, 0.0, 1.0]))
    right /= np.linalg.norm(right)
    return wxyz_of(np.column_stack([right, np.cross(ahead, right), ahead]))


def _on_white(drawn: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a picture with transparent parts as one on white paper."""
    if drawn.shape[2] == 3:
        return drawn
    opaque = drawn[..., 3:].astype(np.float64) / 255.0
    return np.rint(255.0 + opaque * (drawn[..., :3] - 255.0)).astype(np.uint8)


def _pillow_format(path: Path) -> str:
    return {".jpg": "JPEG"}.get(path.suffix.lower(), path.suffix[1:].upper())


def _write_with_pillow(
    path: Path, kind: str, pictures: Iterable[NDArray[np.uint8]], per_second: float
) -> None:
    from PIL import Image

    others = (Image.fromarray(pixels) for pixels in pictures)
    first = next(others)
    duration = round(1000.0 / per_second)
    first.save(path, format=kind, save_all=True, append_images=others, duration=duration, loop=0)


def _write_with_ffmpeg(
    path: Path, pictures: Iterable[NDArray[np.uint8]], per_second: float
) -> None:
    others = iter(pictures)
    first = next(others)
    size = f"{first.shape[1]}x{first.shape[0]}"
    command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]
    command += ["-s", size, "-r", f"{per_second:g}", "-i", "-", "-pix_fmt", "yuv420p"]
    command += ["-f", "mp4", str(path)]
    # It ends when its input does, hence also with this process.
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as encoder:
        assert encoder.stdin is not None
        try:
            for pixels in itertools.chain([first], others):
                encoder.stdin.write(pixels.tobytes())
        except BaseException as error:
            if not isinstance(error, BrokenPipeError):  # with that it has ended, and says why
                encoder.kill()
                encoder.communicate()
                raise
        _, complaint = encoder.communicate()
    if encoder.returncode != 0:
        lines = complaint.decode(errors="replace").strip().splitlines()
        reason = lines[-1] if lines else "it gave no reason"
        raise InputError(f"ffmpeg could not write the video: {reason}.")
