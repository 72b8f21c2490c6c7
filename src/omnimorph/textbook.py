"""The paper's control loop, line by line, in NumPy and DAQP: slow, readable; tests the core.

Read it beside the section "Control" of Aboudorra et al., "Modelling, Analysis, and Control of
OmniMorph", JIRS 2024, doi 10.1007/s10846-024-02054-x. A control step asks three questions:

1. Which acceleration leads back to the reference?         `reference_acceleration`
2. Which thrusts give it at the least cost, at one tilt?   `allocate`, `solve_box_qp`
3. Which of three tilts is the cheapest?                   `three_candidates`

`step_actuators` and `step_body` then move the vehicle and `fly` closes the loop; nothing calls the
compiled core. SI units; W is the world (z up), B the body at the centre of mass; force comes before
torque. The inputs are thrusts f [N], where the paper has squared speeds u = f/c_f [Hz²].
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from omnimorph.design.vehicle import Vehicle
from omnimorph.protocols import Command, Desired, Reference, State
from omnimorph.protocols import FloatArray as Array

GRAVITY = 9.81  # m/s², along −z of W


class Gains(NamedTuple):
    """Feedback gains; the paper's values are the defaults."""

    velocity: float = 30.0  # K_p1, 1/s
    position: float = 300.0  # K_p2, 1/s²
    rate: float = 40.0  # K_ω1, 1/s
    attitude: float = 100.0  # K_ω2, 1/s²


class Weights(NamedTuple):
    """Diagonals of the paper's W1, W2 and W3, as printed: W1 and W3 are for inputs in Hz²."""

    input: float  # W1, 1/Hz⁴, on the effort
    acceleration: Sequence[float]  # W2 (6,), s⁴/m² then s⁴/rad², on the tracking
    change: float  # W3, 1/Hz⁴, on the change since the previous control step


class PlantSettings(NamedTuple):
    """How the vehicle is flown: periods, imperfect actuators, noise of the measurement."""

    physics_step: float  # s
    control_period: float  # s, a multiple of the physics step; commands are held in between
    actuators_lag: bool  # speeds lag by the time constants, tilts by the rate limit; or at once
    rotors_have_momentum: bool  # the spinning rotors carry angular momentum
    noise: Sequence[float]  # 1σ of position [m], velocity [m/s], attitude [rad], body rate [rad/s]


PAPER_GAINS = Gains()
CASE_A = Weights(1e-8, (3e6, 3e6, 3e6, 1e3, 1e3, 1e3), 1e-5)
CASE_B = Weights(1e-5, (3e4, 3e4, 3e4, 10.0, 10.0, 10.0), 1e-5)
PERFECT = PlantSettings(1e-3, 1e-3, False, False, (0.0, 0.0, 0.0, 0.0))
REALISTIC = PlantSettings(1e-3, 4e-3, True, True, (1e-3, 1e-2, 3e-3, 1e-2))


# ---- Rotations ----
def hat(v: Array) -> Array:
    """Skew matrix (3, 3) of a vector (3,): ``hat(a) @ b`` is the cross product a × b."""
    x, y, z = v.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def vee(S: Array) -> Array:
    """Vector (3,) of a skew matrix (3, 3), the inverse of `hat`."""
    return np.array([S[2, 1], S[0, 2], S[1, 0]])


def exp_so3(v: Array) -> Array:
    """Rotation (3, 3) by v (3,) [rad]: I + (sin θ/θ) V + ((1 − cos θ)/θ²) V², V = hat(v)."""
    V, half = hat(v), 0.5 * math.sqrt(v @ v)
    a = math.sin(half) / half if half > 0.0 else 1.0
    return np.eye(3) + (a * math.cos(half)) * V + (0.5 * a**2) * (V @ V)


# ---- The reference ----
def minimum_jerk(u: float) -> tuple[float, float, float]:
    """Blend s = 10u³ − 15u⁴ + 6u⁵, s' and s'' at 0 ≤ u ≤ 1; half-way they are 0.5, 1.875 and 0."""
    s = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    return s, 30.0 * u**2 * (1.0 - u) ** 2, 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)


class Segment(NamedTuple):
    """One move from rest to rest."""

    duration: float  # s
    displacement: Sequence[float] = (0.0, 0.0, 0.0)  # m, in W
    rotation: Sequence[float] = (0.0, 0.0, 0.0)  # rad, rotation vector in W


