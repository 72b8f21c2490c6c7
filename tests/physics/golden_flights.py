"""Flights whose numbers are kept to the last bit, in ``golden_flights.toml``.

A change that is to leave every flight as it is leaves these values alone. A change that alters
flights on purpose writes them anew, in a commit of its own that says why::

    python -m tests.physics.golden_flights            # write the values anew
    python -m tests.physics.golden_flights --check    # compare them

Only what stays is used here: the public names of `omnimorph` and the columns of a run. Nothing
depends on BLAS, LAPACK or SciPy, whose last bits differ between versions and processors. Flights
that vary `rotor_lag` are left out: their bits come from a power of the C library.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import partial

import numpy as np
from tests.physics import golden_by_hand as by_hand
from tests.physics import golden_parts as parts
from tests.physics.golden_effects import EVERYTHING, WORN
from tests.physics.golden_parts import (
    NOISE,
    REALISTIC,
    RUNGE_KUTTA,
    WEIGHTS,
    Flight,
    Named,
    alone,
    both,
    many,
    plant,
    scenario,
)
from tests.physics.golden_values import (
    VALUES,
    Trace,
    as_file,
    differing,
    kept_values,
    values_of,
)

import omnimorph as om
from omnimorph import effects
from omnimorph.protocols import Reference
from omnimorph.reference import segments_from_waypoints


def vehicles() -> Named:
    """Every vehicle of the catalogue with the controller proposed for it, and other sizes."""
    for name in parts.CATALOGUE:
        own = scenario(name, **parts.controller_of(name))
        yield f"vehicle {name}", partial(alone, own)
        yield from both(f"vehicle {name}", own)
    fixed = om.FixedTilt(**WEIGHTS)
    for n in (5, 9):
        what = scenario(parts.ring(n), allocator=fixed)
        yield f"{n} rotors", partial(alone, what)
        yield from both(f"{n} rotors", what)
    jointly = om.JointTilt(**WEIGHTS)
    for sizes, body in (
        ("5 rotors, 5 servos", parts.ring(5, servos=True)),
        ("14 rotors, 2 servos", parts.FOURTEEN_ROTORS),
        ("18 rotors, 18 servos", parts.ring(18, servos=True)),
    ):
        what = scenario(body, allocator=jointly)
        yield sizes, partial(alone, what)
        yield from both(sizes, what)


def files() -> Named:
    """Scenarios of the catalogue, their beginning."""
    for name in ("paper-case-a", "paper-case-b", "paper-case-b-w3", "paper-fixed-45-a", "hover"):
        what = replace(om.load_scenario(name), reference=parts.MOVE_AND_TURN)
        yield f"scenario {name}", partial(alone, what)


def effects_of_plants() -> Named:
    """Every effect alone and all together: alone with the one integrator, many with the other."""
    for name, worn in (WORN | {"all": EVERYTHING}).items():
        quiet = name in ("none", "all") or "noise" in name
        one = scenario(plant=plant(*worn, integrator=RUNGE_KUTTA))
        some = scenario(plant=plant(*worn) if quiet else plant(*worn, NOISE))
        yield f"effect {name}", partial(alone, one)
        yield from both(f"effect {name}", some)
    for name in ("rotor-momentum", "interference published", "sine-wrench", "dead-band"):
        what = scenario(plant=plant(*WORN[name], NOISE, integrator=RUNGE_KUTTA))
        yield from both(f"effect {name}, {RUNGE_KUTTA}", what)


def allocators() -> Named:
    """Every rule, with several numbers of candidates and from several tilts."""
    rules: dict[str, om.ThreeCandidates | om.ExhaustiveTilt | om.JointTilt | om.FixedTilt] = {
        "three-candidates": om.ThreeCandidates(**WEIGHTS),
        "fixed-tilt": om.FixedTilt(**WEIGHTS),
        "joint-tilt": om.JointTilt(**WEIGHTS),
        "joint-tilt with W4": om.JointTilt(**WEIGHTS, W4=0.0625),
    }
    for candidates in (3, 5, 13, 27):
        found = om.ExhaustiveTilt(**WEIGHTS, span="window", candidates=candidates)
        rules[f"window of {candidates}"] = found
    for candidates in (3, 7, 31, 91):
        found = om.ExhaustiveTilt(**WEIGHTS, span="range", candidates=candidates)
        rules[f"range of {candidates}"] = found
    for name, rule in rules.items():
        what = scenario(allocator=rule, start_tilt=0.5, reference=parts.Screw())
        yield f"allocator {name}", partial(alone, what)
        yield from both(f"allocator {name}", what)
    each = WEIGHTS | {"W1": tuple(2.0**-27 * (1.0 + 0.125 * i) for i in range(8)), "W3": 0.0}
    own = scenario(allocator=om.ThreeCandidates(**each), start_tilt=1.0)
    yield "allocator with a weight a rotor", partial(alone, own)
    several = parts.controller_of("omav-12") | {"allocator": om.FixedTilt(**WEIGHTS)}
    tilts = np.array([0.25, -0.25, 0.125, -0.125, 0.0, 0.5])
    yield "six servos held", partial(alone, scenario("omav-12", **several, start_tilt=tilts))


def position_first() -> Named:
    """The attitude gives way: with none that can push sideways, and with a limited one."""
    for name in ("quadrotor", "hexarotor"):
        what = scenario(name, **parts.controller_of(name), attitude_gives_way=True)
        yield f"position first, {name}", partial(alone, what)
        yield from both(f"position first, {name}", what)
    for name, most in (("tilt-hex", 3.625), ("omav-12", 16.0)):
        what = scenario(name, **parts.controller_of(name))
        yield f"position first, {name}", partial(leaning, what, most)


def leaning(what: om.Scenario, lateral_force: float) -> list[Trace]:
    """Fly with the core's controller as a part in Python, which may push this hard sideways."""
    controller = om.PoseController(
        what.vehicle,
        what.gains,
        what.allocator,
        what.plant.control_period,
        what.start_tilt,
        lateral_force=lateral_force,
    )
    return alone(what, controller=controller)


