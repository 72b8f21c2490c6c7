"""The controller proposed for a vehicle: what bounds it, how it flies, and what cannot be flown."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star, build_tilting_star, build_vehicle

import omnimorph as om
from omnimorph.analysis.free_tilt import reach_over_tilts
from omnimorph.control.allocators import AllocationRule
from omnimorph.control.capability import capability
from omnimorph.errors import InputError, ScenarioError, VehicleError
from omnimorph.model.allocation import allocation_matrix
from omnimorph.model.dynamics import GRAVITY

OMNIMORPH = om.load_vehicle("omnimorph")
LAGGED = {"time_constant_up": 0.02, "time_constant_down": 0.015}
VEHICLES = {
    "omnimorph": OMNIMORPH,
    "omnimorph-2026": om.load_vehicle("omnimorph-2026"),
    "quadrotor": build_star(4, **LAGGED),
    "canted": build_star(6, cant=math.radians(20.0), **LAGGED),
    "hardly-canted": build_star(6, cant=math.radians(5.0), **LAGGED),
    "heavy-quadrotor": build_star(4, mass=1.3, **LAGGED),
    "heavy-canted": build_star(6, cant=math.radians(20.0), mass=1.8, **LAGGED),
    "slow-quadrotor": build_star(4, time_constant_up=0.06, time_constant_down=0.04),
    "independent-tilts": build_tilting_star(6, **LAGGED),
}
TWO_ROTORS = build_vehicle([(0.2, 0, 0), (-0.2, 0, 0)], mass=0.5, rotor_spin=[1.0, -1.0])
EVERY_VEHICLE = pytest.mark.parametrize("vehicle", VEHICLES.values(), ids=VEHICLES.keys())


# --- what a vehicle has to spare ------------------------------------------------------------------


def test_a_quadrotor_by_hand() -> None:
    """Four rotors of 3.6 N at 0.2 m, 1 kg: each has 1.1475 N above hover and more below."""
    quadrotor = build_star(4)
    f_max, hover = 1e-5 * 600.0**2, GRAVITY / 4.0
    spare = f_max - hover
    found = capability(quadrotor)
    assert found.leans
    assert found.vertical == pytest.approx(4.0 * spare)
    # roll: two rotors at ±0.2 m; yaw: all four by their drag of kappa = 0.02 m
    moment = np.array([2 * 0.2 * spare, 2 * 0.2 * spare, 4 * 0.02 * spare])
    np.testing.assert_allclose(found.angular, moment / np.diag(quadrotor.inertia))
    assert found.effort == pytest.approx(4.0 * (hover / 1e-5) ** 2)


def test_the_weaker_sense_of_a_moment_counts() -> None:
    """Two of the four rotors, those that turn one way round, are faster: more yaw one way."""
    spin = np.array([1.0, -1.0, 1.0, -1.0])
    for faster in (1.0, -1.0):
        lopsided = build_star(4, speed_max=np.where(spin == faster, 640.0, 600.0))
        hover = GRAVITY / 4.0
        fast, slow = (1e-5 * w**2 for w in (640.0, 600.0))
        # The total stays the weight, so what one pair gains the other loses; kappa is 0.02 m.
        strong, weak = (2 * 0.02 * min(f - hover, hover) * 2 for f in (fast, slow))
        assert weak < strong
        moments = om.analysis.moment_set(lopsided, [], force=[0.0, 0.0, GRAVITY])
        reach = sorted(moments.reach([0.0, 0.0, sign]) for sign in (1.0, -1.0))
        np.testing.assert_allclose(reach, [weak, strong])
        yaw = capability(lopsided).angular[2]
        assert yaw == pytest.approx(weak / lopsided.inertia[2, 2])


@EVERY_VEHICLE
def test_what_is_to_spare_can_be_made(vehicle: om.Vehicle) -> None:
    found = capability(vehicle)
    wrenches = om.analysis.wrench_set(vehicle, found.tilt)
    weight = np.array([0.0, 0.0, vehicle.mass * GRAVITY])
    for axis in range(3):
        for sign in (-1.0, 1.0):
            unit = sign * np.eye(3)[axis]
            most = found.vertical if axis == 2 else found.sideways
            force = weight + vehicle.mass * most * unit
            if axis == 2 or not found.turns:
                assert wrenches.contains([*force, 0.0, 0.0, 0.0])
            else:  # made at other tilts
                side = vehicle.mass * most * (1.0 - 1e-9)
                assert reach_over_tilts(vehicle, unit[None], weight)[0] >= side
            moment = vehicle.inertia @ (found.angular[axis] * unit)
            assert wrenches.contains([*weight, *moment])


# --- gains ----------------------------------------------------------------------------------------


@EVERY_VEHICLE
def test_bandwidth_damping_and_authority(vehicle: om.Vehicle) -> None:
    gains = om.propose_controller(vehicle).gains
    found = capability(vehicle)
    k = np.concatenate([gains.axes("position"), gains.axes("attitude")])
    d = np.concatenate([gains.axes("velocity"), gains.axes("rate")])
    np.testing.assert_allclose(d, 2.0 * np.sqrt(k))
    lag = max(vehicle.time_constant_up.max(), vehicle.time_constant_down.max()) + 0.002
    crossover = np.sqrt((d**2 + np.sqrt(d**4 + 4.0 * k**2)) / 2.0)
    assert (crossover * lag <= 0.5 + 1e-9).all()
    sideways = np.inf if found.leans else found.sideways
    assert (k[:3] * 0.05 <= np.array([sideways, sideways, found.vertical]) + 1e-9).all()
    assert (k[3:] * math.radians(5.0) <= found.angular + 1e-9).all()
    if found.leans or found.turns:
        assert 3.0 * crossover[0] < crossover[3:5].min()


@EVERY_VEHICLE
def test_margins_of_what_is_proposed(vehicle: om.Vehicle) -> None:
    for delay in (0.0, 0.01):
        gains = om.propose_controller(vehicle, delay=delay).gains
        margins = om.stability_margins(gains, vehicle, delay=delay)
        assert (margins.phase_margin > math.radians(45.0)).all()
        assert (margins.gain_margin > 3.0).all()


def test_slower_actuators_and_delay_make_it_softer() -> None:
    firm = om.propose_controller(OMNIMORPH).gains.axes("attitude")
    for changes in ({"delay": 0.01}, {"control_period": 0.02}):
        assert (om.propose_controller(OMNIMORPH, **changes).gains.axes("attitude") < firm).all()


@EVERY_VEHICLE
def test_the_qp_is_as_well_conditioned_as_case_b(vehicle: om.Vehicle) -> None:
    def condition(vehicle: om.Vehicle, rule: AllocationRule) -> float:
        A = allocation_matrix(vehicle, capability(vehicle).tilt)
        G = np.vstack([A[:3] / vehicle.mass, np.linalg.solve(vehicle.inertia, A[3:])])
        W2 = np.diag([*rule.W2_position, *rule.W2_attitude])
        own = rule.per_thrust(vehicle, "W1") + rule.per_thrust(vehicle, "W3")
        return float(np.linalg.cond(G.T @ W2 @ G + np.diag(own)))

    case_b = om.load_scenario("paper-case-b").allocator
    rule = om.propose_controller(vehicle).allocator
    assert condition(vehicle, rule) < 10.0 * condition(OMNIMORPH, case_b)


def test_the_weights_of_omnimorph_are_nearly_case_b() -> None:
    proposed = om.propose_controller(OMNIMORPH).allocator
    case_b = om.load_scenario("paper-case-b").allocator
    assert proposed.kind == "three-candidates"
    scale = case_b.W1 / proposed.W1  # type: ignore[operator]
    assert proposed.W3 == proposed.W1
    np.testing.assert_allclose(np.multiply(scale, proposed.W2_position), 3e4, rtol=0.2)
    np.testing.assert_allclose(np.multiply(scale, proposed.W2_attitude[:2]), 10.0, rtol=0.1)


def test_neither_length_nor_force_unit_matters() -> None:
    """A vehicle of doubled mass, inertia and thrust is flown with the same gains."""
    small = VEHICLES["canted"]
    large = small.replace(
        mass=2.0 * small.mass,
        inertia=2.0 * small.inertia,
        thrust_coefficient=2.0 * small.thrust_coefficient,
        drag_coefficient=2.0 * small.drag_coefficient,
    )
    one, other = om.propose_controller(small), om.propose_controller(large)
    np.testing.assert_allclose(one.gains.position, other.gains.position)
    np.testing.assert_allclose(one.gains.attitude, other.gains.attitude)
    np.testing.assert_allclose(one.allocator.W1, other.allocator.W1)
    np.testing.assert_allclose(one.allocator.W2_attitude, other.allocator.W2_attitude)


def test_reasons_tell_what_bounds_each_gain() -> None:
    reasons = " ".join(om.propose_controller(build_star(4, **LAGGED)).reasons)
    assert "sideways: k = 1.799/s², it moves so by leaning" in reasons
    assert (
        "up and down: k = 91.8/s², 5 cm of error may ask for no more than the 4.59 m/s²" in reasons
    )
    assert "roll: k = 121.9/s², the lag of 22 ms" in reasons
    assert "at 48°" in om.propose_controller(OMNIMORPH).reasons[-1]


# --- flights --------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("case", ["paper-case-a", "paper-case-b"])
def test_omnimorph_flies_the_papers_way_as_well_as_with_the_papers_gains(case: str) -> None:
    papers = om.load_scenario(case)
    proposed = om.propose_controller(OMNIMORPH)
    own = replace(papers, gains=proposed.gains, allocator=proposed.allocator)
    for seed in range(2):
        first, second = (om.fly(scenario, seed=seed).metrics for scenario in (papers, own))
        assert second.position_error_mean_m < 2.5 * first.position_error_mean_m
        assert second.position_error_max_m < 0.004
        assert second.attitude_error_mean_rad < 2.0 * first.attitude_error_mean_rad


# --- what cannot be flown -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vehicle", "reason"),
    [
        (build_star(4, mass=1.6), "it cannot hover level"),
        (build_star(4, mass=4.0 * 3.6 / GRAVITY * (1 - 1e-8)), "no thrust left to climb"),
        (TWO_ROTORS, "no moment about body x"),
        (build_star(4, rotor_spin=1.0, drag_coefficient=1e-12, mass=0.2), "cannot hover level"),
        (build_star(4, mass=1.466), "leave no gain that is firm enough"),
    ],
)
def test_what_cannot_fly_is_refused_in_a_sentence(vehicle: om.Vehicle, reason: str) -> None:
    with pytest.raises(VehicleError, match=reason) as caught:
        om.propose_controller(vehicle)
    assert str(caught.value).startswith("vehicle small: no controller is proposed: ")


@pytest.mark.parametrize("vehicle", [OMNIMORPH, VEHICLES["quadrotor"]], ids=["omnimorph", "quad"])
def test_a_delay_too_long_is_refused_with_the_longest(vehicle: om.Vehicle) -> None:
    with pytest.raises(ScenarioError, match=r"delay is 0\.9, but it must be at most") as caught:
        om.propose_controller(vehicle, delay=0.9)
    longest = float(str(caught.value.allowed).split()[2])
    assert om.propose_controller(vehicle, delay=0.999 * longest)
    with pytest.raises(ScenarioError, match="at most"):
        om.propose_controller(vehicle, delay=1.001 * longest)


@pytest.mark.parametrize(
    "times", [{"delay": -1.0}, {"delay": math.nan}, {"control_period": 0.0}, {"control_period": -1}]
)
def test_times_are_checked(times: dict[str, float]) -> None:
    with pytest.raises(InputError, match="but it must be a"):
        om.propose_controller(OMNIMORPH, **times)
    with pytest.raises(InputError, match="but it must be a"):
        om.stability_margins(om.TrackingGains(), OMNIMORPH, **times)


# --- the page -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_page_tells_what_comes_out() -> None:
    page = (Path(__file__).parents[2] / "docs" / "gains.md").read_text(encoding="utf-8")
    papers = om.load_scenario("paper-case-b")
    proposal = om.propose_controller(OMNIMORPH)
    own = replace(papers, gains=proposal.gains, allocator=proposal.allocator)
    cells: list[list[str]] = []
    for scenario in (papers, own):
        margins = om.stability_margins(scenario.gains, OMNIMORPH)
        metrics = om.fly(scenario).metrics
        before = om.fly(replace(scenario, plant=om.load_plant("realistic-1"))).metrics
        both = [0, 3]
        w, phase = margins.crossover[both], np.degrees(margins.phase_margin[both])
        delay = 1e3 * margins.delay_margin[both]
        mean, most = metrics.position_error_mean_m * 1e3, metrics.position_error_max_m * 1e3
        cells.append(
            [
                f"{w[0]:.1f}, {w[1]:.1f} rad/s",
                f"{phase[0]:.0f}°, {phase[1]:.0f}°",
                f"{delay[0]:.1f}, {delay[1]:.1f} ms",
                f"{mean:.2f}, {most:.1f} mm",
                f"{metrics.attitude_error_mean_rad:.4f}",
                f"{before.attitude_error_mean_rad:.4f}",
                f"{metrics.drag_energy_paper:.0f}",
            ]
        )
    for first, second in zip(*cells, strict=True):
        assert f"| {first} | {second} |" in page
