"""What an analysis comes to: its vehicle in a sentence, and key points.

Every sentence holds for the vehicle it is said of. A radius never stands without its set.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from omnimorph.analysis.actuation import ThrustKind
from omnimorph.analysis.overview import VehicleAnalysis, WakeEffect
from omnimorph.report.analysis_text import (
    count_text,
    intervals_text,
    judged_text,
    listed,
    lost_text,
    singular_text,
)
from omnimorph.report.tables import degrees, number, tilt_text


class KeyPoint(NamedTuple):
    """One line of the summary: what it is about, in bold, and how it goes on."""

    head: str
    text: str


def description(analysis: VehicleAnalysis) -> str:
    """Return what the vehicle is, in a sentence: rotors, servos, weight, limits of the thrusts."""
    vehicle = analysis.vehicle
    low, high = float(vehicle.thrust_min.min()), float(vehicle.thrust_max.max())
    servos = count_text(vehicle.n_servos, "servo")
    if vehicle.n_servos:
        least, most = analysis.limits
        reach = f"from {degrees(least)} to {degrees(most)}" if most > least else degrees(least)
        servos += f" (tilt {reach}{', which all reach' if vehicle.n_servos > 1 else ''})"
    each = "its rotor gives" if vehicle.n_rotors == 1 else "each rotor gives"
    return _unbroken(
        f"It has {count_text(vehicle.n_rotors, 'rotor')} and {servos}. It weighs "
        f"{number(analysis.weight)} N ({number(vehicle.mass)} kg); {each} {number(low)} to "
        f"{number(high)} N."
    )


def key_points(analysis: VehicleAnalysis) -> list[KeyPoint]:
    """Return what one has to know of a vehicle, a handful of lines."""
    points = [_omnidirectional(analysis), _level(analysis), _actuation(analysis)]
    if analysis.platform.has_free_tilts:
        points.insert(0, KeyPoint("All servos at one tilt.", judged_text(analysis.platform)))
    if analysis.asked.hover.feasible:
        points.append(_moments(analysis))
    if analysis.wakes is not None and np.isfinite(analysis.wakes.power).any():
        points.append(_in_wakes(analysis.wakes))
    if analysis.vehicle.n_servos:
        points.append(_mechanism(analysis))
    return [KeyPoint(head, _unbroken(text)) for head, text in points]


def _unbroken(text: str) -> str:
    """Return a text in which a number and its unit stay on one line."""
    return re.sub(r"(?<=\d) (?=(?:N|W|kg|Hz|%)(?!\w))", "\N{NO-BREAK SPACE}", text)


# --- key points ---------------------------------------------------------------------------------


def _omnidirectional(analysis: VehicleAnalysis) -> KeyPoint:
    found, weight = analysis.omnidirectional, analysis.weight
    best = max(analysis.at[:-1] or analysis.at, key=lambda one: one.force_zero.inscribed_radius)
    radius = best.force_zero.inscribed_radius
    share = f"{number(radius)} N ({number(100.0 * radius / weight, 3)} % of the weight)"
    if not analysis.vehicle.n_servos:
        free = number(best.force_free.inscribed_radius)
        text = f"Its radius is {share} at zero moment, which hovering needs, and {free} N with "
        text += "free moments."
        text += " There are directions in which it cannot push." if radius == 0.0 else ""
        holds = best.actuation.thrust_kind is ThrustKind.OMNIDIRECTIONAL
        return KeyPoint(f"{_yes_or_no(holds)}.", text)
    if len(found.zero_moment):
        text = f"{intervals_text(found.zero_moment)} at zero moment, which hovering needs; "
        text += f"{intervals_text(found.free_moment)} with free moments. The radius at zero "
        text += f"moment is largest at {tilt_text(best.tilt)}: {share}."
    else:
        text = f"at any tilt within its limits: the largest radius at zero moment is {share}"
        text += f", at {tilt_text(best.tilt)}." if radius > 0.0 else "."
        if len(found.free_moment):
            text += f" With free moments it would be {intervals_text(found.free_moment)}."
    head = _yes_or_no(len(found.zero_moment) > 0)
    head += " with all servos at one tilt" if analysis.platform.has_free_tilts else ""
    return KeyPoint(head, text + _further(analysis))


def _yes_or_no(holds: bool) -> str:
    return "Omnidirectional" if holds else "Not omnidirectional"


def _further(analysis: VehicleAnalysis) -> str:
    """Return what more travel upwards would give, at zero moment; "" if nothing."""
    beyond, limit = analysis.omnidirectional.zero_moment_beyond, analysis.limits[1]
    ahead = beyond[beyond[:, 1] > limit + 1e-6]
    if not len(ahead):
        return ""
    if ahead[0, 0] <= limit:
        return f" With more travel it would stay so up to {degrees(ahead[0, 1])} (zero moment)."
    return f" With more travel it would be so {intervals_text(ahead[:1])} (zero moment)."


def _level(analysis: VehicleAnalysis) -> KeyPoint:
    level, limits = analysis.omnidirectional.level, analysis.limits
    costs = _level_costs(analysis)
    if not costs:
        within = analysis.sweep.tilt <= limits[1] + 1e-9
        lift = number(float(analysis.sweep.largest_lift[within].max()))
        where = " at the best tilt" if limits[1] > limits[0] else ""
        text = f"at zero moment it lifts {lift} N straight up{where}, and weighs "
        return KeyPoint("Cannot hover level:", f"{text}{number(analysis.weight)} N.")
    if limits[1] <= limits[0]:
        return KeyPoint("Hovering level", f"costs {number(costs[0][1])} W of rotor drag power.")
    shown = [f"{number(power)} W at {degrees(tilt)}" for tilt, power in (costs[0], costs[-1])]
    text = f"costs {' and '.join(dict.fromkeys(shown))} of rotor drag power, in still air."
    least = min(power for _, power in costs)
    if least < 0.99 * min(costs[0][1], costs[-1][1]):
        best = [degrees(tilt) for tilt, power in costs if power <= (1.0 + 1e-9) * least]
        text += f" Near {listed(list(dict.fromkeys(best)))} it is cheapest, {number(least)} W."
    everywhere = len(level) == 1 and np.allclose(level[0], limits, atol=1e-6)
    if not everywhere and len(level):
        text += f" It can do so {intervals_text(level)} only."
    return KeyPoint("Hovering level", text)


def _level_costs(analysis: VehicleAnalysis) -> list[tuple[float, float]]:
    """Return (tilt, power) wherever level hover was asked for within the limits, and possible."""
    low, high = analysis.limits
    asked = dict(
        zip(analysis.sweep.tilt.tolist(), analysis.sweep.level_power.tolist(), strict=True)
    )
    for one in analysis.at:
        tilts = set(one.tilt.tolist()) or {0.0}
        if len(tilts) == 1:
            asked[tilts.pop()] = one.hover.power
    return sorted(
        (tilt, power)
        for tilt, power in asked.items()
        if np.isfinite(power) and low - 1e-9 <= tilt <= high + 1e-9
    )


def _actuation(analysis: VehicleAnalysis) -> KeyPoint:
    one = analysis.asked.actuation
    at = f"at {tilt_text(one.tilt)}: " if analysis.vehicle.n_servos else ""
    text = f"{at}{one.vehicle_class} (rank A = {one.rank_thrust}"
    text += f", rank F = {one.rank_full})." if analysis.vehicle.n_servos else ")."
    if one.rank_thrust < 6:
        text += f" No thrusts make {lost_text(one.lost)}."
    falls = singular_text(analysis)
    text += f" Over a full rotation of the tilt the rank of A falls {falls}." if falls else ""
    return KeyPoint("Actuation" if at else "Actuation:", text)


def _moments(analysis: VehicleAnalysis) -> KeyPoint:
    asked = analysis.asked
    at = f" at {tilt_text(asked.tilt)}" if analysis.vehicle.n_servos else ""
    roll, pitch, yaw = (
        number(min(asked.moment.reach(axis), asked.moment.reach(-axis)), 3) for axis in np.eye(3)
    )
    text = f"while hovering level{at}: {roll} N m about x, {pitch} N m about y, {yaw} N m about z, "
    text += "either way."
    if asked.moment.inscribed_radius > 0.0:
        text += f" About every axis: {number(asked.moment.inscribed_radius, 3)} N m."
    return KeyPoint("Moments", text)


def _in_wakes(wakes: WakeEffect) -> KeyPoint:
    can = np.flatnonzero(np.isfinite(wakes.power))
    ends = dict.fromkeys([int(can[0]), int(can[-1])])
    varied = len(wakes.tilt) > 1
    shown = []
    for k in ends:
        more = 100.0 * (wakes.power[k] / wakes.power_still[k] - 1.0)
        at = f" at {degrees(float(wakes.tilt[k]))}" if varied else ""
        shown.append(f"{number(float(wakes.power[k]))} W{at} (+{number(more, 2)} %)")
    pairs = (
        "1 pair of rotors is"
        if len(wakes.pairs) == 1
        else f"{len(wakes.pairs)} pairs of rotors are"
    )
    text = f"{pairs} in line; in their wakes hovering level takes {' and '.join(shown)}. "
    if wakes.radius_still.max() > 0.0:
        best = int(wakes.radius.argmax())
        text += "The radius at zero moment that is left for certain is "
        text += f"{number(float(wakes.radius[best]))} N"
        text += f" at best, at {degrees(float(wakes.tilt[best]))}" if varied else ""
        text += f" (in still air {number(float(wakes.radius_still.max()))} N)."
    return KeyPoint("Wakes:", text.rstrip())


def _mechanism(analysis: VehicleAnalysis) -> KeyPoint:
    trade = analysis.trade
    head = "The tilt mechanism"
    if trade is None:
        return KeyPoint(head, "is not weighed: untilted, the vehicle cannot hover level.")
    if trade.own is None:
        text = "has a mass that the vehicle file does not state, so whether it pays is left open."
        return KeyPoint(head, text)
    share = f"{number(100.0 * trade.own, 3)} % of the mass of the rest"
    tilts: list[tuple[str, float | None]] = [("in still air", trade.break_even)]
    if analysis.wakes is not None:
        tilts.append(("in the rotors' wakes", trade.break_even_in_wakes))
    pays = [
        f"beyond {degrees(tilt)} {where}" if tilt is not None else f"at no tilt {where}"
        for where, tilt in tilts
    ]
    text = f"({share}) pays against a vehicle whose tilt is fixed {' and '.join(pays)}."
    return KeyPoint(head, text)
