"""The comparison with peers: the same problems, equal work, and names for what is missing."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import daqp
import numpy as np
import pytest
from benchmarks.peers import measure_peers
from benchmarks.peers import quadrotor as q
from benchmarks.peers.limits import what_peers_cannot_run
from benchmarks.peers.missing import NotInstalled, imported, quiet
from benchmarks.peers.recorded_problems import Problem, recorded_problems
from benchmarks.peers.solvers import SOLVERS, exact_answers, solve_all
from benchmarks.peers.suite import away

import omnimorph as om
from omnimorph.bench.batches import worn_plant
from omnimorph.bench.checkout import find_checkout
from omnimorph.control.box_qp import solve_box_qp
from omnimorph.errors import InputError
from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects import EFFECTS

ROOT = Path(__file__).parents[2]
IMPORT = "from omnimorph.bench.checkout import import_peers as f; print(f().__file__)"
PEERS = ("osqp", "proxsuite", "casadi", "mujoco", "crazyflow", "rotorpy")


@pytest.fixture(scope="module")
def problems() -> list[Problem]:
    """Return some recorded problems."""
    return recorded_problems(160)


@pytest.fixture(scope="module")
def exact(problems: list[Problem]) -> list[FloatArray]:
    """Return their answers."""
    return exact_answers(problems)


def test_problems_are_scaled_and_half_of_them_meet_limits_often(
    problems: list[Problem], exact: list[FloatArray]
) -> None:
    assert len(problems) == 160
    for problem in problems:
        assert np.trace(problem.H) == pytest.approx(8.0)
        assert np.linalg.eigvalsh(problem.H).min() > 0.0
    limited = [
        ((x <= one.lower) | (x >= one.upper)).any()
        for one, x in zip(problems, exact, strict=True)
    ]  # fmt: skip
    assert sum(limited[80:]) > 20


def test_answers_prove_themselves_and_beat_what_is_near(
    problems: list[Problem], exact: list[FloatArray]
) -> None:
    random = np.random.default_rng(1)
    for one, x in zip(problems, exact, strict=True):
        gradient = one.H @ x + one.g
        assert np.abs(x - np.clip(x - gradient, one.lower, one.upper)).max() < 1e-12
        other = np.clip(x + 1e-3 * random.standard_normal(8), one.lower, one.upper)
        assert 0.5 * x @ one.H @ x + one.g @ x <= 0.5 * other @ one.H @ other + one.g @ other


def test_the_papers_fourteen_variables_have_the_same_answer(
    problems: list[Problem], exact: list[FloatArray]
) -> None:
    """DAQP on u and q̈ with the dynamics as equations, u counted in shares so that it is scaled."""
    for one, x in zip(problems[::8], exact[::8], strict=True):
        paper = one.paper
        scale = np.concatenate([1.0 / paper.to_shares, np.ones(6)])
        H, g, rows = (paper.H * scale).T * scale, paper.g * scale, paper.rows * scale
        free = np.full(6, 1e6)
        upper = np.concatenate([one.upper, free, paper.right])
        lower = np.concatenate([one.lower, -free, paper.right])
        sense = np.array([0] * 14 + [5] * 6, dtype=np.int32)  # equations, always active
        size = np.trace(H) / 14
        y, _, flag, _ = daqp.solve(H / size, g / size, rows, upper, lower, sense)
        assert flag > 0
        np.testing.assert_allclose(y[:8], x, atol=1e-6)


@pytest.mark.parametrize("package", ["omnimorph", "daqp"])
def test_solvers_at_hand_are_right(
    package: str, problems: list[Problem], exact: list[FloatArray]
) -> None:
    answers = solve_all(SOLVERS[package][1](), problems, exact)
    assert answers.errors.max() < 1e-8
    assert answers.claimed.all()
    assert answers.wrong == 0
    assert (answers.seconds > 0.0).all()


def test_an_answer_that_is_called_solved_and_is_not_is_counted(
    problems: list[Problem], exact: list[FloatArray]
) -> None:
    def careless(problem: Problem) -> tuple[FloatArray, bool]:
        return np.zeros(8), True

    def honest(problem: Problem) -> tuple[FloatArray, bool]:
        return np.full(8, np.nan), False

    assert solve_all(careless, problems, exact).wrong == len(problems)
    assert solve_all(honest, problems, exact).wrong == 0


@pytest.mark.parametrize(
    "parts",
    [
        (np.eye(3), np.zeros(2), -np.ones(2), np.ones(2)),
        (np.eye(2), np.zeros(2), -np.ones(3), np.ones(2)),
        (np.eye(37), np.zeros(37), -np.ones(37), np.ones(37)),
        (np.zeros((0, 0)), np.zeros(0), np.zeros(0), np.zeros(0)),
    ],
)
def test_a_box_qp_of_the_wrong_shape_is_refused(parts: tuple[FloatArray, ...]) -> None:
    with pytest.raises(InputError, match="shape of its parts"):
        solve_box_qp(*parts)


# --- equal work ---------------------------------------------------------------------------------


def test_our_open_loop_ends_where_the_rigid_body_does() -> None:
    one = q.ours(q.Loop(1, closed=False))
    assert np.linalg.norm(q.final_position()) > 0.05
    np.testing.assert_allclose(one.position, q.final_position(), rtol=0, atol=1e-11)


def test_our_closed_loop_comes_back() -> None:
    one = q.ours(q.Loop(1, closed=True))
    assert np.linalg.norm(one.position) < 0.5 * np.linalg.norm([0.2, 0.0, 0.1])


# --- where the peers are ------------------------------------------------------------------------


@pytest.fixture
def elsewhere(tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run Python with a package that does not lie in the checkout, as an installed one."""
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "omnimorph").symlink_to(Path(om.__file__).parent)
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "site")}

    def run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, *words]
        settings: dict[str, Any] = {"cwd": folder, "env": environment, "timeout": 60.0}
        return subprocess.run(command, capture_output=True, text=True, check=False, **settings)

    return run


