"""References: derivatives are derivatives, joints rest, tables of poses say what is wrong."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from omnimorph.errors import ScenarioError
from omnimorph.protocols import Desired, Reference
from omnimorph.reference import (
    SampledReference,
    Segment,
    SegmentReference,
    segments_from_waypoints,
)

Evaluated = SegmentReference | SampledReference
UP = (0.0, 0.0, 1.0)
TILTED = np.array([1.0, 2.0, -2.0]) / 3.0
QUARTER_ABOUT_Z = [math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]


def two_turns() -> SegmentReference:
    """Return moves and turns about different axes, each beginning where the last one ended."""
    return SegmentReference(
        (0.3, -0.2, 1.2),
        Rotation.from_euler("zyx", [0.4, -0.3, 0.9]).as_matrix(),
        [
            Segment(2.0, (0.1, 0.5, 0.8), (1.0, 0.0, 0.0), math.radians(30.0)),
            Segment(0.5),
            Segment(3.0, (-0.5, 0.0, 0.1), TILTED, -4.0),
            Segment(1.5, rotation_axis_W=UP, rotation_angle=2.0),
        ],
    )


def wandering() -> SampledReference:
    """Return a smooth curve through poses that turn about all axes, unevenly in time."""
    times = np.array([0.0, 0.3, 0.5, 1.0, 1.4, 2.0, 2.2])
    angles = np.column_stack((np.sin(times), 0.5 * times, np.cos(2.0 * times)))
    attitudes = Rotation.from_euler("zyx", angles).as_quat(scalar_first=True)
    positions = np.column_stack((np.cos(times), np.sin(times), 0.1 * times**2))
    return SampledReference(times, positions, attitudes)


def hat_inverse(matrix: Any) -> Any:
    """Return a with [a]× = the antisymmetric part of the matrix."""
    odd = (matrix - matrix.T) / 2.0
    return np.array([odd[2, 1], odd[0, 2], odd[1, 0]])


def as_row(desired: Desired) -> Any:
    return np.concatenate([np.ravel(part) for part in desired])


# --- what holds for every reference --------------------------------------------------------------


@pytest.mark.parametrize("reference", [two_turns(), wandering()], ids=["segments", "samples"])
@pytest.mark.parametrize("share", [0.03, 0.11, 0.2, 0.41, 0.57, 0.66, 0.83, 0.97])
def test_rates_are_derivatives(reference: Evaluated, share: float) -> None:
    """v = ṗ, a = v̇, [w_B]× = Rᵀ Ṙ and dw_B = ẇ_B, by central differences."""
    time, h = share * reference.duration, 1e-5
    before, now, after = (reference(t) for t in (time - h, time, time + h))
    np.testing.assert_allclose((after.p_WB - before.p_WB) / (2 * h), now.v_WB, atol=1e-8)
    np.testing.assert_allclose((after.v_WB - before.v_WB) / (2 * h), now.a_WB, atol=1e-7)
    rate = hat_inverse(now.R_WB.T @ (after.R_WB - before.R_WB) / (2 * h))
    np.testing.assert_allclose(rate, now.w_WB_B, atol=1e-8)
    change = (after.w_WB_B - before.w_WB_B) / (2 * h)
    np.testing.assert_allclose(change, now.dw_WB_B, atol=1e-7)
    np.testing.assert_allclose(now.R_WB @ now.R_WB.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(now.R_WB) > 0


@pytest.mark.parametrize("reference", [two_turns(), wandering()], ids=["segments", "samples"])
def test_many_times_at_once_are_the_same_as_one_by_one(reference: Evaluated) -> None:
    times = np.random.default_rng(0).uniform(-1.0, reference.duration + 1.0, 300)
    times[:3] = 0.0, reference.duration, 2.5
    table = reference.sample(times)
    assert table.shape == (300, 24)
    expected = np.array([as_row(reference(time)) for time in times.tolist()])
    np.testing.assert_allclose(table, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("reference", [two_turns(), wandering()], ids=["segments", "samples"])
def test_outside_its_time_the_pose_is_held_at_rest(reference: Evaluated) -> None:
    for outside, end in ((-0.5, 0.0), (reference.duration + 0.5, reference.duration)):
        held = reference(outside)
        np.testing.assert_array_equal(held.p_WB, reference(end).p_WB)
        np.testing.assert_array_equal(held.R_WB, reference(end).R_WB)
        for rate in (held.v_WB, held.w_WB_B, held.a_WB, held.dw_WB_B):
            np.testing.assert_array_equal(rate, np.zeros(3))


def test_both_are_references() -> None:
    references: list[Reference] = [two_turns(), wandering()]
    assert [reference.duration for reference in references] == [7.0, 2.2]


# --- segments -----------------------------------------------------------------------------------


def test_joints_rest_exactly() -> None:
    reference = two_turns()
    assert reference.duration == 7.0
    for joint in (0.0, 2.0, 2.5, 5.5, 7.0):
        at = reference(joint)
        for rate in (at.v_WB, at.w_WB_B, at.a_WB, at.dw_WB_B):
            np.testing.assert_array_equal(np.abs(rate), np.zeros(3))
        near = reference(joint - 1e-9)
        np.testing.assert_allclose(near.p_WB, at.p_WB, atol=1e-15)
        np.testing.assert_allclose(near.R_WB, at.R_WB, atol=1e-14)


def test_end_is_start_plus_moves_and_turns() -> None:
    reference = two_turns()
    end = reference(7.0)
    np.testing.assert_allclose(end.p_WB, [-0.1, 0.3, 2.1], atol=1e-15)
    turned = Rotation.from_matrix(reference.start_R_WB)
    for segment in reference.segments:
        vector = segment.rotation_angle * segment.rotation_axis_W
        turned = Rotation.from_rotvec(vector) * turned
    np.testing.assert_allclose(end.R_WB, turned.as_matrix(), atol=1e-14)


def test_half_way_through_a_segment() -> None:
    """At u = ½: s = ½, ṡ = 15/(8 T), s̈ = 0."""
    reference = SegmentReference(
        (0.0, 0.0, 1.0), np.eye(3), [Segment(4.0, (2.0, 0.0, 0.0), UP, math.pi)]
    )
    middle = reference(2.0)
    np.testing.assert_allclose(middle.p_WB, [1.0, 0.0, 1.0], atol=1e-15)
    np.testing.assert_allclose(middle.v_WB, [2.0 * 15 / 32, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(middle.w_WB_B, [0.0, 0.0, math.pi * 15 / 32], atol=1e-15)
    np.testing.assert_array_equal(middle.a_WB, np.zeros(3))
    np.testing.assert_allclose(middle.R_WB @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-15)


def test_full_turn_comes_back() -> None:
    roll = Segment(18.0, rotation_axis_W=(1.0, 0.0, 0.0), rotation_angle=2.0 * math.pi)
    start = Rotation.from_euler("zyx", [0.4, -0.3, 0.9]).as_matrix()
    reference = SegmentReference((0.0, 0.0, 1.0), start, [roll, Segment(1.0)])
    for time in (18.0, 18.5, 19.0, 100.0):
        np.testing.assert_allclose(reference(time).R_WB, start, atol=1e-15)
    over = reference(9.0).R_WB
    np.testing.assert_allclose(over, np.diag([1.0, -1.0, -1.0]) @ start, atol=1e-15)


def test_table_holds_all_the_core_needs() -> None:
    """Evaluate the segments from the table alone, with SciPy's rotations."""
    reference = two_turns()
    table = reference.as_table()
    assert table.shape == (4, 21)
    for t0, T, *rest in table:
        p0, d, R0 = np.array(rest[0:3]), np.array(rest[3:6]), np.reshape(rest[6:15], (3, 3))
        axis, angle = np.array(rest[15:18]), rest[18]
        u = 0.3
        s = 10 * u**3 - 15 * u**4 + 6 * u**5
        at = reference(t0 + u * T)
        np.testing.assert_allclose(at.p_WB, p0 + s * d, atol=1e-14)
        turn = Rotation.from_rotvec(s * angle * axis).as_matrix()
        np.testing.assert_allclose(at.R_WB, turn @ R0, atol=1e-14)
    np.testing.assert_array_equal(table[:, 0], [0.0, 2.0, 2.5, 5.5])
    table[:] = 0.0  # a copy
    np.testing.assert_array_equal(reference(0.0).p_WB, [0.3, -0.2, 1.2])


