"""Effects that take their numbers from the vehicle: what is said where it has none."""

from __future__ import annotations

from pathlib import Path

import pytest

import omnimorph as om
from omnimorph import effects
from omnimorph.cli.main import main
from omnimorph.design.files import vehicle_text
from omnimorph.errors import ScenarioError
from omnimorph.simulation.effects import EFFECTS, Effect


@pytest.mark.parametrize(
    ("effect", "field", "key", "remedy"),
    [
        (
            effects.RotorLag(),
            "time_constant_up",
            "rotor.time_constant_up_ms",
            "; or give the effect up_ms of its own",
        ),
        (
            effects.RotorLag(),
            "time_constant_down",
            "rotor.time_constant_down_ms",
            "; or give the effect down_ms of its own",
        ),
        (
            effects.DeadBand(),
            "dead_band",
            "rotor.dead_band_Hz",
            "; or give the effect smallest_Hz of its own",
        ),
        (
            effects.RotorMomentum(),
            "spin_inertia",
            "rotor.spin_inertia_kg_m2",
            "; or fly in the plant realistic-1, which lacks that effect",
        ),
        (
            effects.ServoLag(),
            "servo_time_constant",
            "servo.time_constant_ms",
            "; or give the effect time_constant_ms of its own",
        ),
        (effects.MeasurementNoise(filtered=True), "filter_cutoff", "filter", ""),
    ],
)
def test_a_number_that_is_meant_of_the_vehicle_is_called_by_its_file(
    effect: Effect, field: str, key: str, remedy: str
) -> None:
    vehicle = om.load_vehicle("omnimorph")
    without = vehicle.replace(name="mine", **{field: 0.0 * getattr(vehicle, field)})
    plant = om.PlantModel(name="p", effects=(effect,))
    with pytest.raises(ScenarioError) as caught:
        plant.core_fields(without)
    reported = f"positive, because the plant's effect {effect.kind} takes it from the vehicle"
    reported += remedy
    assert str(caught.value) == f"vehicle mine: {key} is 0, but it must be {reported}."


def test_a_vehicle_that_only_another_plant_takes_flies_in_that(tmp_path: Path) -> None:
    vehicle = om.load_vehicle("quadrotor")
    without = vehicle.replace(spin_inertia=0.0 * vehicle.spin_inertia)
    tour = om.load_scenario("tour")
    with pytest.raises(ScenarioError, match="fly in the plant realistic-1"):
        tour.for_vehicle(without)
    flown = tour.for_vehicle(without, plant="realistic-1")
    assert (flown.plant.name, flown.gains) == ("realistic-1", tour.for_vehicle(vehicle).gains)
    (tmp_path / "mine.toml").write_text(vehicle_text(without), encoding="utf-8")
    words = ["fly", "tour", "--vehicle", str(tmp_path / "mine.toml"), "--out", str(tmp_path / "o")]
    assert main([*words, "--plant", "realistic-1"]) == 0
    assert om.load_run(tmp_path / "o" / "run.nc").provenance.plant_name == "realistic-1"
    assert main(words) == 2


def test_every_effect_that_falls_back_on_the_vehicle_says_so_that_way() -> None:
    """With a vehicle that has no numbers of its own, none names a key of the plant as missing."""
    bare = om.load_vehicle("omnimorph").replace(
        name="bare",
        **{
            field: 0.0 * getattr(om.load_vehicle("omnimorph"), field)
            for field in (
                *("time_constant_up", "time_constant_down", "dead_band", "spin_inertia"),
                *("servo_time_constant", "filter_cutoff"),
            )
        },
    )
    refused: dict[str, str] = {}
    for kind in EFFECTS:
        try:
            plant = om.PlantModel(name="p", effects=(kind(),))
        except (TypeError, ScenarioError):  # it has numbers that one must give
            continue
        try:
            plant.core_fields(bare)
        except ScenarioError as error:
            refused[kind.kind] = str(error)
    assert {"rotor-lag", "dead-band", "rotor-momentum", "servo-lag"} <= set(refused)
    assert all(reported.startswith("vehicle bare: ") for reported in refused.values())
    assert not any("missing" in reported for reported in refused.values())
