"""Every header of the core compiles alone, with all of its templates instantiated."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from tests.core.instantiation import functions_of, program
from tests.core.test_standalone_core import CORE, HEADERS, STRICT, compiler, run

INCLUDES = CORE / "include" / "omnimorph"

# What template parameters stand for: one vehicle whose rotors are counted when compiling, one whose
# rotors are counted at run time beside candidates in lanes, and eight vehicles in lanes.
FOUR, EIGHT = "Pack<double, 4>", "Pack<float, 8>"
ALWAYS = {"R": "3", "K": "3", "Lanes": "4", "Factors": "NoFactors", "GoesOn": "Answered"}
ALWAYS |= {"Found": "Called", "Belong": "Answered", "Visit": "Called", "Watch": "Called"}
VEHICLES = [
    {"T": "double", "U": "double", "S": "double", "N": "8", "M": "4", **ALWAYS},
    {"T": "double", "U": FOUR, "S": "float", "N": "0", "M": "0", **ALWAYS},
    {"T": EIGHT, "U": EIGHT, "S": EIGHT, "N": "8", "M": "4", **ALWAYS},
]
ONE_VEHICLE = {  # what is for one vehicle, or is what lanes are made of
    "control/tilt_candidates.hpp": {"best_in_lanes", "cost_over_tilt", "side_by_side"},
    "math/number.hpp": {"select", "IfFloat"},
    "math/pack.hpp": {"*"},
}
IN_LANES = {"control/tilt_candidates.hpp": {"best_in_turn"}}
SAMPLE = dict.fromkeys(("Record", "X", "Y", "To", "From"), "Sample")
LIST = dict.fromkeys("XY", "Records<Sample>")
PER_ROTOR = {"X": "PerRotor<{U}, {N}>"}
EVERYWHERE = {"Moment": "Moment<{T}, {N}>"}  # of a force
OTHERS = {  # what parameters stand for in single headers ("*"), and in single templates of them
    "control/allocation_problem.hpp": {"*": PER_ROTOR},
    "control/tilt_candidates.hpp": {"*": {"Tilts": "CandidateTilts<{T}>"}},
    "flight/loop.hpp": {"*": {"X": "long"}},
    "flight/metrics.hpp": {"*": {"Sums": "FlightSums<{T}>", "Each": "Tilts<{T}>"}},
    "flight/record.hpp": {
        "*": {"Rows": "3", "Columns": "0", "Stored": "double", "Values": "PerRotor<{T}, {N}>"}
    },
    "flight/stored_state.hpp": {
        "*": {"X": "FlightState<double, {N}>", "Bytes": "const unsigned char*"}
    },
    "math/fields.hpp": {
        "*": {
            **SAMPLE,
            "Member": "double",
            "I": "0",
            "Count": "1",
            "Choice": "std::variant<Sample>",
            "Each": "Field<Sample, double>",
        },
        "elements_of": {"X": "Samples"},
        "for_each_pair": LIST,
    },
    "math/pack.hpp": {"*": {"U": "int"}},
    "math/records.hpp": {"*": {"First": "double", "Rest": "float", "Kind": "float"}},
    "model/vehicle.hpp": {"Count": {"N": "8"}},  # 0 is defined by itself
    "model/interference.hpp": {"*": {"X": "StackedPair"}},
    "plant/command_delay.hpp": {"*": {"X": "long"}},
    "plant/settings.hpp": {
        "*": {"Law": "RotorLag<{T}, {N}>", "Laws": "RotorLaws<double, {N}>"},
    },
}
LEFT_OUT = {  # special forms of meta-functions, which those that ask them instantiate
    "estimate/estimator.hpp": {"StatesOf"},
    "math/fields.hpp": {"HasMembers", "IsRecord", "IsArray", "field_list"},
}
BEFORE = {
    "math/fields.hpp": """
