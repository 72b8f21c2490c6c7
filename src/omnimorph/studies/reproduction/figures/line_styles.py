"""How the page draws each of the paper's flights, and what is not one of them."""

from __future__ import annotations

from omnimorph.report import style
from omnimorph.report.style import LineStyle
from omnimorph.studies.reproduction.flights import FIXED_A, FIXED_B, W3, A, B

DASHED, DOTTED = (0, (4.0, 1.2)), (0, (1.2, 1.2))
LINE_STYLES = {
    A: LineStyle(style.VERMILLION),
    B: LineStyle(style.BLUE, DASHED),
    W3: LineStyle(style.PURPLE),
    FIXED_A: LineStyle(style.GREEN),
    FIXED_B: LineStyle(style.PURPLE, DASHED),
}
ORDER = (
    LineStyle(style.BLACK),
    LineStyle(style.VERMILLION),
    LineStyle(style.BLUE, DASHED),
    LineStyle(style.GREEN, "-."),
    LineStyle(style.PURPLE, DOTTED),
)
"""Line styles of curves that are not cases."""
