"""The effects that the flights with kept values are flown with.

Time constants, frequency and phase are such that no exponential and no sine lies near the middle
between two numbers of double precision: every good C library rounds them alike.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from tests.physics.golden_parts import NOISE

from omnimorph import effects

SWING: dict[str, Any] = {"frequency": 16.25, "phase": 0.1875}
WORN: dict[str, tuple[effects.Effect, ...]] = {
    "none": (),
    "command-delay": (effects.CommandDelay(time=0.006),),
    "rotor-lag": (effects.RotorLag(up=0.03125, down=0.0625),),
    "rotor-lag up": (effects.RotorLag(up=0.03125),),
    "speed-limits": (effects.SpeedLimits(largest=440.0),),
    "dead-band": (effects.DeadBand(smallest=350.0, reversal_time=0.01),),
    "effectiveness": (effects.Effectiveness(share=(1.0, 0.5, 1.0, 1.0, 0.75, 1.0, 1.0, 0.0)),),
    "model-mismatch": (
        effects.ModelMismatch(
            mass=1.25, inertia=0.75, thrust_coefficient=0.875, drag_coefficient=1.5
        ),
    ),
    "servo-lag": (effects.ServoLag(time_constant=0.03125),),
    "servo-rate-limit": (effects.ServoRateLimit(rate=0.75),),
    "measurement-noise": (NOISE,),
    "measurement-noise filtered": (replace(NOISE, filtered=True),),
    "constant-wrench": (
        effects.ConstantWrench(force=(1.0, 2.0, 3.0), torque=(0.125, 0.25, 0.375)),
        effects.ConstantWrench(force=(0.5, -4.0, 0.0)),
    ),
    "sine-wrench": (effects.SineWrench(force=(4.0, 0.0, 2.0), torque=(0.0, 0.25, 0.0), **SWING),),
    "wrench-profile": (
        effects.WrenchProfile(
            times=(0.03125, 0.125, 0.1875),
            force=((0.0, 0.0, 4.0), (2.0, 0.0, -1.0), (0.0, 3.0, 0.0)),
            torque=((0.25, 0.0, 0.0), (0.0, 0.0, 0.125), (0.0, 0.0, 0.0)),
        ),
    ),
    "rotor-momentum": (effects.RotorLag(up=0.03125), effects.RotorMomentum()),
    "interference published": (effects.Interference(),),
    "interference blade-element": (effects.Interference(model="blade-element"),),
}
EVERYTHING = (
    effects.CommandDelay(time=0.002),
    effects.RotorLag(up=0.03125, down=0.0625),
    effects.SpeedLimits(),
    effects.DeadBand(smallest=64.0, reversal_time=0.004),
    effects.Effectiveness(share=0.9375),
    effects.ModelMismatch(mass=1.0625, drag_coefficient=0.875),
    effects.ServoLag(time_constant=0.015625),
    effects.ServoRateLimit(),
    replace(NOISE, filtered=True),
    effects.ConstantWrench(force=(0.5, 0.25, -1.0)),
    effects.SineWrench(force=(1.0, 0.0, 0.0), **SWING),
    *WORN["wrench-profile"],
    effects.RotorMomentum(),
    effects.Interference(),
)
