"""How figures look: sizes for print, colours everyone can distinguish, and how they are kept.

Figures are as wide as the text of an A4 page (7.0 in), so that nothing is scaled in print and no
letter is smaller than 8 pt. The palette is that of Okabe and Ito; curves also differ by their line.
"""

from __future__ import annotations

import functools
import io
import re
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec

from omnimorph.results.atomic import replacing, write_text
from omnimorph.results.palette import BLUE, GREEN, PURPLE, VERMILLION, YELLOW
from omnimorph.results.run import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "BLACK",
    "BLUE",
    "COLUMNS",
    "GREEN",
    "GREY",
    "INTERLEAVED",
    "LIMIT",
    "PURPLE",
    "SILVER",
    "VEIL",
    "VERMILLION",
    "WIDTH",
    "YELLOW",
    "Flight",
    "LineStyle",
    "as_svg",
    "house_style",
    "legend_above",
    "legend_entries",
    "new_figure",
    "plain",
    "save_figure",
    "save_svg",
    "styled",
]

Options = ParamSpec("Options")

BLACK, GREY, SILVER = "#000000", "#767676", "#bdbdbd"
INTERLEAVED: tuple[Any, ...] = ((0.0, (3.0, 3.0)), (3.0, (3.0, 3.0)))
"""Two dashed lines: where one lies on the other, the dashes of each fill the gaps of the other."""
LIMIT: dict[str, Any] = {"color": GREY, "linestyle": (0, (1.5, 2.0)), "linewidth": 1.0, "zorder": 1}
"""How a limit is drawn."""
VEIL: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "alpha": 0.6, "pad": 0.6}
"""What stands between words and the lines behind them."""

WIDTH = 7.0
"""Of every figure, inches."""
COLUMNS = 720
"""Pixel columns of a curve across a whole figure: about 120 dots per inch."""

_SETTINGS: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.labelsize": 8.5,
    "axes.titlesize": 9.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.5,
    "axes.linewidth": 0.6,
    "axes.edgecolor": "#444444",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.2,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.frameon": False,
    "text.hinting": "no_hinting",  # letters as wide in the layout as in what is kept
    "svg.fonttype": "path",
    "svg.hashsalt": "omnimorph",
    "path.simplify_threshold": 0.2,
}
# Only coordinates are rounded: a glyph's scale, 0.015625, stands in a `transform`.
_COORDINATES = re.compile(r'(?<= )(?:d|x|y|width|height)="[^"]*"')
_LONG_NUMBER = re.compile(r"-?\d+\.\d{3,}")


@dataclass(frozen=True)
class LineStyle:
    """How one flight is drawn, everywhere in a report: colour, line, mark, and width in points."""

    colour: str
    line: Any = "-"
    mark: str = "o"
    width: float = 1.2


@dataclass(frozen=True)
class Flight:
    """A run with the name and the style of line it has in a report."""

    label: str
    run: Run
    line_style: LineStyle


def styled(draw: Callable[Options, Figure]) -> Callable[Options, Figure]:
    """Let a function that draws a figure draw it in the house style, whatever the user's own is."""

    @functools.wraps(draw)
    def draw_in_style(*args: Options.args, **kwargs: Options.kwargs) -> Figure:
        with house_style():
            figure = draw(*args, **kwargs)
            engine = figure.get_layout_engine()
            if engine is not None:
                # Once is enough: from here on every drawing of the figure uses this layout.
                engine.execute(figure)
                figure.set_layout_engine(None)
        return figure

    return draw_in_style


def new_figure(
    height: float, rows: int = 1, columns: int = 1, **options: Any
) -> tuple[Figure, Any]:
    """Return a figure of `height` inches and its (rows, columns) array of axes.

    Without pyplot: nothing is global, no window system is looked for. To be called by a function
    that is `styled`.

    Parameters
    ----------
    height : float
        In inches; the width is `WIDTH`.
    rows, columns : int
        Of the grid of axes; no rows, no axes.
    options
        Handed to ``Figure.subplots``.
    """
    from matplotlib.figure import Figure as NewFigure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    layout = ConstrainedLayoutEngine(w_pad=0.03, h_pad=0.03)
    figure = NewFigure(figsize=(WIDTH, height), layout=layout)
    return figure, figure.subplots(rows, columns, squeeze=False, **options) if rows else None


