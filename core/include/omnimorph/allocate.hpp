// Allocation: the thrusts, and the tilt, that come closest to an acceleration under limits (the paper's eqs. 15 and 16).
//
// At a fixed tilt the paper's problem, with the dynamics q̈ = M⁻¹(μ + J_R A(α) f) put in, is a box QP in the thrusts:
//
//     J(f) = ‖u‖²_W1 + ‖q̈_r − q̈‖²_W2 + ‖u − u⁻‖²_W3,   u = f / c_f in Hz²
//
// written in x = f / f_scale and divided by the mean of the diagonal of its Hessian, so that tolerances mean the same for
// every vehicle. The cost is summed term by term, never through x'Hx: the candidates differ by less than the cancellation.
#pragma once

#include "box_qp.hpp"
#include "tracking.hpp"
#include "wrench.hpp"

namespace omnimorph {

template <class T, int N> struct AllocationWeights {
    PerRotor<T, N> input, input_change;  // W1 and W3, for thrust: 1/N²
    Vec6<T> acceleration;                // W2: s⁴/m² then s⁴/rad²
};

/// An answer that proves itself.
template <class T, int N> struct Allocation {
    Command<T, N> command;
    PerRotor<T, N> active;  // -1 at the least thrust, 0 free, +1 at the largest
    T cost, kkt_residual;
    Vec6<T> wrench_asked;   // in B, by the model
};

/// Newton and Euler solved for the wrench: [m Rᵀ(p̈ + g e3) ; J ẇ + w x J w], in B.
template <class T, int N>
inline Vec6<T> wrench_for(const Vehicle<T, N>& vehicle, const Motion<T>& state, const Vec6<T>& acceleration) {
    const Vec3<T> linear{{acceleration[0], acceleration[1], acceleration[2] + T(gravity)}};
    const Vec3<T> angular{{acceleration[3], acceleration[4], acceleration[5]}};
    const Vec3<T> force = vehicle.mass * transpose_times(state.R, linear);
    const Vec3<T> torque = vehicle.inertia * angular + cross(state.w, vehicle.inertia * state.w);
    return {{force[0], force[1], force[2], torque[0], torque[1], torque[2]}};
}

/// Where the tilts lie that one control step tries: a step to either side of α⁻, or anywhere in the servo's limits.
enum class TiltSpan { window, range };

/// The tilts of a single servo that one control step tries, within its limits; number 0 is α⁻, so that a tie goes to it.
template <class T> struct TiltCandidates {
    TiltSpan span;
    int spaced;           // how many are evenly spaced; in a window α⁻ is the middle one of them
    T stay, change;       // α⁻, and ε, the most that the tilt may change
    T low, high;

    int count() const { return span == TiltSpan::window ? spaced : spaced + 1; }

    T operator[](int k) const {
        if (k == 0) return clamp(stay, low, high);
        if (span == TiltSpan::range) return clamp(low + T(double(k - 1) / (spaced - 1)) * (high - low), low, high);
        const int away = k % 2 == 1 ? -(k + 1) / 2 : k / 2;  // -1, 1, -2, 2 …: the nearest first
        return clamp(stay + T(double(away) / (spaced / 2)) * change, low, high);
    }
};

template <class T, int N> class Allocator {
  public:
    Allocator(const Vehicle<T, N>& vehicle, const AllocationWeights<T, N>& weights)
        : vehicle_(vehicle), weights_(weights), scale_(thrust_scale(vehicle)), map_(thrust_wrench_map(vehicle, scale_)) {
        for (int i = 0; i < vehicle.n_rotors; ++i) {
            lower_[i] = vehicle.thrust_min(i) / scale_[i];
            upper_[i] = vehicle.thrust_max(i) / scale_[i];
            diagonal_[i] = (weights.input[i] + weights.input_change[i]) * scale_[i] * scale_[i];
        }
        for (int r = 0; r < 3; ++r) {
            root_weight_[r] = square_root(weights.acceleration[r]);
            root_weight_[3 + r] = square_root(weights.acceleration[3 + r]);
            linear_gain_[r] = root_weight_[r] / vehicle.mass;
        }
        weigh_torques();
    }

    /// The thrusts at the previous tilt.
    Allocation<T, N> at_fixed_tilt(const Motion<T>& state, const Vec6<T>& acceleration, const Allocation<T, N>& previous) const {
        const Target target(*this, state, acceleration);
        const auto trig = trigonometry_of(previous.command.tilt, vehicle_.n_servos);
        return answer<T>(target, solve_at<T>(target, trig, previous), previous.command.tilt);
    }

    /// The best of `candidates` tilts of a single servo from α⁻ − ε to α⁻ + ε; of three, this is the paper's rule (its Sec. 3).
    Allocation<T, N> best_in_window(const Motion<T>& state, const Vec6<T>& acceleration, const Allocation<T, N>& previous, const T& epsilon,
                                    int candidates) const {
        const Target target(*this, state, acceleration);
        return best_of(target, candidates_of(TiltSpan::window, candidates, previous, epsilon), previous);
    }

    /// From α⁻ by at most ε towards the best of α⁻ and `candidates` tilts over the whole range of a single servo.
    Allocation<T, N> towards_best_in_range(const Motion<T>& state, const Vec6<T>& acceleration, const Allocation<T, N>& previous, const T& epsilon,
                                           int candidates) const {
        const Target target(*this, state, acceleration);
        const TiltCandidates<T> tried = candidates_of(TiltSpan::range, candidates, previous, epsilon);
        const Allocation<T, N> aim = best_of(target, tried, previous);
        const T tilt = clamp(aim.command.tilt[0], tried[0] - epsilon, tried[0] + epsilon);
        const Mask<T> reached = tilt == aim.command.tilt[0];
        return any(opposite(reached)) ? selected(reached, aim, at_tilt(target, tilt, previous)) : aim;
    }

    /// The least cost at each of `count` tilts of a single servo, four of them side by side (T is a scalar).
    void cost_over_tilt(const Motion<T>& state, const Vec6<T>& acceleration, const Allocation<T, N>& previous, const T* tilt, int count, T* cost) const {
        const Target target(*this, state, acceleration);
        for (int k = 0; k < count; k += 4) {
            const Solved<Lanes> solved = solve_at_angle(target, side_by_side(tilt, k, count), previous);
            for (int lane = 0; lane < 4 && k + lane < count; ++lane) cost[k + lane] = solved.cost[lane];
        }
    }

  private:
    using Lanes = Pack<Scalar<T>, 4>;  // candidates of one vehicle

    static PerRotor<T, N> thrust_scale(const Vehicle<T, N>& vehicle) {
        PerRotor<T, N> scale{};
        for (int i = 0; i < vehicle.n_rotors; ++i)
            scale[i] = maximum(magnitude(vehicle.thrust_min(i)), magnitude(vehicle.thrust_max(i)));
        return scale;
    }

    /// W2^½ J⁻¹ is the same in every attitude: the torque rows of the map hold it from the beginning.
    void weigh_torques() {
        Mat3<T> gain;
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) gain[r][c] = root_weight_[3 + r] * vehicle_.inertia_inverse[r][c];
        for (int i = 0; i < vehicle_.n_rotors; ++i)
            for (Vec6<T>* column : {&map_.constant[i], &map_.cosine[i], &map_.sine[i]}) {
                const Vec3<T> torque = gain * torque_of(*column);
                for (int r = 0; r < 3; ++r) (*column)[3 + r] = torque[r];
            }
    }

