"""What experiments could have given: made-up but plausible data for their figures."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.report.style import BLUE, VERMILLION, LineStyle
from omnimorph.results.run import Run
from omnimorph.simulation.thrust_stand import StandReading
from omnimorph.studies.flight_log import FlightResult
from omnimorph.studies.reproduction.degraded import Degraded
from omnimorph.studies.reproduction.figures.ablation import AblationPanel, AblationRow
from omnimorph.studies.reproduction.flights import CASES
from omnimorph.studies.reproduction.frontier import Frontier
from omnimorph.studies.reproduction.interference import Experiment, StandTest
from omnimorph.studies.reproduction.lost_thrust import KINDS, NOT_LOST, POSE_KEPT, Share
from omnimorph.studies.reproduction.tilt_choice import (
    RANGE,
    WINDOW,
    Choice,
    Gap,
    LowerBound,
    TiltChoice,
)
from omnimorph.units import to_SI

DASHED = (0, (4.0, 1.4))
LINE_STYLES = {"Case A": LineStyle(VERMILLION), "Case B": LineStyle(BLUE, DASHED, "s")}

# --- ablation -------------------------------------------------------------------------------------

_EFFECTS = (
    "rotor lag 20 ms",
    "rotor speed limits",
    "dead band of 15 Hz",
    "command delay 4 ms",
    "servo rate 100°/s",
    "servo lag 50 ms",
    "measurement noise",
    "filters of 30 Hz",
    "model mismatch 5 %",
    "interference of rotors",
    "angular momentum of rotors",
)
_GROUPS = {
    "perfect plant plus one": ("perfect plant", *_EFFECTS),
    "realistic plant less one": ("realistic plant", *_EFFECTS[:8]),
    "realistic plant plus one": ("wind of 2 m/s", "constant torque of 0.1 N m", "half the gains"),
    "another reference": tuple(f"segments of {s} s, jerk continuous" for s in range(2, 13)),
}
PANELS = (
    AblationPanel("tilt", "mean tilt (°)", paper={}),
    AblationPanel("energy", "energy (“J”)", paper={"Case A": 2080.7, "Case B": 1162.3}),
    AblationPanel("position", "position error\n(mm)", True, {"Case A": 11.0, "Case B": 44.0}),
    AblationPanel(
        "attitude", "attitude error\n‖e_R‖ (–)", True, {"Case A": 0.062, "Case B": 0.068}
    ),
)
_TYPICAL = {
    "tilt": {"Case A": (56.0, 0.03)},
    "energy": {"Case A": (1950.0, 0.06), "Case B": (1200.0, 0.08)},
    "position": {"Case A": (9.0, 0.6), "Case B": (21.0, 0.7)},
    "attitude": {"Case A": (0.03, 0.5), "Case B": (0.05, 0.5)},
}


def build_ablation() -> list[AblationRow]:
    """Build 35 rows of five seeds; in the third all flights of Case B are lost, in the 9th two."""
    random = np.random.default_rng(1)
    rows = []
    for group, labels in _GROUPS.items():
        for label in labels:
            values = {
                measure: {
                    case: typical * np.exp(spread * random.normal() + 0.03 * random.normal(size=5))
                    for case, (typical, spread) in cases.items()
                }
                for measure, cases in _TYPICAL.items()
            }
            rows.append(AblationRow(label, group, values))  # type: ignore[arg-type]
    for row, lost in ((rows[2], slice(None)), (rows[8], slice(2))):
        for cases in row.values.values():
            if "Case B" in cases:
                cases["Case B"][lost] = math.nan  # type: ignore[index]
    return rows


# --- stand ----------------------------------------------------------------------------------------


def build_stand() -> Experiment:
    """Build half a minute at 1 kHz: seven rotors in steps of 20 Hz around one at 120 Hz."""
    random = np.random.default_rng(2)
    time = 1e-3 * np.arange(35_000, dtype=np.float64)
    share: FloatArray = np.minimum(np.floor(time / 5.0), 6.0) / 6.0
    speed = to_SI(120.0, "Hz") * np.column_stack([np.ones_like(time), *7 * [share]])

    def reading(thrust: FloatArray) -> StandReading:
        force = np.outer(thrust, [0.0, 0.0, 1.0])
        none = np.zeros_like(force)
        return StandReading(
            time=time,
            speed=speed,
            axis=np.array([0.0, 0.0, 1.0]),
            force=force,
            torque=none,
            true_force=force,
            true_torque=none,
        )

    tests = []
    for tilt, left in ((0.0, 1.8), (math.radians(50.0), 2.5)):
        loss = (2.7 - left) * share**2
        alone = 2.68 + 0.03 * random.normal(size=35_000)
        noise = (0.03 + 0.06 * share) * random.normal(size=35_000)
        tests.append(
            StandTest(tilt=tilt, alone=reading(alone), together=reading(2.68 - loss + noise))
        )
    return Experiment(rotor=0, tests=tests, judged=[])


# --- frontier -------------------------------------------------------------------------------------


def build_frontier() -> Degraded:
    """Build two kinds of loss, two cases at two rotor limits, and single dead rotors."""
    loss = np.linspace(0.0, 0.6, 13)
    frontiers = []
    for kind, scale in zip(KINDS, (1.0, 1.35), strict=True):
        for criterion in (NOT_LOST, POSE_KEPT):
            for limit, shift, physical in ((170, 0.0, 0.39 * scale), (220, 0.12, 0.53)):
                for name, fails in zip(CASES, (0.36, 0.31), strict=True):
                    met = np.round(20 / (1 + np.exp(60 * (loss - scale * fails - shift))))
                    frontiers.append(
                        Frontier(
                            scenario=name,
                            kind=kind,
                            criterion=criterion,
                            speed_limit=to_SI(float(limit), "Hz"),
                            survived={
                                at: Share(int(k), 20)
                                for at, k in zip(loss.tolist(), met, strict=True)
                            },
                            bracket=(0.3, 0.4),
                            physical_limit=physical,
                        )
                    )
    dead = {
        (name, criterion): [Share(k, 20) for k in met]
        for name, criterion, met in (
            (CASES[0], NOT_LOST, (0, 20, 8, 20, 20, 16, 0, 20)),
            (CASES[1], POSE_KEPT, (0, 18, 2, 0, 12, 0, 0, 20)),
        )
    }
    return Degraded(losses=[], frontiers=frontiers, dead=dead, judged=[])


# --- choice of the tilt ---------------------------------------------------------------------------


WAYS = ("three candidates", "exhaustive in the window", "exhaustive over the range")


def build_gaps() -> list[Gap]:
    """Build gaps of 11 000 control steps to the best of the window and of all; one is none."""
    random = np.random.default_rng(3)
    gaps = []
    for name in CASES:
        window = np.maximum(np.exp(random.normal(-9.0, 2.0, size=11_000)) - 3e-4, 0.0)
        whole = np.maximum(np.exp(random.normal(-5.0, 2.5, size=11_000)) - 3e-3, 0.0)
        gaps += [Gap(scenario=name, span=WINDOW, gap=window)]
        gaps += [Gap(scenario=name, span=RANGE, gap=whole)]
    return [*gaps, Gap(scenario=CASES[0], span="itself", gap=np.zeros(100))]


def build_choices(run: Run) -> TiltChoice:
    """Build what three ways of choosing spend, in flights that look alike."""
    random = np.random.default_rng(4)
    spread = 1.0 + 0.005 * random.normal(size=5)
    factors = (1.75, 1.74, 1.7), (1.12, 1.11, 1.04)
    choices = [
        Choice(
            label=way,
            runs=dict.fromkeys(CASES, run),
            flown={
                name: [
                    FlightResult(replace(run.metrics, drag_energy_paper=1100.0 * factor * share))
                    for share in spread.tolist()
                ]
                for name, factor in zip(CASES, both, strict=True)
            },
        )
        for way, *both in zip(WAYS, *factors, strict=True)
    ]
    power = np.full(2, 2.0 * math.pi * 1100.0)
    bound = LowerBound(time=np.array([0.0, 1.0]), tilt=np.zeros(2), power=power)
    return TiltChoice(choices=choices, gaps=build_gaps(), lower_bound=bound)
