"""`docs/notation.md` says what every metric means."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from omnimorph.results.metrics import Metrics

NOTATION = (Path(__file__).parents[2] / "docs" / "notation.md").read_text(encoding="utf-8")


def test_every_metric_is_defined() -> None:
    names = [field.name for field in dataclasses.fields(Metrics)]
    assert [name for name in names if f"`{name}`" not in NOTATION] == []
