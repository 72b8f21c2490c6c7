"""The reproduction of the paper: its verdicts are honest, its report needs no other file."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import pytest

import omnimorph as om
from omnimorph.errors import InputError
from omnimorph.results.metrics import Metrics
from omnimorph.studies.paper_comparison import (
    Verdict,
    judge_claims,
    judge_values,
    paper_values,
)
from omnimorph.studies.paper_flights import SCENARIOS
from omnimorph.studies.reproduction import reproduce


@pytest.fixture(scope="module")
def runs() -> dict[str, om.Run]:
    return {name: om.fly(om.load_scenario(name)) for name in SCENARIOS}


@pytest.fixture(scope="module")
def flown(runs: dict[str, om.Run]) -> dict[str, list[Metrics]]:
    return {name: [run.metrics] for name, run in runs.items()}


def test_the_papers_numbers_say_where_they_stand() -> None:
    content = paper_values()
    for entry in content["value"]:
        assert entry["scenario"] in SCENARIOS
        assert entry["metric"] in {field.name for field in dataclasses.fields(Metrics)}
        assert entry["value"] > 0
        assert entry["where"].startswith("Results")
    keys = [(entry["scenario"], entry["metric"]) for entry in content["value"]]
    assert len(keys) == len(set(keys))


def test_verdicts_on_numbers(flown: dict[str, list[Metrics]]) -> None:
    for row in judge_values(flown):
        if "/" in row.scenario:
            continue
        if row.metric == "drag_energy_paper":
            # the length of the flight was chosen because of these
            assert row.verdict in (Verdict.CALIBRATED, Verdict.NOT_EXPLAINED)
        elif row.metric == "acceleration_energy_paper":
            assert row.verdict is Verdict.ASSUMED
        else:
            assert row.verdict is Verdict.NOT_EXPLAINED
            assert row.difference < -0.9


def test_a_number_near_the_papers_is_reproduced_only_if_nothing_was_chosen(
    flown: dict[str, list[Metrics]],
) -> None:
    """Give every flight the paper's own numbers: what was put in is still only calibrated."""
    perfect = {
        name: [
            dataclasses.replace(
                flown[name][0],
                **{
                    e["metric"]: e["value"]
                    for e in paper_values()["value"]
                    if e["scenario"] == name
                },
            )
        ]
        for name in SCENARIOS
    }
    for row in judge_values(perfect):
        assert abs(row.difference) < 1e-12
        if "/" in row.scenario or "error" in row.metric:
            assert row.verdict is Verdict.REPRODUCED
        else:
            assert row.verdict in (Verdict.CALIBRATED, Verdict.ASSUMED)


def test_claims_in_words(runs: dict[str, om.Run], flown: dict[str, list[Metrics]]) -> None:
    claims = {claim.key: claim for claim in judge_claims(flown, runs)}
    assert list(claims) == [entry["key"] for entry in paper_values()["claim"]]
    for key in ("energy_order", "fixed_tilt_alike", "tilt_of_case_b", "tracking_order"):
        assert claims[key].verdict is Verdict.REPRODUCED, claims[key].here
    assert claims["acceleration_is_minor"].verdict is Verdict.NOT_REPRODUCED


def test_energies_and_tilt(flown: dict[str, list[Metrics]]) -> None:
    energy = {name: metrics[0].drag_energy_paper for name, metrics in flown.items()}
    assert energy["paper-case-b"] < energy["paper-fixed-45-b"] < energy["paper-case-a"]
    assert energy["paper-case-b"] < energy["paper-fixed-45-a"] < energy["paper-case-a"]
    assert energy["paper-fixed-45-a"] == pytest.approx(energy["paper-fixed-45-b"], rel=0.02)
    assert energy["paper-case-b"] == pytest.approx(1111, rel=0.05)
    assert flown["paper-case-a"][0].tilt_mean_deg > 45
    assert flown["paper-case-b"][0].tilt_mean_deg < 35


@pytest.mark.parametrize("seeds", [0, -1])
def test_a_number_of_seeds_that_makes_no_sense(tmp_path: Path, seeds: int) -> None:
    with pytest.raises(InputError, match="seeds"):
        reproduce(tmp_path / "out", seeds=seeds)
    assert list(tmp_path.iterdir()) == []


def test_somebody_elses_folder_is_refused_before_anything_is_flown(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")

    def told(done: float, total: float, label: str) -> None:
        raise AssertionError("it flew")

    with pytest.raises(InputError, match="not one of ours"):
        reproduce(tmp_path, progress=told)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


@pytest.mark.slow
def test_case_a_over_five_seeds() -> None:
    scenario = om.load_scenario("paper-case-a")
    energies = [om.fly(scenario, seed=seed).metrics.drag_energy_paper for seed in range(5)]
    assert sum(energies) / 5 == pytest.approx(1773, rel=0.05)


@pytest.mark.slow
def test_the_report_is_one_file_and_the_numbers_are_beside_it(tmp_path: Path) -> None:
    out = tmp_path / "out"
    told: list[tuple[float, float]] = []
    report = reproduce(out, seeds=1, progress=lambda done, total, label: told.append((done, total)))
    assert report == out / "report.html"

    assert [done for done, _ in told] == list(range(len(told)))
    assert {total for _, total in told} == {len(told)}

    text = report.read_text(encoding="utf-8")
    assert len(text.encode()) < 1_500_000
    assert "<script" not in text
    assert not re.search(r'(src|@import|url\()\s*=?\s*["\']?(https?:|//|\w+/)', text)
    links = set(re.findall(r'(?<!:)href="([^"#][^"]*)"', text))
    assert all(link.startswith("https://doi.org/") for link in links), links
    for inside in re.findall(r'(?<!:)href="#([^"]+)"', text):
        assert f'id="{inside}"' in text
    assert text.count("<svg") == 8

    results = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert results["schema"] == "omnimorph reproduction"
    for name in ("paper-case-a", "paper-case-b"):
        run = om.load_run(out / f"run-{name}.nc")
        assert run.provenance.content_hash == results["realistic"][name]["content_hash"]
        assert run.provenance.content_hash in text
    names = {path.stem for path in (out / "figures").iterdir()}
    assert {path.name for path in (out / "figures").iterdir()} == {
        f"{name}.{kind}" for name in names for kind in ("svg", "pdf")
    }
    assert len(names) == 8
