"""Who may use a page, and what it may ask for: viser answers anybody and takes what it is sent.

viser has no hook for this. While a server starts, the one function with which viser opens its port
is replaced by one that checks each request before it is answered, and each message before viser
reads it. The server is tried then, and not kept if it lets anything through.
"""

from __future__ import annotations

import itertools
import math
import re
import secrets
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from http import HTTPStatus
from typing import Any

import msgspec
import viser
import websockets.asyncio.server
from websockets.exceptions import InvalidStatus, WebSocketException
from websockets.sync.client import connect

from omnimorph.errors import InputError
from omnimorph.viewer.server import LOOPBACK, in_numbers, is_loopback

_HOST = re.compile(r"(\[[0-9a-f:.]+\]|[^:/@\[\]\s]+)(:\d+)?")
_HEADERS = {
    "X-Frame-Options": "DENY",  # no page of others may lie over it and borrow its clicks
    "Referrer-Policy": "no-referrer",  # the address is a secret
}
_PROTOCOL: Any = f"viser-v{viser.__version__}"  # how the page in the browser calls what it speaks
_VECTORS_OF_CAMERA = {"wxyz": 4, "position": 3, "look_at": 3, "up_direction": 3}
_FARTHEST = 1e9  # m from where somebody looks
_ROUNDING = 1e-7  # the browser writes a slider's value with at most seven decimals
_PATIENCE = 10.0  # s for the first try of a new server

_websockets: Any = websockets.asyncio.server
_one_start = threading.Lock()


