"""Colours that everyone can distinguish: the palette of Okabe and Ito, as in style sheets."""

from __future__ import annotations

BLUE, SKY, GREEN, ORANGE = "#0072B2", "#56B4E9", "#009E73", "#E69F00"
VERMILLION, PURPLE, YELLOW = "#D55E00", "#CC79A7", "#F0E442"

OF_UNITS = {"m": BLUE, "m/s": SKY, "rad": PURPLE, "rad/s": GREEN, "N": ORANGE, "W": VERMILLION}
"""How a quantity is drawn where nothing else stands beside it; blue, if it is none of these."""
