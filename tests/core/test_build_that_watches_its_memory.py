"""The tests of the interface on modules that end at the first error of memory (ASan, UBSan)."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from tests.core.other_builds import build, run_python

# What writes and reads through the bindings: flights and batches, controllers, sets.
OF_THE_INTERFACE = [
    "tests/unit/test_stepped_flight.py",
    "tests/unit/test_memory_of_flights.py",
    "tests/unit/test_python_in_the_loop.py",
    "tests/unit/test_bad_parts_of_the_loop.py",
    "tests/unit/test_fly_many.py",
    "tests/unit/test_joint_tilt.py",
    "tests/unit/test_box_qp.py",
    "tests/unit/test_thrust_stand.py",
    "tests/unit/test_tilt_cost.py",
    "tests/unit/test_interference.py",
    "tests/physics/test_many_flights.py",
    "tests/physics/test_wrench_sets.py",
]


@pytest.mark.slow
def test_no_access_beyond_an_array_and_nothing_undefined(tmp_path: Path) -> None:
    packages = build(tmp_path, OMNIMORPH_SANITIZE="ON", OMNIMORPH_ROTOR_COUNTS="8")
    gcc = shutil.which("g++")
    assert gcc is not None
    libraries = [
        subprocess.run(
            [gcc, f"-print-file-name={name}"], capture_output=True, text=True, check=True
        ).stdout.strip()
        for name in ("libasan.so", "libstdc++.so")
    ]
    watched = {
        "LD_PRELOAD": " ".join(libraries),
        "ASAN_OPTIONS": "detect_leaks=0",  # Python itself keeps what it has until the end
        "PYTHONMALLOC": "malloc",  # so that the ends of Python's own arrays are watched too
    }
    program = "import omnimorph, sys; print(omnimorph.__file__)"
    assert str(packages) in run_python(packages, ["-c", program], watched)
    quick = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not slow", *OF_THE_INTERFACE]
    assert " passed" in run_python(packages, quick, watched)
