"""How fast the pages are on this machine: `python -m tests.browser.measure`."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from playwright.sync_api import Page, sync_playwright
from tests.browser.conftest import opened
from tests.serving import served

import omnimorph as om
from omnimorph.viewer.pictures import browser as chromium

FRAMES = """async (seconds) => {
    const end = performance.now() + 1000 * seconds;
    let frames = 0;
    while (performance.now() < end) {
        await new Promise(requestAnimationFrame);
        frames += 1;
    }
    return frames / seconds;
}"""
# From a key that moves a slider by one step to the new number on the page, ms.
LATENCY = """async ([slider, number]) => {
    const shown = document.querySelector(number);
    const before = shown.innerText;
    const began = performance.now();
    const key = {key: 'ArrowRight', code: 'ArrowRight', keyCode: 39, bubbles: true};
    slider.dispatchEvent(new KeyboardEvent('keydown', key));
    while (document.querySelector(number).innerText == before) {
        await new Promise((resolve) => setTimeout(resolve, 1));
        if (performance.now() - began > 5000) return NaN;
    }
    return performance.now() - began;
}"""


def main() -> None:
    """Print what the pages take."""
    folder = Path(tempfile.mkdtemp(prefix="omnimorph-"))
    om.fly(om.load_scenario("paper-case-a")).save(folder / "a.nc")
    with sync_playwright() as playwright:
        options = ["--no-sandbox", "--enable-unsafe-swiftshader"]
        browser = playwright.chromium.launch(executable_path=chromium(), args=options)
        for words, number in ((("view", "a.nc"), "#time"), (("view", "omnimorph"), "#weight")):
            began = time.monotonic()
            with served(*words, folder=folder) as command, opened(browser, command.url) as page:
                page.wait_for_selector(number)
                ready = time.monotonic() - began
                served_after = f"served after {command.seconds:.2f} s"
                print(f"{' '.join(words)}: {served_after}, shown after {ready:.2f} s")
                page.wait_for_timeout(3000)
                if number == "#time":
                    page.get_by_role("button", name="Play").click()
                    page.wait_for_timeout(1000)
                    print(f"  frames a second while it plays: {page.evaluate(FRAMES, 6):.1f}")
                else:
                    _print_latency(page)
        browser.close()


def _print_latency(page: Page) -> None:
    slider = page.get_by_role("slider").first
    for _ in range(3):
        slider.press("ArrowRight")
        page.wait_for_timeout(300)
    handle = slider.element_handle()
    times = []
    for _ in range(15):
        times.append(page.evaluate(LATENCY, [handle, "#force-radius"]))
        page.wait_for_timeout(200)
    times.sort()
    low, middle, high = times[0], times[7], times[-1]
    print(f"  slider to new numbers: median {middle:.0f} ms, from {low:.0f} to {high:.0f}")


if __name__ == "__main__":
    main()
