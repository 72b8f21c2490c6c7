"""The tables of the page, each from what a question found."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from omnimorph.report.analysis_words import condition_words, rows_by_tilt
from omnimorph.report.tables import Table, degrees, number
from omnimorph.results.metrics import MEASURES
from omnimorph.studies.flight_log import Flown
from omnimorph.studies.many_flights import Job
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.ablation import METRICS, Ablation, Lag
from omnimorph.studies.reproduction.degraded import Degraded
from omnimorph.studies.reproduction.design import Design
from omnimorph.studies.reproduction.flights import W3, A, B, PaperFlights
from omnimorph.studies.reproduction.lost_thrust import CASES, NOT_LOST, POSE_KEPT
from omnimorph.studies.reproduction.spread import spread_of
from omnimorph.studies.reproduction.tilt_choice import TiltChoice
from omnimorph.studies.reproduction.verdicts import Judged
from omnimorph.studies.reproduction.words import (
    FLIGHT_WORDS,
    difference_words,
    spread_words,
    with_unit,
)
from omnimorph.units import from_SI

__all__ = [
    "ablation_table",
    "actuation_table",
    "claims_table",
    "dead_rotor_table",
    "energy_table",
    "error_table",
    "example_table",
    "failed_table",
    "frontier_table",
    "gap_table",
    "lag_table",
    "losses_table",
    "tilt_choice_table",
    "variant_table",
    "wake_table",
]

_TURN = 2.0 * math.pi


def claims_table(judged: Sequence[Judged]) -> Table:
    """Return every claim of the paper in a line."""
    rows = []
    for row in judged:
        here, unit = row.here_in_words, row.claim.unit
        found = with_unit(here, unit) if here else row.found
        rows.append(
            [
                row.claim.text,
                row.claim.rule,
                "" if row.claim.value is None else with_unit(number(row.claim.value, 5), unit),
                f"{found}. {row.why}" if row.explained else found,
                difference_words(row.difference) if here else "",
                row.verdict.value,
            ]
        )
    head = ["the paper says", "rule", "its number", "here", "difference", "verdict"]
    return Table(
        "What the paper says, in the order of its sections, beside what comes out here.",
        head,
        rows,
        frozenset({2}),
    )


# --- design ---------------------------------------------------------------------------------------


def actuation_table(design: Design) -> Table:
    """Return ranks, conditions and classes at the tilts that stand out."""
    rows = []
    for one, why in rows_by_tilt(design.analysis):
        found = one.actuation
        conditions = [condition_words(rows) for rows in found.conditions]
        rows.append(
            [
                degrees(float(one.tilt[0])),
                why,
                str(found.rank_thrust),
                str(found.rank_full),
                "" if found.rank_thrust == 6 else "; ".join(conditions),
                f"{found.kind.value}; {found.thrust_kind.value}",
            ]
        )
    head = ["tilt", "why this one", "rank A", "rank F", "where tilting adds one", "class"]
    return Table("Ranks and classes at the tilts that stand out.", head, rows, frozenset({2, 3}))


def example_table(design: Design) -> Table:
    """Return the thrusts that distinguish the paper's conditions from ours."""
    rows = [
        [
            degrees(one.tilt),
            one.thrusts,
            str(one.paper),
            str(one.ours),
            one.condition,
            "agrees" if one.paper == one.ours else "counter-example",
        ]
        for one in design.examples
    ]
    head = ["tilt", "thrusts", "rank F by the paper", "rank F", "it is higher if and only if", ""]
    return Table(
        "Thrusts for which the rank of F decides between the paper's condition and ours.",
        head,
        rows,
        frozenset({2, 3}),
    )


# --- flights --------------------------------------------------------------------------------------


