"""Write an incremental (INDI) controller, and let it fight a wind that no model knows.

A controller by a model asks for the wrench that the model needs; a wind, or a mass that is not
the model's, leaves an error. An incremental one asks for what is missing: it measures the
acceleration and the rotors' speeds, and changes the thrusts by what the difference takes. Run it
with ``python examples/05_incremental_controller.py``.

Smeur, Chu, de Croon, J. Guidance, Control, and Dynamics 39(3), 2016.
"""

from __future__ import annotations

import numpy as np

import omnimorph as om
from omnimorph.protocols import FloatArray

WIND = om.effects.ConstantWrench(force=(1.5, -1.0, 0.5), torque=(0.0, 0.05, 0.02))
HEAVIER = om.effects.ModelMismatch(mass=1.1)


class Incremental:
    """f = f₀ + A⁺ M (a_wanted − a_measured), clipped; f₀ from the speeds, at a fixed tilt."""

    def __init__(self, scenario: om.Scenario) -> None:
        self.vehicle, self.tilt = scenario.vehicle, scenario.tilt
        self.inverse = np.linalg.pinv(om.allocation_matrix(self.vehicle, self.tilt))

    def __call__(self, time: float, state: om.State, desired: om.Desired) -> om.Command:
        """Return the command for this control step."""
        assert state.speed is not None
        assert state.acceleration is not None
        missing = self.wanted(state, desired) - state.acceleration
        wrench = np.concatenate(
            [
                self.vehicle.mass * state.R_WB.T @ missing[:3],
                self.vehicle.inertia @ missing[3:],
            ]
        )
        now = self.vehicle.thrust_coefficient * state.speed * abs(state.speed)
        thrust = now + self.inverse @ wrench
        clipped = np.clip(thrust, self.vehicle.thrust_min, self.vehicle.thrust_max)
        log = {"acceleration_missing": (np.linalg.norm(missing[:3]), "m/s2")}
        return om.Command(clipped, self.tilt, log=log)

    def wanted(self, state: om.State, desired: om.Desired) -> FloatArray:
        """Return the acceleration that leads back to the reference."""
        relative = state.R_WB.T @ desired.R_WB
        skew = 0.5 * (relative - relative.T)
        turn = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
        linear = (
            desired.a_WB + 10.0 * (desired.v_WB - state.v_WB) + 25.0 * (desired.p_WB - state.p_WB)
        )
        angular = 15.0 * (relative @ desired.w_WB_B - state.w_WB_B) + 60.0 * turn
        return np.concatenate([linear, angular])


def main() -> None:
    """Fly Case A's trajectory in the wind with both, and print how far off each is."""
    scenario = om.load_scenario("paper-fixed-45-a")
    wind = om.PlantModel(
        physics_step=1e-3, control_period=4e-3, effects=(*rotors(scenario), WIND, HEAVIER)
    )
    own = om.fly(scenario, plant=wind, controller=Incremental(scenario))
    paper = om.fly(scenario, plant=wind)
    for name, run in (("incremental", own), ("the paper's, by its model", paper)):
        m = run.metrics
        print(f"{name}: {run.outcome_sentence}")
        print(f"  position error {m.position_error_mean_m * 1e3:.2f} mm on average")
        print(f"  attitude error {np.degrees(m.attitude_error_mean_rad):.3f} degrees on average")
    missing = own["acceleration_missing"]
    print(f"the incremental one missed {missing.mean():.3f} m/s² on average")


def rotors(scenario: om.Scenario) -> tuple[om.effects.Effect, ...]:
    """Return the lag and the limits of the scenario's plant."""
    kept = ("rotor-lag", "speed-limits")
    return tuple(effect for effect in scenario.plant.effects if effect.kind in kept)


if __name__ == "__main__":
    main()
