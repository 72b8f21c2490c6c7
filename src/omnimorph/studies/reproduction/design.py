"""What the paper says of the vehicle before it flies: ranks, matrix, sets of forces, mass."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from omnimorph.analysis import actuation, mass_break_even, mechanism_share
from omnimorph.analysis.overview import VehicleAnalysis, analyze
from omnimorph.design.files import load_vehicle
from omnimorph.design.vehicle import Vehicle
from omnimorph.model.allocation import full_allocation_matrix
from omnimorph.protocols import FloatArray
from omnimorph.studies.reproduction import paper
from omnimorph.studies.reproduction.printed_matrix import PrintedMatrix, compare_printed_matrix
from omnimorph.studies.reproduction.verdicts import Basis, Judged, judge

VEHICLE = "omnimorph"
_ANALYZE = f"omnimorph analyze {VEHICLE}"
_ERRATA = "pytest tests/paper/test_errata.py"
_ACTUATION = "pytest tests/physics/test_actuation.py"


@dataclass(frozen=True, kw_only=True)
class CounterExample:
    """Thrusts that distinguish two conditions on rank F."""

    tilt: float  # rad
    thrusts: str  # in words
    paper: int  # rank that the paper's condition gives
    ours: int  # rank of F, computed
    condition: str  # what decides it


@dataclass(frozen=True, kw_only=True, eq=False)
class Design:
    """The vehicle, analysed and set beside the paper."""

    analysis: VehicleAnalysis
    matrix: PrintedMatrix
    examples: tuple[CounterExample, ...]
    judged: list[Judged]

    def as_dict(self) -> dict[str, Any]:
        """Return what ``results.json`` holds of it."""
        analysis = self.analysis
        free, zero = (
            getattr(analysis.omnidirectional, f"{name}_moment_beyond") for name in ("free", "zero")
        )
        trade = analysis.trade
        assert trade is not None
        return {
            "misprints": [list(place) for place in self.matrix.misprints],
            "rotor_of_column": list(self.matrix.rotors),
            "counter_examples": [vars(example) for example in self.examples],
            "singular_tilts_deg": [math.degrees(one.tilt) for one in analysis.singular],
            "omnidirectional_free_moment_deg": np.degrees(free).tolist(),
            "omnidirectional_zero_moment_deg": np.degrees(zero).tolist(),
            "level_hover_deg": np.degrees(analysis.omnidirectional.level_beyond).tolist(),
            "mechanism_share": trade.own,
            "break_even_tilt_deg": math.degrees(trade.break_even or math.nan),
            "break_even_tilt_in_wakes_deg": math.degrees(trade.break_even_in_wakes or math.nan),
        }


def examine_design() -> Design:
    """Analyse the paper's vehicle and judge what the paper says of it."""
    vehicle = load_vehicle(VEHICLE)
    half_edge = float(np.abs(vehicle.rotor_position).max())
    analysis = analyze(vehicle)
    matrix = compare_printed_matrix(vehicle, half_edge)
    examples = _counter_examples(vehicle)
    judged = [
        *_judge_ranks(vehicle, analysis),
        *_judge_conditions(vehicle, examples),
        _judge_matrix(matrix),
        _judge_axes(vehicle),
        *_judge_intervals(vehicle, analysis),
        *_judge_mass(vehicle, analysis),
    ]
    return Design(analysis=analysis, matrix=matrix, examples=examples, judged=judged)


# --- actuation ------------------------------------------------------------------------------------


def _counter_examples(vehicle: Vehicle) -> tuple[CounterExample, ...]:
    """Return thrusts for which the paper's conditions on rank F give another rank."""
    upper = vehicle.rotor_position[:, 2] > 0.0
    layers = np.where(upper, 1.0, 2.0)
    pairs = np.where(upper, 1.0, -1.0)
    equal, alone = np.ones(len(upper)), np.eye(len(upper))[0]
    right = 0.5 * math.pi
    leaning, summed = "Σ f h ≠ 0, h where a rotor leans to", "Σ f ≠ 0"
    rows = (
        (0.0, "all equal", equal, 4, leaning),
        (0.0, "upper rotors 1 N, lower rotors 2 N", layers, 5, leaning),
        (0.0, "one rotor alone", alone, 5, leaning),
        (right, "upper rotors 1 N, lower rotors −1 N", pairs, 6, summed),
        (right, "one rotor alone", alone, 6, summed),
    )
    return tuple(
        CounterExample(
            tilt=tilt,
            thrusts=name,
            paper=claimed,
            ours=actuation(vehicle, tilt, thrust, beyond_limits=True).rank_full,
            condition=condition,
        )
        for tilt, name, thrust, claimed, condition in rows
    )


