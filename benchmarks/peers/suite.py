"""All comparisons with peers: solvers on the same problems, simulators on equal work, in turns."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, chdir, contextmanager
from functools import partial
from multiprocessing import get_context
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.peers import crazyflow_loop, mujoco_loop, rotorpy_loop
from benchmarks.peers import quadrotor as q
from benchmarks.peers.limits import what_peers_cannot_run
from benchmarks.peers.missing import NotInstalled, quiet
from benchmarks.peers.recorded_problems import Problem, recorded_problems
from benchmarks.peers.solvers import SOLVERS, Answers, Solve, exact_answers, solve_all
from omnimorph.bench.batches import omnimorphs_per_s
from omnimorph.bench.measurement import BenchReport, Measurement
from omnimorph.bench.provenance import provenance_of_machine
from omnimorph.machine.children import end_with
from omnimorph.protocols import FloatArray

__all__ = ["away", "measure_peers"]

_SIMULATORS: dict[str, Callable[[q.Loop], q.Timed]] = {
    "omnimorph": q.ours,
    "mujoco": mujoco_loop.fly,
    "crazyflow": crazyflow_loop.fly,
    "rotorpy": rotorpy_loop.fly,
}
_PEERS = ("osqp", "proxsuite", "casadi", "mujoco", "crazyflow", "jax", "rotorpy", "torch")
_LOOPS = tuple(q.Loop(n, closed) for n in (1, q.BATCH) for closed in (False, True))
_NOT_THERE = {  # (simulator, loop): what it does not have
    ("omnimorph", q.Loop(q.BATCH, False)),  # a batch always flies with its controller
    *(("mujoco", loop) for loop in _LOOPS if loop.closed),  # it brings none
}


def measure_peers(
    progress: Callable[[int, int], None] | None = None, *, rounds: int = 3
) -> BenchReport:
    """Compare with what users would take instead; about a minute a round.

    Parameters
    ----------
    progress : callable, optional
        Called after each part with the number done and the number of all.
    rounds : int
        How often each number is measured; peers take turns in each.

    Returns
    -------
    BenchReport
        Times beside accuracy; `notes` name what is not installed and what peers cannot run.
    """
    notes: list[str] = []
    parts = rounds * (1 + len(_SIMULATORS)) + 1
    done = 0

    def tell() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done, parts)

    # Crazyflow wants this before SciPy is imported, which it is in the processes begun below.
    os.environ.setdefault("SCIPY_ARRAY_API", "1")
    solved: dict[str, list[Answers]] = {}
    timed: dict[tuple[str, q.Loop], list[q.Timed]] = {}
    omnimorphs: list[float] = []
    problems = recorded_problems()
    exact = exact_answers(problems)
    with away(_SIMULATORS) as pools:
        with quiet():
            notes += what_peers_cannot_run()
        tell()
        for _ in range(rounds):
            for name, (_, make) in SOLVERS.items():
                with quiet():  # qpOASES introduces itself
                    found = _measured(notes, partial(_solved_by, make, problems, exact))
                solved.setdefault(name, []).extend(found)
            tell()
            omnimorphs.append(omnimorphs_per_s())
            for name, fly in _SIMULATORS.items():
                for loop in _LOOPS:
                    if (name, loop) in _NOT_THERE:
                        continue
                    flying = pools[name].submit(fly, loop)
                    timed.setdefault((name, loop), []).extend(_measured(notes, flying.result))
                tell()
    rows = [*_solver_rows(solved), *_simulator_rows(timed), *_ratio_rows(timed, omnimorphs)]
    unique = tuple(dict.fromkeys(notes))
    return BenchReport(measurements=rows, provenance=provenance_of_machine(_PEERS), notes=unique)


@contextmanager
def away(names: Iterable[str]) -> Iterator[dict[str, ProcessPoolExecutor]]:
    """Work in a folder that is removed afterwards; give a process there for each name.

    Some peers leave a log where they are run. The processes are kept for all rounds: peers differ
    in what they need of one another's libraries, and their threads rest while others run.
    """
    spawn = get_context("spawn")
    with TemporaryDirectory() as folder, chdir(folder), ExitStack() as stack:
        begin = (_begin, (os.getpid(), folder))
        yield {name: stack.enter_context(ProcessPoolExecutor(1, spawn, *begin)) for name in names}


def _begin(parent: int, folder: str) -> None:
    """Begin a process of `away`: a spawned one starts where the user stands."""
    end_with(parent)
    os.chdir(folder)


def _solved_by(
    make: Callable[[], Solve], problems: list[Problem], exact: list[FloatArray]
) -> Answers:
    return solve_all(make(), problems, exact)


def _measured(notes: list[str], measure: Callable[[], Any]) -> list[Any]:
    """Return what was measured, in a list; nothing, and a note why, where a peer is missing."""
    try:
        return [measure()]
    except NotInstalled as missing:
        notes.append(str(missing))
        return []


def _row(name: str, what: str, unit: str, samples: list[float]) -> Measurement:
    return Measurement(name=name, what=what, unit=unit, samples=tuple(samples))


def _solver_rows(solved: dict[str, list[Answers]]) -> Iterator[Measurement]:
    for package, rounds in solved.items():
        if not rounds:
            continue
        what = SOLVERS[package][0]
        name = f"qp_{package}"
        for quantile, word in ((50, "median"), (99, "99 of 100 problems take less")):
            yield _row(
                f"{name}_p{quantile}_us",
                f"recorded allocation problem, {what}: {word}",
                "µs",
                [1e6 * float(np.percentile(one.seconds, quantile)) for one in rounds],
            )
        yield _row(
            f"{name}_error_percent",
            "the same: largest error of a thrust, of the largest thrust",
            "%",
            [100.0 * float(one.errors.max()) for one in rounds],
        )
        yield _row(
            f"{name}_wrong",
            "the same: called solved, but more than 0.1 % off, of 2 000",
            "problems",
            [float(one.wrong) for one in rounds],
        )


def _simulator_rows(timed: dict[tuple[str, q.Loop], list[q.Timed]]) -> Iterator[Measurement]:
    truth = q.final_position()
    for (name, loop), rounds in timed.items():
        if not rounds:
            continue
        many = f"{loop.vehicles} quadrotors" if loop.vehicles > 1 else "one quadrotor"
        how = "with its own controller" if loop.closed else "constant rotor speeds"
        key = f"{name}_{'closed' if loop.closed else 'open'}_{loop.vehicles}"
        rate = [loop.vehicles * q.STEPS / one.seconds for one in rounds]
        yield _row(f"{key}_steps_per_s", f"{name}: {many}, {how}, 2 ms", "steps/s", rate)
        yield _row(
            f"{key}_rotor_steps_per_s", "the same", "rotor-steps/s", [4.0 * value for value in rate]
        )
        if rounds[0].warm_up > 0.5:
            yield _row(f"{key}_warm_up_s", "before it runs", "s", [one.warm_up for one in rounds])
        if not loop.closed:
            off = [float(np.linalg.norm(one.position - truth)) for one in rounds]
            yield _row(f"{key}_error_m", "error of its position after 1 s", "m", off)


def _ratio_rows(
    timed: dict[tuple[str, q.Loop], list[q.Timed]], omnimorphs: list[float]
) -> Iterator[Measurement]:
    many = q.Loop(q.BATCH, True)
    yield _row(
        "omnimorphs_closed_1024_steps_per_s",
        "omnimorph: 1024 OmniMorphs, three QPs in every step",
        "steps/s",
        omnimorphs,
    )
    yield _row(
        "omnimorphs_closed_1024_rotor_steps_per_s",
        "the same",
        "rotor-steps/s",
        [8.0 * rate for rate in omnimorphs],
    )
    for name, target in (("crazyflow", 2.0), ("rotorpy", 150.0)):
        rounds = timed.get((name, many), [])
        ratios = [
            rate * one.seconds / (q.BATCH * q.STEPS)
            for rate, one in zip(omnimorphs, rounds, strict=False)
        ]
        if ratios:
            yield Measurement(
                name=f"omnimorphs_over_{name}",
                what=f"1024 OmniMorphs over {name}'s 1024 quadrotors, in turns",
                unit="times",
                samples=tuple(ratios),
                target=target,
                aim="at least",
            )
