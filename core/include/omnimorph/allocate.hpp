// Allocation at tilts that are given or tried one by one: at each, the problem is a box QP in the thrusts, divided by the
// mean of the diagonal of its Hessian, so that tolerances mean the same for every vehicle.
#pragma once

#include "allocation_problem.hpp"

namespace omnimorph {

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

template <class T, int N> class Allocator : protected AllocationProblem<T, N> {
  public:
    using AllocationProblem<T, N>::AllocationProblem;

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

  protected:
    using Problem = AllocationProblem<T, N>;
    using typename Problem::Target;
    using Problem::diagonal_, Problem::lower_, Problem::map_, Problem::scale_, Problem::upper_, Problem::vehicle_, Problem::weights_;

    template <class U> struct ThrustQp {
        BoxQp<U, N> qp;
        U unit;  // it is half of J times this
    };

    /// The box QP at one tilt, or at a pack of them; U is T or a pack of candidates of one vehicle.
    template <class U>
    void set_thrust_qp(const Target& target, const WrenchMatrix<U, N>& G, const Allocation<T, N>& previous, ThrustQp<U>& out) const {
        const Count<N> n = vehicle_.n_rotors;
        BoxQp<U, N>& qp = out.qp;
        qp.n = n;
        U trace = U(0);
        for (int i = 0; i < n; ++i) {
            qp.H[i][i] = dot(G.column[i], G.column[i]) + U(diagonal_[i]);
            trace += qp.H[i][i];
            qp.g[i] = U(-scale_[i] * weights_.input_change[i] * previous.command.thrust[i]);
            for (int r = 0; r < 6; ++r) qp.g[i] -= G.column[i][r] * U(target.b[r]);
            qp.lower[i] = U(lower_[i]);
            qp.upper[i] = U(upper_[i]);
        }
        const U unit = out.unit = U(int(n)) / trace;
        for (int i = 0; i < n; ++i) {
            qp.g[i] *= unit;
            qp.H[i][i] *= unit;
#pragma GCC unroll 8
            for (int j = 0; j < i; ++j) qp.H[i][j] = dot(G.column[i], G.column[j]) * unit;
        }
    }

  private:
    using Lanes = Pack<Scalar<T>, 4>;  // candidates of one vehicle

    template <class U> struct Solved {
        BoxQpSolution<U, N> qp;
        U cost;
    };

    template <class U>
    Solved<U> solve_at(const Target& target, const TiltTrigonometry<U>& trig, const Allocation<T, N>& previous) const {
        const WrenchMatrix<U, N> G = this->template weighted_map<U>(target, map_.template at<U>(trig));
        Solved<U> s;
        for (int i = 0; i < vehicle_.n_rotors; ++i) s.qp.active[i] = U(previous.active[i]);
        ThrustQp<U> thrusts;
        set_thrust_qp(target, G, previous, thrusts);
        solve(thrusts.qp, s.qp);
        s.cost = this->cost(this->missed(target, G, s.qp.x), s.qp.x, previous);
        return s;
    }

    /// The same at one angle, or a pack of angles, of a single servo.
    template <class U> Solved<U> solve_at_angle(const Target& target, const U& angle, const Allocation<T, N>& previous) const {
        PerServo<U> tilt;
        tilt[0] = angle;
        return solve_at<U>(target, trigonometry_of(tilt, 1), previous);
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

};

}  // namespace omnimorph
