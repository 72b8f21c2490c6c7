"""Imperfections of the plant: objects one adds to a list.

::

    PlantModel(effects=(RotorLag(up=0.020), Effectiveness(share=0.65)))

Each is a small frozen record in SI; left out, a parameter is the vehicle's own. In files an effect
is a table with its kind: ``{kind = "rotor-lag", up_ms = 20}``. The arithmetic of each is in
``core/include/omnimorph/effects/``.
"""

from __future__ import annotations

from omnimorph.simulation.effects.control import CommandDelay, MeasurementNoise, ModelMismatch
from omnimorph.simulation.effects.disturbances import ConstantWrench, SineWrench, WrenchProfile
from omnimorph.simulation.effects.effect import Effect, PlantBuild
from omnimorph.simulation.effects.rotors import (
    DeadBand,
    Effectiveness,
    Interference,
    RotorLag,
    RotorMomentum,
    SpeedLimits,
)
from omnimorph.simulation.effects.servos import ServoLag, ServoRateLimit

__all__ = [
    "EFFECTS",
    "CommandDelay",
    "ConstantWrench",
    "DeadBand",
    "Effect",
    "Effectiveness",
    "Interference",
    "MeasurementNoise",
    "ModelMismatch",
    "PlantBuild",
    "RotorLag",
    "RotorMomentum",
    "ServoLag",
    "ServoRateLimit",
    "SineWrench",
    "SpeedLimits",
    "WrenchProfile",
]

EFFECTS: tuple[type[Effect], ...] = (
    CommandDelay,
    RotorLag,
    SpeedLimits,
    DeadBand,
    Effectiveness,
    ModelMismatch,
    ServoLag,
    ServoRateLimit,
    MeasurementNoise,
    ConstantWrench,
    SineWrench,
    WrenchProfile,
    RotorMomentum,
    Interference,
)
"""Every effect that a file can name."""
