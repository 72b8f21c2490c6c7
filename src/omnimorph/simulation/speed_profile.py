"""What rotors are commanded on a test stand: speeds over time, such as steps of all but one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from omnimorph.arrays import as_numbers
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.errors import ScenarioError
from omnimorph.protocols import FloatArray
from omnimorph.simulation.whole_number import rotor_index
from omnimorph.units import from_SI, to_SI

_PROFILE = "the speed profile"
_MOST_LEVELS = 2**20
_ROUNDING = 1e-9
_120_Hz, _20_Hz = to_SI(120.0, "Hz"), to_SI(20.0, "Hz")


@dataclass(frozen=True, eq=False, kw_only=True)
class SpeedProfile:
    """The commanded speeds of all rotors, held from one change to the next.

    Attributes
    ----------
    time : (K,) array, s
        When each row of `speed` begins: the first at 0, increasing.
    speed : (K, n) array, rad/s
        Signed speeds of all rotors.
    duration : float, s
        When the last row ends.

    Raises
    ------
    ScenarioError
        If a number is not finite, a shape does not fit, or the times are not as said.
    """

    time: FloatArray
    speed: FloatArray
    duration: float

    def __post_init__(self) -> None:
        for name, dims in (("time", 1), ("speed", 2), ("duration", 0)):
            value = getattr(self, name)
            array = as_numbers(value).copy()
            if array.ndim != dims or not array.size or not np.isfinite(array).all():
                shape = ("one finite number", "a row of finite numbers", "rows of finite numbers")
                raise ScenarioError.at(_PROFILE, name, value, shape[dims])
            array.setflags(write=False)
            object.__setattr__(self, name, array if dims else float(array))
        if len(self.speed) != len(self.time):
            allowed = f"one for each of the {len(self.time)} times"
            raise ScenarioError.at(_PROFILE, "number of rows of speed", len(self.speed), allowed)
        if self.time[0] != 0.0 or not (np.diff(self.time) > 0.0).all():
            raise ScenarioError.at(_PROFILE, "time", self.time, "increasing, and 0 at first")
        if not self.duration > self.time[-1]:
            allowed = f"after the last change, at {self.time[-1]:g} s"
            raise ScenarioError.at(_PROFILE, "duration", self.duration, allowed)


def speed_steps(
    vehicle: VehicleLike,
    rotor: int,
    *,
    held: float = _120_Hz,
    step: float = _20_Hz,
    largest: float = _120_Hz,
    dwell: float = 5.0,
    alone: bool = False,
) -> SpeedProfile:
    """Return the profile of the experiment: one rotor at a constant speed, the others in steps.

    The others turn at 0, ±`step`, ±2 `step` … `largest`, `dwell` s each.

    Parameters
    ----------
    vehicle : Vehicle
        With n rotors.
    rotor : int
        The one that is measured.
    held : float, rad/s
        Its signed speed; 120 Hz by default.
    step : float, rad/s
        By how much the others grow faster each time, > 0; 20 Hz by default.
    largest : float, rad/s
        Their last speed, signed, a multiple of `step`; 120 Hz by default.
    dwell : float, s
        How long each step is held, > 0; 5 s by default.
    alone : bool
        Leave the others at rest, for as long: what there is to compare with.

    Returns
    -------
    SpeedProfile
        Of ``|largest|/step + 1`` rows.

    Raises
    ------
    ScenarioError
        If there is no such rotor, or a number is not as said.

    Examples
    --------
    >>> import omnimorph as om
    >>> profile = speed_steps(om.load_vehicle("omnimorph"), 4)
    >>> profile.duration, (profile.speed[:, [0, 4]].T / (2 * np.pi)).round(9)
    (35.0, array([[  0.,  20.,  40.,  60.,  80., 100., 120.],
           [120., 120., 120., 120., 120., 120., 120.]]))

    Notes
    -----
    Speeds: Aboudorra et al. 2024, section on mutual interference. The 5 s are ASSUMED: the paper
    does not say in words how long a step lasts.
    """
    vehicle = as_vehicle(vehicle)
    rotor = rotor_index(vehicle, rotor)
    for name, value in (("step", step), ("dwell", dwell)):
        if not 0.0 < value < math.inf:
            raise ScenarioError.at(_PROFILE, name, value, "a positive number")
    steps = abs(largest) / step
    if not (steps < _MOST_LEVELS and abs(steps - round(steps)) <= _ROUNDING * max(steps, 1.0)):
        allowed = f"a multiple of the step, {from_SI(step, 'Hz'):g} Hz"
        raise ScenarioError.at(_PROFILE, "largest", f"{from_SI(largest, 'Hz'):g} Hz", allowed)
    levels = np.linspace(0.0, largest, round(steps) + 1)
    speed = np.tile(0.0 * levels if alone else levels, (vehicle.n_rotors, 1)).T
    speed[:, rotor] = held
    time = dwell * np.arange(len(levels), dtype=np.float64)
    return SpeedProfile(time=time, speed=speed, duration=dwell * len(levels))
