"""Mass, centre of mass and inertia of a vehicle made of boxes, cylinders and point masses.

Each part has an inertia J_P about its own centre, in its own axes. With its orientation R_BP and
its place p from the common centre of mass, it adds ``R J_P Rᵀ + m (|p|² 1 − p pᵀ)``: Steiner.

Parts may stand in a TOML file::

    [[part]]
    kind = "box"                          # or "cylinder", "point"
    mass_kg = 0.45
    size_m = [0.12, 0.08, 0.03]
    position_m = [0.0, 0.0, 0.01]         # of its centre; the origin if left out
    orientation_deg = [0.0, 0.0, 45.0]    # roll, pitch, yaw; none if left out
    name = "battery"                      # for you
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, reduce
from operator import or_
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from omnimorph.design.documents import check_document, parse_toml
from omnimorph.design.input_files import read_text
from omnimorph.design.ranges import Range
from omnimorph.design.records import Record, quantity
from omnimorph.errors import InputError
from omnimorph.protocols import FloatArray

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


PartsLike = Sequence[Part] | str | os.PathLike[str]
"""Parts, or the file of them."""


def assemble(parts: PartsLike) -> MassProperties:
    """Return mass, centre of mass and inertia of parts that are fixed to one another.

    Parameters
    ----------
    parts : sequence of Box, Cylinder or PointMass, str or path
        At least one, all placed in the same axes; or the file of `load_parts` that holds them.

    Returns
    -------
    MassProperties
        ``Σ R J_P Rᵀ + m (|p|² 1 − p pᵀ)``, p from the common centre of mass.

    Raises
    ------
    InputError
        If there is no part, or what is given is none.

    Examples
    --------
    A dumbbell: two masses of 1 kg, 2 m apart, which has no inertia about its own line.

    >>> from omnimorph.identification import PointMass
    >>> ends = [PointMass(mass=1.0, position=(x, 0.0, 0.0)) for x in (0.0, 2.0)]
    >>> body = assemble(ends)
    >>> body.mass, body.centre.tolist(), body.inertia.diagonal().tolist(), body.is_solid
    (2.0, [1.0, 0.0, 0.0], [0.0, 2.0, 2.0], False)
    """
    body = load_parts(parts) if isinstance(parts, str | os.PathLike) else parts
    if not isinstance(body, Sequence) or not all(isinstance(part, PARTS) for part in body):
        allowed = "a sequence of Box, Cylinder or PointMass, or the file of one"
        raise InputError.at("the call", "parts", body, allowed)
    if not body:
        raise InputError("there are no parts, but there must be one or more.")
    masses = np.array([part.mass for part in body])
    positions = np.array([part.position for part in body])
    inertia = np.zeros((3, 3))
    centre = masses @ positions / masses.sum()
    for part, p in zip(body, positions - centre, strict=True):
        inertia += part.own_inertia() + part.mass * (p @ p * np.eye(3) - np.outer(p, p))
    return MassProperties(mass=float(masses.sum()), centre=centre, inertia=inertia)


def load_parts(path: str | os.PathLike[str]) -> list[Part]:
    """Load the parts of a TOML file.

    Parameters
    ----------
    path : str or path
        A file of ``[[part]]`` tables, see the head of this module.

    Returns
    -------
    list of Box, Cylinder or PointMass
        In SI, in the order of the file.

    Raises
    ------
    InputError
        If the file cannot be read, or a key or value in it cannot be used: one sentence with the
        file, the key, the value and what is allowed.
    """
    text, file = read_text(path, InputError), os.fsdecode(path)
    document = parse_toml(text, file, InputError)
    content = check_document(_file_model(), document, file, InputError)
    kinds = {kind.kind: kind for kind in PARTS}
    parts = []
    for index, table in enumerate(content.part):
        try:
            parts.append(kinds[table.kind].from_file(table))
        except InputError as refused:
            raise InputError(f"{file}: part[{index}], a {refused}", file=file) from None
    return parts


@cache
def _file_model() -> Any:
    from pydantic import ConfigDict, Field, create_model

    from omnimorph.design.tables import file_model

    text = (str | None, Field(default=None, description="text"))
    tables = []
    for kind in PARTS:
        word: Any = Literal[kind.kind]
        tables.append(file_model(kind, kind=(word, ...), name=text))
    one_of: Any = Annotated[reduce(or_, tables), Field(discriminator="kind")]
    parts = Field(min_length=1, description="tables, written [[part]], one or more")
    settings = ConfigDict(extra="forbid", strict=True)
    return create_model("PartsFile", __config__=settings, part=(list[one_of], parts))


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
