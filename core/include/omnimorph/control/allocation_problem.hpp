// The problem that allocation solves: the thrusts, and the tilts, that come closest to an acceleration under limits
// (the paper's eqs. 15 and 16), with the dynamics q̈ = M⁻¹(μ + J_R (A(α) f + bias)) put in:
//
//     J(f, α) = ‖u‖²_W1 + ‖q̈_r − q̈‖²_W2 + ‖u − u⁻‖²_W3,   u = f / c_f in Hz²
//
// written in x = f / f_scale. The cost is summed term by term, never through x'Hx: answers differ by less than what
// cancels.
#pragma once

#include "../model/wrench.hpp"
#include "tracking.hpp"

namespace omnimorph {

template <class T, int N> struct AllocationWeights {
    PerRotor<T, N> input, input_change;  // W1 and W3, for thrust: 1/N²
    Vec6<T> acceleration;                // W2: s⁴/m² then s⁴/rad²

    static constexpr auto fields() {
        using W = AllocationWeights;
        return field_list(field("input", &W::input), field("input_change", &W::input_change),
                          field("acceleration", &W::acceleration));
    }
};

/// An answer that proves itself.
template <class T, int N> struct Allocation {
    Command<T, N> command;
    PerRotor<T, N> active;  // -1 at the least thrust, 0 free, +1 at the largest
    T cost, kkt_residual;
    Vec6<T> wrench_asked;  // of the rotors, in B, by the model

    static constexpr auto fields() {
        using A = Allocation;
        return field_list(field("command", &A::command), field("active", &A::active), field("cost", &A::cost),
                          field("kkt_residual", &A::kkt_residual), field("wrench_asked", &A::wrench_asked));
    }
};

/// Newton and Euler solved for the wrench: [m Rᵀ(p̈ + g e3) ; J ẇ + w x J w], in B.
template <class T, int N>
OMNIMORPH_FN Vec6<T> wrench_for(const Vehicle<T, N>& vehicle, const Motion<T>& state, const Vec6<T>& acceleration) {
    const Vec3<T> linear{{acceleration[0], acceleration[1], acceleration[2] + T(gravity)}};
    const Vec3<T> angular{{acceleration[3], acceleration[4], acceleration[5]}};
    const Vec3<T> force = vehicle.mass * transpose_times(state.R, linear);
    const Vec3<T> torque = vehicle.inertia * angular + cross(state.w, vehicle.inertia * state.w);
    return {{force[0], force[1], force[2], torque[0], torque[1], torque[2]}};
}

/// The problem of one vehicle, scaled. `allocation_problem` builds it; the `set_...` functions below change it, in
/// every control step if need be, and keep what follows in agreement.
template <class T, int N> struct AllocationProblem {
    Vehicle<T, N> vehicle;
    AllocationWeights<T, N> weights;
    PerRotor<T, N> thrust_min, thrust_max;  // the bounds, N
    PerRotor<T, N> effectiveness;           // share of the commanded thrust that each rotor gives
    Vec6<T> wrench_bias;                    // N and N m in B, beside the rotors'
    long version;                           // of what caches hold; 1 at first, 0 is that of an empty cache

    // What follows from them.
    PerRotor<T, N> scale;         // f_scale, the larger limit of each rotor of the vehicle
    WrenchMap<T, N> map;          // A f_scale, weighted as far as it is the same in every attitude
    PerRotor<T, N> lower, upper;  // bounds of x
    PerRotor<T, N> diagonal;      // (W1 + W3) f_scale²
    Vec6<T> root_weight;          // W2^½
    Vec3<T> linear_gain;          // W2^½ / m
    Vec6<T> bias_acceleration;    // of the bias alone, in B
    bool in_body;                 // W2 weighs all directions of force alike, so that the map holds all of it
    bool is_biased;
};

namespace allocation_problem_parts {

template <class T, int N> OMNIMORPH_FN PerRotor<T, N> thrust_scale(const Vehicle<T, N>& vehicle) {
    PerRotor<T, N> scale{};
    for (int i = 0; i < vehicle.n_rotors; ++i) scale[i] = max(abs(vehicle.thrust_min(i)), abs(vehicle.thrust_max(i)));
    return scale;
}

/// W2^½ J⁻¹ is the same in every attitude: the torque rows of the map hold it from the beginning. Where W2 weighs every
/// direction alike the force rows hold W2^½ / m too, and accelerations are expressed in B: one rotation instead of n.
template <class T, int N> OMNIMORPH_FN void update_map(AllocationProblem<T, N>& problem) {
    PerRotor<T, N> unit{};
    for (int i = 0; i < problem.vehicle.n_rotors; ++i) unit[i] = problem.scale[i] * problem.effectiveness[i];
    problem.map = thrust_wrench_map(problem.vehicle, unit);
    Mat3<T> gain;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) gain[r][c] = problem.root_weight[3 + r] * problem.vehicle.inertia_inverse[r][c];
    for (int i = 0; i < problem.vehicle.n_rotors; ++i)
        for (Vec6<T>* column : {&problem.map.constant[i], &problem.map.cosine[i], &problem.map.sine[i]}) {
            const Vec3<T> torque = gain * torque_of(*column);
            for (int r = 0; r < 3; ++r) {
                if (problem.in_body) (*column)[r] *= problem.linear_gain[r];
                (*column)[3 + r] = torque[r];
            }
        }
}

}  // namespace allocation_problem_parts