def legend_entries(panels: Sequence[Axes]) -> tuple[list[Any], list[str]]:
    """Return handles and labels of all curves in some panels."""
    found = [panel.get_legend_handles_labels() for panel in panels]
    return [h for handles, _ in found for h in handles], [x for _, labels in found for x in labels]


def legend_above(
    figure: Figure,
    handles: list[Any],
    labels: list[str],
    where: Any = "outside upper left",
    columns: int = 6,
) -> None:
    """Put one legend beside all panels, in rows, where it covers nothing; each label once."""
    once = dict(zip(reversed(labels), reversed(handles), strict=True))
    names = list(dict.fromkeys(labels))
    figure.legend(
        [once[name] for name in names],
        names,
        loc=where,
        ncols=columns,
        columnspacing=1.6,
        handlelength=2.4,
        borderpad=0.1,
        borderaxespad=0.4,
    )


def plain(value: float, _: Any = None) -> str:
    """Return a number as an axis shows it: in full if that is short, else as a power of ten.

    To be handed to ``set_major_formatter``, which also passes the number of the tick.

    Examples
    --------
    >>> plain(0.001), plain(20.0), plain(1e-5), plain(3e-5)
    ('0.001', '20', '10⁻⁵', '3·10⁻⁵')
    """
    if 0.99e-4 < abs(value) < 1e5 or value == 0.0:
        return f"{value:g}"
    digits, _, exponent = f"{value:.0e}".partition("e")
    raised = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"10{raised}" if digits == "1" else f"{digits}·10{raised}"


def as_svg(figure: Figure) -> str:
    """Return a figure as the text of an SVG element: letters as outlines, numbers to 1/100 pt.

    The same figure gives the same text: no date, no random names.
    """
    text = _drawn(figure, "svg").decode()
    text = text[text.index("<svg") :]
    return _COORDINATES.sub(lambda found: _LONG_NUMBER.sub(_rounded, found.group()), text)


def save_svg(figure: Figure, folder: Path, name: str) -> str:
    """Write ``name.svg`` into a folder, as a whole; return the SVG element.

    Raises
    ------
    RunFileError
        If it cannot be written.
    """
    svg = as_svg(figure)
    write_text(folder / f"{name}.svg", '<?xml version="1.0" encoding="utf-8"?>\n' + svg)
    return svg


def save_figure(figure: Figure, folder: Path, name: str, *, draft: bool = False) -> str:
    """Write ``name.svg`` and ``name.pdf`` into a folder, each as a whole; return the SVG element.

    The PDF holds its font, as publishers ask; a draft holds the outlines of letters (Type 3), which
    is three times as fast.

    Raises
    ------
    RunFileError
        If one cannot be written.
    """
    svg = save_svg(figure, folder, name)
    with replacing(folder / f"{name}.pdf") as temporary:
        temporary.write_bytes(_drawn(figure, "pdf", 3 if draft else 42))
    return svg


def _rounded(found: re.Match[str]) -> str:
    return f"{float(found.group()):.2f}".rstrip("0").rstrip(".")


def _drawn(figure: Figure, kind: str, fonts: int = 42) -> bytes:
    undated = {"Date": None} if kind == "svg" else {"CreationDate": None}
    page = io.BytesIO()
    with house_style(fonts):
        figure.savefig(page, format=kind, metadata=undated, facecolor="white")
    return page.getvalue()


def house_style(fonts: int = 42) -> AbstractContextManager[None]:
    """Return a context in which nothing of the user's own style is left."""
    import matplotlib.style

    return matplotlib.style.context(["default", _SETTINGS | {"pdf.fonttype": fonts}])
