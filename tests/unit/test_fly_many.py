"""What `fly_many` draws, keeps, refuses and leaves when it is interrupted."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation
from tests.physics.test_many_flights import NOISE, assert_same, two_seconds

import omnimorph as om
from omnimorph import effects
from omnimorph.errors import InputError, ScenarioError
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.simulation.variation import VARIABLE, draw

LAG = effects.RotorLag(up=0.02, down=0.03)
REST = np.zeros(3)


def flown(name: str, values: object, scenario: om.Scenario) -> om.Run:
    """Return the only flight of a batch in which one parameter has these values."""
    return om.fly_many(scenario, 1, vary={name: np.array([values])}, keep=[0]).runs[0]


# --- what varies --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "values", "effect"),
    [
        ("mass", 1.07, effects.ModelMismatch(mass=1.07)),
        ("inertia", 1.2, effects.ModelMismatch(inertia=1.2)),
        ("thrust_coefficient", [0.93] * 8, effects.ModelMismatch(thrust_coefficient=0.93)),
        ("drag_coefficient", [1.3] * 8, effects.ModelMismatch(drag_coefficient=1.3)),
        (
            "effectiveness",
            [1.0, 0.7, 1.0, 1.0, 0.9, 1.0, 1.0, 1.0],
            effects.Effectiveness(share=(1.0, 0.7, 1.0, 1.0, 0.9, 1.0, 1.0, 1.0)),
        ),
        ("force", [0.3, 0.2, 0.1], effects.ConstantWrench(force=(0.3, 0.2, 0.1))),
        ("torque", [0.01, 0.02, 0.0], effects.ConstantWrench(torque=(0.01, 0.02, 0.0))),
    ],
)
def test_a_parameter_is_the_effect_of_its_name(
    name: str, values: object, effect: effects.Effect
) -> None:
    alone = om.fly(two_seconds(worn=(NOISE, LAG, effect)))
    assert_same(flown(name, values, two_seconds(worn=(NOISE, LAG))), alone)


def test_lag_and_noise_are_factors_of_the_plants_own() -> None:
    base = two_seconds(worn=(NOISE, LAG))
    slower = om.fly(two_seconds(worn=(NOISE, effects.RotorLag(up=0.03, down=0.045))))
    found = flown("rotor_lag", 1.5, base)
    np.testing.assert_allclose(found.p_WB, slower.p_WB, rtol=0, atol=1e-9)
    louder = effects.MeasurementNoise(position=2e-3, velocity=2e-2, attitude=6e-3, rate=2e-2)
    assert_same(flown("noise", 2.0, base), om.fly(two_seconds(worn=(louder, LAG))))


def test_a_centre_of_mass_aside_is_where_the_rotors_push_from() -> None:
    """Hovering, the rotors' torque about the model's centre of mass is offset × force."""
    offset = np.array([5e-3, 0.0, 0.0])
    scenario = replace(om.load_scenario("hover"), plant=om.PlantModel())
    run = flown("centre_of_mass", offset, scenario)
    force, torque = run.wrench_achieved[-1, :3], run.wrench_achieved[-1, 3:]
    assert np.linalg.norm(force) == pytest.approx(scenario.vehicle.mass * 9.81, rel=1e-5)
    np.testing.assert_allclose(torque, 0.0, atol=1e-5)
    by_model = om.allocation_matrix(scenario.vehicle, run.tilt_actual[-1]) @ run.thrust_command[-1]
    np.testing.assert_allclose(by_model[3:], np.cross(offset, force), atol=1e-5)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("start_position", [0.02, -0.01, 0.03]),
        ("start_velocity", [0.1, 0.2, -0.1]),
        ("start_rate", [0.1, -0.2, 0.3]),
        ("start_attitude", [0.1, 0.2, -0.1]),
    ],
)
def test_a_start_is_beside_the_references(name: str, values: list[float]) -> None:
    scenario = two_seconds()
    usual, run = om.fly(scenario), flown(name, values, scenario)
    moved = {
        "start_position": run.p_WB[0] - usual.p_WB[0],
        "start_velocity": run.v_WB[0],
        "start_rate": run.w_WB_B[0],
        "start_attitude": Rotation.from_matrix(usual.R_WB[0].T @ run.R_WB[0]).as_rotvec(),
    }
    np.testing.assert_allclose(moved[name], values, rtol=0, atol=1e-12)
    assert run.outcome is om.Outcome.COMPLETED


def test_a_start_attitude_turns_about_the_axes_of_the_body() -> None:
    """R₀ᵀ R = exp(v): from an attitude that is not upright the axes of W would be others."""
    turned = Rotation.from_rotvec([0.4, -0.7, 0.5]).as_matrix()
    reference = SegmentReference((0.0, 0.0, 1.0), turned, [Segment(0.1)])
    scenario = replace(two_seconds(), reference=reference)
    vector = np.array([0.1, 0.2, -0.15])
    run = flown("start_attitude", vector, scenario)
    away = Rotation.from_matrix(turned.T @ run.R_WB[0]).as_rotvec()
    np.testing.assert_allclose(away, vector, atol=1e-12)


# --- what is drawn ------------------------------------------------------------------------------


def drawn(name: str, wanted: Any, seed: int, first: int, n: int) -> np.ndarray[Any, Any]:
    """Return the numbers of one parameter."""
    return draw({name: wanted}, two_seconds(worn=(NOISE, LAG)), seed, first, n).drawn[name]


@pytest.mark.parametrize("name", VARIABLE)
def test_numbers_follow_their_distribution(name: str) -> None:
    numbers = drawn(name, om.Uniform(0.5, 1.5), seed=3, first=0, n=4000)
    for column in numbers.reshape(4000, -1).T:
        assert stats.kstest(column, "uniform", args=(0.5, 1.0)).pvalue > 1e-4
    numbers = drawn(name, om.Normal(10.0, 1.0), seed=4, first=0, n=4000)
    for column in numbers.reshape(4000, -1).T:
        assert stats.kstest(column, "norm", args=(10.0, 1.0)).pvalue > 1e-4
    numbers = drawn(name, stats.expon(loc=1.0), seed=5, first=0, n=4000)
    for column in numbers.reshape(4000, -1).T:
        assert stats.kstest(column, "expon", args=(1.0,)).pvalue > 1e-4


def test_parameters_components_seeds_and_flights_are_independent() -> None:
    each = [
        drawn(name, om.Uniform(0.5, 1.5), seed, 0, 4000).reshape(4000, -1)
        for name in VARIABLE
        for seed in (3, 4)
    ]
    columns = np.hstack([*each, *(numbers[::-1] for numbers in each[:1])])
    correlation = np.corrcoef(columns.T) - np.eye(columns.shape[1])
    assert np.abs(correlation).max() < 6.0 / np.sqrt(4000)
    follows = np.corrcoef(columns[1:, 0], columns[:-1, 0])[0, 1]
    assert abs(follows) < 6.0 / np.sqrt(4000)


@pytest.mark.parametrize("name", ["mass", "force", "effectiveness"])
def test_a_flights_numbers_are_its_own(name: str) -> None:
    many = drawn(name, om.Uniform(0.5, 1.5), seed=9, first=0, n=50)
    for first in (1, 2, 3, 17):
        few = drawn(name, om.Uniform(0.5, 1.5), seed=9, first=first, n=4)
        assert np.array_equal(few, many[first : first + 4])


# --- what is kept -------------------------------------------------------------------------------


def test_only_what_is_asked_for_is_kept(tmp_path: Any) -> None:
    flights = om.fly_many(two_seconds(), 9, first=100, keep=[108, 100, 100])
    assert list(flights.runs) == [100, 108]
    flights.runs[108].save(tmp_path / "kept.nc")
    again = om.load_run(tmp_path / "kept.nc")
    assert_same(again, flights.runs[108])
    assert again.provenance.flight == 108


def test_a_kept_run_tells_what_made_it_differ() -> None:
    flights = om.fly_many(two_seconds(), 2, vary={"mass": om.Uniform(1.0, 1.1)}, keep="all")
    reported = f'"vary": {{"mass": {float(flights.varied["mass"][1])!r}}}'
    assert reported in flights.runs[1].provenance.scenario_text


def test_memory_is_bounded_by_what_is_kept() -> None:
    """At most 2 kB a flight of which only the metrics are kept, by the process's own peak."""
    program = (
        "import re, omnimorph as om\n"
        "from dataclasses import replace\n"
        "from tests.physics.test_many_flights import two_seconds\n"
        "whole = two_seconds()\n"
        "class Short:\n"
        "    duration = 0.002\n"
        "    def __call__(self, time): return whole.reference(time)\n"
        "scenario = replace(whole, reference=Short())\n"
        "om.fly_many(scenario, 1000)\n"
        "def peak():  # bytes; of this process alone, not of the one it was started from\n"
        "    status = open('/proc/self/status').read()\n"
        "    return 1024 * int(re.search(r'VmHWM: *\\t? *([0-9]+)', status)[1])\n"
        "before = peak()\n"
        "om.fly_many(scenario, 200_000, vary={'mass': om.Uniform(0.9, 1.1)})\n"
        "print((peak() - before) / 200_000)\n"
    )
    answer = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert 100 < float(answer.stdout) < 2000