/// Other bounds of the thrusts, N: of a rotor that heats up or is to stop.
template <class T, int N>
OMNIMORPH_FN void set_bounds(AllocationProblem<T, N>& problem, const PerRotor<T, N>& low, const PerRotor<T, N>& high) {
    problem.thrust_min = low;
    problem.thrust_max = high;
    for (int i = 0; i < problem.vehicle.n_rotors; ++i) {
        problem.lower[i] = low[i] / problem.scale[i];
        problem.upper[i] = high[i] / problem.scale[i];
    }
    ++problem.version;
}

/// The share of its commanded thrust that each rotor gives: 1 where it is as the model says, 0 where it is lost.
template <class T, int N>
OMNIMORPH_FN void set_effectiveness(AllocationProblem<T, N>& problem, const PerRotor<T, N>& share) {
    problem.effectiveness = share;
    allocation_problem_parts::update_map(problem);
    ++problem.version;
}

/// A wrench in B that acts beside the rotors' (N, N m), such as one that an observer has found. No cache depends on it.
template <class T, int N> OMNIMORPH_FN void set_wrench_bias(AllocationProblem<T, N>& problem, const Vec6<T>& bias) {
    problem.wrench_bias = bias;
    const Vec3<T> angular = problem.vehicle.inertia_inverse * torque_of(bias);
    Mask<T> is_zero = T(0) == T(0);
    for (int r = 0; r < 3; ++r) {
        problem.bias_acceleration[r] = bias[r] / problem.vehicle.mass;
        problem.bias_acceleration[3 + r] = angular[r];
        const Mask<T> no_force = bias[r] == T(0), no_torque = bias[3 + r] == T(0);
        is_zero = is_zero & no_force & no_torque;
    }
    problem.is_biased = any(!is_zero);
}

template <class T, int N>
OMNIMORPH_FN void set_weights(AllocationProblem<T, N>& problem, const AllocationWeights<T, N>& weights) {
    problem.weights = weights;
    for (int i = 0; i < problem.vehicle.n_rotors; ++i)
        problem.diagonal[i] = (weights.input[i] + weights.input_change[i]) * problem.scale[i] * problem.scale[i];
    const Vec6<T>& w = weights.acceleration;
    for (int r = 0; r < 6; ++r) problem.root_weight[r] = sqrt(w[r]);
    for (int r = 0; r < 3; ++r) problem.linear_gain[r] = problem.root_weight[r] / problem.vehicle.mass;
    const Mask<T> x_as_y = w[0] == w[1], y_as_z = w[1] == w[2];
    problem.in_body = all(x_as_y & y_as_z);
    allocation_problem_parts::update_map(problem);
    ++problem.version;
}

/// The problem of a vehicle whose rotors all give what its model says, within its limits and without a bias. Start it
/// with an empty cache: versions are counted for each problem.
template <class T, int N>
OMNIMORPH_FN AllocationProblem<T, N> allocation_problem(const Vehicle<T, N>& vehicle,
                                                        const AllocationWeights<T, N>& weights) {
    const PerRotor<T, N> scale = allocation_problem_parts::thrust_scale(vehicle);
    PerRotor<T, N> low{}, high{}, all{};
    for (int i = 0; i < vehicle.n_rotors; ++i) {
        low[i] = vehicle.thrust_min(i);
        high[i] = vehicle.thrust_max(i);
        all[i] = T(1);
    }
    const Vec6<T> none = Vec6<T>::zero();
    const WrenchMap<T, N> map = thrust_wrench_map(vehicle, scale);  // not weighted yet
    AllocationProblem<T, N> problem{vehicle, weights,         low,  high,  all,  none, 0, scale, map, {}, {}, {},
                                    none,    Vec3<T>::zero(), none, false, false};
    set_bounds(problem, low, high);
    set_weights(problem, weights);
    problem.version = 1;
    return problem;
}

