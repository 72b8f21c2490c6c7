"""Tables of poses: between which attitudes a vehicle can be asked to turn."""

from __future__ import annotations

import numpy as np
import pytest

from omnimorph.errors import ScenarioError
from omnimorph.reference.samples import SampledReference


def test_the_two_quaternions_of_an_attitude_are_the_same_pose() -> None:
    """A table may change from q to −q, and may turn by up to 170° from one pose to the next."""
    angles = np.radians([0.0, 30.0, 199.0, 210.0])
    q = np.column_stack([np.cos(angles / 2), 0 * angles, 0 * angles, np.sin(angles / 2)])
    signs = np.array([[1.0], [-1.0], [-1.0], [1.0]])
    references = [SampledReference(np.arange(4.0), np.zeros((4, 3)), s * q) for s in (1, signs)]
    for time, angle in zip(range(4), angles, strict=True):
        for reference in references:
            c, s = np.cos(angle), np.sin(angle)
            expected = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
            np.testing.assert_allclose(reference(time).R_WB, expected, atol=1e-12)
    far = np.radians(172.0) / 2
    two = [[1.0, 0.0, 0.0, 0.0], [np.cos(far), 0.0, np.sin(far), 0.0]]
    with pytest.raises(ScenarioError, match=r"is 172\.0°, but it must be at most 170°"):
        SampledReference([0.0, 1.0], np.zeros((2, 3)), two)