def test_axis_is_normalised_within_one_percent() -> None:
    axis = Segment(1.0, rotation_axis_W=(0.0, 0.6, 0.805), rotation_angle=1.0).rotation_axis_W
    assert np.linalg.norm(axis) == pytest.approx(1.0, abs=1e-15)
    with pytest.raises(ScenarioError, match=r"rotation_axis_W .* unit length within 1 %"):
        Segment(1.0, rotation_axis_W=(0.0, 1.0, 1.0), rotation_angle=1.0)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"duration": 0.0}, "duration is 0.0, but it must be from 1e-6 to 1e6"),
        ({"duration": math.nan}, "duration is nan, but it must be finite"),
        ({"duration": 1.0, "move_W": (1.0, 2.0)}, r"move_W is \(1.0, 2.0\), but it must be of sha"),
        ({"duration": 1.0, "move_W": (0.0, math.inf, 0.0)}, "move_W is .* must be finite"),
        ({"duration": 1.0, "rotation_angle": "far"}, 'rotation_angle is "far", but it must be nu'),
    ],
)
def test_segments_that_cannot_be(arguments: dict[str, Any], expected: str) -> None:
    with pytest.raises(ScenarioError, match=expected):
        Segment(**arguments)


def test_reference_needs_a_rotation_and_a_segment() -> None:
    with pytest.raises(ScenarioError, match=r"start_R_WB is .* a rotation matrix"):
        SegmentReference((0.0, 0.0, 0.0), np.diag([1.0, 1.0, -1.0]), [Segment(1.0)])
    with pytest.raises(ScenarioError, match="at least one segment"):
        SegmentReference((0.0, 0.0, 0.0), np.eye(3), [])