class SegmentedReference:
    """Minimum-jerk segments one after the other, begun level at `start` (3,) [m, W]; then it holds.

    With s((t − t0)/T) and the rotation vector φ [rad, W] of a segment, p = p0 + Δp s and
    R = exp(φ s) R0, so v = Δp ṡ, ω = R0ᵀφ ṡ (the axis stands still in B too), v̇ = Δp s̈, ω̇ = R0ᵀφ s̈.
    """

    def __init__(self, start: Sequence[float], segments: Sequence[Segment]) -> None:
        self.duration, self._moves = 0.0, []
        p, R, zero = np.array(start, dtype=float), np.eye(3), np.zeros(3)
        for segment in segments:
            step, phi = np.array(segment.displacement), np.array(segment.rotation)
            self._moves.append((self.duration, segment.duration, p, R, step, phi))
            p, R, self.duration = p + step, exp_so3(phi) @ R, self.duration + segment.duration
        self._hold = Desired(p, R, zero, zero, zero, zero)

    def __call__(self, time: float) -> Desired:
        """Desired motion at `time` [s]."""
        for t0, T, p0, R0, step, phi in self._moves:
            if time < t0 + T:
                s, ds, dds = minimum_jerk((time - t0) / T)
                p, R, phi_B = p0 + step * s, exp_so3(phi * s) @ R0, R0.T @ phi
                ds, dds = ds / T, dds / T**2
                return Desired(p, R, step * ds, phi_B * ds, step * dds, phi_B * dds)
        return self._hold


def paper_reference() -> SegmentedReference:
    """A 45 s reading of the paper's unpublished trajectory, from rest at z = 1.2 m."""
    segments = (
        Segment(3.0, (0.0, 0.0, 0.8)), Segment(3.0, (0.0, 0.0, -0.8)),
        Segment(3.0, (0.0, 0.5, 0.0)), Segment(3.0, (0.0, -0.5, 0.0)),
        Segment(2.0, rotation=(math.pi / 6.0, 0.0, 0.0)),
        Segment(3.0, (0.5, 0.0, 0.0)), Segment(3.0, (-0.5, 0.0, 0.0)),
        Segment(2.0, rotation=(-math.pi / 6.0, 0.0, 0.0)),
        Segment(18.0, rotation=(2.0 * math.pi, 0.0, 0.0)),
        Segment(3.0, (0.0, 0.0, 0.4)), Segment(2.0),
    )  # fmt: skip
    return SegmentedReference((0.0, 0.0, 1.2), segments)


# ---- The model ----
class _Constants(NamedTuple):
    """What the loop needs of a vehicle and what does not change in flight."""

    axes: tuple[Array, Array, Array]  # z0, zC, zS (n, 3) of `thrust_axes`
    arms: Array  # (n, 6, 3): the wrench of rotor i is arms_i z_i f_i
    servo: Array  # (n, m): row i is one at the servo of rotor i
    M_inverse: Array  # (6, 6)
    c: Array  # (n,) N/Hz², thrust coefficients as the paper counts them
    scale: Array  # (n,) N, the largest thrust either way
    box: tuple[Array, Array]  # (n,) least and largest thrust / scale


@lru_cache(maxsize=8)
def _constants(vehicle: Vehicle) -> _Constants:
    z, a = vehicle.rotor_axis, vehicle.hinge_axis
    along = np.sum(a * z, axis=1, keepdims=True) * a
    M, eye = np.zeros((6, 6)), np.eye(3)
    M[:3, :3], M[3:, 3:] = vehicle.mass * eye, vehicle.inertia
    arms = zip(vehicle.rotor_position, vehicle.rotor_spin * vehicle.kappa, strict=True)
    scale = np.maximum(np.abs(vehicle.thrust_min), np.abs(vehicle.thrust_max))
    return _Constants(
        axes=(along, z - along, np.cross(a, z)),
        arms=np.array([np.vstack([eye, hat(p) - k_kappa * eye]) for p, k_kappa in arms]),
        servo=(vehicle.rotor_servo[:, None] == np.arange(vehicle.n_servos)).astype(float),
        M_inverse=np.array(np.linalg.inv(M), dtype=float),
        c=vehicle.thrust_coefficient * (2.0 * math.pi) ** 2,
        scale=scale,
        box=(vehicle.thrust_min / scale, vehicle.thrust_max / scale),
    )


