"""Who may use a page: strangers are refused, and what no control sends has no effect."""

from __future__ import annotations

import http.client
import random
import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest
import viser
import viser.infra._infra
from tests.visitor import CAMERA, Visitor, wait_until
from websockets.exceptions import InvalidStatus

import omnimorph as om
from omnimorph.errors import InputError
from omnimorph.live.page import LivePage
from omnimorph.viewer.explorer_page import ExplorerPage
from omnimorph.viewer.flight_page import FlightPage
from omnimorph.viewer.frames import Flight
from omnimorph.viewer.guard import _can_be
from omnimorph.viewer.server import address_of, new_server, stop

HOVER = om.load_scenario("hover")
FORBIDDEN = 403
PACK = msgspec.msgpack.encode


@pytest.fixture
def server() -> Iterator[Any]:
    started = new_server()
    yield started
    stop(started)


@pytest.fixture(scope="module")
def elsewhere() -> Iterator[Any]:
    """A page that other machines can reach."""
    started = new_server("0.0.0.0")
    yield started
    stop(started)


def control(server: Any, label: str) -> Any:
    found = [c for c in server.gui._gui_input_handle_from_uuid.values() if c.label == label]
    assert len(found) == 1, label
    return found[0]


# --- who may come in ----------------------------------------------------------------------------


def status_of(server: Any, path: str, headers: dict[str, str]) -> tuple[int, bytes]:
    """Return what HTTP answers."""
    line = http.client.HTTPConnection("127.0.0.1", server.get_port(), timeout=30.0)
    line.request("GET", path, headers=headers)
    answer = line.getresponse()
    reported = answer.status, answer.read()
    line.close()
    return reported


STRANGERS = {
    "no token": ("/", {}),
    "another token": ("/" + "A" * 32 + "/", {}),
    "half a token": ("/{half}", {}),
    "a token and more": ("/{token}/index.html", {}),
    "a token as a query": ("/?token={token}", {}),
    "a path that is not ASCII": ("/%c3%a9\u00e9", {}),
    "a foreign Host": ("/{token}/", {"Host": "evil.example"}),
    "a foreign Host with our port": ("/{token}/", {"Host": "evil.example:{port}"}),
    "a Host that begins like ours": ("/{token}/", {"Host": "127.0.0.1.evil.example:{port}"}),
    "a Host with a name before it": ("/{token}/", {"Host": "evil.example@127.0.0.1:{port}"}),
    "an address of others": ("/{token}/", {"Host": "192.0.2.1:{port}"}),
    "no Host": ("/{token}/", {"Host": ""}),
    "a foreign Origin": ("/{token}/", {"Origin": "http://evil.example"}),
    "a page on another port": ("/{token}/", {"Origin": "http://127.0.0.1:1"}),
    "another name of this machine": ("/{token}/", {"Origin": "http://localhost:{port}"}),
    "a page from a file": ("/{token}/", {"Origin": "null"}),
}


@pytest.fixture(scope="module")
def closed() -> Iterator[Any]:
    started = new_server()
    yield started
    stop(started)


@pytest.mark.parametrize("who", STRANGERS)
def test_a_stranger_is_refused(closed: Any, who: str) -> None:
    path, headers = STRANGERS[who]
    token, port = closed.guard.token, closed.get_port()
    known = {"token": token, "half": token[:16], "port": port}
    path = path.format(**known)
    headers = {name: value.format(**known) for name, value in headers.items()}
    raw_path = path.encode().decode("latin-1") if path.isascii() else "/%C3%A9"
    status, reported = status_of(closed, raw_path, headers)
    assert (status, reported) == (FORBIDDEN, b"Forbidden.\n")
    host = headers.get("Host", f"127.0.0.1:{port}")
    if not host or "@" in host:
        return  # our websocket cannot ask like this
    with pytest.raises(InvalidStatus) as refusal:
        Visitor(f"http://127.0.0.1:{port}{raw_path}", host=host, origin=headers.get("Origin", ""))
    assert refusal.value.response.status_code == FORBIDDEN


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("", ""),
        ("127.0.0.1:{port}", "http://127.0.0.1:{port}"),
        ("localhost:{port}", "http://localhost:{port}"),
        ("LOCALHOST:{port}", "http://localhost:{port}"),
        ("127.0.0.1:9000", "http://127.0.0.1:9000"),  # the port of an SSH tunnel at its other end
    ],
)
def test_who_knows_the_address_comes_in(closed: Any, host: str, origin: str) -> None:
    port, path = closed.get_port(), f"/{closed.guard.token}/"
    host, origin = host.format(port=port), origin.format(port=port)
    for asked in (path, path.rstrip("/"), f"{path}?websocket=ws://here"):
        headers = {"Host": host} if host else {}
        status, page = status_of(closed, asked, headers)
        assert status == 200
        assert b"<html" in page[:200]
    with Visitor(address_of(closed), host=host, origin=origin) as visitor:
        assert visitor.controls() == {}


