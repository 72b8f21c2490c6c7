"""Every number of every file has a range, and whatever is beyond it is reported in a sentence."""

from __future__ import annotations

import copy
import math
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.fuzz.kinds import KINDS, PARTS, bench_texts, reference_texts, trees
from tests.fuzz.mutations import as_toml, at, paths

import omnimorph as om
from omnimorph.control.rules import RULES
from omnimorph.design.ranges import Range
from omnimorph.design.records import Record
from omnimorph.design.schema import VehicleFile
from omnimorph.design.tables import Table, range_of
from omnimorph.identification.bench_data import column_ranges
from omnimorph.identification.inertia import PARTS as PART_KINDS
from omnimorph.reference import samples
from omnimorph.simulation.effects import EFFECTS
from omnimorph.simulation.plant_files import PlantFile
from omnimorph.simulation.scenario_schema import ScenarioFile

REFUSED: tuple[Any, ...] = (1e300, -1e300, 1e154, math.nan, math.inf, "x", True, [])
EITHER = (0.0, 5e-324, 1e-300, 1e-12, -1.0, 1e9)


# --- every number has a range ---------------------------------------------------------------------


def tables(model: type[Table], seen: set[type[Table]]) -> set[type[Table]]:
    """Return a model and all those that its fields mention."""
    if model not in seen:
        seen.add(model)
        for field in model.model_fields.values():
            for inner in mentioned(field.annotation):
                tables(inner, seen)
    return seen


def mentioned(annotation: Any) -> Iterator[Any]:
    """Yield the classes in an annotation, however deep."""
    if isinstance(annotation, type) and not typing.get_args(annotation):
        if hasattr(annotation, "model_fields"):
            yield annotation
        return
    for argument in typing.get_args(annotation):
        yield from mentioned(argument)


def holds_numbers(annotation: Any) -> bool:
    return annotation is float or any(map(holds_numbers, typing.get_args(annotation)))


MODELS = [
    model
    for whole in (VehicleFile, ScenarioFile, PlantFile)
    for model in sorted(tables(whole, set()), key=lambda one: one.__name__)
    if issubclass(model, Table)
]


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_every_number_of_a_table_has_a_range(model: type[Table]) -> None:
    for name, field in model.model_fields.items():
        if holds_numbers(field.annotation):
            limits = range_of(field)
            assert isinstance(limits, Range), name
            assert math.isfinite(limits.least), name
            assert math.isfinite(limits.most), name
            assert str(limits) in str(field.description), name


def test_every_column_has_a_range() -> None:
    for columns in (column_ranges(), samples.RANGES):
        assert all(math.isfinite(limits.most) for limits in columns.values())
    assert {"time_s", "speed_rpm", "command_Hz", "force_N", "torque_Nm"} <= column_ranges().keys()
    assert {"time_s", "x_m", "qz"} <= samples.RANGES.keys()


# --- and it is kept -------------------------------------------------------------------------------


def example(record: type[Record]) -> dict[str, Any]:
    """Return a table of a file with every number that a record has."""
    from omnimorph.design.tables import file_model

    known = {"times_s": [0.0, 1.0], "span": "window", "candidates": 5, "model": "published"}
    table: dict[str, Any] = {"kind": record.kind}
    for name, field in file_model(record).model_fields.items():
        if name in known:
            table[name] = known[name]
        elif holds_numbers(field.annotation):
            several = name.startswith(
                ("W2", "position_m", "orientation", "size", "force", "torque")
            )
            several = several and record.kind != "measurement-noise"
            rows = record.kind == "wrench-profile"
            table[name] = [[1.0] * 3] * 2 if rows else [1.0] * 3 if several else 1.0
    return table


def with_effect(effect: type[Record]) -> dict[str, Any]:
    plant = copy.deepcopy(trees("simulation/plants")[0])
    plant["plant"]["effect"] = [example(effect)]
    return plant


def with_rule(rule: type[Record]) -> dict[str, Any]:
    scenario = copy.deepcopy(tree_named("simulation/scenarios", "paper-case-a"))
    scenario["controller"]["allocator"] = example(rule)
    return scenario


def tree_named(folder: str, name: str) -> dict[str, Any]:
    return next(tree for tree in trees(folder) if tree["name"] == name)


