"""Fly your own controller in the same plant, and compare it with the paper's.

The controller below tracks the pose as the paper's does, but allocates by the pseudo-inverse and
clips, which is what most people write first. Run it with ``python examples/01_own_controller.py``.
"""

from __future__ import annotations

import numpy as np

import omnimorph as om
from omnimorph.model.dynamics import wrench_for


class ClippedPseudoInverse:
    """Pose tracking, then f = A⁺ w at a fixed tilt, clipped to the limits."""

    def __init__(self, vehicle: om.Vehicle, tilt: float) -> None:
        self.vehicle = vehicle
        self.tilt = np.array([tilt])
        self.inverse = np.linalg.pinv(om.allocation_matrix(vehicle, tilt))

    def __call__(self, time: float, state: om.State, desired: om.Desired) -> om.Command:
        """Return the command for this control step."""
        relative = state.R_WB.T @ desired.R_WB
        skew = 0.5 * (relative - relative.T)
        w_desired = relative @ desired.w_WB_B
        linear = (
            desired.a_WB + 30.0 * (desired.v_WB - state.v_WB) + 300.0 * (desired.p_WB - state.p_WB)
        )
        angular = relative @ desired.dw_WB_B - np.cross(state.w_WB_B, w_desired)
        angular += 40.0 * (w_desired - state.w_WB_B)
        angular += 100.0 * np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
        wrench = wrench_for(self.vehicle, state, np.concatenate([linear, angular]))
        thrust = np.clip(self.inverse @ wrench, self.vehicle.thrust_min, self.vehicle.thrust_max)
        return om.Command(thrust, self.tilt)


def main() -> None:
    """Fly Case A's trajectory at 45 degrees with both, and print how well each did."""
    scenario = om.load_scenario("paper-fixed-45-a")
    mine = om.fly(scenario, controller=ClippedPseudoInverse(scenario.vehicle, np.radians(45.0)))
    paper = om.fly(scenario)
    for name, run in (("clipped pseudo-inverse", mine), ("the paper's QP", paper)):
        m = run.metrics
        print(f"{name}: {run.outcome.value}")
        print(f"  position error {m.position_error_mean_m * 1e3:.2f} mm on average")
        share = f"{m.saturated_share:.1%} of the time at a limit"
        print(f"  {m.drag_energy_J:.0f} J of rotor drag, {share}")


if __name__ == "__main__":
    main()
