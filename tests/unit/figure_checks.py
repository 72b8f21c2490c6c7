"""What must hold of every figure: its words lie apart and inside its frame."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

from omnimorph.report import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Text
    from matplotlib.transforms import Bbox


def laid_out(figure: Figure) -> Figure:
    """Return a figure whose ticks are made, and all of whose words have their places."""
    figure.set_dpi(72.0)  # that of SVG: ticks and places are those that readers see
    style.as_svg(figure)
    return figure


def boxes_of(figure: Figure) -> list[tuple[str, Bbox]]:
    """Return every text that is seen with its place, in points."""
    with style.house_style():  # letters are as wide as in what is kept
        return [(text.get_text(), text.get_window_extent()) for text in texts_of(figure)]


def texts_of(figure: Figure) -> list[Text]:
    """Return all texts that are seen, legends included: not those of ticks beyond an axis."""
    from matplotlib.text import Text

    beyond = [
        label
        for panel in figure.axes
        for axis in (panel.xaxis, panel.yaxis)
        for tick in axis.get_major_ticks()
        for label in (tick.label1, tick.label2)
        if not min(axis.get_view_interval()) <= tick.get_loc() <= max(axis.get_view_interval())
    ]
    hidden = [
        text for one in figure.axes if not one.get_visible() for text in one.findobj(Text)
    ] + [
        text
        for one in figure.axes
        if not one.axison
        for axis in (one.xaxis, one.yaxis)
        for text in axis.findobj(Text)
    ]
    left_out = {id(text) for text in (*beyond, *hidden)}
    shown = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text()]
    return [text for text in shown if id(text) not in left_out]


def overlaps(figure: Figure, least_gap: float = 0.0) -> list[tuple[str, str]]:
    """Return pairs of words that lie on one another, or so near (points) that they read as one."""
    found = []
    for (word, one), (other, two) in itertools.combinations(boxes_of(figure), 2):
        across = min(one.x1, two.x1) - max(one.x0, two.x0)
        along = min(one.y1, two.y1) - max(one.y0, two.y0)
        if across >= 1.0 - least_gap and along >= 1.0:
            found.append((word, other))
    return found


def cut_off(figure: Figure) -> list[str]:
    """Return the words that reach beyond the frame of a figure by more than half a point."""
    width, height = (72.0 * side for side in figure.get_size_inches())
    found = []
    for word, box in boxes_of(figure):
        if min(box.x0, width - box.x1, box.y0, height - box.y1) < -0.5:
            found.append(word)
    return found
