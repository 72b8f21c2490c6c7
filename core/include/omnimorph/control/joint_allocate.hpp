// Joint allocation: the thrusts and every tilt of a vehicle at once, for any number of servos.
//
//     J(f, α) = ‖u‖²_W1 + ‖q̈_r − q̈(f, α)‖²_W2 + ‖u − u⁻‖²_W3 + W4 ‖(α − α⁻)/ε‖²
//
// over f_min <= f <= f_max, |α_j − α_j⁻| <= ε_j and the limits of the servos, where ε_j is what a control step allows.
//
// J is convex in the thrusts and not in the tilts. So the thrusts are eliminated: φ(α) = min J(f, α) over f, a box QP in n
// variables, and φ falls by Newton's method within the bounds. Its Hessian is the Schur complement of that of J in the
// n + m variables, over the thrusts that are free, with the second derivatives of the wrench: among answers of one
// wrench the effort gets all its curvature from them. A step counts only if φ falls, and is halved until it does. Where no
// part of it does - φ has kinks in its slope, where a thrust reaches a limit, and curves downwards in places - the next is
// damped: with enough of that it goes down the gradient, which is continuous, so that only a point without one ends it.
//
// (One box QP in n + m variables steps out of the narrow curved valley of equal wrenches, and is halved back; where the
// effort decides, as in the paper's Case A, six servos took it more than twice as many steps.)
//
// The residual that proves the answer is that of J: max |z − clamp(z − ∇J/2)| over z = (x, α), with α in rad and ∇J divided
// by the mean of the diagonal of the Hessian in x, as at a fixed tilt.
#pragma once

#include <utility>

#include "allocate.hpp"

