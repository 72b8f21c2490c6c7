"""Fly a scenario many times at once: many vehicles in the lanes of a register, on every core."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.errors import ScenarioError
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.results.flights import BatchPerformance, Flights, Precision
from omnimorph.results.many_metrics import metrics_from_sums
from omnimorph.results.run import Run
from omnimorph.simulation.core_settings import core_settings_of
from omnimorph.simulation.fly_each import fly_each
from omnimorph.simulation.instruction_sets import INSTRUCTION_SET, batch_module
from omnimorph.simulation.parts import (
    AllocatorLike,
    AnyPlant,
    ControllerLike,
    DisturbanceLike,
    EstimatorLike,
    ReferenceLike,
    SensorsLike,
    with_parts,
)
from omnimorph.simulation.recording import OUTCOMES, FlownRows, as_run, bytes_of_flights
from omnimorph.simulation.scenario import Scenario
from omnimorph.simulation.scenario_files import ScenarioLike
from omnimorph.simulation.variation import Distribution, Variation, draw, numbers_of_a_flight
from omnimorph.simulation.whole_number import whole_number

_PATIENCE = 0.1  # s between two looks at whether the user wants to stop
_BYTES_OF_A_FLIGHT = 800  # without its trace: start, sums, metrics and outcome, with what is copied
_BYTES_OF_A_NUMBER = 24  # in which flights differ, with what is copied


def fly_many(
    scenario: ScenarioLike,
    n: int,
    *,
    seed: int = 0,
    first: int = 0,
    vary: Mapping[str, Distribution | ArrayLike] | None = None,
    keep: Iterable[int] | Literal["all"] = (),
    plant: AnyPlant | None = None,
    sensors: SensorsLike | None = None,
    estimator: EstimatorLike | None = None,
    controller: ControllerLike | None = None,
    allocator: AllocatorLike | None = None,
    reference: ReferenceLike | None = None,
    disturbance: DisturbanceLike | None = None,
    allow_code: bool = False,
    precision: Precision = "float64",
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Flights:
    """Fly a scenario n times, each flight with its own noise, parameters and start.

    Flight j of a seed is the same to the last bit alone (`fly` with ``flight=j``), in any batch, on
    any thread and with any instruction set. A Ctrl-C returns the flights that are finished.

    Parameters
    ----------
    scenario : Scenario, str or path
        What is flown, or its name or file.
    n : int
        How many flights.
    seed, first : int
        The flights are `first` … ``first + n − 1`` of this seed.
    vary : mapping, optional
        In what flights differ: a distribution (`Uniform`, `Normal`, any of ``scipy.stats``), whose
        numbers are drawn independently, or an array with a row for each flight. Any number of the
        scenario by its path (`paths`), such as ``vehicle.mass``, ``truth.thrust_coefficient[3]`` or
        ``controller.position``, in SI: each flight is that of `replaced` alone; an array of n
        numbers is one for all rotors. And these keys, which act upon what paths give:

        ``mass``, ``inertia``, ``thrust_coefficient``, ``drag_coefficient``
            The true vehicle's over what the controller believes; coefficients one a rotor.
        ``effectiveness``
            Share of its thrust that each rotor gives.
        ``centre_of_mass``
            Where the true one is, m in B, three numbers.
        ``rotor_lag``, ``noise``
            Factors of the plant's time constants and standard deviations.
        ``force``, ``torque``
            Constant, N in W and N m in B, beside the plant's own.
        ``start_position``, ``start_velocity``, ``start_attitude``, ``start_rate``
            Beside the reference's start: m and m/s in W, a rotation vector in rad and rad/s in B.
    keep : iterable of int, or "all"
        Numbers of the flights whose traces are kept.
    plant, sensors, estimator, controller, allocator, reference, disturbance : optional
        As `fly` takes them. Where any but the reference is an object of one's own, each flight is
        flown by itself, with a copy of the object, tens to hundreds of times slower; flights may
        then differ at paths alone, and not at those of what the object stands in for.
    allow_code : bool
        Whether code may run that a file or a text names.
    precision : "float64" or "float32"
        Single precision is about twice as fast. Over the catalogue's tours it is good to 40 µm and
        40 µrad; where a nearly constant cost leaves the tilt to rounding it is another flight
        (``docs/many-flights.md``).
    threads : int, optional
        All cores by default.
    progress : callable, optional
        Called now and then with the number of flights done and of all.

    Returns
    -------
    Flights
        Metrics of all, traces of those kept.

    Raises
    ------
    ScenarioError
        If `n` is not positive, if `vary` names what is not known or cannot vary in a batch, or
        gives an impossible scenario (the flight is named), if `keep` names a flight that is not
        among them.
    TooLargeError
        If the flights, or the traces of those kept, are more than memory holds.

    Examples
    --------
    >>> import omnimorph as om
    >>> flights = om.fly_many(om.load_scenario("hover"), 8, vary={"mass": om.Uniform(0.9, 1.1)})
    >>> len(flights), bool(flights.completed.all())
    (8, True)
    """
    scenario = with_parts(
        scenario,
        plant=plant,
        sensors=sensors,
        estimator=estimator,
        controller=controller,
        allocator=allocator,
        reference=reference,
        disturbance=disturbance,
        allow_code=allow_code,
    )
    seed = whole_number("fly_many", "seed", seed, 64)
    first = whole_number("fly_many", "first", first, 32)
    n = _positive("n", n, 2**32 - first)
    threads = _positive("threads", threads, 4096) if threads is not None else os.cpu_count() or 1
    if precision not in ("float64", "float32"):
        raise ScenarioError.at("fly_many", "precision", precision, "float64 or float32")
    vary = {} if vary is None else vary
    varied = numbers_of_a_flight(vary, scenario)
    _check_memory(scenario, n, 0, varied)  # of their numbers, before any are counted out
    kept = _kept(keep, first, n)
    _check_memory(scenario, n, len(kept), varied)
    variation = draw(vary, scenario, seed, first, n)
    if scenario.own.given():
        if precision != "float64":
            allowed = "float64, as parts of the loop are written in Python"
            raise ScenarioError.at("fly_many", "precision", precision, allowed)
        return fly_each(
            scenario,
            variation,
            seed=seed,
            first=first,
            kept=kept,
            threads=threads,
            progress=progress,
        )
    return _Batch(scenario, variation, kept, seed, first, precision, threads).fly(progress)


@dataclass(eq=False)
class _Batch:
    """Flights under way."""

    scenario: Scenario
    variation: Variation
    kept: Sequence[int]
    seed: int
    first: int
    precision: Precision
    threads: int

    def __post_init__(self) -> None:
        module, parts = batch_module(), core_settings_of(self.variation.flown)
        single, first = self.precision == "float32", self.first
        self.lanes = module.lanes * (2 if single else 1)
        self.threads = min(self.threads, math.ceil(self.variation.flights / self.lanes))
        self.began = perf_counter()
        self.core = module.start(
            **parts.of_flight(),
            flights=self.variation.flights,
            seed=self.seed,
            first=first,
            variation=self.variation.for_core(parts),
            recorded=[number - first for number in self.kept],
            single_precision=single,
            threads=self.threads,
        )

    def fly(self, progress: Callable[[int, int], None] | None) -> Flights:
        """Wait for the end, or for the user to interrupt; return what is finished."""
        core, n = self.core, self.variation.flights
        interrupted = False
        try:
            while not core.wait(_PATIENCE):
                if progress is not None:
                    progress(core.done, n)
        except KeyboardInterrupt:
            interrupted = True
        finally:
            core.stop()
            while not core.wait(_PATIENCE):
                pass
        wall_time = perf_counter() - self.began
        if progress is not None:
            progress(core.done, n)
        return self._flights(wall_time, interrupted)

    def _flights(self, wall_time: float, interrupted: bool) -> Flights:
        status = [_core.FlightStatus(code) for code in self.core.status()]
        finished = np.flatnonzero([one != _core.FlightStatus.FLYING for one in status])
        outcomes = [OUTCOMES[status[row]] for row in finished]
        sums = np.ascontiguousarray(self.core.sums()[finished].T)
        steps = sum(self.core.last_step(row) for row in finished.tolist())
        return Flights(
            number=self.first + finished,
            metrics=metrics_from_sums(
                dict(zip(batch_module().sum_names, sums, strict=True)),
                outcomes,
                physics_step=self.scenario.plant.physics_step,
                n_servos=self.scenario.vehicle.n_servos,
            ),
            varied={name: values[finished] for name, values in self.variation.drawn.items()},
            runs={
                number: self._run(number, status[number - self.first], wall_time)
                for number in self.kept
                if status[number - self.first] != _core.FlightStatus.FLYING
            },
            scenario_name=self.scenario.name,
            seed=self.seed,
            precision=self.precision,
            interrupted=interrupted,
            performance=BatchPerformance(
                wall_time=wall_time,
                vehicle_steps=steps,
                threads=self.threads,
                lanes=self.lanes,
                instruction_set=INSTRUCTION_SET,
            ),
        )

    def _run(self, number: int, status: _core.FlightStatus, wall_time: float) -> Run:
        """Return the trace of one flight; the time it took is its share of the whole batch's."""
        row = number - self.first
        scenario = self.variation.scenario_of(row)
        truth = scenario.plant.true_vehicle(scenario.vehicle)
        factor = self.variation.drawn.get("drag_coefficient")
        flown = FlownRows(
            columns=self.core.columns(row),
            rows=self.core.last_step(row) + 1,
            outcome=OUTCOMES[status],
            seed=self.seed,
            flight=number,
            wall_time=wall_time / self.variation.flights,
            drag_coefficient=truth.drag_coefficient * (1.0 if factor is None else factor[row]),
        )
        written: dict[str, Any] = {}
        if self.variation.drawn:
            written["vary"] = self.variation.of_flight(row)
        if self.precision == "float32":
            written["precision"] = self.precision
        return as_run(scenario, flown, written)