    /// What does not depend on the tilt: W2^½ R / m, the force part of C = W2^½ M⁻¹ J_R, and b = W2^½ (q̈_r − M⁻¹ μ).
    struct Target {
        Mat3<T> force_gain;
        Vec6<T> b, wrench_asked;
        Target(const Allocator& a, const Motion<T>& state, const Vec6<T>& acceleration) {
            const Vec3<T> gyroscopic = a.vehicle_.inertia_inverse * cross(state.w, a.vehicle_.inertia * state.w);
            wrench_asked = wrench_for(a.vehicle_, state, acceleration);
            for (int r = 0; r < 3; ++r) {
                for (int c = 0; c < 3; ++c) force_gain[r][c] = a.linear_gain_[r] * state.R[r][c];
                b[r] = a.root_weight_[r] * (acceleration[r] + T(r == 2 ? gravity : 0));
                b[3 + r] = a.root_weight_[3 + r] * (acceleration[3 + r] + gyroscopic[r]);
            }
        }
    };

    template <class U> struct Solved {
        BoxQpSolution<U, N> qp;
        U cost;
    };

    /// The box QP at one tilt, or at a pack of them; U is T or a pack of candidates of one vehicle.
    template <class U>
    Solved<U> solve_at(const Target& target, const TiltTrigonometry<U>& trig, const Allocation<T, N>& previous) const {
        const Count<N> n = vehicle_.n_rotors;
        const WrenchMatrix<U, N> G = weighted_map<U>(target, map_.template at<U>(trig));
        BoxQp<U, N> qp(n);
        Solved<U> s;
        U trace = U(0);
        for (int i = 0; i < n; ++i) {
            qp.H[i][i] = dot(G.column[i], G.column[i]) + U(diagonal_[i]);
            trace += qp.H[i][i];
            qp.g[i] = U(-scale_[i] * weights_.input_change[i] * previous.command.thrust[i]);
            for (int r = 0; r < 6; ++r) qp.g[i] -= G.column[i][r] * U(target.b[r]);
            qp.lower[i] = U(lower_[i]);
            qp.upper[i] = U(upper_[i]);
            s.qp.active[i] = U(previous.active[i]);
        }
        const U unit = U(int(n)) / trace;
        for (int i = 0; i < n; ++i) {
            qp.g[i] *= unit;
            qp.H[i][i] *= unit;
#pragma GCC unroll 8
            for (int j = 0; j < i; ++j) qp.H[i][j] = dot(G.column[i], G.column[j]) * unit;
        }
        solve(qp, s.qp);
        s.cost = cost<U>(target, G, s.qp.x, previous);
        return s;
    }