def _judge_ranks(vehicle: Vehicle, analysis: VehicleAnalysis) -> list[Judged]:
    right = float(paper.claims()["rank_at_90"].about["tilt_deg"])
    ranks = {
        "rank_at_0": actuation(vehicle, 0.0).rank_thrust,
        "rank_at_90": actuation(vehicle, math.radians(right), beyond_limits=True).rank_thrust,
        "rank_elsewhere": int(analysis.sweep.rank_thrust[1:-1].min()),
    }
    found = ", ".join(f"{math.degrees(one.tilt):.0f}°" for one in analysis.singular)
    why = f"Over a full rotation of the tilt the rank falls at {found.replace('-', '−')} only."
    return [
        judge(key, here=rank, basis=Basis.DERIVED, why=why, command=_ANALYZE)
        for key, rank in ranks.items()
    ]


def _judge_conditions(vehicle: Vehicle, examples: tuple[CounterExample, ...]) -> list[Judged]:
    judged = []
    for key, tilt in (("full_rank_at_0", 0.0), ("full_rank_at_90", 0.5 * math.pi)):
        here = [one for one in examples if one.tilt == tilt]
        wrong = [one for one in here if one.ours != one.paper]
        found = "; ".join(f"{one.thrusts}: rank {one.ours}, not {one.paper}" for one in wrong)
        why = f"The rank is that high if and only if {here[0].condition}."
        command = f"{_ACTUATION}::test_conditions_of_omnimorph"
        judged.append(_statement(key, not wrong, found, why, command))
    still = vehicle.replace(drag_coefficient=1e-9 * vehicle.drag_coefficient)
    right = 0.5 * math.pi
    rank = actuation(still, right, beyond_limits=True).rank_thrust
    torques = full_allocation_matrix(still, np.ones(still.n_rotors), right)[3:5, : still.n_rotors]
    both = int(np.linalg.matrix_rank(torques, tol=1e-6))
    found = f"without drag the rank of A stays {rank}, that of its roll and pitch rows {both}"
    why = "They come from the lever arms of the rotors above and below the centre of mass."
    command = f"{_ERRATA}::test_at_90_degrees_roll_and_pitch_come_from_lever_arms"
    return [*judged, _statement("roll_from_drag", both != 2, found, why, command)]


def _judge_matrix(matrix: PrintedMatrix) -> Judged:
    wrong = matrix.misprints
    places = ", ".join(f"({row}, {column})" for row, column in wrong)
    count = sum(len(row) for row in matrix.entries)
    found = (
        f"{len(wrong)} of {count} entries are misprinted: {places}, row and column from 1"
        if wrong
        else "no misprint"
    )
    why = (
        "Only otherwise are the torques the moments of the printed thrust axes and of their drag; "
        "its columns are not in the order of eq. (1), and its L is a half-edge."
    )
    command = f"{_ERRATA}::test_four_entries_of_the_printed_matrix_are_wrong"
    return _statement("printed_matrix", not wrong, found, why, command)


def _judge_axes(vehicle: Vehicle) -> Judged:
    """Compare thrust axes at atan √2 with the fixed vehicle's, turned; rotors may be flipped."""
    turn = math.radians(paper.claims()["turned_axes"].about["turn_deg"])
    a, b, c = 0.5 + 1 / math.sqrt(12), 0.5 - 1 / math.sqrt(12), 1 / math.sqrt(3)
    fixed = np.array(
        [
            [-a, b, -b, a, a, -b, b, -a],
            [b, a, -a, -b, -b, -a, a, b],
            [c, -c, -c, c, c, -c, -c, c],
        ]
    )
    about_z = np.array(
        [[math.cos(turn), -math.sin(turn), 0], [math.sin(turn), math.cos(turn), 0], [0, 0, 1]]
    )
    tilt = math.atan(math.sqrt(2.0))
    z0, zC, zS = vehicle.thrust_axis_parts
    axes = (z0 + zC * math.cos(tilt) + zS * math.sin(tilt)).T
    ours = axes[:, _by_vertex(vehicle)]
    apart = float(np.abs(np.abs((about_z @ fixed * ours).sum(axis=0)) - 1.0).max())
    found = f"at {math.degrees(tilt):.4f}° the axes are those, turned: identical to rounding"
    why = "Four axes point in the opposite direction, the same for bi-directional rotors."
    return _statement("turned_axes", apart < 1e-12, found, why, "omnimorph verify")