def test_nearly_a_rotation_becomes_one() -> None:
    rounded = np.round(Rotation.from_euler("x", 0.7).as_matrix(), 4)
    R = SegmentReference((0.0, 0.0, 0.0), rounded, [Segment(1.0)])(0.5).R_WB
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(R, rounded, atol=1e-4)


# --- waypoints ----------------------------------------------------------------------------------


def test_waypoints_are_met_at_rest() -> None:
    times = [0.5, 2.0, 3.0, 7.0]
    positions = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 0.0, 1.0]]
    attitudes = Rotation.from_euler("zyx", [[0, 0, 0], [1, 2, 3], [-1, 0, 2], [0, 0, math.pi]])
    quaternions = attitudes.as_quat(scalar_first=True) * [[1.0], [-1.0], [1.005], [1.0]]
    reference = segments_from_waypoints(times, positions, quaternions)
    assert reference.duration == 7.0
    for k, time in enumerate(times):
        at = reference(time)
        np.testing.assert_allclose(at.p_WB, positions[k], atol=1e-15)
        np.testing.assert_allclose(at.R_WB, attitudes[k].as_matrix(), atol=1e-14)
        np.testing.assert_array_equal(np.abs(at.w_WB_B), np.zeros(3))
    np.testing.assert_array_equal(reference(0.2).p_WB, positions[0])
    assert all(abs(segment.rotation_angle) <= math.pi for segment in reference.segments)


