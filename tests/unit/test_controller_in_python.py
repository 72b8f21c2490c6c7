"""The compiled controller called from Python: what it takes, what it gives and what it refuses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import omnimorph as om
from omnimorph.errors import ScenarioError
from omnimorph.model.core import state_row
from omnimorph.protocols import Controller, FloatArray

SCENARIO = om.load_scenario("paper-case-b")
DESIRED = SCENARIO.reference(3.0)
# of numbers that float32 and whole numbers hold exactly
STATE = om.State(np.array([0.0, 0.0, 1.0]), np.eye(3)[[1, 2, 0]], np.full(3, 0.5), np.ones(3))
ACCELERATION = np.array([0.5, 0.0, 0.25, 1.0, 0.0, -2.0])


def spread(part: FloatArray) -> FloatArray:
    """Return the same numbers, not side by side in memory."""
    return np.stack([part, np.full_like(part, np.nan)], axis=-1)[..., 0]


UNEQUAL: Any = [[1.0], [1.0, 2.0]]
FORMS: dict[str, Callable[[Any], Any]] = {
    "lists": lambda part: part.tolist(),
    "tuples": lambda part: tuple(part.ravel().tolist()),
    "float32": lambda part: part.astype(np.float32),
    "big-endian": lambda part: part.astype(">f8"),
    "spread": spread,
    "in Fortran's order": np.asfortranarray,
    "memory": memoryview,
    "read-only": lambda part: np.frombuffer(part.tobytes()).reshape(part.shape),
    "objects": lambda part: part.astype(object),
}


def assert_same(one: Any, other: Any) -> None:
    for name in ("thrust", "tilt", "active", "wrench_asked", "cost", "kkt_residual"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("form", FORMS)
def test_a_state_is_given_in_any_numbers(form: str) -> None:
    write = FORMS[form]
    state = om.State(*(write(part) for part in STATE))
    desired = om.Desired(*(np.asarray(part, np.float64) for part in DESIRED))
    plain, other = SCENARIO.build_controller(), SCENARIO.build_controller()
    for _ in range(2):
        assert_same(other.step(state, desired), plain.step(state_row(*STATE), state_row(*DESIRED)))
        acceleration = write(ACCELERATION)
        assert_same(other.allocate(acceleration, state), plain.allocate(ACCELERATION, STATE))
    command, expected = other(0.0, state, desired), plain(0.0, STATE, DESIRED)
    for one, same in zip(command, expected, strict=True):
        np.testing.assert_array_equal(one, same)


def test_whole_numbers_are_numbers() -> None:
    numbers: list[Any] = [np.array([0, 0, 1]), np.eye(3, dtype=int), np.zeros(3, int), [1, 0, 0]]
    whole = om.State(*numbers)
    same = om.State(*(np.asarray(part, np.float64) for part in whole))
    controllers = [SCENARIO.build_controller() for _ in range(2)]
    assert_same(controllers[0].step(whole, DESIRED), controllers[1].step(same, DESIRED))


def test_a_desired_motion_may_be_lists_too() -> None:
    lists = om.Desired(*(part.tolist() for part in DESIRED))
    row = state_row(*DESIRED).astype(np.float64)
    controllers = [SCENARIO.build_controller() for _ in range(3)]
    plain = controllers[0].step(STATE, DESIRED)
    assert_same(controllers[1].step(STATE, lists), plain)
    assert_same(controllers[2].step(state_row(*STATE).tolist(), row), plain)


def test_what_else_a_state_holds_is_not_asked_for() -> None:
    full = om.State(*STATE, speed=np.ones(8), tilt=np.ones(1), acceleration=np.ones(6))
    controllers: list[Controller] = [SCENARIO.build_controller() for _ in range(2)]
    for one, same in zip(
        *(c(0.0, s, DESIRED) for c, s in zip(controllers, (full, STATE), strict=True)), strict=True
    ):
        np.testing.assert_array_equal(one, same)


def test_what_was_answered_stays_as_it_was() -> None:
    """Over more steps than arrays are made at once; and what one changes in it is one's own."""
    controller = SCENARIO.build_controller()
    answers, thrusts, tilts = [], [], []
    for k in range(200):
        a = controller.step(STATE, SCENARIO.reference(0.1 * k))
        answers.append(a)
        thrusts.append(a.thrust.copy())
        tilts.append(a.tilt.copy())
    np.testing.assert_array_equal([a.thrust for a in answers], thrusts)
    np.testing.assert_array_equal([a.tilt for a in answers], tilts)
    assert len(np.unique(thrusts, axis=0)) > 100
    other = pickled_on(controller)
    answers[-1].thrust[:] = -1.0
    answers[-1].tilt[:] = 1.0
    assert_same(controller.step(STATE, DESIRED), other.step(STATE, DESIRED))
    np.testing.assert_array_equal(answers[-2].thrust, thrusts[-2])


def pickled_on(controller: om.PoseController) -> om.PoseController:
    other = SCENARIO.build_controller()
    other.restore(controller.stored_state())
    return other


@pytest.mark.parametrize(
    ("state", "desired", "why"),
    [
        (STATE._replace(p_WB=np.zeros(2)), DESIRED, "state is .* 18 numbers"),
        (STATE[:3], DESIRED, "state is .* 18 numbers"),
        (STATE._replace(p_WB=None), DESIRED, "state is .* 18 numbers"),
        (STATE._replace(v_WB="fast"), DESIRED, "state is .* 18 numbers"),
        (3, DESIRED, "state is 3, but it must be 18 numbers"),
        (None, DESIRED, "state is None, but it must be 18 numbers"),
        (np.zeros(17), DESIRED, "state is .* 18 numbers"),
        (np.zeros(19, np.float32), DESIRED, "state is .* 18 numbers"),
        (DESIRED, DESIRED, "state is .* 18 numbers"),
        (STATE, STATE, "desired is .* 24 numbers"),
        (STATE, DESIRED._replace(a_WB=UNEQUAL), "desired is .* 24 numbers"),
        (STATE, "there", "desired is .there., but it must be 24 numbers"),
    ],
)
def test_what_is_no_state_is_refused_and_changes_nothing(
    state: Any, desired: Any, why: str
) -> None:
    controller = SCENARIO.build_controller()
    before = controller.stored_state()
    for call in (controller.step, lambda *given: controller(0.0, *given)):
        with pytest.raises(ScenarioError, match=f"^the controller: {why}"):
            call(state, desired)
    assert controller.stored_state() == before


@pytest.mark.parametrize("acceleration", [np.zeros(5), 3.0, "up", None, UNEQUAL])
def test_an_acceleration_is_six_numbers(acceleration: Any) -> None:
    with pytest.raises(ScenarioError, match=r"^the controller: acceleration is .* 6 numbers"):
        SCENARIO.build_controller().allocate(acceleration, STATE)


@pytest.mark.parametrize("thrust", [np.zeros(7), 3.0, "up", np.full(8, np.nan)])
def test_it_begins_with_a_thrust_for_each_rotor(thrust: Any) -> None:
    given = SCENARIO.vehicle, SCENARIO.gains, SCENARIO.allocator, 4e-3, 0.0
    with pytest.raises(
        ScenarioError, match=r"^the controller: start_thrust is .* 8 finite numbers"
    ):
        om.PoseController(*given, thrust)
    begun = om.PoseController(*given, [1] * 8)  # type: ignore[arg-type]
    assert np.isfinite(begun.step(STATE, DESIRED).thrust).all()
