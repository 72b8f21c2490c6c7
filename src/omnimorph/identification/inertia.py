"""Mass, centre of mass and inertia of a vehicle made of boxes, cylinders and point masses.

Each part has an inertia J_P about its own centre, in its own axes. With its orientation R_BP and
its place p from the common centre of mass, it adds ``R J_P Rᵀ + m (|p|² 1 − p pᵀ)``: Steiner.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from omnimorph.design.ranges import Range
from omnimorph.design.records import Record, quantity
from omnimorph.errors import InputError
from omnimorph.protocols import FloatArray

__all__ = ["PARTS", "Box", "Cylinder", "MassProperties", "Part", "PointMass"]

_MASS = "a positive number of kilograms"
_PLACE = "three finite numbers [x, y, z] in metres"
_ANGLES = "three finite angles [roll, pitch, yaw]"
_LENGTH = "zero or a positive number of metres"
_SIZES = Range(0.0, 1e4)
_ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class PointMass(Record):
    """A mass in one place, or a body too small to matter.

    Attributes
    ----------
    mass : float, kg
        Above 0.
    position : (3,), m
        Of the part's centre.

    Raises
    ------
    InputError
        If a number is not as said; so do all parts.
    """

    kind: ClassVar[str] = "point"
    mass: float = quantity("kg", Range(1e-9, 1e6), _MASS)
    position: tuple[float, ...] = quantity("m", Range(-1e4, 1e4), _PLACE, length=3, default=_ORIGIN)

    def own_inertia(self) -> FloatArray:
        """Return the (3, 3) inertia about the part's centre, kg m², in the common axes."""
        return np.zeros((3, 3))


@dataclass(frozen=True, kw_only=True)
class Box(PointMass):
    """A uniform box, or a plate or rod if a side is zero.

    Attributes
    ----------
    size : (3,), m
        Along its own x, y and z.
    orientation : (3,), rad
        Roll, pitch and yaw: R = R_z(yaw) R_y(pitch) R_x(roll) turns its axes from the common ones.

    Examples
    --------
    >>> Box(mass=12.0, size=(1.0, 2.0, 3.0)).own_inertia().diagonal().tolist()
    [13.0, 10.0, 5.0]
    """

    kind: ClassVar[str] = "box"
    size: tuple[float, ...] = quantity("m", _SIZES, "three numbers of metres", length=3)
    orientation: tuple[float, ...] = quantity(
        "deg", Range(-1e5, 1e5), _ANGLES, length=3, default=_ORIGIN
    )

    def own_inertia(self) -> FloatArray:
        """Return m/12 diag(b² + c², a² + c², a² + b²), turned, kg m²."""
        squares = np.square(self.size)
        return _turned(np.diag(self.mass / 12.0 * (squares.sum() - squares)), self.orientation)


@dataclass(frozen=True, kw_only=True)
class Cylinder(PointMass):
    """A uniform cylinder whose axis is its own z; a tube if it has an inner radius.

    Attributes
    ----------
    radius, length : float, m
        Not negative.
    inner_radius : float, m
        From 0 to `radius`; 0 by default.
    orientation : (3,), rad
        Roll, pitch and yaw, as for `Box`: ``(0, π/2, 0)`` lays the axis along x.

    Examples
    --------
    >>> Cylinder(mass=12.0, radius=1.0, length=2.0).own_inertia().diagonal().tolist()
    [7.0, 7.0, 6.0]
    """

    kind: ClassVar[str] = "cylinder"
    radius: float = quantity("m", _SIZES, _LENGTH)
    length: float = quantity("m", _SIZES, _LENGTH)
    inner_radius: float = quantity("m", _SIZES, _LENGTH, default=0.0)
    orientation: tuple[float, ...] = quantity(
        "deg", Range(-1e5, 1e5), _ANGLES, length=3, default=_ORIGIN
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.inner_radius > self.radius:
            allowed = f"at most the radius, {self.radius:g} m"
            raise InputError.at(self.kind, "inner_radius", self.inner_radius, allowed)

    def own_inertia(self) -> FloatArray:
        """Return m diag(3q + l², 3q + l², 6q)/12 with q = r² + r_inner², turned, kg m²."""
        round_part = self.radius**2 + self.inner_radius**2
        across = self.mass / 12.0 * (3.0 * round_part + self.length**2)
        along = self.mass / 2.0 * round_part
        return _turned(np.diag([across, across, along]), self.orientation)


Part = PointMass | Box | Cylinder
PARTS: tuple[type[Part], ...] = (Box, Cylinder, PointMass)
"""Every kind of part."""


@dataclass(frozen=True, eq=False, kw_only=True)
class MassProperties:
    """What a rigid body is to mechanics.

    Attributes
    ----------
    mass : float, kg
    centre : (3,) array, m
        Its centre of mass, in the axes of the parts.
    inertia : (3, 3) array, kg m²
        About the centre of mass, in the same axes.
    """

    mass: float
    centre: FloatArray
    inertia: FloatArray

    @property
    def is_solid(self) -> bool:
        """Whether every principal moment is positive, as a vehicle needs."""
        moments = np.linalg.eigvalsh(self.inertia)
        return bool(moments[0] > 1e-12 * moments[-1])


def _turned(inertia: FloatArray, orientation: Sequence[float]) -> FloatArray:
    """Return R J Rᵀ with R of roll, pitch and yaw, exactly symmetric."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in orientation)
    roll = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    pitch = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    yaw = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    R = yaw @ pitch @ roll
    turned = R @ inertia @ R.T
    symmetric: FloatArray = 0.5 * (turned + turned.T)
    return symmetric
