"""Colours that everyone can distinguish: the palette of Okabe and Ito, and two scales."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph.results import palette

Colour = tuple[int, int, int]


def of_css(colour: str) -> Colour:
    """Return the colour that a style sheet writes as #rrggbb.

    Examples
    --------
    >>> of_css("#0072B2")
    (0, 114, 178)
    """
    red, green, blue = bytes.fromhex(colour[1:])
    return red, green, blue


INK: Colour = (45, 50, 58)
GREY: Colour = (150, 155, 162)
BLUE, SKY, GREEN, ORANGE, VERMILLION, PURPLE = (
    of_css(one)
    for one in (
        palette.BLUE,
        palette.SKY,
        palette.GREEN,
        palette.ORANGE,
        palette.VERMILLION,
        palette.PURPLE,
    )
)

_REST: Colour = (225, 228, 232)
# From dark blue over green to yellow, as light as they are large: dark is little.
_SEQUENCE = np.array(
    [(68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)], dtype=np.float64
)


def of_thrust(share: ArrayLike) -> NDArray[np.uint8]:
    """Return colours of thrusts, (n, 3): blue forwards, vermillion reversed, pale near zero.

    Parameters
    ----------
    share : (n,) array
        Of the largest thrust; −1 … 1.
    """
    signed = np.clip(np.asarray(share, dtype=np.float64), -1.0, 1.0)[:, None]
    full = np.where(signed >= 0.0, np.array(BLUE), np.array(VERMILLION))
    strength = np.sqrt(np.abs(signed))  # half of the colour at a quarter of the thrust
    return _rounded((1.0 - strength) * np.array(_REST) + strength * full)


def of_power(share: ArrayLike) -> NDArray[np.uint8]:
    """Return colours of powers, (K, 3): dark for the least, bright for the most; grey for none.

    Parameters
    ----------
    share : (K,) array
        0 for the least, 1 for the most; not finite where there is none.
    """
    value = np.asarray(share, dtype=np.float64)
    place = np.where(np.isfinite(value), np.clip(value, 0.0, 1.0), 0.0)
    stops = np.linspace(0.0, 1.0, len(_SEQUENCE))
    mixed = np.column_stack([np.interp(place, stops, channel) for channel in _SEQUENCE.T])
    return _rounded(np.where(np.isfinite(value)[:, None], mixed, np.array(_REST)))


def of_instances(colours: ArrayLike, count: int | None = None) -> NDArray[np.uint8]:
    """Return colours as viser takes those of instances and arrows: linear in the light, not sRGB.

    Parameters
    ----------
    colours : (n, 3) array, or (3,)
        As a style sheet has them, 0 to 255.
    count : int, optional
        Repeat one colour so often.
    """
    share = np.asarray(colours, dtype=np.float64) / 255.0
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return _rounded(255.0 * (linear if count is None else np.tile(linear, (count, 1))))


def css(colour: ArrayLike) -> str:
    """Return a colour as a style sheet writes it.

    Examples
    --------
    >>> css((0, 114, 178))
    '#0072b2'
    """
    return "#" + "".join(f"{int(channel):02x}" for channel in np.asarray(colour))


def _rounded(colours: NDArray[np.float64]) -> NDArray[np.uint8]:
    return np.rint(colours).astype(np.uint8)