def energy_table(flights: PaperFlights) -> Table:
    """Return both energies of each flight in both counts, below the paper's own."""
    rows = [[f"the paper, {FLIGHT_WORDS[name]}", *_paper_energies(name)] for name in (A, B)]
    for words, name, flown in _both_plants(flights):
        row = [words]
        for metric in ("drag_energy", "acceleration_energy"):
            for count in ("paper", "J"):
                row.append(spread_words(spread_of(flown, f"{metric}_{count}")))
            perfect = spread_of([flights.perfect[name]], f"{metric}_paper")
            row.append(number(perfect.mean))
        rows.append(row)
    head = ["", "rotor drag (“J”)", "rotor drag (J)", "perfect plant (“J”)"]
    head += ["acceleration (“J”)", "acceleration (J)", "perfect plant (“J”)"]
    caption = (
        "Rotor drag energy, and energy to accelerate the rotors: in the paper's count (“J”) and in "
        "joules."
    )
    return Table(caption, head, rows, frozenset(range(1, 7)))


def _paper_energies(scenario: str) -> list[str]:
    """Return the paper's own cells of the table of energies: it left the speeds in hertz."""
    cells = []
    for kind, factor in (("drag", _TURN), ("acceleration", _TURN**2)):
        value = paper.claims()[f"{kind}_energy_{'a' if scenario == A else 'b'}"].value
        assert value is not None
        cells += [number(value, 5), number(factor * value), "—"]
    return cells


def error_table(flights: PaperFlights) -> Table:
    """Return mean and root-mean-square errors of each flight beside the paper's."""
    shown = {
        "position_error_mean_m": ("position error, mean (mm)", 1e3),
        "position_error_rms_m": ("position error, RMS (mm)", 1e3),
        "attitude_error_paper": ("‖e_R‖, mean (10⁻³)", 1e3),
        "attitude_error_rms_rad": ("attitude error, RMS (°)", math.degrees(1.0)),
    }
    rows = []
    for words, _, flown in _both_plants(flights):
        row = [words]
        for metric, (_, factor) in shown.items():
            row.append(spread_words(spread_of(flown, metric), factor))
        rows.append(row)
    head = ["", *(words for words, _ in shown.values())]
    caption = (
        "Means and root mean squares (RMS) over the whole flight, every physics step counted alike."
    )
    return Table(caption, head, rows, frozenset(range(1, 5)))


def _both_plants(flights: PaperFlights) -> Iterator[tuple[str, str, list[Flown]]]:
    """Return words, scenario and flights: each in the realistic plant, then without momentum."""
    for name, words in FLIGHT_WORDS.items():
        yield words, name, flights.realistic[name]
        yield f"{words}, no rotor momentum", name, flights.without_momentum[name]


def variant_table(flights: PaperFlights) -> Table:
    """Return the energies in plants that ought to agree."""
    rows = []
    for variant in flights.variants:
        metrics, b = variant.run.metrics, spread_of([variant.b], "drag_energy_paper")
        words = f"step {1e3 * variant.step:g} ms" + (", tiny noise" if variant.noise else "")
        numbers = (metrics.drag_energy_paper, metrics.tilt_mean_deg, b.mean)
        rows.append([words, *(number(value) for value in numbers)])
    head = ["perfect plant", "Case A (“J”)", "its tilt, mean (°)", "Case B (“J”)"]
    caption = "Rotor drag energy in plants that ought to agree."
    return Table(caption, head, rows, frozenset({1, 2, 3}))


def wake_table(flights: PaperFlights) -> Table:
    """Return what interference does to each flight."""
    shown = ("drag_energy_paper", "tilt_mean_deg", "position_error_mean_m", "attitude_error_paper")
    rows = []
    for name, words in FLIGHT_WORDS.items():
        row = [words]
        for metric in shown:
            still, wakes = (
                spread_of(flown[name], metric, MEASURES[metric].factor).mean
                for flown in (flights.realistic, flights.in_wakes)
            )
            row.append(f"{number(still, 3)} → {number(wakes, 3)}")
        rows.append(row)
    head = [
        "",
        "rotor drag energy (“J”)",
        "tilt, mean (°)",
        "position error, mean (mm)",
        "‖e_R‖, mean",
    ]
    caption = "In still air → in the wakes, means over the seeds."
    return Table(caption, head, rows, frozenset({1, 2, 3, 4}))


