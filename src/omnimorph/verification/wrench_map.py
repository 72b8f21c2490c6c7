"""A(α), its derivative, its rank, and what hovering costs."""

from __future__ import annotations

import numpy as np

from omnimorph.analysis.hover import HoverPoint, hover
from omnimorph.model.allocation import allocation_matrix, full_allocation_matrix, tilt_derivative
from omnimorph.model.dynamics import rotation_exponential
from omnimorph.protocols import FloatArray
from omnimorph.verification.case import Result, case, largest
from omnimorph.verification.setting import TURN, omnimorph, spin_axes

_GEOMETRY = "Aboudorra et al. 2024, Sec. 2: a cube of hubs, two pinwheels of thrust axes"
_FIGURES = "closed form: equal thrusts m g / (8 cos α), P = Σ c_τ |w|³"

# Hub over the half-edge, thrust axis as multiples of (sin α, sin α, cos α), and spin. Upper layer
# first, counter-clockwise from (+, +); the lower layer is its mirror image.
_TABLE = np.array(
    [
        # hub        axis       spin
        [+1, +1, +1, -1, +0, 1, -1],
        [-1, +1, +1, +0, -1, 1, +1],
        [-1, -1, +1, +1, +0, 1, -1],
        [+1, -1, +1, +0, +1, 1, +1],
        [+1, +1, -1, +1, +0, 1, -1],
        [-1, +1, -1, +0, +1, 1, +1],
        [-1, -1, -1, -1, +0, 1, -1],
        [+1, -1, -1, +0, -1, 1, +1],
    ]
)


def _rank(matrix: FloatArray) -> int:
    # In units of the half-edge, so that forces and torques weigh the same.
    scaled = matrix / np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])[:, np.newaxis]
    return int(np.linalg.matrix_rank(scaled, tol=1e-9 * float(np.linalg.norm(scaled))))


@case(_GEOMETRY)
def allocation_matrix_follows_the_table() -> Result:
    """A(α) of OmniMorph is what its table of hubs, axes and spins gives, at 73 tilts of a turn."""
    vehicle, errors = omnimorph(), []
    hub, spin = 0.1062 * _TABLE[:, :3], _TABLE[:, 6:]
    kappa = 2.754e-6 / 1.8638e-4
    for tilt in np.linspace(-np.pi, np.pi, 73):
        z = _TABLE[:, 3:6] * np.array([np.sin(tilt), np.sin(tilt), np.cos(tilt)])
        expected = np.hstack([z, np.cross(hub, z) - kappa * spin * z]).T
        errors.append(largest(allocation_matrix(vehicle, float(tilt)) - expected))
    return Result(value=max(errors), tolerance=1e-14, unit="N/N, N m/N")


@case("O. Rodrigues' rotation about the hinge, as the exponential of its cross matrix")
def thrust_axes_turn_about_their_hinges() -> Result:
    """Any rotor's thrust axis z0 + zC cos α + zS sin α is its axis turned about its hinge by α."""
    numbers = np.random.default_rng(2024)
    n, errors = 8, []
    unit = numbers.normal(size=(2, n, 3))
    axis, hinge = unit / np.linalg.norm(unit, axis=2, keepdims=True)
    servo = np.array([0, 1, 2, -1, 1, 0, 2, -1])
    vehicle = omnimorph().replace(
        rotor_axis=axis,
        hinge_axis=np.where(servo[:, np.newaxis] >= 0, hinge, 0.0),
        rotor_servo=servo,
        servo_name=("a", "b", "c"),
        **{name: np.full(3, 1.0) for name in ("servo_angle_max", "servo_rate_max")},
        **{name: np.full(3, -1.0) for name in ("servo_angle_min",)},
        servo_time_constant=np.zeros(3),
    )
    for tilt in numbers.uniform(-4.0, 4.0, size=(20, 3)):
        angle = np.append(tilt, 0.0)[servo]
        turned = [rotation_exponential(angle[i] * hinge[i]) @ axis[i] for i in range(n)]
        errors.append(largest(allocation_matrix(vehicle, tilt)[:3].T - turned))
        errors.append(largest(spin_axes(vehicle, tilt) - turned))
    return Result(value=max(errors), tolerance=1e-14)


@case("central differences of A(α) f, step 1e-5 rad")
def tilt_derivative_is_the_difference_quotient() -> Result:
    """∂(A(α) f)/∂α is the limit of the difference quotient, and the last column of F(f, α)."""
    vehicle, numbers, step = omnimorph(), np.random.default_rng(7), 1e-5
    errors = []
    for tilt in np.linspace(-1.6, 1.6, 33):
        thrust = numbers.uniform(-5.0, 5.0, 8)
        either = [allocation_matrix(vehicle, float(tilt + h)) @ thrust for h in (-step, step)]
        slope = (either[1] - either[0]) / (2.0 * step)
        errors.append(largest(tilt_derivative(vehicle, thrust, float(tilt))[:, 0] - slope))
        errors.append(largest(full_allocation_matrix(vehicle, thrust, float(tilt))[:, 8] - slope))
    return Result(value=max(errors), tolerance=5e-9, unit="N/rad, N m/rad")