    /// The same at one angle, or a pack of angles, of a single servo.
    template <class U> Solved<U> solve_at_angle(const Target& target, const U& angle, const Allocation<T, N>& previous) const {
        PerServo<U> tilt;
        tilt[0] = angle;
        return solve_at<U>(target, trigonometry_of(tilt, 1), previous);
    }

    /// G = C A(α) f_scale
    template <class U> WrenchMatrix<U, N> weighted_map(const Target& target, const WrenchMatrix<U, N>& A) const {
        const Mat3<U> force_gain = cast<U>(target.force_gain);
        WrenchMatrix<U, N> G;
        for (int i = 0; i < vehicle_.n_rotors; ++i) {
            const Vec3<U> force = force_gain * force_of(A.column[i]), torque = torque_of(A.column[i]);
            G.column[i] = {{force[0], force[1], force[2], torque[0], torque[1], torque[2]}};
        }
        return G;
    }

    template <class U>
    U cost(const Target& target, const WrenchMatrix<U, N>& G, const PerRotor<U, N>& x, const Allocation<T, N>& previous) const {
        Vec6<U> miss;
        for (int r = 0; r < 6; ++r) miss[r] = U(target.b[r]);
        U inputs = U(0);
        for (int i = 0; i < vehicle_.n_rotors; ++i) {
            for (int r = 0; r < 6; ++r) miss[r] -= G.column[i][r] * x[i];
            const U thrust = U(scale_[i]) * x[i];
            const U change = thrust - U(previous.command.thrust[i]);
            inputs += U(weights_.input[i]) * thrust * thrust + U(weights_.input_change[i]) * change * change;
        }
        return inputs + dot(miss, miss);
    }

    TiltCandidates<T> candidates_of(TiltSpan span, int spaced, const Allocation<T, N>& previous, const T& epsilon) const {
        return {span, spaced, previous.command.tilt[0], epsilon, vehicle_.angle_min[0], vehicle_.angle_max[0]};
    }

    Allocation<T, N> best_of(const Target& target, const TiltCandidates<T>& candidates, const Allocation<T, N>& previous) const {
        if constexpr (lane_count<T> == 1) {
            return best_in_lanes(target, candidates, previous);
        } else {
            return best_in_turn(target, candidates, previous);
        }
    }

