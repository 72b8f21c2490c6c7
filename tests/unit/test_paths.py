"""Every number that decides a flight can be read and replaced by its path."""

from __future__ import annotations

import dataclasses
import typing
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

import omnimorph as om
from omnimorph.control.allocators import ExhaustiveTilt
from omnimorph.control.rules import RULES
from omnimorph.control.tracking import TrackingGains
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import InputError, ScenarioError
from omnimorph.report.tables import plant_table
from omnimorph.simulation.effects import EFFECTS
from omnimorph.simulation.paths import paths, replaced, value_at
from omnimorph.simulation.plant import PlantModel

E = om.effects
EVERY_EFFECT = (
    E.CommandDelay(time=0.004),
    E.RotorLag(up=0.02),
    E.SpeedLimits(),
    E.DeadBand(smallest=1.0),
    E.Effectiveness(share=0.9),
    E.ModelMismatch(mass=1.1),
    E.ServoLag(time_constant=0.01),
    E.ServoRateLimit(rate=2.0),
    E.MeasurementNoise(position=0.001),
    E.ConstantWrench(force=(0.1, 0.0, 0.0)),
    E.ConstantWrench(torque=(0.0, 0.01, 0.0)),
    E.SineWrench(force=(0.0, 0.1, 0.0), frequency=3.0),
    E.WrenchProfile(times=(0.0, 1.0), force=((0.1,) * 3,) * 2, torque=((0.1,) * 3,) * 2),
    E.RotorMomentum(),
    E.Interference(),
)
TOUR = om.load_scenario("tour")
WHOLE = dataclasses.replace(TOUR, plant=PlantModel(effects=EVERY_EFFECT, name="whole"))


def replaced_at(scenario: om.Scenario, path: str, value: ArrayLike) -> om.Scenario:
    return replaced(scenario, {path: value})


def is_a_number(hint: Any) -> bool:
    """Return whether a field of this type may hold numbers."""
    return hint in (float, int) or any(map(is_a_number, typing.get_args(hint)))


def numeric_fields(record: type) -> set[str]:
    hints = typing.get_type_hints(record)
    return {f.name for f in dataclasses.fields(record) if is_a_number(hints[f.name])}


# --- every number has a path ----------------------------------------------------------------------


def test_every_number_of_every_effect_has_a_path() -> None:
    known = paths(WHOLE)
    assert {type(effect) for effect in EVERY_EFFECT} == set(EFFECTS)
    for effect in EFFECTS:
        which = "[1]" if effect is E.ConstantWrench else ""
        for field in numeric_fields(effect):
            assert f"plant.{effect.kind}{which}.{field}" in known


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.kind)
def test_every_number_of_every_rule_has_a_path(rule: Any) -> None:
    weights: dict[str, Any] = {"W1": 1e-9, "W2_position": (1.0,) * 3, "W2_attitude": (1.0,) * 3}
    more = {"span": "window", "candidates": 5} if "candidates" in numeric_fields(rule) else {}
    scenario = dataclasses.replace(TOUR, allocator=rule(**weights, W3=0.0, **more))
    for field in numeric_fields(rule):
        assert f"controller.allocator.{field}" in paths(scenario)


def test_every_number_of_vehicle_plant_gains_and_scenario_has_a_path() -> None:
    known = paths(TOUR)
    for field in dataclasses.fields(Vehicle):
        has_one = isinstance(getattr(TOUR.vehicle, field.name), float | np.ndarray)
        counts = field.name in ("rotor_servo", "rotor_spin")  # what is where, and no quantity
        assert (f"vehicle.{field.name}" in known) is (has_one and not counts)
        assert (f"truth.{field.name}" in known) is (has_one and not counts)
    assert {f"controller.{field}" for field in numeric_fields(TrackingGains)} <= set(known)
    own = {"physics_step", "control_period"}
    assert {path for path in known if path.startswith("plant.") and path.count(".") == 1} == {
        f"plant.{field}" for field in own
    }
    assert {path for path in known if "." not in path} == {"start_tilt", "lost_beyond"}


