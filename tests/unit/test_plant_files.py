"""Plant files, and plants inside scenarios: what they say, and every way to be wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from tests.unit.scenario_parts import PLANT, SEGMENTS, TOP, changed, refusal

import omnimorph as om
from omnimorph import effects
from omnimorph.errors import InputError, ScenarioError
from omnimorph.simulation.scenario_files import list_plants

# --- what is wrong in a plant ---------------------------------------------------------------------

EFFECT = "plant.effect[0]"
WRONG_PLANTS = [
    ("schema = 1", "", "schema", "is missing, but it must be 1"),
    ('name = "wobbly"', 'name = ""', "name", "a name"),
    ("step_ms = 1.0", "step_ms = 0", "plant.physics_step_ms", "a positive number of milliseconds"),
    ("step_ms = 1.0", "step_ms = -1.0", "plant.physics_step_ms", "a positive number"),
    ("step_ms = 1.0", "step_ms = nan", "plant.physics_step_ms", "a positive number"),
    ("step_ms = 1.0", 'step_ms = "1"', "plant.physics_step_ms", "a positive number"),
    ("step_ms = 1.0", "step_ms = 3.0", "control_period_ms", "a multiple of the physics step, 3 ms"),
    ("_ms = 4.0", "_ms = 0.5", "control_period_ms", "is 0.5, but it must be a multiple"),
    ("physics_step_ms", "physics_step", "plant.physics_step", "did you mean physics_step_ms"),
    ('"runge-kutta-4"', '"euler"', "plant.integrator", "semi-implicit-euler or runge-kutta-4"),
    ('"rotor-lag"', '"rotor-lagg"', f"{EFFECT}.kind", "one of command-delay, "),
    ('kind = "rotor-lag"', "", f"{EFFECT}.kind", "is missing, but it must be one of command-delay"),
    ("up_ms = 20", "up_s = 20", f"{EFFECT}.up_s", "did you mean up_ms"),
    ("up_ms = 20", "up_ms = -1.0", f"{EFFECT}.up_ms", "is -1.0, but it must be a number of milli"),
    ("up_ms = 20", 'up_ms = "20"', f"{EFFECT}.up_ms", 'is "20", but it must be a number of milli'),
    ("up_ms = 20", "up_ms = true", f"{EFFECT}.up_ms", "is true, but it must be a number of milli"),
    ("up_ms = 20", "up_ms = nan", f"{EFFECT}.up_ms", "is nan, but it must be a number of milli"),
    ("up_ms = 20", '[[plant.effect]]\nkind = "rotor-lag"', "effect", "there only once"),
]
WRONG_EFFECTS = [
    ('kind = "effectiveness"', f"{EFFECT}.share", "is missing, but it must be a share"),
    ('kind = "effectiveness"\nshare = [1, -2]', f"{EFFECT}.share", "none negative"),
    ('kind = "effectiveness"\nshare = []', f"{EFFECT}.share", "none negative"),
    ('kind = "constant-wrench"\nforce_N = [1.0]', f"{EFFECT}.force_N", "three finite numbers"),
    ('kind = "sine-wrench"\nfrequency_Hz = 0', f"{EFFECT}.frequency_Hz", "a positive number"),
    ('kind = "model-mismatch"\nmass = 0.0', f"{EFFECT}.mass", "a positive factor"),
    (
        'kind = "speed-limits"\nlargest_Hz = -1',
        f"{EFFECT}.largest_Hz",
        "a positive number of hertz",
    ),
    ('kind = "measurement-noise"\nfiltered = "yes"', f"{EFFECT}.filtered", 'is "yes"'),
    (
        'kind = "wrench-profile"\ntimes_s = [0, nan]\nforce_N = [[0, 0, 0]]',
        f"{EFFECT}.times_s",
        "finite numbers of seconds",
    ),
]
UNFIT_EFFECTS = [
    ('kind = "effectiveness"\nshare = [1, 1]', "share", "one for each of the 8 rotors"),
    ('kind = "command-delay"\ntime_ms = 1.5', "time_ms", "a multiple of the physics step, 1 ms"),
    ('kind = "command-delay"\ntime_ms = 300', "time_ms", "at most 60 control periods"),
    (
        'kind = "wrench-profile"\ntimes_s = [1, 0]\nforce_N = [[0, 0, 0], [0, 0, 1]]',
        "times_s",
        "increasing",
    ),
    (
        'kind = "wrench-profile"\ntimes_s = [0, 1]\nforce_N = [[0, 0, 0]]',
        "force_N",
        "2 rows of three numbers",
    ),
]


@pytest.mark.parametrize(
    ("text", "key", "allowed"),
    [
        *((changed(PLANT, old, new), key, allowed) for old, new, key, allowed in WRONG_PLANTS),
        *(
            (PLANT[: PLANT.index("kind")] + effect, key, allowed)
            for effect, key, allowed in WRONG_EFFECTS
        ),
        ('schema = 1\nname = "p"\n', "plant", "is missing, but it must be a table"),
        ('schema = 1\nname = "p"\nplant = 3\n', "plant", "is 3, but it must be a table"),
    ],
)
def test_wrong_plant_is_refused_by_itself_and_in_a_scenario(
    tmp_path: Path, text: str, key: str, allowed: str
) -> None:
    file = tmp_path / "wobbly.toml"
    file.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        om.load_plant(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert caught.value.key == key
    assert allowed in str(caught.value)
    for jargon in ("pydantic", "Field", "str.", "dict", "Input should"):
        assert jargon not in str(caught.value)
    mentioned = changed(TOP, '"perfect"', '"wobbly.toml"') + SEGMENTS
    (tmp_path / "mine.toml").write_text(mentioned)
    with pytest.raises(ScenarioError) as again:
        om.load_scenario(tmp_path / "mine.toml")
    assert str(again.value) == str(caught.value)


@pytest.mark.parametrize(("old", "new", "key", "allowed"), WRONG_PLANTS[2:])
def test_wrong_plant_table_inside_a_scenario(
    tmp_path: Path, old: str, new: str, key: str, allowed: str
) -> None:
    table = changed(PLANT, old, new)
    error = refusal(
        tmp_path, changed(TOP, 'plant = "perfect"', "") + SEGMENTS + table[table.index("[plant]") :]
    )
    assert error.key == key
    assert allowed in str(error)


@pytest.mark.parametrize(("effect", "key", "allowed"), UNFIT_EFFECTS)
def test_effects_that_do_not_fit_the_vehicle_are_refused_before_the_flight(
    tmp_path: Path, effect: str, key: str, allowed: str
) -> None:
    plant = f"\n[plant]\n[[plant.effect]]\n{effect}\n"
    error = refusal(tmp_path, changed(TOP, 'plant = "perfect"', "") + SEGMENTS + plant)
    assert error.key == key
    assert allowed in str(error)


MORE = "\n[[reference.segment]]\nduration_s = 1e6\n"

# --- what cannot be flown ------------------------------------------------------------------------


@pytest.mark.parametrize(
    "segments",
    [changed(SEGMENTS, "1.0", "1e-5"), changed(SEGMENTS, "1.0", "1e6") + MORE * 2],
)
def test_flights_of_no_step_or_too_many(tmp_path: Path, segments: str) -> None:
    (tmp_path / "mine.toml").write_text(TOP + segments)
    scenario = om.load_scenario(tmp_path / "mine.toml")
    with pytest.raises(ScenarioError) as caught:
        om.fly(scenario)
    assert caught.value.key == "duration"
    assert "physics step" in str(caught.value)


@pytest.mark.parametrize(
    ("numbers", "key"),
    [({"seed": -1}, "seed"), ({"seed": 2**64}, "seed"), ({"flight": 2**32}, "flight")],
)
def test_noise_that_cannot_be_numbered(numbers: dict[str, int], key: str) -> None:
    with pytest.raises(InputError) as caught:
        om.fly(om.load_scenario("hover"), **numbers)  # type: ignore[arg-type]
    assert caught.value.key == key


# --- what they say --------------------------------------------------------------------------------


def load(folder: Path, text: str) -> om.Scenario:
    """Return the scenario of a text."""
    (folder / "mine.toml").write_text(text)
    return om.load_scenario(folder / "mine.toml")


def test_plant_table_file_and_name_mean_the_same(tmp_path: Path) -> None:
    (tmp_path / "wobbly.toml").write_text(PLANT)
    by_file = load(tmp_path, changed(TOP, '"perfect"', '"wobbly.toml"') + SEGMENTS).plant
    table = changed(TOP, 'plant = "perfect"', "") + SEGMENTS + PLANT[PLANT.index("[plant]") :]
    inside = load(tmp_path, table).plant
    assert by_file.name == "wobbly"
    assert by_file == replace(inside, name="wobbly")
    assert by_file == om.PlantModel(
        physics_step=1e-3,
        control_period=4e-3,
        integrator="runge-kutta-4",
        effects=(effects.RotorLag(up=0.02),),
        name="wobbly",
    )


def test_plants_of_the_catalogue() -> None:
    assert list_plants() == ["perfect", "realistic", "realistic-1"]
    perfect, realistic, before = (om.load_plant(name) for name in list_plants())
    assert perfect.effects == ()
    assert (perfect.physics_step, perfect.control_period) == (1e-3, 1e-3)
    assert (realistic.physics_step, realistic.control_period) == (1e-3, 4e-3)
    noise = effects.MeasurementNoise(position=1e-3, velocity=1e-2, attitude=3e-3, rate=1e-2)
    expected = (effects.RotorLag(), effects.SpeedLimits(), effects.ServoRateLimit(), noise)
    assert realistic.effects == (*expected, effects.RotorMomentum())
    assert before == replace(realistic, effects=expected, name="realistic-1")