/// What does not depend on the tilt: the force part of C = W2^½ M⁻¹ J_R that the map does not hold, W2^½ R / m, and
/// b = W2^½ (q̈_r − M⁻¹ (μ + J_R bias)).
template <class T> struct AllocationTarget {
    Mat3<T> force_gain;
    bool in_body;
    Vec6<T> b, wrench_asked;
};

namespace allocation_problem_parts {

/// Ask the rotors for less by what the bias gives.
template <class T, int N>
OMNIMORPH_FN void subtract_bias(const AllocationProblem<T, N>& problem, const Motion<T>& estimate,
                                AllocationTarget<T>& target) {
    Vec3<T> linear = force_of(problem.bias_acceleration);
    if (!target.in_body) linear = estimate.R * linear;
    const Vec6<T> acceleration = joined(linear, torque_of(problem.bias_acceleration));
    for (int r = 0; r < 6; ++r) target.b[r] -= problem.root_weight[r] * acceleration[r];
    target.wrench_asked = target.wrench_asked - problem.wrench_bias;
}

}  // namespace allocation_problem_parts

template <class T, int N>
OMNIMORPH_FN AllocationTarget<T> allocation_target(const AllocationProblem<T, N>& problem, const Motion<T>& estimate,
                                                   const Demand<T>& demand) {
    const Vehicle<T, N>& vehicle = problem.vehicle;
    const Vec6<T>& asked = demand.acceleration;
    AllocationTarget<T> target;
    target.in_body = problem.in_body;
    target.wrench_asked = wrench_for(vehicle, estimate, asked);
    const Vec3<T> gyroscopic = vehicle.inertia_inverse * cross(estimate.w, vehicle.inertia * estimate.w);
    Vec3<T> linear{{asked[0], asked[1], asked[2] + T(gravity)}};
    if (target.in_body) linear = transpose_times(estimate.R, linear);
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) target.force_gain[r][c] = problem.linear_gain[r] * estimate.R[r][c];
        target.b[r] = problem.root_weight[r] * linear[r];
        target.b[3 + r] = problem.root_weight[3 + r] * (asked[3 + r] + gyroscopic[r]);
    }
    if (problem.is_biased) allocation_problem_parts::subtract_bias(problem, estimate, target);
    return target;
}

/// C w of a wrench that is weighted already as far as the map is; U is T, or a pack of tilts for one vehicle.
template <class T, class U> OMNIMORPH_FN Vec6<U> weighted(const AllocationTarget<T>& target, const Vec6<U>& w) {
    return target.in_body ? w : joined(cast<U>(target.force_gain) * force_of(w), torque_of(w));
}
/// The same backwards: with it, a row of errors times C is a row of errors times the map.
template <class T> OMNIMORPH_FN Vec6<T> pulled_back(const AllocationTarget<T>& target, const Vec6<T>& error) {
    return target.in_body ? error : joined(transpose_times(target.force_gain, force_of(error)), torque_of(error));
}

/// G = C A(α) f_scale, column by column, so that A itself is nowhere stored.
template <class T, int N, class U>
OMNIMORPH_FN WrenchMatrix<U, N> weighted_map(const AllocationProblem<T, N>& problem, const AllocationTarget<T>& target,
                                             const TiltTrigonometry<U>& trig) {
    if (target.in_body) return problem.map.template at<U>(trig);
    WrenchMatrix<U, N> G;
    for (int i = 0; i < problem.vehicle.n_rotors; ++i)
        G.column[i] = weighted(target, problem.map.template column_at<U>(i, trig));
    return G;
}

/// b − G x, whose square is what the error of the acceleration costs; X holds a number for each rotor.
template <class T, int N, class U, class X>
OMNIMORPH_FN Vec6<U> weighted_error(const AllocationProblem<T, N>& problem, const AllocationTarget<T>& target,
                                    const WrenchMatrix<U, N>& G, const X& x) {
    Vec6<U> error;
    for (int r = 0; r < 6; ++r) error[r] = U(target.b[r]);
    for (int i = 0; i < problem.vehicle.n_rotors; ++i)
        for (int r = 0; r < 6; ++r) error[r] -= G.column[i][r] * x[i];
    return error;
}

/// J
template <class T, int N, class U, class X>
OMNIMORPH_FN U allocation_cost(const AllocationProblem<T, N>& problem, const Vec6<U>& error, const X& x,
                               const PerRotor<T, N>& previous) {
    const AllocationWeights<T, N>& weights = problem.weights;
    U inputs = U(0);
    for (int i = 0; i < problem.vehicle.n_rotors; ++i) {
        const U thrust = U(problem.scale[i]) * x[i];
        const U change = thrust - U(previous[i]);
        inputs += U(weights.input[i]) * thrust * thrust + U(weights.input_change[i]) * change * change;
    }
    return inputs + dot(error, error);
}

}  // namespace omnimorph
