"""What a reproduction could have found: made up, every number another, so that none is mistaken."""

from __future__ import annotations

import html
import math
import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
from tests.unit.conftest import build_random_run

import omnimorph as om
from omnimorph.protocols import FloatArray
from omnimorph.report.page import Picture
from omnimorph.report.tables import Table
from omnimorph.results.metrics import MEASURES
from omnimorph.simulation.thrust_stand import StandReading
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.ablation import LESS, MORE, PERFECT, Ablation, Condition, Lag
from omnimorph.studies.reproduction.degraded import Degraded, PaperLoss
from omnimorph.studies.reproduction.flights import PaperFlights, Variant
from omnimorph.studies.reproduction.frontier import Frontier
from omnimorph.studies.reproduction.hypotheses import (
    MOMENTUM_AND_WAKES,
    WITH_MOMENTUM,
    Hypothesis,
)
from omnimorph.studies.reproduction.interference import Experiment, StandTest
from omnimorph.studies.reproduction.lost_thrust import KINDS, NOT_LOST, POSE_KEPT, Share
from omnimorph.studies.reproduction.page import page_text
from omnimorph.studies.reproduction.plan import Plan
from omnimorph.studies.reproduction.rendering import as_table, templates
from omnimorph.studies.reproduction.results import Results
from omnimorph.studies.reproduction.spread import spread_of
from omnimorph.studies.reproduction.tilt_choice import Choice, Gap, LowerBound, TiltChoice
from omnimorph.studies.reproduction.verdicts import Verdict
from omnimorph.studies.reproduction.wording import FLIGHT_LABELS, spread_text

NAMES = A, B, W3, FIXED_A, FIXED_B = tuple(FLIGHT_LABELS)
TURN = 2.0 * math.pi
LIMITS = (170.0 * TURN, 220.0 * TURN)
WORDS = {
    A: "Case A",
    B: "Case B",
    W3: "Case B, W3 × 10",
    FIXED_A: "fixed 45°, A's weights",
    FIXED_B: "fixed 45°, B's weights",
}
CLAIMS = paper.claims()
# The unit in which each metric is read, as a factor on that in which it is kept.
SHOWN = {
    "tilt_mean_deg": 1.0,
    "drag_energy_paper": 1.0,
    "acceleration_energy_paper": 1.0,
    "position_error_mean_m": 1e3,
    "position_error_rms_m": 1e3,
    "attitude_error_paper": 1.0,
}
_RUN = om.fly(om.load_scenario("hover"))
_DRAWN = np.random.default_rng(11)
# Where the metrics of flights lie, about as those of the paper's flights do.
_TYPICAL = {
    "position_error_mean_m": 0.011,
    "position_error_max_m": 0.09,
    "attitude_error_paper": 0.05,
    "attitude_error_max_rad": 0.15,
    "drag_energy_paper": 1500.0,
}


def flown(outcome: str = "completed", **metrics: Any) -> FlightResult:
    """Make up a flight, all of whose metrics differ from those of any other."""
    drawn = {
        key: _TYPICAL.get(key, 5.0) * float(_DRAWN.uniform(0.7, 1.3))
        for key in MEASURES
        if key != "unproven_steps"
    }
    values: dict[str, Any] = drawn | {"outcome": outcome} | metrics
    return FlightResult(replace(_RUN.metrics, **values))


def some(**metrics: Any) -> list[FlightResult]:
    """Make up three flights that were completed and one that was lost."""
    return [*(flown(**metrics) for _ in range(3)), flown("lost", **metrics)]


def values_of(flights: Sequence[FlightResult], metric: str) -> FloatArray:
    """Return a metric of the flights that were completed."""
    return np.array([getattr(one.metrics, metric) for one in flights if one.completed])


def mean(flights: Sequence[FlightResult], metric: str) -> float:
    return SHOWN.get(metric, 1.0) * float(values_of(flights, metric).mean())


def kept(flights: list[FlightResult], criterion: str) -> int:
    """Count flights by the words of the criterion: never farther off than 0.1 m and 10°."""
    done = [one.metrics for one in flights if one.completed and one.metrics is not None]
    near = [
        one.position_error_max_m <= 0.1 and one.attitude_error_max_rad <= math.radians(10.0)
        for one in done
    ]
    return len(done) if criterion == NOT_LOST else sum(near)


def bound_J() -> float:
    bound = made_up_results().tilt_choice.lower_bound
    return float(np.mean(bound.power)) * float(bound.time[-1] - bound.time[0])


