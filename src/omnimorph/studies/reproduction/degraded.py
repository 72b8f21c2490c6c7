"""The paper's flights with less thrust than the controller believes in, and how far it goes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import load_scenario
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.flights import A
from omnimorph.studies.reproduction.frontier import (
    Frontier,
    PhysicalLimits,
    count_frontiers,
    fly_dead_rotors,
    search_frontiers,
)
from omnimorph.studies.reproduction.lost_thrust import (
    NOT_LOST,
    POSE_KEPT,
    Share,
    count_met,
    degrade,
    speed_limits,
    with_speed_limit,
)
from omnimorph.studies.reproduction.plan import FlyJobs, Plan, fly_over_seeds
from omnimorph.studies.reproduction.spread import share_interval, spread_of
from omnimorph.studies.reproduction.verdicts import Basis, Judged, Verdict, judge, survival_holds
from omnimorph.units import from_SI


@dataclass(frozen=True, kw_only=True, eq=False)
class PaperLoss:
    """One of the losses the paper flies."""

    key: str  # of the claim about it
    scenario: str
    loss: float  # share of the thrust
    speed_limit: float  # rad/s
    flown: list[FlightResult]  # one for each seed

    def share(self, criterion: str) -> Share:
        """Return how many flights met a criterion, of how many."""
        return count_met(self.flown, criterion)


@dataclass(frozen=True, kw_only=True, eq=False)
class Degraded:
    """What came of all flights with less thrust.

    `dead` has, by scenario and criterion, a share for each rotor that gives no thrust at all.
    """

    losses: list[PaperLoss]
    frontiers: list[Frontier]
    dead: Mapping[tuple[str, str], list[Share]]
    judged: list[Judged]

    def as_dict(self) -> dict[str, Any]:
        """Return what ``results.json`` holds of it."""
        return {
            "losses": [
                {
                    "scenario": one.scenario,
                    "loss": one.loss,
                    "speed_limit_Hz": from_SI(one.speed_limit, "Hz"),
                    "not_lost": list(one.share(NOT_LOST)),
                    "pose_kept": list(one.share(POSE_KEPT)),
                    "position_error_mean_m": spread_of(
                        one.flown, "position_error_mean_m"
                    )._asdict(),
                    "attitude_error_paper": spread_of(one.flown, "attitude_error_paper")._asdict(),
                }
                for one in self.losses
            ],
            "frontiers": [
                {
                    "scenario": one.scenario,
                    "kind": one.kind,
                    "criterion": one.criterion,
                    "speed_limit_Hz": from_SI(one.speed_limit, "Hz"),
                    "survived": [[loss, *one.survived[loss]] for loss in sorted(one.survived)],
                    "bracket": list(one.bracket),
                    "physical_limit": one.physical_limit,
                }
                for one in self.frontiers
            ],
            "dead_rotor": [
                {"scenario": name, "criterion": criterion, "shares": [list(row) for row in rows]}
                for (name, criterion), rows in self.dead.items()
            ],
        }


def count_degraded(plan: Plan) -> int:
    """Return how many flights `fly_degraded` hands out."""
    limits = len(speed_limits(load_scenario(A).vehicle))
    return limits * len(_PAPER_KEYS) * len(plan.seeds) + count_frontiers(plan)


def fly_degraded(plan: Plan, fly_jobs: FlyJobs, physical: PhysicalLimits) -> Degraded:
    """Fly the paper's losses, search the largest that each case survives, stop single rotors."""
    losses = fly_paper_losses(plan, fly_jobs)
    return Degraded(
        losses=losses,
        frontiers=search_frontiers(plan, fly_jobs, physical),
        dead=fly_dead_rotors(plan, fly_jobs),
        judged=_judge(losses),
    )


# --- the paper's losses ---------------------------------------------------------------------------

_PAPER_KEYS = ("a_survives", "b_fails", "b_survives")


