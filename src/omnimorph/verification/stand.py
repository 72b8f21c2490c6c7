"""The test stand: the published experiment on interference, and what does not change in it."""

from __future__ import annotations

import math

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.simulation.effects import Effect, Interference
from omnimorph.simulation.speed_profile import speed_steps
from omnimorph.simulation.thrust_stand import StandReading, ThrustStand
from omnimorph.verification.case import Result, case, largest
from omnimorph.verification.setting import omnimorph

_LOWER, _UPPER = 4, 0
_FORCE = 1.8638e-4 * 120.0**2  # N, at 120 Hz
_LEVELS = np.arange(7) / 6.0  # speed of the others over 120 Hz
_PUBLISHED = "Aboudorra et al. 2024, section on mutual interference, to the digits it gives"


def _steps(rotor: int, tilt_deg: float, *effects: Effect) -> StandReading:
    """Return the reading of a rotor at 120 Hz beside seven that take 0.1 s for each 20 Hz."""
    vehicle, tilt = omnimorph(), math.radians(tilt_deg)
    stand = ThrustStand(vehicle=vehicle, rotor=rotor, tilt=tilt, effects=effects)
    return stand.measure(speed_steps(vehicle, rotor, dwell=0.1))


def _lost(rotor: int, tilt_deg: float) -> FloatArray:
    """Return the share of its thrust that a rotor has lost at the end of each step."""
    lost: FloatArray = 1.0 - _steps(rotor, tilt_deg, Interference()).true_thrust[100::100] / _FORCE
    return lost


@case("2.684 N = 1.8638e-4 N/Hz² · (120 Hz)², the paper's bench: 2.7 N")
def rotor_alone_gives_its_thrust() -> Result:
    """On the stand a rotor that none blows on gives c_f w² at any tilt."""
    forces = [_steps(_LOWER, tilt_deg).true_thrust[1:] for tilt_deg in (0.0, 30.0, 50.0)]
    return Result(value=largest(np.array(forces) - _FORCE), tolerance=1e-12, unit="N")


@case(_PUBLISHED)
def lower_rotor_loses_a_third_upright() -> Result:
    """At α = 0, all rotors at 120 Hz, a lower rotor loses 33 % of its thrust."""
    return Result(value=_lost(_LOWER, 0.0)[-1], expected=0.33, tolerance=0.005)


@case(_PUBLISHED)
def lower_rotor_loses_little_tilted() -> Result:
    """At α = 50°, all rotors at 120 Hz, a lower rotor loses 7 % of its thrust."""
    return Result(value=_lost(_LOWER, 50.0)[-1], expected=0.07, tolerance=0.005)


@case("the published model: loss = 0.333 w_up/w_down")
def loss_grows_with_the_partners_speed() -> Result:
    """Step by step a lower rotor loses in proportion to the speed of the one above."""
    return Result(value=largest(_lost(_LOWER, 0.0) - 0.333 * _LEVELS), tolerance=1e-12)


@case("definition: a wake leaves a rotor against its thrust")
def upper_rotor_loses_nothing() -> Result:
    """An upper rotor gives the same force whatever the other seven do."""
    return Result(value=largest(_lost(_UPPER, 0.0)), tolerance=1e-12)


@case("definition: wakes take thrust alone")
def wakes_leave_the_drag_on_the_stand() -> Result:
    """The torque about the hub is −k c_τ w|w| z, in wakes as without."""
    reading = _steps(_LOWER, 50.0, Interference())
    drag = -omnimorph().rotor_spin[_LOWER] * 2.754e-6 * 120.0**2 * reading.axis
    return Result(value=largest(reading.true_torque[1:] - drag), tolerance=1e-14, unit="N m")