def everything(scenario: om.Scenario) -> dict[str, Any]:
    """Return all fields of what a scenario is made of, without any path."""
    truth = scenario.plant.true_vehicle(scenario.vehicle)
    parts: dict[str, Any] = {"vehicle": scenario.vehicle, "truth": truth, "plant": scenario.plant}
    parts |= {"controller": scenario.gains, "controller.allocator": scenario.allocator}
    effects = [effect for effect in scenario.plant.effects if effect.kind != "truth"]
    for number, effect in enumerate(effects):
        which = f"[{number - 9}]" if isinstance(effect, E.ConstantWrench) else ""
        parts[f"plant.{effect.kind}{which}"] = effect
    found = {
        f"{name}.{field.name}": getattr(part, field.name)
        for name, part in parts.items()
        for field in dataclasses.fields(part)
        if field.name != "effects"
    }
    return found | {"start_tilt": scenario.tilt, "lost_beyond": scenario.lost_beyond}


BEFORE = everything(WHOLE)


@pytest.mark.parametrize("path", paths(WHOLE))
def test_a_value_is_replaced_and_nothing_else(path: str) -> None:
    """A little less of each number, or the same where a record refuses less."""
    old = value_at(WHOLE, path)
    np.testing.assert_array_equal(BEFORE[path] if path != "start_tilt" else 0.0, old)
    value = 0.5 if old is None else np.array(old) * 0.99 - 1e-3
    try:
        changed = replaced_at(WHOLE, path, value)
    except InputError:
        value = 0.5 if old is None else np.array(old)
        changed = replaced_at(WHOLE, path, value)
    after = everything(changed)
    near = 2e-3 if "axis" in path else 0.0  # which is made of unit length
    np.testing.assert_allclose(value_at(changed, path), value, rtol=1e-12, atol=near)  # type: ignore[arg-type]
    np.testing.assert_array_equal(after[path], value_at(changed, path))
    follow = {path, path.replace("vehicle.", "truth.")}
    if path in ("vehicle.mass", "plant.model-mismatch.mass"):
        follow |= {"truth.mass", "truth.tilt_mechanism_mass"}
    for field in follow | {path.replace("plant.model-mismatch.", "truth.")}:
        del after[field]
    for field, value in after.items():
        np.testing.assert_equal(value, BEFORE[field], field)


@pytest.mark.parametrize(
    ("path", "value", "record"),
    [
        ("vehicle.thrust_coefficient[3]", 4e-6, lambda s: s.vehicle.thrust_coefficient[3]),
        ("vehicle.rotor_position[3][2]", 0.2, lambda s: s.vehicle.rotor_position[3, 2]),
        ("vehicle.servo_angle_max", 0.9, lambda s: s.vehicle.servo_angle_max[0]),
        ("controller.position", 90.0, lambda s: s.gains.position),
        ("controller.position[2]", 90.0, lambda s: s.gains.position[2]),
        ("controller.allocator.W1[5]", 3e-12, lambda s: s.allocator.W1[5]),
        ("plant.rotor-lag.up", 0.03, lambda s: s.plant.effects[1].up),
        ("plant.effectiveness.share[7]", 0.4, lambda s: s.plant.effects[4].share[7]),
        ("plant.constant-wrench[1].torque[1]", 0.3, lambda s: s.plant.effects[10].torque[1]),
        ("plant.wrench-profile.force[1][2]", 0.3, lambda s: s.plant.effects[12].force[1][2]),
        ("plant.physics_step", 5e-4, lambda s: s.plant.physics_step),
        ("start_tilt[0]", 0.1, lambda s: s.tilt[0]),
        ("lost_beyond", 3.0, lambda s: s.lost_beyond),
    ],
)
def test_where_a_path_leads(path: str, value: float, record: Any) -> None:
    changed = replaced_at(WHOLE, path, value)
    assert record(changed) == value
    assert value_at(changed, path) == value
    assert np.all(value_at(WHOLE, path) != value)  # which remains as it was


def test_one_number_for_all_rotors_and_one_for_each() -> None:
    alike = replaced_at(TOUR, "vehicle.spin_inertia", 2e-5)
    np.testing.assert_array_equal(alike.vehicle.spin_inertia, np.full(8, 2e-5))
    each = replaced_at(TOUR, "vehicle.spin_inertia", np.arange(1.0, 9.0) * 1e-5)
    np.testing.assert_array_equal(each.vehicle.spin_inertia, np.arange(1.0, 9.0) * 1e-5)


def test_a_whole_number_stays_one() -> None:
    weights: dict[str, Any] = {"W1": 1e-9, "W2_position": (1.0,) * 3, "W2_attitude": (1.0,) * 3}
    rule = ExhaustiveTilt(span="window", candidates=5, W3=0.0, **weights)
    path = "controller.allocator.candidates"
    exhaustive = dataclasses.replace(TOUR, allocator=rule)
    assert value_at(replaced_at(exhaustive, path, 7), path) == 7.0
    for value in (6, 7.5, [5, 7]):
        with pytest.raises(ScenarioError, match="but it must be an odd whole number from 3 to 361"):
            replaced_at(exhaustive, path, value)


