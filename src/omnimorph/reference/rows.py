"""A reference as a table: one row of 24 numbers an instant, the form the compiled core reads.

Columns of a row, in the order of `omnimorph.protocols.Desired`:

===== ========================================= ============
0:3   position p_WB                             m, in W
3:12  attitude R_WB, row by row                 1
12:15 velocity v_WB                             m/s, in W
15:18 angular velocity w_WB_B                   rad/s, in B
18:21 acceleration a_WB                         m/s², in W
21:24 angular acceleration dw_WB_B              rad/s², in B
===== ========================================= ============
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from omnimorph.protocols import Desired, FloatArray

ROW_LENGTH = 24
POSITION = slice(0, 3)
ATTITUDE = slice(3, 12)
VELOCITY = slice(12, 15)
BODY_RATE = slice(15, 18)
ACCELERATION = slice(18, 21)
BODY_RATE_DERIVATIVE = slice(21, 24)

ROTATION = "a rotation matrix, 3 x 3, orthonormal to 1e-6"
_ORTHONORMAL = 1e-6


def desired_from_row(row: FloatArray) -> Desired:
    """Return the `Desired` of one (24,) row."""
    return Desired(
        p_WB=row[POSITION],
        R_WB=row[ATTITUDE].reshape(3, 3),
        v_WB=row[VELOCITY],
        w_WB_B=row[BODY_RATE],
        a_WB=row[ACCELERATION],
        dw_WB_B=row[BODY_RATE_DERIVATIVE],
    )


def are_rotations(R: FloatArray) -> NDArray[np.bool_]:
    """Return which of (K, 3, 3) finite matrices are rotations, to 1e-6."""
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is none
        apart = np.abs(R @ np.swapaxes(R, 1, 2) - np.eye(3)).max(axis=(1, 2))
        return np.asarray((apart < _ORTHONORMAL) & (np.linalg.det(R) > 0.0))


def cross_matrix(vector: FloatArray) -> FloatArray:
    """Return the (3, 3) matrix [a]× with [a]× b = a × b."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_from_axis(axis: FloatArray, angle: float) -> FloatArray:
    """Return the rotation by `angle` (rad) about the unit vector `axis`, a (3, 3) array.

    Rodrigues' formula, R = I + sin(angle) [a]× + (1 - cos(angle)) [a]×².
    """
    a = cross_matrix(axis)
    turn: FloatArray = np.eye(3) + np.sin(angle) * a + (1.0 - np.cos(angle)) * (a @ a)
    return turn


def rotation_from_quaternion(quaternion_wxyz: FloatArray) -> FloatArray:
    """Return the (3, 3) rotation of a unit quaternion (w, x, y, z).

    Examples
    --------
    >>> rotation_from_quaternion(np.array([0.0, 0.0, 0.0, 1.0])).diagonal()  # half a turn about z
    array([-1., -1.,  1.])
    """
    w, x, y, z = quaternion_wxyz
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def relative_rotation(first_wxyz: FloatArray, second_wxyz: FloatArray) -> tuple[FloatArray, float]:
    """Return axis (unit, in W) and angle (rad, 0 to π) that turn one attitude into another.

    The rotation is R_second R_firstᵀ; the axis of no rotation at all is z. Unit quaternions, (4,).
    """
    w0, v0 = first_wxyz[0], first_wxyz[1:]
    w1, v1 = second_wxyz[0], second_wxyz[1:]
    cosine = w1 * w0 + v1 @ v0
    vector = w0 * v1 - w1 * v0 - np.cross(v1, v0)  # the vector part of second · conjugate(first)
    if cosine < 0:  # q and -q are the same attitude: take the shorter way
        cosine, vector = -cosine, -vector
    sine = float(np.linalg.norm(vector))
    if sine == 0.0:
        return np.array([0.0, 0.0, 1.0]), 0.0
    return vector / sine, 2.0 * float(np.arctan2(sine, cosine))
