"""Pages of others in a real browser: none of them reaches a flight that is flown beside them."""

from __future__ import annotations

import http.server
import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
import viser
from playwright.sync_api import Browser, Page
from tests.browser.conftest import opened
from tests.serving import served

import omnimorph as om
from omnimorph.viewer.pictures import browser as chromium

pytestmark = pytest.mark.slow

# Knocks at an address as its own page does; tells whether the door was opened.
KNOCK = f"""(address) => new Promise((resolve) => {{
    const socket = new WebSocket(address.replace('http', 'ws'), ['viser-v{viser.__version__}']);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {{ socket.close(); resolve('opened'); }};
    socket.onerror = () => resolve('refused');
}})"""
READ = "(address) => fetch(address).then((answer) => answer.text()).then(() => 'read', () => 'not')"
EMBED = """(address) => new Promise((resolve) => {
    const frame = document.createElement('iframe');
    frame.onload = resolve;
    frame.src = address;
    document.body.append(frame);
})"""


class _Quiet(http.server.BaseHTTPRequestHandler):
    """Another page, empty but for what is tried on it."""

    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(b"<!doctype html><title>another page</title><body></body>")

    def log_message(self, *_: Any) -> None:
        pass


@pytest.fixture(scope="module")
def other_port() -> Iterator[int]:
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), _Quiet)
    threading.Thread(target=server.serve_forever).start()
    yield server.server_address[1]
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def rebound(browser: Browser) -> Iterator[Browser]:
    """A browser for which the name of a stranger is made to point here."""
    rules = "--host-resolver-rules=MAP evil.example 127.0.0.1"
    options = ["--no-sandbox", "--enable-unsafe-swiftshader", rules]
    started = browser.browser_type.launch(executable_path=chromium(), args=options)
    yield started
    started.close()


def is_embedded(page: Page, address: str) -> bool:
    """Embed an address in a page; tell whether it is shown there, and not an error instead."""
    page.evaluate(EMBED, address)
    (frame,) = page.frames[1:]
    for _ in range(100):
        if frame.url:
            break
        page.wait_for_timeout(100)
    return frame.url != "chrome-error://chromewebdata/"


def test_no_other_page_reaches_a_flight(
    browser: Browser, rebound: Browser, other_port: int, tmp_path: Path
) -> None:
    words = ("fly", "hover", "--view", "--out", "flown")
    with served(*words, folder=tmp_path) as command:
        port = urlsplit(command.url).port
        bare = f"http://127.0.0.1:{port}/"
        localhost = command.url.replace("127.0.0.1", "localhost")
        evil = command.url.replace("127.0.0.1", "evil.example")
        for started, host in (
            (browser, "127.0.0.1"),
            (browser, "localhost"),
            (rebound, "evil.example"),
        ):
            page = started.new_page()
            page.goto(f"http://{host}:{other_port}/")
            # Even if it had guessed the address: where a page comes from is looked at as well.
            for address in (bare, command.url, localhost, evil):
                if started is browser and address == evil:
                    continue
                assert page.evaluate(KNOCK, address) == "refused", (host, address)
                assert page.evaluate(READ, address) == "not", (host, address)
            assert not is_embedded(page, command.url)
            page.close()
        stranger = rebound.new_page()
        for address in (evil, f"http://evil.example:{port}/", bare):
            answer = stranger.goto(address)
            assert answer is not None
            assert (answer.status, answer.text()) == (403, "Forbidden.\n")
        stranger.close()
        with opened(browser, command.url) as page:
            page.wait_for_selector("#notices")
            assert page.evaluate(KNOCK, command.url) == "opened"
            page.locator("#notices", has_text="The flight was completed.").wait_for(timeout=60_000)
        out, err = command.process.communicate(timeout=60)
    assert command.process.returncode == 0
    assert "The flight was completed." in out
    assert "had no effect" not in err
    assert "Traceback" not in err
    run = om.load_run(tmp_path / "flown" / "run.nc")
    assert "events" not in json.loads(run.provenance.scenario_text)