VARIED: dict[str, om.Uniform] = {
    "mass": om.Uniform(0.75, 1.25),
    "inertia": om.Uniform(0.5, 1.5),
    "thrust_coefficient": om.Uniform(0.875, 1.125),
    "drag_coefficient": om.Uniform(0.5, 2.0),
    "effectiveness": om.Uniform(0.5, 1.0),
    "centre_of_mass": om.Uniform(-0.03125, 0.03125),
    "noise": om.Uniform(0.0, 4.0),
    "force": om.Uniform(-4.0, 4.0),
    "torque": om.Uniform(-0.25, 0.25),
    "start_position": om.Uniform(-0.25, 0.25),
    "start_velocity": om.Uniform(-0.5, 0.5),
    "start_attitude": om.Uniform(-0.25, 0.25),
    "start_rate": om.Uniform(-2.0, 2.0),
}
"""All in which flights can differ but the rotors' lag."""


def variations() -> Named:
    """Flights that differ in each number, and in all of them."""
    for name, distribution in VARIED.items():
        yield from both(f"vary {name}", scenario(), **{name: distribution})
    everything = scenario(plant=plant(*EVERYTHING))
    yield from both("vary all", everything, **VARIED)
    yield from both(
        "vary all on voliro", scenario("voliro", **parts.controller_of("voliro")), **VARIED
    )


