"""An analysis as plain data, in the units people read: ``--json`` and ``results.json``.

Every key is described in ``docs/analysis.md``; the unit stands at its end. None stands where there
is no finite number: no power suffices, no condition number exists.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from omnimorph.analysis.hover import HoverMap, HoverPoint
from omnimorph.analysis.omnidirectional import Omnidirectionality
from omnimorph.analysis.overview import AtTilt, Trade, VehicleAnalysis, WakeEffect
from omnimorph.analysis.platform import Platform
from omnimorph.analysis.polytope import Polytope
from omnimorph.analysis.sweep import TiltSweep
from omnimorph.protocols import FloatArray
from omnimorph.units import from_SI
from omnimorph.version import __version__

ANALYSIS_SCHEMA = "omnimorph.analysis"
"""The value of ``schema``: by it a folder is known as an analysis."""


def analysis_data(analysis: VehicleAnalysis) -> dict[str, Any]:
    """Return an analysis as dictionaries, lists, texts and finite numbers."""
    vehicle = analysis.vehicle
    return {
        "schema": ANALYSIS_SCHEMA,
        "schema_version": 1,
        "omnimorph": __version__,
        "vehicle": {
            "name": vehicle.name,
            "title": vehicle.title,
            "rotors": vehicle.n_rotors,
            "servos": vehicle.n_servos,
            "mass_kg": vehicle.mass,
            "weight_N": analysis.weight,
            "dead_band_ignored": bool(vehicle.dead_band.any()),
        },
        "over_all_tilts": platform_data(analysis.platform),
        "tilt_limits_deg": _degrees(analysis.limits) if vehicle.n_servos else None,
        "at_tilt": [_at(one) for one in analysis.at],
        "singular_tilts": [
            {"tilt_deg": _degrees(one.tilt), "rank_thrust": one.rank} for one in analysis.singular
        ],
        "hovering_range_deg": _ranges(analysis.omnidirectional),
        "sweep": _sweep(analysis.sweep),
        "hover_map": _hover_map(analysis.hover_map),
        "interference": None if analysis.wakes is None else _wakes(analysis.wakes),
        "morphing_trade": None if analysis.trade is None else _trade(analysis.trade),
    }


def platform_data(found: Platform) -> dict[str, Any]:
    """Return the class and numbers of a vehicle over all its tilts, as `compare` has them too."""
    return {
        "actuation": found.kind.value,
        "thrust": found.thrust_kind.value,
        "radius_over_weight": found.radius_over_weight,
        "lateral_over_weight": found.lateral_over_weight,
        "hover_power_W_per_kg": _finite(found.hover_power_per_kg),
    }


def _at(one: AtTilt) -> dict[str, Any]:
    actuation = one.actuation
    return {
        "tilt_deg": _degrees(one.tilt),
        "why": one.why,
        "rank_thrust": actuation.rank_thrust,
        "rank_full": actuation.rank_full,
        "kind": actuation.kind.value,
        "thrust_kind": actuation.thrust_kind.value,
        "condition_number": _finite(actuation.condition_number),
        "singular_values_N": _finite(actuation.singular_values),
        "null_space": _finite(actuation.null_space.T),
        "conditions": [_finite(rows) for rows in actuation.conditions],
        "force_free_moment": _set(one.force_free, "N", "N3"),
        "force_zero_moment": _set(one.force_zero, "N", "N3"),
        "moment_at_level_hover": _set(one.moment, "Nm", "N3m3"),
        "largest_lift_N": one.force_zero.reach([0.0, 0.0, 1.0]),
        "level_hover": _hover(one.hover),
        "level_hover_least_norm": _hover(one.hover_norm),
        "attitudes_share": one.attitudes.share,
        "attitudes": one.attitudes.words,
    }


def _set(polytope: Polytope, unit: str, cubed: str) -> dict[str, Any]:
    sphere = polytope.inscribed_sphere()
    return {
        "dimension": polytope.dimension,
        f"radius_{unit}": sphere.radius,
        "radius_direction": _finite(sphere.direction),
        f"volume_{cubed}": polytope.volume,
        f"vertices_{unit}": _finite(polytope.vertices),
        "normals": _finite(polytope.normals),
        f"offsets_{unit}": _finite(polytope.offsets),
    }


def _hover(point: HoverPoint) -> dict[str, Any]:
    return {
        "feasible": point.feasible,
        "power_W": _finite(point.power),
        "power_paper": _finite(point.power_paper),
        "thrust_N": _finite(point.thrust) if point.feasible else None,
        "speed_Hz": _finite(from_SI(point.speed, "Hz")) if point.feasible else None,
    }


def _ranges(found: Omnidirectionality) -> dict[str, Any]:
    return {
        "every_attitude_zero_moment": _degrees(found.zero_moment),
        "every_attitude_free_moment": _degrees(found.free_moment),
        "level": _degrees(found.level),
        "every_attitude_zero_moment_whole_turn": _degrees(found.zero_moment_beyond),
        "every_attitude_free_moment_whole_turn": _degrees(found.free_moment_beyond),
        "level_whole_turn": _degrees(found.level_beyond),
    }


def _sweep(sweep: TiltSweep) -> dict[str, Any]:
    return {
        "tilt_deg": _degrees(sweep.tilt),
        "rank_thrust": sweep.rank_thrust.tolist(),
        "condition_number": _finite(sweep.condition_number),
        "radius_free_moment_N": _finite(sweep.radius_free_moment),
        "radius_zero_moment_N": _finite(sweep.radius_zero_moment),
        "largest_lift_N": _finite(sweep.largest_lift),
        "level_power_W": _finite(sweep.level_power),
    }


def _hover_map(found: HoverMap) -> dict[str, Any]:
    best = np.where(found.feasible, found.best_tilt, np.nan)
    return {
        "attitudes": len(found.up),
        "feasible_share": float(found.feasible.mean()),
        "up": _finite(found.up),
        "tilt_deg": _degrees(found.tilt),
        "power_W": _finite(found.power),
        "best_tilt_deg": _degrees(best),
        "least_power_W": _finite(found.least_power),
    }


def _wakes(effect: WakeEffect) -> dict[str, Any]:
    return {
        "model": "published",
        "pairs": effect.pairs.tolist(),
        "tilt_deg": _degrees(effect.tilt),
        "level_power_W": _finite(effect.power),
        "level_power_still_air_W": _finite(effect.power_still),
        "radius_zero_moment_at_least_N": _finite(effect.radius),
        "radius_zero_moment_still_air_N": _finite(effect.radius_still),
    }


def _trade(trade: Trade) -> dict[str, Any]:
    return {
        "tilt_fixed_deg": _degrees(trade.tilt_fixed),
        "break_even_share": _finite(trade.share),
        "break_even_share_in_wakes": _finite(trade.share_in_wakes),
        "own_share": trade.own,
        "break_even_tilt_deg": _angle(trade.break_even),
        "break_even_tilt_in_wakes_deg": _angle(trade.break_even_in_wakes),
    }


def _finite(value: float | FloatArray) -> Any:
    """Return numbers as lists, None for what is not finite."""
    if isinstance(value, np.ndarray):
        return [_finite(item) for item in value] if value.ndim else _finite(float(value))
    number = float(value) + 0.0  # no negative zero
    return number if math.isfinite(number) else None


def _degrees(angle: Any) -> Any:
    # Roots are good to about 1e-12 rad; what is beyond comes from the change of unit.
    return _finite(np.round(from_SI(np.asarray(angle, dtype=np.float64), "deg"), 10))


def _angle(angle: float | None) -> Any:
    return None if angle is None else _degrees(angle)
