"""A program that visits a page as its browser does, and may say anything there."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit

import msgspec
import viser
import zstandard
from websockets.sync.client import connect
from websockets.typing import Subprotocol

CAMERA: dict[str, Any] = {
    "type": "ViewerCameraMessage",
    "wxyz": [1, 0, 0, 0],
    "position": [0.0, -3.0, 1.0],
    "fov": 0.8,
    "near": 0.01,
    "far": 1000,
    "image_height": 720,
    "image_width": 960,
    "look_at": [0, 0, 0],
    "up_direction": [0, 0, 1],
}


class Visitor:
    """A websocket to a page, and the controls that it is shown there.

    Parameters
    ----------
    url : str
        The address of the page.
    host : str
        What is reported as the Host; that of the address by default.
    origin : str
        What is reported as the Origin; none by default, as by a program.
    """

    def __init__(self, url: str, *, host: str = "", origin: str = "") -> None:
        parts = urlsplit(url)
        assert parts.hostname is not None
        self._socket = connect(
            f"ws://{host or parts.netloc}{parts.path.rstrip('/')}",
            sock=socket.create_connection((parts.hostname, parts.port), timeout=30.0),
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            additional_headers={"Origin": origin} if origin else {},
            max_size=None,
            max_queue=None,
        )

    def __enter__(self) -> Visitor:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def send(self, raw: bytes | str) -> None:
        """Send anything."""
        self._socket.send(raw)

    def say(self, **message: Any) -> None:
        """Send a message as the page writes it."""
        self.send(msgspec.msgpack.encode(message))

    def look(self) -> None:
        """Say from where one looks, without which one is no visitor yet."""
        self.say(**CAMERA)

    def set(self, uuid: str, value: Any) -> None:
        """Move a control, or press a button: `value` is True then."""
        self.say(type="GuiUpdateMessage", uuid=uuid, updates={"value": value})

    def controls(self) -> dict[str, str]:
        """Return the ids of the controls by their labels."""
        controls = [message for message in self.shown() if message["type"].startswith("Gui")]
        labels = {message.get("props", {}).get("label"): message for message in controls}
        return {label: labels[label]["uuid"] for label in labels if label is not None}

    def shown(self) -> list[dict[str, Any]]:
        """Return all that the page is sent when it opens."""
        messages: list[dict[str, Any]] = []
        while not any(message["type"] == "ReplayDoneMessage" for message in messages):
            messages += self._heard()
        return messages

    def _heard(self) -> list[dict[str, Any]]:
        raw = self._socket.recv(timeout=30.0)
        assert isinstance(raw, bytes)
        ends = 16 + int.from_bytes(raw[8:16], "little")
        reported = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(raw[16:ends]))
        messages: list[dict[str, Any]] = reported["messages"]
        return messages


def wait_until(happened: Callable[[], object], seconds: float = 30.0) -> None:
    """Wait until something has happened."""
    ends = time.monotonic() + seconds
    while not happened():
        assert time.monotonic() < ends, "it did not happen"
        time.sleep(0.005)