def test_no_page_of_others_may_lie_over_it(closed: Any) -> None:
    line = http.client.HTTPConnection("127.0.0.1", closed.get_port(), timeout=30.0)
    line.request("GET", f"/{closed.guard.token}/")
    answer = line.getresponse()
    assert answer.headers["X-Frame-Options"] == "DENY"
    assert answer.headers["Referrer-Policy"] == "no-referrer"
    answer.read()
    line.close()


def test_where_others_can_reach_it_names_of_others_are_still_refused(elsewhere: Any) -> None:
    import socket

    path = f"/{elsewhere.guard.token}/"
    own = (socket.gethostname(), "192.0.2.7:8080", "[2001:db8::7]:8080", "localhost", "0.0.0.0")
    for host in own:
        assert status_of(elsewhere, path, {"Host": host})[0] == 200, host
        assert status_of(elsewhere, "/", {"Host": host})[0] == FORBIDDEN, host
    for host in ("evil.example", "192.0.2.7.evil.example", "192.0.2.7@evil.example", "[evil]"):
        assert status_of(elsewhere, path, {"Host": host})[0] == FORBIDDEN, host


def test_every_start_has_an_address_of_its_own(closed: Any, elsewhere: Any) -> None:
    tokens = {closed.guard.token, elsewhere.guard.token}
    assert len(tokens) == 2
    assert min(map(len, tokens)) >= 32


# --- what may be asked for ----------------------------------------------------------------------


def malformed(server: Any) -> Iterator[bytes | str]:
    """Yield what no control of a live page sends."""
    yield from ("", "pace", b"", b"\xc1", b"\x91" * 5000, b"\xff" * 100_000)
    yield from wrong_values(server)
    yield from wrong_messages(control(server, "Pause")._impl.uuid)
    chance = random.Random(13)
    for _ in range(100):
        yield chance.randbytes(chance.randrange(1, 200))


def wrong_values(server: Any) -> Iterator[bytes]:
    """Yield what the controls of a live page cannot be set to."""

    def update(of: str, /, **updates: Any) -> bytes:
        uuid = control(server, of)._impl.uuid
        return PACK({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates})

    for word in ("warp", "", "real time ", "real time\0", 1.0, True, None, ["half"], {"a": 1}):
        yield update("pace", value=word)
    wrong: Any
    numbers: list[Any] = [np.nan, np.inf, -np.inf, -0.1, 1e300, 2**63, True, None, "1", [1.0], b"1"]
    for number in numbers:
        yield update("push, N", value=number)
    for label in ("Pause", "Cut its thrust"):
        for wrong in (False, 1, "True", None, [True]):
            yield update(label, value=wrong)
    for word in ("rotor 8", "rotor 99", 3, None):
        yield update("rotor", value=word)
    for word in ("paper-case-z", "../../etc/passwd", "<script>", 7):
        yield update("controller", value=word)
    for name in ("visible", "disabled", "label", "order", "hint", "options", "min", "max"):
        yield update("pace", **{name: 0})
    for name in ("update_cb", "sync_cb", "gui_api", "removed", "uuid", "props", "__class__"):
        yield update("Pause", **{name: None})
        yield update("Pause", value=True, **{name: None})
    yield update("pace")


