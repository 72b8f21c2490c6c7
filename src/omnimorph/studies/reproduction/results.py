"""`Results`: all that the sections of the page are written from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from omnimorph.results.run import Run
from omnimorph.studies.reproduction.ablation import Ablation
from omnimorph.studies.reproduction.degraded import Degraded
from omnimorph.studies.reproduction.design import Design
from omnimorph.studies.reproduction.flights import PaperFlights
from omnimorph.studies.reproduction.hypotheses import Hypothesis
from omnimorph.studies.reproduction.interference import Experiment
from omnimorph.studies.reproduction.tilt_choice import TiltChoice


@dataclass(frozen=True, kw_only=True, eq=False)
class Results:
    """All that was found: one field a section of the page."""

    design: Design
    flights: PaperFlights
    hypotheses: list[Hypothesis]
    ablation: Ablation
    experiment: Experiment
    degraded: Degraded
    degraded_runs: Mapping[str, Run]  # key of a claim -> one flight with that loss of thrust
    tilt_choice: TiltChoice
