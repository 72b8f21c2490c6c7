// Joint allocation: the thrusts and every tilt of a vehicle at once, for any number of servos.
//
//     J(f, α) = ‖u‖²_W1 + ‖q̈_r − q̈(f, α)‖²_W2 + ‖u − u⁻‖²_W3 + W4 ‖(α − α⁻)/ε‖²
//
// over f_min <= f <= f_max, |α_j − α_j⁻| <= ε_j and the limits of the servos, where ε_j is what a control step allows.
//
// J is convex in the thrusts and not in the tilts. So the thrusts are eliminated: φ(α) = min J(f, α) over f, a box QP
// in n variables, and φ falls by Newton's method within the bounds. Its Hessian is the Schur complement of that of J in
// the n + m variables, over the thrusts that are free, with the second derivatives of the wrench: among answers of one
// wrench the effort gets all its curvature from them. A step counts only if φ falls, and is halved until it does. Where
// no part of it does - φ has kinks in its slope, where a thrust reaches a limit, and curves downwards in places - the
// next is damped: with enough of that it goes down the gradient, which is continuous, so that only a point without one
// ends it.
//
// (One box QP in n + m variables steps out of the narrow curved valley of equal wrenches, and is halved back; where the
// effort decides, as in the paper's Case A, six servos took it more than twice as many steps.)
//
// The residual that proves the answer is that of J: max |z − clamp(z − ∇J/2)| over z = (x, α), with α in rad and ∇J
// divided by the mean of the diagonal of the Hessian in x, as at a fixed tilt.
//
// The steps: start_at, then newton_step and line_search (which calls solve_at_tilts) until converged, then
// store_answer.
#pragma once

#include <utility>

#include "fixed_tilt.hpp"
#include "indefinite_step.hpp"
#include "tilt_candidates.hpp"

