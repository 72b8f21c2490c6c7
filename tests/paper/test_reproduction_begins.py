"""The reproduction before anything is flown: claims of the paper, folders, plans."""

from __future__ import annotations

from pathlib import Path

import pytest

import omnimorph as om
from omnimorph.errors import InputError
from omnimorph.studies.own_folder import FLIGHTS
from omnimorph.studies.reproduction import Plan, paper, reproduce

PLAN = Plan.quickly()


def test_every_claim_says_where_it_stands() -> None:
    for key, claim in paper.claims().items():
        assert claim.key == key
        assert claim.text.endswith(".")
        assert claim.where
        if "metric" in claim.about:
            assert claim.about["scenario"] in om.list_scenarios()
            assert claim.value is not None


def test_somebody_elses_folder_is_refused_before_anything_is_flown(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")

    def reported(done: float, total: float, label: str) -> None:
        raise AssertionError("it flew")

    with pytest.raises(InputError, match="not one of ours"):
        reproduce(tmp_path, PLAN, reported)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_log_beside_somebody_elses_file_is_not_ours(tmp_path: Path) -> None:
    (tmp_path / FLIGHTS).write_text('{"schema": "omnimorph flights", "schema_version": 1}\n')
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="not one of ours"):
        reproduce(tmp_path, PLAN)


def test_a_plan_without_seeds_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="seeds"):
        reproduce(tmp_path / "out", PLAN._replace(seeds=range(0)))
    assert list(tmp_path.iterdir()) == []