# --- why ------------------------------------------------------------------------------------------


def ablation_table(ablation: Ablation) -> Table:
    """Return every condition with its means over the seeds, Case A before Case B."""
    rows = []
    for condition in ablation.conditions:
        row = [f"{condition.group}: {condition.label}"]
        for metric in METRICS:
            factor = MEASURES[metric].factor
            means = (condition.spread(name, metric).mean for name in CASES)
            row.append(" / ".join(number(factor * mean, 3) for mean in means))
        rows.append(row)
    head = ["", "tilt, mean (°)", "rotor drag energy (“J”)", "energy to accelerate (“J”)"]
    head += ["position error, mean (mm)", "position error, RMS (mm)", "‖e_R‖, mean"]
    caption = "Case A / Case B, means over the seeds."
    return Table(caption, head, rows, frozenset(range(1, 7)))


def lag_table(lag: Lag, flights: PaperFlights) -> Table:
    """Return what a reference without feed-forward gives: closed form, flown, and the paper."""
    errors = (
        ("‖e_R‖", "attitude_error", "attitude_error_paper", lag.attitude_error),
        ("position (mm)", "position_error", "position_error_mean_m", 1e3 * lag.position_error),
    )
    rows = []
    for words, key, metric, closed in errors:
        for name, case in ((A, "a"), (B, "b"), (W3, "w3")):
            factor = MEASURES[metric].factor
            as_stated, without = (
                spread_of(flown[name], metric, factor)
                for flown in (flights.without_momentum, flights.pose_only)
            )
            claimed = paper.claims()[f"{key}_{case}"].value
            assert claimed is not None
            rows.append(
                [
                    f"{words}, {FLIGHT_WORDS[name]}",
                    number(claimed),
                    number(as_stated.mean, 3),
                    spread_words(without),
                    number(closed, 3),
                    difference_words(without.mean / claimed - 1.0),
                ]
            )
    head = ["mean error", "the paper", "as stated", "no feed-forward", "closed form", "difference"]
    caption = "A reference without velocity and acceleration feed-forward, no rotor momentum."
    return Table(caption, head, rows, frozenset(range(1, 6)))


# --- less thrust ----------------------------------------------------------------------------------


def losses_table(degraded: Degraded) -> Table:
    """Return the paper's losses of thrust, at both limits of speed."""
    rows = [
        [
            f"{FLIGHT_WORDS[one.scenario]}, {100 * one.loss:g} % less",
            f"±{from_SI(one.speed_limit, 'Hz'):.0f}",
            "{} of {}".format(*one.share(NOT_LOST)),
            "{} of {}".format(*one.share(POSE_KEPT)),
            spread_words(spread_of(one.flown, "position_error_mean_m", 1e3)),
            spread_words(spread_of(one.flown, "attitude_error_paper")),
        ]
        for one in degraded.losses
    ]
    head = ["", "speed limit (Hz)", "not lost", "pose kept"]
    head += ["position error, mean (mm)", "‖e_R‖, mean"]
    caption = "The paper's three flights with less thrust; errors of those that were not lost."
    return Table(caption, head, rows, frozenset(range(1, 6)))


def frontier_table(degraded: Degraded) -> Table:
    """Return how much thrust each case may lose, beside the physical limit."""
    rows = [
        [
            f"{FLIGHT_WORDS[one.scenario]}, {one.kind}",
            one.criterion,
            f"±{from_SI(one.speed_limit, 'Hz'):.0f}",
            f"{100 * one.bracket[0]:.1f} to {100 * one.bracket[1]:.1f}",
            f"{100 * one.physical_limit:.1f}",
        ]
        for one in degraded.frontiers
    ]
    head = ["", "criterion", "speed limit (Hz)", "largest loss (%)", "physical limit (%)"]
    caption = "The largest loss that half of the flights survive: between these two."
    return Table(caption, head, rows, frozenset({2, 3, 4}))


