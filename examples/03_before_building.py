"""Which half-edge should the cube have, and what would a stronger motor buy?

OmniMorph with other dimensions, analysed before anything is built: where it would be
omnidirectional, and what hovering in every attitude would cost. Then the derivatives of its radius
say which change is worth most. Run it with ``python examples/03_before_building.py``.
"""

from __future__ import annotations

import numpy as np

import omnimorph as om


def main() -> None:
    """Print where variants of OmniMorph are omnidirectional, and what drives the radius."""
    vehicle = om.load_vehicle("omnimorph")
    faster = {"speed_min": 1.1 * vehicle.speed_min, "speed_max": 1.1 * vehicle.speed_max}
    for what, variant in (
        ("as it is", vehicle),
        ("half-edge + 20 %", vehicle.replace(rotor_position=1.2 * vehicle.rotor_position)),
        ("rotors + 10 % speed", vehicle.replace(**faster)),
        ("mass + 30 %", vehicle.replace(mass=1.3 * vehicle.mass)),
    ):
        intervals = np.degrees(om.analysis.omnidirectional_range(variant, zero_moment=True))
        where = ", ".join(f"{low:.1f} to {high:.1f} deg" for low, high in intervals) or "nowhere"
        best = om.analysis.tilt_of_largest_radius(variant)
        attitudes = om.analysis.hover_map(variant, om.analysis.sphere_directions(200), [best])
        worst = float(attitudes.least_power.max())
        print(f"{what}: omnidirectional {where}; at its best tilt at most {worst:.0f} W")

    slope = om.analysis.sensitivity(vehicle, np.radians(45.0), "radius_zero_moment")
    print(f"\nradius at 45 deg: {slope.value:.2f} N")
    print(f"a degree more of tilt: {np.radians(slope.tilt[0]):+.3f} N")
    # OmniMorph is symmetric, so its radius has kinks: a change of one rotor alone gains nothing;
    # `along` gives the derivative for changes made together.
    print(f"a newton more from rotor 0 alone: {slope.right.thrust_max[0]:+.3f} N")
    print(f"a newton less: {-slope.left.thrust_max[0]:+.3f} N")
    print(f"a newton more from all, both ways: {slope.along(thrust_max=1, thrust_min=-1):+.3f} N")
    outwards = vehicle.rotor_position / np.linalg.norm(vehicle.rotor_position, axis=1)[:, None]
    print(f"hubs a millimetre farther out: {slope.along(position=1e-3 * outwards):+.4f} N")


if __name__ == "__main__":
    main()
