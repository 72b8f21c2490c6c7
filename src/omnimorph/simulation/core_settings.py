"""What the core is given to fly a scenario, alone or in a batch."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from omnimorph import _core
from omnimorph.arrays import as_numbers
from omnimorph.control.controller import controller_fields
from omnimorph.errors import ScenarioError
from omnimorph.model.core import state_row
from omnimorph.model.dynamics import hover_thrust
from omnimorph.protocols import FloatArray, Reference
from omnimorph.reference.rows import ROTATION, are_rotations
from omnimorph.reference.segments import SegmentReference
from omnimorph.simulation.own_parts import FAILURES, PartFailed, in_flight, named
from omnimorph.simulation.plant import control_steps, core_motion
from omnimorph.simulation.scenario import Scenario

MOST_STEPS = 2**31
"""How many physics steps a flight has at most; no flight draws the noise of a later one."""


class CoreSettings(NamedTuple):
    """What the core is given to fly a scenario, and what of it the loop needs to know itself."""

    settings: _core.LoopSettings
    controller: _core.ControllerSettings
    reference: _core.Reference
    start: FloatArray  # (18,)
    thrust: FloatArray
    tilt: FloatArray
    steps: int
    control_every: int
    lost_beyond: float

    def of_flight(self) -> dict[str, Any]:
        """Return the arguments that make a flight of the core, but for its noise."""
        names = ("settings", "reference", "steps", "lost_beyond")
        return {name: getattr(self, name) for name in names}


def core_settings_of(scenario: Scenario) -> CoreSettings:
    """Return what the core needs to fly a scenario.

    Raises
    ------
    ScenarioError
        If the flight has no step or too many, or the reference is not finite.
    """
    steps = physics_steps(scenario)
    start = _start(scenario)
    fields = loop_fields(scenario, start)
    controller = _core.ControllerSettings(fields["controller"])
    return CoreSettings(
        settings=_core.LoopSettings(fields | {"controller": controller}),
        controller=controller,
        reference=_core_reference(scenario, steps),
        start=start,
        **fields["start"]["command"],
        steps=steps,
        control_every=control_steps(scenario.plant),
        lost_beyond=scenario.lost_beyond,
    )


def loop_fields(scenario: Scenario, start: FloatArray) -> dict[str, Any]:
    """Return every field of the core's loop; the scenario starts from the (18,) state `start`."""
    vehicle, plant, tilt = scenario.vehicle, scenario.plant, scenario.tilt
    rule, force = scenario.allocator, scenario.lateral_force
    command = {"thrust": hover_thrust(vehicle, tilt), "tilt": tilt}
    return plant.core_fields(vehicle) | {
        "controller": controller_fields(vehicle, scenario.gains, rule, plant.control_period, force),
        "start": {"motion": core_motion(start), "command": command},
    }


def _start(scenario: Scenario) -> FloatArray:
    """Return the (18,) state from which a scenario starts: at rest, where the reference begins."""
    with _asked(scenario.reference):
        return np.concatenate([_row(scenario.reference, 0.0)[:12], np.zeros(6)])


def physics_steps(scenario: Scenario) -> int:
    """Return how many physics steps a scenario lasts.

    Raises
    ------
    ScenarioError
        If it has no step or too many.
    """
    with _asked(scenario.reference):
        given = scenario.reference.duration
    duration = as_numbers(given)
    steps = float(duration) / scenario.plant.physics_step if duration.ndim == 0 else math.nan
    if not 0.5 < steps <= MOST_STEPS:
        allowed = f"from one physics step to {MOST_STEPS} of them"
        raise ScenarioError.at(scenario.name, "duration", given, allowed)
    return round(steps)


def _core_reference(scenario: Scenario, steps: int) -> _core.Reference:
    """Return the reference as the core flies it: segments as they are, anything else sampled."""
    reference = scenario.reference
    nothing = np.zeros(0)
    if isinstance(reference, SegmentReference):
        return _core.Reference(reference.as_table(), nothing)
    times = np.arange(steps + 1) * scenario.plant.physics_step
    with in_flight({"reference": reference}), _asked(reference):
        sample = getattr(reference, "sample", None)
        if callable(sample):
            rows = as_numbers(sample(times))
        else:
            rows = np.array([_row(reference, t) for t in times.tolist()])
    if rows.shape != (steps + 1, 24):
        allowed = f"({steps + 1}, {24})"
        raise ScenarioError.at("the reference", "shape of its samples", rows.shape, allowed)
    if not np.isfinite(rows).all():
        at = times[np.argmin(np.isfinite(rows).all(axis=1))]
        raise ScenarioError.at(scenario.name, f"reference at {at:g} s", "not finite", "finite")
    turned = are_rotations(rows[:, 3:12].reshape(-1, 3, 3))
    if not turned.all():
        k = int(np.argmin(turned))
        place = f"attitude of the reference at {times[k]:g} s"
        attitude = rows[k, 3:12].reshape(3, 3).tolist()
        raise ScenarioError.at(scenario.name, place, attitude, ROTATION)
    return _core.Reference(nothing, np.ascontiguousarray(rows))


@contextmanager
def _asked(reference: Reference) -> Iterator[None]:
    """Raise in a sentence what a reference of one's own raises."""
    try:
        yield
    except FAILURES as error:
        PartFailed(named("reference", reference), error).refuse()


def _row(reference: Reference, time: float) -> FloatArray:
    """Return the 24 numbers of a point of a reference written in Python."""
    point = reference(time)
    row = state_row(*point) if isinstance(point, tuple) else np.zeros(0)
    if row.shape != (24,):
        allowed = "an omnimorph.Desired: position, attitude and their first two derivatives"
        raise ScenarioError.at("the reference", f"the point at {time:g} s", point, allowed)
    return row
