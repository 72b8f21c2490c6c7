// The problem that allocation solves: the thrusts, and the tilts, that come closest to an acceleration under limits (the
// paper's eqs. 15 and 16), with the dynamics q̈ = M⁻¹(μ + J_R A(α) f) put in:
//
//     J(f, α) = ‖u‖²_W1 + ‖q̈_r − q̈‖²_W2 + ‖u − u⁻‖²_W3,   u = f / c_f in Hz²
//
// written in x = f / f_scale. The cost is summed term by term, never through x'Hx: answers differ by less than what cancels.
#pragma once

#include "box_qp.hpp"
#include "tracking.hpp"
#include "../model/wrench.hpp"

namespace omnimorph {

template <class T, int N> struct AllocationWeights {
    PerRotor<T, N> input, input_change;  // W1 and W3, for thrust: 1/N²
    Vec6<T> acceleration;                // W2: s⁴/m² then s⁴/rad²
    T tilt_change = T(0);                // W4, for a change of a tilt by all that a control step allows; counts where tilts are free
    static constexpr auto fields() { using W = AllocationWeights; return std::make_tuple(field("input", &W::input), field("input_change", &W::input_change), field("acceleration", &W::acceleration), field("tilt_change", &W::tilt_change)); }
};

/// An answer that proves itself.
template <class T, int N> struct Allocation {
    Command<T, N> command;
    PerRotor<T, N> active;  // -1 at the least thrust, 0 free, +1 at the largest
    T cost, kkt_residual;
    Vec6<T> wrench_asked;   // in B, by the model
    static constexpr auto fields() { using A = Allocation; return std::make_tuple(field("command", &A::command), field("active", &A::active), field("cost", &A::cost), field("kkt_residual", &A::kkt_residual), field("wrench_asked", &A::wrench_asked)); }
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

/// What every way of solving it shares: the problem of one vehicle, scaled.
template <class T, int N> class OldProblem {
  public:
    OldProblem(const Vehicle<T, N>& vehicle, const AllocationWeights<T, N>& weights)
        : vehicle_(vehicle), weights_(weights), scale_(thrust_scale(vehicle)), map_(thrust_wrench_map(vehicle, scale_)) {
        for (int i = 0; i < vehicle.n_rotors; ++i) {
            lower_[i] = vehicle.thrust_min(i) / scale_[i];
            upper_[i] = vehicle.thrust_max(i) / scale_[i];
            diagonal_[i] = (weights.input[i] + weights.input_change[i]) * scale_[i] * scale_[i];
        }
        for (int r = 0; r < 3; ++r) {
            root_weight_[r] = sqrt(weights.acceleration[r]);
            root_weight_[3 + r] = sqrt(weights.acceleration[3 + r]);
            linear_gain_[r] = root_weight_[r] / vehicle.mass;
        }
        const Vec6<T>& w = weights.acceleration;
        in_body_ = !any(!((w[0] == w[1]) & (w[1] == w[2])));
        weigh_map();
    }

  protected:
    static PerRotor<T, N> thrust_scale(const Vehicle<T, N>& vehicle) {
        PerRotor<T, N> scale{};
        for (int i = 0; i < vehicle.n_rotors; ++i)
            scale[i] = max(abs(vehicle.thrust_min(i)), abs(vehicle.thrust_max(i)));
        return scale;
    }

    /// W2^½ J⁻¹ is the same in every attitude: the torque rows of the map hold it from the beginning. Where W2 weighs every
    /// direction alike the force rows hold W2^½ / m too, and accelerations are looked at in B: one rotation instead of n.
    void weigh_map() {
        Mat3<T> gain;
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) gain[r][c] = root_weight_[3 + r] * vehicle_.inertia_inverse[r][c];
        for (int i = 0; i < vehicle_.n_rotors; ++i)
            for (Vec6<T>* column : {&map_.constant[i], &map_.cosine[i], &map_.sine[i]}) {
                const Vec3<T> torque = gain * torque_of(*column);
                for (int r = 0; r < 3; ++r) {
                    if (in_body_) (*column)[r] *= linear_gain_[r];
                    (*column)[3 + r] = torque[r];
                }
            }
    }

    /// What does not depend on the tilt: the force part of C = W2^½ M⁻¹ J_R that the map does not hold, W2^½ R / m, and
    /// b = W2^½ (q̈_r − M⁻¹ μ).
    struct Target {
        Mat3<T> force_gain;
        bool in_body;
        Vec6<T> b, wrench_asked;

        Target(const OldProblem& a, const Motion<T>& state, const Vec6<T>& acceleration) : in_body(a.in_body_) {
            const Vec3<T> gyroscopic = a.vehicle_.inertia_inverse * cross(state.w, a.vehicle_.inertia * state.w);
            wrench_asked = wrench_for(a.vehicle_, state, acceleration);
            Vec3<T> linear{{acceleration[0], acceleration[1], acceleration[2] + T(gravity)}};
            if (in_body) linear = transpose_times(state.R, linear);
            for (int r = 0; r < 3; ++r) {
                for (int c = 0; c < 3; ++c) force_gain[r][c] = a.linear_gain_[r] * state.R[r][c];
                b[r] = a.root_weight_[r] * linear[r];
                b[3 + r] = a.root_weight_[3 + r] * (acceleration[3 + r] + gyroscopic[r]);
            }
        }

        /// C w of a wrench that is weighted already as far as the map is.
        template <class U = T> Vec6<U> weighted(const Vec6<U>& w) const {
            return in_body ? w : joined(cast<U>(force_gain) * force_of(w), torque_of(w));
        }
        /// The same backwards: with it, a row of errors times C is a row of errors times the map.
        Vec6<T> pulled_back(const Vec6<T>& miss) const {
            return in_body ? miss : joined(transpose_times(force_gain, force_of(miss)), torque_of(miss));
        }
    };

    /// G = C A(α) f_scale, column by column, so that A itself is nowhere stored.
    template <class U> WrenchMatrix<U, N> weighted_map(const Target& target, const TiltTrigonometry<U>& trig) const {
        if (target.in_body) return map_.template at<U>(trig);
        WrenchMatrix<U, N> G;
        for (int i = 0; i < vehicle_.n_rotors; ++i) G.column[i] = target.weighted(map_.template column_at<U>(i, trig));
        return G;
    }

    /// b − G x, whose square is what the acceleration missed costs.
    template <class U, class X> Vec6<U> missed(const Target& target, const WrenchMatrix<U, N>& G, const X& x) const {
        Vec6<U> miss;
        for (int r = 0; r < 6; ++r) miss[r] = U(target.b[r]);
        for (int i = 0; i < vehicle_.n_rotors; ++i)
            for (int r = 0; r < 6; ++r) miss[r] -= G.column[i][r] * x[i];
        return miss;
    }

    /// J
    template <class U, class X> U cost(const Vec6<U>& miss, const X& x, const Allocation<T, N>& previous) const {
        U inputs = U(0);
        for (int i = 0; i < vehicle_.n_rotors; ++i) {
            const U thrust = U(scale_[i]) * x[i];
            const U change = thrust - U(previous.command.thrust[i]);
            inputs += U(weights_.input[i]) * thrust * thrust + U(weights_.input_change[i]) * change * change;
        }
        return inputs + dot(miss, miss);
    }

    Vehicle<T, N> vehicle_;
    AllocationWeights<T, N> weights_;
    PerRotor<T, N> scale_;             // f_scale, the larger limit of each rotor
    WrenchMap<T, N> map_;              // A f_scale, weighted as far as it is the same in every attitude
    PerRotor<T, N> lower_, upper_;     // limits of x
    PerRotor<T, N> diagonal_;          // (W1 + W3) f_scale²
    Vec6<T> root_weight_;              // W2^½
    Vec3<T> linear_gain_;              // W2^½ / m
    bool in_body_;                     // the map holds it
};

}  // namespace omnimorph