def write_project(folder: Path, project: str) -> Path:
    """Write a project with peers that leave a mark where they are imported."""
    (folder / "benchmarks" / "peers").mkdir(parents=True)
    (folder / "pyproject.toml").write_text(project)
    (folder / "benchmarks" / "__init__.py").touch()
    peers = folder / "benchmarks" / "peers" / "__init__.py"
    peers.write_text(f"open({str(folder / 'imported')!r}, 'w')\n")
    return folder


def test_outside_a_checkout_one_sentence_says_where_the_peers_are(
    tmp_path: Path, elsewhere: Callable[..., subprocess.CompletedProcess[str]]
) -> None:
    folder = write_project(tmp_path / "project", "[project]\nname = 'another'\nversion = '0.1.0'\n")
    done = elsewhere(folder, "-m", "omnimorph", "bench", "--peers")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("omnimorph: bench --peers: the peers are in benchmarks/peers")
    assert done.stderr.count("\n") == 1
    assert not (folder / "imported").exists()


def test_an_installed_package_finds_the_checkout_someone_stands_in(
    elsewhere: Callable[..., subprocess.CompletedProcess[str]],
) -> None:
    done = elsewhere(ROOT / "docs", "-c", IMPORT)
    assert done.stdout.strip() == str(ROOT / "benchmarks" / "peers" / "__init__.py"), done.stderr


def test_a_package_that_lies_in_a_checkout_finds_its_peers_from_anywhere(
    tmp_path: Path, elsewhere: Callable[..., subprocess.CompletedProcess[str]]
) -> None:
    write_project(tmp_path, f"[project]\nname = 'omnimorph'\nversion = '{om.__version__}'\n")
    done = elsewhere(Path("/"), "-c", IMPORT)
    assert done.stdout.strip() == str(tmp_path / "benchmarks" / "peers" / "__init__.py")


@pytest.mark.parametrize(
    ("project", "found"),
    [
        (f"[project]\nname = 'omnimorph'\nversion = '{om.__version__}'", True),
        (f"[project]\nname = 'another'\nversion = '{om.__version__}'", False),
        ("[project]\nname = 'omnimorph'\nversion = '0.0.1'", False),
        ("project = 3", False),
        ("[project", False),
        ("", False),
    ],
)
def test_only_a_project_of_this_name_and_version_is_the_checkout(
    tmp_path: Path, project: str, found: bool
) -> None:
    write_project(tmp_path, project)
    assert find_checkout([tmp_path / "not-there", tmp_path]) == (tmp_path if found else None)


# --- what is not there --------------------------------------------------------------------------


def test_a_missing_peer_is_named_with_the_way_to_it() -> None:
    with pytest.raises(NotInstalled, match=r"no_such_peer is not measured: .*omnimorph\[bench\]"):
        imported("no_such_peer")


def test_each_peer_is_tried_or_named() -> None:
    reported = what_peers_cannot_run()
    assert [sentence.split(":")[0].split()[0] for sentence in reported] == [
        "rotorpy", "crazyflow", "mujoco",
    ]  # fmt: skip
    assert all(sentence.endswith(".") and "\n" not in sentence for sentence in reported)


def test_what_a_peer_prints_stays_away(capfd: pytest.CaptureFixture[str]) -> None:
    with quiet():
        os.write(1, b"a banner")
        os.write(2, b"a warning")
    assert capfd.readouterr() == ("", "")


def test_what_a_peer_writes_is_gone_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Some leave a log where they are run, in this process or in one of their own."""
    monkeypatch.chdir(tmp_path)
    with away(["one"]) as pools:
        assert Path("HERE_LOG.TXT").write_text("here") == 4
        assert pools["one"].submit(Path("THERE_LOG.TXT").write_text, "there").result() == 5
        assert sorted(os.listdir()) == ["HERE_LOG.TXT", "THERE_LOG.TXT"]
    assert Path.cwd() == tmp_path
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_report_holds_what_is_there_and_names_what_is_not() -> None:
    reported: list[tuple[int, int]] = []
    report = measure_peers(lambda done, of: reported.append((done, of)), rounds=1)
    assert reported[-1][0] == reported[-1][1] == len(reported)
    content = json.loads(json.dumps(report.as_dict(), allow_nan=False))
    names = {row["name"] for row in content["measurements"]}
    assert {"qp_omnimorph_p50_us", "qp_daqp_p50_us", "omnimorph_open_1_error_m"} <= names
    assert report["qp_omnimorph_wrong"].median == 0
    assert report["omnimorph_open_1_error_m"].median < 1e-10
    rate = report["omnimorph_closed_1024_steps_per_s"].median
    assert report["omnimorph_closed_1024_rotor_steps_per_s"].median == pytest.approx(4.0 * rate)
    for peer in PEERS:
        measured = any(peer in name for name in names)
        assert measured or any(note.startswith(f"{peer} is not measured") for note in report.notes)
        assert measured <= (find_spec(peer) is not None)
    assert all(note in report.as_text() for note in report.notes)


def test_a_worn_plant_has_every_imperfection_and_is_flown_with() -> None:
    plant = worn_plant()
    assert {type(effect) for effect in plant.effects} == set(EFFECTS)
    scenario = om.load_scenario("hover")
    flights = om.fly_many(replace(scenario, plant=plant), 8)
    assert flights.completed.all()
