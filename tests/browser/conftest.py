"""Pages opened in a real Chromium."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Page
from tests.serving import Served, served

DESKTOP, PHONE = (1440, 900), (390, 844)


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
    """Open a page; no error may be reported there."""
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
