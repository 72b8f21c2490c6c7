"""A build that is not tuned for this machine flies the same flights, with every instruction set."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.other_builds import build, run_python
from tests.physics.test_many_flights import FLIGHT_HASHES, flight_hashes

from omnimorph import _core


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(tmp_path_factory.mktemp("travels"), OMNIMORPH_NATIVE="OFF")


@pytest.fixture(scope="module")
def known(packages: Path) -> list[str]:
    """The instruction sets that this build and this processor have."""
    reported = run_python(
        packages, ["-c", "from omnimorph import _core as c; print(*c.instruction_sets())"], {}
    )
    return reported.split()


@pytest.mark.slow
def test_every_instruction_set_flies_the_same_flights(packages: Path, known: list[str]) -> None:
    here = flight_hashes(_core.instruction_sets()[-1])
    assert known[0] in ("x86-64-v2", "portable")
    assert _core.instruction_sets()[-1] in known
    for name in known:
        answer = run_python(packages, ["-c", FLIGHT_HASHES], {"OMNIMORPH_SIMD": name})
        flown_with, hashes = answer.splitlines()
        assert flown_with == name
        assert hashes.split() == here


@pytest.mark.slow
def test_every_instruction_set_flies_the_golden_flights(packages: Path, known: list[str]) -> None:
    for name in known:
        check = ["-m", "tests.physics.golden_flights", "--check"]
        answer = run_python(packages, check, {"OMNIMORPH_SIMD": name})
        assert answer == f"All flights are as before, with {name}.\n"