def times_and_references() -> Named:
    """Control periods, physics steps and delays; references of segments and of rows."""
    for name, period, step, delay in (
        ("1 ms", 1e-3, 1e-3, 0.0),
        ("2 ms, late by 3 ms", 2e-3, 1e-3, 3e-3),
        ("5 ms, late by 20 ms", 5e-3, 1e-3, 0.02),
        ("10 ms in steps of 2 ms, late by 10 ms", 0.01, 2e-3, 0.01),
        ("1 ms in steps of 0.25 ms, late by 0.75 ms", 1e-3, 2.5e-4, 7.5e-4),
        ("1 ms, late by 60 ms", 1e-3, 1e-3, 0.06),
    ):
        late = (effects.CommandDelay(time=delay),) if delay else ()
        for integrator in ("semi-implicit-euler", RUNGE_KUTTA):
            timed = plant(
                *REALISTIC, *late, period=period, physics_step=step, integrator=integrator
            )
            yield f"control every {name}, {integrator}", partial(alone, scenario(plant=timed))
        yield from both(f"control every {name}", scenario(plant=timed))
    references: dict[str, Reference] = {
        "turned start": parts.FROM_A_QUARTER_TURN,
        "waypoints": segments_from_waypoints(
            [0.0625, 0.125, 0.25], [(0.0, 0.0, 1.0), (0.0, 0.015625, 1.0), (0.03125, 0.0, 1.0)]
        ),
        "own": parts.Screw(0.25),
        "own, sampled": parts.SampledScrew(0.5),
        "own, nearly upside down": parts.Screw(4.0),
    }
    for name, reference in references.items():
        what = scenario(reference=reference, start_tilt=0.875 if "upside" in name else 0.0)
        yield f"reference {name}", partial(alone, what)
        yield from both(f"reference {name}", what)


def endings() -> Named:
    """Flights that are lost, diverge, or are given what is no number.

    They are what no check before the flight can see: pulled, twisted, damaged under way.
    """
    heavy = effects.ConstantWrench(force=(0.0, 0.0, -400.0))
    torn = effects.ConstantWrench(torque=(1e9, 0.0, 5e8))
    for name, worn, most in (
        ("lost to a pull", heavy, 0.5),
        ("torn by a torque", torn, 1e9),
    ):
        for integrator in ("semi-implicit-euler", RUNGE_KUTTA):
            pulled = plant(*REALISTIC, worn, integrator=integrator)
            what = scenario(plant=pulled, lost_beyond=most)
            yield f"{name}, {integrator}", partial(alone, what)
        yield from both(name, what)
    pulls = np.zeros((17, 3))
    pulls[1, 2] = -400.0
    shares = np.ones((17, 8))
    shares[8] = 0.0
    rates = np.zeros((17, 3))
    rates[[2, 16]] = 1e160
    noise = np.ones(17)
    noise[7] = 1e160
    near = scenario(lost_beyond=0.125)
    for precision, n in (("float64", 9), ("float32", 17)):
        some = {"force": pulls[:n], "effectiveness": shares[:n]}
        some |= {"start_rate": rates[:n], "noise": noise[:n]}
        yield f"some end early, many in {precision}", partial(many, near, precision, **some)


FLIGHTS: dict[str, Flight] = {
    name: flight
    for some in (
        vehicles,
        files,
        effects_of_plants,
        allocators,
        position_first,
        variations,
        times_and_references,
        by_hand.parts_in_python,
        endings,
        by_hand.stepped,
        by_hand.plants,
    )
    for name, flight in some()
}


def main(arguments: list[str]) -> str | None:
    """Write the values anew, or compare them; return what is wrong."""
    flown = {name: values_of(flight()) for name, flight in FLIGHTS.items()}
    kept = kept_values() if VALUES.is_file() else {}
    changed = [
        f"{name}: {', '.join(columns)}"
        for name in {**kept, **flown}
        if (columns := differing(flown.get(name, {}), kept.get(name, {})))
    ]
    if arguments == ["--check"] and changed:
        return "\n".join(["These flights differ:", *changed])
    if arguments == ["--check"]:
        used = om.fly_many(scenario(), 1).performance.instruction_set
        print(f"All flights are as before, with {used}.")
        return None
    VALUES.write_text(as_file(flown), encoding="utf-8")
    print(f"{len(flown)} flights; {len(changed)} are new, gone or not as before.")
    return None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
