"""A build that is not tuned for this machine flies the same flights, with every instruction set."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.other_builds import build, run_python
from tests.physics.test_many_flights import FLIGHT_HASHES, flight_hashes

from omnimorph import _core


@pytest.mark.slow
def test_every_instruction_set_flies_the_same_flights(tmp_path: Path) -> None:
    here = flight_hashes(_core.instruction_sets()[-1])
    packages = build(tmp_path, OMNIMORPH_NATIVE="OFF")
    told = run_python(
        packages, ["-c", "from omnimorph import _core as c; print(*c.instruction_sets())"], {}
    )
    known = told.split()
    assert known[0] in ("x86-64-v2", "portable")
    assert _core.instruction_sets()[-1] in known
    for name in known:
        answer = run_python(packages, ["-c", FLIGHT_HASHES], {"OMNIMORPH_SIMD": name})
        flown_with, hashes = answer.splitlines()
        assert flown_with == name
        assert hashes.split() == here
