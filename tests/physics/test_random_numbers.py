"""The counter-based generator behind all noise: published vectors, and how normals come of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from omnimorph import _core
from omnimorph.simulation.fly import measurement_noise

PUBLISHED = [  # counter, key, answer
    (4 * [0x00000000], 2 * [0x00000000], "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    (4 * [0xFFFFFFFF], 2 * [0xFFFFFFFF], "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    (
        [0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344],
        [0xA4093822, 0x299F31D0],
        "d16cfe09 94fdcceb 5001e420 24126ea1",
    ),
]


@pytest.mark.parametrize(
    ("counter", "key", "answer"), PUBLISHED, ids=["zeros", "ones", "digits of pi"]
)
def test_philox_gives_the_published_vectors(
    counter: list[int], key: list[int], answer: str
) -> None:
    """Known answers of philox4x32-10 from the generator's authors (Random123)."""
    assert " ".join(f"{number:08x}" for number in _core.philox(counter, key)) == answer


def uniform(high: int, low: int) -> float:
    """Return a number in (0, 1) made of the upper 53 of 64 bits."""
    return (((high << 32 | low) >> 11) + 0.5) * 2.0**-53


@pytest.mark.parametrize(("seed", "flight"), [(0, 0), (7, 3), (2**40 + 5, 2**32 - 1)])
def test_normals_are_box_and_mullers_of_the_counters(seed: int, flight: int) -> None:
    rows = measurement_noise(seed, flight, steps=20)
    key = [seed & 0xFFFFFFFF, seed >> 32]
    for step in (0, 1, 19):
        for pair in range(6):
            bits = _core.philox([step, pair, flight, 0], key)
            radius = math.sqrt(-2.0 * math.log(uniform(bits[0], bits[1])))
            angle = 2.0 * math.pi * uniform(bits[2], bits[3])
            two = [radius * math.cos(angle), radius * math.sin(angle)]
            np.testing.assert_allclose(rows[step, 2 * pair : 2 * pair + 2], two, rtol=0, atol=1e-14)


def test_no_two_numbers_of_many_flights_are_the_same() -> None:
    rows = [measurement_noise(seed, flight, 200) for seed in (0, 1, 2**32) for flight in range(20)]
    numbers = np.concatenate(rows).ravel()
    assert len(np.unique(numbers)) == len(numbers)


def test_longer_flights_begin_like_shorter_ones() -> None:
    np.testing.assert_array_equal(measurement_noise(5, 6, 1000)[:10], measurement_noise(5, 6, 10))


@pytest.mark.slow
def test_two_million_numbers_follow_the_normal_distribution() -> None:
    from scipy import stats

    rows = measurement_noise(2024, 0, 170_000)
    assert stats.kstest(rows.ravel(), "norm").pvalue > 1e-3
    assert abs(stats.skew(rows.ravel())) < 5.0 * math.sqrt(6.0 / rows.size)
    assert max(stats.kstest(column, "norm").pvalue for column in rows.T) > 0.1
    # 2.04 million numbers: the farthest one is expected near 5.1 standard deviations
    assert 4.5 < float(np.abs(rows).max()) < 6.5
