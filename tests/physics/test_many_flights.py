"""Many flights at once are the flights one by one: every effect, allocator, vehicle and number."""

from __future__ import annotations

import functools
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from tests.unit.test_effects import EXAMPLES

import omnimorph as om
from omnimorph import _core, effects
from omnimorph.model.core import state_row
from omnimorph.protocols import FloatArray
from omnimorph.results.run import COLUMNS
from omnimorph.simulation.effects import Effect

N = 6  # more than the lanes of one register and no multiple of them, for AVX2 and SSE
NOISE = effects.MeasurementNoise(position=1e-3, velocity=1e-2, attitude=3e-3, rate=1e-2)


def two_seconds(
    name: str = "paper-case-b",
    worn: Sequence[Effect] = (NOISE,),
    integrator: str = "semi-implicit-euler",
) -> om.Scenario:
    """Return a scenario whose first two seconds are flown, with control at 250 Hz."""
    whole = om.load_scenario(name)

    class Beginning:
        duration = 2.0
        __call__ = whole.reference.__call__

        def sample(self, times: FloatArray) -> FloatArray:
            return rows_of(name, tuple(times.tolist()))

    plant = om.PlantModel(
        control_period=4e-3,
        effects=tuple(worn),
        integrator=integrator,  # type: ignore[arg-type]
    )
    return replace(whole, reference=Beginning(), plant=plant)


@functools.cache
def rows_of(name: str, times: tuple[float, ...]) -> FloatArray:
    """Return the rows of a scenario's reference, computed once for all flights here."""
    wishes = om.load_scenario(name).reference
    return np.array([state_row(*wishes(time)) for time in times])


def assert_same(one: om.Run, other: om.Run) -> None:
    """Compare every number of two runs, bit by bit."""
    assert one.outcome == other.outcome
    for column in COLUMNS:
        np.testing.assert_array_equal(getattr(one, column.name), getattr(other, column.name))


def assert_as_alone(scenario: om.Scenario) -> om.Flights:
    """Fly a batch and each of its flights alone; return the batch."""
    flights = om.fly_many(scenario, N, seed=5, first=11, keep="all")
    assert flights.number.tolist() == list(range(11, 11 + N))
    for number in flights.number.tolist():
        assert_same(flights.runs[number], om.fly(scenario, seed=5, flight=number))
    return flights


@pytest.mark.parametrize("integrator", ["semi-implicit-euler", "runge-kutta-4"])
@pytest.mark.parametrize("effect", EXAMPLES, ids=lambda effect: effect.kind)
def test_each_effect_is_the_same_in_a_batch(effect: Effect, integrator: str) -> None:
    worn = (effect,) if isinstance(effect, effects.MeasurementNoise) else (effect, NOISE)
    flights = assert_as_alone(two_seconds(worn=worn, integrator=integrator))
    assert len({flights.runs[number].content_hash for number in flights.runs}) == N


def test_all_effects_together_are_the_same_in_a_batch() -> None:
    bearable = [
        replace(effect, share=0.9) if isinstance(effect, effects.Effectiveness) else effect
        for effect in EXAMPLES
        if not isinstance(effect, effects.ConstantWrench | effects.SpeedLimits)
    ]
    assert_as_alone(two_seconds(worn=bearable))


def rules() -> dict[str, om.Scenario]:
    """Return a scenario for each way to allocate."""
    base = two_seconds()
    paper = base.allocator
    weights = {name: getattr(paper, name) for name in ("W1", "W2_position", "W2_attitude", "W3")}
    return {
        "three candidates": base,
        "window": replace(
            base, allocator=om.ExhaustiveTilt(**weights, span="window", candidates=7)
        ),
        "range": replace(base, allocator=om.ExhaustiveTilt(**weights, span="range", candidates=13)),
        "fixed": replace(base, allocator=om.FixedTilt(**weights), start_tilt=0.7),
        "jointly": replace(base, allocator=om.JointTilt(**weights, W4=0.01)),
        "position first": replace(base, attitude_gives_way=True),
    }


@pytest.mark.parametrize("rule", list(rules()))
def test_each_allocator_is_the_same_in_a_batch(rule: str) -> None:
    assert_as_alone(rules()[rule])


@pytest.mark.parametrize("vehicle", om.list_vehicles())
def test_each_vehicle_is_the_same_in_a_batch(vehicle: str) -> None:
    assert_as_alone(two_seconds("tour").for_vehicle(om.load_vehicle(vehicle)))


FLIGHT_HASHES = (
    "import omnimorph as om\n"
    "from tests.physics.test_many_flights import EXAMPLES, rules, two_seconds\n"
    "worn = [EXAMPLES[1], EXAMPLES[3], EXAMPLES[8], EXAMPLES[13]]\n"
    "scenarios = [two_seconds(worn=worn), rules()['jointly']]\n"
    "vary = {'mass': om.Normal(1.0, 0.02)}\n"
    "flights = [om.fly_many(one, 9, keep='all', vary=vary) for one in scenarios]\n"
    "print(flights[0].performance.instruction_set)\n"
    "print(*(run.content_hash for some in flights for run in some.runs.values()))\n"
)