WAYPOINTS = {
    "kind": "waypoints",
    "waypoint": [
        {"time_s": 0.0, "position_m": [0.0, 0.0, 1.0], "quaternion_wxyz": [1.0, 0.0, 0.0, 0.0]},
        {"time_s": 1.0, "position_m": [0.0, 0.0, 2.0]},
    ],
}
TURNING = {
    "kind": "segments",
    "start_position_m": [0.0, 0.0, 1.0],
    "start_quaternion_wxyz": [1.0, 0.0, 0.0, 0.0],
    "segment": [
        {"duration_s": 1.0, "move_m": [0.1, 0.0, 0.0], "rotation_axis_W": [1.0, 0.0, 0.0],
         "rotation_angle_deg": 5.0}
    ],
}  # fmt: skip
HOVER = tree_named("simulation/scenarios", "hover")
FULL = HOVER | {"start_tilt_deg": 0.0, "lost_beyond_m": 2.0}
SERVO = tree_named("design/catalogue", "omnimorph-2026")
FILTERED = SERVO | {"tilt_mechanism_mass_kg": 0.1, "filter": {"rate_cutoff_Hz": 30.0}}
DOCUMENTS: list[tuple[str, dict[str, Any]]] = [
    ("vehicle", FILTERED),
    ("vehicle", tree_named("design/catalogue", "tilt-hex")),
    ("scenario", FULL | {"reference": TURNING}),
    ("scenario", FULL | {"reference": WAYPOINTS}),
    *(("scenario", with_rule(rule)) for rule in RULES),
    *(("plant", with_effect(effect)) for effect in EFFECTS),
    ("plant", trees("simulation/plants")[1]),
    ("parts", {"part": [example(part) for part in PART_KINDS]}),
    ("parts", PARTS),
]


def numbers_of(tree: dict[str, Any]) -> dict[tuple[Any, ...], tuple[Any, ...]]:
    """Return the place of a number for each key there is: the first it stands at."""
    found: dict[tuple[Any, ...], tuple[Any, ...]] = {}
    for path in paths(tree):
        value = at(tree, path)
        if isinstance(value, float) or (type(value) is int and path[-1] != "schema"):
            found.setdefault(tuple(step for step in path if isinstance(step, str)), path)
    return found


def refusal(kind: str, path: Path) -> str:
    """Return what is said of a file; nothing if it can be used."""
    try:
        KINDS[kind].use(path)
    except om.InputError as refused:
        return str(refused)
    return ""


@pytest.mark.parametrize(("kind", "tree"), DOCUMENTS)
def test_what_is_beyond_a_range_is_reported(
    kind: str, tree: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path(KINDS[kind].name)
    for words, place in numbers_of(tree).items():
        for value in (*REFUSED, *EITHER):
            changed = copy.deepcopy(tree)
            at(changed, place[:-1])[place[-1]] = value
            path.write_text(as_toml(changed), encoding="utf-8")
            reported = refusal(kind, path)
            assert len(reported) < 700
            if any(value is one for one in REFUSED):
                assert reported.startswith(f"{path}: "), (words, value)
                assert str(words[-1]) in reported, (words, value)


@pytest.mark.parametrize(
    ("kind", "text"),
    [*(("bench", text) for text in bench_texts()), *(("reference", t) for t in reference_texts())],
)
def test_what_is_beyond_the_range_of_a_column_is_reported(
    kind: str, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path(KINDS[kind].name)
    header, *lines = text.splitlines()
    for column, name in enumerate(header.split(",")):
        for value in ("1e300", "-1e300", "1e154", "nan", "inf", "x", ""):
            cells = lines[4].split(",")
            cells[column] = value
            path.write_text("\n".join([header, *lines[:4], ",".join(cells), *lines[5:]]))
            with pytest.raises(om.InputError) as caught:
                KINDS[kind].use(path)
            reported = f"{path}: line 6, column {name} is "
            assert str(caught.value).startswith(reported)
            assert "a finite number from " in str(caught.value)


def test_times_too_near_to_one_another(tmp_path: Path) -> None:
    poses = tmp_path / "poses.csv"
    poses.write_text("time_s,x_m,y_m,z_m\n0,0,0,1\n5e-324,0,0,1\n1e-323,0,0,1\n")
    with pytest.raises(om.InputError, match=r"column time_s is 5e-324, .* by 1e-06 s or more"):
        samples.SampledReference.from_csv(poses)


def test_a_command_without_rest_is_reported(tmp_path: Path) -> None:
    """Thousands of steps would take minutes to fit."""
    speeds = [40 + k % 20 for k in range(3000)]
    rows = [f"{k},{w},{20 + 20 * (k % 2)},{w * w},{w * w}" for k, w in enumerate(speeds)]
    bench = tmp_path / "bench.csv"
    bench.write_text("\n".join(["time_s,speed_Hz,command_Hz,force_N,torque_Nm", *rows]))
    with pytest.raises(om.InputError, match=r"number of steps of the command is 2999, but it must"):
        KINDS["bench"].use(bench)


def test_a_bench_that_rests_is_reported(tmp_path: Path) -> None:
    """All speeds zero, beside a command or another speed that is not."""
    for names in ("speed_Hz,command_Hz", "speed_Hz,speed_rpm", "speed_rpm,speed_Hz"):
        rows = [f"{0.1 * k},0.0,{10 + k},1.0,0.1" for k in range(20)]
        bench = tmp_path / "bench.csv"
        bench.write_text("\n".join([f"time_s,{names},force_N,torque_Nm", *rows]))
        with pytest.raises(om.InputError):
            KINDS["bench"].use(bench)
