"""Imperfections of the plant: objects one adds to a list.

::

    PlantModel(effects=(RotorLag(up=0.020), Effectiveness(share=0.65)))

Each is a small frozen record in SI; left out, a parameter is the vehicle's own. In files an effect
is a table with its kind: ``{kind = "rotor-lag", up_ms = 20}``. The arithmetic of each is in
``core/include/omnimorph/plant/`` and ``estimate/``.
"""

from __future__ import annotations

from omnimorph.simulation.effects.control import CommandDelay as CommandDelay
from omnimorph.simulation.effects.control import MeasurementNoise as MeasurementNoise
from omnimorph.simulation.effects.control import ModelMismatch as ModelMismatch
from omnimorph.simulation.effects.disturbances import ConstantWrench as ConstantWrench
from omnimorph.simulation.effects.disturbances import SineWrench as SineWrench
from omnimorph.simulation.effects.disturbances import WrenchProfile as WrenchProfile
from omnimorph.simulation.effects.effect import Effect as Effect
from omnimorph.simulation.effects.effect import PlantBuild as PlantBuild
from omnimorph.simulation.effects.rotors import DeadBand as DeadBand
from omnimorph.simulation.effects.rotors import Effectiveness as Effectiveness
from omnimorph.simulation.effects.rotors import Interference as Interference
from omnimorph.simulation.effects.rotors import RotorLag as RotorLag
from omnimorph.simulation.effects.rotors import RotorMomentum as RotorMomentum
from omnimorph.simulation.effects.rotors import SpeedLimits as SpeedLimits
from omnimorph.simulation.effects.servos import ServoLag as ServoLag
from omnimorph.simulation.effects.servos import ServoRateLimit as ServoRateLimit

EFFECTS: tuple[type[Effect], ...] = tuple(
    here
    for here in list(vars().values())
    if isinstance(here, type) and issubclass(here, Effect) and here is not Effect
)
"""Every effect that a file can name: those that are imported here."""
