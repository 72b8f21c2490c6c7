"""Parts of a vehicle, put together."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np

from omnimorph.errors import InputError
from omnimorph.identification.inertia import PARTS, MassProperties, Part
from omnimorph.identification.parts_file import load_parts

__all__ = ["PartsLike", "assemble"]

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
