"""The figures of the questions behind the flights, drawn from what was found."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimorph.report import style
from omnimorph.report.style import Flight, Look
from omnimorph.results.measures import MEASURES
from omnimorph.studies.flight_log import Flown
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.ablation import Ablation, Condition
from omnimorph.studies.reproduction.degraded import Degraded
from omnimorph.studies.reproduction.figures.ablation import AblationPanel, AblationRow, ablation
from omnimorph.studies.reproduction.figures.frontier import (
    FrontierPanel,
    PhysicalLimit,
    Survival,
    frontier,
)
from omnimorph.studies.reproduction.figures.line_styles import DASHED, LOOKS, ORDER
from omnimorph.studies.reproduction.figures.stand import Level, StandSpeeds, StandTest, stand
from omnimorph.studies.reproduction.figures.tilt_choice import (
    ChoiceEnergy,
    CostGap,
    cost_gaps,
    energy_by_choice,
    tilt_by_choice,
)
from omnimorph.studies.reproduction.flights import (
    A,
    B,
)
from omnimorph.studies.reproduction.frontier import Frontier
from omnimorph.studies.reproduction.interference import Experiment
from omnimorph.studies.reproduction.lost_thrust import CASES, KINDS, NOT_LOST, POSE_KEPT, Share
from omnimorph.studies.reproduction.spread import share_interval
from omnimorph.studies.reproduction.tilt_choice import TiltChoice
from omnimorph.studies.reproduction.wording import FLIGHT_LABELS
from omnimorph.units import from_SI

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "draw_ablation",
    "draw_energies",
    "draw_frontier",
    "draw_gaps",
    "draw_stand",
    "draw_tilt_choice",
]


def draw_ablation(found: Ablation) -> Figure:
    """Draw tilt, energy and errors of both cases, a row a condition."""
    reported = {
        metric: {
            FLIGHT_LABELS[claim.about["scenario"]]: claim.value
            for claim in paper.claims().values()
            if claim.about.get("metric") == metric
            and claim.about["scenario"] in CASES
            and claim.value is not None
        }
        for metric in ("drag_energy_paper", "position_error_mean_m", "attitude_error_paper")
    }
    panels = [
        AblationPanel("tilt_mean_deg", "tilt,\nmean (°)"),
        AblationPanel(
            "drag_energy_paper", "drag energy\n(“J”)", paper=reported["drag_energy_paper"]
        ),
        AblationPanel(
            "position_error_mean_m",
            "position error,\nmean (mm)",
            logarithmic=True,
            paper=reported["position_error_mean_m"],
        ),
        AblationPanel(
            "attitude_error_paper",
            "‖e_R‖,\nmean (–)",
            logarithmic=True,
            paper=reported["attitude_error_paper"],
        ),
    ]
    rows = [
        AblationRow(one.label, one.group, {panel.measure: _by_case(one, panel) for panel in panels})
        for one in found.conditions
    ]
    looks = {
        FLIGHT_LABELS[A]: Look(style.VERMILLION),
        FLIGHT_LABELS[B]: Look(style.BLUE, DASHED, "s"),
    }
    return ablation(rows, panels, looks)


def _by_case(condition: Condition, panel: AblationPanel) -> dict[str, list[float]]:
    factor = MEASURES[panel.measure].factor
    return {
        FLIGHT_LABELS[name]: [factor * _value(one, panel.measure) for one in condition.flown[name]]
        for name in CASES
    }


def _value(flown: Flown, metric: str) -> float:
    return float(getattr(flown.metrics, metric)) if flown.completed else math.nan


def draw_stand(experiment: Experiment) -> Figure:
    """Draw speeds and forces of the experiment beside what the paper reports."""
    first = experiment.tests[0].together
    turning = first.time >= 0.5  # s: the rotors start from rest
    others = np.delete(first.speed, experiment.rotor, axis=1)
    speeds = StandSpeeds(
        time=first.time, measured=first.speed[:, experiment.rotor], others=others.max(axis=1)
    )
    alone, together, loss = (
        paper.claims()[key].value for key in ("force_alone", "force_together", "loss_at_50")
    )
    assert alone is not None
    assert together is not None
    assert loss is not None
    left = alone * (1.0 - loss / 100.0)
    levels = (
        [Level(alone, f"the paper: {alone:g} N"), Level(together, f"the paper: {together:g} N")],
        [Level(alone, f"the paper: {alone:g} N"), Level(left, f"the paper: {loss:g} % less")],
    )
    tests = [
        StandTest(
            tilt=test.tilt,
            time=test.together.time[turning],
            alone=test.alone.thrust[turning],
            together=test.together.thrust[turning],
            levels=level,
        )
        for test, level in zip(experiment.tests, levels, strict=True)
    ]
    return stand(speeds, tests)


def draw_frontier(degraded: Degraded) -> Figure:
    """Draw the shares that survive over the loss, a panel a kind of loss and a criterion."""
    panels = []
    for kind in KINDS:
        for criterion in (NOT_LOST, POSE_KEPT):
            found = [
                one for one in degraded.frontiers if (one.kind, one.criterion) == (kind, criterion)
            ]
            limits = {one.speed_limit: one.physical_limit for one in found}
            panels.append(
                FrontierPanel(
                    title=f"{kind}: {criterion}",
                    curves=[_survival(one) for one in found],
                    limits=[
                        PhysicalLimit(loss, f"±{from_SI(speed, 'Hz'):.0f} Hz")
                        for speed, loss in limits.items()
                    ],
                )
            )
    dead = [
        _shares(
            f"{FLIGHT_LABELS[name]}, {criterion}",
            Look(LOOKS[name].colour, mark="o" if criterion == NOT_LOST else "D"),
            np.arange(float(len(shares))),
            shares,
        )
        for (name, criterion), shares in degraded.dead.items()
    ]
    return frontier(panels, dead)


def _survival(one: Frontier) -> Survival:
    losses = sorted(one.survived)
    speed = from_SI(one.speed_limit, "Hz")
    colour = LOOKS[one.scenario].colour
    look = Look(colour, "-" if speed < 200.0 else DASHED)
    words = f"{FLIGHT_LABELS[one.scenario]}, ±{speed:.0f} Hz"
    return _shares(words, look, np.array(losses), [one.survived[loss] for loss in losses])


def _shares(words: str, look: Look, over: np.ndarray, shares: list[Share]) -> Survival:
    ends = np.array([share_interval(*share) for share in shares])
    return Survival(
        label=words,
        look=look,
        over=over,
        share=np.array([share.met / share.flown for share in shares]),
        low=ends[:, 0],
        high=ends[:, 1],
    )


def draw_tilt_choice(found: TiltChoice) -> Figure:
    """Draw the tilt by how it is chosen, beside the lower bound's."""
    cases = {}
    for name in CASES:
        shown = [
            Flight(choice.label, choice.runs[name], look)
            for choice, look in zip(found.choices, ORDER[1:], strict=False)
        ]
        best = np.interp(shown[0].run.time, found.lower_bound.time, found.lower_bound.tilt)
        bound = replace(shown[0].run, tilt_actual=best[:, None])
        cases[FLIGHT_LABELS[name]] = [*shown, Flight("lower bound", bound, ORDER[0])]
    return tilt_by_choice(cases)


def draw_energies(found: TiltChoice) -> Figure:
    """Draw what each way to choose the tilt spends, beside the least possible."""
    names = {FLIGHT_LABELS[name]: name for name in CASES}
    rows = [
        ChoiceEnergy(
            choice.label,
            {
                case: [
                    one.metrics.drag_energy_paper
                    for one in choice.flown[name]
                    if one.metrics is not None and one.completed
                ]
                for case, name in names.items()
            },
        )
        for choice in found.choices
    ]
    least = dict.fromkeys(names, found.lower_bound.energy_paper)
    looks = {
        case: Look(LOOKS[name].colour, mark=mark)
        for (case, name), mark in zip(names.items(), "os", strict=True)
    }
    return energy_by_choice(rows, least, looks)


def draw_gaps(found: TiltChoice) -> Figure:
    """Draw how many control steps cost more than the best, by how much."""
    looks = [Look(LOOKS[name].colour, line) for name in CASES for line in ("-", DASHED)]
    return cost_gaps(
        [
            CostGap(f"{FLIGHT_LABELS[one.scenario]}: to {one.span}", look, one.gap)
            for one, look in zip(found.gaps, looks, strict=True)
        ]
    )
