"""The list of mistakes stays true: each can still be made, and the tests beside it are there."""

from __future__ import annotations

from collections import Counter

import pytest
from tests.mutants.listed import ROOT, Mutant, mutants

LISTED = mutants()


def test_names_are_unique() -> None:
    assert [name for name, count in Counter(one.name for one in LISTED).items() if count > 1] == []


@pytest.mark.parametrize("mutant", LISTED, ids=lambda one: one.name)
def test_a_mistake_can_be_made_where_it_says(mutant: Mutant) -> None:
    text = (ROOT / mutant.file).read_text(encoding="utf-8")
    assert mutant.applied(text) != text
    assert mutant.wrong.endswith(".")
    assert mutant.tests
    for test in mutant.tests:
        file, _, name = test.partition("::")
        assert f"def {name}" in (ROOT / file).read_text(encoding="utf-8")
