"""One class of a vehicle wherever it is named; several servos are never judged by a common tilt."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.physics.small_vehicles import build_star, build_tilting_star, build_vehicle

import omnimorph as om
from omnimorph.analysis.actuation import ActuationKind, ThrustKind, VehicleClass
from omnimorph.analysis.attitude_share import attitude_share
from omnimorph.analysis.free_tilt import dimension_over_tilts
from omnimorph.analysis.overview import VehicleAnalysis
from omnimorph.cli import analyze as command
from omnimorph.design import Vehicle
from omnimorph.report.analysis_data import analysis_data
from omnimorph.report.analysis_summary import key_points
from omnimorph.studies.comparison import Compared, comparison_data, platform_table
from omnimorph.viewer.design import Design
from omnimorph.viewer.explorer_page import numbers_of
from omnimorph.viewer.tables import Row

UNDER, FULLY, REDUNDANT = ActuationKind
NO_WAY, ONE_WAY, SOME_WAYS, ALL_WAYS = ThrustKind
EXPECTED = {
    "quadrotor": (UNDER, ONE_WAY),
    "canted quadrotor": (UNDER, ONE_WAY),
    "tilt-hex": (FULLY, SOME_WAYS),
    "fast-hex": (FULLY, SOME_WAYS),
    "omnicopter": (REDUNDANT, ALL_WAYS),
    "omnimorph": (REDUNDANT, ALL_WAYS),
    "tilting star": (FULLY, SOME_WAYS),
    "tilting-quad": (FULLY, SOME_WAYS),
    "voliro": (FULLY, ALL_WAYS),
    "omav-12": (REDUNDANT, ALL_WAYS),
}
LONG = ("omnimorph", "fast-hex", "tilting-quad", "voliro", "omav-12")
SERVOS = ["tilting star", "tilting-quad", "voliro", "omav-12"]


def each_of(names: Iterable[str]) -> pytest.MarkDecorator:
    """Go through vehicles; those that take seconds are slow."""
    marked = [pytest.param(one, marks=pytest.mark.slow) if one in LONG else one for one in names]
    return pytest.mark.parametrize("name", marked)


@cache
def vehicle_of(name: str) -> Vehicle:
    if name == "canted quadrotor":
        return build_star(4, cant=math.radians(15.0), mass=0.8)
    if name == "tilting star":
        return build_tilting_star(4, servo_angle_min=-0.3, servo_angle_max=0.3)
    return om.load_vehicle(name)


@cache
def analysis_of(name: str) -> VehicleAnalysis:
    return om.analysis.analyze(vehicle_of(name))


def compared(name: str) -> Compared:
    """Return its row of a comparison, without the flight."""
    found = analysis_of(name).platform
    return Compared(vehicle=vehicle_of(name), platform=found, flown=None)


@cache
def explored(name: str) -> dict[str, Row]:
    """Return what the explorer shows."""
    return {row.key: row for row in numbers_of(Design.of(vehicle_of(name)).view())}


def printed(name: str) -> str:
    """Return what the command prints, without line ends."""
    return " ".join(command._as_text(analysis_of(name)).split())


@each_of(EXPECTED)
def test_everything_names_the_same_class(name: str) -> None:
    words = str(VehicleClass(*EXPECTED[name]))
    analysis = analysis_of(name)
    assert str(analysis.platform.vehicle_class) == words
    assert platform_table([compared(name)]).rows[0][-1] == words
    in_data = analysis_data(analysis)["over_all_tilts"]
    assert f"{in_data['actuation']}; {in_data['thrust']}" == words
    (of_comparison,) = comparison_data([compared(name)])["vehicles"]
    assert in_data == {key: of_comparison[key] for key in in_data}
    rows = explored(name)
    assert rows["class" if vehicle_of(name).n_servos else "kind"].values == [words]
    assert words in printed(name).split("rank A")[0], "before the table"


@each_of(SERVOS)
def test_servos_that_tilt_alone_are_not_judged_by_a_common_tilt(name: str) -> None:
    """Command, page and explorer say first how they judge, with the numbers of `compare`."""
    analysis, found = analysis_of(name), compared(name).platform
    first = f"judges all {found.n_servos} servos at one common tilt"
    radius = f"radius {found.radius_over_weight:.3g}, sideways force"
    text = printed(name)
    assert first in text
    assert text.index(first) < text.index(radius) < text.index("rank A")
    assert "it can hover, all servos at one tilt" in text
    points = key_points(analysis)
    assert first in points[0].text
    assert radius in points[0].text
    for head, words in points[1:]:
        if re.search("omnidirectional", head, re.IGNORECASE):
            assert head.endswith("with all servos at one tilt"), words
    rows = list(explored(name).values())
    assert [row.key for row in rows][:4] == ["class", "free-radius", "free-lateral", "kind"]
    assert rows[1].values == [f"{found.radius_over_weight:.3g}"]
    assert rows[3].label == "class at the tilts set, as all below"


@pytest.mark.parametrize(
    ("vehicle", "dimension"),
    [
        (build_star(4), 1),
        (build_star(6, cant=0.4), 3),
        (build_tilting_star(4), 3),
        (build_tilting_star(6), 3),
        (build_tilting_star(4, hinge_axis=np.tile([1.0, 0.0, 0.0], (4, 1))), 2),
        (build_vehicle([[0.1, 0.0, 0.0]]), 0),
    ],
)
def test_dimension_of_the_forces_over_all_tilts(vehicle: Vehicle, dimension: int) -> None:
    assert dimension_over_tilts(vehicle) == dimension
    if vehicle.n_servos == 0:
        assert om.analysis.force_set(vehicle, 0.0, zero_moment=True).dimension == dimension


LEANING, UPRIGHT = [0.6, 0.0, 0.8], [0.0, 0.0, 1.0]


def build_through_the_middle(axes: list[list[float]], **changes: Any) -> Vehicle:
    """Build pairs of rotors that push through the centre of mass, turning against each other."""
    places = [sign * 0.1 * np.array(axis) for axis in axes for sign in (1.0, -1.0)]
    spins = {"rotor_spin": [1.0, -1.0] * len(axes), "mass": 0.7}
    twice = [axis for axis in axes for _ in range(2)]
    return build_vehicle([place.tolist() for place in places], twice, **(spins | changes))


# --- shares of attitudes --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vehicle", "words"),
    [
        (build_star(4, mass=0.8), "level only"),
        (build_star(4, mass=0.8, speed_min=-600.0), "level and upside down only"),
        (build_star(4, cant=0.2, mass=0.8), "level only"),
        (build_star(6, mass=3.0), "none"),
        (build_star(6, cant=0.3, speed_min=590.0), "none"),  # its least lift is twice the weight
        (build_star(6, cant=0.3, speed_min=599.9, mass=2.103), "less than 0.01 %"),
        (build_vehicle([[0.0, 0.0, 0.1], [0.0, 0.0, -0.1]] * 2, [[0.6, 0.0, 0.8]] * 4), "none"),
        (build_through_the_middle([LEANING], speed_min=0.0), "one leaning only"),
        (build_through_the_middle([LEANING]), "two leaning only"),
        (
            build_through_the_middle([LEANING, UPRIGHT], speed_min=-600.0),
            "single ones about one axis",
        ),
        (build_through_the_middle([UPRIGHT], mass=99.0), "none"),
        (om.load_vehicle("omnicopter"), "all"),
    ],
)
def test_attitudes_without_area_are_no_share(vehicle: Vehicle, words: str) -> None:
    found = attitude_share(vehicle, om.analysis.force_set(vehicle, 0.0, zero_moment=True))
    assert found.words == words
    assert found.share == (1.0 if words == "all" else 0.0)


def test_the_share_of_attitudes_is_that_of_the_cap() -> None:
    """Against attitudes drawn at random."""
    vehicle = om.load_vehicle("tilt-hex")
    forces = om.analysis.force_set(vehicle, 0.0, zero_moment=True)
    generator = np.random.default_rng(1)
    up = generator.normal(size=(100_000, 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    held = (vehicle.mass * 9.81 * up @ forces.normals.T <= forces.offsets).all(axis=1)
    found = attitude_share(vehicle, forces)
    assert found.share == pytest.approx(float(held.mean()), abs=1.5e-3)
    assert found.words == f"{100.0 * found.share:.3g} %"


def test_a_grid_that_holds_level_counts_no_share() -> None:
    """The explorer's attitudes hold level itself: one of 902 is not 0.111 %."""
    assert explored("quadrotor")["hovers"].values == ["level only"]
    assert "share of all attitudes: level only" in printed("quadrotor")
    (at,) = json.loads(json.dumps(analysis_data(analysis_of("quadrotor"))))["at_tilt"]
    assert (at["attitudes_share"], at["attitudes"]) == (0.0, "level only")