def flight_hashes(instruction_set: str) -> list[str]:
    """Return the hashes of some flights, computed with an instruction set in a new process."""
    answer = subprocess.run(
        [sys.executable, "-c", FLIGHT_HASHES],
        env=os.environ | {"OMNIMORPH_SIMD": instruction_set},
        capture_output=True,
        text=True,
        check=True,
    )
    reported, hashes = answer.stdout.splitlines()
    assert reported == instruction_set
    return hashes.split()


def test_every_instruction_set_that_is_built_gives_the_same_flights() -> None:
    known = _core.instruction_sets()
    reported = [flight_hashes(name) for name in known]
    assert len(reported[0]) == 18
    assert all(hashes == reported[0] for hashes in reported)


def test_threads_and_repeats_change_no_bit() -> None:
    scenario = two_seconds()
    once = om.fly_many(scenario, 40, keep="all", threads=1)
    again = om.fly_many(scenario, 40, keep="all", threads=3)
    for number in once.runs:
        assert_same(once.runs[number], again.runs[number])
    for name, column in once.metrics.as_dict().items():
        assert np.array_equal(column, again.metrics.as_dict()[name])


def test_a_flight_does_not_depend_on_how_many_fly_beside_it() -> None:
    vary = {"mass": om.Uniform(0.9, 1.1), "start_attitude": om.Normal(0.0, 0.05)}
    many = om.fly_many(two_seconds(), 20, vary=vary, keep=[13])
    few = om.fly_many(two_seconds(), 1, first=13, vary=vary, keep=[13])
    assert_same(many.runs[13], few.runs[13])
    assert many.varied["mass"][13] == few.varied["mass"][0]


# --- metrics ------------------------------------------------------------------------------------


def assert_metrics(found: om.Flights, row: int, run: om.Run) -> None:
    """Compare the metrics of a flight with those of its run, but for rounding of long sums."""
    for name, value in vars(run.metrics).items():
        reported = getattr(found.metrics[row], name)
        wanted = value if isinstance(value, str) else pytest.approx(value, rel=1e-12, nan_ok=True)
        assert reported == wanted, name


@pytest.mark.parametrize("vehicle", ["omnimorph", "quadrotor", "voliro"])
def test_metrics_are_those_of_the_runs(vehicle: str) -> None:
    scenario = om.load_scenario("tour").for_vehicle(om.load_vehicle(vehicle))
    flights = om.fly_many(scenario, 3, keep=[2])
    assert_metrics(flights, 2, flights.runs[2])
    assert_metrics(flights, 1, om.fly(scenario, flight=1))


def test_lost_flights_are_measured_as_far_as_they_came_and_disturb_none() -> None:
    factors = np.ones(N)
    factors[[1, 4]] = 9.0  # too heavy
    scenario = two_seconds(worn=())
    flights = om.fly_many(scenario, N, vary={"mass": factors}, keep="all")
    assert flights.metrics.outcome == (
        "completed", "lost", "completed", "completed", "lost", "completed",
    )  # fmt: skip
    assert flights.completed.tolist() == [True, False, True, True, False, True]
    for row, factor in enumerate(factors.tolist()):
        worn = replace(scenario.plant, effects=(effects.ModelMismatch(mass=factor),))
        alone = om.fly(replace(scenario, plant=worn), flight=row)
        assert_same(flights.runs[row], alone)
        assert_metrics(flights, row, alone)


def test_a_flight_that_overflows_is_distinguished_from_the_others() -> None:
    noise = np.ones(N)
    noise[2] = 1e160
    flights = om.fly_many(two_seconds(), N, vary={"noise": noise}, keep="all")
    assert flights.metrics.outcome[2] == "not_finite"
    assert set(np.delete(np.array(flights.metrics.outcome), 2)) == {"completed"}
    assert_metrics(flights, 2, flights.runs[2])
    assert_same(flights.runs[3], om.fly(two_seconds(), flight=3))


# --- single precision ---------------------------------------------------------------------------


def test_single_precision_says_so_and_stays_near() -> None:
    """Docs/many-flights.md tells how near, over whole flights."""
    double = om.fly_many(two_seconds(), N, keep="all")
    single = om.fly_many(two_seconds(), N, keep="all", precision="float32")
    assert (double.precision, single.precision) == ("float64", "float32")
    assert '"precision": "float32"' in single.runs[0].provenance.scenario_text
    for number in range(N):
        apart = np.abs(single.runs[number].p_WB - double.runs[number].p_WB).max()
        assert 0.0 < apart < 1e-5
