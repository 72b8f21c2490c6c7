"""Everything a designer asks of a vehicle before it is built, in one record.

`analyze` asks each question of the other modules once; the command line, its JSON and the report
page only show what it returns.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnimorph.analysis.actuation import Actuation, SingularTilt, actuation, singular_tilts
from omnimorph.analysis.attitude_share import AttitudeShare, attitude_share
from omnimorph.analysis.hover import HoverMap, HoverPoint, hover, hover_map, sphere_directions
from omnimorph.analysis.morphing import break_even_tilt, mass_break_even_of, mechanism_share
from omnimorph.analysis.omnidirectional import (
    Omnidirectionality,
    inscribed_radius,
    omnidirectionality,
    tilt_of_largest_radius,
)
from omnimorph.analysis.platform import Platform, platform
from omnimorph.analysis.polytope import Polytope
from omnimorph.analysis.scaling import checked_tilt, common_limits
from omnimorph.analysis.sweep import TiltSweep, tilt_sweep
from omnimorph.analysis.wakes import hover_in_wakes, vehicle_in_wakes
from omnimorph.analysis.wrench_set import force_set, moment_set
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import VehicleError
from omnimorph.model.dynamics import GRAVITY
from omnimorph.model.interference import WakeModel, stacked_pairs
from omnimorph.protocols import FloatArray

Progress = Callable[[float, float, str], None]

ATTITUDES = 100
"""Attitudes of the hover-power map."""
MAP_TILTS = 61
"""Tilts of the hover-power map, over the limits of the servos."""
_SAME = 1e-6  # rad: tilts nearer than that are one
_WIDEST = 0.5 * math.pi  # the sweep goes on to 90°, to show what more travel would give


@dataclass(frozen=True, eq=False, kw_only=True)
class AtTilt:
    """The answers at one tilt.

    Attributes
    ----------
    tilt : (m,) array, rad
    why : str
        What makes this tilt worth a row.
    actuation : Actuation
    force_free, force_zero : Polytope, N
        The forces with free moments, and at zero moment.
    moment : Polytope, N m
        The moments together with the force that holds the weight, level; they may leave out zero,
        or be none, if it cannot hover.
    hover, hover_norm : HoverPoint
        Level, with the least power and with the least norm of thrusts.
    attitudes : AttitudeShare
        Of all attitudes, those in which it can hover.
    """

    tilt: FloatArray
    why: str
    actuation: Actuation
    force_free: Polytope
    force_zero: Polytope
    moment: Polytope
    hover: HoverPoint
    hover_norm: HoverPoint
    attitudes: AttitudeShare


@dataclass(frozen=True, eq=False, kw_only=True)
class WakeEffect:
    """What rotors that blow on one another cost, over K tilts.

    Attributes
    ----------
    pairs : (p, 2) array of int
        Rotors in line: (above, below).
    tilt : (K,) array, rad
        Common to all servos.
    power, power_still : (K,) arrays, W
        Of hovering level, with and without wakes; inf where it cannot.
    radius, radius_still : (K,) arrays, N
        Inscribed at zero moment: what is left for certain, and in still air.
    """

    pairs: NDArray[np.int64]
    tilt: FloatArray
    power: FloatArray
    power_still: FloatArray
    radius: FloatArray
    radius_still: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Trade:
    """Whether the tilt mechanism pays for its mass.

    Attributes
    ----------
    tilt_fixed : (K,) array, rad
        The tilt of the vehicle it is compared with, which has no mechanism.
    share, share_in_wakes : (K,) arrays
        Relative mass of the mechanism that just pays, in still air and in the rotors' wakes; inf
        where the other cannot hover. The same twice if no rotors are in line. Still air leaves out
        the limits of thrust, as the paper does.
    own : float or None
        Relative mass of this vehicle's mechanism, if it is known.
    break_even, break_even_in_wakes : float or None, rad
        The fixed tilt beyond which this vehicle's own mechanism pays.
    """

    tilt_fixed: FloatArray
    share: FloatArray
    share_in_wakes: FloatArray
    own: float | None
    break_even: float | None
    break_even_in_wakes: float | None


@dataclass(frozen=True, eq=False, kw_only=True)
class VehicleAnalysis:
    """Everything that was asked of a vehicle.

    Attributes
    ----------
    vehicle : Vehicle
    platform : Platform
        Its class and numbers over all tilts, each servo at its own: what `compare` shows. All else
        here is at one tilt common to all servos, or at the one asked for.
    limits : (float, float), rad
        Tilts that all servos can take together.
    at : tuple of AtTilt
        The answers at tilts that stand out, and at the one asked for.
    asked : AtTilt
        One of them: the tilt asked for, by default that of the largest radius at zero moment, where
        it can hover level if it can anywhere.
    singular : tuple of SingularTilt
        Over the whole turn.
    omnidirectional : Omnidirectionality
    sweep : TiltSweep
        Over the limits and on to 90°.
    hover_map : HoverMap
        Least hover power over attitude and tilt, within the limits.
    wakes : WakeEffect or None
        None if no two rotors are in line.
    trade : Trade or None
        None for a vehicle without servos, or one that cannot hover level untilted, in the wakes of
        its own rotors where there are any.
    """

    vehicle: Vehicle
    platform: Platform
    limits: tuple[float, float]
    at: tuple[AtTilt, ...]
    asked: AtTilt
    singular: tuple[SingularTilt, ...]
    omnidirectional: Omnidirectionality
    sweep: TiltSweep
    hover_map: HoverMap
    wakes: WakeEffect | None
    trade: Trade | None

    @property
    def weight(self) -> float:
        """M g, N."""
        return self.vehicle.mass * GRAVITY


def analyze(
    vehicle: VehicleLike,
    tilt: ArrayLike | None = None,
    *,
    beyond_limits: bool = False,
    progress: Progress | None = None,
) -> VehicleAnalysis:
    """Analyse a vehicle: actuation, force and moment sets, hover, wakes, morphing.

    Parameters
    ----------
    vehicle : Vehicle
        Any whose servos, if it has several, have a tilt in common.
    tilt : float or (m,) array, rad, optional
        Where the sets are shown; by default where the radius at zero moment is largest.
    beyond_limits : bool
        Allow a tilt that the servos cannot reach.
    progress : callable, optional
        Called with what is done, what there is to do, and what comes next.

    Raises
    ------
    VehicleError
        If the tilt cannot be used.
    """
    vehicle = as_vehicle(vehicle)
    steps = _Steps(progress)
    limits = common_limits(vehicle)
    asked = None if tilt is None else checked_tilt(vehicle, tilt, beyond_limits)
    steps.next("the vehicle over all tilts")
    overall = platform(vehicle)
    steps.next("tilts that stand out")
    singular = singular_tilts(vehicle, beyond_limits=True)
    omnidirectional = omnidirectionality(vehicle, limits)
    steps.next("sweep over the tilt")
    high = max(limits[1], _WIDEST) if vehicle.n_servos else limits[1]
    sweep = tilt_sweep(vehicle, _from_to(limits[0], high, 181), beyond_limits=True)
    steps.next("hover power over attitude and tilt")
    best = _best_tilt(vehicle, sweep, limits)
    power = hover_map(vehicle, sphere_directions(ATTITUDES), _from_to(*limits, MAP_TILTS))
    steps.next("wakes")
    wakes = _wake_effect(vehicle, limits)
    steps.next("what morphing buys")
    trade = _trade(vehicle, wakes is not None)
    steps.next("sets")
    shown = checked_tilt(vehicle, best, True) if asked is None else asked
    rows = _rows(vehicle, limits, omnidirectional, best, singular)
    if not any(np.allclose(shown, where, rtol=0.0, atol=_SAME) for where, _ in rows):
        rows.append(
            (shown, ("shown" if asked is None else "asked for") if vehicle.n_servos else "")
        )
    at = tuple(_at(vehicle, where, why) for where, why in rows)
    return VehicleAnalysis(
        vehicle=vehicle,
        platform=overall,
        limits=limits,
        at=at,
        asked=min(at, key=lambda one: float(np.abs(one.tilt - shown).max(initial=0.0))),
        singular=singular,
        omnidirectional=omnidirectional,
        sweep=sweep,
        hover_map=power,
        wakes=wakes,
        trade=trade,
    )


def _best_tilt(vehicle: Vehicle, sweep: TiltSweep, limits: tuple[float, float]) -> float:
    """Return the tilt of the largest radius at zero moment; one that can hover if there is any.

    If no tilt has a radius, the one nearest to zero.
    """
    able = (sweep.tilt <= limits[1]) & np.isfinite(sweep.level_power)
    upright = min(max(limits[0], 0.0), limits[1])
    best = tilt_of_largest_radius(vehicle)
    if inscribed_radius(vehicle, best, zero_moment=True) <= 0.0:
        best = upright
    if hover(vehicle, best).feasible or not able.any():
        return best
    return float(sweep.tilt[np.where(able, sweep.radius_zero_moment, -1.0).argmax()])


class _Steps:
    """Says what comes next."""

    _ALL = 7

    def __init__(self, progress: Progress | None) -> None:
        self._progress, self._done = progress, 0

    def next(self, label: str) -> None:
        if self._progress is not None:
            self._progress(self._done, self._ALL, label)
        self._done += 1


def _rows(
    vehicle: Vehicle,
    limits: tuple[float, float],
    omnidirectional: Omnidirectionality,
    best: float,
    singular: tuple[SingularTilt, ...],
) -> list[tuple[FloatArray, str]]:
    """Return the tilts that stand out within the limits, in order, each with the reason."""
    if vehicle.n_servos == 0:
        return []
    reasons = [(limits[0], "least tilt"), (limits[1], "largest tilt")]
    reasons += [(one.tilt, f"rank {one.rank}") for one in singular]
    for begin, end in omnidirectional.zero_moment:
        reasons += [(begin, "omnidirectional from here"), (end, "up to here")]
    if inscribed_radius(vehicle, best, zero_moment=True) > 0.0:
        reasons.append((best, "largest radius"))
    by_tilt: dict[float, list[str]] = {}
    for tilt, reason in sorted(reasons):
        if limits[0] - 1e-9 <= tilt <= limits[1] + 1e-9:
            near = next((known for known in by_tilt if abs(known - tilt) < _SAME), tilt)
            by_tilt.setdefault(near, []).append(reason)
    return [(np.full(vehicle.n_servos, tilt), ", ".join(why)) for tilt, why in by_tilt.items()]


def _at(vehicle: Vehicle, tilt: FloatArray, why: str) -> AtTilt:
    level = np.array([0.0, 0.0, vehicle.mass * GRAVITY])
    forces = force_set(vehicle, tilt, zero_moment=True, beyond_limits=True)
    return AtTilt(
        tilt=tilt,
        why=why,
        actuation=actuation(vehicle, tilt, beyond_limits=True),
        force_free=force_set(vehicle, tilt, zero_moment=False, beyond_limits=True),
        force_zero=forces,
        moment=moment_set(vehicle, tilt, force=level, beyond_limits=True),
        hover=hover(vehicle, tilt, beyond_limits=True),
        hover_norm=hover(vehicle, tilt, least="norm", beyond_limits=True),
        attitudes=attitude_share(vehicle, forces),
    )


def _wake_effect(vehicle: Vehicle, limits: tuple[float, float]) -> WakeEffect | None:
    pairs = stacked_pairs(vehicle)
    if not len(pairs):
        return None
    tilts = _from_to(*limits, 25)
    still = tilt_sweep(vehicle, tilts)
    left = [
        force_set(vehicle_in_wakes(vehicle, tilt), tilt, zero_moment=True).inscribed_radius
        for tilt in tilts
    ]
    return WakeEffect(
        pairs=pairs,
        tilt=tilts,
        power=np.array([hover_in_wakes(vehicle, tilt).power for tilt in tilts]),
        power_still=still.level_power,
        radius=np.array(left),
        radius_still=still.radius_zero_moment,
    )


def _trade(vehicle: Vehicle, with_wakes: bool) -> Trade | None:
    if vehicle.n_servos == 0:
        return None
    tilts = np.radians(np.arange(0.0, 61.0, 2.5))
    own = mechanism_share(vehicle)
    models: tuple[WakeModel | None, WakeModel | None] = (None, "published" if with_wakes else None)
    try:
        still, in_wakes = (mass_break_even_of(vehicle, tilts, wakes=model) for model in models)
    except VehicleError:
        return None
    crossings = [
        None if own is None else break_even_tilt(vehicle, own, wakes=model) for model in models
    ]
    return Trade(
        tilt_fixed=tilts,
        share=still,
        share_in_wakes=in_wakes,
        own=own,
        break_even=crossings[0],
        break_even_in_wakes=crossings[1],
    )


def _from_to(low: float, high: float, count: int) -> FloatArray:
    return np.linspace(low, high, count if high > low else 1)