def above_the_bound(flights: list[FlightResult]) -> float:
    return mean(flights, "drag_energy_paper") / (bound_J() / TURN) - 1.0


def shown(flights: list[FlightResult], metric: str, factor: float = 1.0) -> str:
    return spread_text(spread_of(flights, metric, factor))


def assert_rows(table: Table, expected: list[list[str]], *head: str) -> None:
    """Hold that a table has this head and these rows, and that its numbers are set to the right."""
    assert tuple(table.head) == head
    assert [list(row) for row in table.rows] == expected
    assert {len(row) for row in table.rows} == {len(table.head)}
    assert all(0 < column < len(table.head) for column in table.numeric)
    assert table.caption.endswith(".")


def table_text(name: str, *found: Any) -> str:
    """Return a table of the page in Markdown, from what was found."""
    return str(getattr(templates().get_template("tables.md.j2").module, name)(*found))


def table(name: str, *found: Any) -> Table:
    """Return a table of the page, from what was found."""
    return as_table(table_text(name, *found))


@cache
def made_up_page() -> str:
    """Return the page of what was made up, without figures and claims."""
    matrix = SimpleNamespace(rotors=(), misprints=(), entries=())
    design: Any = SimpleNamespace(analysis=SimpleNamespace(at=()), examples=(), matrix=matrix)
    return page_text(
        replace(made_up_results(), design=design),
        defaultdict(list),
        defaultdict(lambda: Picture("", "")),
        plan=Plan.quickly(),
        flown={},
        run_files=[],
    )


def text_of(part: str) -> str:
    """Return the words of a piece of HTML as they are read."""
    return " ".join(html.unescape(re.sub(r"<[^>]+>", "", part)).split())


def listed_in(page: str) -> list[str]:
    """Return the texts of a list in HTML, item by item, as they are read."""
    items = re.findall(r"<li>(.*?)</li>", page, re.DOTALL)
    return [text_of(item) for item in items]


def signed(share: float) -> str:
    return f"{100.0 * share:+.1f}".replace("-", "−")


def per_cent(share: float) -> str:
    if share > 1.0:
        return f"{1.0 + share:.1f} × larger"
    if share < -0.5:
        return f"{1.0 / (1.0 + share):.2g} × smaller"
    return f"{signed(share)} %"


@cache
def made_up_results() -> Results:
    """Make up everything but the design, which is computed and not flown."""
    return Results(
        design=SimpleNamespace(),  # type: ignore[arg-type]
        flights=_flights(),
        hypotheses=_hypotheses(),
        ablation=_ablation(),
        experiment=_experiment(),
        degraded=_degraded(),
        degraded_runs={key: build_random_run(seed=40 + k) for k, key in enumerate(LOSSES)},
        tilt_choice=_tilt_choice(),
    )


def _flights() -> PaperFlights:
    groups: Any = {
        group: {name: some() for name in NAMES}
        for group in ("realistic", "without_momentum", "pose_only", "in_wakes")
    }
    plants = ((0.5e-3, 0.0), (1e-3, 0.0), (2e-3, 0.0), (4e-3, 0.0), (1e-3, 1e-5))
    variants = [
        Variant(step, noise, build_random_run(seed=30 + k), flown())
        for k, (step, noise) in enumerate(plants)
    ]
    return PaperFlights(
        seeds=range(4),
        runs={name: build_random_run(seed=20 + k) for k, name in enumerate(NAMES)},
        perfect={name: flown() for name in NAMES},
        variants=variants,
        **groups,
    )


def _hypotheses() -> list[Hypothesis]:
    """Make up four; the fit gives the paper's numbers, a conjecture two of them."""
    claimed: dict[str, dict[str, float]] = {name: {} for name in (A, B, W3)}
    for claim in paper.claims().values():
        metric = claim.about.get("metric")
        if metric in ("position_error_mean_m", "attitude_error_paper"):
            factor = 1e-3 if claim.unit == "mm" else 1.0
            claimed[claim.about["scenario"]][metric] = factor * (claim.value or 0.0)
    far = {name: {key: 3.0 * value for key, value in one.items()} for name, one in claimed.items()}
    ways: list[tuple[str, Verdict | None, str, Any]] = [
        (WITH_MOMENTUM, None, "", {name: {} for name in claimed}),
        (MOMENTUM_AND_WAKES, Verdict.CONJECTURED, "it is only half said", far | {A: claimed[A]}),
        ("another", Verdict.CONJECTURED, "nobody says so", far),
        ("fitted", Verdict.CALIBRATED, "it was fitted", claimed),
    ]
    return [
        Hypothesis(
            label=label,
            verdict=verdict,
            against=against,
            flown={name: some(**numbers[name]) for name in (A, B, W3)},
        )
        for label, verdict, against, numbers in ways
    ]


