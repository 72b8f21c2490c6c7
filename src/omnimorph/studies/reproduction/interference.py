"""The paper's experiment on interference, replayed on a simulated test stand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from omnimorph.design.files import load_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.simulation.effects import Interference, RotorLag
from omnimorph.simulation.speed_profile import speed_steps
from omnimorph.simulation.thrust_stand import StandReading, ThrustStand
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.verdicts import Basis, Judged, judge
from omnimorph.units import to_SI

_SETTLED = 2.0  # s at the end of the highest step, over which forces are averaged


@dataclass(frozen=True, kw_only=True, eq=False)
class StandTest:
    """The rotor on the sensor at one tilt, alone and with the others."""

    tilt: float  # rad
    alone: StandReading
    together: StandReading

    @property
    def force_alone(self) -> float:
        """Mean force along the rotor's axis at the end, N, alone."""
        return _at_the_end(self.alone)

    @property
    def force_together(self) -> float:
        """The same with the others at their highest speed."""
        return _at_the_end(self.together)

    @property
    def loss(self) -> float:
        """What the others take, as a share."""
        return 1.0 - self.force_together / self.force_alone


@dataclass(frozen=True, kw_only=True, eq=False)
class Experiment:
    """The replayed experiment."""

    rotor: int  # the lower one on the sensor, from 0
    tests: list[StandTest]  # one for each tilt
    judged: list[Judged]

    def as_dict(self) -> dict[str, Any]:
        """Return what ``results.json`` holds of it."""
        return {
            "rotor": self.rotor,
            "tests": [
                {
                    "tilt_deg": float(np.degrees(test.tilt)),
                    "force_alone_N": test.force_alone,
                    "force_together_N": test.force_together,
                    "loss": test.loss,
                }
                for test in self.tests
            ],
        }


def replay_experiment() -> Experiment:
    """Put a lower rotor on the sensor at both tilts, alone and with the others."""
    vehicle = load_vehicle("omnimorph")
    rotor = int(np.argmin(vehicle.rotor_position[:, 2]))
    tests = [
        _test_at(vehicle, rotor, float(np.radians(tilt))) for tilt in paper.bench()["tilts_deg"]
    ]
    return Experiment(rotor=rotor, tests=tests, judged=_judge(tests))


def _test_at(vehicle: Vehicle, rotor: int, tilt: float) -> StandTest:
    stand = ThrustStand(
        vehicle=vehicle, rotor=rotor, tilt=tilt, effects=(RotorLag(), Interference())
    )
    bench = paper.bench()
    held, step, largest = (
        to_SI(float(bench[key]), "Hz") for key in ("held_Hz", "step_Hz", "largest_Hz")
    )
    alone, together = (
        stand.measure(
            speed_steps(vehicle, rotor, held=held, step=step, largest=largest, alone=only), seed
        )
        for seed, only in enumerate((True, False))
    )
    return StandTest(tilt=tilt, alone=alone, together=together)


def _at_the_end(reading: StandReading) -> float:
    return float(reading.thrust[reading.time > reading.time[-1] - _SETTLED].mean())


def _judge(tests: list[StandTest]) -> list[Judged]:
    untilted, tilted = tests
    calibrated = "The model of wakes was given the paper's two losses."
    own_file = "From the thrust coefficient of the vehicle's file."
    rows = (
        ("force_alone", untilted.force_alone, Basis.DERIVED, own_file),
        ("force_together", untilted.force_together, Basis.CHOSEN, calibrated),
        ("loss_at_0", 100.0 * untilted.loss, Basis.CHOSEN, calibrated),
        ("loss_at_50", 100.0 * tilted.loss, Basis.CHOSEN, calibrated),
    )
    found = f"mean over the last {_SETTLED:g} s of the simulated stand"
    return [
        judge(key, here=value, basis=basis, found=found, why=why, command="omnimorph verify")
        for key, value, basis, why in rows
    ]