def test_waypoints_without_attitude_stay_level() -> None:
    reference = segments_from_waypoints([0.0, 1.0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    np.testing.assert_array_equal(reference(0.4).R_WB, np.eye(3))


@pytest.mark.parametrize("times", [[0.0], [0.0, 0.0], [1.0, 0.5], [-1.0, 0.0], [0.0, math.nan]])
def test_waypoints_need_increasing_times(times: list[float]) -> None:
    with pytest.raises(ScenarioError, match="times is"):
        segments_from_waypoints(times, np.zeros((len(times), 3)))


def test_waypoints_need_unit_quaternions() -> None:
    with pytest.raises(ScenarioError, match=r"quaternions_wxyz is .* unit length within 1 %"):
        segments_from_waypoints([0, 1], np.zeros((2, 3)), [[1, 0, 0, 0], [1, 1, 0, 0]])


# --- samples ------------------------------------------------------------------------------------


def test_samples_are_met_without_rest() -> None:
    reference = wandering()
    times = np.array([0.0, 0.3, 0.5, 1.0, 1.4, 2.0, 2.2])
    table = reference.sample(times)
    np.testing.assert_allclose(table[:, 0], np.cos(times), atol=1e-14)
    np.testing.assert_allclose(table[:, 1], np.sin(times), atol=1e-14)
    angles = np.column_stack((np.sin(times), 0.5 * times, np.cos(2.0 * times)))
    expected = Rotation.from_euler("zyx", angles).as_matrix().reshape(-1, 9)
    np.testing.assert_allclose(table[:, 3:12], expected, atol=1e-13)
    assert np.all(np.linalg.norm(table[:, 12:15], axis=1) > 0.5)


def test_spline_is_smooth_at_the_samples() -> None:
    """Velocity, acceleration, body rate and its derivative do not jump; the ends are natural."""
    reference = wandering()
    for joint in (0.3, 0.5, 1.0, 1.4, 2.0):
        before, after = as_row(reference(joint - 1e-9)), as_row(reference(joint + 1e-9))
        np.testing.assert_allclose(before, after, atol=1e-6)
    for end in (0.0, 2.2):
        np.testing.assert_allclose(reference(end).a_WB, np.zeros(3), atol=1e-12)


def test_constant_turn_is_followed_through_many_turns() -> None:
    """Eight poses a turn about a fixed axis at 2 rad/s: the rate comes out constant."""
    times = np.arange(0.0, 4 * math.pi, math.pi / 8)
    half = times[:, None]
    quaternions = np.hstack((np.cos(half), np.sin(half) * TILTED))
    reference = SampledReference(times, np.zeros((len(times), 3)), quaternions)
    table = reference.sample(np.linspace(0.0, times[-1], 200))
    np.testing.assert_allclose(table[:, 15:18], np.tile(2.0 * TILTED, (200, 1)), atol=1e-8)


def test_two_samples_are_a_line() -> None:
    reference = SampledReference(
        [0.0, 2.0], [[0, 0, 0], [0, 4, 0]], [[1.0, 0.0, 0.0, 0.0], QUARTER_ABOUT_Z]
    )
    at = reference(1.0)
    np.testing.assert_allclose(at.p_WB, [0.0, 2.0, 0.0], atol=1e-14)
    np.testing.assert_allclose(at.v_WB, [0.0, 2.0, 0.0], atol=1e-14)
    np.testing.assert_allclose(at.w_WB_B, [0.0, 0.0, math.pi / 4], atol=1e-14)


HEADER = "time_s,x_m,y_m,z_m"
FULL_HEADER = HEADER + ",qw,qx,qy,qz"


def test_csv_of_positions(tmp_path: Path) -> None:
    path = tmp_path / "path.csv"
    path.write_text("\ufeff x_m, time_s ,z_m,y_m\r\n0,0,1,0\r\n\r\n1,1,1,0\r\n4,2,1,0\r\n")
    reference = SampledReference.from_csv(path)
    assert reference.duration == 2.0
    np.testing.assert_allclose(reference(1.0).p_WB, [1.0, 0.0, 1.0], atol=1e-15)
    np.testing.assert_array_equal(reference(0.7).R_WB, np.eye(3))


def test_csv_of_poses(tmp_path: Path) -> None:
    path = tmp_path / "path.csv"
    half = math.sqrt(0.5) * 1.009
    path.write_text(f"{FULL_HEADER}\n0,0,0,1,1,0,0,0\n1,0,0,1,{half},0,0,{half}\n")
    reference = SampledReference.from_csv(str(path))
    turned = reference(1.0).R_WB
    np.testing.assert_allclose(turned @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-14)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "line 1, column time_s is missing, but it must be there"),
        ("0,0,0,1\n1,0,0,1\n", "line 1, column time_s is missing"),
        ("time_s,x_m,y_m\n", "line 1, column z_m is missing"),
        (HEADER + ",qw\n", "line 1, column qx is missing"),
        (HEADER + ",x\n", "line 1, column 'x' is not a known key; did you mean"),
        (HEADER + ",x_m\n", "line 1, column x_m is there twice"),
        (HEADER + "\n", "it holds 0 poses, but it must hold 2 or more"),
        (HEADER + "\n0,0,0,1\n", "it holds 1 poses, but it must hold 2 or more"),
        (
            HEADER + "\n0,0,0,1\n1,0,oops,1\n",
            'line 3, column y_m is "oops", but it must be a finite number',
        ),
        (HEADER + "\n0,0,0,1\n1,0,nan,1\n", 'line 3, column y_m is "nan"'),
        (HEADER + "\n0,0,0,1\n1,,0,1\n", 'line 3, column x_m is ""'),
        (HEADER + "\n0,0,0,1\n1,0,1\n", "line 3, number of values is 3, but it must be 4"),
        (
            HEADER + "\n-1,0,0,1\n1,0,0,1\n",
            'line 2, column time_s is "-1", but it must be a finite number from 0 to 1e6',
        ),
        (
            HEADER + "\n0,0,0,1\n\n2,0,0,1\n2,0,0,2\n",
            "line 5, column time_s is 2.0, but it must be later than the time before it, 2.0 s",
        ),
        (
            FULL_HEADER + "\n0,0,0,1,1,0,0,0\n1,0,0,1,1,0.5,0,0\n",
            "line 3, column qw to qz is [1.0, 0.5, 0.0, 0.0], but it must be a quaternion of unit",
        ),
        (
            FULL_HEADER + "\n0,0,0,1,1,0,0,0\n1,0,0,1,0,1,0,0\n",
            "line 3, turn from the attitude before is 180.0°, but it must be at most 170°",
        ),
    ],
)
def test_csv_that_cannot_be_used(tmp_path: Path, text: str, expected: str) -> None:
    path = tmp_path / "poses.csv"
    path.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        SampledReference.from_csv(path)
    sentence = str(caught.value)
    assert sentence.startswith(f"{path}: {expected}")
    assert "\n" not in sentence


def test_csv_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"none\.csv: this file cannot be read, because"):
        SampledReference.from_csv(tmp_path / "none.csv")
    (tmp_path / "picture.csv").write_bytes(b"\x89PNG\xff\xfe\x00")
    with pytest.raises(ScenarioError, match=r"picture\.csv: .* it is not a text file"):
        SampledReference.from_csv(tmp_path / "picture.csv")


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (([0.0], [[0, 0, 0]]), "times is"),
        (([0.0, 1.0], [[0, 0, 0]]), "positions is"),
        (([0.0, 1.0], np.zeros((2, 3)), [[1, 0, 0, 0]]), "quaternions_wxyz is"),
        (([0.0, 0.0], np.zeros((2, 3))), "sample 1, column time_s is 0.0"),
        (([0.0, 1.0], np.full((2, 3), np.inf)), "sample 0, column x_m is inf"),
    ],
)
def test_samples_that_cannot_be(arguments: tuple[Any, ...], expected: str) -> None:
    with pytest.raises(ScenarioError, match=expected):
        SampledReference(*arguments)
