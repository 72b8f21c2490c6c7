"""The flights of the paper: every scenario with several seeds, in both plants."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from omnimorph.results.metrics import Metrics
from omnimorph.results.run import Run
from omnimorph.simulation.effects import MeasurementNoise
from omnimorph.simulation.fly import fly
from omnimorph.simulation.plant import PlantModel
from omnimorph.simulation.scenario_files import load_scenario

__all__ = ["N_FLIGHTS_BUT_SEEDS", "SCENARIOS", "Flown", "Variant", "fly_everything"]

SCENARIOS = (
    "paper-case-a",
    "paper-case-b",
    "paper-case-b-w3",
    "paper-fixed-45-a",
    "paper-fixed-45-b",
)
"""What is flown, in the order of every table."""

_STEPS = (0.5e-3, 1e-3, 2e-3, 4e-3)  # s, of the perfect plants that ought to agree
_TINY_NOISE = 1e-5  # m, m/s, rad and rad/s, 1σ

N_FLIGHTS_BUT_SEEDS = len(SCENARIOS) + len(_STEPS) + 1
"""How many flights there are beside the seeds of each scenario."""


@dataclass(frozen=True)
class Variant:
    """Both cases in a plant without imperfection, but for its step or a tiny noise.

    Attributes
    ----------
    step : float, s
        Of physics and control.
    noise : float, m, m/s, rad, rad/s
        One standard deviation of every measurement.
    run : Run
        What came out of Case A.
    b : Metrics
        What came out of Case B in the same plant.
    """

    step: float
    noise: float
    run: Run
    b: Metrics


@dataclass(frozen=True)
class Flown:
    """Everything that was flown.

    Attributes
    ----------
    seeds : range
        Of the realistic plant.
    runs : mapping of scenario name to Run
        The first seed, in the realistic plant.
    spread : mapping of scenario name to list of Metrics
        One for each seed, in the realistic plant.
    perfect : mapping of scenario name to Metrics
        In the perfect plant.
    variants : list of Variant
        Case A in plants that ought to agree.
    """

    seeds: range
    runs: Mapping[str, Run]
    spread: Mapping[str, list[Metrics]]
    perfect: Mapping[str, Metrics]
    variants: list[Variant]


def fly_everything(seeds: range, next_step: Callable[[str], None]) -> Flown:
    """Fly every scenario with every seed, in the perfect plant, and Case A in its variants.

    `next_step` is called with a few words before each flight.
    """
    runs: dict[str, Run] = {}
    spread: dict[str, list[Metrics]] = {}
    perfect: dict[str, Metrics] = {}
    for name in SCENARIOS:
        scenario = load_scenario(name)
        spread[name] = []
        for seed in seeds:
            next_step(f"flying {name}")
            run = fly(scenario, seed=seed)
            spread[name].append(run.metrics)
            runs.setdefault(name, run)
        next_step(f"flying {name}")
        perfect[name] = fly(scenario, plant="perfect").metrics
    return Flown(seeds, runs, spread, perfect, _fly_variants(next_step))


def _fly_variants(next_step: Callable[[str], None]) -> list[Variant]:
    case_a, case_b = load_scenario("paper-case-a"), load_scenario("paper-case-b")
    found = []
    for step, noise in [*((step, 0.0) for step in _STEPS), (1e-3, _TINY_NOISE)]:
        next_step("flying plants that ought to agree")
        tiny = MeasurementNoise(position=noise, velocity=noise, attitude=noise, rate=noise)
        plant = PlantModel(
            physics_step=step, control_period=step, effects=(tiny,) if noise else (), name="variant"
        )
        run, b = (fly(replace(scenario, plant=plant)) for scenario in (case_a, case_b))
        found.append(Variant(step, noise, run, b.metrics))
    return found