namespace omnimorph {
struct Sample {
    static constexpr const char* name = "sample";
    double x = 0;
    static constexpr auto fields() { return field_list(field("x", &Sample::x)); }
};
struct Samples {
    double a[2];
};
}
"""
}


def source(header: Path) -> str:
    """Return the program that instantiates a header."""
    name = header.relative_to(INCLUDES).as_posix()
    others = OTHERS.get(name, {})

    def choices(template: str) -> list[dict[str, str]]:
        if template in LEFT_OUT.get(name, set()):
            return []
        vehicles = VEHICLES
        if {"*", template} & ONE_VEHICLE.get(name, set()):
            vehicles = VEHICLES[:2]
        if template in IN_LANES.get(name, set()):
            vehicles = VEHICLES[2:]
        chosen = EVERYWHERE | others.get("*", {}) | others.get(template, {})
        return [
            vehicle | {key: value.format(**vehicle) for key, value in chosen.items()}
            for vehicle in vehicles
        ]

    return program(f"omnimorph/{name}", header.read_text(), choices, BEFORE.get(name, ""))


TEMPLATES = """
namespace omnimorph {
template <class T> OMNIMORPH_FN T f(const T& x) { return a_function(x); }
template <class T> struct A { T f() const { return a_member(T(1)); } };
template <class T> struct B { template <class U> U f(U x) { return a_member_template(x); } };
template <class T> struct C { friend C f(C x) { return a_friend(x); } };
template <class T> inline constexpr T x = a_variable(T(1));
}
"""


def test_a_mistake_that_only_instantiation_shows_is_found(tmp_path: Path) -> None:
    header, alone = tmp_path / "header.hpp", tmp_path / "alone.cpp"
    header.write_text('#include "omnimorph/math/placement.hpp"' + TEMPLATES)
    alone.write_text(program(str(header), header.read_text(), lambda _: VEHICLES[:1]))
    command = [compiler("g++"), *STRICT, "-fsyntax-only", str(alone)]
    complaints = subprocess.run(command, capture_output=True, text=True).stderr
    kinds = ("a_function", "a_member", "a_member_template", "a_friend", "a_variable")
    assert [kind for kind in kinds if not re.search(rf"{kind}\b", complaints)] == []


STEP = ("math", "model", "control", "estimate", "plant", "flight/loop.hpp")
ON_A_DEVICE = {
    name: header
    for header in HEADERS
    if (name := header.relative_to(INCLUDES).as_posix()).startswith(STEP)
    and name != "math/fields.hpp"  # what converts records and lists their fields is for the host
}


@pytest.mark.parametrize("header", ON_A_DEVICE.values(), ids=ON_A_DEVICE.keys())
def test_functions_that_a_step_calls_may_run_on_a_device(header: Path) -> None:
    unmarked = [
        head
        for head in functions_of(header.read_text())
        if "OMNIMORPH_FN" not in head and not head.endswith(" fields()")
    ]
    assert unmarked == []


@pytest.mark.parametrize("header", ON_A_DEVICE.values(), ids=ON_A_DEVICE.keys())
def test_a_step_reads_plain_values(header: Path) -> None:
    containers = r"std::(vector|map|string|function|unique_ptr|shared_ptr|optional|any)\b"
    assert re.findall(containers, header.read_text()) == []


def test_a_template_parameter_without_a_value_is_found() -> None:
    with pytest.raises(AssertionError, match="no value for"):
        program("x.hpp", "template <class New> void f(New) {}", lambda _: VEHICLES)


@pytest.mark.slow
@pytest.mark.parametrize("header", HEADERS, ids=lambda path: path.name)
@pytest.mark.parametrize("compiler_name", ["g++", "clang++"])
def test_header_compiles_alone_when_instantiated(
    header: Path, compiler_name: str, tmp_path: Path
) -> None:
    alone = tmp_path / "alone.cpp"
    alone.write_text(source(header))
    run([compiler(compiler_name), *STRICT, "-fsyntax-only", str(alone)])