class Guard:
    """Keeps others out of a page, and from its controls what they cannot have sent.

    Parameters
    ----------
    host : str
        Where the page is served.

    Attributes
    ----------
    token : str
        The part of the address that only those know to whom it was given.
    dropped : int
        How many messages no control of the page could have sent.
    takes_pictures : bool
        Whether the browser was asked for pictures, and may send them.
    """

    def __init__(self, host: str) -> None:
        self.token = secrets.token_urlsafe(24)
        self.dropped = 0
        self.takes_pictures = False
        self._host = host.lower()
        self._controls: dict[str, Any] = {}
        self._when_faulty: list[Callable[[Exception], object]] = []

    def on_fault(self, call: Callable[[Exception], object]) -> None:
        """Let something be called with each exception that a callback of the page raises."""
        self._when_faulty.append(call)

    def fault(self, error: Exception) -> None:
        """Report a fault of the page."""
        for call in self._when_faulty:
            call(error)

    def start(self, make: Callable[[], Any]) -> Any:
        """Return the server that `make` starts, with everything that reaches it checked.

        Raises
        ------
        InputError
            If it would not be: the server is stopped then.
        """
        with _one_start:
            serve = _websockets.serve
            _websockets.serve = lambda *arguments, **options: self._serve(
                serve, *arguments, **options
            )
            try:
                server = make()
            finally:
                _websockets.serve = serve
        try:
            self._controls = server.gui._gui_input_handle_from_uuid
            is_kept = self._catches_faults(server) and self._keeps_out(server)
        except (AttributeError, OSError, WebSocketException):
            is_kept = False
        if not is_kept:
            server.stop()
            raise InputError(
                f"the page is not served: viser {viser.__version__}, as it is installed here, "
                "would let anybody use it; pip install 'omnimorph[view]' brings another."
            )
        self.dropped = 0
        return server

    def _serve(
        self, serve: Any, handle: Any, *where: Any, process_request: Any = None, **options: Any
    ) -> Any:
        """Open a port as viser asks for it, with a look at what comes in."""

        def answer(connection: Any, request: Any) -> Any:
            if not self._admits(request):
                return connection.respond(HTTPStatus.FORBIDDEN, "Forbidden.\n")
            request.path = "/"
            response = process_request(connection, request)
            if response is not None:
                response.headers.update(_HEADERS)
            return response

        async def converse(connection: Any) -> None:
            receive = connection.recv

            async def receive_checked() -> Any:
                while not self._is_in_order(message := await receive()):
                    self.dropped += 1
                return message

            connection.recv = receive_checked
            if connection.subprotocol == _PROTOCOL:
                await handle(connection)
            else:  # viser would complain on our standard output
                await connection.close(1002, "another viser")

        return serve(converse, *where, process_request=answer, **options)

    def _admits(self, request: Any) -> bool:
        """Return whether a request is for this page, from this page, and knows its address.

        A browser says in Host what it was asked to open, and in Origin which page asks; only a
        page of this server has both the same. Programs that are no browser send no Origin.
        """
        hosts, origins = (request.headers.get_all(name) for name in ("Host", "Origin"))
        if len(hosts) != 1 or not self._is_served(hosts[0].lower()):
            return False
        if any(origin.lower() != f"http://{hosts[0].lower()}" for origin in origins):
            return False
        asked = request.path.partition("?")[0].strip("/").encode(errors="surrogateescape")
        return secrets.compare_digest(asked, self.token.encode())

    def _is_served(self, host: str) -> bool:
        """Return whether a Host is a name of this server.

        What must be kept out is a name of others that is made to point here (DNS rebinding). So
        the host that was asked for and those of loopback are allowed; where others may reach the
        page also this machine's own name and any address in numbers: nobody can make one point
        elsewhere, and those of routers and containers before it are not known here. The port is
        not compared: an SSH tunnel has its own, and Origin must have the same.
        """
        found = _HOST.fullmatch(host)
        if found is None:
            return False
        name = found[1].strip("[]")
        if name == self._host or is_loopback(name):
            return True
        is_own = in_numbers(name) is not None or name == socket.gethostname().lower()
        return is_own and not is_loopback(self._host)

    def _is_in_order(self, raw: Any) -> bool:
        """Return whether a message is one that the page may send; viser would take any."""
        known: dict[str, Callable[..., bool]]
        known = {"GuiUpdateMessage": self._is_update, "ViewerCameraMessage": _is_camera}
        if self.takes_pictures:
            known["GetRenderResponseMessage"] = lambda payload, render_uuid: (
                type(payload) is bytes and type(render_uuid) is str
            )
        try:
            message = msgspec.msgpack.decode(raw)
            return known[message.pop("type")](**message)
        except Exception:  # whatever is wrong with it
            return False

    def _is_update(self, *, uuid: str, updates: dict[str, Any]) -> bool:
        """Return whether a control that is there has been moved to where it can be."""
        return updates.keys() == {"value"} and _can_be(self._controls[uuid], updates["value"])

    def _catches_faults(self, server: Any) -> bool:
        """Let the callbacks of a server report their exceptions here, not in a traceback."""
        pool = server._thread_executor
        submit = pool.submit

        def run(call: Callable[..., object], *arguments: object) -> None:
            try:
                call(*arguments)
            except Exception as error:
                self.fault(error)

        pool.submit = lambda call, *arguments: submit(run, call, *arguments)
        return server.gui._thread_executor is pool

    def _keeps_out(self, server: Any) -> bool:
        """Try a server: a stranger must be refused, and what is no message dropped."""
        where = (LOOPBACK if self._host == "0.0.0.0" else self._host, server.get_port())

        def visit(path: str) -> Any:
            door = socket.create_connection(where, timeout=_PATIENCE)
            return connect(f"ws://localhost/{path}", sock=door, subprotocols=[_PROTOCOL])

        with suppress(InvalidStatus):
            visit("").close()
            return False
        with visit(self.token) as friend:
            friend.send(b"no message")
            ends = time.monotonic() + _PATIENCE
            while self.dropped == 0 and time.monotonic() < ends:
                time.sleep(2e-3)
        return self.dropped == 1


def _can_be(control: Any, value: Any) -> bool:
    """Return whether a control of the page can have a value."""
    if isinstance(control, viser.GuiSliderHandle):
        low, high = control.min - _ROUNDING, control.max + _ROUNDING
        return _are_numbers(value) and bool(low <= value <= high)
    if isinstance(control, viser.GuiDropdownHandle | viser.GuiButtonGroupHandle):
        return type(value) is str and value in control.options
    if isinstance(control, viser.GuiCheckboxHandle):
        return type(value) is bool
    return isinstance(control, viser.GuiButtonHandle) and value is True


def _is_camera(
    *, fov: Any, near: Any, far: Any, image_height: Any, image_width: Any, **vectors: Any
) -> bool:
    """Return whether a message says from where somebody looks."""
    numbers = [fov, near, far, image_height, image_width, *itertools.chain(*vectors.values())]
    return (
        {name: len(vector) for name, vector in vectors.items()} == _VECTORS_OF_CAMERA
        and _are_numbers(*numbers)
        and max(map(abs, numbers)) <= _FARTHEST
        and min(image_height, image_width) >= 1
        and any(vectors["up_direction"])
        and bool(vectors["look_at"] != vectors["position"])
    )


def _are_numbers(*values: Any) -> bool:
    return all(type(value) in (int, float) and math.isfinite(value) for value in values)
