"""Whole numbers of Python fly as the same numbers written with a point."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from tests.unit.test_variation import HOVER

import omnimorph as om
from omnimorph import effects
from omnimorph.simulation.effects import EFFECTS, Effect

WHOLE: list[Effect] = [
    effects.CommandDelay(time=0),
    effects.RotorLag(up=1, down=2),
    effects.SpeedLimits(largest=900),
    effects.DeadBand(smallest=1, reversal_time=0),
    effects.Effectiveness(share=1),
    effects.ModelMismatch(mass=1, inertia=1, thrust_coefficient=1, drag_coefficient=1),
    effects.ServoLag(time_constant=1),
    effects.ServoRateLimit(rate=2),
    effects.MeasurementNoise(position=0, velocity=0, attitude=0, rate=0),
    effects.ConstantWrench(force=(1, 0, 0), torque=(0, 0, 0)),
    effects.SineWrench(force=(1, 0, 0), torque=(0, 0, 0), frequency=9, phase=1),
    effects.WrenchProfile(times=(0, 1), force=((0, 0, 0), (1, 0, 0))),
]
RULE = om.JointTilt(W1=1, W2_position=(9, 9, 9), W2_attitude=(9, 9, 9), W3=0, W4=0)
GAINS = om.TrackingGains(position=9, velocity=(6, 6, 6), attitude=100, rate=20)


def as_floats(value: Any) -> Any:
    """Return a value, or a record, with a float for every whole number."""
    if isinstance(value, tuple):
        return tuple(map(as_floats, value))
    if isinstance(value, Effect | om.JointTilt | om.TrackingGains):
        return replace(
            value, **{one.name: as_floats(getattr(value, one.name)) for one in fields(value)}
        )
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value


def test_every_effect_with_numbers_is_here() -> None:
    assert {type(effect) for effect in WHOLE} == {kind for kind in EFFECTS if fields(kind)} - {
        effects.Interference
    }


@pytest.mark.parametrize(
    "change",
    [
        *({"plant": om.PlantModel(effects=(effect,))} for effect in WHOLE),
        {"gains": GAINS},
        {"allocator": RULE},
        {"start_tilt": 0, "lost_beyond": 2},
    ],
    ids=lambda change: str(change)[:40],
)
def test_whole_numbers_fly_as_the_same_floats(change: dict[str, Any]) -> None:
    floats = {name: as_floats(value) for name, value in change.items()}
    if "plant" in change:
        worn = as_floats(change["plant"].effects)
        floats = {"plant": replace(change["plant"], effects=worn)}
    run, other = om.fly(replace(HOVER, **change)), om.fly(replace(HOVER, **floats))
    np.testing.assert_array_equal(run.p_WB, other.p_WB)
    np.testing.assert_array_equal(run.speed, other.speed)
