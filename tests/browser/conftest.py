"""A real Chromium without a window."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright
from tests.serving import Served, served

from omnimorph.viewer.pictures import browser as chromium

DESKTOP, PHONE = (1440, 900), (390, 844)


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
    """Run `omnimorph` with some words and open its page, all of whose messages must be taken."""
    with served(*words, folder=folder) as command:
        with opened(browser, command.url, size) as page:
            yield page, command
        if command.process.poll() is None:
            assert "had no effect" not in command.stopped()[2]


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