namespace omnimorph {

namespace joint {


template <class T> inline constexpr double tolerance = is_double<T> ? 1e-11 : 1e-5;    // of the residual; proven is enough where J stops falling
template <class T> inline constexpr double rounding = is_double<T> ? 1e-12 : 1e-4;     // of J, relative
template <class T> inline constexpr double least_pivot = is_double<T> ? 1e-12 : 1e-5;  // of the scaled Hessian
inline constexpr double beyond_any_bound = 1e4;  // rad
inline constexpr double least_damping = 1e-3, first_damping = 0.1, most_damping = 1e8;
inline constexpr int most_steps = 400;  // a few are usual
inline constexpr int most_halvings = 12;

/// A step x to lower x'Hx/2 + g'x within bounds, H of any sign: to the minimum over the variables that are free, and along a
/// direction in which there is none, until a bound stops it; again with that variable held. Those `active` at first stay.
/// A `damped` step takes no such direction, whose first part may lead uphill: a pivot of LDL' counts by its size.
template <class T, int M> OMNIMORPH_FN void step_down(const BoxQp<T, M>& qp, BoxQpSolution<T, M>& s, const Mask<T>& damped) {
    for (int j = 0; j < qp.n; ++j) s.x[j] = T(0);
    Mask<T> arrived = T(0) < T(0);
    for (int k = 0; k <= qp.n && any(!arrived); ++k) {
        Triangle<T, M> K;
        PerVariable<T, M> unused{};
        box_qp::take_out(qp, s.active, K, unused);
        const PerVariable<T, M> gradient = box_qp::gradient(qp, s.x);
        PerVariable<T, M> way, downward;
        Mask<T> unbounded = T(0) < T(0);
        for (int j = 0; j < qp.n; ++j) way[j] = select(s.active[j] == T(0), -gradient[j], T(0));
        for (int j = 0; j < qp.n; ++j) {  // LDL', up to the first negative pivot
            const T pivot = select(damped, abs(K[j][j]), K[j][j]);
            const Mask<T> here = (!unbounded) & (pivot < T(-least_pivot<T>));
            downward[j] = select(here, T(1), T(0));
            unbounded = unbounded | here;
            const T inverse_pivot = select(unbounded, T(0), T(1) / max(pivot, T(least_pivot<T>)));
            for (int i = qp.n - 1; i > j; --i) {  // from the last row on, so that those above are still as they were
                const T share = K[i][j] * inverse_pivot;
                for (int l = j + 1; l <= i; ++l) K[i][l] -= share * K[l][j];
                way[i] -= share * way[j];
                K[i][j] = share;
            }
            way[j] = way[j] * inverse_pivot;
        }
        T slope = T(0);
        for (int j = qp.n - 1; j >= 0; --j) {
            way[j] = select(unbounded, downward[j], way[j]);
            for (int i = j + 1; i < qp.n; ++i) way[j] -= K[i][j] * way[i];
            slope += gradient[j] * way[j];
        }
        const T length = select(unbounded, select(slope > T(0), T(-beyond_any_bound), T(beyond_any_bound)), T(1));
        PerVariable<T, M> target, share;
        for (int j = 0; j < qp.n; ++j) target[j] = s.x[j] + length * way[j];
        const T least = box_qp::feasible_share(qp, s.x, target, share);
        for (int j = 0; j < qp.n; ++j) {
            const Mask<T> stopped = (share[j] <= least) & !arrived, below = target[j] < s.x[j];
            const T reached = select(stopped, select(below, qp.lower[j], qp.upper[j]), s.x[j] + least * (target[j] - s.x[j]));
            s.x[j] = select(arrived, s.x[j], reached);
            s.active[j] = select(stopped, select(below, T(-1), T(1)), s.active[j]);
        }
        arrived = arrived | !(least < T(1));
    }
}

}  // namespace joint

template <class T, int N> class JointAllocator : public Allocator<T, N> {
  public:
    using Allocator<T, N>::Allocator;

    /// Thrusts and tilts, each tilt within `epsilon` of the one before. For a single servo the descent begins at the best
    /// of the paper's three candidates, otherwise at the tilts as they are; its end is not above where it began.
    void jointly(const Motion<T>& state, const Vec6<T>& acceleration, Allocation<T, N>& last, const PerServo<T>& epsilon) {
        const int m = vehicle_.n_servos;
        const Allocation<T, N> previous = last;
        if (m == 1) {
            this->best_in_window(state, acceleration, last, epsilon[0], 3);
        } else {
            this->at_fixed_tilt(state, acceleration, last);
        }
        const Target target(*this, state, acceleration);
        last = descended(target, last, previous, epsilon);
    }

  private:
    using Problem = Allocator<T, N>;
    using typename Problem::Target;
    using Problem::lower_, Problem::map_, Problem::scale_, Problem::upper_, Problem::vehicle_, Problem::weights_;

    Allocation<T, N> descended(const Target& target, const Allocation<T, N>& begin, const Allocation<T, N>& previous, const PerServo<T>& epsilon) const {
        if constexpr (lane_count<T> == 1) {  // in lanes a type for each number of servos gains little, and takes long to compile
            const int m = vehicle_.n_servos;
            if (m == 1) return Descent<1>(*this, target, previous, epsilon).from(begin);
            if constexpr (N > 1) {
                if (m == N) return Descent<N>(*this, target, previous, epsilon).from(begin);
            }
            if constexpr (N > 2 && N % 2 == 0) {
                if (m == N / 2) return Descent<N / 2>(*this, target, previous, epsilon).from(begin);
            }
        }
        return Descent<0>(*this, target, previous, epsilon).from(begin);
    }

    /// φ and its first derivatives at some tilts, with what the second ones are made of.
    template <int M> struct Point {
        PerVariable<T, M> tilt, gradient;                   // the latter of φ/2, scaled as the box QP of the thrusts
        typename Problem::template ThrustQp<T> thrusts;
        FactoredBoxQpSolution<T, N> best;                           // best.x = f / f_scale
        WrenchMatrix<T, N> G;                               // C A(α) f_scale
        PerVariable<Vec6<T>, M> turning;                    // ∂(G x)/∂α_j
        PerRotor<T, N> bending;                             // (b − G x)' ∂G_i/∂α
        PerVariable<T, M> curvature;                        // −(b − G x)' ∂²(G x)/∂α_j²
        T cost, residual;
    };

    /// One control step of a vehicle with M servos, or (0) with a number of servos counted at run time.
    template <int M> class Descent {
      public:
        Descent(const JointAllocator& allocator, const Target& target, const Allocation<T, N>& previous, const PerServo<T>& epsilon)
            : a_(allocator), target_(target), previous_(previous), n_(allocator.vehicle_.n_rotors), m_(allocator.vehicle_.n_servos) {
            for (int j = 0; j < m_; ++j) {
                const T low = a_.vehicle_.angle_min[j], high = a_.vehicle_.angle_max[j];
                stay_[j] = clamp(previous.command.tilt[j], low, high);
                lower_[j] = max(stay_[j] - epsilon[j], low);
                upper_[j] = min(stay_[j] + epsilon[j], high);
                change_weight_[j] = a_.weights_.tilt_change / (epsilon[j] * epsilon[j]);
            }
        }

        Allocation<T, N> from(const Allocation<T, N>& begin) const {
            Point<M> points[2], *here = &points[0], *spare = &points[1];  // exchanged, as they are large
            set_solved(*here, begin);
            Mask<T> done = here->residual <= T(joint::tolerance<T>);
            if (any(!done)) here->best.factors = factors_of(*here);
            T damping = T(0);
            for (int k = 0; k < joint::most_steps && any(!done); ++k) {
                const T before = here->cost;
                const Mask<T> moved = descend(here, spare, newton_step(*here, damping), done);
                const Mask<T> level = (!moved) | (here->cost >= before * T(1 - box_qp::proven<T>));
                const T less = select(damping > T(joint::least_damping), damping * T(1.0 / 16), T(0));
                damping = select(moved, less, max(T(4) * damping, T(joint::first_damping)));
                done = done | ((here->residual <= T(joint::tolerance<T>)) | (level & (here->residual <= T(box_qp::proven<T>))));
                done = done | (damping > T(joint::most_damping));
            }
            return answer(*here);
        }

      private:
        /// Thrusts that are the best at their tilts already.
        void set_solved(Point<M>& p, const Allocation<T, N>& begin) const {
            for (int j = 0; j < m_; ++j) p.tilt[j] = clamp(begin.command.tilt[j], lower_[j], upper_[j]);
            for (int i = 0; i < n_; ++i) {
                p.best.x[i] = clamp(begin.command.thrust[i] / a_.scale_[i], a_.lower_[i], a_.upper_[i]);
                p.best.active[i] = begin.active[i];
            }
            p.best.kkt_residual = begin.kkt_residual;
            differentiate(p, set_map(p));
        }

        auto factors_of(Point<M>& p) const {
            FactoredBoxQpSolution<T, N> again;
            again.active = p.best.active;
            box_qp::solve_free(p.thrusts.qp, again);
            return again.factors;
        }

        /// The best thrusts at the tilts of p, looked for from an active set on.
        void solve_at_tilts(Point<M>& p, const PerVariable<T, N>& active) const {
            const TiltTrigonometry<T> trig = set_map(p);
            for (int i = 0; i < n_; ++i) p.best.active[i] = active[i];
            solve(p.thrusts.qp, p.best);
            differentiate(p, trig);
        }

        TiltTrigonometry<T> set_map(Point<M>& p) const {
            PerServo<T> angle;
            for (int j = 0; j < m_; ++j) angle[j] = p.tilt[j];
            const TiltTrigonometry<T> trig = trigonometry_of(angle, m_);
            p.G = a_.template weighted_map<T>(target_, trig);
            a_.set_hessian(p.G, p.thrusts);
            a_.set_gradient(target_, p.G, previous_, p.thrusts);
            return trig;
        }

        /// The miss is carried back to where the map is, so that only one column for each servo need be weighted.
        void differentiate(Point<M>& p, const TiltTrigonometry<T>& trig) const {
            const Vec6<T> miss = a_.missed(target_, p.G, p.best.x);
            const Vec6<T> pull = target_.pulled_back(miss);
            for (int j = 0; j < m_; ++j) {
                p.turning[j] = Vec6<T>::zero();
                p.curvature[j] = T(0);
            }
            for (int i = 0; i < n_ && m_ > 0; ++i) {
                const int j = a_.vehicle_.servo[i];
                const Vec6<T> turned = a_.map_.tilt_derivative(i, trig);
                p.bending[i] = dot(pull, turned);
                p.turning[j] = p.turning[j] + p.best.x[i] * turned;
                p.curvature[j] += p.best.x[i] * (dot(miss, p.G.column[i]) - dot(pull, a_.map_.constant[i]));
            }
            p.cost = a_.cost(miss, p.best.x, previous_);
            p.residual = p.best.kkt_residual;
            for (int j = 0; j < m_; ++j) {
                p.turning[j] = target_.weighted(p.turning[j]);
                const T change = p.tilt[j] - stay_[j];
                p.cost += change_weight_[j] * change * change;
                p.gradient[j] = p.thrusts.unit * (change_weight_[j] * change - dot(miss, p.turning[j]));
                p.residual = max_or_nan(p.residual, abs(p.tilt[j] - clamp(p.tilt[j] - p.gradient[j], lower_[j], upper_[j])));
            }
        }

        /// The increments of the tilts, and where they end at a bound. Damping, a share of the largest entry on the diagonal of
        /// the Hessian that is added to all of them, turns the step into a short one down the gradient.
        BoxQpSolution<T, M> newton_step(const Point<M>& p, const T& damping) const {
            BoxQp<T, M> qp(m_);
            BoxQpSolution<T, M> step;
            set_reduced_hessian(p, qp);
            T largest = T(0);
            for (int j = 0; j < m_; ++j) largest = max(largest, abs(qp.H[j][j]));
            for (int j = 0; j < m_; ++j) {
                qp.H[j][j] += damping * largest;
                qp.g[j] = p.gradient[j];
                qp.lower[j] = lower_[j] - p.tilt[j];
                qp.upper[j] = upper_[j] - p.tilt[j];
                const Mask<T> low = (p.tilt[j] <= lower_[j]) & (p.gradient[j] > T(0)), high = (p.tilt[j] >= upper_[j]) & (p.gradient[j] < T(0));
                step.active[j] = select(low, T(-1), select(high, T(1), T(0)));
            }
            joint::step_down(qp, step, damping > T(0));
            return step;
        }

        /// The Hessian of J/2 in thrusts and tilts, [H B'; B E], with the thrusts that are free eliminated: E − B H⁻¹ B'.
        void set_reduced_hessian(const Point<M>& p, BoxQp<T, M>& qp) const {
            const T unit = p.thrusts.unit;
            const auto& L = p.best.factors;
            PerVariable<PerVariable<T, N>, M> B;  // and then L⁻¹ B'
            for (int j = 0; j < m_; ++j) {
                for (int i = 0; i < n_; ++i) {
                    const T bent = a_.vehicle_.servo[i] == j ? p.bending[i] : T(0);
                    B[j][i] = select(p.best.active[i] == T(0), unit * (dot(p.turning[j], p.G.column[i]) - bent), T(0));
                }
                for (int i = 0; i < n_; ++i)
                    for (int k = i + 1; k < n_; ++k) B[j][k] -= L[k][i] * B[j][i];
                for (int l = 0; l <= j; ++l) {
                    qp.H[j][l] = unit * dot(p.turning[j], p.turning[l]);
                    for (int i = 0; i < n_; ++i) qp.H[j][l] -= B[j][i] * B[l][i] * L[i][i];
                }
                qp.H[j][j] += unit * (p.curvature[j] + change_weight_[j]);
            }
        }

        /// Go along a step as far as J falls, a half of it, a quarter … Where J stays the same to rounding, the residual
        /// must fall. True in the lanes that moved; those that are done stay.
        Mask<T> descend(Point<M>*& here, Point<M>*& next, const BoxQpSolution<T, M>& step, const Mask<T>& done) const {
            Mask<T> open = !done, moved = T(0) < T(0);
            const PerVariable<T, M> start = here->tilt;
            const PerVariable<T, N> active = here->best.active;
            T share = T(1);
            for (int k = 0; k <= joint::most_halvings && any(open); ++k, share *= T(0.5)) {
                for (int j = 0; j < m_; ++j) {
                    const T ahead = clamp(start[j] + share * step.x[j], lower_[j], upper_[j]);
                    const T end = select(step.active[j] < T(0), lower_[j], select(step.active[j] > T(0), upper_[j], ahead));
                    next->tilt[j] = k == 0 ? end : ahead;
                }
                solve_at_tilts(*next, active);
                const Mask<T> level = next->cost <= here->cost * T(1 + joint::rounding<T>);
                const Mask<T> falls = (next->cost < here->cost * T(1 - joint::rounding<T>)) | (level & (next->residual < here->residual));
                take(open & falls, here, next);
                moved = moved | (open & falls);
                open = open & !(falls | level);
            }
            return moved;
        }

        /// Lane by lane, the point `other` instead of `point`; they may change places.
        void take(const Mask<T>& mask, Point<M>*& point, Point<M>*& other) const {
            if (all(mask)) std::swap(point, other);
            if (!any(mask) || all(mask)) return;
            for (int j = 0; j < m_; ++j) point->tilt[j] = select(mask, other->tilt[j], point->tilt[j]);
            for (int i = 0; i < n_; ++i) {
                point->best.x[i] = select(mask, other->best.x[i], point->best.x[i]);
                point->best.active[i] = select(mask, other->best.active[i], point->best.active[i]);
            }
            point->best.kkt_residual = select(mask, other->best.kkt_residual, point->best.kkt_residual);
            differentiate(*point, set_map(*point));
            point->best.factors = factors_of(*point);
        }

        Allocation<T, N> answer(const Point<M>& p) const {
            Allocation<T, N> out;
            for (int i = 0; i < n_; ++i) {
                out.command.thrust[i] = a_.scale_[i] * p.best.x[i];
                out.active[i] = p.best.active[i];
            }
            for (int j = 0; j < m_; ++j) out.command.tilt[j] = p.tilt[j];
            out.cost = p.cost;
            out.kkt_residual = p.residual;
            out.wrench_asked = target_.wrench_asked;
            return out;
        }

        const JointAllocator& a_;
        const Target& target_;
        const Allocation<T, N>& previous_;
        Count<N> n_;
        Count<M> m_;
        PerVariable<T, M> lower_, upper_;          // limits of the tilts
        PerVariable<T, M> stay_, change_weight_;   // α⁻ and W4 / ε²
    };
};

}  // namespace omnimorph
