"""Scenarios whose controller comes from the vehicle: in files, and with another vehicle."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star, build_tilting_star
from tests.unit.scenario_parts import changed

import omnimorph as om
from omnimorph.errors import InputError, ScenarioError, VehicleError
from omnimorph.units import to_SI

LAGGED = {"time_constant_up": 0.02, "time_constant_down": 0.02}
QUADROTOR = build_star(4, **LAGGED)
PROPOSED = 'schema = 1\nname = "mine"\nbase = "{}"\n[controller]\nproposed = true\n'


def load(folder: Path, text: str) -> om.Scenario:
    (folder / "mine.toml").write_text(text, encoding="utf-8")
    return om.load_scenario(folder / "mine.toml")


def test_a_file_may_leave_the_controller_to_the_vehicle(tmp_path: Path) -> None:
    """Whatever gains and weights the base has; at the plant's period and delay."""
    scenario = load(tmp_path, PROPOSED.format("paper-case-b"))
    proposal = om.propose_controller(scenario.vehicle, 0.004)
    assert scenario.proposed
    assert (scenario.gains, scenario.allocator) == (proposal.gains, proposal.allocator)
    late = '[plant]\n[[plant.effect]]\nkind = "command-delay"\ntime_ms = 5.0\n'
    scenario = load(tmp_path, PROPOSED.format("paper-case-b") + late)
    assert scenario.gains == om.propose_controller(scenario.vehicle, 0.001, 0.005).gains


def test_attitude_gives_way_of_the_base_stays(tmp_path: Path) -> None:
    assert load(tmp_path, PROPOSED.format("tour")).attitude_gives_way
    assert not load(tmp_path, PROPOSED.format("hover")).attitude_gives_way


ONE_OF_EACH = "position_per_s2 = 9.0\nrate_per_s = [8.0, 8.0, 7.0]\nallocator.W1_per_Hz4 = 1e-8\n"
FIXED = """[controller.allocator]
kind = "fixed-tilt"
W1_per_Hz4 = 1e-8
W2_position_s4_per_m2 = [1.0, 2.0, 3.0]
W2_attitude_s4_per_rad2 = [4.0, 5.0, 6.0]
W3_per_Hz4 = 1e-9
"""


def test_single_values_stand_in_place_of_proposed_ones(tmp_path: Path) -> None:
    """All others are those proposed, to the last bit; provenance says which were given."""
    scenario = load(tmp_path, PROPOSED.format("hover") + ONE_OF_EACH)
    proposal = om.propose_controller(scenario.vehicle, scenario.plant.control_period)
    W1 = to_SI(1e-8, "per_Hz4")
    assert scenario.proposed
    assert scenario.gains == replace(proposal.gains, position=9.0, rate=(8.0, 8.0, 7.0))
    assert scenario.allocator == replace(proposal.allocator, W1=W1)
    assert scenario.overrides == {
        "position": 9.0,
        "rate": (8.0, 8.0, 7.0),
        "allocator": {"W1": W1},
    }
    written = scenario.as_file()["controller"]["overrides"]
    assert written == {
        "position_per_s2": 9.0,
        "rate_per_s": (8.0, 8.0, 7.0),
        "allocator": {"W1_per_Hz4": pytest.approx(1e-8, rel=1e-15)},
    }
    assert "overrides" not in om.load_scenario("tour").as_file()["controller"]


def test_overrides_stay_with_another_vehicle(tmp_path: Path) -> None:
    scenario = load(tmp_path, PROPOSED.format("tour") + ONE_OF_EACH)
    flown = scenario.for_vehicle(QUADROTOR)
    proposal = om.propose_controller(QUADROTOR)
    assert flown.overrides == scenario.overrides
    assert flown.gains == replace(proposal.gains, position=9.0, rate=(8.0, 8.0, 7.0))
    assert flown.allocator == replace(proposal.allocator, W1=to_SI(1e-8, "per_Hz4"))
    stiffer = om.replaced(flown, {"controller.position": 10.0})
    assert (stiffer.proposed, stiffer.overrides) == (False, {})
    assert stiffer.gains.velocity == flown.gains.velocity


def test_a_rule_of_another_kind_replaces_the_proposed_one(tmp_path: Path) -> None:
    scenario = load(tmp_path, PROPOSED.format("tour") + FIXED)
    assert scenario.allocator.kind == "fixed-tilt"
    assert scenario.for_vehicle(QUADROTOR).allocator == scenario.allocator
    assert scenario.gains == om.load_scenario("tour").gains
    three = changed(FIXED, "fixed-tilt", "exhaustive-tilt") + 'span = "window"\ncandidates = 5\n'
    searching = load(tmp_path, PROPOSED.format("tour") + three)
    with pytest.raises(ScenarioError, match="exhaustive-tilt") as caught:
        searching.for_vehicle(QUADROTOR)
    assert "fly tour" not in str(caught.value)


