"""The kinds of files there are: good ones of each, what is made of them, and what reads them."""

from __future__ import annotations

import io
import json
import math
import tomllib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import cache
from importlib import resources
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import h5py
import numpy as np
from tests.fuzz.mutations import NUMBERS, as_toml, mutated_bytes, mutated_text, mutated_tree
from tests.physics.small_vehicles import random_tilting_vehicle, random_vehicle

import omnimorph as om
from omnimorph.design import parse_vehicle, vehicle_text
from omnimorph.design.keys import OF_VEHICLES
from omnimorph.reference.samples import SampledReference
from omnimorph.reference.segments import Segment, SegmentReference
from omnimorph.report.analysis_data import analysis_data
from omnimorph.report.fit_data import fit_data
from omnimorph.results import store
from omnimorph.results.curves import phases
from omnimorph.results.run import Provenance
from omnimorph.results.saving import ATTRIBUTES, hash_of

_MOST_ROWS = 1_000  # of a flight that is flown here


class Kind(NamedTuple):
    """One kind of file.

    Attributes
    ----------
    name : str
        The end of its files' names.
    make : callable
        Gives the bytes of a case, which may be good or bad.
    use : callable
        Reads a file and does with it what its users do.
    """

    name: str
    make: Callable[[Random], bytes]
    use: Callable[[Path], object]


# --- files of TOML --------------------------------------------------------------------------------


@cache
def trees(folder: str) -> list[dict[str, Any]]:
    """Return the files of a catalogue as trees."""
    room, _, name = folder.partition("/")
    entries = resources.files(f"omnimorph.{room}").joinpath(name).iterdir()
    files = sorted((entry for entry in entries if entry.name.endswith(".toml")), key=str)
    return [tomllib.loads(file.read_text(encoding="utf-8")) for file in files]


def tree_of(documents: list[dict[str, Any]]) -> Callable[[Random], bytes]:
    """Return what makes bad files of these; one in ten is bad already as a text."""

    def make(rng: Random) -> bytes:
        text = as_toml(mutated_tree(rng.choice(documents), documents, rng)).encode()
        return mutated_bytes(text, rng) if rng.random() < 0.1 else text

    return make


def use_vehicle(path: Path) -> None:
    vehicle = om.load_vehicle(path)
    again = om.analysis.hover(vehicle, vehicle.servo_angle_min)
    assert again.tilt.shape == (vehicle.n_servos,)
    assert np.isfinite(om.allocation_matrix(vehicle, vehicle.servo_angle_max)).all()
    assert parse_vehicle(vehicle_text(vehicle), "again.toml").n_rotors == vehicle.n_rotors


def use_scenario(path: Path) -> None:
    fly_a_little(om.load_scenario(path))


def use_plant(path: Path) -> None:
    fly_a_little(replace(hovering(), plant=om.load_plant(path)))


@cache
def hovering() -> om.Scenario:
    return om.load_scenario("hover")


def fly_a_little(scenario: om.Scenario) -> None:
    """Fly a scenario if that is soon done, else its first moments."""
    reference = scenario.reference
    if reference.duration / scenario.plant.physics_step > _MOST_ROWS:
        start = reference(0.0)
        rest = Segment(max(100.0 * scenario.plant.physics_step, 1e-6))
        reference = SegmentReference(start.p_WB, start.R_WB, [rest])
    run = om.fly(replace(scenario, reference=reference))
    assert run.metrics.outcome in om.Outcome.__members__ or run.metrics.as_dict()


def use_parts(path: Path) -> None:
    body = om.identification.assemble(om.identification.load_parts(path))
    assert np.isfinite(body.inertia).all()
    assert body.is_solid in (True, False)


PARTS = {
    "part": [
        {"kind": "box", "mass_kg": 0.45, "size_m": [0.12, 0.08, 0.03], "name": "battery"},
        {"kind": "cylinder", "mass_kg": 0.05, "radius_m": 0.02, "length_m": 0.03,
         "inner_radius_m": 0.01, "position_m": [0.2, 0.0, 0.0]},
        {"kind": "point", "mass_kg": 0.1, "position_m": [0.0, 0.1, 0.0]},
        {"kind": "box", "mass_kg": 0.1, "size_m": [0.4, 0.01, 0.01],
         "orientation_deg": [0.0, 0.0, 45.0]},
    ]
}  # fmt: skip


