// The thrusts at given tilts: a box QP, divided by the mean of the diagonal of its Hessian, so that tolerances mean the
// same for every vehicle; and the cache of what it shares with the step before.
#pragma once

#include "allocation_problem.hpp"
#include "box_qp.hpp"

// Four candidates of one vehicle fit into a register; with OMNIMORPH_SCALAR, for a compiler that has no vector
// extensions, they are solved one after the other, and the answer is the same to the last bit.
#ifndef OMNIMORPH_SCALAR
#include "../math/pack.hpp"
#endif

namespace omnimorph {

/// Candidates of one vehicle side by side: four of a scalar; one, where the lanes are vehicles already.
#ifdef OMNIMORPH_SCALAR
template <class T> using CandidateLanes = T;
#else
template <class T> using CandidateLanes = std::conditional_t<std::is_floating_point_v<T>, Pack<T, 4>, T>;
#endif
template <class T> inline constexpr int candidate_lanes = lane_count<CandidateLanes<T>> / lane_count<T>;

template <class U, int N> struct ThrustQp {
    BoxQp<U, N> qp;
    U unit;  // it is half of J times this
};

/// What is known of the problem at some tilts. Where the map holds all of W2 it is the same in every attitude, so that
/// it serves again as long as the tilts stay: always, for a vehicle whose rotors do not tilt.
template <class U, int N> struct TiltCache {
    long version = 0;  // of the problem; with the tilts, the key
    PerServo<U> tilt;
    WrenchMatrix<U, N> G;
    ThrustQp<U, N> thrusts;
};

/// The caches of one vehicle's allocation, by whatever rule; an empty one gives the same bits. It belongs to one
/// problem.
template <class T, int N> struct AllocationCache {
    static constexpr int candidates = candidate_lanes<T> == 1 ? 3 : 1;  // the paper's three, if they are solved in turn
    TiltCache<T, N> fixed;
    TiltCache<CandidateLanes<T>, N> candidate[candidates];
};

/// The part of the box QP that does not depend on what is asked for; U is T or a pack of candidates of one vehicle.
template <class T, int N, class U>
OMNIMORPH_FN void set_hessian(const AllocationProblem<T, N>& problem, const WrenchMatrix<U, N>& G,
                              ThrustQp<U, N>& out) {
    const Count<N> n = problem.vehicle.n_rotors;
    BoxQp<U, N>& qp = out.qp;
    qp.n = n;
    qp.is_factored = false;
    U trace = U(0);
    for (int i = 0; i < n; ++i) {
        qp.H[i][i] = dot(G.column[i], G.column[i]) + U(problem.diagonal[i]);
        trace += qp.H[i][i];
        qp.lower[i] = U(problem.lower[i]);
        qp.upper[i] = U(problem.upper[i]);
    }
    const U unit = out.unit = U(int(n)) / trace;
    for (int i = 0; i < n; ++i) {
        qp.H[i][i] *= unit;
#pragma GCC unroll 8
        for (int j = 0; j < i; ++j) qp.H[i][j] = dot(G.column[i], G.column[j]) * unit;
    }
}

template <class T, int N, class U>
OMNIMORPH_FN void set_gradient(const AllocationProblem<T, N>& problem, const AllocationTarget<T>& target,
                               const WrenchMatrix<U, N>& G, const PerRotor<T, N>& previous, ThrustQp<U, N>& out) {
    for (int i = 0; i < problem.vehicle.n_rotors; ++i) {
        U g = U(-problem.scale[i] * problem.weights.input_change[i] * previous[i]);
        for (int r = 0; r < 6; ++r) g -= G.column[i][r] * U(target.b[r]);
        out.qp.g[i] = g * out.unit;
    }
}

/// Make the cache one of these tilts.
template <class T, int N, class U>
OMNIMORPH_FN void update_cache(const AllocationProblem<T, N>& problem, const AllocationTarget<T>& target,
                               const PerServo<U>& tilt, TiltCache<U, N>& cache) {
    const int m = problem.vehicle.n_servos;
    bool is_current = target.in_body && cache.version == problem.version;
    for (int j = 0; j < m; ++j) is_current = is_current && !any(!(tilt[j] == cache.tilt[j]));
    if (is_current) return;
    for (int j = 0; j < m; ++j) cache.tilt[j] = tilt[j];
    cache.G = weighted_map<T, N, U>(problem, target, trigonometry_of(tilt, m));
    set_hessian(problem, cache.G, cache.thrusts);
    cache.version = problem.version;
}

/// The best thrusts at given tilts, starting from the active set of the last answer; returns their cost J.
template <class T, int N, class U>
OMNIMORPH_FN U solve_thrusts(const AllocationProblem<T, N>& problem, const AllocationTarget<T>& target,
                             const PerServo<U>& tilt, const Allocation<T, N>& last, TiltCache<U, N>& cache,
                             BoxQpSolution<U, N>& solution) {
    update_cache(problem, target, tilt, cache);
    set_gradient(problem, target, cache.G, last.command.thrust, cache.thrusts);
    for (int i = 0; i < problem.vehicle.n_rotors; ++i) solution.active[i] = U(last.active[i]);
    solve(cache.thrusts.qp, solution);
    const Vec6<U> error = weighted_error(problem, target, cache.G, solution.x);
    return allocation_cost(problem, error, solution.x, last.command.thrust);
}

/// Make an answer of the thrusts that were found; its tilts are left as they are.
template <class T, int N>
OMNIMORPH_FN void store_answer(const AllocationProblem<T, N>& problem, const AllocationTarget<T>& target,
                               const BoxQpSolution<T, N>& solution, const T& cost, const T& kkt_residual,
                               Allocation<T, N>& answer) {
    for (int i = 0; i < problem.vehicle.n_rotors; ++i) {
        answer.command.thrust[i] = problem.scale[i] * solution.x[i];
        answer.active[i] = solution.active[i];
    }
    answer.cost = cost;
    answer.kkt_residual = kkt_residual;
    answer.wrench_asked = target.wrench_asked;
}

}  // namespace omnimorph
