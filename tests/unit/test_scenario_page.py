"""The page on scenario files: its samples load and fly, and it names every key there is."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

import omnimorph as om
from omnimorph.control.rules import RULES
from omnimorph.control.tracking import TrackingGains
from omnimorph.design.records import Record
from omnimorph.design.tables import Table, file_model
from omnimorph.reference.samples import POSE_COLUMNS, QUATERNION_COLUMNS
from omnimorph.simulation import plant_files
from omnimorph.simulation import scenario_schema as schema
from omnimorph.simulation.effects import EFFECTS, Effect
from omnimorph.simulation.plant import INTEGRATORS
from omnimorph.simulation.scenario_files import list_plants

PAGE = (Path(__file__).parents[2] / "docs" / "scenarios.md").read_text(encoding="utf-8")
SAMPLES = dict(re.findall(r"^```toml\n# (\S+\.toml)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL))
POSES = re.findall(r"^```csv\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
NAMED = set(re.findall(r"[\w-]+", " ".join(re.findall(r"`([^`\n]+)`", PAGE))))
"""Every word of the page that stands between backticks in a line."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with the files of the page."""
    (tmp_path / "poses.csv").write_text(POSES[0], encoding="utf-8")
    for name, text in SAMPLES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def keys_in_file(record: type[Record]) -> set[str]:
    """Return the keys of a record in a file, with their units."""
    return set(file_model(record).model_fields) - {"kind"}


def test_the_page_is_one_page_of_complete_samples() -> None:
    assert len(SAMPLES) == PAGE.count("```toml") == 4
    assert len(PAGE.splitlines()) <= 185
    assert len(POSES) == 1
    kinds = {tomllib.loads(text).get("reference", {}).get("kind") for text in SAMPLES.values()}
    assert kinds >= {"segments", "waypoints", "samples"}


@pytest.mark.parametrize("name", SAMPLES)
def test_scenario_of_the_page_flies(folder: Path, name: str) -> None:
    scenario = om.load_scenario(folder / name)
    assert f"{scenario.name}.toml" == name
    run = om.fly(scenario)
    assert run.outcome is om.Outcome.COMPLETED
    assert run.time[-1] == pytest.approx(scenario.reference.duration)
    assert run.metrics.position_error_max_m < 0.1


def test_what_the_samples_say_is_flown(folder: Path) -> None:
    fixed = om.load_scenario(folder / "fixed-tilt.toml")
    assert fixed.allocator.kind == "fixed-tilt"
    assert fixed.reference.duration == 2.0
    exhaustive = om.load_scenario(folder / "exhaustive.toml").allocator
    assert isinstance(exhaustive, om.ExhaustiveTilt)
    assert (exhaustive.span, exhaustive.candidates) == ("range", 61)
    pushed = om.load_scenario(folder / "pushed.toml")
    assert [effect.kind for effect in pushed.plant.effects] == ["rotor-lag", "sine-wrench"]
    assert pushed.reference.duration == 2.0
    assert pushed.allocator == om.load_scenario("hover").allocator


def test_merging_as_the_page_tells_it(folder: Path) -> None:
    """Lists are replaced whole, tables merged; paths of a base are looked for beside the base."""
    below = folder / "below"
    below.mkdir()
    plant = 'schema = 1\nname = "worn"\n[plant]\ncontrol_period_ms = 2.0\n'
    (below / "worn.toml").write_text(plant, encoding="utf-8")
    base = SAMPLES["climb-and-roll.toml"].replace('"realistic"', '"worn.toml"')
    (below / "climb.toml").write_text(base, encoding="utf-8")
    text = 'name = "mine"\nbase = "below/climb.toml"\n'
    text += "[controller.allocator]\nW3_per_Hz4 = 1e-4\n[[reference.segment]]\nduration_s = 1.0\n"
    (folder / "mine.toml").write_text(text, encoding="utf-8")
    scenario = om.load_scenario(folder / "mine.toml")
    assert scenario.plant.name == "worn"
    assert scenario.reference.duration == 1.0
    assert scenario.reference(1.0).p_WB.tolist() == [0.0, 0.0, 1.2]
    weights = scenario.allocator.as_file()
    assert weights["W3_per_Hz4"] == pytest.approx(1e-4)
    assert weights["W1_per_Hz4"] == pytest.approx(1e-8)


def test_a_fixed_tilt_without_sideways_thrust_does_not_follow(folder: Path) -> None:
    text = SAMPLES["fixed-tilt.toml"].replace("start_tilt_deg = 45.0", "start_tilt_deg = 0.0")
    (folder / "level.toml").write_text(text, encoding="utf-8")
    run = om.fly(om.load_scenario(folder / "level.toml"))
    assert run.p_WB[-1, 0] == pytest.approx(0.0, abs=1e-3)
    assert run.desired_p_WB[-1, 0] == pytest.approx(0.3)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.kind)
def test_row_of_an_effect_names_its_keys(effect: type[Effect]) -> None:
    rows = re.findall(rf"^\| `{effect.kind}` \|([^|]*)\|([^|]+)\|$", PAGE, re.MULTILINE)
    assert len(rows) == 1
    keys, what_it_does = rows[0]
    assert set(re.findall(r"`(\w+)`", keys)) == keys_in_file(effect)
    assert what_it_does.strip()


@pytest.mark.parametrize("record", [TrackingGains, *RULES])
def test_keys_of_the_controller_are_named(record: type[Record]) -> None:
    assert keys_in_file(record) - NAMED == set()


@pytest.mark.parametrize(
    "table",
    [
        schema.ScenarioFile,
        plant_files.PlantFile,
        plant_files.PlantTable,
        schema.ProposedTable,
        schema.Segments,
        schema.SegmentTable,
        schema.Waypoints,
        schema.Waypoint,
        schema.Samples,
    ],
)
def test_keys_of_a_table_are_named(table: type[Table]) -> None:
    keys = {field.alias or name for name, field in table.model_fields.items()}
    assert {key for key in keys if key not in NAMED and f"[[reference.{key}]]" not in PAGE} == set()


def test_names_a_file_may_use_are_named() -> None:
    kinds = {*(rule.kind for rule in RULES), "segments", "waypoints", "samples"}
    assert {*kinds, *INTEGRATORS, *list_plants()} - NAMED == set()
    assert {*POSE_COLUMNS, *QUATERNION_COLUMNS} - NAMED == set()