# --- files of CSV ---------------------------------------------------------------------------------


@cache
def bench_texts() -> list[str]:
    """Return runs on a bench: steps of one rotor, and one that turns both ways."""
    rng, texts = np.random.default_rng(1), []
    for sides in ((1.0,), (1.0, -1.0)):
        command = np.repeat([s * w for s in sides for w in (40.0, 60.0, 90.0, 70.0)], 25)
        time = 0.01 * np.arange(len(command))
        speed = np.convolve(command, np.full(4, 0.25), mode="same") + rng.normal(0, 0.1, len(time))
        force, torque = 1e-3 * speed * np.abs(speed), 1e-5 * speed * np.abs(speed)
        rows = np.column_stack([time, speed, force, torque, command])
        lines = [",".join(f"{x:.6g}" for x in row) for row in rows]
        texts.append("\n".join(["time_s,speed_Hz,force_N,torque_Nm,command_Hz", *lines]))
        lines = [
            ",".join(f"{x:.6g}" for x in row) for row in rows[:, [0, 1, 1, 2, 3]] * [1, 1, 60, 1, 1]
        ]
        texts.append("\n".join(["time_s,speed_Hz,speed_rpm,force_N,torque_Nm", *lines]))
    return texts


def use_bench(path: Path) -> None:
    fit = om.identification.fit_rotor(om.identification.read_bench(path))
    json.dumps(fit_data(fit), allow_nan=False)


