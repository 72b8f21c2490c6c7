"""How a page lies on a screen: what is cut, what overflows, and whether a sign says so."""

from __future__ import annotations

import re
from typing import NamedTuple

from playwright.sync_api import Page

_EDGE = 6  # pixels at the right of a box in which its sign shows
# Boxes that scroll, each with what it holds; what reaches beyond the page and is in none of them.
_LOOK = """() => {
    const width = document.documentElement.clientWidth;
    const scrolls = (e) => ['auto', 'scroll'].includes(getComputedStyle(e).overflowX);
    const boxes = [...document.querySelectorAll('body *')].filter(scrolls);
    boxes.forEach((e, number) => { e.dataset.number = number; });
    const named = (e) => (e.querySelector('caption')?.innerText
        || e.getAttribute('aria-label') || e.innerText).slice(0, 60);
    const loose = (e) => {
        for (let up = e.parentElement; up; up = up.parentElement)
            if (scrolls(up)) return false;
        return true;
    };
    return {
        width: width,
        page: document.documentElement.scrollWidth,
        boxes: boxes.map((e, number) => ({
            number: number,
            name: named(e),
            hidden: e.scrollWidth - e.clientWidth,
            free: width - e.getBoundingClientRect().right,
        })),
        beyond: [...document.querySelectorAll('main *')]
            .filter((e) => e.getBoundingClientRect().right > width + 1 && loose(e))
            .map((e) => e.tagName + ' ' + (e.innerText || '').slice(0, 60)),
    };
}"""
_OPEN = "document.querySelectorAll('details').forEach((one) => { one.open = true; })"
# Where the edge of a box is on the screen, once its background is set and it is scrolled there.
_SHOW = """(box, background) => {
    box.style.background = background;
    box.scrollLeft = 0;
    box.scrollIntoView({block: 'center'});
    const at = box.getBoundingClientRect();
    const top = Math.max(at.top, 0);
    return [at.right, top, Math.min(at.bottom, innerHeight) - top];
}"""


# Every caption with the heading that stands above it.
_CAPTIONS = """() => {
    const found = [];
    let heading = '';
    for (const e of document.querySelectorAll('h2, h3, caption, figcaption'))
        if (e.tagName.startsWith('H')) heading = e.innerText;
        else found.push([heading, e.innerText]);
    return found;
}"""
_EMPTY = {
    "a",
    "all",
    "and",
    "are",
    "as",
    "at",
    "by",
    "each",
    "every",
    "is",
    "it",
    "its",
    "not",
    "of",
    "or",
    "that",
    "the",
    "to",
    "with",
}


class Cut(NamedTuple):
    """A box of which a part is hidden: its number and name, how much (px), what is free beside."""

    number: int
    name: str
    hidden: float
    free: float


class Layout(NamedTuple):
    """What was found on a page: its overflow (px), what reaches beyond it, boxes that are cut."""

    overflow: float
    beyond: list[str]
    cut: list[Cut]


def layout_of(page: Page) -> Layout:
    """Return how a page lies, with all that it can unfold unfolded."""
    page.evaluate(_OPEN)
    found = page.evaluate(_LOOK)
    cut = [
        Cut(one["number"], one["name"], one["hidden"], one["free"])
        for one in found["boxes"]
        if one["hidden"] > 1
    ]
    return Layout(found["page"] - found["width"], found["beyond"], cut)


def without_sign(page: Page, cut: list[Cut]) -> list[str]:
    """Return the names of cut boxes at whose right edge nothing shows that there is more.

    The sign is the background: the edge looks another way without it.
    """
    found = []
    for one in cut:
        box, edges = page.locator(f'[data-number="{one.number}"]'), []
        for background in ("none", ""):
            x, y, height = box.evaluate(_SHOW, background)
            edges.append(
                page.screenshot(clip={"x": x - _EDGE, "y": y, "width": _EDGE, "height": height})
            )
        if edges[0] == edges[1]:
            found.append(one.name)
    return found


def repeated(page: Page) -> list[str]:
    """Return the captions that say hardly more than the heading above them."""
    pairs = page.evaluate(_CAPTIONS)
    more = {caption: words_of(caption) - words_of(heading) for heading, caption in pairs}
    return [caption for caption, words in more.items() if len(words) < 3]


def words_of(text: str) -> set[str]:
    """Return the words of a text that say something."""
    return {word for word in re.findall(r"\w+", text.lower()) if word not in _EMPTY}


def faults_of(page: Page) -> list[str]:
    """Return what is wrong with how a page lies on its screen, in words.

    Nothing overflows the page; what is cut scrolls in a box with a sign, and only where there is no
    free space beside the box that it could take.
    """
    found = layout_of(page)
    faults = (
        [f"the page is {found.overflow} px wider than the screen"] if found.overflow > 0 else []
    )
    faults += [f"beyond the page: {name}" for name in found.beyond]
    for one in found.cut:
        if one.free > 24.0:
            faults.append(f"{one.name}: {one.hidden} px hidden, {one.free} px free beside it")
    return faults + [f"{name}: cut, and no sign" for name in without_sign(page, found.cut)]
