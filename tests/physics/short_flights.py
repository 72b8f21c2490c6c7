"""Short flights from scenario files, for tests of what a flight is made of."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tests.physics.test_many_flights import assert_same

import omnimorph as om


def short_flight(folder: Path, tables: str, *, seconds: float = 0.2) -> om.Scenario:
    """Load a scenario file with these tables: a short move up, otherwise as the scenario hover."""
    reference = f"reference.segment = [{{duration_s = {seconds}, move_m = [0.0, 0.0, 0.02]}}]"
    file = folder / "short.toml"
    file.write_text(f'schema = 1\nname = "short"\nbase = "hover"\n{reference}\n{tables}\n')
    return om.load_scenario(file)


def flown_in_a_batch(scenario: om.Scenario, path: str, values: Sequence[Any]) -> list[om.Run]:
    """Fly a batch, a flight for each value at a path; alone each is the same to the last bit."""
    batch = om.fly_many(scenario, len(values), keep="all", vary={path: values})
    for number, value in enumerate(values):
        assert_same(batch.runs[number], om.fly(om.replaced(scenario, {path: value}), flight=number))
    return [batch.runs[number] for number in range(len(values))]
