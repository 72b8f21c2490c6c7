"""`omnimorph new-vehicle`: a file that loads, names what it assumes, hovers and flies unedited."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import omnimorph as om
from omnimorph.design.new_vehicle import KINDS, Kind, new_vehicle_text

Program = Callable[..., "subprocess.CompletedProcess[str]"]


def written(folder: Path, kind: Kind, rotors: int = 6) -> om.Vehicle:
    file = folder / f"mine-{kind}.toml"
    file.write_text(new_vehicle_text(file.stem, rotors, kind), encoding="utf-8")
    return om.load_vehicle(file)


@pytest.mark.parametrize("kind", KINDS)
def test_it_flies_unedited(kind: Kind, tmp_path: Path) -> None:
    vehicle = written(tmp_path, kind)
    assert vehicle.n_servos == {"fixed": 0, "synchronised": 1, "independent": 6}[kind]
    flown = om.fly(om.load_scenario("tour").for_vehicle(vehicle), seed=5)
    assert flown.metrics.outcome == "completed"
    assert flown.metrics.position_error_max_m < 0.05


@pytest.mark.parametrize("rotors", [6, 8, 18])
@pytest.mark.parametrize("kind", KINDS)
def test_its_rotors_push_every_way_and_none_is_favoured(
    kind: Kind, rotors: int, tmp_path: Path
) -> None:
    """On a circle and leaning in turn: rank 6 where tilted, and equal speeds give no moment."""
    vehicle = written(tmp_path, kind, rotors)
    tilt = np.zeros(vehicle.n_servos) if kind == "fixed" else np.full(vehicle.n_servos, 0.5)
    if kind == "independent":
        tilt[::2] *= -1.0
    effect = om.allocation_matrix(vehicle, tilt)
    assert np.linalg.matrix_rank(effect) == 6
    wrench = effect @ np.ones(rotors)
    np.testing.assert_allclose(wrench[[0, 1, 3, 4]], 0.0, atol=1e-9)
    assert wrench[2] > 0


@pytest.mark.parametrize("kind", KINDS)
def test_every_number_says_that_it_is_assumed(
    kind: str, program: Program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = program("new-vehicle", "mine", "--kind", kind)
    assert (done.returncode, done.stderr) == (0, "")
    assert "omnimorph fly tour --vehicle mine.toml" in done.stdout
    shown = program("vehicles", "mine.toml")
    assert shown.returncode == 0
    assert "From the template" in shown.stdout
    assert "no source given" not in shown.stdout


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["a/b"], "NAME"),
        ([".hidden"], "NAME"),
        (["mine.toml"], "without .toml"),
        (["mine", "--rotors", "7"], "an even number from 6 to 18"),
        (["mine", "--rotors", "20"], "an even number from 6 to 18"),
        (["mine", "--rotors", "2", "--kind", "independent"], "an even number from 4 to 18"),
        (["mine", "--rotors", "six"], '--rotors is "six", but it must be a positive'),
        (["mine", "--kind", "other"], "invalid choice"),
    ],
)
def test_mistakes_are_reported_and_nothing_is_written(
    words: list[str],
    complaint: str,
    program: Program,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    done = program("new-vehicle", *words)
    assert done.returncode == 2
    assert complaint in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_there_is_kept(
    program: Program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text("my work", encoding="utf-8")
    done = program("new-vehicle", "mine")
    assert done.returncode == 2
    assert "not written over" in done.stderr
    assert (tmp_path / "mine.toml").read_text(encoding="utf-8") == "my work"
