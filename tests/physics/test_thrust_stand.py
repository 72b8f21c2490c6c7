"""The test stand: the published experiment, closed forms of the load, and its noise."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.physics.small_vehicles import attitude, build_vehicle, random_tilting_vehicle

import omnimorph as om
from omnimorph import _core, effects
from omnimorph.design import Vehicle
from omnimorph.model.interference import WAKE_MODELS, WakeModel, stacked_pairs, thrust_lost
from omnimorph.protocols import FloatArray
from omnimorph.simulation.fly import measurement_noise
from omnimorph.simulation.thrust_stand import StandReading

VEHICLE = om.load_vehicle("omnimorph")
TURN = 2.0 * math.pi
UPPER, LOWER = 0, 4
ALONE = 1.8638e-4 * 120.0**2  # N, at 120 Hz
DRAG = 2.754e-6 * 120.0**2  # N m
WAKES = effects.Interference()
TAU = 0.02
TILTED_LOSS = 0.333 * math.exp(-((50.0 / 40.0) ** 2))

each_rotor = pytest.mark.parametrize("rotor", range(8))


def measured(
    rotor: int = LOWER,
    tilt_deg: float = 0.0,
    *kinds: effects.Effect,
    vehicle: Vehicle = VEHICLE,
    sensor: om.SixAxisSensor | None = None,
    seed: int = 0,
    **steps: Any,
) -> StandReading:
    """Run the steps of the experiment, 0.3 s each unless said otherwise."""
    stand = om.ThrustStand(
        vehicle=vehicle,
        rotor=rotor,
        tilt=math.radians(tilt_deg),
        effects=kinds,
        sensor=om.SixAxisSensor() if sensor is None else sensor,
    )
    return stand.measure(om.speed_steps(vehicle, rotor, **({"dwell": 0.3} | steps)), seed)


def ends(reading: StandReading, levels: int = 7) -> FloatArray:
    """Return the true thrust at the end of each of the steps."""
    last = len(reading.time) - 1
    return np.array([reading.true_thrust[last * (k + 1) // levels] for k in range(levels)])


def constant(speed: FloatArray, duration: float = 0.01) -> om.SpeedProfile:
    """Build the profile that holds the speeds of one row."""
    return om.SpeedProfile(time=np.zeros(1), speed=speed[None], duration=duration)


# --- the experiment ---------------------------------------------------------------------------


@pytest.mark.parametrize("tilt_deg", [0.0, 20.0, 50.0, 60.0])
def test_alone_at_120_Hz_it_gives_its_thrust_at_any_tilt(tilt_deg: float) -> None:
    reading = measured(LOWER, tilt_deg, WAKES, alone=True)
    np.testing.assert_allclose(reading.true_thrust[1:], ALONE, rtol=1e-12)
    assert round(ALONE, 3) == 2.684


@pytest.mark.parametrize(("tilt_deg", "loss"), [(0.0, 0.333), (50.0, TILTED_LOSS)])
@pytest.mark.parametrize("rotor", [4, 5, 6, 7])
def test_a_lower_rotor_loses_as_its_partner_speeds_up(
    rotor: int, tilt_deg: float, loss: float
) -> None:
    """The published model: loss proportional to the speed of the partner above."""
    share = 1.0 - ends(measured(rotor, tilt_deg, WAKES)) / ALONE
    np.testing.assert_allclose(share, loss * np.arange(7) / 6.0, atol=1e-12)


def test_published_digits() -> None:
    """2.7 N, of which 1.8 N are left at 0°, and 7 % lost at 50°."""
    upright, tilted = (ends(measured(LOWER, tilt_deg, WAKES)) for tilt_deg in (0.0, 50.0))
    assert (round(upright[0], 1), round(upright[-1], 1)) == (2.7, 1.8)
    assert round(100.0 * (1.0 - upright[-1] / upright[0])) == 33
    assert round(100.0 * (1.0 - tilted[-1] / tilted[0])) == 7


@pytest.mark.parametrize("tilt_deg", [0.0, 50.0])
def test_an_upper_rotor_loses_nothing(tilt_deg: float) -> None:
    np.testing.assert_allclose(ends(measured(UPPER, tilt_deg, WAKES)), ALONE, rtol=1e-12)


def test_turning_the_other_way_the_upper_one_loses() -> None:
    back: dict[str, Any] = {"held": -120.0 * TURN, "largest": -120.0 * TURN}
    upper, lower = (ends(measured(rotor, 0.0, WAKES, **back)) for rotor in (UPPER, LOWER))
    np.testing.assert_allclose(-upper, ALONE * (1.0 - 0.333 * np.arange(7) / 6.0), rtol=1e-12)
    np.testing.assert_allclose(-lower, ALONE, rtol=1e-12)


@each_rotor
def test_without_interference_nothing_is_lost(rotor: int) -> None:
    np.testing.assert_allclose(ends(measured(rotor, 30.0)), ALONE, rtol=1e-12)


@each_rotor
def test_drag_torque_is_not_touched(rotor: int) -> None:
    """Neither wakes nor wear change −k c_τ w|w| z, and no lever adds to it at the hub."""
    worn = effects.Effectiveness(share=0.65)
    reading = measured(rotor, 30.0, WAKES, worn)
    drag = -VEHICLE.rotor_spin[rotor] * DRAG * reading.axis
    np.testing.assert_allclose(reading.true_torque[1:], np.tile(drag, (2100, 1)), atol=1e-15)


# --- the load, whatever the vehicle -----------------------------------------------------------


@each_rotor
@pytest.mark.parametrize("tilt_deg", [0.0, 25.0, 60.0])
def test_the_force_is_along_the_axis_of_the_rotor(rotor: int, tilt_deg: float) -> None:
    """Upper axes (−s, 0, c) and three more by quarter turns; lower ones mirrored."""
    s, c = math.sin(math.radians(tilt_deg)), math.cos(math.radians(tilt_deg))
    outward = [[-s, 0], [0, -s], [s, 0], [0, s]][rotor % 4]
    axis = np.array([*outward, c]) * ([1, 1, 1] if rotor < 4 else [-1, -1, 1])
    reading = measured(rotor, tilt_deg, alone=True, dwell=0.01)
    np.testing.assert_allclose(reading.axis, axis, atol=1e-15)
    np.testing.assert_allclose(reading.true_force[-1], ALONE * axis, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("model", WAKE_MODELS)
def test_the_load_is_that_of_the_model(model: WakeModel) -> None:
    """Random speeds, tilts and shares against the loss as the analysis knows it."""
    numbers = np.random.default_rng(1)
    for rotor in range(8):
        speed, tilt = TURN * numbers.uniform(-150.0, 150.0, 8), numbers.uniform(0.0, 1.0)
        share = numbers.uniform(0.2, 1.0, 8)
        kinds = (
            effects.Interference(model=model),
            effects.Effectiveness(share=tuple(share.tolist())),
            effects.ModelMismatch(thrust_coefficient=0.9, drag_coefficient=1.1, mass=3.0),
        )
        stand = om.ThrustStand(vehicle=VEHICLE, rotor=rotor, tilt=tilt, effects=kinds)
        reading = stand.measure(constant(speed))
        f = VEHICLE.thrust_coefficient * speed * np.abs(speed)
        kept = 1.0 - thrust_lost(VEHICLE, tilt, f, model)
        np.testing.assert_allclose(reading.speed[-1], speed, rtol=1e-12)
        expected = 0.9 * (share * kept * f)[rotor]
        np.testing.assert_allclose(reading.true_thrust[-1], expected, rtol=1e-12)
        drag = -1.1 * (VEHICLE.rotor_spin * VEHICLE.kappa * f)[rotor] * reading.axis
        np.testing.assert_allclose(reading.true_torque[-1], drag, rtol=1e-11, atol=1e-15)


def test_the_loads_of_all_rotors_make_the_wrench_of_the_plant() -> None:
    """Force by force, with its lever, they add up to what carries the vehicle in flight."""
    numbers = np.random.default_rng(2)
    vehicle = random_tilting_vehicle(numbers, 5, 2)
    speed, tilt = numbers.uniform(-300.0, 300.0, 5), np.array([0.3, -0.7])
    readings = [
        om.ThrustStand(vehicle=vehicle, rotor=i, tilt=tilt).measure(constant(speed))
        for i in range(5)
    ]
    force = np.array([reading.true_force[-1] for reading in readings])
    torque = np.array([reading.true_torque[-1] for reading in readings])
    total = np.concatenate(
        [force.sum(axis=0), (torque + np.cross(vehicle.rotor_position, force)).sum(axis=0)]
    )
    thrust = vehicle.thrust_coefficient * speed * np.abs(speed)
    flying = om.SimulatedPlant(vehicle, om.PlantModel(), start_tilt=tilt, start_thrust=thrust)
    np.testing.assert_allclose(total, flying.wrench, rtol=1e-11, atol=1e-14)


def test_a_single_rotor_in_any_direction() -> None:
    vehicle = build_vehicle([[0.1, -0.2, 0.3]], [[0.6, 0.0, 0.8]], rotor_spin=-1.0)
    reading = measured(0, 0.0, vehicle=vehicle, held=300.0, alone=True)
    np.testing.assert_allclose(reading.true_force[-1], [0.54, 0.0, 0.72], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(reading.true_torque[-1], [0.0108, 0, 0.0144], rtol=1e-12, atol=1e-15)


def test_the_axes_of_the_body_turn_the_load_with_them() -> None:
    turn = attitude([0.3, -0.5, 0.8])
    vectors = ("rotor_position", "rotor_axis", "hinge_axis")
    turned = VEHICLE.replace(**{name: getattr(VEHICLE, name) @ turn.T for name in vectors})
    assert stacked_pairs(turned).tolist() == stacked_pairs(VEHICLE).tolist()
    here, there = (measured(LOWER, 40.0, WAKES, vehicle=vehicle) for vehicle in (VEHICLE, turned))
    np.testing.assert_allclose(there.true_force, here.true_force @ turn.T, atol=1e-12)
    np.testing.assert_allclose(there.true_torque, here.true_torque @ turn.T, atol=1e-12)


def test_parts_may_hold_the_rotors_where_no_servo_would() -> None:
    tilt = math.radians(85.0)
    stand = om.ThrustStand(vehicle=VEHICLE, rotor=LOWER, tilt=tilt, beyond_limits=True)
    reading = stand.measure(constant(np.full(8, 120.0 * TURN)))
    expected = ALONE * np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    np.testing.assert_allclose(reading.true_force[-1], expected, rtol=1e-12, atol=1e-15)


# --- speeds over time -------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [100.0, 1000.0, 5000.0])
def test_speeds_follow_with_a_first_order_lag(rate: float) -> None:
    """w = w_c + (w_0 − w_c) e^(−t/τ) in each step, exact however seldom it is sampled."""
    sensor = om.SixAxisSensor(rate=rate)
    reading = measured(LOWER, 0.0, effects.RotorLag(up=TAU), WAKES, sensor=sensor)
    t, per_step = reading.time, round(0.3 * rate)
    np.testing.assert_allclose(reading.speed[:, LOWER], 120 * TURN * (1 - np.exp(-t / TAU)))
    start = 0.0
    for k in range(7):
        part = slice(k * per_step, (k + 1) * per_step + 1)
        level, since = 20.0 * k * TURN, t[part] - 0.3 * k
        expected = level + (start - level) * np.exp(-since / TAU)
        np.testing.assert_allclose(reading.speed[part, UPPER], expected, atol=1e-9)
        start = expected[-1]


def test_thrust_follows_the_speeds_as_they_are() -> None:
    """At every sample: c_f w (w − 0.333 w_up), the loss from the actual speeds of both."""
    reading = measured(LOWER, 0.0, effects.RotorLag(up=TAU), WAKES)
    w, w_up = reading.speed[:, LOWER], reading.speed[:, UPPER]
    loss = np.minimum(0.333 * w_up, w)  # a rotor starting up below a fast one loses all at most
    expected = VEHICLE.thrust_coefficient[LOWER] * w * (w - loss)
    np.testing.assert_allclose(reading.true_thrust, expected, rtol=1e-12, atol=1e-12)


def test_speeds_are_those_of_the_plant_in_flight() -> None:
    """Lag, dead band and delay together, beside a plant that flies under the same commands."""
    kinds = (
        effects.RotorLag(up=TAU, down=0.03),
        effects.DeadBand(smallest=30.0 * TURN, reversal_time=0.01),
        effects.CommandDelay(time=0.005),
    )
    rows = TURN * np.array([np.full(8, 80.0), np.full(8, -60.0), np.linspace(-90.0, 90.0, 8)])
    profile = om.SpeedProfile(time=np.array([0.0, 0.1, 0.25]), speed=rows, duration=0.4)
    stand = om.ThrustStand(vehicle=VEHICLE, rotor=3, tilt=0.5, effects=kinds)
    reading = stand.measure(profile)
    flying = om.SimulatedPlant(VEHICLE, om.PlantModel(effects=kinds), start_thrust=np.zeros(8))
    for k, reported in enumerate(reading.speed):
        np.testing.assert_allclose(reported, flying.speed, rtol=1e-12, atol=1e-12)
        asked = rows[np.searchsorted([100, 250], k, side="right")]
        thrust = VEHICLE.thrust_coefficient * asked * np.abs(asked)
        flying.step(om.Command(thrust, np.zeros(1)))


def test_a_profile_begins_at_rest_and_changes_at_the_next_sample() -> None:
    speed = np.array([[100.0], [200.0], [300.0]])
    profile = om.SpeedProfile(time=np.array([0.0, 0.021, 0.03]), speed=speed, duration=0.05)
    vehicle, sensor = build_vehicle([[0.0, 0.0, 0.0]]), om.SixAxisSensor(rate=100.0)
    reading = om.ThrustStand(vehicle=vehicle, rotor=0, tilt=0.0, sensor=sensor).measure(profile)
    np.testing.assert_allclose(reading.time, [0.0, 0.01, 0.02, 0.03, 0.04, 0.05], atol=1e-15)
    # what is commanded at a sample is there at the next one; 0.021 s waits for 0.03 s
    np.testing.assert_allclose(reading.speed[:, 0], [0, 100, 100, 100, 300, 300], rtol=1e-12)


# --- noise ------------------------------------------------------------------------------------

SENSOR = om.SixAxisSensor(force_noise=(0.1, 0.2, 0.3), torque_noise=(0.01, 0.02, 0.03))
SIGMA = np.array([*SENSOR.force_noise, *SENSOR.torque_noise])


def errors(reading: StandReading) -> FloatArray:
    """Return what the sensor adds, (T, 6), in standard deviations."""
    read = np.hstack([reading.force, reading.torque])
    return np.asarray((read - np.hstack([reading.true_force, reading.true_torque])) / SIGMA)


def test_noise_is_white_with_the_sensors_deviations() -> None:
    """Mean 0, variance 1, no correlation of axes or samples, each within five standard errors."""
    added = errors(measured(LOWER, 0.0, WAKES, sensor=SENSOR, dwell=10.0))
    N = len(added)
    assert np.abs(added.mean(axis=0)).max() < 5.0 / math.sqrt(N)
    assert np.abs(added.var(axis=0) - 1.0).max() < 5.0 * math.sqrt(2.0 / N)
    joined = np.corrcoef(np.hstack([added, np.roll(added, 1, axis=0)]).T)
    assert np.abs(joined - np.eye(12)).max() < 5.0 / math.sqrt(N)


def test_the_same_seed_gives_the_same_reading() -> None:
    first, again, other = (measured(sensor=SENSOR, seed=seed) for seed in (7, 7, 8))
    np.testing.assert_array_equal(first.force, again.force)
    np.testing.assert_array_equal(first.torque, again.torque)
    np.testing.assert_array_equal(first.true_force, other.true_force)
    assert (first.force[1:] != other.force[1:]).all()


def test_noise_is_no_flights() -> None:
    """It is drawn from counts that no flight reaches, and does not correlate with a flight's."""
    added = errors(measured(sensor=SENSOR, seed=3))
    np.testing.assert_allclose(
        added, _core.measurement_normals(3, 0, 2**31, len(added))[:, :6], rtol=0.0, atol=1e-9
    )
    flown = measurement_noise(3, 0, len(added))
    both = np.asarray(np.corrcoef(np.hstack([added, flown]).T))
    assert np.abs(both[:6, 6:]).max() < 5.0 / math.sqrt(len(added))


