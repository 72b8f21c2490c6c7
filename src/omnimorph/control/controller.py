"""The paper's controller, compiled: pose tracking, then allocation, one control step at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from omnimorph import _core
from omnimorph.arrays import as_numbers
from omnimorph.control.allocators import AllocationRule, RuleLike
from omnimorph.control.rules import RULES
from omnimorph.control.tracking import GainsLike, TrackingGains
from omnimorph.design.files import VehicleLike, as_vehicle
from omnimorph.design.records import record_of
from omnimorph.design.vehicle import Vehicle
from omnimorph.errors import ScenarioError
from omnimorph.model.core import as_core, as_thrust, as_tilt, in_float64, state_row
from omnimorph.model.dynamics import hover_thrust
from omnimorph.model.stored_state import Copyable
from omnimorph.protocols import Command, Desired, FloatArray, State

if TYPE_CHECKING:
    Allocation = _core.Allocation


def core_settings(
    vehicle: Vehicle,
    gains: GainsLike,
    rule: RuleLike,
    control_period: float,
    lateral_force: float | None = None,
) -> _core.ControllerSettings:
    """Return the core's settings of a controller, made of `controller_fields`."""
    fields = controller_fields(vehicle, gains, rule, control_period, lateral_force)
    return _core.ControllerSettings(fields)


def controller_fields(
    vehicle: Vehicle,
    gains: GainsLike,
    rule: RuleLike,
    control_period: float,
    lateral_force: float | None = None,
) -> dict[str, Any]:
    """Return the fields of the core's controller; refuses a rule that does not fit the vehicle.

    With a `lateral_force`, N, position goes first: where more is asked sideways, the attitude gives
    way.
    """
    gains = record_of("the controller", "gains", gains, TrackingGains)
    rule = record_of("the controller", "allocator", rule, AllocationRule)
    if not rule.suits(vehicle.n_servos):
        raise _unfit_servos(vehicle, rule)
    for name in ("W1", "W3"):
        if np.size(getattr(rule, name)) not in (1, vehicle.n_rotors):
            allowed = f"one number, or one for each of the {vehicle.n_rotors} rotors"
            raise _refusal(rule, name, allowed)
    input_weight, change_weight = (rule.per_thrust(vehicle, name) for name in ("W1", "W3"))
    if not (input_weight + change_weight > 0).all():
        raise _refusal(rule, "W1", "positive, or W3 must be")
    tracking: dict[str, object] = {
        "gains": {name: gains.axes(name) for name in ("velocity", "position", "rate", "attitude")}
    }
    if lateral_force is not None and lateral_force != np.inf:
        tracking["position-first"] = {"lateral_force": lateral_force}
    fields = {
        "model": as_core(vehicle),
        "tracking": tracking,
        "allocation": {
            "weights": {
                "input": input_weight,
                "input_change": change_weight,
                "acceleration": np.array([*rule.W2_position, *rule.W2_attitude]),
            },
            "tilt_change": vehicle.servo_rate_max * control_period,
            "rule": rule.core_rule(),
        },
        "period": control_period,
    }
    return in_float64(fields)


def _unfit_servos(vehicle: Vehicle, rule: AllocationRule) -> ScenarioError:
    """Build the error for a rule that turns another number of servos; it names those that fit."""
    m = vehicle.n_servos
    fitting = " or ".join(one.kind for one in RULES if one.suits(m))
    place = f"vehicle {vehicle.name} with {m} servos"
    return ScenarioError.at(place, "controller.allocator", rule.kind, fitting)


def _refusal(rule: AllocationRule, name: str, allowed: str) -> ScenarioError:
    """Build the error for a weight, named as the file names it."""
    key = f"{name}_per_Hz4"
    return ScenarioError.at(rule.kind, key, rule.as_file()[key], allowed)


