"""Replace every part of the loop by an object of your own, one after the other and all at once.

Whatever is left out stays omnimorph's, and every flight is recorded alike. Run it with
``python examples/06_every_part_of_your_own.py``.
"""

from __future__ import annotations

import numpy as np

import omnimorph as om
from omnimorph.protocols import FloatArray

UPRIGHT, ZERO = np.eye(3), np.zeros(3)


class Circle:
    """A reference: a circle of 0.3 m, begun and ended at rest."""

    duration = 4.0

    def __call__(self, time: float) -> om.Desired:
        """Return where to be: the angle goes from 0 to 2π by a minimum-jerk polynomial."""
        u, T = time / self.duration, self.duration
        angle = 2 * np.pi * (10 * u**3 - 15 * u**4 + 6 * u**5)
        rate = 2 * np.pi * (30 * u**2 - 60 * u**3 + 30 * u**4) / T
        change = 2 * np.pi * (60 * u - 180 * u**2 + 120 * u**3) / T**2
        out = 0.3 * np.array([np.cos(angle), np.sin(angle), 0.0])
        along = 0.3 * np.array([-np.sin(angle), np.cos(angle), 0.0])
        p = out + np.array([0.0, 0.0, 1.0])
        return om.Desired(p, UPRIGHT, rate * along, ZERO, change * along - rate**2 * out, ZERO)


class MotionCapture:
    """Sensors: position and attitude are seen, with noise; velocities come by the estimator."""

    def __init__(self, seed: int = 0) -> None:
        self.random = np.random.default_rng(seed)

    def __call__(self, time: float, state: om.State) -> om.State:
        """Return the motion as cameras see it."""
        return state._replace(p_WB=state.p_WB + self.random.normal(0.0, 2e-4, 3))


class PositionFilter:
    """An estimator: an alpha-beta filter for position and velocity, which logs its innovation."""

    period, alpha, beta = 4e-3, 0.4, 0.08

    def __init__(self, start: om.Desired) -> None:
        self.p, self.v = start.p_WB, start.v_WB

    def __call__(self, time: float, measured: om.State, previous: om.Command) -> om.Estimate:
        """Return what is known after a measurement."""
        predicted = self.p + self.period * self.v
        innovation = measured.p_WB - predicted
        self.p = predicted + self.alpha * innovation
        self.v = self.v + self.beta / self.period * innovation
        known = (self.p, measured.R_WB, self.v, measured.w_WB_B)
        return om.Estimate(*known, log={"innovation": (innovation, "m")})


class PseudoInverse:
    """An allocator: the least thrusts at a fixed tilt, clipped to the limits."""

    def __init__(self, vehicle: om.Vehicle, tilt: float) -> None:
        self.vehicle, self.tilt = vehicle, np.array([tilt])
        self.inverse = np.linalg.pinv(om.allocation_matrix(vehicle, tilt))

    def __call__(
        self, acceleration: FloatArray, state: om.State, previous: om.Command
    ) -> om.Command:
        """Return the command for a wanted acceleration."""
        J, w = self.vehicle.inertia, state.w_WB_B
        lift = acceleration[:3] + np.array([0.0, 0.0, 9.81])
        force = self.vehicle.mass * state.R_WB.T @ lift
        torque = J @ acceleration[3:] + np.cross(w, J @ w)
        thrust = self.inverse @ np.concatenate([force, torque])
        limits = self.vehicle.thrust_min, self.vehicle.thrust_max
        return om.Command(np.clip(thrust, *limits), self.tilt)


class RigidBody:
    """A plant: rotors that follow commands at once, on a body with drag, by Euler's steps."""

    physics_step, control_period = 1e-3, 4e-3
    drag = 0.1  # N s/m

    def __init__(self, vehicle: om.Vehicle) -> None:
        self.vehicle = vehicle

    def reset(self, state: om.State, tilt: FloatArray, thrust: FloatArray, seed: int) -> None:
        """Begin anew."""
        self.motion, self.tilt, self.thrust = state, tilt, thrust

    @property
    def speed(self) -> FloatArray:
        """Rotor speeds, rad/s."""
        return np.sign(self.thrust) * np.sqrt(abs(self.thrust) / self.vehicle.thrust_coefficient)

    @property
    def wrench(self) -> FloatArray:
        """What the rotors do to the body, in B."""
        return om.allocation_matrix(self.vehicle, self.tilt) @ self.thrust

    def send(self, command: om.Command) -> None:
        """Take a command."""
        self.thrust, self.tilt = command

    def step_physics(self, steps: int, push: FloatArray) -> None:
        """Go on under a push."""
        (p, R, v, w), J = self.motion, self.vehicle.inertia
        wrench = self.wrench
        for _ in range(steps):
            force = R @ wrench[:3] + push[:3] - self.drag * v
            torque = wrench[3:] + push[3:] - np.cross(w, J @ w)
            v = v + self.physics_step * (force / self.vehicle.mass - np.array([0.0, 0.0, 9.81]))
            w = w + self.physics_step * np.linalg.solve(J, torque)
            p = p + self.physics_step * v
            R = R @ turned(self.physics_step * w)
        self.motion = om.State(p, R, v, w)


def turned(angle: FloatArray) -> FloatArray:
    """Return the rotation by a small vector, by Cayley's formula."""
    x, y, z = 0.5 * angle
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.linalg.solve(UPRIGHT - skew, UPRIGHT + skew)


def gusts(time: float, state: om.State) -> FloatArray:
    """A disturbance: a wind from the side that comes and goes."""
    return np.array([0.0, 0.4 * np.sin(2.0 * time) ** 2, 0.0, 0.0, 0.0, 0.0])


def main() -> None:
    """Fly the circle with each part replaced, and print how well it was followed."""
    scenario = om.load_scenario("paper-fixed-45-a")
    vehicle, circle = scenario.vehicle, Circle()
    parts = {
        "reference": circle,
        "sensors": MotionCapture(),
        "estimator": PositionFilter(circle(0.0)),
        "allocator": PseudoInverse(vehicle, np.radians(45.0)),
        "plant": RigidBody(vehicle),
        "disturbance": gusts,
    }
    for name, part in parts.items():
        chosen = {"reference": circle} | {name: part}
        report(name, om.fly(scenario, **chosen))  # type: ignore[arg-type]
    parts["estimator"] = PositionFilter(circle(0.0))  # which has remembered a flight
    run = om.fly(scenario, **parts)  # type: ignore[arg-type]
    report("all", run)
    innovation = np.linalg.norm(run["innovation"], axis=1).mean()
    print(f"the estimator was surprised by {innovation * 1e3:.2f} mm on average")


def report(name: str, run: om.Run) -> None:
    """Print how a flight went."""
    error = run.metrics.position_error_mean_m * 1e3
    print(f"{name} of your own: {error:.2f} mm off on average. {run.outcome_sentence}")


if __name__ == "__main__":
    main()
