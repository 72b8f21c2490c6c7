"""What is drawn for a path, and what cannot vary and is refused with the reason."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.physics.test_many_flights import assert_same
from tests.unit.test_variation import EVERY_PATH, HOVER, OTHERS, RICH, assert_as_alone

import omnimorph as om
from omnimorph.errors import InputError
from omnimorph.simulation import variation
from omnimorph.simulation.paths import paths, replaced, value_at
from omnimorph.simulation.variation import SHARED, VARIABLE, draw

# --- what is drawn --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "shape"),
    [
        ("truth.mass", ()),
        ("truth.thrust_coefficient", (8,)),  # one a rotor
        ("truth.thrust_coefficient[3]", ()),
        ("controller.allocator.W1", (8,)),
        ("plant.effectiveness.share", (8,)),
        ("vehicle.rotor_position", (8, 3)),
        ("vehicle.rotor_position[2]", (3,)),
        ("start_tilt", (1,)),
        ("plant.rotor-lag.down", ()),
    ],
)
def test_a_distribution_draws_every_number_at_a_path(path: str, shape: tuple[int, ...]) -> None:
    scenario, spread_over = RICH["every effect"], om.Uniform(0.2, 0.8)
    many = draw({path: spread_over}, scenario, 9, 0, 40).drawn[path]
    assert many.shape == (40, *shape)
    assert np.unique(many).size == many.size
    few = draw({path: spread_over}, scenario, 9, 17, 4).drawn[path]
    np.testing.assert_array_equal(few, many[17:21])
    other = draw({"vehicle.mass": spread_over}, scenario, 9, 0, 40).drawn["vehicle.mass"]
    assert not np.isin(many, other).any()


def test_one_number_a_flight_stands_for_all_rotors() -> None:
    scenario, path = RICH["every effect"], "vehicle.thrust_coefficient"
    one = value_at(scenario, path)[0] * np.array([1.0, 1.1])  # type: ignore[index]
    flights = om.fly_many(scenario, 2, vary={path: one}, keep="all")
    assert_as_alone(flights, 1, replaced(scenario, {path: one[1]}))
    each = om.fly_many(scenario, 2, vary={path: np.tile(one[:, np.newaxis], 8)}, keep="all")
    assert_same(each.runs[1], flights.runs[1])


def test_no_path_is_a_key() -> None:
    assert set(paths(RICH["every effect"])).isdisjoint(VARIABLE)


# --- what is refused ------------------------------------------------------------------------------


def refusal(scenario: om.Scenario, vary: dict[Any, Any], n: int = 2, first: int = 0) -> str:
    with pytest.raises(InputError) as caught:
        om.fly_many(scenario, n, first=first, vary=vary)
    message = str(caught.value)
    assert "\n" not in message
    assert message[-1] in ".?"
    return message


SOME = om.Uniform(1.0, 2.0)


@pytest.mark.parametrize(
    ("vary", "sentence"),
    [
        (
            {"vehicle.mas": SOME},
            ": vehicle.mas is not a known key or path; did you mean vehicle.mass",
        ),
        ({"mas": SOME}, "mas is not a known key or path; did you mean mass or vehicle.mass or tru"),
        ({"start_tlit": SOME}, "did you mean start_tilt"),
        ({"zzz": SOME}, "zzz is not a known key or path; they are mass, inertia, thrust_coeffic"),
        ({"zzz": SOME}, "start_rate, or begin with vehicle, truth, plant, plant.rotor-lag, "),
        ({3: SOME}, "3 is not a known key or path"),
        ({"plant.servo-lag.time_constant": SOME}, "because plant realistic has no servo-lag"),
        ({"vehicle.mass[0]": SOME}, "one without an index"),
        ({"truth.mass": [1.0]}, 'vary: truth.mass is "of shape (1,)"'),
        ({"truth.mass": "heavy"}, 'truth.mass is "heavy", but it must be a distribution'),
        ({"truth.thrust_coefficient": np.ones((2, 3))}, "or an array of 2 rows of 8 numbers"),
        ({"truth.inertia": np.ones((2, 3))}, "or an array of 2 arrays of shape (3, 3)"),
        ({"truth.mass": [1.3, -1.0]}, "vary, flight 1: vehicle omnimorph: mass is -1.0, but it m"),
        ({"truth.mass": [-1.0, 1.3]}, "vary, flight 0: vehicle omnimorph: mass is -1.0, but it m"),
        ({"truth.mass": [1.3, np.nan]}, "flight 1: scenario hover: truth.mass is nan"),
        ({"vehicle.rotor_position": [0.1, 0.2]}, "flight 0: scenario hover: vehicle.rotor_positi"),
        ({"controller.position": [1.0, -2.0]}, "vary, flight 1: pose-tracking: position is -2.0"),
        ({"start_tilt": [0.0, 2.0]}, "flight 1: hover: start_tilt_deg is [114.59"),
        ({"truth.mass": om.Normal(-5.0, 0.1)}, "vary, flight 0: vehicle omnimorph: mass is -"),
        ({"lost_beyond": [1.0, 2.0]}, "lost_beyond cannot vary, because a batch has one bound"),
        ({"plant.physics_step": SOME}, "plant.physics_step cannot vary, because the flights of a"),
    ],
)
def test_what_cannot_vary_is_refused_in_one_sentence(vary: dict[Any, Any], sentence: str) -> None:
    assert sentence in refusal(HOVER, vary)


def test_a_refusal_names_the_flight_by_its_number() -> None:
    reported = refusal(HOVER, {"truth.mass": [1.3, 1.4, -1.0]}, n=3, first=70)
    assert reported.startswith("vary, flight 72: ")


@pytest.mark.parametrize("path", [path for path in SHARED if path in EVERY_PATH])
def test_nothing_that_a_batch_shares_slips_through(
    path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Were it not on the list, the core's own places would tell."""
    monkeypatch.setattr(variation, "SHARED", {})
    for name, scenario in RICH.items():
        if path in paths(scenario):
            own = np.array(value_at(scenario, path))
            other = {
                "plant.physics_step": 0.5e-3,
                "plant.control_period": 4e-3,
                "plant.command-delay.time": 5e-3,
                "controller.allocator.candidates": 7.0,
            }.get(path, 0.9 * own + 0.02)
            reported = refusal(scenario, {path: np.stack([own, np.array(other)])})
            assert (
                f"vary, flights 0 and 1: {path} cannot vary so, because the core has one"
                in reported
            ), name


