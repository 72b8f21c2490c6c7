"""What happens when rotors give less thrust than the controller believes?

Case B with all rotors at a share of their thrust, one flight each. Run it with
``python examples/02_worn_rotors.py``.
"""

from __future__ import annotations

from dataclasses import replace

import omnimorph as om


def main() -> None:
    """Fly Case B with healthy and with worn rotors, and print what became of it."""
    scenario = om.load_scenario("paper-case-b")
    for share in (1.0, 0.9, 0.8, 0.6):
        worn = om.effects.Effectiveness(share=share)
        plant = replace(scenario.plant, effects=(*scenario.plant.effects, worn))
        run = om.fly(replace(scenario, plant=plant))
        flown, error = float(run.time[-1]), run.metrics.position_error_max_m * 1e3
        print(
            f"{share:.0%} of the thrust: {run.outcome.name.lower()} after {flown:.1f} s, "
            f"at most {error:.0f} mm off"
        )


if __name__ == "__main__":
    main()