def test_the_sensor_of_the_experiment() -> None:
    """Its resolution, taken for one standard deviation: N in x, y and z, and N m."""
    sensor = om.SixAxisSensor()
    assert sensor.force_noise == (1 / 200, 1 / 200, 1 / 100)
    assert sensor.torque_noise == (1 / 8000,) * 3


def test_the_mean_of_a_step_tells_the_loss_through_the_noise() -> None:
    """As one would evaluate it: means over a step of the two runs, each run with its own seed."""
    kinds = (effects.RotorLag(up=TAU), WAKES)
    together = measured(LOWER, 0.0, *kinds, seed=1, dwell=5.0)
    alone = measured(LOWER, 0.0, *kinds, seed=2, dwell=5.0, alone=True)
    lost = 1.0 - together.thrust[-4000:].mean() / alone.thrust[-4000:].mean()
    assert lost == pytest.approx(0.333, abs=5.0 * 0.01 / ALONE * math.sqrt(2.0 / 4000))


def test_a_perfect_sensor_reads_what_it_bears() -> None:
    sensor = om.SixAxisSensor(force_noise=(0.0,) * 3, torque_noise=(0.0,) * 3)
    reading = measured(LOWER, 50.0, WAKES, sensor=sensor)
    np.testing.assert_array_equal(reading.force, reading.true_force)
    np.testing.assert_array_equal(reading.torque, reading.true_torque)
    np.testing.assert_array_equal(reading.thrust, reading.true_thrust)