def test_overrides_of_a_base_and_of_its_user(tmp_path: Path) -> None:
    (tmp_path / "base.toml").write_text(PROPOSED.format("tour") + ONE_OF_EACH)
    for proposed in ("", "proposed = true\n"):
        upper = 'schema = 1\nname = "mine"\nbase = "base.toml"\n[controller]\n' + proposed
        scenario = load(tmp_path, upper + "position_per_s2 = 7.0\nallocator.W3_per_Hz4 = 1e-9\n")
        assert scenario.overrides["position"] == 7.0
        assert scenario.overrides["rate"] == (8.0, 8.0, 7.0)
        assert scenario.overrides["allocator"].keys() == {"W1", "W3"}
    of_its_own = load(tmp_path, upper + FIXED)
    assert of_its_own.overrides["allocator"] == of_its_own.allocator
    own_gains = PROPOSED.format("paper-case-b") + "position_per_s2 = 7.0\n"
    assert load(tmp_path, own_gains).overrides == {"position": 7.0}


@pytest.mark.parametrize(
    ("lines", "sentence"),
    [
        ("position_per_s2 = -9.0", "controller.position_per_s2 is -9.0, but it must be one number"),
        ("positoin_per_s2 = 9.0", "controller.positoin_per_s2 is not a known key; did you mean po"),
        ("allocator = 3", "controller.allocator is 3, but it must be a table"),
        ("allocator.W1_per_Hz4 = -1.0", "controller.allocator.W1_per_Hz4 is -1.0, but it must be"),
        ("allocator.W4 = 1.0", "controller.allocator.W4 is not a known key; allowed: kind,"),
        ('allocator.kind = "best"', 'controller.allocator.kind is "best", but it must be one of'),
        ('allocator.kind = "fixed-tilt"', "controller.allocator.W1_per_Hz4 is missing, but it mus"),
    ],
)
def test_values_that_nothing_proposed_has(lines: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError) as caught:
        load(tmp_path, PROPOSED.format("tour") + lines + "\n")
    assert str(caught.value).startswith(f"{tmp_path / 'mine.toml'}: {sentence}")


def test_a_kind_that_is_stated_is_kept_or_refused(tmp_path: Path) -> None:
    stated = 'allocator.kind = "three-candidates"\nallocator.W1_per_Hz4 = 1e-8\n'
    scenario = load(tmp_path, PROPOSED.format("tour") + stated)
    assert scenario.as_file()["controller"]["overrides"]["allocator"]["kind"] == "three-candidates"
    with pytest.raises(ScenarioError, match=r"allocator\.kind is .three-candidates., but it must"):
        scenario.for_vehicle(QUADROTOR)
    joint = replace(om.load_scenario("tour").for_vehicle(VEHICLES["independent-tilts"]))
    joint = replace(
        joint,
        allocator=replace(joint.allocator, W4=1.0),  # type: ignore[call-arg]
        overrides={"allocator": {"W4": 1.0}},
    )
    with pytest.raises(ScenarioError, match=r"allocator\.W4 is 1\.0, but it must be left out, as"):
        joint.for_vehicle(QUADROTOR)


@pytest.mark.parametrize(
    "overrides",
    [3, {"position": 1.0}, {"positoin": 1.0}, {"allocator": 3}, {"allocator": {"W": 1}}],
)
def test_overrides_that_the_controller_does_not_hold(overrides: Any) -> None:
    with pytest.raises(ScenarioError, match=r"^tour: (overrides|controller)"):
        replace(om.load_scenario("tour"), overrides=overrides)


def test_overrides_of_what_is_not_proposed() -> None:
    hover = om.load_scenario("hover")
    with pytest.raises(ScenarioError, match=r"overrides is .* left out, as the controller is not"):
        replace(hover, overrides={"position": hover.gains.position})


def test_what_is_not_proposed_is_reported_whole(tmp_path: Path) -> None:
    reported = 'schema = 1\nname = "mine"\nbase = "tour"\n[controller]\nproposed = false\n'
    with pytest.raises(ScenarioError, match=r"controller\.allocator is missing, but it must be"):
        load(tmp_path, reported)
    with pytest.raises(ScenarioError, match=r'controller\.proposed is "yes", but it must be true'):
        load(tmp_path, changed(PROPOSED.format("hover"), "true", '"yes"'))
    with pytest.raises(ScenarioError, match=r"controller\.propsed is not a known key; did you"):
        load(tmp_path, 'schema = 1\nname = "mine"\nbase = "hover"\ncontroller.propsed = true\n')
    with pytest.raises(ScenarioError, match=r"controller\.positionfirst is not a known key"):
        load(tmp_path, PROPOSED.format("hover") + "positionfirst = true\n")


