"""A real Chromium without a window, and pages served by real processes."""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from omnimorph.viewer.pictures import browser as chromium

DESKTOP, PHONE = (1440, 900), (390, 844)


class Served(NamedTuple):
    """A command that serves a page: where, since when, and its process."""

    url: str
    seconds: float
    process: subprocess.Popen[str]

    def stopped(self) -> tuple[int, str, str]:
        """Press Ctrl-C; return the exit code and what it said."""
        self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=30)
        return self.process.returncode, out, err


@contextmanager
def served(*words: str, folder: Path) -> Iterator[Served]:
    """Run `omnimorph` with some words until its page is there."""
    began = time.monotonic()
    command = [sys.executable, "-m", "omnimorph", *words, "--port", "0", "--no-browser"]
    process = subprocess.Popen(
        command,
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # a shell may have told its background jobs to ignore Ctrl-C
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:
        yield Served(_address(process), time.monotonic() - began, process)
    finally:
        process.kill()
        process.communicate()


def _address(process: subprocess.Popen[str]) -> str:
    assert process.stderr is not None
    said = ""
    ends = time.monotonic() + 60.0
    while time.monotonic() < ends:
        if select.select([process.stderr], [], [], 0.5)[0]:
            line = os.read(process.stderr.fileno(), 4096).decode()
            if not line:
                break
            said += line
        found = re.search(r"the page is at (http://[\d.]+:\d+)", said)
        if found:
            return found[1]
    raise AssertionError(f"no page: {said}")


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    # Drawing in software, as where there is no GPU.
    options = ["--no-sandbox", "--enable-unsafe-swiftshader"]
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium(), args=options)
        yield started
        started.close()


@contextmanager
def viewed(
    browser: Browser, *words: str, folder: Path, size: tuple[int, int] = DESKTOP
) -> Iterator[tuple[Page, Served]]:
    """Run `omnimorph` with some words and open its page."""
    with served(*words, folder=folder) as command, opened(browser, command.url, size) as page:
        yield page, command


@contextmanager
def opened(browser: Browser, url: str, size: tuple[int, int] = DESKTOP) -> Iterator[Page]:
    """Open a page; no error may be told there."""
    page = browser.new_page(viewport={"width": size[0], "height": size[1]})
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda line: errors.append(line.text) if line.type == "error" else None)
    page.goto(url)
    try:
        yield page
        assert errors == []
    finally:
        page.close()
