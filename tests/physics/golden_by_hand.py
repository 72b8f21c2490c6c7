"""Flights with kept values that are not flown by the core alone: parts in Python, steps, plants."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from tests.physics import golden_parts as parts
from tests.physics.golden_effects import EVERYTHING
from tests.physics.golden_parts import (
    REALISTIC,
    RUNGE_KUTTA,
    WEIGHTS,
    Named,
    alone,
    plant,
    scenario,
)
from tests.physics.golden_values import Trace, trace_of

import omnimorph as om
from omnimorph import effects


def parts_in_python() -> Named:
    """A controller, an allocator or a disturbance in Python, and a controller that fails."""
    tilted = scenario(start_tilt=0.25)
    written: dict[str, dict[str, Any]] = {
        "controller": {"controller": parts.lift_alone},
        "allocator": {"allocator": parts.spread_out},
        "disturbance": {"disturbance": parts.spring_from_outside},
        "controller and disturbance": {
            "controller": parts.lift_alone,
            "disturbance": parts.spring_from_outside,
        },
    }
    for name, part in written.items():
        yield f"{name} in Python", partial(alone, tilted, **part)
    for number in (np.nan, np.inf):
        yield f"controller gives {number}", partial(failing_later, tilted, number)


def failing_later(what: om.Scenario, number: float) -> list[Trace]:
    """Fly with a controller that gives this number in the end."""
    return alone(what, controller=parts.FailingLater(number))


def stepped() -> Named:
    """Flown a control step at a time: pushed, damaged, and given another controller."""
    jointly = scenario(allocator=om.JointTilt(**WEIGHTS, W4=0.0625))
    push = np.array([20.0, -4.0, 8.0, 0.25, 0.0, -0.5])
    shares = np.array([1.0, 0.25, 1.0, 1.0, 0.0, 1.0, 0.875, 1.0])

    def pushed(flight: om.SteppedFlight, step: int) -> None:
        flight.step(push if 10 <= step < 20 else np.zeros(6))

    def damaged(flight: om.SteppedFlight, step: int) -> None:
        if step == 15:
            flight.set_effectiveness(shares)
        flight.step()

    def handed_over(flight: om.SteppedFlight, step: int) -> None:
        if step == 25:
            flight.change_controller(jointly)
        flight.step()

    def without_thrust(flight: om.SteppedFlight, step: int) -> None:
        if step == 15:
            flight.set_effectiveness(np.zeros(8))
        flight.step()

    def everything(flight: om.SteppedFlight, step: int) -> None:
        handed_over(flight, step)
        if step == 30:
            flight.set_effectiveness(shares)
        if step >= 40 and not flight.is_over:
            flight.step(-push)

    late = effects.CommandDelay(time=0.006)
    weak = effects.Effectiveness(share=0.9375)
    worn = plant(*REALISTIC, late, weak, effects.Interference())
    what = scenario(plant=worn, lost_beyond=0.125)
    for doing in (pushed, damaged, handed_over, everything, without_thrust):
        name = doing.__name__.replace("_", " ")
        yield f"stepped, {name}", partial(flown_by_hand, what, doing, steps=10**6)
    yield "stepped, under way", partial(flown_by_hand, what, pushed, steps=30)


def flown_by_hand(
    what: om.Scenario, doing: Callable[[om.SteppedFlight, int], None], steps: int
) -> list[Trace]:
    """Step a flight, at most so often."""
    flight = om.SteppedFlight(what, seed=7, flight=3)
    step = 0
    while not flight.is_over and step < steps:
        doing(flight, step)
        step += 1
    return [trace_of(flight.as_run())]


def plants() -> Named:
    """A plant on its own, under commands and pushes."""
    omnimorph, voliro = parts.vehicle_of("omnimorph"), parts.vehicle_of("voliro")
    for name, vehicle, worn in (
        ("perfect", omnimorph, ()),
        ("realistic", omnimorph, REALISTIC),
        ("with all effects", omnimorph, EVERYTHING),
        ("realistic, voliro", voliro, REALISTIC),
        ("realistic, 1 rotor", parts.ring(1), REALISTIC),
    ):
        for integrator in ("semi-implicit-euler", RUNGE_KUTTA):
            model = plant(*worn, integrator=integrator)
            yield f"plant {name}, {integrator}", partial(plant_alone, vehicle, model)


def plant_alone(vehicle: om.Vehicle, model: om.PlantModel) -> list[Trace]:
    """Command a plant for a while; return what it did, measured and true."""
    n, m = vehicle.n_rotors, vehicle.n_servos
    start = om.State(*parts.Screw(0.25)(0.125)[:4])
    flying = om.SimulatedPlant(vehicle, model, start=start, start_tilt=0.5, seed=7)
    rows: list[list[Any]] = []
    for step in range(60):
        thrust = 1.75 + 0.03125 * ((np.arange(n, dtype=np.float64) * (step + 1)) % 5.0)
        command = om.Command(thrust * (1.0 if step < 30 else -0.5), np.full(m, 0.5 + step / 64.0))
        measured = flying.step(command)
        flying.step_physics(4, np.array([1.0, 0.0, -2.0, 0.0, 0.125, 0.0]))
        rows.append([*measured, *flying.state, flying.speed, flying.tilt, flying.wrench])
    names = [f"measured_{name}" for name in om.State._fields] + [*om.State._fields]
    names += ["speed", "tilt_actual", "wrench_achieved"]
    return [dict(zip(names, map(np.array, zip(*rows, strict=True)), strict=True)) | {"outcome": ""}]