def test_several_values_are_put_in_together() -> None:
    """Both limits move past the old ones: neither could go first."""
    low, high = 1.2 * TOUR.vehicle.speed_max, 1.4 * TOUR.vehicle.speed_max
    values: dict[str, Any] = {"truth.speed_min": low, "truth.speed_max": high, "truth.mass": 1.4}
    changed = replaced(TOUR, values)
    for path, value in values.items():
        np.testing.assert_array_equal(value_at(changed, path), value)
    with pytest.raises(InputError, match="speed_min"):
        replaced_at(TOUR, "truth.speed_min", low)


# --- the truth ------------------------------------------------------------------------------------


def test_the_model_and_the_truth() -> None:
    both = replaced_at(TOUR, "vehicle.mass", 1.5)
    assert (value_at(both, "vehicle.mass"), value_at(both, "truth.mass")) == (1.5, 1.5)
    truth = replaced_at(both, "truth.mass", 1.7)
    assert (value_at(truth, "vehicle.mass"), value_at(truth, "truth.mass")) == (1.5, 1.7)
    again = replaced_at(replaced_at(truth, "truth.mass", 1.8), "vehicle.mass", 1.4)
    assert (value_at(again, "vehicle.mass"), value_at(again, "truth.mass")) == (1.4, 1.8)
    assert [effect.kind for effect in again.plant.effects].count("truth") == 1


def test_parts_of_the_truth_come_in_any_order() -> None:
    one, all_rotors = "truth.thrust_coefficient[3]", "truth.thrust_coefficient"
    c_f = TOUR.vehicle.thrust_coefficient
    steps = ((one, 4e-6), ("truth.thrust_coefficient[1]", 5e-6), ("vehicle.mass", 1.4))
    for order in (steps, steps[::-1]):
        scenario = TOUR
        for path, value in order:
            scenario = replaced_at(scenario, path, value)
        expected = c_f.copy()
        expected[3], expected[1] = 4e-6, 5e-6
        np.testing.assert_array_equal(value_at(scenario, all_rotors), expected)
    stronger = replaced_at(scenario, "vehicle.thrust_coefficient", 6e-6)  # where nothing is fixed
    assert np.count_nonzero(value_at(stronger, all_rotors) == 6e-6) == 6
    whole = replaced_at(stronger, all_rotors, 4.5e-6)  # covers what was said of one
    np.testing.assert_array_equal(value_at(whole, all_rotors), np.full(8, 4.5e-6))
    assert len(whole.plant.effects[-1].as_file()) == 2  # its kind, and one value for all rotors
    assert value_at(replaced_at(whole, one, 4e-6), one) == 4e-6


def test_the_truth_flies_as_a_mismatch_of_the_model() -> None:
    """The same flight to the last bit, said in two ways; and not that of the model."""
    short = om.load_scenario("hover")
    mass = short.vehicle.mass
    mechanism = short.vehicle.tilt_mechanism_mass
    said = replaced(
        short, {"truth.mass": 1.25 * mass, "truth.tilt_mechanism_mass": 1.25 * mechanism}
    )
    effects = (*short.plant.effects, E.ModelMismatch(mass=1.25))
    mismatch = dataclasses.replace(short, plant=dataclasses.replace(short.plant, effects=effects))
    flown, other, plain = (om.fly(scenario) for scenario in (said, mismatch, short))
    assert flown.p_WB.tobytes() == other.p_WB.tobytes()
    assert flown.speed.tobytes() == other.speed.tobytes()
    assert flown.p_WB.tobytes() != plain.p_WB.tobytes()
    stored = flown.provenance.scenario["plant"]["effects"][-1]
    assert stored == {
        "kind": "truth",
        "mass_kg": 1.25 * mass,
        "tilt_mechanism_mass_kg": 1.25 * mechanism,
    }
    row = plant_table(flown).rows[-1]
    assert row[:2] == ["truth", "mass 1.644 kg, tilt mechanism mass 0.2338 kg"]


# --- whether the controller is still the proposed one ---------------------------------------------


@pytest.mark.parametrize(
    ("path", "value", "proposed"),
    [
        ("vehicle.mass", 1.4, False),
        ("controller.rate", 20.0, False),
        ("plant.control_period", 0.002, False),
        ("start_tilt", 0.1, False),
        ("truth.mass", 1.4, True),
        ("plant.measurement-noise.rate", 0.0, True),
        ("lost_beyond", 1.0, True),
    ],
)
def test_a_controller_is_proposed_no_longer_if_it_would_be_another(
    path: str, value: float, proposed: bool
) -> None:
    assert TOUR.proposed
    assert replaced_at(TOUR, path, value).proposed is proposed


