"""The rows of the table: what each number is, its unit and what we aim at."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from omnimorph.bench.analysis import AnalysisTimes, RadiusTimes
from omnimorph.bench.batches import BatchTimes
from omnimorph.bench.flights import JOINTLY, ControlTimes, LoopTimes
from omnimorph.bench.measurement import Measurement
from omnimorph.bench.processes import ProcessCost


class Round(NamedTuple):
    """What one round measured."""

    loops: LoopTimes
    batches: BatchTimes
    control: ControlTimes
    joint: tuple[float, ...]
    python_loop: float
    radii: RadiusTimes
    analysis: AnalysisTimes
    flight: ProcessCost
    analysis_page: ProcessCost
    importing: ProcessCost
    help: ProcessCost


def rows_of(done: list[Round], warm_up: float) -> tuple[Measurement, ...]:
    """Return every row, made of what all rounds measured; `warm_up` (s) is that of the first."""
    return (
        *_loop_rows(done, warm_up),
        *_batch_rows(done),
        *_python_rows(done),
        *_radius_rows([one.radii for one in done]),
        *_sampling_rows([one.radii for one in done]),
        *_analysis_rows(done),
        *_process_rows(done),
    )


def _row(
    name: str,
    what: str,
    unit: str,
    samples: list[float],
    at_most: float | None = None,
    at_least: float | None = None,
) -> Measurement:
    one = Measurement(name=name, what=what, unit=unit, samples=tuple(samples), target=at_most)
    return one if at_least is None else replace(one, target=at_least, aim="at least")


def _loop_rows(done: list[Round], warm_up: float) -> list[Measurement]:
    loops = [one.loops for one in done]
    rate = "steps/s"
    return [
        _row(
            "core_case_a_steps_per_s",
            "one vehicle, Case A, perfect plant, three QPs at every 1 kHz step, recorded",
            rate,
            [one.core_case_a for one in loops],
            at_least=1.5e6,
        ),
        _row(
            "core_case_b_steps_per_s",
            "the same of Case B",
            rate,
            [one.core_case_b for one in loops],
            at_least=1.5e6,
        ),
        _row(
            "whole_call_case_a_steps_per_s",
            "Case A as fly(...) is called: setting up and the Run included",
            rate,
            [one.whole_call_case_a for one in loops],
        ),
        _row(
            "textbook_steps_per_s",
            "the first 0.25 s of Case A in the textbook (NumPy and DAQP)",
            rate,
            [one.textbook for one in loops],
        ),
        _row(
            "core_over_textbook",
            "Case A: core over textbook, in turns",
            "times",
            [one.core_case_a / one.textbook for one in loops],
            at_least=200.0,
        ),
        _row(
            "core_textbook_difference_m",
            "largest difference in position over those 0.25 s",
            "m",
            [one.difference for one in loops],
            1e-11,
        ),
        _row(
            "realistic_flight_s",
            "45 s of Case A in the realistic plant, control at 250 Hz, recorded",
            "s",
            [one.realistic for one in loops],
        ),
        _row("first_round_s", "the first round of all these, before any counted", "s", [warm_up]),
    ]


def _batch_rows(done: list[Round]) -> list[Measurement]:
    batches = [one.batches for one in done]
    rate = "steps/s"
    return [
        _row(
            "many_perfect_steps_per_s",
            "1024 OmniMorphs, perfect plant, three QPs at every 1 kHz step, on all cores",
            rate,
            [one.perfect for one in batches],
            at_least=5e6,
        ),
        _row(
            "many_over_textbook",
            "the same over the textbook's one vehicle, in turns",
            "times",
            [one.batches.perfect / one.loops.textbook for one in done],
            at_least=1000.0,
        ),
        _row(
            "many_perfect_float32_steps_per_s",
            "the same in single precision",
            rate,
            [one.single_precision for one in batches],
        ),
        _row(
            "many_threads_gain",
            f"the same on all cores ({batches[0].threads} threads) over one thread",
            "times",
            [one.perfect / one.one_thread for one in batches],
            at_least=0.9 * batches[0].threads,
        ),
        _row(
            "many_worn_steps_per_s",
            "1024 OmniMorphs, every imperfection on, control at 250 Hz, on all cores",
            rate,
            [one.worn for one in batches],
            at_least=4e6,
        ),
        _row(
            "many_realistic_flights_per_s",
            "flights of 45 s in the realistic plant, on all cores; 10 000 in 150 s are 66.7",
            "flights/s",
            [one.whole_flights for one in batches],
            at_least=10_000 / 150.0,
        ),
        _row(
            "many_largest_over_smallest",
            "time a vehicle in a batch of 16 384 over one of 256",
            "times",
            [one.largest_over_smallest for one in batches],
            1.15,
        ),
    ]


def _python_rows(done: list[Round]) -> list[Measurement]:
    return [
        _row(
            "control_step_us",
            "one control step called from Python, thrust and tilt read: median",
            "µs",
            [1e6 * one.control.median for one in done],
            3.0,
        ),
        _row(
            "control_step_p99_us",
            "the same: 99 of 100 steps take less",
            "µs",
            [1e6 * one.control.almost_all for one in done],
        ),
        _row(
            "control_step_in_core_us",
            "the same steps in one call, in the core alone: mean",
            "µs",
            [1e6 * one.control.in_core for one in done],
            0.6,
        ),
        *(
            _row(
                f"joint_step_{vehicle.replace('-', '_')}_us",
                f"the same with thrusts and tilts at once, {vehicle} on its tour: median",
                "µs",
                [1e6 * one.joint[k] for one in done],
                target,
            )
            for k, (vehicle, target) in enumerate(zip(JOINTLY, (1.5, 3.0, 8.0), strict=True))
        ),
        _row(
            "python_controller_steps_per_s",
            "flying with a trivial controller written in Python",
            "steps/s",
            [one.python_loop for one in done],
            at_least=30e3,
        ),
    ]


def _radius_rows(radii: list[RadiusTimes]) -> list[Measurement]:
    times: tuple[tuple[str, str, list[float], float | None], ...] = (
        (
            "free_moment_radius_us",
            "largest force in every direction, moments free: exact, each call at a new tilt",
            [one.free for one in radii],
            100.0,
        ),
        (
            "free_moment_radius_by_grid_us",
            "the same by the hull of the forces of 3⁸ thrusts, in turns",
            [one.grid.time for one in radii],
            None,
        ),
        (
            "free_moment_radius_by_random_us",
            "the same by that of 10⁵ random thrusts, in turns",
            [one.drawn.time for one in radii],
            None,
        ),
        (
            "zero_moment_radius_us",
            "largest force in every direction without a moment: exact",
            [one.zero for one in radii],
            2000.0,
        ),
        (
            "zero_moment_radius_by_random_us",
            "the same by random thrusts that leave at most 1 % of the largest moment",
            [one.drawn_zero.time for one in radii],
            None,
        ),
        (
            "zero_moment_radius_by_projection_us",
            "the same by random thrusts, projected on those that make no moment",
            [one.projected.time for one in radii],
            None,
        ),
    )
    return [
        _row(name, what, "µs", [1e6 * seconds for seconds in samples], target)
        for name, what, samples, target in times
    ]


def _sampling_rows(radii: list[RadiusTimes]) -> list[Measurement]:
    errors = (
        (
            "free_moment_grid_error_percent",
            "error of the grid's radius: the corners are in the grid, so it is exact as well",
            [one.grid.error for one in radii],
        ),
        (
            "free_moment_random_error_percent",
            "error of the random thrusts' radius",
            [one.drawn.error for one in radii],
        ),
        (
            "zero_moment_random_error_percent",
            "error at zero moment of those with little moment; 100 if too few are left for a hull",
            [one.drawn_zero.error for one in radii],
        ),
        (
            "zero_moment_projection_error_percent",
            "error at zero moment of those projected",
            [one.projected.error for one in radii],
        ),
    )
    rows = [
        _row(name, what, "%", [100.0 * error for error in samples])
        for name, what, samples in errors
    ]
    left = [one.drawn_zero.used for one in radii]
    what = "random thrusts that leave at most 1 % of the largest moment, of 10⁵"
    rows.append(_row("zero_moment_random_left", what, "thrusts", left))
    return rows


def _analysis_rows(done: list[Round]) -> list[Measurement]:
    return [
        _row(
            "tilt_sweep_s",
            "ranks, radii, lift and least power at 181 tilts",
            "s",
            [one.analysis.sweep for one in done],
            2.0,
        ),
        _row(
            "hover_map_s",
            "least hover power in 100 attitudes at 61 tilts",
            "s",
            [one.analysis.hover_map for one in done],
            10.0,
        ),
        _row(
            "cold_analysis_page_s",
            "`omnimorph analyze omnimorph --out DIR` from a cold process, page and figures written",
            "s",
            [one.analysis_page.wall for one in done],
            4.0,
        ),
        _row(
            "cold_analysis_page_MB",
            "its peak memory",
            "MB",
            [one.analysis_page.memory for one in done],
        ),
    ]


def _process_rows(done: list[Round]) -> list[Measurement]:
    return [
        _row(
            "cold_flight_s",
            "`omnimorph fly paper-case-a` from a cold process, files written",
            "s",
            [one.flight.wall for one in done],
            1.5,
        ),
        _row("cold_flight_MB", "its peak memory", "MB", [one.flight.memory for one in done], 150.0),
        _row(
            "import_s",
            "`python -c 'import omnimorph'`, Python's own start included",
            "s",
            [one.importing.wall for one in done],
            0.25,
        ),
        _row("help_s", "`omnimorph --help`", "s", [one.help.wall for one in done], 0.35),
    ]
