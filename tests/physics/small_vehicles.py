"""Vehicles for the tests of the analysis: a few of the textbook, and random ones."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from omnimorph.design import Vehicle
from omnimorph.protocols import FloatArray

UP = (0.0, 0.0, 1.0)


def build_vehicle(position: ArrayLike, axis: ArrayLike | None = None, **changes: Any) -> Vehicle:
    """Build a vehicle with these hubs and axes (up if not given) whose rotors turn both ways.

    A name of rotors takes one value for all or one each. `servos` is their number: each turns from
    −1 to 1 rad, and rotor i tilts about ``hinge_axis[i]`` by servo ``rotor_servo[i]``.
    """
    n, m = len(np.asarray(position)), changes.pop("servos", 0)
    values: dict[str, Any] = {
        "name": "small",
        "title": "A vehicle for tests",
        "mass": 1.0,
        "inertia": np.diag([0.01, 0.011, 0.018]),
        "rotor_position": position,
        "rotor_axis": np.tile(UP, (n, 1)) if axis is None else axis,
        "hinge_axis": np.zeros((n, 3)),
        "rotor_servo": np.full(n, -1),
        "servo_name": tuple(f"servo{j}" for j in range(m)),
        "filter_cutoff": np.zeros(4),
    }
    of_rotors = {"thrust_coefficient": 1e-5, "drag_coefficient": 2e-7, "speed_max": 600.0}
    of_rotors |= {"speed_min": -600.0, "rotor_spin": 1.0, "dead_band": 0.0, "spin_inertia": 1e-5}
    of_rotors |= {"time_constant_up": 0.0, "time_constant_down": 0.0}
    of_servos = {"servo_angle_min": -1.0, "servo_angle_max": 1.0}
    of_servos |= {"servo_rate_max": 1.0, "servo_time_constant": 0.0}
    for names, count in ((of_rotors, n), (of_servos, m)):
        values |= {name: np.full(count, changes.pop(name, names[name])) for name in names}
    return Vehicle(**(values | changes))


def build_star(n: int, cant: float = 0.0, **changes: Any) -> Vehicle:
    """Build n rotors on a circle of 0.2 m, spins in turn, canted about their arms in turn."""
    angle = 2.0 * np.pi * np.arange(n) / n
    arm = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    spin = (-1.0) ** np.arange(n)
    lean = Rotation.from_rotvec(cant * spin[:, None] * arm).apply(UP)
    return build_vehicle(0.2 * arm, lean, **({"rotor_spin": spin, "speed_min": 0.0} | changes))


def build_tilting_star(n: int, **changes: Any) -> Vehicle:
    """Build the same with a servo for each rotor, which tilts it about its arm."""
    star = build_star(n)
    hinges: dict[str, Any] = {"rotor_servo": np.arange(n), "hinge_axis": 5.0 * star.rotor_position}
    return build_star(n, servos=n, **(hinges | changes))


def random_axes(generator: np.random.Generator, n: int) -> FloatArray:
    """Return n random unit vectors."""
    axes = generator.normal(size=(n, 3))
    return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))


def random_vehicle(generator: np.random.Generator, n: int, **changes: Any) -> Vehicle:
    """Build a vehicle without any symmetry: hubs, axes, spins, coefficients, limits, inertia."""
    turn = Rotation.from_rotvec(generator.normal(size=3)).as_matrix()
    speed_max = generator.uniform(400.0, 700.0, n)
    values: dict[str, Any] = {
        "rotor_spin": generator.choice([-1.0, 1.0], n),
        "thrust_coefficient": generator.uniform(0.5e-5, 2e-5, n),
        "drag_coefficient": generator.uniform(1e-7, 5e-7, n),
        "speed_max": speed_max,
        "speed_min": -speed_max * generator.uniform(0.5, 1.0, n),
        "inertia": turn @ np.diag([0.01, 0.012, 0.018]) @ turn.T,
    }
    position = generator.uniform(-0.3, 0.3, (n, 3))
    values["questioned"] = False  # whatever its numbers look like
    return build_vehicle(position, random_axes(generator, n), **(values | changes))


def random_tilting_vehicle(generator: np.random.Generator, n: int, m: int = 1) -> Vehicle:
    """Build the same with m servos; rotor i is tilted by servo i modulo m."""
    hinges = {"servos": m, "rotor_servo": np.arange(n) % m, "hinge_axis": random_axes(generator, n)}
    return random_vehicle(generator, n, **hinges)


def frozen(vehicle: Vehicle, tilt: float) -> Vehicle:
    """Return a vehicle without servos whose axes are those of another at one tilt."""
    z0, zC, zS = vehicle.thrust_axis_parts
    nothing = np.zeros(0)
    names = ("angle_min", "angle_max", "rate_max", "time_constant")
    return vehicle.replace(
        rotor_axis=z0 + zC * np.cos(tilt) + zS * np.sin(tilt),
        hinge_axis=np.zeros((vehicle.n_rotors, 3)),
        rotor_servo=np.full(vehicle.n_rotors, -1),
        servo_name=(),
        **{f"servo_{name}": nothing for name in names},
    )


def attitude(up: ArrayLike) -> FloatArray:
    """Return a rotation R_WB with R_WBᵀ e3 along `up`."""
    unit = np.asarray(up) / np.linalg.norm(up)
    return np.asarray(Rotation.align_vectors([[0.0, 0.0, 1.0]], [unit])[0].as_matrix())
