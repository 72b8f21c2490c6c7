"""Fly a scenario: in the compiled core, or with parts of the loop that are one's own."""

from __future__ import annotations

from omnimorph import _core
from omnimorph.machine.memory import refuse_more_than_memory
from omnimorph.protocols import FloatArray
from omnimorph.results.run import Run
from omnimorph.simulation.loop import Progress, SteppedFlight
from omnimorph.simulation.own_parts import in_flight
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
from omnimorph.simulation.scenario_files import ScenarioLike
from omnimorph.simulation.whole_number import whole_number


def fly(
    scenario: ScenarioLike,
    *,
    seed: int = 0,
    flight: int = 0,
    plant: AnyPlant | None = None,
    sensors: SensorsLike | None = None,
    estimator: EstimatorLike | None = None,
    controller: ControllerLike | None = None,
    allocator: AllocatorLike | None = None,
    reference: ReferenceLike | None = None,
    disturbance: DisturbanceLike | None = None,
    allow_code: bool = False,
    progress: Progress | None = None,
) -> Run:
    """Fly a scenario once.

    What is left out is the scenario's and runs in the core. A part of one's own is an object of its
    protocol (`omnimorph.protocols`) that is called once a control step; a disturbance once a
    physics step, a reference for every physics step before the flight, a plant for every one.

    Parameters
    ----------
    scenario : Scenario, str or path
        What is flown, or its name or file.
    seed, flight : int
        Which noise: flight k of seed s is the same wherever and beside whatever it is flown.
    plant : PlantModel, str, path or Plant, optional
        How the vehicle behaves, such as ``perfect``, or an engine of one's own that flies instead:
        what is measured and estimated of its motion is then as in the scenario's plant.
    sensors : effect, str, path or Sensors, optional
        `omnimorph.effects` for sensors, or the name or file of a plant that has them.
    estimator : effect, str, path or Estimator, optional
        Likewise.
    controller : TrackingGains, Scenario, str, path or Controller, optional
        Gains, or a scenario, or the name or file of one, whose whole controller is taken.
    allocator : AllocationRule, str, path or Allocator, optional
        A rule; the kind of one, such as ``three-candidates``, with the scenario's weights; or a
        scenario's. One of one's own gets its accelerations from the scenario's tracking.
    reference : Reference, str or path, optional
        Where to be; of a scenario, or from a CSV file of poses.
    disturbance : effect, str, path or Disturbance, optional
        Forces, or the name or file of a plant that has them, beside those of the plant.
    allow_code : bool
        Whether code may run that a file or a text names, ``my_module:MyController``.
    progress : callable, optional
        Called now and then with the time flown and the duration, s.

    Returns
    -------
    Run
        Complete, or up to the step at which the flight ended; see `Run.outcome`. What a part of
        one's own raises ends the flight, and the run so far is kept; in its very first step it is
        raised.

    Notes
    -----
    A part of one's own that may remember something, as any may but plain functions and frozen
    records, flies once at a time.

    Raises
    ------
    ScenarioError
        If a part does not fit: both a controller and an allocator, a reference that is not finite;
        if a part is flying in another thread; if a file names code that is not allowed.
    TooLargeError
        If the flight has more rows than memory holds.

    Examples
    --------
    >>> import omnimorph as om
    >>> run = om.fly(om.load_scenario("hover"), plant="perfect")
    >>> run.outcome.name, run.metrics.position_error_max_m < 1e-4
    ('COMPLETED', True)
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
    with in_flight(scenario.own.given()):
        flown = SteppedFlight(scenario, seed=seed, flight=flight)
        flown.fly(progress)
    return flown.as_run()


def measurement_noise(seed: int, flight: int, steps: int) -> FloatArray:
    """Return the (steps, 12) standard normal numbers behind a flight's white measurement noise.

    Columns: position, velocity, attitude, body rate. They depend on nothing but the arguments.

    Raises
    ------
    ScenarioError
        If an argument is not a whole number that a flight can have.
    TooLargeError
        If they are more than memory holds.
    """
    for name, value, bits in (("seed", seed, 64), ("flight", flight, 32), ("steps", steps, 32)):
        whole_number("measurement_noise", name, value, bits)
    refuse_more_than_memory(f"{steps} rows of noise", 96 * steps, "ask for fewer")
    return _core.measurement_normals(seed, flight, 0, steps)