    /// Tilts k to k + 3 of one vehicle in a register; lanes beyond the last repeat the first.
    template <class Tilts> static Lanes side_by_side(const Tilts& tilts, int k, int count) {
        Lanes four(tilts[k]);
        for (int lane = 1; lane < 4; ++lane) four.set(lane, k + lane < count ? tilts[k + lane] : four[0]);
        return four;
    }

    /// The candidates of one vehicle, four at a time.
    Allocation<T, N> best_in_lanes(const Target& target, const TiltCandidates<T>& candidates, const Allocation<T, N>& previous) const {
        const int count = candidates.count();
        Allocation<T, N> best = best_of_four(target, side_by_side(candidates, 0, count), previous);
        for (int k = 4; k < count; k += 4) {
            const Allocation<T, N> next = best_of_four(target, side_by_side(candidates, k, count), previous);
            if (next.cost < best.cost) best = next;
        }
        return best;
    }

    Allocation<T, N> best_of_four(const Target& target, const Lanes& tilts, const Allocation<T, N>& previous) const {
        const Solved<Lanes> solved = solve_at_angle(target, tilts, previous);
        int best = 0;
        for (int lane = 1; lane < 4; ++lane)
            if (solved.cost[lane] < solved.cost[best]) best = lane;
        Solved<T> one;
        for (int i = 0; i < vehicle_.n_rotors; ++i) {
            one.qp.x[i] = solved.qp.x[i][best];
            one.qp.active[i] = solved.qp.active[i][best];
        }
        one.qp.kkt_residual = solved.qp.kkt_residual[best];
        one.cost = solved.cost[best];
        PerServo<T> chosen;
        chosen[0] = tilts[best];
        return answer<T>(target, one, chosen);
    }

    /// The candidates of many vehicles, one after the other; each lane keeps its own best.
    Allocation<T, N> best_in_turn(const Target& target, const TiltCandidates<T>& candidates, const Allocation<T, N>& previous) const {
        Allocation<T, N> best = at_tilt(target, candidates[0], previous);
        for (int k = 1; k < candidates.count(); ++k) {
            const Allocation<T, N> next = at_tilt(target, candidates[k], previous);
            best = selected(next.cost < best.cost, next, best);
        }
        return best;
    }

    Allocation<T, N> at_tilt(const Target& target, const T& angle, const Allocation<T, N>& previous) const {
        PerServo<T> tilt;
        tilt[0] = angle;
        return answer<T>(target, solve_at_angle(target, angle, previous), tilt);
    }

    /// Lane by lane, one of two answers for a single servo to the same target.
    Allocation<T, N> selected(const Mask<T>& mask, const Allocation<T, N>& yes, const Allocation<T, N>& no) const {
        Allocation<T, N> out = no;
        for (int i = 0; i < vehicle_.n_rotors; ++i) {
            out.command.thrust[i] = select(mask, yes.command.thrust[i], no.command.thrust[i]);
            out.active[i] = select(mask, yes.active[i], no.active[i]);
        }
        out.command.tilt[0] = select(mask, yes.command.tilt[0], no.command.tilt[0]);
        out.cost = select(mask, yes.cost, no.cost);
        out.kkt_residual = select(mask, yes.kkt_residual, no.kkt_residual);
        return out;
    }

    template <class U> Allocation<T, N> answer(const Target& target, const Solved<U>& solved, const PerServo<T>& tilt) const {
        Allocation<T, N> out;
        out.command.tilt = tilt;
        for (int i = 0; i < vehicle_.n_rotors; ++i) {
            out.command.thrust[i] = scale_[i] * solved.qp.x[i];
            out.active[i] = solved.qp.active[i];
        }
        out.cost = solved.cost;
        out.kkt_residual = solved.qp.kkt_residual;
        out.wrench_asked = target.wrench_asked;
        return out;
    }

    Vehicle<T, N> vehicle_;
    AllocationWeights<T, N> weights_;
    PerRotor<T, N> scale_;             // f_scale, the larger limit of each rotor
    WrenchMap<T, N> map_;              // A f_scale, its torque rows times W2^½ J⁻¹
    PerRotor<T, N> lower_, upper_;     // limits of x
    PerRotor<T, N> diagonal_;          // (W1 + W3) f_scale²
    Vec6<T> root_weight_;              // W2^½
    Vec3<T> linear_gain_;              // W2^½ / m
};

}  // namespace omnimorph