def wrong_messages(uuid: str) -> Iterator[bytes]:
    """Yield messages that are misshapen, or that the page has no use for; one button is `uuid`."""
    wrong: Any
    yield PACK({"type": "GuiUpdateMessage", "uuid": "nobody", "updates": {"value": True}})
    yield PACK({"type": "GuiUpdateMessage", "uuid": ["a"], "updates": {"value": True}})
    yield PACK({"type": "GuiUpdateMessage", "uuid": uuid, "updates": [["value", True]]})
    yield PACK({"type": "GuiUpdateMessage", "uuid": uuid})
    yield PACK({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": True}, "more": 1})
    yield PACK({"type": ["GuiUpdateMessage"]})
    yield PACK(["GuiUpdateMessage", uuid])
    for name in ("wxyz", "position", "look_at", "up_direction"):
        for wrong in ([], [0.0] * 5, [np.nan] * 4, "wxyz", None, [[0.0]] * 3):
            yield PACK(CAMERA | {name: wrong})
    for name in ("fov", "near", "far", "image_height", "image_width"):
        for wrong in (np.nan, np.inf, "1", None, True):
            yield PACK(CAMERA | {name: wrong})
    yield PACK(CAMERA | {"image_height": 0})
    yield PACK(CAMERA | {"image_width": -1})
    yield PACK(CAMERA | {"position": [1e300, 0.0, 0.0]})
    yield PACK(CAMERA | {"position": CAMERA["look_at"]})
    yield PACK(CAMERA | {"up_direction": [0, 0, 0]})
    kinds: dict[str, dict[str, Any]] = {
        "ShareUrlRequest": {},
        "ShareUrlDisconnect": {},
        "CommandTriggerMessage": {"uuid": uuid},
        "GuiButtonHoldMessage": {"uuid": uuid, "frequency": 10.0},
        "GuiFormSubmitMessage": {"uuid": uuid},
        "GuiFormDirtyMessage": {"uuid": uuid},
        "FileTransferPart": {"transfer_uuid": "a", "part_index": 0, "content": b"a" * 1000},
        "RunJavascriptMessage": {"source": "alert(1)"},
        "GuiRemoveMessage": {"uuid": uuid},
        "GetRenderResponseMessage": {"payload": b"", "render_uuid": "a"},
        "NoSuchMessage": {},
        "Message": {},
    }
    for kind, fields in kinds.items():
        yield PACK({"type": kind, **fields})


def state_of(server: Any) -> list[Any]:
    """Return all that a message could have changed."""
    controls = server.gui._gui_input_handle_from_uuid
    return [
        (uuid, c._impl.value, vars(c._impl.props).copy(), c._impl.removed, len(c._impl.update_cb))
        for uuid, c in controls.items()
    ]


def test_200_malformed_messages_have_no_effect(
    server: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    page = LivePage(server, HOVER)
    faults: list[Exception] = []
    server.guard.on_fault(faults.append)
    before = state_of(server)
    with Visitor(address_of(server)) as visitor:
        visitor.look()
        wait_until(server.get_clients)
        count = 0
        for raw in malformed(server):
            visitor.send(raw)
            count += 1
        assert count >= 200
        wait_until(lambda: server.guard.dropped >= count)
        assert state_of(server) == before
        visitor.set(control(server, "Cut its thrust")._impl.uuid, True)
        wait_until(lambda: page.flight.notes)
        visitor.set(control(server, "pace")._impl.uuid, "half")
        wait_until(lambda: control(server, "pace").value == "half")
    assert [event["kind"] for event in page.flight.notes["events"]] == ["effectiveness"]
    assert server.guard.dropped == count
    assert faults == []
    assert capfd.readouterr() == ("", "")


def test_the_ends_of_a_slider_are_allowed_and_nothing_beyond(server: Any) -> None:
    slider = server.gui.add_slider("a", 0.0, 38.699999999999996, 0.1, 1.0)
    for value in (0, 0.0, 38.7, 12):
        assert _can_be(slider, value)
    for value in (-1e-3, 38.8, np.nan):
        assert not _can_be(slider, value)


@pytest.mark.parametrize("kind", ["live", "flight", "explorer"])
def test_every_control_of_every_page_is_one_that_is_checked(server: Any, kind: str) -> None:
    if kind == "live":
        LivePage(server, HOVER)
    elif kind == "flight":
        FlightPage(server, [Flight(om.fly(HOVER), "hover")])
    else:
        ExplorerPage(server, om.load_vehicle("omnimorph"))
    controls = list(server.gui._gui_input_handle_from_uuid.values())
    assert len(controls) >= 7
    for each in controls:
        is_button = isinstance(each, viser.GuiButtonHandle)
        assert _can_be(each, True if is_button else each.value), each.label
        assert not _can_be(each, object()), each.label


# --- whether it holds ---------------------------------------------------------------------------


def test_a_server_that_cannot_be_guarded_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    infra: Any = viser.infra._infra
    real = infra.websockets
    unwrapped = SimpleNamespace(**vars(real.asyncio.server))  # as if it opened its port otherwise
    other = SimpleNamespace(asyncio=SimpleNamespace(server=unwrapped), exceptions=real.exceptions)
    monkeypatch.setattr(infra, "websockets", other)
    with pytest.raises(InputError, match="the page is not served: viser"):
        new_server()


def test_a_viser_without_what_is_guarded_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    started = viser.ViserServer.__init__

    def otherwise(self: Any, *words: Any, **options: Any) -> None:
        started(self, *words, **options)
        self.controls = vars(self.gui).pop("_gui_input_handle_from_uuid")

    monkeypatch.setattr(viser.ViserServer, "__init__", otherwise)
    with pytest.raises(InputError, match="the page is not served: viser"):
        new_server()


def test_another_version_of_viser_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viser, "__version__", "1.2.0")
    with pytest.raises(InputError, match=r"needs viser 1\.1\.x, not 1\.2\.0"):
        new_server()


def test_the_version_that_is_asked_for_is_the_one_that_is_guarded() -> None:
    text = (Path(__file__).parents[2] / "pyproject.toml").read_text()
    wanted = tomllib.loads(text)["project"]["optional-dependencies"]["view"]
    assert "viser>=1.1.1,<1.2" in wanted
    lock = (Path(__file__).parents[2] / "requirements.lock").read_text()
    assert "viser==1.1." in lock