@cache
def reference_texts() -> list[str]:
    """Return references of poses, with attitudes and without."""
    half = 0.05 * np.arange(20)
    attitude = np.column_stack([np.cos(half), 0 * half, np.sin(half), 0 * half])
    position = np.column_stack([np.sin(half), np.cos(half), 1.0 + half])
    table = np.column_stack([0.02 * np.arange(20), position, attitude])
    names = ["time_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]
    return [
        "\n".join([",".join(names[:count]), *(",".join(map(repr, row)) for row in rows)])
        for count in (4, 8)
        for rows in [table[:, :count].tolist()]
    ]


def use_reference(path: Path) -> None:
    reference = SampledReference.from_csv(path)
    rows = reference.sample(np.linspace(0.0, reference.duration, 50))
    assert np.isfinite(rows).all()
    fly_a_little(replace(hovering(), reference=reference))


# --- runs -----------------------------------------------------------------------------------------


@cache
def run_bytes() -> bytes:
    """Return a short run as a file holds it."""
    scenario = om.load_scenario("hover")
    start = scenario.reference(0.0)
    short = SegmentReference(start.p_WB, start.R_WB, [Segment(0.02)])
    path = Path("good.nc")
    run = om.fly(replace(scenario, reference=short))
    replace(run, logged={"wind": om.LoggedColumn(0.5 * run.p_WB, "m/s")}).save(path)
    data = path.read_bytes()
    path.unlink()
    return data


def make_run(rng: Random) -> bytes:
    """Return a run damaged as bytes, or as HDF5 knows it: attributes and columns are others."""
    if rng.random() < 0.4:
        return mutated_bytes(run_bytes(), rng)
    whole = io.BytesIO(run_bytes())
    with h5py.File(whole, "r+") as file:
        for _ in range(rng.choice((1, 1, 2))):
            _change_run(file, rng)
        if rng.random() < 0.7:
            _sign_again(file)
    return whole.getvalue()


def _sign_again(file: Any) -> None:
    """Let the hash of a changed run be right, if it can be: what else is wrong must be reported."""
    with suppress(Exception):
        reported = {name: store._attribute("", file, key) for key, name in ATTRIBUTES.items()}
        provenance = Provenance(**reported)
        outcome = store._outcome("", file)
        columns, logged = store._columns("", file), store._logged(file, store.SCHEMA_VERSION)
        hash_now = hash_of(columns, logged, outcome, provenance)
        file.attrs["content_hash"] = hash_now


def _change_run(file: Any, rng: Random) -> None:
    segments = '{"reference": {"segment": [3, {"duration_s": "x"}]}}'
    texts = ("", "x" * 1000, "[" * 20_000, segments, "[]")
    odd = rng.choice((*NUMBERS, 2**63 - 1, *texts, *texts, [1.0, 2.0], b"\xff"))
    what, name = (
        rng.choice(("attribute", "gone", "column", "cells")),
        rng.choice(sorted(file.keys())),
    )
    attribute = rng.choice(sorted(file.attrs.keys()))
    if what == "attribute":
        file.attrs[attribute] = odd
    elif what == "gone" and rng.random() < 0.5:
        del file.attrs[attribute]
    elif what == "gone":
        del file[name]
    elif what == "column":
        del file[name]
        file[name] = rng.choice((odd, np.zeros((3, 3)), np.zeros(0), np.full(21, "x", dtype="S1")))
    elif isinstance(file[name], h5py.Dataset) and file[name].dtype.kind == "f":
        cells = file[name][...]
        cells.flat[: rng.randint(1, 3)] = rng.choice(NUMBERS)
        file[name][...] = cells


def use_run(path: Path) -> None:
    run = om.load_run(path)
    assert run.content_hash == run.provenance.content_hash
    assert isinstance(phases(run), list)
    run.metrics.as_dict()


# --- vehicles nobody thought of -------------------------------------------------------------------


def make_random_vehicle(rng: Random) -> bytes:
    """Return the file of a vehicle of any size and of any numbers that a file may have."""
    generator = np.random.default_rng(rng.randrange(2**32))
    n, m = rng.randint(1, 18), rng.choice((0, 0, 1, 1, rng.randint(1, 18)))
    vehicle = random_tilting_vehicle(generator, n, m) if m else random_vehicle(generator, n)
    vehicle = vehicle.replace(mass=n * rng.uniform(0.05, 0.4))
    tree = tomllib.loads(vehicle_text(vehicle))
    what = rng.choice(("as it is", "mutated", "anywhere in the ranges"))
    if what == "mutated":
        tree = mutated_tree(tree, [tree], rng)
    elif what == "anywhere in the ranges":
        for table in (tree, tree["rotor_defaults"], tree["filter"], *tree["rotor"]):
            _spread(table, rng)
    return as_toml(tree).encode()


def _spread(table: dict[str, Any], rng: Random) -> None:
    """Give some of a table's numbers any size that their ranges allow, all alike likely."""
    for key, value in table.items():
        if key in OF_VEHICLES and rng.random() < 0.3:
            limits, size = OF_VEHICLES[key], abs(value if isinstance(value, float) else 1.0)
            least = max(limits.least, 1e-6 * min(size or 1.0, 1.0))
            factor = math.exp(rng.uniform(math.log(least), math.log(limits.most))) / (size or 1.0)
            many = isinstance(value, list) and not isinstance(value[0], list)
            table[key] = [factor * one for one in value] if many else factor * size


def use_random_vehicle(path: Path) -> None:
    vehicle = om.load_vehicle(path)
    if vehicle.n_rotors <= 14:  # an analysis of 18 rotors that tilt computes for 23 s
        json.dumps(analysis_data(om.analysis.analyze(vehicle)), allow_nan=False)
    om.propose_controller(vehicle)
    fly_a_little(om.load_scenario("tour").for_vehicle(vehicle))


KINDS = {
    "vehicle": Kind("vehicle.toml", tree_of(trees("design/catalogue")), use_vehicle),
    "scenario": Kind("scenario.toml", tree_of(trees("simulation/scenarios")), use_scenario),
    "plant": Kind("plant.toml", tree_of(trees("simulation/plants")), use_plant),
    "parts": Kind("parts.toml", tree_of([PARTS]), use_parts),
    "bench": Kind("bench.csv", lambda rng: mutated_text(rng.choice(bench_texts()), rng), use_bench),
    "reference": Kind(
        "poses.csv", lambda rng: mutated_text(rng.choice(reference_texts()), rng), use_reference
    ),
    "run": Kind("run.nc", make_run, use_run),
    "random-vehicle": Kind("random.toml", make_random_vehicle, use_random_vehicle),
}