def _ablation() -> Ablation:
    ways = [
        *((PERFECT, label) for label in ("nothing", "noise")),
        *((LESS, label) for label in ("nothing", "no measurement noise")),
        *((MORE, label) for label in ("noise, filtered", "delay 8 ms", "interference")),
    ]
    conditions = [
        Condition(group=group, label=label, flown={name: some() for name in (A, B)})
        for group, label in ways
    ]
    lag = Lag(attitude_time=0.21, position_time=0.31, turned=13.0, path_length=1.7, duration=43.0)
    return Ablation(conditions=conditions, lag=lag)


LOSSES = ("a_survives", "b_fails", "b_survives")


def _degraded() -> Degraded:
    about = {key: paper.claims()[key].about for key in LOSSES}
    lost, far = flown("lost"), flown(position_error_max_m=0.3)
    fates = [[flown(), far, far, lost], [lost, lost, lost, flown()], [flown(), flown(), far, lost]]
    losses = [
        PaperLoss(
            key=key,
            scenario=about[key]["scenario"],
            loss=about[key]["loss_percent"] / 100.0,
            speed_limit=limit,
            flown=[*fate, *(some() if limit == LIMITS[1] else [])],
        )
        for key, fate in zip(LOSSES, fates, strict=True)
        for limit in LIMITS
    ]
    frontiers = [
        Frontier(
            scenario=name,
            kind=kind,
            criterion=criterion,
            speed_limit=limit,
            survived={0.6: Share(k % 4, 9), 0.2: Share(9 - k % 3, 9), 0.4: Share(5, 9)},
            bracket=(0.201 + 0.01 * k, 0.502 + 0.01 * k),
            physical_limit=0.3 + 0.02 * KINDS.index(kind) + 0.1 * LIMITS.index(limit),
        )
        for k, (name, kind, criterion, limit) in enumerate(
            (name, kind, criterion, limit)
            for name in (A, B)
            for kind in KINDS
            for criterion in (NOT_LOST, POSE_KEPT)
            for limit in LIMITS
        )
    ]
    dead = {
        (name, criterion): [Share((3 * i + k) % 6, 7) for i in range(8)]
        for k, (name, criterion) in enumerate(
            (name, criterion) for name in (A, B) for criterion in (NOT_LOST, POSE_KEPT)
        )
    }
    return Degraded(losses=losses, frontiers=frontiers, dead=dead, judged=[])


def _tilt_choice() -> TiltChoice:
    labels = ("three candidates", "exhaustive, window", "exhaustive, range")
    choices = [
        Choice(
            label=label,
            runs={name: build_random_run(seed=50 + 2 * k + i) for i, name in enumerate((A, B))},
            flown={name: some() for name in (A, B)},
        )
        for k, label in enumerate(labels)
    ]
    gaps = [
        Gap(scenario=name, span=label, gap=_DRAWN.lognormal(-4.5 - k, 1.0, size=400))
        for name in (A, B)
        for k, label in enumerate(labels[1:])
    ]
    time = np.linspace(0.0, 0.019, 7)
    bound = LowerBound(
        time=time, tilt=_DRAWN.uniform(0.2, 0.9, 7), power=_DRAWN.uniform(3e5, 6e5, 7)
    )
    return TiltChoice(choices=choices, gaps=gaps, lower_bound=bound)


def _experiment() -> Experiment:
    def reading(force: float, others: float) -> StandReading:
        time = np.arange(0.0, 6.0, 0.01)
        speed = TURN * np.tile(others * np.arange(1.0, 9.0), (len(time), 1))
        speed[:, 3] = TURN * 120.0
        speed[time < 0.5] = 0.0
        thrust = force * (1.0 + 0.01 * np.sin(40.0 * time)) * np.where(time < 0.5, 0.0, 1.0)
        along = np.column_stack([0.0 * thrust, 0.0 * thrust, thrust])
        none = np.zeros_like(along)
        return StandReading(
            time=time,
            speed=speed,
            axis=np.array([0.0, 0.0, 1.0]),
            force=along,
            torque=none,
            true_force=along,
            true_torque=none,
        )

    tests = [
        StandTest(tilt=math.radians(tilt), alone=reading(2.61, 0.0), together=reading(left, 9.0))
        for tilt, left in ((0.0, 1.83), (50.0, 2.47))
    ]
    return Experiment(rotor=3, tests=tests, judged=[])
