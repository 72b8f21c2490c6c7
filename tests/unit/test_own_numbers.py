"""Effects that take their numbers from the vehicle: what is said where it has none."""

from __future__ import annotations

import pytest

import omnimorph as om
from omnimorph import effects
from omnimorph.errors import ScenarioError
from omnimorph.simulation.effects import EFFECTS, Effect


@pytest.mark.parametrize(
    ("effect", "field", "key", "own"),
    [
        (effects.RotorLag(), "time_constant_up", "rotor.time_constant_up_ms", "up_ms"),
        (effects.DeadBand(), "dead_band", "rotor.dead_band_Hz", "smallest_Hz"),
        (effects.RotorMomentum(), "spin_inertia", "rotor.spin_inertia_kg_m2", ""),
        (effects.ServoLag(), "servo_time_constant", "servo.time_constant_ms", "time_constant_ms"),
        (effects.MeasurementNoise(filtered=True), "filter_cutoff", "filter", ""),
    ],
)
def test_a_number_that_is_meant_of_the_vehicle_is_called_by_its_file(
    effect: Effect, field: str, key: str, own: str
) -> None:
    vehicle = om.load_vehicle("omnimorph")
    without = vehicle.replace(name="mine", **{field: 0.0 * getattr(vehicle, field)})
    plant = om.PlantModel(name="p", effects=(effect,))
    with pytest.raises(ScenarioError) as caught:
        plant.build_settings(without)
    told = f"positive, because the plant's effect {effect.kind} takes it from the vehicle"
    told += f"; or give the effect {own} of its own" if own else ""
    assert str(caught.value) == f"vehicle mine: {key} is 0, but it must be {told}."


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
            plant.build_settings(bare)
        except ScenarioError as error:
            refused[kind.kind] = str(error)
    assert {"rotor-lag", "dead-band", "rotor-momentum", "servo-lag"} <= set(refused)
    assert all(told.startswith("vehicle bare: ") for told in refused.values())
    assert not any("missing" in told for told in refused.values())