def thrust_axes(vehicle: Vehicle, tilt: Array) -> Array:
    """z_i(α) (n, 3), unit vectors in B: the axes turned about their hinges by the tilts (m,) [rad].

    Rodrigues: a (a·z) + (z − a (a·z)) cos α + (a × z) sin α = z0 + zC cos α + zS sin α.
    """
    constants = _constants(vehicle)
    alpha = (constants.servo @ tilt)[:, None]  # zero for a rotor without a servo
    z0, zC, zS = constants.axes
    return np.asarray(z0 + zC * np.cos(alpha) + zS * np.sin(alpha))


def allocation_matrix(vehicle: Vehicle, tilt: Array) -> Array:
    """A(α) (6, n): A f is the wrench [N; N m] in B about the centre of mass; tilt α (m,) [rad].

    Column i is [z_i; p_i × z_i − k_i κ_i z_i]. OmniMorph, α = 0: row 2 is ones, rows 0, 1 are zero.
    """
    z = thrust_axes(vehicle, tilt)
    return (_constants(vehicle).arms @ z[:, :, None])[:, :, 0].T


# ---- The controller ----
def reference_acceleration(state: State, desired: Desired, gains: Gains) -> Array:
    """q̈_r (6,) [m/s² in W; rad/s² in B], the first equation of the paper's section "Control".

    p̈_r = p̈_d + K_p1 ė_p + K_p2 e_p,  ω̇_r = RᵀR_d ω̇_d − ω × RᵀR_d ω_d + K_ω1 e_ω + K_ω2 e_R, with
    e_R = ½ (RᵀR_d − R_dᵀR)^∨, e_ω = RᵀR_d ω_d − ω; the paper omits RᵀR_d, desired B to actual B.
    """
    R_error, w = state.R_WB.T @ desired.R_WB, state.w_WB_B
    w_d = R_error @ desired.w_WB_B
    e_p, de_p = desired.p_WB - state.p_WB, desired.v_WB - state.v_WB
    e_R, e_w = 0.5 * vee(R_error - R_error.T), w_d - w
    dw_d = R_error @ desired.dw_WB_B - hat(w) @ w_d
    linear = desired.a_WB + gains.velocity * de_p + gains.position * e_p
    return np.concatenate([linear, dw_d + gains.rate * e_w + gains.attitude * e_R])


class Demand(NamedTuple):
    """The paper's equality constraint and q̈_r in one: q̈_r − q̈ = missing − gain A(α) f."""

    missing: Array  # (6,) q̈_r − M⁻¹μ
    gain: Array  # (6, 6) M⁻¹J_R


def build_demand(vehicle: Vehicle, state: State, acceleration: Array) -> Demand:
    """M q̈ = μ + J_R A f: M = diag(m I, J), J_R = diag(R, I), μ = [−m g e3; −ω × Jω]; q̈_r (6,)."""
    M_inverse, J_R, w = _constants(vehicle).M_inverse, np.eye(6), state.w_WB_B
    J_R[:3, :3] = state.R_WB
    mu = np.array([0.0, 0.0, -vehicle.mass * GRAVITY, *(-hat(w) @ (vehicle.inertia @ w))])
    return Demand(acceleration - M_inverse @ mu, M_inverse @ J_R)


def solve_box_qp(H: Array, g: Array, lower: Array, upper: Array) -> tuple[Array, float]:
    """Minimise ½ xᵀHx + gᵀx in lower ≤ x ≤ upper, H (n, n) positive definite: x and its residual.

    DAQP finds the active bounds; with these, the free variables are solved for exactly. The largest
    entry of x − clip(x − (Hx + g)) proves the answer: it vanishes only if every variable is within
    its bounds and every multiplier has its sign. H = I, g = (−2, 0.5), box ±1: x = (1, −0.5).
    """
    import daqp

    only_bounds = np.zeros((0, len(g)))
    _, _, _, info = daqp.solve(H, g, only_bounds, upper, lower, primal_tol=1e-12, dual_tol=1e-12)
    multiplier = info["lam"]  # positive at the upper bound, negative at the lower one
    x = np.where(multiplier > 0.0, upper, lower)
    free = (multiplier == 0.0).nonzero()[0]
    x[free] = 0.0
    x[free] = np.linalg.solve(H[free[:, None], free], -(g + H @ x)[free])
    return x, float(np.abs(x - np.clip(x - (H @ x + g), lower, upper)).max())


