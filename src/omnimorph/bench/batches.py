"""Many flights at once against the clock."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.results.flights import Flights
from omnimorph.simulation import effects
from omnimorph.simulation.fly_many import fly_many
from omnimorph.simulation.plant import PlantModel
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import load_plant, load_scenario

VEHICLES = 1024
CONTROL_PERIOD = 4e-3  # s, with every imperfection on


class BatchTimes(NamedTuple):
    """One round of batches, in physics steps of one vehicle a second where nothing else is said."""

    perfect: float  # all cores
    one_thread: float
    single_precision: float
    worn: float
    whole_flights: float  # realistic flights of 45 s a second
    largest_over_smallest: float  # seconds a vehicle, 16 384 of them over 256
    threads: int


def time_batches() -> BatchTimes:
    """Fly 1024 OmniMorphs in several ways, once each, and some whole flights."""
    perfect = _beginning()
    all_cores = fly_all(perfect, VEHICLES).performance
    one_thread = fly_all(perfect, VEHICLES // 4, threads=1).performance
    single = fly_all(perfect, VEHICLES, precision="float32").performance
    worn = fly_all(replace(perfect, plant=worn_plant()), VEHICLES).performance
    whole = 64
    flights = fly_all(load_scenario("paper-case-a"), whole).performance
    short = _hovering(0.25)
    few, many = (fly_all(short, n).performance.wall_time / n for n in (256, 16384))
    return BatchTimes(
        perfect=all_cores.vehicle_steps_per_s,
        one_thread=one_thread.vehicle_steps_per_s,
        single_precision=single.vehicle_steps_per_s,
        worn=worn.vehicle_steps_per_s,
        whole_flights=whole / flights.wall_time,
        largest_over_smallest=many / few,
        threads=all_cores.threads,
    )


def fly_all(scenario: Scenario, n: int, **how: Any) -> Flights:
    """Fly all n flights of `fly_many`: a Ctrl-C, which it answers with some, ends this."""
    flights = fly_many(scenario, n, **how)
    if flights.interrupted:
        raise KeyboardInterrupt
    return flights


def omnimorphs_per_s() -> float:
    """Fly 1024 OmniMorphs, three QPs in every 1 kHz step, on all cores: steps a second."""
    return fly_all(_beginning(), VEHICLES).performance.vehicle_steps_per_s


def worn_plant() -> PlantModel:
    """Return a plant with every imperfection on, each mild enough to fly with."""
    return PlantModel(
        name="every imperfection",
        control_period=CONTROL_PERIOD,
        effects=(
            effects.CommandDelay(time=4e-3),
            effects.RotorLag(up=0.010, down=0.014),
            effects.SpeedLimits(),
            effects.DeadBand(smallest=2.0 * np.pi * 20.0, reversal_time=5e-3),
            effects.Effectiveness(share=0.97),
            effects.ModelMismatch(mass=1.02, inertia=0.97, drag_coefficient=1.05),
            effects.ServoLag(time_constant=0.02),
            effects.ServoRateLimit(),
            effects.MeasurementNoise(
                position=1e-3, velocity=1e-2, attitude=3e-3, rate=1e-2, filtered=True
            ),
            effects.ConstantWrench(force=(0.1, 0.0, 0.1), torque=(0.0, 1e-3, 0.0)),
            effects.SineWrench(force=(0.1, 0.0, 0.0), frequency=3.0),
            effects.WrenchProfile(times=(0.0, 1.0), force=((0.0, 0.0, 0.0), (0.0, 0.1, 0.0))),
            effects.RotorMomentum(),
            effects.Interference(),
        ),
    )


@cache
def _beginning() -> Scenario:
    """Return the first movement of Case A in the perfect plant."""
    whole = load_scenario("paper-case-a")
    reference = whole.reference
    assert isinstance(reference, SegmentReference)
    first = SegmentReference(reference.start_p_WB, reference.start_R_WB, reference.segments[:1])
    return replace(whole, reference=first, plant=load_plant("perfect"))


@cache
def _hovering(duration: float) -> Scenario:
    whole = _beginning()
    return replace(
        whole, reference=SegmentReference([0.0, 0.0, 1.2], np.eye(3), [Segment(duration)])
    )