def _by_vertex(vehicle: Vehicle) -> list[int]:
    """Return our rotors in the order of eq. (1): x alternates first, then y, then z, from +."""
    signs = np.sign(vehicle.rotor_position)
    return [int(i) for i in np.lexsort((-signs[:, 0], -signs[:, 1], -signs[:, 2]))]


# --- sets of forces -------------------------------------------------------------------------------


def _judge_intervals(vehicle: Vehicle, analysis: VehicleAnalysis) -> list[Judged]:
    found = analysis.omnidirectional
    free, zero = (
        np.degrees(_first_positive(intervals))
        for intervals in (found.free_moment_beyond, found.zero_moment_beyond)
    )
    level = np.degrees(found.level_beyond)
    lost = float(max(high for low, high in level if low <= 0.0 <= high))
    limit = float(vehicle.thrust_max.max())
    why = (
        f"The limit of thrust, {limit:.4f} N, is not published; it was solved from the first of "
        "these tilts, with free moments. Its other two tilts then follow from the same number."
    )
    rows = (
        (
            "omnidirectional_from",
            free[0],
            f"{free[0]:.2f}° with free moments, {zero[0]:.2f}° at "
            "zero moment, which hovering needs",
        ),
        (
            "omnidirectional_to",
            free[1],
            f"{free[1]:.2f}° with free moments, {zero[1]:.2f}° at zero moment",
        ),
        ("hover_lost_at", lost, f"level hover is lost at {lost:.2f}°"),
    )
    return [
        judge(key, here=value, basis=Basis.CHOSEN, found=found, why=why, command=_ANALYZE)
        for key, value, found in rows
    ]


def _first_positive(intervals: FloatArray) -> FloatArray:
    return np.asarray(min((one for one in intervals if one[0] > 0.0), key=lambda one: one[0]))


# --- mass -----------------------------------------------------------------------------------------


def _judge_mass(vehicle: Vehicle, analysis: VehicleAnalysis) -> list[Judged]:
    judged = []
    for key in ("break_even_20", "break_even_30"):
        share = 100.0 * float(mass_break_even(math.radians(paper.claims()[key].about["tilt_deg"])))
        why = "Closed form: thrusts go with 1/cos α_f at the same mass, so Δ̄_m = 1/cos α_f − 1."
        command = "pytest tests/physics/test_morphing.py::test_mass_break_even"
        judged.append(judge(key, here=share, basis=Basis.DERIVED, why=why, command=command))
    own, trade = mechanism_share(vehicle), analysis.trade
    assert own is not None
    assert trade is not None
    assert trade.break_even is not None
    named = math.radians(paper.claims()["own_mechanism_pays"].about["tilt_deg"])
    pays = float(mass_break_even(named)) >= own
    wakes = trade.break_even_in_wakes
    found = (
        f"its mechanism is {100 * own:.2f} % of the other mass, which pays beside a vehicle fixed "
        f"beyond {math.degrees(trade.break_even):.2f}°"
    )
    if wakes is not None:
        found += (
            f"; with the interference that the paper measures, beyond {math.degrees(wakes):.1f}°"
        )
    needed = paper.claims()["omnidirectional_from"].value
    why = f"From 1/cos α_f − 1 and the two masses; at the {needed:g}° it needs, it does pay."
    command = f"{_ERRATA}::test_at_30_degrees_its_mechanism_does_not_pay"
    return [*judged, _statement("own_mechanism_pays", pays, found, why, command)]


def _statement(key: str, holds: bool, found: str, why: str, command: str) -> Judged:
    return judge(key, holds=holds, basis=Basis.DERIVED, found=found, why=why, command=command)