@case("Aboudorra et al. 2024, Sec. 2.3")
def rank_of_the_allocation_matrix() -> Result:
    """A(α) has rank 4 at α = kπ, 5 at π/2 + kπ and 6 at every other tilt: none of 147 differs."""
    special = {0: 4, 90: 5, 180: 4, 270: 5}
    wrong = 0
    for degrees in np.unique([*np.arange(0.0, 360.0, 2.5), 0.1, 7.92, 89.9]).tolist():
        rank = _rank(allocation_matrix(omnimorph(), np.radians(degrees)))
        wrong += rank != special.get(degrees, 6)
    return Result(value=wrong, tolerance=0.0, unit="tilts")


@case("singular values of F(f, α) for thrusts chosen to meet, or just to miss, the condition")
def rank_of_the_full_allocation_matrix() -> Result:
    """Tilting adds a direction at α = 0 if Σ f h ≠ 0, h where a rotor tilts, at 90° if Σ f ≠ 0."""
    vehicle = omnimorph()
    layers = np.array([1.0] * 4 + [2.0] * 4)  # not all equal, yet Σ f h = 0
    one = np.eye(8)[0]
    zero_sum = np.array([3.0, -1.0, 2.0, -4.0, 0.5, -0.5, 1.0, -1.0])
    expected = [
        (0.0, np.ones(8), 4),
        (0.0, layers, 4),
        (0.0, one, 5),
        (np.pi / 2, np.ones(8), 6),
        (np.pi / 2, one, 6),
        (np.pi / 2, zero_sum, 5),
    ]
    wrong = sum(
        _rank(full_allocation_matrix(vehicle, f, tilt)) != rank for tilt, f, rank in expected
    )
    return Result(value=wrong, tolerance=0.0, unit="matrices")


@case("closed form: the yaw of lever arm and drag cancel where tan α = κ / l")
def other_spins_lose_a_rank() -> Result:
    """With one sense of spin a layer the rank falls to 5 at α = atan(κ/l) = 7.92° too."""
    vehicle = omnimorph()
    layered = vehicle.replace(rotor_spin=np.array([1.0] * 4 + [-1.0] * 4))
    tilt = float(np.arctan(vehicle.kappa[0] / 0.1062))
    right = round(np.degrees(tilt), 2) == 7.92
    right &= _rank(allocation_matrix(layered, tilt)) == 5
    right &= _rank(allocation_matrix(layered, tilt + 0.01)) == 6
    right &= _rank(allocation_matrix(vehicle, tilt)) == 6
    return Result(value=float(right), expected=1.0, tolerance=0.0)


def _level(tilt_deg: float) -> HoverPoint:
    """Return how OmniMorph hovers level with the thrusts of least norm, as in the paper."""
    return hover(omnimorph(), np.radians(tilt_deg), least="norm")


@case(_FIGURES)
def hover_speed_level() -> Result:
    """With untilted rotors OmniMorph hovers at 93.01 Hz."""
    return Result(value=_level(0.0).speed.max() / TURN, expected=93.01, tolerance=0.005, unit="Hz")


@case(_FIGURES)
def hover_power_level_as_the_paper_counts() -> Result:
    """That takes 17.730 as the paper counts power, with speeds in Hz."""
    return Result(value=_level(0.0).power_paper, expected=17.730, tolerance=5e-4, unit="N m Hz")


@case(_FIGURES)
def hover_power_level() -> Result:
    """That takes 111.40 W of drag power."""
    return Result(value=_level(0.0).power, expected=111.40, tolerance=5e-3, unit="W")


@case(_FIGURES)
def hover_speed_tilted() -> Result:
    """At 60° of tilt OmniMorph hovers level at 131.54 Hz, with the thrusts of least norm."""
    return Result(
        value=_level(60.0).speed.max() / TURN, expected=131.54, tolerance=0.005, unit="Hz"
    )


@case(_FIGURES)
def hover_power_tilted_as_the_paper_counts() -> Result:
    """That takes 50.148 as the paper counts power."""
    return Result(value=_level(60.0).power_paper, expected=50.148, tolerance=5e-4, unit="N m Hz")


@case(_FIGURES)
def hover_power_tilted() -> Result:
    """That takes 315.09 W of drag power."""
    return Result(value=_level(60.0).power, expected=315.09, tolerance=5e-3, unit="W")