def dead_rotor_table(degraded: Degraded) -> Table:
    """Return how many flights get by with one rotor dead."""
    rotors = range(len(next(iter(degraded.dead.values()))))
    rows = [
        [f"{FLIGHT_WORDS[name]}, {criterion}", *("{} of {}".format(*share) for share in shares)]
        for (name, criterion), shares in degraded.dead.items()
    ]
    head = ["", *(f"rotor {k}" for k in rotors)]
    caption = "One rotor gives no thrust at all."
    return Table(caption, head, rows, frozenset(k + 1 for k in rotors))


# --- choosing the tilt ----------------------------------------------------------------------------


def tilt_choice_table(found: TiltChoice) -> Table:
    """Return energy, tilt and error of each method to choose the tilt, above the lower bound."""
    rows = []
    for choice in found.choices:
        row = [choice.label]
        for name in CASES:
            row += [
                spread_words(spread_of(choice.flown[name], "drag_energy_paper")),
                f"{100 * found.excess(choice, name):+.1f} %".replace("-", "−"),
                spread_words(spread_of(choice.flown[name], "tilt_mean_deg")),
                spread_words(spread_of(choice.flown[name], "position_error_mean_m", 1e3)),
            ]
        rows.append(row)
    bound = found.lower_bound
    energy, tilt = number(bound.energy_paper), number(math.degrees(bound.tilt.mean()), 3)
    rows.append(["lower bound", *(2 * [energy, "", tilt, ""])])
    head = [""]
    for name in CASES:
        case = FLIGHT_WORDS[name]
        head += [f"{case}, energy (“J”)", "relative to the lower bound", "tilt, mean (°)"]
        head += ["position error, mean (mm)"]
    caption = "Rotor drag energy, tilt and position error by how the tilt is chosen."
    return Table(caption, head, rows, frozenset(range(1, 9)))


def gap_table(found: TiltChoice) -> Table:
    """Return how much more than the best the paper's choice costs, over its control steps."""
    rows = [
        [
            f"{FLIGHT_WORDS[one.scenario]}, {one.span}",
            _excess(float(np.median(one.gap))),
            f"{100.0 * float((one.gap > 0.01).mean()):.1f}",
        ]
        for one in found.gaps
    ]
    head = ["beside", "median of its excess cost (%)", "steps that cost over 1 % more (%)"]
    caption = "The cost of the three candidates' choice, relative to the best of a search."
    return Table(caption, head, rows, frozenset({1, 2}))


def _excess(share: float) -> str:
    return "identical to rounding" if abs(share) < 1e-12 else number(100.0 * share, 2)


# --- all flights ----------------------------------------------------------------------------------


def failed_table(groups: Mapping[str, Sequence[tuple[Job, Flown]]]) -> Table:
    """Return the flights that were not completed, a row for each end that they came to.

    Parameters
    ----------
    groups : mapping of words to (Job, Flown) pairs
        All flights, by what they were flown for.
    """
    rows = []
    for words, flights in groups.items():
        ended: dict[tuple[str, str], list[Flown]] = {}
        for job, flown in flights:
            if not flown.completed:
                ended.setdefault((job.scenario.name, flown.failure or flown.outcome), []).append(
                    flown
                )
        for (scenario, how), some in ended.items():
            among = sum(job.scenario.name == scenario for job, _ in flights)
            times = [one.metrics.duration_s for one in some if one.metrics is not None]
            after = f"{min(times):.1f} … {max(times):.1f}" if times else "—"
            rows.append([words, scenario, how, f"{len(some)} of {among}", after])
    head = ["flown for", "flight", "how it ended", "how many", "after (s)"]
    return Table("What they were flown for, and how they ended.", head, rows, frozenset({3, 4}))