namespace omnimorph {

template <class T> struct JointTilt {
    static constexpr const char* name = "joint-tilt";
    T tilt_change_weight = T(0);  // W4, for a change of a tilt by all that a control step allows

    static constexpr auto fields() { return field_list(field("tilt_change_weight", &JointTilt::tilt_change_weight)); }
};

namespace joint_tilt {

/// Of the residual; where J stops falling, that of a proven box QP is enough.
template <class T> inline constexpr double tolerance = is_double<T> ? 1e-11 : 1e-5;
template <class T> inline constexpr double rounding = is_double<T> ? 1e-12 : 1e-4;  // of J, relative
inline constexpr double least_damping = 1e-3, first_damping = 0.1, largest_damping = 1e8;
inline constexpr int max_steps = 400;  // a few are usual
inline constexpr int max_halvings = 12;

/// One control step of a vehicle with M servos, or (0) with a number of servos counted at run time.
template <class T, int N, int M> struct Context {
    const AllocationProblem<T, N>& problem;
    const AllocationTarget<T>& target;
    const Command<T, N>& previous;
    Count<N> n;
    Count<M> m;
    PerVariable<T, M> lower, upper;           // limits of the tilts
    PerVariable<T, M> before, change_weight;  // α⁻ and W4 / ε²
};

/// φ and its first derivatives at some tilts, with what the second ones are made of.
template <class T, int N, int M> struct Point {
    PerVariable<T, M> tilt, gradient;  // the latter of φ/2, scaled as the box QP of the thrusts
    ThrustQp<T, N> thrusts;
    BoxQpSolution<T, N> best;          // best.x = f / f_scale
    Triangle<T, N> factors;            // of the Hessian over the thrusts that are free
    WrenchMatrix<T, N> G;              // C A(α) f_scale
    PerVariable<Vec6<T>, M> jacobian;  // ∂(G x)/∂α_j
    PerRotor<T, N> cross_term;         // (b − G x)' ∂G_i/∂α
    PerVariable<T, M> curvature;       // −(b − G x)' ∂²(G x)/∂α_j²
    T cost, residual;
};

template <class T, int N, int M>
OMNIMORPH_FN Context<T, N, M> context_of(const JointTilt<T>& rule, const AllocationProblem<T, N>& problem,
                                         const AllocationTarget<T>& target, const Command<T, N>& previous,
                                         const PerServo<T>& tilt_change, Count<M> m) {
    Context<T, N, M> c{problem, target, previous, problem.vehicle.n_rotors, m, {}, {}, {}, {}};
    for (int j = 0; j < c.m; ++j) {
        const T low = c.problem.vehicle.angle_min[j], high = c.problem.vehicle.angle_max[j];
        c.before[j] = clamp(c.previous.tilt[j], low, high);
        c.lower[j] = max(c.before[j] - tilt_change[j], low);
        c.upper[j] = min(c.before[j] + tilt_change[j], high);
        c.change_weight[j] = rule.tilt_change_weight / (tilt_change[j] * tilt_change[j]);
    }
    return c;
}

/// The box QP of the thrusts at the tilts of p.
template <class T, int N, int M>
OMNIMORPH_FN TiltTrigonometry<T> set_thrust_qp(const Context<T, N, M>& c, Point<T, N, M>& p) {
    PerServo<T> angle;
    for (int j = 0; j < c.m; ++j) angle[j] = p.tilt[j];
    const TiltTrigonometry<T> trig = trigonometry_of(angle, c.m);
    p.G = weighted_map<T, N, T>(c.problem, c.target, trig);
    set_hessian(c.problem, p.G, p.thrusts);
    set_gradient(c.problem, c.target, p.G, c.previous.thrust, p.thrusts);
    return trig;
}

/// φ, its gradient and the residual. The error is carried back to where the map is, so that only one column for each
/// servo need be weighted.
template <class T, int N, int M>
OMNIMORPH_FN void differentiate(const Context<T, N, M>& c, const TiltTrigonometry<T>& trig, Point<T, N, M>& p) {
    const WrenchMap<T, N>& map = c.problem.map;
    const Vec6<T> error = weighted_error(c.problem, c.target, p.G, p.best.x);
    const Vec6<T> pulled = pulled_back(c.target, error);
    for (int j = 0; j < c.m; ++j) {
        p.jacobian[j] = Vec6<T>::zero();
        p.curvature[j] = T(0);
    }
    for (int i = 0; i < c.n && c.m > 0; ++i) {
        const int j = c.problem.vehicle.servo[i];
        const Vec6<T> slope = map.tilt_derivative(i, trig);
        p.cross_term[i] = dot(pulled, slope);
        p.jacobian[j] = p.jacobian[j] + p.best.x[i] * slope;
        p.curvature[j] += p.best.x[i] * (dot(error, p.G.column[i]) - dot(pulled, map.constant[i]));
    }
    p.cost = allocation_cost(c.problem, error, p.best.x, c.previous.thrust);
    p.residual = p.best.kkt_residual;
    for (int j = 0; j < c.m; ++j) {
        p.jacobian[j] = weighted(c.target, p.jacobian[j]);
        const T change = p.tilt[j] - c.before[j];
        p.cost += c.change_weight[j] * change * change;
        p.gradient[j] = p.thrusts.unit * (c.change_weight[j] * change - dot(error, p.jacobian[j]));
        const T slack = p.tilt[j] - clamp(p.tilt[j] - p.gradient[j], c.lower[j], c.upper[j]);
        p.residual = max_or_nan(p.residual, abs(slack));
    }
}

/// Where the thrusts are the best at their tilts already.
template <class T, int N, int M>
OMNIMORPH_FN void start_at(const Context<T, N, M>& c, const Allocation<T, N>& begin, Point<T, N, M>& p) {
    for (int j = 0; j < c.m; ++j) p.tilt[j] = clamp(begin.command.tilt[j], c.lower[j], c.upper[j]);
    for (int i = 0; i < c.n; ++i) {
        p.best.x[i] = clamp(begin.command.thrust[i] / c.problem.scale[i], c.problem.lower[i], c.problem.upper[i]);
        p.best.active[i] = begin.active[i];
    }
    p.best.kkt_residual = begin.kkt_residual;
    differentiate(c, set_thrust_qp(c, p), p);
}

/// The best thrusts at the tilts of p, starting from an active set.
template <class T, int N, int M>
OMNIMORPH_FN void solve_at_tilts(const Context<T, N, M>& c, const PerVariable<T, N>& active, Point<T, N, M>& p) {
    const TiltTrigonometry<T> trig = set_thrust_qp(c, p);
    for (int i = 0; i < c.n; ++i) p.best.active[i] = active[i];
    solve(p.thrusts.qp, p.best, p.factors);
    differentiate(c, trig, p);
}

/// The factors that belong to the active set of p.
template <class T, int N, int M> OMNIMORPH_FN void factorise(Point<T, N, M>& p) {
    BoxQpSolution<T, N> again;
    again.active = p.best.active;
    box_qp::solve_free(p.thrusts.qp, again, p.factors);
}

/// The Hessian of J/2 in thrusts and tilts, [H B'; B E], with the thrusts that are free eliminated: E − B H⁻¹ B'.
template <class T, int N, int M>
OMNIMORPH_FN void set_reduced_hessian(const Context<T, N, M>& c, const Point<T, N, M>& p, BoxQp<T, M>& qp) {
    const T unit = p.thrusts.unit;
    const Triangle<T, N>& L = p.factors;
    PerVariable<PerVariable<T, N>, M> B;  // and then L⁻¹ B'
    for (int j = 0; j < c.m; ++j) {
        for (int i = 0; i < c.n; ++i) {
            const T cross = c.problem.vehicle.servo[i] == j ? p.cross_term[i] : T(0);
            B[j][i] = select(p.best.active[i] == T(0), unit * (dot(p.jacobian[j], p.G.column[i]) - cross), T(0));
        }
        for (int i = 0; i < c.n; ++i)
            for (int k = i + 1; k < c.n; ++k) B[j][k] -= L[k][i] * B[j][i];
        for (int l = 0; l <= j; ++l) {
            qp.H[j][l] = unit * dot(p.jacobian[j], p.jacobian[l]);
            for (int i = 0; i < c.n; ++i) qp.H[j][l] -= B[j][i] * B[l][i] * L[i][i];
        }
        qp.H[j][j] += unit * (p.curvature[j] + c.change_weight[j]);
    }
}

/// The increments of the tilts, and where they end at a bound. Damping, a share of the largest entry on the diagonal of
/// the Hessian that is added to all of them, turns the step into a short one down the gradient.
template <class T, int N, int M>
OMNIMORPH_FN BoxQpSolution<T, M> newton_step(const Context<T, N, M>& c, const Point<T, N, M>& p, const T& damping) {
    BoxQp<T, M> qp;
    BoxQpSolution<T, M> step;
    qp.n = c.m;
    set_reduced_hessian(c, p, qp);
    T largest = T(0);
    for (int j = 0; j < c.m; ++j) largest = max(largest, abs(qp.H[j][j]));
    for (int j = 0; j < c.m; ++j) {
        qp.H[j][j] += damping * largest;
        qp.g[j] = p.gradient[j];
        qp.lower[j] = c.lower[j] - p.tilt[j];
        qp.upper[j] = c.upper[j] - p.tilt[j];
        const Mask<T> is_low = p.tilt[j] <= c.lower[j], falls_below = p.gradient[j] > T(0);
        const Mask<T> is_high = p.tilt[j] >= c.upper[j], falls_above = p.gradient[j] < T(0);
        step.active[j] = select(is_low & falls_below, T(-1), select(is_high & falls_above, T(1), T(0)));
    }
    step_down(qp, step, damping > T(0));
    return step;
}

/// Lane by lane, the point `other` instead of `point`; they may change places.
template <class T, int N, int M>
OMNIMORPH_FN void select_point(const Context<T, N, M>& c, const Mask<T>& mask, Point<T, N, M>*& point,
                               Point<T, N, M>*& other) {
    if (all(mask)) std::swap(point, other);
    if (!any(mask) || all(mask)) return;
    for (int j = 0; j < c.m; ++j) point->tilt[j] = select(mask, other->tilt[j], point->tilt[j]);
    for (int i = 0; i < c.n; ++i) {
        point->best.x[i] = select(mask, other->best.x[i], point->best.x[i]);
        point->best.active[i] = select(mask, other->best.active[i], point->best.active[i]);
    }
    point->best.kkt_residual = select(mask, other->best.kkt_residual, point->best.kkt_residual);
    differentiate(c, set_thrust_qp(c, *point), *point);
    factorise(*point);
}

/// Go along a step as far as J falls, a half of it, a quarter … Where J is constant to rounding, the residual must
/// fall. True in the lanes that moved; those that are done stay.
template <class T, int N, int M>
OMNIMORPH_FN Mask<T> line_search(const Context<T, N, M>& c, const BoxQpSolution<T, M>& step, const Mask<T>& done,
                                 Point<T, N, M>*& here, Point<T, N, M>*& next) {
    Mask<T> open = !done, moved = T(0) < T(0);
    const PerVariable<T, M> start = here->tilt;
    const PerVariable<T, N> active = here->best.active;
    T share = T(1);
    for (int k = 0; k <= max_halvings && any(open); ++k, share *= T(0.5)) {
        for (int j = 0; j < c.m; ++j) {
            const T ahead = clamp(start[j] + share * step.x[j], c.lower[j], c.upper[j]);
            const T at_bound = select(step.active[j] > T(0), c.upper[j], ahead);
            const T end = select(step.active[j] < T(0), c.lower[j], at_bound);
            next->tilt[j] = k == 0 ? end : ahead;
        }
        solve_at_tilts(c, active, *next);
        const Mask<T> level = next->cost <= here->cost * T(1 + rounding<T>);
        const Mask<T> lower = next->cost < here->cost * T(1 - rounding<T>);
        const Mask<T> falls = lower | (level & (next->residual < here->residual));
        select_point<T, N, M>(c, open & falls, here, next);
        moved = moved | (open & falls);
        open = open & !(falls | level);
    }
    return moved;
}

/// From an answer that is the best at its tilts, down to where φ has no slope; its end is not above where it began.
template <class T, int N, int M> OMNIMORPH_FN void descend(const Context<T, N, M>& c, Allocation<T, N>& answer) {
    Point<T, N, M> points[2], *here = &points[0], *next = &points[1];  // exchanged, as they are large
    start_at(c, answer, *here);
    Mask<T> done = here->residual <= T(tolerance<T>);
    if (any(!done)) factorise(*here);
    T damping = T(0);
    for (int k = 0; k < max_steps && any(!done); ++k) {
        const T before = here->cost;
        const Mask<T> moved = line_search<T, N, M>(c, newton_step(c, *here, damping), done, here, next);
        const Mask<T> level = (!moved) | (here->cost >= before * T(1 - box_qp::proven<T>));
        const T less = select(damping > T(least_damping), damping * T(1.0 / 16), T(0));
        damping = select(moved, less, max(T(4) * damping, T(first_damping)));
        const Mask<T> proven = level & (here->residual <= T(box_qp::proven<T>));
        done = done | (here->residual <= T(tolerance<T>)) | proven | (damping > T(largest_damping));
    }
    store_answer(c.problem, c.target, here->best, here->cost, here->residual, answer);
    for (int j = 0; j < c.m; ++j) answer.command.tilt[j] = here->tilt[j];
}

/// visit(number of servos), as a type of its own where it is usual for N rotors. In lanes that gains little, and takes
/// long to compile.
template <class T, int N, class Visit> OMNIMORPH_FN void with_servo_count(int m, Visit&& visit) {
    if constexpr (lane_count<T> == 1) {
        if (m == 1) return visit(Count<1>());
        if constexpr (N > 1) {
            if (m == N) return visit(Count<N>());
        }
        if constexpr (N > 2 && N % 2 == 0) {
            if (m == N / 2) return visit(Count<N / 2>());
        }
    }
    visit(Count<0>(m));
}

}  // namespace joint_tilt

/// Thrusts and tilts, each tilt within what a control step allows of the one before. For a single servo the descent
/// begins at the best of the paper's three candidates, otherwise at the tilts as they are.
template <class T, int N>
OMNIMORPH_FN void allocate(const JointTilt<T>& rule, const AllocationProblem<T, N>& problem,
                           const PerServo<T>& tilt_change, const Motion<T>& estimate, const Demand<T>& demand,
                           Allocation<T, N>& last, AllocationCache<T, N>& cache) {
    const Command<T, N> previous = last.command;
    const AllocationTarget<T> target = allocation_target(problem, estimate, demand);
    if (problem.vehicle.n_servos == 1) {
        choose_tilt(TiltCandidates{TiltSpan::window, 3}, problem, tilt_change[0], target, last, cache);
    } else {
        hold_tilt(problem, target, last, cache);
    }
    joint_tilt::with_servo_count<T, N>(problem.vehicle.n_servos, [&](auto m) {
        joint_tilt::descend(joint_tilt::context_of(rule, problem, target, previous, tilt_change, m), last);
    });
}

}  // namespace omnimorph
