"""Whether a flight that was completed ended where its reference did."""

from __future__ import annotations

import math
from typing import Any

from omnimorph.errors import legible
from omnimorph.results.metrics import Metrics
from omnimorph.results.record import Outcome, RunRecord
from omnimorph.results.sums import LAST_SECOND

FAR_ATTITUDE = math.radians(30.0)
"""An attitude that is off by this much over the last second, rad, was not followed."""


def sentence_of(run: RunRecord, metrics: Metrics) -> str:
    """Return how a flight of these metrics ended, in a sentence.

    One that was completed, but was far from its reference over the last second, says so: by 30° in
    attitude, unless its controller lets the attitude give way or is one of the user's own, or by
    the scenario's ``lost_beyond_m`` in position. One that a part written in Python ended says when
    that was, which part, and how it failed.
    """
    said: str = run.outcome.value
    if run.outcome is Outcome.PART_FAILED:
        return _failure(run.provenance.scenario) or said
    if run.outcome is not Outcome.COMPLETED:
        return said
    far = _far_from_reference(metrics, run.provenance.scenario)
    over = "over the last second" if run.time[-1] >= LAST_SECOND else "throughout the flight"
    return f"{said[:-1]}, but {' and '.join(far)} {over}." if far else said


def _failure(scenario: dict[str, Any]) -> str:
    """Return what the last failure among the events was; "" if none is recorded as it should be."""
    for event in reversed(_events(scenario)):
        part, error, time = (event.get(key) for key in ("part", "error", "time_s"))
        is_time = isinstance(time, int | float) and not isinstance(time, bool) and 0 <= time < 1e9
        if event.get("kind") != "failure" or not is_time:
            continue
        if isinstance(part, str) and isinstance(error, str):
            what = legible(f"{part} failed with {error}".rstrip("."), 500)
            return f"The flight was ended at {time:.6g} s: {what}."
    return ""


def _events(scenario: dict[str, Any]) -> list[dict[str, Any]]:
    events = scenario.get("events")
    return [e for e in events if isinstance(e, dict)] if isinstance(events, list) else []


def _far_from_reference(metrics: Metrics, scenario: dict[str, Any]) -> list[str]:
    """Return what was not followed; the scenario is text of a file, and may hold anything."""
    lost_beyond = scenario.get("lost_beyond_m")
    attitude = metrics.attitude_error_last_second_rad
    position = metrics.position_error_last_second_m
    far = []
    if attitude >= FAR_ATTITUDE and not _gives_way(scenario):
        degrees = math.degrees(attitude)
        far.append(f"the attitude was not followed: it was {degrees:.0f}° from the reference")
    if isinstance(lost_beyond, int | float) and position >= lost_beyond:
        far.append(f"the position was not followed: it was {position:.3g} m from the reference")
    return far


def _gives_way(scenario: dict[str, Any]) -> bool:
    """Return whether the attitude may give way in the controller that was the last to fly."""
    first = scenario.get("controller")
    tables = [first, *_events(scenario)] if isinstance(first, dict) else _events(scenario)
    if tables and tables[0].get("kind") == "python":  # it may do anything
        return True
    answers = [table["attitude_gives_way"] for table in tables if "attitude_gives_way" in table]
    return bool(answers) and answers[-1] is True
