"""Whether a flight that was completed ended where its reference did."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

from omnimorph.results.metrics import Metrics

if TYPE_CHECKING:
    from omnimorph.results.run import Run

__all__ = ["FAR_ATTITUDE", "sentence_of"]

FAR_ATTITUDE = math.radians(30.0)
"""An attitude that is off by this much over the last second, rad, was not followed."""


def sentence_of(run: Run) -> str:
    """Return how a flight ended, in a sentence.

    One that was completed, but was far from its reference over the last second, says so: by 30° in
    attitude, unless its controller lets the attitude give way, or by the scenario's
    ``lost_beyond_m`` in position.
    """
    from omnimorph.results.run import Outcome

    said: str = run.outcome.value
    if run.outcome is not Outcome.COMPLETED:
        return said
    far = _far_from_reference(run.metrics, _scenario_of(run))
    return f"{said[:-1]}, but {' and '.join(far)} over the last second." if far else said


def _far_from_reference(metrics: Metrics, scenario: dict[str, Any]) -> list[str]:
    gives_way = scenario.get("controller", {}).get("attitude_gives_way", False)
    attitude = metrics.attitude_error_last_second_rad
    position = metrics.position_error_last_second_m
    far = []
    if attitude >= FAR_ATTITUDE and not gives_way:
        degrees = math.degrees(attitude)
        far.append(f"the attitude was not followed: it was {degrees:.0f}° from the reference")
    if position >= scenario.get("lost_beyond_m", math.inf):
        far.append(f"the position was not followed: it was {position:.3g} m from the reference")
    return far


def _scenario_of(run: Run) -> dict[str, Any]:
    """Return the scenario that a run tells of; nothing, if it tells none."""
    try:
        scenario = json.loads(run.provenance.scenario_text)
    except json.JSONDecodeError:
        return {}
    return scenario if isinstance(scenario, dict) else {}