def paper_loss(key: str, speed_limit: float | None = None) -> Scenario:
    """Return what the paper flew for a claim, at the vehicle's limit of speed or another, rad/s."""
    about = paper.claims()[key].about
    scenario = load_scenario(about["scenario"])
    limit = speed_limits(scenario.vehicle)[0] if speed_limit is None else speed_limit
    return degrade(with_speed_limit(scenario, limit), about["loss_percent"] / 100.0)


def fly_paper_losses(plan: Plan, fly_jobs: FlyJobs) -> list[PaperLoss]:
    """Fly what the paper flew with less thrust, at both limits of speed, over the seeds."""
    limits = speed_limits(load_scenario(A).vehicle)
    weakened = {(key, limit): paper_loss(key, limit) for key in _PAPER_KEYS for limit in limits}
    flown = fly_over_seeds(weakened, plan.seeds, fly_jobs, "the paper's losses of thrust")
    return [
        PaperLoss(
            key=key,
            scenario=paper.claims()[key].about["scenario"],
            loss=paper.claims()[key].about["loss_percent"] / 100.0,
            speed_limit=limit,
            flown=results,
        )
        for (key, limit), results in flown.items()
    ]


def _judge(losses: list[PaperLoss]) -> list[Judged]:
    return [*(_judge_loss(key, losses) for key in _PAPER_KEYS), _judge_most_affected(losses)]


def _judge_loss(key: str, losses: list[PaperLoss]) -> Judged:
    """Judge whether a case survives; the paper's limit of thrust is not known, so two are flown."""
    rows = sorted((one for one in losses if one.key == key), key=lambda one: one.speed_limit)
    limits = [f"±{from_SI(one.speed_limit, 'Hz'):.0f} Hz" for one in rows]
    answers = [_holds(one, fails=key == "b_fails") for one in rows]
    holds = answers[0] if len(set(answers)) == 1 else None
    explained = None
    if holds is not None:
        why = f"It {'holds' if holds else 'does not hold'} at either limit of the rotors' speed."
    elif True in answers:
        explained = Verdict.CONJECTURED
        where = limits[answers.index(True)]
        why = f"It holds if the rotors may turn at {where}; the paper does not say."
    else:
        where = " and ".join(limits[i] for i, one in enumerate(answers) if one is None)
        why = (
            f"At {where} it depends on what counts, or chance decides: the shares of flights that "
            "are not lost and of those that keep the pose do not both settle it."
        )
    return judge(
        key,
        holds=holds,
        basis=Basis.FLOWN,
        found="; ".join(_shares_text(one) for one in rows),
        why=why,
        command="omnimorph reproduce",
        explained=explained,
    )


def _holds(one: PaperLoss, *, fails: bool) -> bool | None:
    """Return whether most flights survive, or fail, whichever of the two criteria counts."""
    intervals = [share_interval(*one.share(criterion)) for criterion in (NOT_LOST, POSE_KEPT)]
    return survival_holds(intervals, fails=fails)


def _shares_text(one: PaperLoss) -> str:
    not_lost, kept = (one.share(criterion).met for criterion in (NOT_LOST, POSE_KEPT))
    limit = from_SI(one.speed_limit, "Hz")
    return f"at ±{limit:.0f} Hz {not_lost} of {len(one.flown)} are not lost, {kept} keep the pose"


def _judge_most_affected(losses: list[PaperLoss]) -> Judged:
    """Judge both errors where the vehicle survives."""
    held = [one for one in losses if one.share(NOT_LOST).at_least_half]
    position, attitude = (
        float(np.mean([spread_of(one.flown, metric).mean for one in held])) if held else np.nan
        for metric in ("position_error_mean_m", "attitude_error_paper")
    )
    found = f"where it survives, {1e3 * position:.1f} mm and ‖e_R‖ {attitude:.3f} on average"
    return judge(
        "position_most_affected",
        basis=Basis.ASSUMED,
        found=found,
        why="Lengths and angles have no common measure; against the paper's own errors it would "
        "depend on what made those.",
        command="omnimorph reproduce",
    )
