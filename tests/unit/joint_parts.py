"""What the tests of joint allocation share: vehicles with many servos, and J written out in NumPy.

J is written for complex numbers too, so that its gradient is exact to rounding (complex steps).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation
from tests.physics.small_vehicles import build_vehicle, random_tilting_vehicle

import omnimorph as om
from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import FloatArray

GRAVITY = np.array([0.0, 0.0, 9.81])


def build_arms(pairs: bool = False, **changes: Any) -> Vehicle:
    """Build six arms at 30° + 60° k, each with a servo that turns its rotor, or its coaxial pair.

    One rotor an arm is like Voliro (Kamel et al. 2018); two are like the OMAV of Allenspach et al.
    2020, whose inertia is assumed here in proportion to its mass.
    """
    angle = np.radians(30.0 + 60.0 * np.arange(6))
    arm = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(6)])
    spin = (-1.0) ** np.arange(6)
    servos = np.arange(6)
    values: dict[str, Any] = {
        "servos": 6,
        "rotor_servo": np.tile(servos, 2) if pairs else servos,
        "hinge_axis": np.tile(arm, (2, 1)) if pairs else arm,
        "rotor_spin": np.concatenate([spin, -spin]) if pairs else spin,
        "speed_min": 0.0,
    }
    if pairs:
        values |= {"mass": 4.04, "inertia": np.diag([0.051, 0.052, 0.096])}
        values |= {"thrust_coefficient": 7.2e-6, "drag_coefficient": 0.015 * 7.2e-6}
        values |= {"speed_max": 1700.0, "servo_rate_max": 10.0}
        values |= {"servo_angle_min": -3.0, "servo_angle_max": 3.0}
        return build_vehicle(0.3 * np.tile(arm, (2, 1)), **(values | changes))
    values |= {"mass": 1.92, "inertia": np.diag([0.0242, 0.0248, 0.0455])}
    values |= {"thrust_coefficient": 1.026e-5, "drag_coefficient": 0.016 * 1.026e-5}
    values |= {"speed_max": 838.0, "servo_rate_max": 4.0}
    values |= {"servo_angle_min": -3.0, "servo_angle_max": 3.0}
    return build_vehicle(0.375 * arm, **(values | changes))


def vehicle_named(name: str) -> Vehicle:
    """Return a vehicle of the tests: of the catalogue, with arms, or without any symmetry."""
    if name == "arms":
        return build_arms()
    if name == "pairs":
        return build_arms(pairs=True)
    if name.startswith("random"):  # "random-7-3": seven rotors, three servos
        n, m = map(int, name.split("-")[1:])
        return random_tilting_vehicle(np.random.default_rng(100 * n + m), n, m)
    return om.load_vehicle(name)


class Situation(NamedTuple):
    """One control step: where the vehicle is, what is asked of it, and the command before."""

    state: om.State
    acceleration: FloatArray  # (6,) m/s², rad/s²
    thrust: FloatArray  # (n,) N
    tilt: FloatArray  # (m,) rad


def random_situation(generator: np.random.Generator, vehicle: Vehicle) -> Situation:
    """Return any attitude, and any thrusts and tilts within the limits, before the step."""
    low, high = vehicle.servo_angle_min, vehicle.servo_angle_max
    return Situation(
        om.State(
            np.zeros(3),
            np.asarray(Rotation.random(random_state=generator).as_matrix()),
            np.zeros(3),
            generator.normal(size=3),
        ),
        generator.normal(size=6) * np.repeat([2.0, 5.0], 3),
        generator.uniform(0.5 * vehicle.thrust_min, 0.5 * vehicle.thrust_max),
        generator.uniform(low, high),
    )


class Problem:
    """J of one control step over z = (f / f_scale, α), its bounds, and its projected gradient."""

    def __init__(
        self, vehicle: Vehicle, rule: om.JointTilt, period: float, situation: Situation
    ) -> None:
        self.vehicle, self.rule, self.at = vehicle, rule, situation
        self.n = vehicle.n_rotors
        self.scale = np.maximum(np.abs(vehicle.thrust_min), np.abs(vehicle.thrust_max))
        self.W1, self.W3 = (rule.per_thrust(vehicle, name) for name in ("W1", "W3"))
        self.W2 = np.array([*rule.W2_position, *rule.W2_attitude])
        self.epsilon = vehicle.servo_rate_max * period
        low = np.maximum(situation.tilt - self.epsilon, vehicle.servo_angle_min)
        high = np.minimum(situation.tilt + self.epsilon, vehicle.servo_angle_max)
        self.lower = np.concatenate([vehicle.thrust_min / self.scale, low])
        self.upper = np.concatenate([vehicle.thrust_max / self.scale, high])
        self.start = np.concatenate([situation.thrust / self.scale, situation.tilt])

    def A(self, tilt: Any) -> Any:
        """Return A(α), column by column from hubs, axes, spins and coefficients."""
        v = self.vehicle
        z0, zC, zS = v.thrust_axis_parts
        angle = np.append(tilt, 0.0)[v.rotor_servo]  # a rotor that does not tilt has servo −1
        z = z0 + zC * np.cos(angle)[:, None] + zS * np.sin(angle)[:, None]
        kappa = (v.drag_coefficient / v.thrust_coefficient)[:, None]
        return np.vstack(
            [z.T, (np.cross(v.rotor_position, z) - v.rotor_spin[:, None] * kappa * z).T]
        )

    def J(self, z: Any) -> Any:
        """Return J(f, α)."""
        v, at = self.vehicle, self.at
        f, tilt = self.scale * z[: self.n], z[self.n :]
        w = self.A(tilt) @ f
        R, rate = at.state.R_WB, at.state.w_WB_B
        linear = R @ w[:3] / v.mass - GRAVITY
        angular = np.linalg.inv(v.inertia) @ (w[3:] - np.cross(rate, v.inertia @ rate))
        miss = at.acceleration - np.concatenate([linear, angular])
        moved = (tilt - at.tilt) / self.epsilon
        effort = np.sum(self.W1 * f**2 + self.W3 * (f - at.thrust) ** 2)
        return effort + np.sum(self.W2 * miss**2) + self.rule.W4 * np.sum(moved**2)

    def gradient(self, z: FloatArray) -> FloatArray:
        """Return ∂J/∂z by complex steps."""
        steps = 1e-30j * np.eye(len(z))
        return np.array([self.J(z + step).imag / 1e-30 for step in steps])

    def residual(self, z: FloatArray) -> float:
        """Return max |z − clip(z − ∇J/2)|, ∇J over the mean of half the Hessian's diagonal in x."""
        one = np.eye(len(z))[: self.n]
        curvature = [(self.J(z + e) + self.J(z - e) - 2.0 * self.J(z)) / 2.0 for e in one]
        slope = 0.5 * self.gradient(z) / np.mean(curvature)
        return float(np.abs(z - np.clip(z - slope, self.lower, self.upper)).max())

    def answer(self, period: float) -> Any:
        """Return the allocation of the rule for this step."""
        v, at = self.vehicle, self.at
        gains = om.TrackingGains()
        controller = om.PoseController(v, gains, self.rule, period, at.tilt, at.thrust)
        return controller.allocate(at.acceleration, at.state)

    def point(self, allocation: Any) -> FloatArray:
        """Return z of an allocation."""
        return np.concatenate([allocation.thrust / self.scale, allocation.tilt])
