"""Margins of the pose loops: closed forms, an independent root count, and flights."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star

import omnimorph as om
from omnimorph.control.margins import rotor_lag
from omnimorph.reference.segments import Segment, SegmentReference

OMNIMORPH = om.load_vehicle("omnimorph")


def test_without_lag_the_crossover_is_in_closed_form() -> None:
    """|k + d jw| = w² at w² = (d² + √(d⁴ + 4k²)) / 2; only the delay costs phase."""
    quick = OMNIMORPH.replace(time_constant_up=np.zeros(8), time_constant_down=np.zeros(8))
    k, d, delay = np.array([50.0, 300.0, 9.0]), np.array([14.0, 30.0, 6.0]), 0.003
    gains = om.TrackingGains(position=tuple(k), velocity=tuple(d))
    found = om.stability_margins(gains, quick, control_period=0.004, delay=delay)
    w = np.sqrt((d**2 + np.sqrt(d**4 + 4.0 * k**2)) / 2.0)
    phase = np.arctan(d * w / k) - w * (delay + 0.002)
    np.testing.assert_allclose(found.crossover[:3], w, rtol=1e-6)
    np.testing.assert_allclose(found.phase_margin[:3], phase, rtol=1e-5)
    np.testing.assert_allclose(found.delay_margin[:3], phase / w, rtol=1e-5)


def test_a_rate_loop_in_closed_form() -> None:
    """k = 0: d/s with a dead time T oscillates at w = π/2T, so the gain margin is π / (2 T d)."""
    quick = OMNIMORPH.replace(time_constant_up=np.zeros(8), time_constant_down=np.zeros(8))
    found = om.stability_margins(om.TrackingGains(attitude=0.0, rate=10.0), quick, 0.02, 0.01)
    np.testing.assert_allclose(found.gain_margin[3:], math.pi / (2.0 * 0.02 * 10.0), rtol=1e-5)
    np.testing.assert_allclose(found.phase_margin[3:], math.pi / 2.0 - 10.0 * 0.02, rtol=1e-5)


def test_at_the_delay_margin_a_pole_is_on_the_imaginary_axis() -> None:
    """And at the gain margin: 1 + L(jw) = 0, each put into the formula by itself."""
    gains = om.TrackingGains()
    found = om.stability_margins(gains, OMNIMORPH)
    more = om.stability_margins(gains, OMNIMORPH, delay=float(found.delay_margin[0]))
    assert more.phase_margin[0] == pytest.approx(0.0, abs=1e-5)
    assert more.gain_margin[0] == pytest.approx(1.0, abs=1e-4)
    s = 1j * found.crossover[0]
    late = found.delay_margin[0] + 0.002
    L = (300.0 + 30.0 * s) / s**2 / (0.02 * s + 1.0) * np.exp(-s * late)
    assert abs(L + 1.0) < 1e-4


def test_an_unstable_loop_says_so() -> None:
    """Without damping no gain is stable."""
    found = om.stability_margins(om.TrackingGains(velocity=0.0), OMNIMORPH)
    assert not found.stable
    assert (found.phase_margin[:3] < 0.0).all()
    assert (found.gain_margin[:3] == 0.0).all()
    assert (found.phase_margin[3:] > 0.0).all()


def test_an_axis_without_gains_has_no_crossover() -> None:
    found = om.stability_margins(om.TrackingGains(position=0.0, velocity=0.0), OMNIMORPH)
    assert (found.crossover[:3] == 0.0).all()
    assert np.isinf(found.delay_margin[:3]).all()
    assert found.stable


def test_a_quadrotor_moves_sideways_through_its_attitude() -> None:
    """Ideal actuators: s² k_a + ... as a polynomial, whose roots tell stability by themselves."""
    quadrotor = build_star(4)
    for k in (1.0, 9.0, 40.0, 100.0):
        gains = om.TrackingGains(position=k, velocity=2.0 * k**0.5, attitude=100.0, rate=20.0)
        found = om.stability_margins(gains, quadrotor, control_period=1e-7)
        # s² (s² + r s + a) + a (k + d s) = 0
        roots = np.roots([1.0, 20.0, 100.0, 100.0 * 2.0 * k**0.5, 100.0 * k])
        assert (roots.real.max() < 0.0) == bool(found.phase_margin[0] > 0.0)
        # Routh: (20·100 − 200 √k) 200 √k > 20² 100 k, that is k < 25
        assert (k < 25.0) == bool(found.gain_margin[0] > 1.0)


def test_an_unstable_attitude_leaves_no_position() -> None:
    gains = om.TrackingGains(position=1.0, velocity=2.0, attitude=100.0, rate=0.5)
    found = om.stability_margins(gains, build_star(4, time_constant_up=0.02))
    assert (found.phase_margin[[0, 1, 3, 4]] < 0.0).all()


def disturbed(delay: float) -> om.Run:
    """Fly OmniMorph with the paper's gains, pushed once, with so much delay."""
    scenario = om.load_scenario("paper-case-b")
    push = om.effects.WrenchProfile(
        times=(0.0, 0.5, 0.501, 0.6, 0.601),
        force=((0, 0, 0), (0, 0, 0), (0, 0, 1), (0, 0, 1), (0, 0, 0)),
    )
    effects: tuple[Any, ...] = (
        om.effects.RotorLag(),
        om.effects.ServoRateLimit(),
        om.effects.SpeedLimits(),
        push,
    )
    if delay:
        effects = (*effects, om.effects.CommandDelay(time=delay))
    plant = replace(scenario.plant, effects=effects)
    still = SegmentReference((0.0, 0.0, 1.2), np.eye(3), [Segment(8.0)])
    return om.fly(replace(scenario, plant=plant, reference=still))


