"""The core stands alone: plain C++ programs build without Python, without a warning, and fly."""

from __future__ import annotations

import os
import shutil
import subprocess
import sysconfig
from pathlib import Path

import nanobind
import pytest

CORE = Path(__file__).parents[2] / "core"
PROGRAMS = sorted((CORE / "tests").glob("*.cpp"))
QUICKLY_COMPILED = {"elementary_in_lanes", "interference_in_lanes"}
ALLOCATION = CORE / "tests" / "allocation_that_changes.cpp"
LOOP = CORE / "tests" / "loop_alone.cpp"
# What sanitisers are spared, as it compiles for long: two only instantiate what the others fly,
# two are watched by those of clang.
SPARED = {
    "g++": {"derivatives", "loop_alone", "allocation_that_changes", "flight_state"},
    "clang++": {"derivatives", "loop_alone"},
}
# What a program is compiled with besides, to prove that it does without.
FLAGS = {"loop_alone": ["-fno-exceptions", "-fno-rtti"]}
HEADERS = sorted((CORE / "include").rglob("*.hpp"))
BINDINGS = sorted((CORE / "bindings").glob("*.cpp"))

STRICT = [
    "-std=c++17",
    "-pthread",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-Wno-psabi",
    "-Wno-bitwise-instead-of-logical",  # & and | of masks, where a bool is the mask of one lane
    f"-I{CORE / 'include'}",
]
PLAIN = ["-O2", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"]
SANITISED = [
    "-O1",
    "-g",
    "-ffp-contract=off",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
]


def run(command: list[str]) -> str:
    """Run a command that must succeed and complain of nothing; return what it prints."""
    # a sanitiser reports all it finds, whatever the shell this was started from asks of it
    settings = os.environ.items()
    environment = {name: value for name, value in settings if not name.endswith("SAN_OPTIONS")}
    answer = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert answer.stderr == ""
    return answer.stdout


def compiler(name: str) -> str:
    """Return the path of a compiler, or say how to come by it."""
    path = shutil.which(name)
    assert path is not None, f"{name} is missing (.ci/run names the Debian package)"
    return path


def build_and_run(program: Path, compiler_name: str, flags: list[str], where: Path) -> str:
    """Compile one program of core/tests and run it; return what it prints."""
    binary = where / program.stem
    flags = [*flags, *FLAGS.get(program.stem, [])]
    run([compiler(compiler_name), *STRICT, *flags, str(program), "-o", str(binary)])
    return run([str(binary)])


def test_there_is_a_flight_without_python() -> None:
    assert {path.stem for path in PROGRAMS} > QUICKLY_COMPILED


@pytest.mark.parametrize(
    "program",
    [
        pytest.param(
            path, marks=[] if path.stem in QUICKLY_COMPILED else pytest.mark.slow, id=path.stem
        )
        for path in PROGRAMS
        if path not in (ALLOCATION, LOOP)  # which the next tests run, in two ways each
    ],
)
def test_program_builds_and_runs(program: Path, tmp_path: Path) -> None:
    assert build_and_run(program, "g++", PLAIN, tmp_path) != ""


@pytest.mark.slow
def test_candidates_in_turn_are_those_in_lanes_to_the_last_bit(tmp_path: Path) -> None:
    """Also without exceptions and without type information, as on a microcontroller."""
    in_lanes = build_and_run(ALLOCATION, "g++", PLAIN, tmp_path)
    scalar = [*PLAIN, "-DOMNIMORPH_SCALAR", "-fno-exceptions", "-fno-rtti"]
    assert build_and_run(ALLOCATION, "g++", scalar, tmp_path) == in_lanes


def test_one_vehicle_needs_no_vector_extensions(tmp_path: Path) -> None:
    """With OMNIMORPH_SCALAR; batches of vehicles in lanes and packs themselves are left out."""
    in_lanes = {"math/pack.hpp", "flight/batch.hpp"}
    names = [header.relative_to(CORE / "include" / "omnimorph").as_posix() for header in HEADERS]
    everything = tmp_path / "everything.cpp"
    everything.write_text(
        "".join(f'#include "omnimorph/{name}"\n' for name in names if name not in in_lanes)
    )
    command = [compiler("g++"), *STRICT, "-E", str(everything)]
    used = [
        [word for word in ("vector_size", "pack.hpp") if word in run([*command, *define])]
        for define in ([], ["-DOMNIMORPH_SCALAR"])
    ]
    assert used == [["vector_size", "pack.hpp"], []]


@pytest.mark.slow
def test_one_vehicle_flies_without_vector_extensions(tmp_path: Path) -> None:
    """The same to the last bit, with every rule and effect."""
    alike = [
        build_and_run(LOOP, "g++", [*PLAIN, *define], tmp_path)
        for define in ([], ["-DOMNIMORPH_SCALAR"])
    ]
    assert "completed" in alike[0]
    assert alike[0] == alike[1]


@pytest.mark.slow
@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_program_runs_with_clang(program: Path, tmp_path: Path) -> None:
    assert build_and_run(program, "clang++", PLAIN, tmp_path) != ""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("compiler_name", "program"),
    [
        pytest.param(name, path, id=f"{name}-{path.stem}")
        for name, spared in SPARED.items()
        for path in PROGRAMS
        if path.stem not in spared
    ],
)
def test_program_runs_under_sanitisers(compiler_name: str, program: Path, tmp_path: Path) -> None:
    assert build_and_run(program, compiler_name, SANITISED, tmp_path) != ""


@pytest.mark.slow
@pytest.mark.parametrize("compiler_name", ["g++", "clang++"])
def test_threads_share_nothing_they_write(compiler_name: str, tmp_path: Path) -> None:
    flags = ["-O1", "-g", "-ffp-contract=off", "-fsanitize=thread"]
    assert build_and_run(CORE / "tests" / "fly_many.cpp", compiler_name, flags, tmp_path) != ""


@pytest.mark.slow
@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_program_compiles_for_aarch64_and_the_quick_ones_run(program: Path, tmp_path: Path) -> None:
    """The same text on another processor, emulated: many flights, wakes and joint allocation."""
    cross_compiler, binary = compiler("aarch64-linux-gnu-g++"), tmp_path / program.stem
    flags = [*STRICT, *PLAIN, *FLAGS.get(program.stem, []), "-static"]
    if program.stem not in ("fly_many", "interference_in_lanes", "joint_in_lanes"):
        run([cross_compiler, *flags, "-fsyntax-only", str(program)])
        return
    run([cross_compiler, *flags, str(program), "-o", str(binary)])
    assert run([compiler("qemu-aarch64"), str(binary)]) != ""


@pytest.mark.slow
@pytest.mark.parametrize("source", BINDINGS, ids=lambda path: path.stem)
def test_bindings_are_clean_with_clang(source: Path) -> None:
    """`make setup` builds them with the machine's own compiler, which is GCC where CI runs."""
    python = f"-isystem{sysconfig.get_paths()['include']}"
    build = (
        "OMNIMORPH_ROTORS=8",
        "OMNIMORPH_ROTOR_COUNTS=8,0",
        "OMNIMORPH_SIMD=portable",
        "OMNIMORPH_REGISTER_BYTES=16",
        'OMNIMORPH_INSTRUCTION_SETS="portable"',
    )
    flags = [python, f"-isystem{nanobind.include_dir()}", *(f"-D{name}" for name in build)]
    module = "-DOMNIMORPH_BATCH_MODULE=_batch_portable"
    run([compiler("clang++"), *STRICT, *flags, module, "-fsyntax-only", str(source)])
