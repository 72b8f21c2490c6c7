"""The compiled loop flies what the textbook flies, to rounding: the paper's control loop, twice."""

from __future__ import annotations

import math

import numpy as np
import pytest

import omnimorph as om
from omnimorph import textbook
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.run import Run
from omnimorph.simulation import effects
from omnimorph.simulation.fly import measurement_noise

WEIGHTS = {"a": textbook.CASE_A, "b": textbook.CASE_B}
PLANTS = {"perfect": textbook.PERFECT, "realistic": textbook.REALISTIC}

SHORT = 2.0  # s
SAME_SHORT = 1e-11  # m in position, 1 in the entries of the rotation
SAME_LONG = 1e-9
SAME_TILT = 1e-12  # rad: the same candidate, though a clipped one may be rounded otherwise
SAME_THRUST = 1e-7  # N: Case A weighs some directions of thrust next to nothing
PROVEN = 1e-9  # KKT residual of the scaled problem


def fly_textbook(
    case: str,
    plant: str,
    duration: float,
    reference: textbook.SegmentedReference | None = None,
    fixed_tilt: float | None = None,
) -> textbook.TextbookFlight:
    """Fly a case in the textbook, with the noise that the core draws for seed 0."""
    settings = PLANTS[plant]
    control_steps = round(duration / settings.control_period)
    return textbook.fly(
        om.load_vehicle("omnimorph"),
        textbook.paper_reference() if reference is None else reference,
        textbook.PAPER_GAINS,
        WEIGHTS[case],
        settings,
        duration,
        tilt=0.0 if fixed_tilt is None else fixed_tilt,
        noise=measurement_noise(0, 0, control_steps) if plant == "realistic" else None,
        fixed_tilt=fixed_tilt is not None,
    )


