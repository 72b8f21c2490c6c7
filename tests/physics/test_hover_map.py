"""Hover power over attitude and tilt, and attitudes spread evenly."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.physics.small_vehicles import attitude, build_star, frozen, random_axes

from omnimorph.analysis import hover, hover_map, sphere_directions
from omnimorph.design import load_vehicle

OMNIMORPH = load_vehicle("omnimorph")


def test_the_map_is_hover_point_by_point() -> None:
    up = np.vstack([3.0 * sphere_directions(12), random_axes(np.random.default_rng(4), 3)])
    tilts, reported = np.radians([0.0, 30.0, 45.0, 60.0]), []
    found = hover_map(OMNIMORPH, up, tilts, progress=lambda done, of: reported.append((done, of)))
    assert reported == [(k, 4) for k in range(1, 5)]
    np.testing.assert_allclose(np.linalg.norm(found.up, axis=1), 1.0, rtol=1e-15)
    for d, direction in enumerate(up):
        powers = [hover(OMNIMORPH, tilt, attitude(direction)).power for tilt in tilts]
        np.testing.assert_allclose(found.power[d], powers, rtol=1e-9)
        assert found.best_tilt[d] == tilts[np.argmin(powers)]
        assert found.least_power[d] == found.power[d].min()
    assert found.feasible.all()
    flat = hover_map(build_star(4), up, [0.0])
    np.testing.assert_array_equal(flat.feasible, False)
    assert np.isinf(flat.least_power).all()


def test_a_frozen_vehicle_hovers_as_a_tilted_one() -> None:
    up = sphere_directions(30)
    still = hover_map(frozen(OMNIMORPH, 0.9), up, [0.0]).power
    np.testing.assert_allclose(still, hover_map(OMNIMORPH, up, [0.9]).power, rtol=1e-9)


@pytest.mark.parametrize("count", [1, 2, 7, 100, 1001])
def test_directions_are_spread_evenly(count: int) -> None:
    """Unit, mean zero along z, and as many in any cap as its area says."""
    up = sphere_directions(count)
    assert up.shape == (count, 3)
    np.testing.assert_allclose(np.linalg.norm(up, axis=1), 1.0, rtol=1e-14)
    assert abs(up[:, 2].mean()) < 1e-14
    assert (np.diff(up[:, 2]) < 0.0).all()
    np.testing.assert_allclose(up.mean(axis=0), 0.0, atol=1.0 / count)
    for axis in random_axes(np.random.default_rng(count), 20):
        for cosine in (-0.5, 0.0, 0.4, 0.8):
            expected = 0.5 * (1.0 - cosine) * count
            assert abs((up @ axis > cosine).sum() - expected) <= 1.5 + 0.6 * math.sqrt(count) / 2