# --- what is refused ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"n": 0}, "n is 0"),
        ({"n": -3}, "n is -3"),
        ({"n": 2.5}, "n is 2.5"),
        ({"n": True}, "n is true"),
        ({"n": 2**40}, f"n is {2**40}"),
        ({"n": 4, "seed": -1}, "seed is -1"),
        ({"n": 4, "first": 2**32}, "first is"),
        ({"n": 4, "threads": 0}, "threads is 0"),
        ({"n": 4, "precision": "float16"}, "float64 or float32"),
        ({"n": 4, "keep": [4]}, "keep is 4"),
        ({"n": 4, "keep": "some"}, "keep is"),
        ({"n": 4, "keep": 3}, "keep is 3"),
        ({"n": 4, "plant": "no-such-plant"}, "no-such-plant"),
        ({"n": 4, "vary": {"maas": om.Uniform(1, 2)}}, "did you mean mass"),
        ({"n": 4, "vary": {"mass": "heavy"}}, 'mass is "heavy"'),
        ({"n": 4, "vary": {"mass": [1.0, 1.1]}}, "of shape (2,)"),
        ({"n": 4, "vary": {"force": np.ones(4)}}, "4 rows of 3 numbers"),
        ({"n": 4, "vary": {"mass": [1.0, 1.1, -0.2, 1.0]}}, "flight 2: mass is -0.2"),
        ({"n": 4, "first": 7, "vary": {"mass": [1.0, 1.1, 1.0, np.nan]}}, "flight 10: mass is nan"),
        ({"n": 4, "vary": {"mass": om.Normal(-5.0, 1.0)}}, "flight 0: mass is -"),
        ({"n": 2, "vary": {"effectiveness": -np.ones((2, 8))}}, "flight 0: effectiveness is [-1"),
        ({"n": 4, "vary": {"rotor_lag": om.Uniform(1, 2)}}, "has no rotor-lag"),
    ],
)
def test_what_cannot_be_flown_is_refused_in_one_sentence(
    arguments: dict[str, Any], expected: str
) -> None:
    with pytest.raises(InputError) as caught:
        om.fly_many(two_seconds(), **arguments)
    message = str(caught.value)
    assert expected in message
    assert message[-1] in ".?"
    assert "\n" not in message


