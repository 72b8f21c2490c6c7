"""Scenarios whose controller comes from the vehicle: in files, and with another vehicle."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star, build_tilting_star
from tests.unit.scenario_parts import changed

import omnimorph as om
from omnimorph.errors import InputError, ScenarioError, VehicleError

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


def test_proposed_and_given_is_refused(tmp_path: Path) -> None:
    for line in ("position_per_s2 = 9.0", 'allocator.kind = "fixed-tilt"'):
        with pytest.raises(ScenarioError, match="left out where proposed = true") as caught:
            load(tmp_path, PROPOSED.format("hover") + line + "\n")
        assert caught.value.key == f"controller.{line.split()[0].split('.')[0]}"
    reported = 'schema = 1\nname = "mine"\nbase = "tour"\n[controller]\nrate_per_s = 9.0\n'
    with pytest.raises(ScenarioError, match=r"controller\.rate_per_s is 9\.0, but"):
        load(tmp_path, reported)


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
