// Allocation at tilts that are given or tried one by one: at each, the problem is a box QP in the thrusts, divided by the
// mean of the diagonal of its Hessian, so that tolerances mean the same for every vehicle.
#pragma once

#include "../math/pack.hpp"
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

template <class T, int N> class Allocator : protected OldProblem<T, N> {
  public:
    using OldProblem<T, N>::OldProblem;

    // Each way to allocate is given the last answer and makes the next one of it: nothing that large is copied.

    /// The thrusts at the previous tilt.
    void at_fixed_tilt(const Motion<T>& state, const Vec6<T>& acceleration, Allocation<T, N>& last) {
        const Target target(*this, state, acceleration);
        tell(target, solve_at<T>(target, last.command.tilt, last, kept_[0]), last);
    }

    /// The best of `candidates` tilts of a single servo from α⁻ − ε to α⁻ + ε; of three, this is the paper's rule (its Sec. 3).
    void best_in_window(const Motion<T>& state, const Vec6<T>& acceleration, Allocation<T, N>& last, const T& epsilon, int candidates) {
        const Target target(*this, state, acceleration);
        tell(target, best_of(target, candidates_of(TiltSpan::window, candidates, last, epsilon), last), last);
    }

    /// From α⁻ by at most ε towards the best of α⁻ and `candidates` tilts over the whole range of a single servo.
    void towards_best_in_range(const Motion<T>& state, const Vec6<T>& acceleration, Allocation<T, N>& last, const T& epsilon, int candidates) {
        const Target target(*this, state, acceleration);
        const TiltCandidates<T> tried = candidates_of(TiltSpan::range, candidates, last, epsilon);
        Candidate<T> best = best_of(target, tried, last);
        const T tilt = clamp(best.tilt, tried[0] - epsilon, tried[0] + epsilon);
        const Mask<T> too_far = !(tilt == best.tilt);
        if (any(too_far)) best.take(too_far, at_tilt(target, tilt, last, kept_[0]), vehicle_.n_rotors);
        tell(target, best, last);
    }

    /// The least cost at each of `count` tilts of a single servo, four of them side by side (T is a scalar).
    void cost_over_tilt(const Motion<T>& state, const Vec6<T>& acceleration, const Allocation<T, N>& previous, const T* tilt, int count, T* cost) const {
        const Target target(*this, state, acceleration);
        AtTilt<Lanes> at;
        for (int k = 0; k < count; k += 4) {
            const Candidate<Lanes> four = at_tilt(target, side_by_side(tilt, k, count), previous, at);
            for (int lane = 0; lane < 4 && k + lane < count; ++lane) cost[k + lane] = four.cost[lane];
        }
    }

  protected:
    using Problem = OldProblem<T, N>;
    using typename Problem::Target;
    using Problem::diagonal_, Problem::lower_, Problem::map_, Problem::scale_, Problem::upper_, Problem::vehicle_, Problem::weights_;

    template <class U> struct ThrustQp {
        BoxQp<U, N> qp;
        U unit;  // it is half of J times this
    };

    /// The part of the box QP that does not depend on what is asked for; U is T or a pack of candidates of one vehicle.
    template <class U> void set_hessian(const WrenchMatrix<U, N>& G, ThrustQp<U>& out) const {
        const Count<N> n = vehicle_.n_rotors;
        BoxQp<U, N>& qp = out.qp;
        qp.n = n;
        qp.is_factored = false;
        U trace = U(0);
        for (int i = 0; i < n; ++i) {
            qp.H[i][i] = dot(G.column[i], G.column[i]) + U(diagonal_[i]);
            trace += qp.H[i][i];
            qp.lower[i] = U(lower_[i]);
            qp.upper[i] = U(upper_[i]);
        }
        const U unit = out.unit = U(int(n)) / trace;
        for (int i = 0; i < n; ++i) {
            qp.H[i][i] *= unit;
#pragma GCC unroll 8
            for (int j = 0; j < i; ++j) qp.H[i][j] = dot(G.column[i], G.column[j]) * unit;
        }
    }

    template <class U>
    void set_gradient(const Target& target, const WrenchMatrix<U, N>& G, const Allocation<T, N>& previous, ThrustQp<U>& out) const {
        for (int i = 0; i < vehicle_.n_rotors; ++i) {
            U g = U(-scale_[i] * weights_.input_change[i] * previous.command.thrust[i]);
            for (int r = 0; r < 6; ++r) g -= G.column[i][r] * U(target.b[r]);
            out.qp.g[i] = g * out.unit;
        }
    }

  private:
    using Lanes = Pack<Scalar<T>, 4>;  // candidates of one vehicle

    /// The best thrusts at given tilts.
    template <class U> struct Solved {
        PerVariable<U, N> x, active;
        U cost, kkt_residual;
    };
    /// The same at an angle of a single servo.
    template <class U> struct Candidate : Solved<U> {
        U tilt;

        /// The other one instead, where the mask says so.
        void take(const Mask<U>& mask, const Candidate& other, int n) {
            for (int i = 0; i < n; ++i) {
                this->x[i] = select(mask, other.x[i], this->x[i]);
                this->active[i] = select(mask, other.active[i], this->active[i]);
            }
            this->cost = select(mask, other.cost, this->cost);
            this->kkt_residual = select(mask, other.kkt_residual, this->kkt_residual);
            tilt = select(mask, other.tilt, tilt);
        }
    };

    /// What is known of the problem at some tilts. Where the map holds all of W2 it is the same in every attitude, so that it
    /// serves again as long as the tilts stay: always, for a vehicle whose rotors do not tilt.
    template <class U> struct AtTilt {
        bool is_known = false;
        PerServo<U> tilt;
        WrenchMatrix<U, N> G;
        ThrustQp<U> thrusts;
    };

    template <class U> void look_at(const Target& target, const PerServo<U>& tilt, AtTilt<U>& at) const {
        const int m = vehicle_.n_servos;
        bool stays = target.in_body && at.is_known;
        for (int j = 0; j < m; ++j) stays = stays && !any(!(tilt[j] == at.tilt[j]));
        if (stays) return;
        for (int j = 0; j < m; ++j) at.tilt[j] = tilt[j];
        at.G = this->template weighted_map<U>(target, trigonometry_of(tilt, m));
        set_hessian(at.G, at.thrusts);
        at.is_known = true;
    }

    template <class U>
    Solved<U> solve_at(const Target& target, const PerServo<U>& tilt, const Allocation<T, N>& previous, AtTilt<U>& at) const {
        look_at(target, tilt, at);
        set_gradient(target, at.G, previous, at.thrusts);
        BoxQpSolution<U, N> s;
        for (int i = 0; i < vehicle_.n_rotors; ++i) s.active[i] = U(previous.active[i]);
        solve(at.thrusts.qp, s);
        return {s.x, s.active, this->cost(this->missed(target, at.G, s.x), s.x, previous), s.kkt_residual};
    }

    /// The same at one angle, or a pack of angles, of a single servo.
    template <class U> Candidate<U> at_tilt(const Target& target, const U& tilt, const Allocation<T, N>& previous, AtTilt<U>& at) const {
        PerServo<U> angle;
        angle[0] = tilt;
        return {solve_at<U>(target, angle, previous, at), tilt};
    }

    TiltCandidates<T> candidates_of(TiltSpan span, int spaced, const Allocation<T, N>& previous, const T& epsilon) const {
        return {span, spaced, previous.command.tilt[0], epsilon, vehicle_.angle_min[0], vehicle_.angle_max[0]};
    }

    Candidate<T> best_of(const Target& target, const TiltCandidates<T>& candidates, const Allocation<T, N>& previous) {
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
    Candidate<T> best_in_lanes(const Target& target, const TiltCandidates<T>& candidates, const Allocation<T, N>& previous) {
        const int count = candidates.count();
        Candidate<T> best = best_of_four(target, side_by_side(candidates, 0, count), previous, kept_four_);
        for (int k = 4; k < count; k += 4) {
            const Candidate<T> next = best_of_four(target, side_by_side(candidates, k, count), previous, kept_four_);
            if (next.cost < best.cost) best = next;
        }
        return best;
    }

    Candidate<T> best_of_four(const Target& target, const Lanes& tilts, const Allocation<T, N>& previous, AtTilt<Lanes>& at) const {
        const Candidate<Lanes> four = at_tilt(target, tilts, previous, at);
        int best = 0;
        for (int lane = 1; lane < 4; ++lane)
            if (four.cost[lane] < four.cost[best]) best = lane;
        Candidate<T> one;
        for (int i = 0; i < vehicle_.n_rotors; ++i) {
            one.x[i] = four.x[i][best];
            one.active[i] = four.active[i][best];
        }
        one.cost = four.cost[best];
        one.kkt_residual = four.kkt_residual[best];
        one.tilt = tilts[best];
        return one;
    }

    /// The candidates of many vehicles, one after the other; each lane keeps its own best.
    Candidate<T> best_in_turn(const Target& target, const TiltCandidates<T>& candidates, const Allocation<T, N>& previous) {
        Candidate<T> best = at_tilt(target, candidates[0], previous, kept_[0]);
        for (int k = 1; k < candidates.count(); ++k) {
            const Candidate<T> next = at_tilt(target, candidates[k], previous, kept_[k % kept]);
            best.take(next.cost < best.cost, next, vehicle_.n_rotors);
        }
        return best;
    }

    /// Make an answer of what was found at the tilts that it holds already, or at a tilt of its own.
    void tell(const Target& target, const Solved<T>& found, Allocation<T, N>& answer) const {
        for (int i = 0; i < vehicle_.n_rotors; ++i) {
            answer.command.thrust[i] = scale_[i] * found.x[i];
            answer.active[i] = found.active[i];
        }
        answer.cost = found.cost;
        answer.kkt_residual = found.kkt_residual;
        answer.wrench_asked = target.wrench_asked;
    }
    void tell(const Target& target, const Candidate<T>& found, Allocation<T, N>& answer) const {
        tell(target, static_cast<const Solved<T>&>(found), answer);
        answer.command.tilt[0] = found.tilt;
    }

    static constexpr int kept = lane_count<T> == 1 ? 1 : 3;  // as many as the paper's candidates, if they are solved in turn
    AtTilt<T> kept_[kept];
    AtTilt<Lanes> kept_four_;
};

}  // namespace omnimorph
