"""How the page draws each of the paper's flights, and what is not one of them."""

from __future__ import annotations

from omnimorph.report import style
from omnimorph.report.style import Look
from omnimorph.studies.reproduction.flights import FIXED_A, FIXED_B, W3, A, B

__all__ = ["DASHED", "DOTTED", "LOOKS", "ORDER"]

DASHED, DOTTED = (0, (4.0, 1.2)), (0, (1.2, 1.2))
LOOKS = {
    A: Look(style.VERMILLION),
    B: Look(style.BLUE, DASHED),
    W3: Look(style.PURPLE),
    FIXED_A: Look(style.GREEN),
    FIXED_B: Look(style.PURPLE, DASHED),
}
ORDER = (
    Look(style.BLACK),
    Look(style.VERMILLION),
    Look(style.BLUE, DASHED),
    Look(style.GREEN, "-."),
    Look(style.PURPLE, DOTTED),
)
"""Looks of curves that are not cases."""
