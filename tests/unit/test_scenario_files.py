"""Scenario files: what they say, and every way to be wrong. Plants: see test_plant_files.py."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.unit.scenario_parts import (
    PLANT,
    POSES,
    SAMPLES,
    SEGMENTS,
    TOP,
    WAYPOINTS,
    changed,
    refusal,
)

import omnimorph as om
from omnimorph.errors import ScenarioError
from omnimorph.units import to_SI

# --- what is wrong in a scenario ------------------------------------------------------------------

WRONG_AT_THE_TOP = [
    ("schema = 1", "schema = 2", "schema", "is 2, but it must be 1"),
    ("schema = 1", "", "schema", "is missing, but it must be 1"),
    ("schema = 1", 'schema = "1"', "schema", 'is "1", but it must be 1'),
    ('name = "mine"', "", "name", "is missing, but it must be a name"),
    ('name = "mine"', 'name = ""', "name", 'is "", but it must be a name'),
    ('name = "mine"', "name = 3", "name", "is 3, but it must be a name"),
    ('name = "mine"', 'name = "mine"\nnmae = 1', "nmae", "did you mean name"),
    ('vehicle = "omnimorph"', "", "vehicle", "is missing, but it must be a name of the catalogue"),
    ('vehicle = "omnimorph"', "vehicle = 3", "vehicle", "is 3, but it must be a name"),
    ('plant = "perfect"', "", "plant", "is missing, but it must be a name of the catalogue"),
    ('plant = "perfect"', "plant = 3", "plant", "is 3, but it must be a name of the catalogue"),
    ('plant = "perfect"', 'plant = ""', "plant", 'is "", but it must be a name of the catalogue'),
    ("schema = 1", "schema = 1\nstart_tilt_deg = 61", "start_tilt_deg", "within 0 to 60 degrees"),
    ("schema = 1", "schema = 1\nstart_tilt_deg = nan", "start_tilt_deg", "a finite number"),
    ("schema = 1", "schema = 1\nlost_beyond_m = 0", "lost_beyond_m", "a positive number of metres"),
    ("schema = 1", "schema = 1\nlost_beyond_m = inf", "lost_beyond_m", "a positive number"),
    ("schema = 1", "schema = 1\ntitle = 5", "title", "one line of text"),
    ("schema = 1", "schema = 1\nbase = 3", "base", "the name or file of another scenario"),
    ("schema = 1", 'schema = 1\nbase = "mine.toml"', "base", "not based on this one"),
    ('name = "mine"', 'base = "hover"', "name", "is missing, but it must be the scenario's own"),
]
WRONG_CONTROLLER = [
    ("= 300.0", "= -300.0", "controller.position_per_s2", "is -300.0, but it must be one number"),
    ("= 300.0", '= "a"', "controller.position_per_s2", 'is "a", but it must be one number'),
    ("= 300.0", "= true", "controller.position_per_s2", "is true, but it must be one number"),
    ("= 300.0", "= [1.0, 2.0]", "controller.position_per_s2", "or three (x, y, z)"),
    ("= 300.0", "= inf", "controller.position_per_s2", "is inf, but it must be one number"),
    ("position_per_s2", "position_s2", "controller.position_s2", "did you mean position_per_s2"),
    (
        '"three-candidates"',
        '"two"',
        "controller.allocator.kind",
        "exhaustive-tilt, joint-tilt, fixed-tilt",
    ),
    (
        'kind = "three-candidates"',
        "",
        "controller.allocator.kind",
        "is missing, but it must be one",
    ),
    ("W1_per_Hz4 = 1e-8", "", "controller.allocator.W1_per_Hz4", "is missing, but it must be"),
    ("1e-8", "-1e-8", "controller.allocator.W1_per_Hz4", "is -1e-08, but it must be a number"),
    ("1e-8", "nan", "controller.allocator.W1_per_Hz4", "is nan, but it must be a number"),
    ("1e-8", "[]", "controller.allocator.W1_per_Hz4", "is [], but it must be a number"),
    (
        "W1_per_Hz4",
        "W1",
        "controller.allocator.W1",
        "is not a known key; allowed: kind, W1_per_Hz4",
    ),
    ("[3e6, 3e6, 3e6]", "3e6", "controller.allocator.W2_position_s4_per_m2", "three numbers"),
    ("[1e3, 1e3, 1e3]", "[1e3]", "controller.allocator.W2_attitude_s4_per_rad2", "three numbers"),
]
EXHAUSTIVE = 'kind = "exhaustive-tilt"\nspan = "range"\ncandidates = 61'
ODD = "an odd whole number from 3 to 361"
WRONG_SEARCH = [
    ('"range"', '"wide"', "span", 'is "wide", but it must be "window" or "range"'),
    ('"range"', "3", "span", 'is 3, but it must be "window" or "range"'),
    ('span = "range"', "", "span", 'is missing, but it must be "window" or "range"'),
    ("= 61", "= 4", "candidates", f"is 4, but it must be {ODD}"),
    ("= 61", "= 1", "candidates", f"is 1, but it must be {ODD}"),
    ("= 61", "= 1000", "candidates", f"is 1000, but it must be {ODD}"),
    ("= 61", "= 61.0", "candidates", f"is 61.0, but it must be {ODD}"),
    ("= 61", "= true", "candidates", f"is true, but it must be {ODD}"),
    ("candidates = 61", "", "candidates", f"is missing, but it must be {ODD}"),
    ("candidates", "candidate", "candidate", "did you mean candidates"),
]
WRONG_SEGMENTS = [
    ('"segments"', '"segment"', "reference.kind", "one of segments, waypoints, samples"),
    ('kind = "segments"', "", "reference.kind", "is missing, but it must be one of segments"),
    ("start_position_m = [0.0, 0.0, 1.2]", "", "reference.start_position_m", "three numbers"),
    ("[0.0, 0.0, 1.2]", "[0.0, 1.2]", "reference.start_position_m", "is [0.0, 1.2], but"),
    ("[0.0, 0.0, 1.2]", "[0.0, 0.0, nan]", "reference.start_position_m", "three numbers of metres"),
    ("duration_s = 1.0", "", "reference.segment[0].duration_s", "is missing, but it must be a pos"),
    ("= 1.0", "= 0.0", "reference.segment[0].duration_s", "is 0.0, but it must be a positive"),
    ("= 1.0", '= "1 s"', "reference.segment[0].duration_s", 'is "1 s", but it must be a positive'),
    ("move_m", "move", "reference.segment[0].move", "did you mean move_m"),
    ("[0.0, 0.0, 0.1]", "0.1", "reference.segment[0].move_m", "is 0.1, but it must be three"),
]
WRONG_QUATERNIONS = [
    ("[1, 0, 0]", "is [1, 0, 0], but it must be four numbers w, x, y, z of unit length"),
    ("[1, 1, 0, 0]", "is [1, 1, 0, 0], but it must be four numbers w, x, y, z of unit length"),
    ("[0, 0, 0, 0]", "is [0, 0, 0, 0], but it must be four numbers w, x, y, z of unit length"),
    ("[1, 0, 0, nan]", "but it must be four numbers w, x, y, z of unit length"),
]
WRONG_WAYPOINTS = [
    ("time_s = 2.0", "time_s = 0.0", "times", "at least 1e-06 s after the one before"),
    ("time_s = 0.0", "time_s = -1.0", "reference.waypoint[0].time_s", "from 0 to 1e6"),
    ("time_s = 2.0", "", "reference.waypoint[1].time_s", "is missing, but it must be a number"),
    ("time_s = 2.0", "time_s = inf", "reference.waypoint[1].time_s", "is inf, but it must be"),
    ("[0.0, 0.1, 1.2]", "[0.1]", "reference.waypoint[1].position_m", "three numbers of metres"),
    ("time_s = 2.0", "time = 2.0", "reference.waypoint[1].time", "did you mean time_s"),
]
WRONG_SAMPLES = [
    ('file = "poses.csv"', "", "reference.file", "is missing, but it must be the name of a CSV"),
    ('"poses.csv"', "3", "reference.file", "is 3, but it must be the name of a CSV file"),
    ('"poses.csv"', '""', "reference.file", 'is "", but it must be the name of a CSV file'),
]
WRONG_SCENARIOS = [
    *((SEGMENTS, *case) for case in WRONG_AT_THE_TOP + WRONG_CONTROLLER),
    *((SEGMENTS, *case) for case in WRONG_SEGMENTS),
    *((WAYPOINTS, *case) for case in WRONG_WAYPOINTS),
    *((SAMPLES, *case) for case in WRONG_SAMPLES),
]


@pytest.mark.parametrize(("reference", "old", "new", "key", "allowed"), WRONG_SCENARIOS)
def test_wrong_scenario_is_refused_in_one_sentence(
    tmp_path: Path, reference: str, old: str, new: str, key: str, allowed: str
) -> None:
    whole = TOP + reference
    in_reference = old in reference and reference is not SEGMENTS
    text = changed(reference, old, new) if in_reference else changed(whole, old, new)
    error = refusal(tmp_path, TOP + text if in_reference else text)
    assert error.key == key
    assert allowed in str(error)


@pytest.mark.parametrize(("old", "new", "key", "allowed"), WRONG_SEARCH)
def test_wrong_search_of_the_tilt_is_refused(
    tmp_path: Path, old: str, new: str, key: str, allowed: str
) -> None:
    rule = changed(EXHAUSTIVE, old, new)
    error = refusal(tmp_path, changed(TOP, 'kind = "three-candidates"', rule) + SEGMENTS)
    assert error.key == f"controller.allocator.{key}"
    assert allowed in str(error)


@pytest.mark.parametrize("value", ["-1.0", "nan", "inf", '"1"', "[1.0]", "true"])
def test_wrong_weight_on_the_motion_of_tilts_is_refused(tmp_path: Path, value: str) -> None:
    rule = f'kind = "joint-tilt"\nW4 = {value}'
    error = refusal(tmp_path, changed(TOP, 'kind = "three-candidates"', rule) + SEGMENTS)
    assert error.key == "controller.allocator.W4"
    assert "but it must be a number, not negative" in str(error)


@pytest.mark.parametrize(("line", "W4"), [("", 0.0), ("\nW4 = 2.5", 2.5)])
def test_joint_tilt_is_read_as_it_is_written(tmp_path: Path, line: str, W4: float) -> None:
    rule = f'kind = "joint-tilt"{line}'
    scenario = load(tmp_path, changed(TOP, 'kind = "three-candidates"', rule) + SEGMENTS)
    assert isinstance(scenario.allocator, om.JointTilt)
    assert scenario.allocator.W4 == W4
    assert scenario.as_file()["controller"]["allocator"]["W4"] == W4


def test_exhaustive_tilt_is_read_as_it_is_written(tmp_path: Path) -> None:
    scenario = load(tmp_path, changed(TOP, 'kind = "three-candidates"', EXHAUSTIVE) + SEGMENTS)
    rule = scenario.allocator
    assert isinstance(rule, om.ExhaustiveTilt)
    assert (rule.span, rule.candidates) == ("range", 61)
    content = scenario.as_file()["controller"]["allocator"]
    assert content["kind"] == "exhaustive-tilt"
    assert (content["span"], content["candidates"]) == ("range", 61)
    assert content["W1_per_Hz4"] == pytest.approx(1e-8)


@pytest.mark.parametrize(("quaternion", "allowed"), WRONG_QUATERNIONS)
def test_quaternion_far_from_unit_length_is_refused(
    tmp_path: Path, quaternion: str, allowed: str
) -> None:
    key = "start_quaternion_wxyz"
    text = changed(SEGMENTS, "[[ref", f"{key} = {quaternion}\n[[ref")
    error = refusal(tmp_path, TOP + text)
    assert error.key == f"reference.{key}"
    assert allowed in str(error)
    text = WAYPOINTS + f"quaternion_wxyz = {quaternion}\n"
    error = refusal(tmp_path, TOP + text)
    assert error.key == "reference.waypoint[1].quaternion_wxyz"
    assert allowed in str(error)


def test_axis_far_from_unit_length_is_refused(tmp_path: Path) -> None:
    turn = "rotation_axis_W = [1.0, 1.0, 0.0]\nrotation_angle_deg = 10.0"
    error = refusal(tmp_path, TOP + SEGMENTS + turn)
    assert "rotation_axis_W is [1.0, 1.0, 0.0], but it must be of unit length" in str(error)


@pytest.mark.parametrize(
    ("segment", "found"), [("segment = []", "is []"), ("segment = 3", "is 3"), ("", "is missing")]
)
def test_a_reference_has_segments(tmp_path: Path, segment: str, found: str) -> None:
    error = refusal(tmp_path, TOP + SEGMENTS[: SEGMENTS.index("[[")] + segment)
    assert error.key == "reference.segment"
    assert f"{found}, but it must be one segment or more" in str(error)


def test_waypoints_are_two_or_more(tmp_path: Path) -> None:
    error = refusal(tmp_path, TOP + WAYPOINTS[: WAYPOINTS.rindex("[[")])
    assert error.key == "reference.waypoint"
    assert "two waypoints or more" in str(error)


@pytest.mark.parametrize(
    ("old", "new", "near"),
    [
        ('vehicle = "omnimorph"', 'vehicle = "omnimorf"', "did you mean omnimorph"),
        ('plant = "perfect"', 'plant = "perfekt"', "did you mean perfect"),
        ('plant = "perfect"', 'plant = "none.toml"', "there is no such file"),
        ('vehicle = "omnimorph"', 'vehicle = "none.toml"', "there is no such file"),
    ],
)
def test_parts_that_do_not_exist(tmp_path: Path, old: str, new: str, near: str) -> None:
    assert near in str(refusal(tmp_path, changed(TOP, old, new) + SEGMENTS))


@pytest.mark.parametrize(
    ("poses", "problem"),
    [
        (None, "cannot be read"),
        ("time_s,x_m,y_m\n0,0,0\n", "column z_m is missing"),
        (POSES.replace("1.5", "a"), 'line 3, column z_m is "a", but it must be a finite number'),
        (POSES.replace("2,0,0,1", "1,0,0,1"), "later than the time before"),
        (POSES[:27], "but it must hold 2 or more"),
    ],
)
def test_pose_tables_are_checked(tmp_path: Path, poses: str | None, problem: str) -> None:
    if poses is not None:
        (tmp_path / "poses.csv").write_text(poses)
    reported_of = "mine.toml" if poses is None else "poses.csv"
    error = refusal(tmp_path, TOP + SAMPLES, reported_of)
    assert f"{tmp_path / 'poses.csv'}: " in str(error)
    assert problem in str(error)


@pytest.mark.parametrize("weights", ["0.0", "[0, 0, 0, 0, 0, 0, 0, 0]"])
def test_weights_that_leave_the_problem_singular(tmp_path: Path, weights: str) -> None:
    text = changed(TOP, "W1_per_Hz4 = 1e-8", f"W1_per_Hz4 = {weights}")
    error = refusal(tmp_path, changed(text, "W3_per_Hz4 = 1e-5", "W3_per_Hz4 = 0.0") + SEGMENTS)
    assert "positive, or W3 must be" in str(error)


def test_weights_for_another_number_of_rotors(tmp_path: Path) -> None:
    error = refusal(tmp_path, changed(TOP, "1e-8", "[1e-8, 1e-8]") + SEGMENTS)
    assert "one for each of the 8 rotors" in str(error)


@pytest.mark.parametrize("text", ["[reference", "a = 1\na = 2\n", "=", "\x00"])
def test_what_is_not_toml(tmp_path: Path, text: str) -> None:
    assert "not valid TOML" in str(refusal(tmp_path, text))


def test_an_empty_file_lacks_its_schema_first(tmp_path: Path) -> None:
    assert refusal(tmp_path, "").key == "schema"


def test_names_that_lead_nowhere(tmp_path: Path) -> None:
    (tmp_path / "latin.toml").write_bytes(b'name = "\xe9"')
    for name, problem in (
        ("hovver", "did you mean hover"),
        ("something-else", "known are hover, paper-case-a"),
        (str(tmp_path / "none.toml"), "there is no such file"),
        (tmp_path, "it is a directory"),
        (tmp_path / "latin.toml", "not a text file in UTF-8"),
    ):
        with pytest.raises(ScenarioError) as caught:
            om.load_scenario(name)
        assert problem in str(caught.value)
        assert "\n" not in str(caught.value)


# --- what they say --------------------------------------------------------------------------------


def load(folder: Path, text: str) -> om.Scenario:
    """Return the scenario of a text."""
    (folder / "mine.toml").write_text(text)
    return om.load_scenario(folder / "mine.toml")


def test_units_are_converted(tmp_path: Path) -> None:
    tilted = changed(TOP, "schema = 1", "schema = 1\nstart_tilt_deg = 30.0")
    scenario = load(tmp_path, tilted + SEGMENTS)
    np.testing.assert_allclose(scenario.tilt, np.pi / 6)
    rule = scenario.allocator
    assert isinstance(rule, om.ThreeCandidates)
    assert to_SI(1e-8, "per_Hz4") == rule.W1
    assert rule.W2_position == (3e6, 3e6, 3e6)
    assert scenario.gains == om.TrackingGains()
    assert scenario.reference.duration == 1.0
    np.testing.assert_allclose(scenario.reference(1.0).p_WB, [0.0, 0.0, 1.3])
    assert scenario.lost_beyond == 2.0
    assert scenario.plant == om.load_plant("perfect")


@pytest.mark.parametrize(
    ("reference", "duration", "highest"), [(WAYPOINTS, 2.0, 1.2), (SAMPLES, 2.0, 1.5)]
)
def test_waypoints_and_tables_of_poses_fly(
    tmp_path: Path, reference: str, duration: float, highest: float
) -> None:
    (tmp_path / "poses.csv").write_text(POSES)
    run = om.fly(load(tmp_path, TOP + reference))
    assert run.outcome is om.Outcome.COMPLETED
    assert run.time[-1] == pytest.approx(duration)
    assert run.p_WB[:, 2].max() == pytest.approx(highest, abs=1e-3)


@pytest.mark.parametrize("file", ["poses.csv", "poses", "tables/poses.txt"])
def test_pose_table_is_looked_for_beside_the_scenario(tmp_path: Path, file: str) -> None:
    (tmp_path / "tables").mkdir()
    (tmp_path / file).write_text(POSES)
    scenario = load(tmp_path, TOP + changed(SAMPLES, "poses.csv", file))
    assert scenario.reference.duration == 2.0


def test_start_in_an_attitude_nearly_of_unit_length(tmp_path: Path) -> None:
    half = f"start_quaternion_wxyz = [{0.5**0.5 * 1.005}, {0.5**0.5 * 1.005}, 0, 0]\n"
    scenario = load(tmp_path, TOP + changed(SEGMENTS, "[[ref", half + "[[ref"))
    quarter_roll = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    np.testing.assert_allclose(scenario.reference(0.0).R_WB, quarter_roll, atol=1e-12)


def test_a_base_gives_what_is_left_out(tmp_path: Path) -> None:
    text = 'schema = 1\nname = "mine"\nbase = "paper-case-a"\n[controller]\nrate_per_s = 50.0\n'
    scenario, base = load(tmp_path, text), om.load_scenario("paper-case-a")
    assert scenario.name == "mine"
    assert scenario.gains == replace(base.gains, rate=50.0)
    assert scenario.allocator == base.allocator
    assert scenario.plant == base.plant
    assert scenario.reference.duration == 45.0


def test_a_table_of_another_kind_replaces_that_of_the_base(tmp_path: Path) -> None:
    text = 'schema = 1\nname = "mine"\nbase = "paper-case-a"\n'
    scenario = load(tmp_path, text + WAYPOINTS)
    assert scenario.reference.duration == 2.0


def test_files_that_a_base_mentions_lie_beside_the_base(tmp_path: Path) -> None:
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared" / "wobbly.toml").write_text(PLANT)
    (tmp_path / "shared" / "poses.csv").write_text(POSES)
    below = changed(TOP, '"perfect"', '"wobbly.toml"') + SAMPLES
    (tmp_path / "shared" / "below.toml").write_text(below)
    scenario = load(tmp_path, 'schema = 1\nname = "above"\nbase = "shared/below.toml"\n')
    assert scenario.plant.name == "wobbly"
    assert scenario.reference.duration == 2.0


def test_bases_that_go_round_in_a_circle(tmp_path: Path) -> None:
    (tmp_path / "other.toml").write_text('name = "other"\nbase = "mine.toml"\n')
    (tmp_path / "mine.toml").write_text('name = "mine"\nbase = "other.toml"\n')
    with pytest.raises(ScenarioError) as caught:
        om.load_scenario(tmp_path / "mine.toml")
    assert caught.value.key == "base"
    assert "not based on this one" in str(caught.value)


@pytest.mark.parametrize("name", om.list_scenarios())
def test_catalogue_loads_and_says_everything_it_flies(name: str) -> None:
    scenario = om.load_scenario(name)
    content = json.loads(json.dumps(scenario.as_file()))
    assert content["name"] == name == scenario.name
    assert scenario.title
    assert content["controller"].get("proposed", False) == scenario.proposed
    assert scenario.proposed or content["controller"]["position_per_s2"] == 300.0
    assert content["controller"]["allocator"]["kind"] == scenario.allocator.kind
    assert {effect["kind"] for effect in content["plant"]["effects"]} == {
        effect.kind for effect in scenario.plant.effects
    }