def assert_same_flight(
    run: Run, textbook_flight: textbook.TextbookFlight, tolerance: float
) -> None:
    """Compare every step flown by both but the last, at which the textbook decides nothing new."""
    rows, decided = len(textbook_flight.time), len(textbook_flight.time) - 1
    assert len(run.time) >= rows
    np.testing.assert_allclose(run.time[:rows], textbook_flight.time, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(
        run.tilt_actual[:rows], textbook_flight.tilt_actual, rtol=0.0, atol=SAME_TILT
    )
    np.testing.assert_allclose(
        run.tilt_command[:decided], textbook_flight.tilt_command[:decided], rtol=0.0, atol=SAME_TILT
    )
    np.testing.assert_allclose(run.p_WB[:rows], textbook_flight.p_WB, rtol=0.0, atol=tolerance)
    np.testing.assert_allclose(run.R_WB[:rows], textbook_flight.R_WB, rtol=0.0, atol=tolerance)
    np.testing.assert_allclose(
        run.thrust_command[:decided],
        textbook_flight.thrust_command[:decided],
        rtol=0.0,
        atol=SAME_THRUST,
    )
    assert run.kkt_residual.max() <= PROVEN
    assert textbook_flight.kkt_residual.max() <= PROVEN


@pytest.mark.parametrize("plant", ["perfect", "realistic"])
@pytest.mark.parametrize("case", ["a", "b"])
def test_two_seconds_of_a_case(case: str, plant: str) -> None:
    run = om.fly(om.load_scenario(f"paper-case-{case}"), plant=plant, seed=0)
    assert_same_flight(run, fly_textbook(case, plant, SHORT), SAME_SHORT)


@pytest.mark.parametrize("plant", ["perfect", "realistic"])
@pytest.mark.parametrize("case", ["a", "b"])
def test_two_seconds_at_a_fixed_tilt(case: str, plant: str) -> None:
    run = om.fly(om.load_scenario(f"paper-fixed-45-{case}"), plant=plant, seed=0)
    textbook_flight = fly_textbook(case, plant, SHORT, fixed_tilt=math.radians(45.0))
    assert_same_flight(run, textbook_flight, SAME_SHORT)


@pytest.mark.parametrize("plant", ["perfect", "realistic"])
def test_the_tilt_is_the_same_while_it_has_to_move(plant: str) -> None:
    """The paper's flight begins with a climb, which needs no tilt: here it moves and turns at once.

    Case B, in which the cost decides on the tilt clearly.
    """
    move, angle = (0.1, -0.3, 0.1), math.radians(25.0)
    axis = np.array([0.6, 0.0, 0.8])
    ours = SegmentReference((0.0, 0.0, 1.0), np.eye(3), [Segment(SHORT, move, axis, angle)])
    theirs = textbook.SegmentedReference(
        (0.0, 0.0, 1.0), [textbook.Segment(SHORT, move, tuple(angle * axis))]
    )
    run = om.fly(om.load_scenario("paper-case-b"), plant=plant, reference=ours, seed=0)
    assert_same_flight(run, fly_textbook("b", plant, SHORT, theirs), SAME_SHORT)
    assert np.degrees(run.tilt_actual.max()) > 5.0
    assert np.ptp(run.tilt_actual[-200:]) > 0.0


def test_both_bounds_of_the_thrust_are_met_alike() -> None:
    """A start far from the reference asks for more than the rotors can give, in every direction."""
    scenario = om.load_scenario("paper-case-b")
    fast = Segment(0.35, (0.5, 0.5, 0.0), (0.0, 0.0, 1.0), 1.0)
    ours = SegmentReference((0.0, 0.0, 1.0), np.eye(3), [fast])
    theirs = textbook.SegmentedReference(
        (0.0, 0.0, 1.0), [textbook.Segment(0.35, (0.5, 0.5, 0.0), (0.0, 0.0, 1.0))]
    )
    run = om.fly(scenario, plant="perfect", reference=ours)
    textbook_flight = fly_textbook("b", "perfect", 0.35, theirs)
    assert_same_flight(run, textbook_flight, SAME_SHORT)
    decided = run.active[:-1]
    assert (decided == 1).any()
    assert (decided == -1).any()
    vehicle = scenario.vehicle
    limit = np.where(decided == 1, vehicle.thrust_max, vehicle.thrust_min)
    at_limit = decided != 0
    np.testing.assert_array_equal(textbook_flight.thrust_command[:-1][at_limit], limit[at_limit])


@pytest.mark.slow
def test_the_whole_of_case_b() -> None:
    run = om.fly(om.load_scenario("paper-case-b"), plant="perfect")
    textbook_flight = fly_textbook("b", "perfect", 45.0)
    assert len(run.time) == len(textbook_flight.time) == 45_001
    assert_same_flight(run, textbook_flight, SAME_LONG)


def test_both_realistic_plants_are_one() -> None:
    """The same periods, deviations and effects; speed limits that no command reaches."""
    plant, textbook_flight = om.load_plant("realistic"), textbook.REALISTIC
    assert (plant.physics_step, plant.control_period) == pytest.approx(
        textbook_flight[:2], rel=1e-15
    )
    assert plant.integrator == "semi-implicit-euler"
    lag, limits, rate, noise, momentum = plant.effects
    assert lag == effects.RotorLag()
    assert limits == effects.SpeedLimits()
    assert rate == effects.ServoRateLimit()
    assert momentum == effects.RotorMomentum()
    assert textbook_flight.rotors_have_momentum
    assert isinstance(noise, effects.MeasurementNoise)
    assert not noise.filtered
    np.testing.assert_allclose(noise.deviation, textbook_flight.noise, rtol=1e-15)
    run = om.fly(om.load_scenario("paper-case-a"), seed=0)
    assert (np.abs(run.thrust_command) <= run.vehicle.thrust_max).all()


def test_the_perfect_plant_has_no_effect_and_decides_at_every_step() -> None:
    plant = om.load_plant("perfect")
    assert plant.effects == ()
    assert plant.physics_step == plant.control_period == pytest.approx(1e-3, rel=1e-15)
    assert plant.integrator == "semi-implicit-euler"
