"""Commands that are ended from outside: nothing goes on, nothing is half written."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.cli.test_fit_and_inertia import write_bench
from tests.left_processes import Marked, marked, omnimorph_command

import omnimorph as om
from omnimorph.results.temporary import is_temporary

Program = Callable[..., "subprocess.CompletedProcess[str]"]

REPRODUCE = ("reproduce", "--quick", "--seeds", 1, "--out", "out")
LONG = """
schema = 1
name = "long"
base = "hover"
[reference]
kind = "segments"
[[reference.segment]]
duration_s = 30.0
"""


def wait_until(run: Marked, path: Path) -> None:
    """Wait until a file is there, or the process has ended."""
    while not path.exists() and run.process.poll() is None:
        time.sleep(0.01)


def ends_before(run: Marked, moment: float) -> bool:
    """Tell whether the process ends by itself within so many seconds."""
    try:
        run.process.wait(timeout=moment)
    except subprocess.TimeoutExpired:
        return False
    return True


def check_whole(folder: Path) -> None:
    """Demand that every file that is not temporary is whole, by what stands at its end."""
    for path in folder.rglob("*"):
        inside = path.relative_to(folder).parents
        if path.is_dir() or is_temporary(path) or any(map(is_temporary, inside)):
            continue
        if path.suffix == ".nc":
            assert om.load_run(path).outcome is om.Outcome.COMPLETED
        elif path.suffix == ".json":
            assert json.loads(path.read_text())
        elif path.suffix == ".jsonl":  # it grows, and a line that was cut off is not believed
            assert path.read_text().startswith('{"schema": "omnimorph flights"')
        else:
            ends = {".html": b"</html>", ".svg": b"</svg>", ".pdf": b"%%EOF", ".csv": b"\n"}
            ends |= {".toml": b"\n", ".md": b"|\n", ".png": b"IEND\xaeB`\x82"}
            assert path.read_bytes()[-16:].strip(b" ").endswith((ends[path.suffix], b">\n", b"F\n"))


# --- asked to end -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_whoever_asks_it_ends_in_the_same_orderly_way(
    tmp_path: Path, number: signal.Signals, code: int
) -> None:
    with marked(omnimorph_command(*REPRODUCE), tmp_path) as run:
        wait_until(run, tmp_path / "out/flights.jsonl")
        run.process.send_signal(number)
        assert run.left() == []
        assert run.process.stderr is not None
        reported = run.process.stderr.read()
        assert run.process.returncode == code
    assert reported.startswith("omnimorph: interrupted; ")
    assert reported.endswith(
        "finished flights are kept in out/flights.jsonl; the same command goes on from there.\n"
    )
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["flights.jsonl"]


def test_a_terminal_that_is_closed(tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    on_it = f'exec <{os.ttyname(theirs)} >&0; exec "$@"'  # the first one that a session opens
    command = ["setsid", "bash", "-c", on_it, "bash", *omnimorph_command(*REPRODUCE)]
    with marked(command, tmp_path) as run:
        wait_until(run, tmp_path / "out/flights.jsonl")
        os.close(theirs)
        os.close(ours)
        assert run.left() == []
        assert run.process.returncode == 129
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["flights.jsonl"]


def test_without_a_terminal_by_nohup_it_goes_on(tmp_path: Path) -> None:
    (tmp_path / "long.toml").write_text(LONG)
    command = "trap '' HUP; exec $0 -m omnimorph fly long.toml --out out"
    with marked(["bash", "-c", command, sys.executable], tmp_path) as run:
        while not ends_before(run, 0.1):
            run.process.send_signal(signal.SIGHUP)
        assert run.process.returncode == 0
    assert om.load_run(tmp_path / "out/run.nc").outcome is om.Outcome.COMPLETED


# --- killed -------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM], ids=["kill", "term"])
def test_nothing_is_left_of_a_killed_reproduction(tmp_path: Path, number: signal.Signals) -> None:
    with marked(omnimorph_command(*REPRODUCE), tmp_path) as run:
        run.wait_for(2)  # with the one that analyses beside the flights
        run.process.send_signal(number)
        assert run.left() == []
        assert run.process.returncode == (143 if number == signal.SIGTERM else -number)


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("flown")
    om.fly(om.load_scenario("hover")).save(folder / "run.nc")
    return folder / "run.nc"


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM], ids=["kill", "term"])
@pytest.mark.parametrize(
    ("words", "last", "times"),
    [
        (REPRODUCE, 12.0, 16),
        (("compare", "omnimorph", "voliro", "--out", "out"), 4.0, 6),
        (("bench", "--rounds", 1), 24.0, 6),
        (("view", "RUN", "--snapshot", "out.png"), 6.0, 8),
        (("view", "RUN", "--video", "out.mp4"), 9.0, 6),
    ],
    ids=["reproduce", "compare", "bench", "snapshot", "video"],
)
def test_nothing_is_left_at_any_moment(
    tmp_path: Path,
    flown: Path,
    words: tuple[object, ...],
    last: float,
    times: int,
    number: signal.Signals,
) -> None:
    """Killed at moments from the start until it is done, or nearly."""
    command = omnimorph_command(*(flown if word == "RUN" else word for word in words))
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    left = []
    for k in range(times):
        with marked(command, tmp_path, TMPDIR=str(temporary)) as run:
            ends_before(run, last * (k + 1) / times)
            run.process.send_signal(number)
            left += run.left()
        check_whole(tmp_path)
    assert left == []
    assert list(temporary.glob("omnimorph-*")) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "last", "times"),
    [
        (("fly", "paper-case-a", "--out", "out"), 1.5, 16),
        (("analyze", "omnimorph", "--out", "out"), 4.0, 8),
        (("compare", "omnimorph", "voliro", "--out", "out"), 4.0, 8),
        (("fit", "bench.csv", "--out", "out"), 4.0, 8),
        (REPRODUCE, 12.0, 8),
    ],
    ids=["fly", "analyze", "compare", "fit", "reproduce"],
)
def test_no_half_file_and_nothing_finished_is_lost(
    program: Program, tmp_path: Path, words: tuple[object, ...], last: float, times: int
) -> None:
    write_bench(tmp_path / "bench.csv")
    flights = 0
    for k in range(times):
        with marked(omnimorph_command(*words), tmp_path) as run:
            ends_before(run, last * (k + 1) / times)
            run.process.kill()
        check_whole(tmp_path)
        if (log := tmp_path / "out/flights.jsonl").exists():
            assert log.read_text().count("\n") >= flights, "what was finished is kept"
            flights = log.read_text().count("\n")
    done = program(*words)
    assert done.returncode == 0
    assert done.stderr == "" or done.stderr.startswith("omnimorph: replaced what was there: out/")
    check_whole(tmp_path)
    assert [path for path in tmp_path.rglob("*") if is_temporary(path)] == []