class Allocation(NamedTuple):
    """Thrusts (n,) [N] at a tilt (m,) [rad], their cost J1 + J2 + J3, the residual of their QP."""

    thrust: Array
    tilt: Array
    cost: float
    kkt_residual: float


def allocate(
    vehicle: Vehicle, tilt: Array, demand: Demand, previous: Array, weights: Weights
) -> Allocation:
    """Cheapest thrusts at one tilt (m,) [rad]: the paper's second optimisation, q̈ eliminated.

    min ‖u‖²_W1 + ‖q̈_r − q̈‖²_W2 + ‖u − u⁻‖²_W3 with f_min ≤ f = c u ≤ f_max; f⁻ is `previous` [N].
    """
    *_, c, scale, box = _constants(vehicle)
    W1, W2, W3 = weights.input, np.array(weights.acceleration), weights.change
    r, B = demand.missing, demand.gain @ allocation_matrix(vehicle, tilt)  # q̈_r − q̈ = r − B f

    # With x = f/scale, the cost is xᵀHx + 2gᵀx + constant; then the mean diagonal of H is made 1.
    E, D = B * scale, (scale / c) ** 2
    H = (E.T * W2) @ E + np.diag((W1 + W3) * D)
    g = -(E.T @ (W2 * r) + W3 * D * (previous / scale))
    size = H.trace() / len(g)
    x, kkt_residual = solve_box_qp(H / size, g / size, *box)

    # The three terms as they stand, not through H: close candidates must compare rightly.
    f = scale * x
    u, du, e = f / c, (f - previous) / c, r - B @ f
    cost = W1 * (u @ u) + W2 @ (e * e) + W3 * (du @ du)
    return Allocation(f, tilt, float(cost), kkt_residual)


def three_candidates(
    vehicle: Vehicle, epsilon: Array, demand: Demand, previous: Command, weights: Weights
) -> Allocation:
    """Cheapest of α⁻, α⁻ − ε and α⁻ + ε, each within the servo's limits; a tie goes to the earlier.

    ε (m,) [rad] is the servo's rate limit times the control period; several servos move as one.
    """
    low, high, f = vehicle.servo_angle_min, vehicle.servo_angle_max, previous.thrust
    tilts = (previous.tilt, previous.tilt - epsilon, previous.tilt + epsilon)
    candidates = [allocate(vehicle, np.clip(tilt, low, high), demand, f, weights) for tilt in tilts]
    return min(candidates, key=lambda candidate: candidate.cost)


# ---- The plant ----
def rotor_speed(vehicle: Vehicle, thrust: Array) -> Array:
    """Speeds w (n,) [rad/s] of thrusts (n,) [N], the inverse of f = c_f w |w|."""
    return np.sign(thrust) * np.sqrt(np.abs(thrust) / vehicle.thrust_coefficient)


def hover_thrust(vehicle: Vehicle, tilt: Array) -> Array:
    """Equal thrusts (n,) [N] that carry the level vehicle: m g / Σ e3·z_i(α) each."""
    lift = np.full(vehicle.n_rotors, thrust_axes(vehicle, tilt)[:, 2].sum())
    return vehicle.mass * GRAVITY / lift


def measure(state: State, sigma: Sequence[float], noise: Array) -> State:
    """`state` plus noise: 1σ of p, v, R and ω times a standard-normal row (12,) in this order."""
    p, v = state.p_WB + sigma[0] * noise[0:3], state.v_WB + sigma[1] * noise[3:6]
    R = state.R_WB @ exp_so3(sigma[2] * noise[6:9])
    return State(p, R, v, state.w_WB_B + sigma[3] * noise[9:12])


def step_actuators(
    vehicle: Vehicle, speed: Array, tilt: Array, command: Command, plant: PlantSettings
) -> tuple[Array, Array]:
    """Speeds (n,) [rad/s] and tilts (m,) [rad] at the end of a physics step under one command."""
    target, h = rotor_speed(vehicle, command.thrust), plant.physics_step
    if not plant.actuators_lag:
        return target, command.tilt
    faster = (np.abs(target) >= np.abs(speed)) & (target * speed >= 0.0)
    tau = np.where(faster, vehicle.time_constant_up, vehicle.time_constant_down)
    decay = np.exp(-h / np.maximum(tau, 1e-12))  # zero where there is no lag
    reach = vehicle.servo_rate_max * h
    return target + (speed - target) * decay, tilt + np.clip(command.tilt - tilt, -reach, reach)


