"""A reference without rates: the controller lags by the ratio of its gains, whatever flies."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import omnimorph as om
from omnimorph.errors import ScenarioError
from omnimorph.reference.pose_only import PoseOnly
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.run import Run

FIXED_TILT = om.load_scenario("paper-fixed-45-a")  # fully actuated from the first step


def there(duration: float = 3.0, **move: object) -> SegmentReference:
    """One move, and a rest in which what lags comes to an end."""
    return SegmentReference(np.zeros(3), np.eye(3), [Segment(duration, **move), Segment(2.0)])  # type: ignore[arg-type]


def fly(reference: SegmentReference, plant: str = "perfect") -> Run:
    return om.fly(replace(FIXED_TILT, reference=PoseOnly(reference)), plant=plant)


def test_it_tells_the_poses_and_no_rates() -> None:
    whole = there(move_W=(0.5, 0.0, 0.0))
    reported = PoseOnly(whole)
    assert reported.duration == whole.duration
    for time in (0.0, 1.0, 2.5, 9.0):
        here, there_ = reported(time), whole(time)
        np.testing.assert_array_equal(here.p_WB, there_.p_WB)
        np.testing.assert_array_equal(here.R_WB, there_.R_WB)
        for rate in here[2:]:
            assert not rate.any()
    table = reported.sample(np.linspace(0.0, 5.0, 11))
    assert not table[:, 12:].any()
    assert (table[:, :12] == whole.sample(np.linspace(0.0, 5.0, 11))[:, :12]).all()


@pytest.mark.parametrize("plant", ["perfect", "realistic"])
@pytest.mark.parametrize("duration", [2.0, 4.0])
def test_the_mean_lag_is_the_ratio_of_gains_times_the_way_over_the_time(
    plant: str, duration: float
) -> None:
    """From rest to rest ∫ e dt = K_v/K_p d, as the acceleration integrates to nothing."""
    run = fly(there(duration, move_W=(0.0, 0.4, 0.0)), plant)
    lag = (run.desired_p_WB - run.p_WB)[:, 1].sum() * 1e-3
    assert lag == pytest.approx(30.0 / 300.0 * 0.4, rel=0.02)


def test_the_attitude_lags_likewise() -> None:
    """For small angles, where e_R is the angle."""
    turn = there(4.0, rotation_axis_W=(1.0, 0.0, 0.0), rotation_angle=0.1)
    run = fly(turn)
    angle = np.arctan2(run.R_WB[:, 2, 1], run.R_WB[:, 1, 1])
    desired = np.arctan2(run.desired_R_WB[:, 2, 1], run.desired_R_WB[:, 1, 1])
    assert (desired - angle).sum() * 1e-3 == pytest.approx(40.0 / 100.0 * 0.1, rel=0.01)


def test_the_paper_flown_so_has_the_papers_attitude_errors() -> None:
    """0.4 s · 420° / 45 s = 0.0652; the paper reports 0.062, 0.068 and 0.063."""
    for name in ("paper-case-a-pose-only", "paper-case-b-pose-only"):
        metrics = om.fly(om.load_scenario(name), plant="realistic-1").metrics
        assert metrics.attitude_error_paper == pytest.approx(0.0652, rel=0.01)
        assert metrics.position_error_mean_m == pytest.approx(0.1 * 4.0 / 45.0, rel=0.06)


def test_any_reference_of_a_file_may_be_given_so(tmp_path: Path) -> None:
    file = tmp_path / "quiet.toml"
    text = 'schema = 1\nname = "quiet"\nbase = "hover"\nreference = {}\n'
    file.write_text(text.replace("{}", "{kind = 'samples', file = 'p.csv', pose_only = true}"))
    (tmp_path / "p.csv").write_text("time_s,x_m,y_m,z_m\n0,0,0,1\n1,0.1,0,1\n2,0.2,0,1\n")
    reference = om.load_scenario(file).reference
    assert isinstance(reference, PoseOnly)
    assert reference(0.5).v_WB.tolist() == [0.0, 0.0, 0.0]
    assert reference.as_file()["pose_only"] is True
    file.write_text(text.replace("{}", "{kind = 'samples', file = 'p.csv', pose_only = 1}"))
    with pytest.raises(ScenarioError, match=r"pose_only is 1, but it must be true or false"):
        om.load_scenario(file)