def test_which_rotors_are_in_line_is_shared() -> None:
    """The core would take the pairs of the first flight in its lanes for the others'."""
    path = "truth.rotor_position[0][0]"
    where = value_at(OTHERS["wakes"], path)
    assert isinstance(where, float)
    reported = refusal(OTHERS["wakes"], {path: [where, where + 0.5]})
    assert (
        "cannot vary so, because all flights of a batch share which rotors are in line" in reported
    )
    flights = om.fly_many(OTHERS["wakes"], 2, vary={path: [where, where + 1e-4]}, keep="all")
    assert_as_alone(flights, 1, replaced(OTHERS["wakes"], {path: where + 1e-4}))


@pytest.mark.parametrize("other", [2.9e4, 3e4 * (1.0 + 1e-9)])  # which is 3e4 in single precision
def test_weights_are_alike_in_all_directions_or_not(other: float) -> None:
    """If not, the core looks at accelerations in W, in all lanes, and rounds otherwise."""
    path = "controller.allocator.W2_position"
    alike, not_alike = [3e4] * 3, [3e4, other, 2.8e4]
    reported = refusal(HOVER, {path: [alike, [3e4, 3e4, other]]})
    assert "W2_position weighs all directions alike either in all flights" in reported
    flights = om.fly_many(HOVER, 2, vary={path: [not_alike, [3e4, 2.9e4, 2.9e4]]}, keep="all")
    assert_as_alone(flights, 0, replaced(HOVER, {path: not_alike}))


def test_the_attitude_gives_way_in_all_flights_or_in_none() -> None:
    """A heavier vehicle no longer hovers in every attitude, and what it can push is bounded."""
    scenario = replace(OTHERS["fixed"], attitude_gives_way=True)
    masses = [scenario.vehicle.mass, 2.0 * scenario.vehicle.mass]
    forces = [replaced(scenario, {"vehicle.mass": mass}).lateral_force for mass in masses]
    assert [force == np.inf for force in forces] == [True, False]
    reported = refusal(scenario, {"vehicle.mass": masses})
    assert "the attitude gives way either in all flights of a batch or in none" in reported


@pytest.mark.parametrize("path", [Path("truth.mass"), b"truth.mass", None, 3])
def test_a_path_is_a_text(path: Any) -> None:
    with pytest.raises(InputError, match="is not a known key or path"):
        om.fly_many(HOVER, 2, vary={path: [1.3, 1.4]})


@pytest.mark.parametrize("index", ["03", "-1", "٣", " 3", "1.0"])
def test_an_index_is_written_in_one_way(index: str) -> None:
    with pytest.raises(InputError, match="is not a known key or path"):
        om.fly_many(HOVER, 2, vary={f"truth.thrust_coefficient[{index}]": [1e-5, 1e-5]})


@pytest.mark.parametrize("numbers", [["1.3", "1.4"], [1.3 + 1j, 1.4], np.array([1, 2], "m8[s]")])
def test_numbers_are_real_numbers(numbers: Any) -> None:
    with pytest.raises(InputError, match=r"truth\.mass is .* an array of 2 numbers"):
        om.fly_many(HOVER, 2, vary={"truth.mass": numbers})
