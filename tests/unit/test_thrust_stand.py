"""The test stand refuses what it cannot measure, in a sentence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star, build_vehicle

import omnimorph as om
from omnimorph import effects
from omnimorph.errors import ScenarioError, VehicleError

VEHICLE = om.load_vehicle("omnimorph")
TURN = 2.0 * np.pi


def stand(vehicle: om.Vehicle = VEHICLE, **changes: Any) -> om.ThrustStand:
    """Build a stand for rotor 4, upright, with something changed."""
    values: dict[str, Any] = {"vehicle": vehicle, "rotor": 4, "tilt": 0.0}
    return om.ThrustStand(**(values | changes))


def profile(**changes: Any) -> om.SpeedProfile:
    """Build a profile of two rows of rest, with something changed."""
    values: dict[str, Any] = {"time": [0.0, 1.0], "speed": np.zeros((2, 8)), "duration": 2.0}
    return om.SpeedProfile(**(values | changes))


@pytest.mark.parametrize("rotor", [-1, 8, 1.0, True, "4", None])
def test_no_such_rotor(rotor: Any) -> None:
    for build in (lambda: stand(rotor=rotor), lambda: om.speed_steps(VEHICLE, rotor)):
        with pytest.raises(ScenarioError, match=r"rotor is .* it must be a rotor of vehicle omni"):
            build()


def test_an_index_of_numpy_is_a_rotor() -> None:
    assert stand(rotor=np.int64(3)).rotor == 3


@pytest.mark.parametrize(
    ("tilt", "expected"),
    [(50.0, "tilt is .*, but it must be from 0° to 60°"), ([0.0, 0.0], "one finite angle"),
     (np.nan, "one finite angle"), ("up", "one finite angle")],
)  # fmt: skip
def test_no_such_tilt(tilt: Any, expected: str) -> None:
    with pytest.raises(VehicleError, match=expected):
        stand(tilt=tilt)


@pytest.mark.parametrize(
    "effect",
    [
        effects.MeasurementNoise(),
        effects.RotorMomentum(),
        effects.ServoLag(time_constant=0.01),
        effects.ServoRateLimit(),
        effects.ConstantWrench(),
    ],
)
def test_effects_that_a_bolted_vehicle_cannot_feel(effect: effects.Effect) -> None:
    with pytest.raises(ScenarioError, match=rf"effect is .*{effect.kind}.* one of the rotors"):
        stand(effects=(effect,))


@pytest.mark.parametrize(
    ("kinds", "expected"),
    [
        ((effects.Interference(), effects.Interference()), "only once"),
        ((effects.Effectiveness(share=(1.0, 1.0)),), "one for each of the 8 rotors"),
        ((effects.CommandDelay(time=1e-4),), "a multiple of the physics step, 1 ms"),
        (("lag",), "a sequence of effects"),
        (3, "a sequence of effects"),
    ],
)
def test_effects_that_do_not_fit(kinds: Any, expected: str) -> None:
    with pytest.raises(ScenarioError, match=expected):
        stand(effects=kinds)


def test_interference_needs_rotors_in_line() -> None:
    with pytest.raises(ScenarioError, match="no two rotors in line"):
        stand(build_star(6), effects=(effects.Interference(),))


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"time": []}, "time is .*, but it must be a row of finite numbers"),
        ({"time": 0.0}, "a row of finite numbers"),
        ({"time": [0.0, np.nan]}, "a row of finite numbers"),
        ({"time": [0.0, 0.0]}, "increasing, and 0 at first"),
        ({"time": [0.0, -1.0]}, "increasing, and 0 at first"),
        ({"time": [0.5, 1.0]}, "increasing, and 0 at first"),
        ({"speed": np.zeros(8)}, "speed is .*, but it must be rows of finite numbers"),
        ({"speed": [[0.0, 1.0], [2.0]]}, "rows of finite numbers"),
        ({"speed": np.full((2, 8), np.inf)}, "rows of finite numbers"),
        ({"speed": np.zeros((3, 8))}, "number of rows of speed is 3, .* each of the 2 times"),
        ({"duration": 1.0}, "duration is 1.0, but it must be after the last change, at 1 s"),
        ({"duration": np.inf}, "duration is inf, but it must be one finite number"),
        ({"duration": "long"}, "one finite number"),
    ],
)
def test_profiles_that_are_none(changes: dict[str, Any], expected: str) -> None:
    with pytest.raises(ScenarioError, match=expected):
        profile(**changes)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"step": 0.0}, "step is 0.0, but it must be a positive number"),
        ({"step": np.nan}, "a positive number"),
        ({"dwell": -1.0}, "dwell is -1.0, but it must be a positive number"),
        ({"largest": 110.0 * TURN}, 'largest is "110 Hz", .* a multiple of the step, 20 Hz'),
        ({"largest": np.inf}, "a multiple of the step"),
        ({"held": np.nan}, "rows of finite numbers"),
    ],
)
def test_steps_that_are_none(changes: dict[str, Any], expected: str) -> None:
    with pytest.raises(ScenarioError, match=expected):
        om.speed_steps(VEHICLE, 4, **changes)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"speed": np.zeros((2, 4))}, "number of columns of speed is 4, .* each of the 8 rotors"),
        ({"time": [0.0, 1e-5], "duration": 1e-4}, "duration is 0.0001, .* from one sample to"),
        ({"duration": 1e9}, "from one sample to"),
        ({"speed": np.full((2, 8), 1e200)}, 'largest thrust is "inf N", .* small enough'),
        ({"speed": np.full((2, 8), 1e150)}, "largest thrust is .* small enough to compute with"),
    ],
)
def test_profiles_that_cannot_be_run(changes: dict[str, Any], expected: str) -> None:
    with pytest.raises(ScenarioError, match=expected):
        stand().measure(profile(**changes))


@pytest.mark.parametrize("seed", [-1, 2**64, 0.5, True])
def test_no_such_seed(seed: Any) -> None:
    with pytest.raises(ScenarioError, match=r"seed is .* an integer from 0 to"):
        stand().measure(profile(), seed=seed)


def test_speeds_beyond_the_limits() -> None:
    speed = np.zeros((2, 8))
    speed[1, 3] = -170.0 * TURN
    limited = stand(effects=(effects.SpeedLimits(),))
    reported = r'speed\[1\]\[3\] is "-170 Hz", .* from -169.563 to 169.563 Hz, .* rotor 3 turn'
    with pytest.raises(ScenarioError, match=reported):
        limited.measure(profile(speed=speed))
    with pytest.raises(ScenarioError, match="from -100 to 100 Hz"):
        stand(effects=(effects.SpeedLimits(largest=100.0 * TURN),)).measure(profile(speed=speed))
    # at the limit, and without limits, a rotor turns as it is commanded
    highest = profile(speed=np.tile(VEHICLE.speed_max, (2, 1)))
    np.testing.assert_allclose(limited.measure(highest).speed[-1], VEHICLE.speed_max, rtol=1e-12)
    assert stand().measure(profile(speed=speed)).speed[-1, 3] == pytest.approx(-170.0 * TURN)


def test_a_rotor_of_one_direction_does_not_reverse() -> None:
    vehicle = build_vehicle([[0.0, 0.0, 0.0]], speed_min=0.0)
    limited = stand(vehicle, rotor=0, effects=(effects.SpeedLimits(),))
    with pytest.raises(ScenarioError, match="from 0 to"):
        limited.measure(profile(speed=np.full((2, 1), -1.0)))


@pytest.mark.parametrize(
    "changes",
    [{"rate": 0.0}, {"force_noise": (1.0, 1.0)}, {"torque_noise": (0.0, 0.0, -1.0)}, {"rate": "1"}],
)
def test_sensors_that_are_none(changes: dict[str, Any]) -> None:
    with pytest.raises(ScenarioError, match="six-axis-sensor"):
        om.SixAxisSensor(**changes)


def test_records_are_frozen() -> None:
    reading = stand().measure(profile())
    for array in (reading.force, reading.true_torque, reading.speed, reading.time, reading.axis):
        assert not array.flags.writeable
    assert not profile().speed.flags.writeable


@pytest.mark.parametrize("other", [None, 3, "sensor"])
def test_sensor_and_profile_are_of_their_kinds(other: Any) -> None:
    vehicle = om.load_vehicle("omnimorph")
    with pytest.raises(ScenarioError, match=r"sensor is .* a SixAxisSensor, or"):
        om.ThrustStand(vehicle=vehicle, rotor=4, tilt=0.0, sensor=other)
    with pytest.raises(ScenarioError, match=r"profile is .* a SpeedProfile, or"):
        om.ThrustStand(vehicle=vehicle, rotor=4, tilt=0.0).measure(other)
