"""A thousand flights, each with another vehicle: how much uncertainty a controller bears.

Then the same flights in single precision, to see what that costs. Run it with
``python examples/04_many_flights.py``.
"""

from __future__ import annotations

import numpy as np

import omnimorph as om

VARY = {
    "mass": om.Normal(1.0, 0.05),
    "inertia": om.Uniform(0.8, 1.2),
    "thrust_coefficient": om.Normal(1.0, 0.03),  # each rotor's own
    "centre_of_mass": om.Normal(0.0, 2e-3),  # m, each axis
    "rotor_lag": om.Uniform(0.7, 2.0),
    "start_attitude": om.Normal(0.0, 0.1),  # rad
}


def main() -> None:
    """Print what the worst vehicles have in common, and how far single precision is off."""
    scenario = om.load_scenario("hover")
    flights = om.fly_many(scenario, 1000, vary=VARY)
    error = 1e3 * flights.metrics.position_error_rms_m
    print(f"{flights.completed.sum()} of {len(flights)} completed")
    print("rms position error, mm: median {:.1f}, 95 % {:.1f}, worst {:.1f}".format(
        *np.percentile(error, [50, 95, 100])))  # fmt: skip
    for name in VARY:
        away = np.abs(flights.varied[name] - np.median(flights.varied[name]))
        share = np.corrcoef(away.reshape(len(flights), -1).mean(axis=1), error)[0, 1]
        print(f"{name:20s} correlation with the error {share:5.2f}")

    print("single precision, largest difference over 16 flights:")
    for name in ("hover", "tour", "paper-case-b", "paper-case-a"):
        scenario = om.load_scenario(name)
        double = om.fly_many(scenario, 16, keep="all")
        single = om.fly_many(scenario, 16, keep="all", precision="float32")
        place = max(
            np.abs(double.runs[k].p_WB - single.runs[k].p_WB).max() for k in double.runs
        )  # fmt: skip
        tilt = max(
            np.abs(run.tilt_actual - single.runs[k].tilt_actual).max()
            for k, run in double.runs.items()
        )  # fmt: skip
        energy = np.abs(single.metrics.drag_energy_J / double.metrics.drag_energy_J - 1.0).max()
        print(f"{name:14s} {1e6 * place:6.1f} µm {np.degrees(tilt):6.2f} deg, energy {energy:.1e}")


if __name__ == "__main__":
    main()