def _positive(name: str, value: object, most: int) -> int:
    """Return a whole number from 1 to `most`; refuse anything else."""
    allowed = f"a whole number from 1 to {most}"
    try:
        number = whole_number("fly_many", name, value, 33)
    except ScenarioError:
        number = 0
    if not 1 <= number <= most:
        raise ScenarioError.at("fly_many", name, value, allowed)
    return number


def _kept(keep: Iterable[int] | Literal["all"], first: int, n: int) -> Sequence[int]:
    """Return the numbers of the flights to be kept, in order."""
    if isinstance(keep, str):
        if keep != "all":
            raise ScenarioError.at("fly_many", "keep", keep, 'numbers of flights, or "all"')
        return range(first, first + n)
    allowed = f"numbers of flights from {first} to {first + n - 1}"
    numbers = set()
    try:
        for asked in keep:
            number = whole_number("fly_many", "keep", asked, 32)
            if not first <= number < first + n:
                raise ScenarioError.at("fly_many", "keep", number, allowed)
            numbers.add(number)
    except TypeError:
        raise ScenarioError.at("fly_many", "keep", keep, allowed) from None
    return sorted(numbers)


def _check_memory(scenario: Scenario, n: int, kept: int, varied: int) -> None:
    """Refuse flights whose numbers, as estimated, are more than memory holds."""
    of_a_flight = _BYTES_OF_A_FLIGHT + _BYTES_OF_A_NUMBER * varied
    refuse_more_than_memory(
        f"fly_many: {n} flights, {kept} of them kept,",
        n * of_a_flight + bytes_of_flights(scenario, kept),
        "fly fewer, keep fewer, or fly for less time",
    )
