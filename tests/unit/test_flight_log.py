"""Finished flights on disk: whole lines are believed, nothing is flown twice or lost."""

from __future__ import annotations

import json
import threading
from dataclasses import replace
from pathlib import Path

import pytest

import omnimorph as om
from omnimorph.errors import RunFileError
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.metrics import Metrics
from omnimorph.studies import flight_log
from omnimorph.studies.flight_log import FlightLog, FlightResult, flight_keys, is_flight_log
from omnimorph.studies.many_flights import Job, fly_jobs, fly_runs

SHORT = replace(
    om.load_scenario("paper-case-b"),
    reference=SegmentReference((0.0, 0.0, 1.0), [[1, 0, 0], [0, 1, 0], [0, 0, 1]], [Segment(0.2)]),
)
JOBS = [Job(SHORT, seed) for seed in range(4)]


def metrics() -> Metrics:
    return om.fly(SHORT).metrics


def lines(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines()


def test_what_is_added_is_there_the_next_time(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "flights.jsonl"
    flown = {"a": FlightResult(metrics()), "b": FlightResult(None, "it has no rotors.")}
    with FlightLog(path) as log:
        assert not path.parent.exists(), "nothing is made before there is something to keep"
        for key, one in flown.items():
            log.add(key, one)
    with FlightLog(path) as log:
        assert len(log) == 2
        assert log.get("a") == flown["a"]
        assert log.get("b") == flown["b"]
        assert log.get("c") is None
    assert is_flight_log(path)


def test_numbers_that_are_not_finite_come_back(tmp_path: Path) -> None:
    lost = replace(metrics(), kkt_residual_max=float("nan"), outcome="lost")
    with FlightLog(tmp_path / "log") as log:
        log.add("a", FlightResult(lost))
    with FlightLog(tmp_path / "log") as log:
        found = log.get("a")
    assert found is not None
    assert found.metrics is not None
    assert found.metrics.kkt_residual_max != found.metrics.kkt_residual_max
    assert (found.completed, found.outcome) == (False, "lost")


@pytest.mark.parametrize("kept", [0, 10, 200, 900])
def test_a_line_that_was_cut_off_is_not_believed(tmp_path: Path, kept: int) -> None:
    path = tmp_path / "log"
    with FlightLog(path) as log:
        log.add("a", FlightResult(metrics()))
        log.add("b", FlightResult(metrics()))
    header, first, second = lines(path)
    path.write_text(f"{header}\n{first}\n{second[:kept]}", encoding="utf-8")
    with FlightLog(path) as log:
        assert (len(log), log.get("b")) == (1, None)
        log.add("c", FlightResult(metrics()))
    with FlightLog(path) as log:
        assert len(log) == 2
        assert log.get("a") is not None
    assert len(lines(path)) == 3, "the cut line is gone"


def test_a_number_changed_by_hand_is_not_believed(tmp_path: Path) -> None:
    path = tmp_path / "log"
    with FlightLog(path) as log:
        log.add("a", FlightResult(metrics()))
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace('\\"tilt_max_deg\\": ', '\\"tilt_max_deg\\": 1'), encoding="utf-8")
    assert path.read_text(encoding="utf-8") != text
    with FlightLog(path) as log:
        assert len(log) == 0


def test_another_build_flies_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with FlightLog(tmp_path / "log") as log:
        log.add("a", FlightResult(metrics()))
    flight_log._build.cache_clear()
    monkeypatch.setattr(flight_log, "__version__", "another")
    try:
        with FlightLog(tmp_path / "log") as log:
            assert len(log) == 0
    finally:
        flight_log._build.cache_clear()


def test_threads_do_not_write_into_each_others_lines(tmp_path: Path) -> None:
    one = FlightResult(metrics())
    with FlightLog(tmp_path / "log") as log:

        def add_fifty(name: str) -> None:
            for k in range(50):
                log.add(f"{name}-{k}", one)

        threads = [threading.Thread(target=add_fifty, args=(name,)) for name in "abcd"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    with FlightLog(tmp_path / "log") as log:
        assert len(log) == 200


def test_a_log_that_cannot_be_written_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with FlightLog(tmp_path / "file" / "log") as log, pytest.raises(RunFileError, match="log: "):
        log.add("a", FlightResult(metrics()))


def test_other_files_are_no_logs(tmp_path: Path) -> None:
    (tmp_path / "a.jsonl").write_text('{"schema": "theirs"}\n')
    (tmp_path / "b.jsonl").write_bytes(b"\xff\xfe")
    assert not is_flight_log(tmp_path / "a.jsonl")
    assert not is_flight_log(tmp_path / "b.jsonl")
    assert not is_flight_log(tmp_path / "none")


def test_the_key_knows_all_that_decides_a_flight() -> None:
    plant = replace(SHORT.plant, control_period=0.008)
    heavier = SHORT.vehicle.replace(mass=1.4)
    gains = replace(SHORT.gains, position=299.0)
    others = [
        replace(SHORT, plant=plant),
        replace(SHORT, vehicle=heavier),
        replace(SHORT, gains=gains),
        replace(SHORT, start_tilt=0.1),
        om.load_scenario("paper-case-b"),
        om.load_scenario("paper-case-b-pose-only"),
    ]
    keys = flight_keys([SHORT, SHORT, *others], [0, 1, *(0 for _ in others)])
    assert len(set(keys)) == len(keys)
    assert flight_keys([replace(SHORT)], [0]) == keys[:1]


# --- many flights ---------------------------------------------------------------------------------


def test_each_flight_is_what_it_is_alone(tmp_path: Path) -> None:
    with FlightLog(tmp_path / "log") as log:
        flown = fly_jobs(JOBS, log)
    assert [one.metrics for one in flown] == [om.fly(SHORT, seed=k).metrics for k in range(4)]


def test_what_is_there_is_not_flown_again(tmp_path: Path) -> None:
    path = tmp_path / "log"
    with FlightLog(path) as log:
        first = fly_jobs([*JOBS[:2], JOBS[0]], log)
    assert len(lines(path)) == 3, "a header, and each flight once"
    before = path.read_bytes()
    reported: list[int] = []
    with FlightLog(path) as log:
        again = fly_jobs([*JOBS[:2], JOBS[0]], log, lambda: reported.append(len(log)))
    assert again == first
    assert path.read_bytes() == before
    assert len(reported) == 3


def test_a_refused_flight_is_an_answer(tmp_path: Path) -> None:
    endless = replace(
        SHORT, reference=SegmentReference((0, 0, 1), SHORT.reference(0.0).R_WB, [Segment(1e6)] * 3)
    )
    with FlightLog(tmp_path / "log") as log:
        refused, fine = fly_jobs([Job(endless, 0), JOBS[0]], log)
    assert refused.metrics is None
    assert refused.outcome == "not flown"
    assert "duration" in refused.failure
    assert fine.completed


def test_an_interrupt_keeps_what_is_finished(tmp_path: Path) -> None:
    class Stop(KeyboardInterrupt):
        pass

    done: list[int] = []

    def stop_at_the_second() -> None:
        done.append(1)
        if len(done) == 2:
            raise Stop

    path = tmp_path / "log"
    with FlightLog(path) as log, pytest.raises(Stop):
        fly_jobs([Job(SHORT, seed) for seed in range(40)], log, stop_at_the_second)
    with FlightLog(path) as log:
        assert 2 <= len(log) < 40
    assert json.loads(lines(path)[0])["schema"] == "omnimorph flights"


def test_every_job_is_flown_with_its_own_seed(tmp_path: Path) -> None:
    alone = [om.fly(SHORT, seed=job.seed) for job in JOBS]
    assert len({run.content_hash for run in alone}) == len(JOBS)
    with FlightLog(tmp_path / "log") as log:
        found = [flown.metrics for flown in fly_jobs(JOBS[::-1], log)]
    assert found == [run.metrics for run in alone[::-1]]
    assert [run.content_hash for run in fly_runs(JOBS)] == [run.content_hash for run in alone]
