"""A list of fields that forgets something does not compile, whatever the list is used for."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from tests.core.test_standalone_core import STRICT, compiler

pytestmark = pytest.mark.slow

RECORD = """
#include "omnimorph/flight/stored_state.hpp"
using namespace omnimorph;
struct Record {
    double x = 0, y = 0;
    static constexpr auto fields() { return field_list(FIELDS); }
};
std::string layout;
"""
WHOLE = 'field("x", &Record::x), field("y", &Record::y)'
MISSING = 'field("x", &Record::x)'
TWICE = 'field("x", &Record::x), field("y", &Record::x)'
USES = {
    "visited": "void use(Record& r) { for_each_field(r, [](const auto&, auto&) {}); }",
    "in another number": "Record use(const Record& r) { return convert<Record>(r); }",
    "in a lane": "void use(Record& r) { put_lane(r, 0, Record()); }",
    "by paths": 'void use(Record& r) { for_each_leaf("", r, r, [](auto&&, auto&, auto&) {}); }',
    "described": "void use() { stored::describe<Record>(layout); }",
    "stored": "void use(std::vector<unsigned char>& b, Record& r) { stored::append(b, r); }",
}

LAW = """
#include "omnimorph/plant/settings.hpp"
using namespace omnimorph;
struct Law {
    bool active = false;
    double x = 0, y = 0;
    static constexpr auto fields() {
        return field_list(
            derived("active", &Law::active), field("x", &Law::x), DERIVED("y", &Law::y));
    }
};
void derive(Law& law, ARGUMENTS) { law.y = law.x; }
void use(Records<Law>& laws) { plant::derive_each(laws, 1, 1, 0.001); }
"""


def complaints(program: str, tmp_path: Path) -> str:
    """Return what the compiler says of a program; nothing if it compiles."""
    source = tmp_path / "program.cpp"
    source.write_text(program)
    command = [compiler("g++"), *STRICT, "-fsyntax-only", str(source)]
    return subprocess.run(command, capture_output=True, text=True).stderr


@pytest.mark.parametrize("use", USES.values(), ids=USES.keys())
def test_a_member_that_is_missing_or_listed_twice(use: str, tmp_path: Path) -> None:
    program = RECORD + use
    assert complaints(program.replace("FIELDS", WHOLE), tmp_path) == ""
    assert "a member is missing" in complaints(program.replace("FIELDS", MISSING), tmp_path)
    assert "a member is listed twice" in complaints(program.replace("FIELDS", TWICE), tmp_path)


def test_a_derived_field_that_nothing_derives(tmp_path: Path) -> None:
    def law(kind: str, arguments: str) -> str:
        program = LAW.replace("DERIVED", kind).replace("ARGUMENTS", arguments)
        return complaints(program, tmp_path)

    assert law("derived", "int, int, double") == ""
    assert law("field", "int, double") == ""
    assert "derive(law, n, m, h) is missing" in law("derived", "int, double")
