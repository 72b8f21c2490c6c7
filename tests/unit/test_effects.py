"""The plant's imperfections as records: what they accept, what they fall back on, how they add up.

What each does to a flight is reported by the cases of `omnimorph verify`, see tests/physics.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import FrozenInstanceError
from typing import Any

import numpy as np
import pytest

import omnimorph as om
from omnimorph import effects
from omnimorph.design.tables import file_model
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import InputError, ScenarioError
from omnimorph.simulation.effects import EFFECTS, Effect
from omnimorph.simulation.effects.truth import TrueValues

HZ = 2.0 * math.pi
REST = om.Command(np.zeros(8), np.zeros(1))

EXAMPLES: tuple[Effect, ...] = (
    effects.CommandDelay(time=0.006),
    effects.RotorLag(up=0.02, down=0.05),
    effects.SpeedLimits(largest=100.0 * HZ),
    effects.DeadBand(smallest=30.0 * HZ, reversal_time=0.01),
    effects.Effectiveness(share=(1.0, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0)),
    effects.ModelMismatch(mass=1.1, inertia=0.9, thrust_coefficient=0.8, drag_coefficient=1.2),
    effects.ServoLag(time_constant=0.03),
    effects.ServoRateLimit(rate=1.5),
    effects.MeasurementNoise(position=1e-3, velocity=2e-2, attitude=3e-3, rate=4e-2, filtered=True),
    effects.ConstantWrench(force=(1.0, 2.0, 3.0), torque=(0.1, 0.2, 0.3)),
    effects.SineWrench(force=(1.0, 0.0, 0.0), frequency=2.0, phase=0.5),
    effects.WrenchProfile(times=(0.0, 1.0), force=((0.0, 0.0, 1.0), (2.0, 0.0, 0.0))),
    effects.RotorMomentum(),
    effects.Interference(model="blade-element"),
)


def plain_quadrotor() -> Vehicle:
    """Return four rotors that do not tilt, each turning one way."""
    full = om.load_vehicle("omnimorph")
    names = ["thrust_coefficient", "drag_coefficient", "time_constant_up", "spin_inertia"]
    names += ["time_constant_down", "rotor_spin", "rotor_position", "dead_band", "speed_max"]
    servo = ("servo_angle_min", "servo_angle_max", "servo_rate_max", "servo_time_constant")
    return full.replace(
        **{name: getattr(full, name)[:4] for name in names},
        **dict.fromkeys(servo, np.zeros(0)),
        servo_name=(),
        speed_min=np.zeros(4),
        rotor_axis=np.tile([0.0, 0.0, 1.0], (4, 1)),
        hinge_axis=np.zeros((4, 3)),
        rotor_servo=np.full(4, -1),
    )


# --- the list -----------------------------------------------------------------------------------


def test_every_effect_is_in_the_list_and_has_an_example() -> None:
    made_by_paths = {TrueValues}  # which stands in no file
    assert set(EFFECTS) == set(Effect.__subclasses__()) - made_by_paths
    assert {type(example) for example in EXAMPLES} == set(EFFECTS)
    assert len({effect.kind for effect in EFFECTS}) == len(EFFECTS)


def test_every_effect_is_named_by_its_module() -> None:
    for effect in EFFECTS:
        assert getattr(effects, effect.__name__) is effect


@pytest.mark.parametrize("effect", EXAMPLES, ids=lambda effect: effect.kind)
def test_effect_survives_the_way_through_a_file(effect: Effect) -> None:
    content = effect.as_file()
    assert content["kind"] == effect.kind
    listed = {key: as_lists(value) for key, value in content.items()}
    again = type(effect).from_file(file_model(type(effect)).model_validate(listed))
    for name, value in vars(effect).items():
        if isinstance(value, str):
            assert vars(again)[name] == value
            continue
        old, new = (np.asarray(x if x is not None else np.nan) for x in (value, vars(again)[name]))
        np.testing.assert_allclose(new.astype(float), old.astype(float), rtol=1e-15)


def as_lists(value: Any) -> Any:
    """Return a value with the lists that TOML has in place of tuples."""
    return [as_lists(item) for item in value] if isinstance(value, tuple) else value


@pytest.mark.parametrize("effect", EXAMPLES, ids=lambda effect: effect.kind)
def test_effect_is_added_to_a_plant_and_flown(effect: Effect) -> None:
    plant = om.SimulatedPlant(om.load_vehicle("omnimorph"), om.PlantModel(effects=(effect,)))
    state = plant.step(REST)
    assert all(np.isfinite(part).all() for part in state)


def test_all_effects_fly_together() -> None:
    plant = om.SimulatedPlant(om.load_vehicle("omnimorph"), om.PlantModel(effects=EXAMPLES))
    for _ in range(100):
        state = plant.step(REST)
    assert all(np.isfinite(part).all() for part in state)


@pytest.mark.parametrize("integrator", ["semi-implicit-euler", "runge-kutta-4"])
def test_effects_fit_a_vehicle_without_servos(integrator: Any) -> None:
    unfit = needs_an_argument() | {effects.Interference}  # no two of its rotors are in line
    suited = [effect() for effect in EFFECTS if effect not in unfit]
    model = om.PlantModel(
        effects=(*suited, effects.Effectiveness(share=0.9)), integrator=integrator
    )
    vehicle = plain_quadrotor().replace(dead_band=np.full(4, 100.0))
    plant = om.SimulatedPlant(vehicle, model)
    command = om.Command(np.full(4, vehicle.mass * 9.81 / 4.0), np.zeros(0))
    for _ in range(50):
        state = plant.step(command)
    assert all(np.isfinite(part).all() for part in state)
    assert plant.tilt.shape == (0,)


def needs_an_argument() -> set[type[Effect]]:
    """Return the effects that cannot be made from nothing."""
    needy = set()
    for effect in EFFECTS:
        try:
            effect()
        except TypeError:
            needy.add(effect)
    return needy


@pytest.mark.parametrize(
    ("effect", "missing"),
    [
        (effects.RotorLag(), "up_ms"),
        (effects.DeadBand(), "smallest_Hz"),
        (effects.ServoLag(), "time_constant_ms"),
        (effects.RotorMomentum(), "spin_inertia"),
        (effects.MeasurementNoise(position=1e-3, filtered=True), "filter"),
    ],
    ids=lambda value: getattr(value, "kind", ""),
)
def test_effect_that_finds_nothing_in_the_vehicle_says_so(effect: Effect, missing: str) -> None:
    nothing = np.zeros(8)
    bare = om.load_vehicle("omnimorph").replace(
        time_constant_up=nothing,
        time_constant_down=nothing,
        dead_band=nothing,
        spin_inertia=nothing,
        servo_time_constant=np.zeros(1),
        filter_cutoff=np.zeros(4),
    )
    with pytest.raises(om.InputError, match=missing):
        om.SimulatedPlant(bare, om.PlantModel(effects=(effect,)))


def test_drag_energy_is_that_of_the_vehicle_that_flew() -> None:
    from dataclasses import replace

    hover = om.load_scenario("hover")
    spent = []
    for factor in (1.0, 2.0):
        mismatch = effects.ModelMismatch(drag_coefficient=factor)
        plant = om.PlantModel(effects=(mismatch,))
        spent.append(om.fly(replace(hover, plant=plant)).metrics.drag_energy_J)
    assert spent[1] == pytest.approx(2.0 * spent[0], rel=1e-3)


def test_effects_are_frozen_and_compare_by_value() -> None:
    lag = effects.RotorLag(up=0.02)
    with pytest.raises(FrozenInstanceError):
        lag.up = 0.03  # type: ignore[misc]
    assert lag == effects.RotorLag(up=0.02)
    assert lag != effects.RotorLag(up=0.03)


def test_numpy_numbers_are_taken() -> None:
    share = effects.Effectiveness(share=np.array([0.5, 1.0]))  # type: ignore[arg-type]
    assert share.share == (0.5, 1.0)
    assert effects.RotorLag(up=np.float64(0.02)).up == 0.02


# --- what is refused ----------------------------------------------------------------------------

IMPOSSIBLE: list[tuple[Callable[[], Effect], str, str]] = [
    (lambda: effects.CommandDelay(time=-1e-3), "time", "not negative"),
    (lambda: effects.CommandDelay(time=math.nan), "time", "not negative"),
    (lambda: effects.RotorLag(up=-0.1), "up", "not negative"),
    (lambda: effects.RotorLag(down=math.inf), "down", "not negative"),
    (lambda: effects.RotorLag(up=True), "up", "a number"),
    (lambda: effects.RotorLag(up="fast"), "up", "a number"),  # type: ignore[arg-type]
    (lambda: effects.SpeedLimits(largest=0.0), "largest", "positive"),
    (lambda: effects.DeadBand(smallest=-1.0), "smallest", "not negative"),
    (lambda: effects.DeadBand(reversal_time=-1.0), "reversal_time", "not negative"),
    (lambda: effects.Effectiveness(share=-0.1), "share", "none negative"),
    (lambda: effects.Effectiveness(share=()), "share", "none negative"),
    (lambda: effects.Effectiveness(share=(1.0, math.nan)), "share", "none negative"),
    (lambda: effects.ModelMismatch(mass=0.0), "mass", "positive"),
    (lambda: effects.ModelMismatch(inertia=-1.0), "inertia", "positive"),
    (lambda: effects.ModelMismatch(drag_coefficient=math.inf), "drag_coefficient", "positive"),
    (lambda: effects.ServoLag(time_constant=-1.0), "time_constant", "not negative"),
    (lambda: effects.ServoRateLimit(rate=0.0), "rate", "positive"),
    (lambda: effects.MeasurementNoise(position=-1.0), "position", "not negative"),
    (lambda: effects.MeasurementNoise(attitude=math.nan), "attitude", "not negative"),
    (lambda: effects.ConstantWrench(force=(1.0, 2.0)), "force", "three"),
    (lambda: effects.ConstantWrench(torque=(1.0, 2.0, math.nan)), "torque", "three"),
    (lambda: effects.SineWrench(frequency=0.0), "frequency", "positive"),
    (lambda: effects.SineWrench(frequency=1.0, phase=math.inf), "phase", "finite"),
    (lambda: effects.WrenchProfile(times=(), force=()), "times", "increasing"),
]


@pytest.mark.parametrize(("build", "field", "allowed"), IMPOSSIBLE)
def test_impossible_numbers_are_refused(
    build: Callable[[], Effect], field: str, allowed: str
) -> None:
    with pytest.raises(ScenarioError) as caught:
        build()
    assert caught.value.key == field
    assert caught.value.allowed is not None
    assert allowed in caught.value.allowed
    assert "\n" not in str(caught.value)


UNFIT: list[tuple[Effect, str, str]] = [
    (effects.CommandDelay(time=0.0015), "time_ms", "a multiple of the physics step, 1 ms"),
    (effects.CommandDelay(time=0.061), "time_ms", "at most 60 control periods"),
    (effects.Effectiveness(share=(1.0, 0.5)), "share", "one for each of the 8 rotors"),
    (
        effects.WrenchProfile(times=(0.0, 0.0), force=((0.0, 0.0, 0.0),) * 2),
        "times_s",
        "increasing",
    ),
    (
        effects.WrenchProfile(times=(0.0, 1.0), force=((0.0, 0.0, 0.0),)),
        "force_N",
        "2 rows of three numbers",
    ),
    (
        effects.WrenchProfile(times=(0.0,), force=((0.0, 0.0),)),
        "force_N",
        "1 rows of three numbers",
    ),
    (
        effects.WrenchProfile(
            times=(0.0,), force=((0.0, 0.0, 0.0),), torque=((0.0, 0.0, 0.0),) * 2
        ),
        "torque_Nm",
        "1 rows of three numbers",
    ),
]


@pytest.mark.parametrize(("effect", "key", "allowed"), UNFIT)
def test_what_does_not_fit_the_plant_is_refused(effect: Effect, key: str, allowed: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        om.SimulatedPlant(om.load_vehicle("omnimorph"), om.PlantModel(effects=(effect,)))
    assert caught.value.key == key
    assert caught.value.allowed is not None
    assert allowed in caught.value.allowed


@pytest.mark.parametrize(
    ("settings", "key"),
    [
        ({"physics_step": 0.0}, "physics_step"),
        ({"physics_step": math.nan}, "physics_step"),
        ({"control_period": -1.0}, "control_period"),
        ({"control_period": 1.5e-3}, "control_period_ms"),
        ({"physics_step": 2e-3}, "control_period_ms"),
        ({"integrator": "euler"}, "integrator"),
        ({"effects": (effects.RotorLag(), effects.RotorLag(up=0.1))}, "effect"),
        ({"effects": (0.02,)}, "effects"),
    ],
)
def test_impossible_plants_are_refused(settings: dict[str, Any], key: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        om.PlantModel(**settings)
    assert caught.value.key == key


@pytest.mark.parametrize(
    "command",
    [
        om.Command(np.zeros(7), np.zeros(1)),
        om.Command(np.zeros(8), np.zeros(0)),
        om.Command(np.full(8, np.nan), np.zeros(1)),
        om.Command(np.zeros(8), np.full(1, np.inf)),
    ],
)
def test_commands_that_do_not_fit_are_refused(command: om.Command) -> None:
    plant = om.SimulatedPlant(om.load_vehicle("omnimorph"), om.PlantModel())
    with pytest.raises(InputError) as caught:
        plant.send(command)
    assert "command" in str(caught.value)


# --- what they fall back on, and how they add up --------------------------------------------------


def speed_after(steps: int, *chosen: Effect, vehicle: Vehicle) -> float:
    """Return the speed of the first rotor after some ms under a command of 4 N."""
    plant = om.SimulatedPlant(vehicle, om.PlantModel(effects=chosen), start_thrust=np.zeros(8))
    plant.send(om.Command(np.full(8, 4.0), np.zeros(1)))
    plant.step_physics(steps)
    return float(plant.speed[0])


def test_left_out_parameters_are_the_vehicles_own() -> None:
    vehicle = om.load_vehicle("omnimorph").replace(
        time_constant_up=np.full(8, 0.07),
        dead_band=np.full(8, 150.0 * HZ),
        servo_rate_max=np.full(1, 0.5),
        servo_time_constant=np.full(1, 0.2),
    )
    own = speed_after(5, effects.RotorLag(), vehicle=vehicle)
    assert own == speed_after(5, effects.RotorLag(up=0.07), vehicle=vehicle)
    assert own != speed_after(5, effects.RotorLag(up=0.02), vehicle=vehicle)
    # 4 N is 146.5 Hz, inside the band and nearer to its edge
    assert speed_after(1, effects.DeadBand(), vehicle=vehicle) == pytest.approx(150.0 * HZ)
    for effect, same in (
        (effects.ServoRateLimit(), effects.ServoRateLimit(rate=0.5)),
        (effects.ServoLag(), effects.ServoLag(time_constant=0.2)),
    ):
        plants = [om.SimulatedPlant(vehicle, om.PlantModel(effects=(e,))) for e in (effect, same)]
        for plant in plants:
            plant.send(om.Command(np.zeros(8), np.ones(1)))
            plant.step_physics(20)
        assert plants[0].tilt[0] == plants[1].tilt[0]
        assert 0.0 < plants[0].tilt[0] < 1.0


def test_only_up_given_means_both_ways() -> None:
    vehicle = om.load_vehicle("omnimorph").replace(time_constant_down=np.full(8, 0.5))
    speeds = []
    for lag in (effects.RotorLag(up=0.02), effects.RotorLag(up=0.02, down=0.02)):
        plant = om.SimulatedPlant(
            vehicle, om.PlantModel(effects=(lag,)), start_thrust=np.full(8, 4.0)
        )
        plant.send(REST)
        plant.step_physics(10)
        speeds.append(plant.speed[0])
    assert speeds[0] == speeds[1]


def test_no_time_constant_is_no_lag() -> None:
    vehicle = om.load_vehicle("omnimorph")
    at_once = speed_after(1, vehicle=vehicle)
    assert speed_after(1, effects.RotorLag(up=0.0), vehicle=vehicle) == at_once


def test_constant_wrenches_add_up_and_others_stand_once() -> None:
    push = effects.ConstantWrench(force=(0.0, 0.0, 1.0))
    model = om.PlantModel(effects=(push, push, push))
    plant = om.SimulatedPlant(om.load_vehicle("omnimorph"), model, start_thrust=np.zeros(8))
    plant.send(REST)
    gained = 1.315 * (plant.step_physics(1000).v_WB[2] + 9.81)
    assert gained == pytest.approx(3.0)


def test_mismatches_change_the_true_vehicle_only() -> None:
    believed = om.load_vehicle("omnimorph")
    heavier = effects.ModelMismatch(mass=1.1)
    truth = om.PlantModel(effects=(heavier,)).true_vehicle(believed)
    assert truth.mass == pytest.approx(1.1 * believed.mass)
    assert believed.mass == 1.315
    assert om.PlantModel().true_vehicle(believed) is believed


def test_order_in_the_list_does_not_matter() -> None:
    ends = []
    for chosen in (EXAMPLES, EXAMPLES[::-1]):
        plant = om.SimulatedPlant(om.load_vehicle("omnimorph"), om.PlantModel(effects=chosen))
        for k in range(50):
            state = plant.step(om.Command(np.linspace(-2.0, 3.0, 8) * np.cos(k), np.ones(1)))
        ends.append(np.concatenate([part.ravel() for part in state]))
    np.testing.assert_array_equal(ends[0], ends[1])


def test_a_largest_speed_below_the_least_of_one_rotor_is_refused() -> None:
    least = np.array([100.0, 100.0, 300.0, 100.0])
    quadrotor = om.load_vehicle("quadrotor").replace(speed_min=least)
    limits = effects.SpeedLimits(largest=200.0)
    allowed = f"above the rotors' least speed, {300.0 / HZ:g} Hz"
    with pytest.raises(ScenarioError, match=allowed):
        limits.of_rotors(quadrotor)
    assert effects.SpeedLimits(largest=301.0).of_rotors(quadrotor)[0].tolist() == least.tolist()