class PoseController(Copyable):
    """Pose tracking and allocation for one vehicle, in the compiled core.

    It remembers its last command, to which the next one is tied (W3, and the tilt's rate limit).
    It can be copied and pickled between two steps, and goes on the same to the last bit.

    Parameters
    ----------
    vehicle : Vehicle
        The model it controls by.
    gains : TrackingGains
        Of the pose controller; or what holds them, a scenario or a proposed controller.
    rule : AllocationRule
        How thrusts and tilt are found; or what holds it.
    control_period : float
        Time between two steps, s.
    start_tilt : float or (m,), rad
        The tilt before the first step.
    start_thrust : (n,), optional, N
        The thrusts before the first step; hovering by default.
    lateral_force : float, optional, N
        What it can push sideways: where more is asked, the attitude gives way to the position.

    Examples
    --------
    >>> import numpy as np, omnimorph as om
    >>> scenario = om.load_scenario("paper-case-a")
    >>> controller = scenario.build_controller()
    >>> desired = scenario.reference(0.0)
    >>> command = controller(0.0, om.State(*desired[:4]), desired)
    >>> bool(np.isclose(command.thrust.sum(), 1.315 * 9.81))
    True
    """

    kind: ClassVar[str] = "controller"
    _in_core: _core.Controller

    def __init__(
        self,
        vehicle: VehicleLike,
        gains: GainsLike,
        rule: RuleLike,
        control_period: float,
        start_tilt: ArrayLike = 0.0,
        start_thrust: FloatArray | None = None,
        lateral_force: float | None = None,
    ) -> None:
        self.vehicle = vehicle = as_vehicle(vehicle)
        tilt = as_tilt(vehicle, start_tilt)
        if start_thrust is None:
            start_thrust = hover_thrust(vehicle, tilt)
        self._settings = gains, rule, control_period, lateral_force
        self._in_core = self._new_core(
            as_thrust(vehicle, start_thrust, "the controller", "start_thrust"), tilt
        )

    def _new_core(
        self, thrust: FloatArray | None = None, tilt: FloatArray | None = None
    ) -> _core.Controller:
        thrust = np.zeros(self.vehicle.n_rotors) if thrust is None else thrust
        tilt = np.zeros(self.vehicle.n_servos) if tilt is None else tilt
        return _core.new_controller(core_settings(self.vehicle, *self._settings), thrust, tilt)

    def __call__(self, time: float, state: State, desired: Desired) -> Command:
        """Return the command for this control step (satisfies `omnimorph.protocols.Controller`)."""
        allocation = self.step(state, desired)
        return Command(allocation.thrust, allocation.tilt)

    def step(self, state: State | FloatArray, desired: Desired | FloatArray) -> Allocation:
        """Return the allocation for this control step, with all that the core knows of it.

        Parameters
        ----------
        state : State or (18,) array
            p_WB, R_WB row by row, v_WB, w_WB_B.
        desired : Desired or (24,) array
            The same of the reference, then a_WB and dw_WB_B.

        Returns
        -------
        Allocation
            ``thrust`` (N), ``tilt`` (rad), ``cost``, ``kkt_residual`` of the scaled problem,
            ``active`` (−1, 0, +1 for each thrust) and ``wrench_asked`` (N, N m, in B).

        Raises
        ------
        ScenarioError
            If they are not so many numbers.
        """
        try:
            return self._in_core.step(state, desired)
        except (TypeError, ValueError):  # not yet so many numbers in float64
            return self._in_core.step(_row("state", state, 18), _row("desired", desired, 24))

    def allocate(self, acceleration: FloatArray, state: State | FloatArray) -> Allocation:
        """Return the allocation for a (6,) acceleration, m/s² in W and rad/s² in B."""
        try:
            return self._in_core.allocate(state, acceleration)
        except (TypeError, ValueError):  # not yet so many numbers in float64
            wish = _row("acceleration", acceleration, 6)
            return self._in_core.allocate(_row("state", state, 18), wish)

    def replay(self, states: FloatArray, desired: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the commands for many control steps, one after the other, without Python between.

        Parameters
        ----------
        states : (K, 18) array
            What was measured, a row as in `step`; from a recorded flight, say.
        desired : (K, 24) array
            What was desired.

        Returns
        -------
        (K, n) array, (K, m) array
            Thrusts (N) and tilts (rad).

        Raises
        ------
        ScenarioError
            If the rows are not as many, or not as wide.
        """
        states, desired = (np.ascontiguousarray(rows, float) for rows in (states, desired))
        if states.ndim != 2 or states.shape != (len(desired), 18) or desired.shape[1:] != (24,):
            shapes = f"{states.shape} and {desired.shape}"
            raise ScenarioError.at("replay", "shape of its arrays", shapes, "(K, 18) and (K, 24)")
        return self._in_core.replay(states, desired)


def _row(name: str, value: object, size: int) -> FloatArray:
    """Return so many numbers, given as an array of them or in parts, as one row of float64."""
    row = state_row(*value) if isinstance(value, (tuple, list)) else as_numbers(value).reshape(-1)
    if row.size != size:
        raise ScenarioError.at("the controller", name, value, f"{size} numbers")
    return row
