"""The paper's printed F beside A(α): every entry as a formula, and which of them differ.

An entry is a sum of products: of c = cos α or s = sin α, alone (a force), times the half-edge L (a
lever arm) or times k = c_τ/c_f (drag). Two entries are equal if their factors are.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from omnimorph.design.vehicle import Vehicle
from omnimorph.studies.reproduction import paper

Factors = dict[str, int]
"""Of c, s, Lc, Ls, kc and ks; what is not there is zero."""

_SYMBOLS = ("c", "s", "Lc", "Ls", "kc", "ks")
_TERMS = {"c": "c", "s": "s", "Lc": "L c", "Ls": "L s", "kc": "κ c", "ks": "κ s"}


class Entry(NamedTuple):
    """One entry: as the paper prints it, as it is, and whether these are the same."""

    printed: str
    ours: str
    same: bool


class PrintedMatrix(NamedTuple):
    """The comparison: six rows of eight entries, in the paper's order of columns.

    `rotors` says which rotor of the catalogue's vehicle, from 0, each column is.
    """

    rotors: tuple[int, ...]
    entries: tuple[tuple[Entry, ...], ...]

    @property
    def misprints(self) -> list[tuple[int, int]]:
        """Row and column, from 1, of every entry that differs."""
        return [
            (i + 1, j + 1)
            for i, row in enumerate(self.entries)
            for j, entry in enumerate(row)
            if not entry.same
        ]


def compare_printed_matrix(vehicle: Vehicle, half_edge: float) -> PrintedMatrix:
    """Compare the paper's printed matrix with that of a vehicle whose hubs are a cube's vertices.

    The paper numbers the columns of F otherwise than its vertices: each is taken to be the rotor
    from which it differs in the fewest entries.

    Parameters
    ----------
    vehicle : Vehicle
        With one servo, hubs at ``(±L, ±L, ±L)``.
    half_edge : float, m
        L.
    """
    printed = [[factors_of(text) for text in row] for row in paper.printed_matrix()]
    ours = _factors_of_map(vehicle, half_edge)
    rotors = tuple(_nearest([row[j] for row in printed], ours) for j in range(len(printed[0])))
    entries = tuple(
        tuple(
            Entry(as_text(row[j]), as_text(ours[rotor][i]), row[j] == ours[rotor][i])
            for j, rotor in enumerate(rotors)
        )
        for i, row in enumerate(printed)
    )
    return PrintedMatrix(rotors, entries)


def factors_of(text: str) -> Factors:
    """Return the factors of a formula.

    Examples
    --------
    >>> factors_of("-Lc + ks"), factors_of("0")
    ({'Lc': -1, 'ks': 1}, {})
    """
    terms = re.findall(r"([+-]?)\s*([Lk]?[cs])", text)
    return {symbol: -1 if sign == "-" else 1 for sign, symbol in terms}


def as_text(factors: Factors) -> str:
    """Return factors as print sets them.

    Examples
    --------
    >>> as_text({"ks": 1, "Lc": -1}), as_text({})
    ('−L c + κ s', '0')
    """
    text = ""
    for symbol in _SYMBOLS:
        factor = factors.get(symbol, 0)
        if factor:
            sign = "−" if factor < 0 else "+"
            text += f" {sign} {_TERMS[symbol]}" if text else sign.replace("+", "") + _TERMS[symbol]
    return text or "0"


def _factors_of_map(vehicle: Vehicle, half_edge: float) -> list[list[Factors]]:
    """Return for each rotor the six entries of its column of A, from p × z − k κ z."""
    columns = []
    _, zC, zS = vehicle.thrust_axis_parts
    for hub, spin, cosine, sine in zip(
        vehicle.rotor_position / half_edge, vehicle.rotor_spin, zC, zS, strict=True
    ):
        forces = [{"c": cosine[r], "s": sine[r]} for r in range(3)]
        arms = {"Lc": np.cross(hub, cosine), "Ls": np.cross(hub, sine)}
        drags = {"kc": -spin * cosine, "ks": -spin * sine}
        torques = [{key: part[r] for key, part in (arms | drags).items()} for r in range(3)]
        columns.append([_whole(entry) for entry in forces + torques])
    return columns


def _whole(entry: dict[str, float]) -> Factors:
    return {key: round(value) for key, value in entry.items() if round(value)}


def _nearest(column: list[Factors], ours: list[list[Factors]]) -> int:
    misses = [sum(a != b for a, b in zip(column, candidate, strict=True)) for candidate in ours]
    return int(np.argmin(misses))
