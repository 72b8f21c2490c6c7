"""How the page calls things, and how it writes numbers over seeds."""

from __future__ import annotations

import math

from omnimorph.report.tables import number
from omnimorph.studies.reproduction.flights import FIXED_A, FIXED_B, W3, A, B
from omnimorph.studies.reproduction.spread import Spread

FLIGHT_LABELS = {
    A: "Case A",
    B: "Case B",
    W3: "Case B, W3 × 10",
    FIXED_A: "fixed 45°, A's weights",
    FIXED_B: "fixed 45°, B's weights",
}
"""What a reader calls each of the paper's flights."""


def spread_text(spread: Spread, factor: float = 1.0) -> str:
    """Return a mean with its 95 % interval, and the range in brackets.

    Examples
    --------
    >>> spread_text(Spread(1.234, 1.19, 1.28, 0.021, 20, 20))
    '1.23 ± 0.02 (1.19 … 1.28)'
    >>> spread_text(Spread(1.234, 1.19, 1.28, 0.021, 20, 18))
    '1.23 ± 0.02 (1.19 … 1.28), 18 of 20'
    >>> spread_text(Spread(math.nan, math.nan, math.nan, math.nan, 2, 0))
    'none of 2'
    """
    if spread.completed == 0:
        return f"none of {spread.flights}"
    mean, low, high, half = (
        factor * value for value in (spread.mean, spread.low, spread.high, spread.half_width)
    )
    text = number(mean)
    if half > 0.0:
        decimals = _decimals(half)
        shown = [f"{value:.{decimals}f}" for value in (mean, half, low, high)]
        text = "{} ± {} ({} … {})".format(*shown)
    return _with_count(text, spread)


def mean_text(spread: Spread, factor: float = 1.0) -> str:
    """Return a mean with half of its 95 % interval, rounded up, to four digits at most.

    Examples
    --------
    >>> mean_text(Spread(10.852, 10.80, 10.91, 0.0131, 20, 20))
    '10.85 ± 0.02'
    >>> mean_text(Spread(0.050394, 0.05, 0.051, 5.2e-6, 20, 20), 1e3)
    '50.39 ± 0.01'
    """
    if spread.completed == 0:
        return f"none of {spread.flights}"
    mean, half_width = factor * spread.mean, factor * spread.half_width
    if not half_width > 0.0:
        return number(mean, 3)
    decimals = min(_decimals(half_width), max(3 - math.floor(math.log10(mean)), 0))
    half_width = math.ceil(half_width * 10**decimals) / 10**decimals
    return _with_count(f"{mean:.{decimals}f} ± {half_width:.{decimals}f}", spread)


def _with_count(text: str, spread: Spread) -> str:
    """Return a number with how many flights it is of, if that is not all."""
    if spread.completed < spread.flights:
        text += f", {spread.completed} of {spread.flights}"
    return text.replace("-", "−")


def with_unit(number_words: str, unit: str) -> str:
    """Return a number with its unit as print sets it: degrees stand close.

    Examples
    --------
    >>> with_unit("37", "°"), with_unit("11", "mm"), with_unit("4", "")
    ('37°', '11 mm', '4')
    """
    return f"{number_words}{unit}" if unit.startswith("°") else f"{number_words} {unit}".strip()


def difference_text(share: float | None) -> str:
    """Return a difference in per cent, or as a factor where it is large; a dash if there is none.

    Examples
    --------
    >>> difference_text(-0.042), difference_text(-0.982), difference_text(1.13)
    ('−4.2 %', '56 × smaller', '2.1 × larger')
    """
    if share is None:
        return "—"
    if -1.0 < share < -0.5:
        return f"{1 / (1 + share):.2g} × smaller"
    if share > 1.0:
        return f"{1 + share:.1f} × larger"
    return "none" if abs(share) < 5e-5 else f"{100 * share:+.1f} %".replace("-", "−")


def _decimals(size: float) -> int:
    """Return how many decimals show one digit of a number of that size."""
    return min(max(-math.floor(math.log10(size)), 0), 9)