@pytest.mark.parametrize("delay", [0.0, 0.012, 0.020])
def test_a_push_dies_out_within_the_margin(delay: float) -> None:
    assert delay < om.stability_margins(om.TrackingGains(), OMNIMORPH).delay_margin.min()
    run = disturbed(delay)
    assert run.outcome is om.Outcome.COMPLETED
    off = np.abs(run.p_WB[:, 2] - 1.2)
    assert off[run.time > 6.0].max() < 0.1 * off.max()


def test_beyond_the_margin_it_grows() -> None:
    margins = om.stability_margins(om.TrackingGains(), OMNIMORPH, delay=0.032)
    assert not margins.stable
    run = disturbed(0.032)
    off = np.abs(run.p_WB[:, 2] - 1.2)
    assert off[run.time > 6.0].max() > 5.0 * off[run.time < 1.0].max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("plant", "flies", "lost"), [("realistic", 16, 20), ("realistic-1", 28, 32)]
)
def test_delays_that_the_papers_flight_bears_are_those_of_the_page(
    plant: str, flies: int, lost: int
) -> None:
    outcome = {}
    for delay_ms in (flies, lost):
        scenario = om.load_scenario("paper-case-b")
        effects = (*om.load_plant(plant).effects, om.effects.CommandDelay(time=1e-3 * delay_ms))
        late = replace(scenario, plant=replace(om.load_plant(plant), effects=effects))
        outcome[delay_ms] = om.fly(late).outcome
    assert outcome == {flies: om.Outcome.COMPLETED, lost: om.Outcome.LOST}
    page = (Path(__file__).parents[2] / "docs" / "gains.md").read_text(encoding="utf-8")
    assert f"| `{plant}` | {flies} ms | {lost} ms |" in page


def test_the_slower_of_both_time_constants_counts() -> None:
    def margins(up: float, down: float) -> om.StabilityMargins:
        of_rotors = {"time_constant_up": np.full(8, up), "time_constant_down": np.full(8, down)}
        return om.stability_margins(om.TrackingGains(), OMNIMORPH.replace(**of_rotors))

    for up, down in ((0.02, 0.05), (0.05, 0.02)):
        slow, both = margins(up, down), margins(0.05, 0.05)
        np.testing.assert_array_equal(slow.delay_margin, both.delay_margin)
        assert (slow.delay_margin < margins(0.02, 0.02).delay_margin).all()
    one = np.full(8, 0.02)
    one[5] = 0.04
    assert rotor_lag(OMNIMORPH.replace(time_constant_up=one)) == 0.04