# --- what is refused ------------------------------------------------------------------------------

UNKNOWN = "scenario tour: {} is not a known path; {}"


@pytest.mark.parametrize(
    ("path", "hint"),
    [
        ("vehicle.mas", "did you mean vehicle.mass or "),
        ("mass", "did you mean vehicle.mass or truth.mass?"),
        ("rotor-lag.up", "did you mean plant.rotor-lag.up?"),
        ("plant.rotor-lag.upp", "did you mean plant.rotor-lag.up or "),
        ("plant.rotor-lag.up_ms", "did you mean plant.rotor-lag.up or "),
        ("controller.W1", "did you mean controller.allocator.W1"),
        ("vehicle.rotor_servo", "did you mean "),
        ("zzz", "they begin with vehicle, truth, plant, plant.rotor-lag, "),
        ("", "they begin with "),
        ("vehicle.mass\x1b[31m", "did you mean "),
        ("vehicle.mass[-1]", "did you mean vehicle.mass"),
    ],
)
@pytest.mark.parametrize("use", [value_at, lambda s, p: replaced_at(s, p, 1.0)])
def test_an_unknown_path_names_the_nearest_ones(use: Any, path: str, hint: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        use(TOUR, path)
    assert str(caught.value).isprintable()
    assert f" is not a known path; {hint}" in str(caught.value)
    assert caught.value.key == path


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        ("plant.effectiveness.share", 0.5, "left out, because plant realistic has no effectivenes"),
        ("vehicle.thrust_coefficient[8]", 1.0, "one with indices within the shape (8,)"),
        ("vehicle.rotor_position[1][3]", 1.0, "one with indices within the shape (8, 3)"),
        ("vehicle.mass[0]", 1.0, "one without an index"),
        ("plant.rotor-lag.up[0]", 1.0, "one without an index"),
        ("truth.mass", "heavy", "finite numbers in SI"),
        ("truth.mass", np.inf, "finite numbers in SI"),
        ("truth.mass", [1.0, 2.0], "one number"),
        ("truth.rotor_position", 1.0, "of shape (8, 3)"),
        ("vehicle.spin_inertia", [1e-5] * 7, "of shape (8,)"),
        ("controller.position[1]", [1.0, 2.0], "one number"),
        ("vehicle.mass", -1.0, "from 1e-6 to 1e6 in SI"),
        ("truth.mass", 0.1, "below the mass of 0.1 kg"),
        ("controller.position", -3.0, "one number, or three (x, y, z), none negative, from 0"),
        ("plant.physics_step", 0.3, "a multiple of the physics step, 300 ms"),
        ("start_tilt", 2.0, "within 0 to 60 degrees"),
        ("lost_beyond", -1.0, "a positive number of metres"),
        ("lost_beyond", [1.0, 2.0], "a positive number of metres"),
        ("start_tilt", [0.1, 0.2], "one finite angle in rad, or one for each of the 1 servos"),
        ("plant.physics_step", [1e-3, 1e-3], "a positive number of milliseconds"),
        ("controller.position", [[1.0] * 3] * 3, "one number, or three (x, y, z)"),
        ("controller.allocator.W1", [[1e-9] * 8], "a number, or one for each rotor"),
        ("controller.allocator.W1", [1e-9] * 7, "one number, or one for each of the 8 rotors"),
    ],
)
def test_a_value_that_cannot_be_is_refused(path: str, value: Any, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        replaced_at(TOUR, path, value)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("wrong", [3, None, ["truth.mass"], "truth.mass"])
def test_values_that_are_no_mapping_are_refused(wrong: Any) -> None:
    with pytest.raises(ScenarioError, match="but it must be a mapping from paths to numbers"):
        om.replaced(TOUR, wrong)


def test_a_path_beside_one_of_its_own_numbers_is_refused() -> None:
    """The order of the mapping must not decide which of them counts."""
    both = {"vehicle.thrust_coefficient[3]": 5e-6, "vehicle.thrust_coefficient": 4e-6}
    for values in (both, dict(reversed(both.items()))):
        with pytest.raises(
            ScenarioError, match=r"coefficient\[3\] is .given., but it must be left"
        ):
            replaced(om.load_scenario("hover"), values)