@pytest.mark.parametrize("make", [lambda: om.Uniform(2.0, 1.0), lambda: om.Normal(0.0, -1.0)])
def test_a_distribution_that_is_none_is_refused(make: Any) -> None:
    with pytest.raises(ScenarioError):
        make()


def test_an_instruction_set_that_is_not_there_is_named() -> None:
    answer = subprocess.run(
        [sys.executable, "-c", "import omnimorph as om; om.fly_many"],
        env=os.environ | {"OMNIMORPH_SIMD": "mmx"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode != 0
    assert 'OMNIMORPH_SIMD is "mmx", but it must be one that this processor has' in answer.stderr


# --- progress and interrupts --------------------------------------------------------------------


def test_progress_ends_with_all() -> None:
    reported: list[tuple[int, int]] = []
    om.fly_many(two_seconds(), 10, progress=lambda done, of: reported.append((done, of)))
    assert reported[-1] == (10, 10)


def test_an_error_in_progress_is_the_callers() -> None:
    def fails(done: int, of: int) -> None:
        raise LookupError("mine")

    with pytest.raises(LookupError, match="mine"):
        om.fly_many(om.load_scenario("paper-case-a"), 100, progress=fails)


def test_an_interrupt_returns_what_is_finished() -> None:
    program = (
        "import signal, omnimorph as om, numpy as np\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a shell's & ignores it
        "scenario = om.load_scenario('paper-case-a')\n"
        "say = lambda done, of: print(done, flush=True)\n"
        "flights = om.fly_many(scenario, 100_000, progress=say, threads=2, keep=[1, 99_999])\n"
        "alone = om.fly(scenario, flight=1)\n"
        "same = np.array_equal(flights.runs[1].p_WB, alone.p_WB)\n"
        "print('left', len(flights), flights.interrupted, flights.completed.all(), same,\n"
        "      99_999 in flights.runs)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        while int(process.stdout.readline()) < 16:
            pass
        process.send_signal(signal.SIGINT)
        try:
            out, err = process.communicate(timeout=60)
        finally:
            process.kill()  # but for a failure it has ended
    assert err == ""
    assert process.returncode == 0
    left, count, *reported = out.splitlines()[-1].split()
    assert left == "left"
    assert 16 <= int(count) < 100_000
    assert reported == ["True", "True", "True", "False"]
