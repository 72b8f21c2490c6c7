"""What is drawn in a figure, read back from it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimorph.protocols import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def panels_of(figure: Figure) -> list[Axes]:
    """Return the panels that are seen, in the order in which they were made."""
    return [panel for panel in figure.axes if panel.axison and panel.get_visible()]


def xy(line: Any) -> FloatArray:
    """Return the points of a line, (K, 2)."""
    return np.asarray(line.get_xydata(), dtype=np.float64)


def curves_of(panel: Axes) -> list[tuple[str, FloatArray]]:
    """Return the label and the points of each curve over time, in the order of drawing."""
    return [
        (str(line.get_label()), xy(line))
        for line in panel.lines
        if not str(line.get_label()).startswith("_child") and not is_level(line)
    ]


def is_level(line: Any) -> bool:
    """Tell a line that goes all the way across, like that of a limit, from a curve."""
    return bool(line.get_transform() == line.axes.get_yaxis_transform(which="grid"))


def levels_of(panel: Axes) -> list[float]:
    """Return where lines go all the way across, from below."""
    return sorted(float(xy(line)[0, 1]) for line in panel.lines if is_level(line))


def uprights_of(panel: Axes) -> list[float]:
    """Return where lines go all the way up, from the left."""
    upright = [one for one in panel.lines if one.get_transform() == _up(panel)]
    return sorted(float(xy(line)[0, 0]) for line in upright)


def _up(panel: Axes) -> Any:
    return panel.get_xaxis_transform(which="grid")


def spans_of(panel: Axes) -> list[tuple[float, float]]:
    """Return from where to where a panel is shaded from its bottom to its top."""
    shaded = [one for one in panel.patches if one.get_transform().contains_branch(_up(panel))]
    boxes = [one.get_extents().transformed(panel.transData.inverted()) for one in shaded]
    return sorted((float(box.x0), float(box.x1)) for box in boxes)


def assert_curves(panel: Axes, expected: list[tuple[str, FloatArray, FloatArray]]) -> None:
    """Hold that a panel draws these curves (label, time, values), all of them and no others."""
    drawn = curves_of(panel)
    assert [label for label, _ in drawn] == [label for label, *_ in expected]
    for (label, points), (_, time, values) in zip(drawn, expected, strict=True):
        shown = np.column_stack([time, values])
        np.testing.assert_allclose(points, shown, rtol=1e-12, atol=1e-12, err_msg=label)


def assert_legend(figure: Figure, *without: str) -> None:
    """Hold that a legend names whatever has a name in a panel, but some, and nothing else."""
    drawn: list[Any] = [
        one
        for panel in panels_of(figure)
        for one in (*panel.lines, *panel.patches, *panel.collections, *panel.containers)
    ]
    names = {str(one.get_label()) for one in drawn}
    named = {name for name in names if name and not name.startswith("_")}
    shown = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert set(shown) == named - set(without)
    assert len(shown) == len(set(shown))


def assert_in_sight(figure: Figure, *, floor: bool = False) -> None:
    """Hold that no point of a curve lies beyond its axes, or with a `floor` only below them."""
    for panel in panels_of(figure):
        for line in panel.lines:
            if line.get_transform() == panel.transData:
                points = xy(line)
                points = points[np.isfinite(points).all(axis=1)]
                for along, name in ((points[:, 0], "x"), (points[:, 1], "y")):
                    ends = panel.get_xlim() if name == "x" else panel.get_ylim()
                    low, high = sorted(ends)
                    room = 1e-9 * (high - low)
                    words = (panel.get_ylabel(), line.get_label(), name)
                    assert (along <= high + room).all(), words
                    assert (floor and name == "y") or (along >= low - room).all(), words


def number_in(text: str) -> int:
    """Return the first whole number in some words."""
    found = re.search(r"\d+", text)
    assert found is not None, text
    return int(found.group())