def rotor_momentum(vehicle: Vehicle, speed: Array, tilt: Array) -> Array:
    """H = Σ I_i k_i w_i z_i(α) (3,) [kg m²/s] in B, of speeds w (n,) [rad/s] and tilts (m,)."""
    return (vehicle.spin_inertia * vehicle.rotor_spin * speed) @ thrust_axes(vehicle, tilt)


def step_body(
    vehicle: Vehicle, state: State, wrench: Array, h: float, H: Sequence[Array | float] = (0.0, 0.0)
) -> State:
    """Newton–Euler for h [s], semi-implicit Euler; wrench (6,) = [f_B; τ_B] [N; N m] in B.

    v̇ = −g e3 + R f_B/m, L̇ = −ω × L + τ_B, L = Jω + H with H before, after; then the new pose.
    """
    p, R, v, w = state
    v = v + h * (np.array([0.0, 0.0, -GRAVITY]) + R @ wrench[:3] / vehicle.mass)
    L = vehicle.inertia @ w + H[0]
    L = L + h * (wrench[3:] - hat(w) @ L)
    w = _constants(vehicle).M_inverse[3:, 3:] @ (L - H[1])
    return State(p + h * v, R @ exp_so3(h * w), v, w)


# ---- The loop ----
class TextbookFlight(NamedTuple):
    """Rows k = 0 … steps: motion and actuators at k h, the command from then on."""

    time: Array  # (K,) s
    p_WB: Array  # (K, 3) m
    R_WB: Array  # (K, 3, 3)
    v_WB: Array  # (K, 3) m/s
    w_WB_B: Array  # (K, 3) rad/s
    thrust_command: Array  # (K, n) N
    tilt_command: Array  # (K, m) rad
    tilt_actual: Array  # (K, m) rad
    speed: Array  # (K, n) rad/s, actual
    cost: Array  # (K,)
    kkt_residual: Array  # (K,)


def fly(
    vehicle: Vehicle,
    reference: Reference,
    gains: Gains,
    weights: Weights,
    plant: PlantSettings,
    duration: float,
    tilt: float = 0.0,
    noise: Array | None = None,
    fixed_tilt: bool = False,
) -> TextbookFlight:
    """Fly the paper's controller for `duration` [s], from a hover at `tilt` [rad] on the reference.

    `noise` has a standard-normal row (12,) for each control step, see `measure`; None measures
    exactly. With `fixed_tilt` the tilt stays where it is and only the thrusts are chosen.
    """
    if not plant.rotors_have_momentum:
        vehicle = vehicle.replace(spin_inertia=np.zeros(vehicle.n_rotors))
    h, period, c_f = plant.physics_step, plant.control_period, vehicle.thrust_coefficient
    steps, held = round(duration / h), round(period / h)
    angle, start, zero = np.full(vehicle.n_servos, float(tilt)), reference(0.0), np.zeros(3)
    epsilon = vehicle.servo_rate_max * period
    state = State(start.p_WB, start.R_WB, zero, zero)
    command = Command(hover_thrust(vehicle, angle), angle)
    speed, rows = rotor_speed(vehicle, command.thrust), []
    for k in range(steps + 1):
        if k % held == 0 and k < steps:
            sensed = state if noise is None else measure(state, plant.noise, noise[k // held])
            q_r = reference_acceleration(sensed, reference(k * h), gains)
            demand = build_demand(vehicle, sensed, q_r)
            if fixed_tilt:
                chosen = allocate(vehicle, command.tilt, demand, command.thrust, weights)
            else:
                chosen = three_candidates(vehicle, epsilon, demand, command, weights)
            command = Command(chosen.thrust, chosen.tilt)
        rows.append((k * h, *state, *command, angle, speed, chosen.cost, chosen.kkt_residual))
        H_before = rotor_momentum(vehicle, speed, angle)
        speed, angle = step_actuators(vehicle, speed, angle, command, plant)
        wrench = allocation_matrix(vehicle, angle) @ (c_f * speed * np.abs(speed))
        H = rotor_momentum(vehicle, speed, angle)
        state = step_body(vehicle, state, wrench, h, (H_before, H))
    return TextbookFlight(*(np.array(column) for column in zip(*rows, strict=True)))
