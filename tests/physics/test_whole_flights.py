"""What whole flights must share: symmetry, repetition, and where hovering ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import omnimorph as om
from omnimorph.model.dynamics import rotation_exponential
from omnimorph.protocols import FloatArray
from omnimorph.reference import Segment, SegmentReference
from omnimorph.results.run import COLUMNS
from omnimorph.simulation.effects import RotorMomentum
from omnimorph.verification.hovering import attitudes, can_hover, hover_scenario
from omnimorph.verification.setting import (
    EULER,
    RUNGE_KUTTA,
    Integrator,
    command,
    plant_with,
    tumbling,
)


def test_case_b_flown_from_another_heading_is_the_turned_flight() -> None:
    scenario = om.load_scenario("paper-case-b")
    path = scenario.reference
    assert isinstance(path, SegmentReference)
    Q = rotation_exponential([0.0, 0.0, np.pi])
    segments = [
        Segment(part.duration, Q @ part.move_W, Q @ part.rotation_axis_W, part.rotation_angle)
        for part in path.segments
    ]
    turned_path = SegmentReference(Q @ path.start_p_WB, Q @ path.start_R_WB, segments)
    plain = om.fly(scenario, plant="perfect")
    turned = om.fly(scenario, plant="perfect", reference=turned_path)
    np.testing.assert_allclose(turned.p_WB, plain.p_WB @ Q.T, rtol=0, atol=1e-9)
    np.testing.assert_allclose(turned.R_WB, Q @ plain.R_WB, rtol=0, atol=1e-9)
    np.testing.assert_allclose(turned.thrust_command, plain.thrust_command, rtol=0, atol=1e-6)
    np.testing.assert_allclose(turned.tilt_actual, plain.tilt_actual, rtol=0, atol=1e-12)


def test_the_integrators_tend_to_one_motion() -> None:
    """An order of convergence tells not to which motion: extrapolated, Euler's is Runge's."""

    def after(step: float, integrator: Integrator) -> FloatArray:
        plant = plant_with(RotorMomentum(), start=tumbling(), step=step, integrator=integrator)
        plant.send(command(np.array([1.6, 1.5, 1.7, 1.4, 1.55, 1.65, 1.5, 1.6]), 0.6))
        return np.concatenate([part.ravel() for part in plant.step_physics(round(0.4 / step))])

    coarse, fine, best = after(2e-4, EULER), after(1e-4, EULER), after(1e-3, RUNGE_KUTTA)
    assert np.abs(fine - best).max() > 1e-4
    np.testing.assert_allclose(2.0 * fine - coarse, best, atol=1e-6)


def test_noise_of_the_attitude_is_about_the_axes_of_the_body() -> None:
    """So in the same step of the same flight it is the same turn Rᵀ R_m in every attitude."""
    noise = om.effects.MeasurementNoise(position=0.01, velocity=0.02, attitude=0.3, rate=0.04)
    turns = []
    for rotation in (np.eye(3), rotation_exponential([0.4, -0.7, 0.9])):
        start = tumbling()._replace(R_WB=rotation)
        measured = plant_with(noise, start=start).measure()
        turns.append(rotation.T @ measured.R_WB)
        assert not np.allclose(measured.p_WB, start.p_WB)
    np.testing.assert_allclose(turns[0], turns[1], atol=1e-12)
    assert np.abs(turns[0] - np.eye(3)).max() > 0.05


def test_a_flights_noise_is_its_own() -> None:
    """Flight 5 of seed 1 is the same alone, after others, and from a scenario loaded anew."""
    first = om.fly(om.load_scenario("hover"), seed=1, flight=5)
    for seed, flight in ((1, 4), (1, 6), (0, 5)):
        other = om.fly(om.load_scenario("hover"), seed=seed, flight=flight)
        assert not np.array_equal(other.p_WB, first.p_WB)
        assert other.content_hash != first.content_hash
    again = om.fly(om.load_scenario("hover"), seed=1, flight=5)
    assert again.content_hash == first.content_hash
    for column in COLUMNS:
        np.testing.assert_array_equal(getattr(again, column.name), getattr(first, column.name))


def test_perfect_plant_has_no_noise_to_depend_on() -> None:
    runs = [om.fly(om.load_scenario("hover"), plant="perfect", seed=seed) for seed in (0, 1)]
    np.testing.assert_array_equal(runs[0].p_WB, runs[1].p_WB)


@pytest.mark.slow
@pytest.mark.parametrize("tilt_deg", [38.0, 38.4, 69.5, 70.0])
def test_where_hovering_in_every_attitude_begins_and_ends(tilt_deg: float) -> None:
    """The zero-moment force set holds the weight in every direction from 38.18 to 69.73°."""
    tilt = float(np.radians(tilt_deg))
    held = all(can_hover(tilt, R_WB) for R_WB in attitudes(2000, seed=1))
    assert held is (38.18 < tilt_deg < 69.73)


@pytest.mark.slow
@pytest.mark.parametrize("tilt_deg", [10.0, 20.0, 30.0, 35.0, 45.0, 60.0])
def test_hover_holds_exactly_where_the_force_set_reaches(tilt_deg: float) -> None:
    """100 attitudes: held to a micrometre inside the zero-moment force set, lost or low outside."""
    tilt = float(np.radians(tilt_deg))
    for R_WB in attitudes(100, seed=8):
        run = om.fly(hover_scenario(tilt, R_WB, duration=6.0))
        held = run.outcome is om.Outcome.COMPLETED and bool(
            np.linalg.norm(run.p_WB[-1] - run.desired_p_WB[-1]) < 1e-6
        )
        assert held is can_hover(tilt, R_WB)


@pytest.mark.slow
def test_free_motion_for_ten_minutes() -> None:
    """600 s of tumbling: momentum and energy drift by no more than the rule's error in sum."""
    vehicle = om.load_vehicle("omnimorph")
    model = om.PlantModel(integrator="runge-kutta-4")
    start = om.State(np.zeros(3), np.eye(3), np.zeros(3), np.array([3.0, -5.0, 4.0]))
    plant = om.SimulatedPlant(vehicle, model, start=start, start_thrust=np.zeros(8))
    plant.send(om.Command(np.zeros(8), np.zeros(1)))
    J = vehicle.inertia
    end = plant.step_physics(600_000)
    before, after = (s.R_WB @ J @ s.w_WB_B for s in (start, end))
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-9 * float(np.linalg.norm(before)))
    energy = [float(s.w_WB_B @ J @ s.w_WB_B) for s in (start, end)]
    assert energy[1] == pytest.approx(energy[0], rel=1e-9)
    np.testing.assert_allclose(end.R_WB.T @ end.R_WB, np.eye(3), atol=1e-13)


@pytest.mark.slow
def test_a_closed_loop_flight_converges_with_the_step() -> None:
    """Smaller physics steps under the same control period lead to one and the same flight."""
    scenario = om.load_scenario("paper-case-b")
    ends = []
    for integrator, step in ((EULER, 5e-4), (EULER, 2.5e-4), (RUNGE_KUTTA, 1e-3)):
        model = om.PlantModel(
            physics_step=step,
            control_period=4e-3,
            integrator=integrator,
            effects=(om.effects.RotorLag(), om.effects.ServoRateLimit()),
        )
        run = om.fly(replace(scenario, plant=model))
        assert run.outcome is om.Outcome.COMPLETED
        ends.append(run.p_WB[:: round(4e-3 / step)][:3000])  # 12 s: the level part
    coarse, fine = (float(np.max(np.abs(end - ends[2]))) for end in ends[:2])
    assert fine < 1e-5
    assert fine < 0.6 * coarse