def test_a_vehicle_that_cannot_fly_is_refused_by_its_file(tmp_path: Path) -> None:
    from omnimorph.design import vehicle_text

    (tmp_path / "heavy.toml").write_text(vehicle_text(build_star(4, mass=2.0, name="heavy")))
    with pytest.raises(InputError, match="cannot fly: its rotors lift at most") as caught:
        load(tmp_path, 'schema = 1\nname = "mine"\nbase = "tour"\nvehicle = "heavy.toml"\n')
    assert str(caught.value).startswith(f"{tmp_path / 'mine.toml'}: vehicle heavy cannot fly: ")


@pytest.mark.parametrize("name", ["hover", "tour"])
def test_no_scenario_takes_a_vehicle_that_cannot_fly(name: str) -> None:
    heavy = replace(om.load_vehicle("omnimorph"), name="heavy", mass=20.0)
    with pytest.raises(InputError, match=r"^vehicle heavy"):
        om.load_scenario(name).for_vehicle(heavy)


def test_another_vehicle_gets_its_own_controller() -> None:
    tour, quadrotor = om.load_scenario("tour"), QUADROTOR
    flown = tour.for_vehicle(quadrotor)
    proposal = om.propose_controller(quadrotor)
    assert (flown.gains, flown.allocator) == (proposal.gains, proposal.allocator)
    assert flown.vehicle is quadrotor
    assert flown.reference is tour.reference
    assert flown.for_vehicle(tour.vehicle).gains == tour.gains
    assert flown.as_file()["controller"]["proposed"] is True


def test_what_is_given_stays() -> None:
    hover = om.load_scenario("hover")
    other = hover.for_vehicle(om.load_vehicle("omnimorph-2026"))
    assert (other.gains, other.allocator) == (hover.gains, hover.allocator)
    with pytest.raises(ScenarioError) as caught:
        hover.for_vehicle(QUADROTOR)
    assert str(caught.value) == (
        "scenario hover: its controller.allocator three-candidates does not fit vehicle "
        f"{QUADROTOR.name} with 0 servos; fly tour, or another scenario with [controller] "
        "proposed = true, which takes the controller from the vehicle, or write one with "
        "fixed-tilt."
    )


def test_the_start_tilt_is_kept_as_far_as_the_servos_turn() -> None:
    tour = om.load_scenario("tour")
    assert tour.for_vehicle(QUADROTOR).tilt.shape == (0,)
    leant = tour.vehicle.replace(servo_angle_min=np.array([0.1]))
    np.testing.assert_array_equal(tour.for_vehicle(leant).tilt, [0.1])
    from_quadrotor = tour.for_vehicle(QUADROTOR).for_vehicle(leant)
    np.testing.assert_array_equal(from_quadrotor.tilt, [0.1])
    apart = replace(
        tour.for_vehicle(build_tilting_star(6, **LAGGED)), start_tilt=np.linspace(0, 0.1, 6)
    )
    with pytest.raises(VehicleError, match="one for each of the 1 servos"):
        apart.for_vehicle(om.load_vehicle("omnimorph"))


VEHICLES = {
    "omnimorph": om.load_vehicle("omnimorph"),
    "omnimorph-2026": om.load_vehicle("omnimorph-2026"),
    "quadrotor": QUADROTOR,
    "canted": build_star(6, cant=math.radians(20.0), **LAGGED),
    "hardly-canted": build_star(6, cant=math.radians(5.0), **LAGGED),
    "heavy-quadrotor": build_star(4, mass=1.3, **LAGGED),
    "heavy-canted": build_star(6, cant=math.radians(20.0), mass=1.8, **LAGGED),
    "slow-quadrotor": build_star(4, time_constant_up=0.06, time_constant_down=0.04),
    "slow-canted": build_star(6, cant=0.35, time_constant_up=0.06, time_constant_down=0.04),
    "independent-tilts": build_tilting_star(6, **LAGGED),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", VEHICLES)
def test_every_vehicle_completes_the_tour(name: str) -> None:
    scenario = om.load_scenario("tour").for_vehicle(VEHICLES[name])
    for seed in range(10):
        run = om.fly(scenario, seed=seed)
        assert run.outcome is om.Outcome.COMPLETED
        assert run.metrics.position_error_max_m < 0.05
        assert run.metrics.attitude_error_mean_rad < 0.03
        assert np.linalg.norm(run.p_WB[-1] - run.desired_p_WB[-1]) < 0.02
        heading = math.atan2(run.R_WB[-1, 1, 0], run.R_WB[-1, 0, 0])
        assert heading == pytest.approx(math.pi / 2, abs=0.02)


def test_a_tour_in_the_core_alone() -> None:
    """The quick one of them: the vehicle of the catalogue's file."""
    run = om.fly(om.load_scenario("tour"))
    assert run.outcome is om.Outcome.COMPLETED
    assert run.metrics.position_error_max_m < 0.005
