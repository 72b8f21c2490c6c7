"""What experiments could have given: made-up but plausible data for their figures."""

from __future__ import annotations

import math

import numpy as np

from omnimorph.protocols import FloatArray
from omnimorph.report.style import BLUE, VERMILLION, Look
from omnimorph.studies.reproduction.figures.ablation import AblationPanel, AblationRow
from omnimorph.studies.reproduction.figures.frontier import FrontierPanel, PhysicalLimit, Survival
from omnimorph.studies.reproduction.figures.stand import Level, StandSpeeds, StandTest
from omnimorph.studies.reproduction.figures.tilt_choice import ChoiceEnergy, CostGap
from omnimorph.units import to_SI

DASHED = (0, (4.0, 1.4))
LOOKS = {"Case A": Look(VERMILLION), "Case B": Look(BLUE, DASHED, "s")}

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


def build_stand() -> tuple[StandSpeeds, list[StandTest]]:
    """Build half a minute at 1 kHz: seven rotors in steps of 20 Hz around one at 120 Hz."""
    random = np.random.default_rng(2)
    time = 1e-3 * np.arange(35_000, dtype=np.float64)
    share: FloatArray = np.minimum(np.floor(time / 5.0), 6.0) / 6.0
    speeds = StandSpeeds(time, np.full(35_000, to_SI(120.0, "Hz")), to_SI(120.0 * share, "Hz"))
    tests = []
    for tilt, left, words in ((0.0, 1.8, "1.8 N, −33 %"), (math.radians(50.0), 2.5, "−7 %")):
        loss = (2.7 - left) * share**2
        alone = 2.68 + 0.03 * random.normal(size=35_000)
        noise = (0.03 + 0.06 * share) * random.normal(size=35_000)
        levels = [Level(2.7, "2.7 N"), Level(left, words)]
        tests.append(StandTest(tilt, time, alone, 2.68 - loss + noise, levels))
    return speeds, tests


# --- frontier -------------------------------------------------------------------------------------


def wilson(share: FloatArray, flights: int) -> tuple[FloatArray, FloatArray]:
    """Return the ends of the 95 % interval of a share that so many flights gave."""
    z = 1.96
    middle = (share + z * z / (2 * flights)) / (1 + z * z / flights)
    half = z * np.sqrt(share * (1 - share) / flights + (z / (2 * flights)) ** 2)
    half /= 1 + z * z / flights
    return middle - half, middle + half


def _survival(label: str, look: Look, over: FloatArray, share: FloatArray) -> Survival:
    return Survival(label, look, over, share, *wilson(share, 20))


def build_frontier() -> tuple[list[FrontierPanel], list[Survival]]:
    """Build two kinds of loss, two cases at two rotor limits, and single dead rotors."""
    loss = np.linspace(0.0, 0.6, 13)
    panels = []
    for title, scale in (("all rotors", 1.0), ("lower rotors", 1.35)):
        curves = [
            _survival(
                f"{case}, rotors to {limit} Hz",
                Look(look.colour, line, look.mark),
                loss,
                np.round(20 / (1 + np.exp(60 * (loss - scale * fails - shift)))) / 20,
            )
            for limit, line, shift in ((170, "-", 0.0), (220, DASHED, 0.12))
            for (case, look), fails in zip(LOOKS.items(), (0.36, 0.31), strict=True)
        ]
        limits = [
            PhysicalLimit(0.39 * scale, "170 Hz: physical limit"),
            PhysicalLimit(0.53, "220 Hz"),
        ]
        panels.append(FrontierPanel(title, curves, limits))
    shares = np.array([0, 1, 0.4, 1, 1, 0.8, 0, 1]), np.array([0, 0.9, 0.1, 0, 0.6, 0, 0, 1])
    dead = [
        _survival(f"{case}, rotors to 170 Hz", look, np.arange(8.0), share)
        for (case, look), share in zip(LOOKS.items(), shares, strict=True)
    ]
    return panels, dead


# --- choice of the tilt ---------------------------------------------------------------------------


def build_gaps() -> list[CostGap]:
    """Build gaps of 11 000 control steps to the best of the window and of the range."""
    random = np.random.default_rng(3)
    gaps = []
    for case, look in LOOKS.items():
        window = np.maximum(np.exp(random.normal(-9.0, 2.0, size=11_000)) - 3e-4, 0.0)
        whole = np.maximum(np.exp(random.normal(-5.0, 2.5, size=11_000)) - 3e-3, 0.0)
        gaps.append(CostGap(f"{case}, beside the best of the window", look, window))
        dotted = Look(look.colour, (0, (1.2, 1.2 if case == "Case A" else 3.0)))
        gaps.append(CostGap(f"{case}, beside the best of all", dotted, whole))
    return [*gaps, CostGap("exhaustive search", Look("#000000"), np.zeros(100))]


WAYS = ("three candidates", "exhaustive in the window", "exhaustive over the range", "least power")


def build_energies() -> tuple[list[ChoiceEnergy], dict[str, float]]:
    """Build what four ways of choosing spend, the last one the least."""
    random = np.random.default_rng(4)
    spread = 1.0 + 0.005 * random.normal(size=5)
    factors = (1.75, 1.74, 1.7, 1.02), (1.12, 1.11, 1.04, 1.02)
    rows = [
        ChoiceEnergy(way, {"Case A": 1100.0 * a * spread, "Case B": 1100.0 * b * spread})  # type: ignore[dict-item]
        for way, a, b in zip(WAYS, *factors, strict=True)
    ]
    return rows, {"Case A": 1100.0, "Case B": 1090.0}
