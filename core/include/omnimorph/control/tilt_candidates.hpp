// Allocation of a vehicle with a single servo by trying tilts: the thrusts are the best at each of them, and the tilt
// of the least cost is taken. Three candidates in the window are the paper's rule (its Sec. 3).
#pragma once

#include "thrust_qp.hpp"

namespace omnimorph {

/// Where the tilts lie that one control step tries: a step to either side of α⁻, or anywhere in the servo's limits.
enum class TiltSpan { window, range };

struct TiltCandidates {
    static constexpr const char* name = "tilt-candidates";
    TiltSpan span = TiltSpan::window;
    int count = 3;  // evenly spaced, an odd number; in a window α⁻ is the middle one, in the range α⁻ is tried too

    static constexpr auto fields() {
        return field_list(field("span", &TiltCandidates::span), field("count", &TiltCandidates::count));
    }
};

/// The tilts that one control step tries, within the servo's limits; number 0 is α⁻, so that a tie goes to it.
template <class T> struct CandidateTilts {
    TiltCandidates rule;
    T before, change;  // α⁻, and ε, the most that the tilt may change
    T low, high;

    OMNIMORPH_FN int count() const { return rule.span == TiltSpan::window ? rule.count : rule.count + 1; }

    OMNIMORPH_FN T operator[](int k) const {
        if (k == 0) return clamp(before, low, high);
        if (rule.span == TiltSpan::range)
            return clamp(low + T(double(k - 1) / (rule.count - 1)) * (high - low), low, high);
        const int away = k % 2 == 1 ? -(k + 1) / 2 : k / 2;  // -1, 1, -2, 2 …: the nearest first
        return clamp(before + T(double(away) / (rule.count / 2)) * change, low, high);
    }
};

namespace tilt_candidates {

/// The best thrusts at an angle of the servo, or at a pack of angles.
template <class U, int N> struct Candidate {
    BoxQpSolution<U, N> thrusts;
    U cost, tilt;
};

template <class T, int N, class U>
OMNIMORPH_FN void solve_candidate(const AllocationProblem<T, N>& problem, const AllocationTarget<T>& target,
                                  const U& tilt, const Allocation<T, N>& last, TiltCache<U, N>& cache,
                                  Candidate<U, N>& out) {
    PerServo<U> angle;
    angle[0] = tilt;
    out.cost = solve_thrusts(problem, target, angle, last, cache, out.thrusts);
    out.tilt = tilt;
}

/// The other candidate instead, where the mask says so.
template <class T, int N>
OMNIMORPH_FN void select_candidate(const Mask<T>& mask, const Candidate<T, N>& other, int n, Candidate<T, N>& best) {
    for (int i = 0; i < n; ++i) {
        best.thrusts.x[i] = select(mask, other.thrusts.x[i], best.thrusts.x[i]);
        best.thrusts.active[i] = select(mask, other.thrusts.active[i], best.thrusts.active[i]);
    }
    best.thrusts.kkt_residual = select(mask, other.thrusts.kkt_residual, best.thrusts.kkt_residual);
    best.cost = select(mask, other.cost, best.cost);
    best.tilt = select(mask, other.tilt, best.tilt);
}

/// Candidates one after the other; where T has lanes, each keeps its own best.
template <class T, int N>
OMNIMORPH_FN void best_in_turn(const AllocationProblem<T, N>& problem, const AllocationTarget<T>& target,
                               const CandidateTilts<T>& tilts, const Allocation<T, N>& last,
                               AllocationCache<T, N>& cache, Candidate<T, N>& best) {
    solve_candidate(problem, target, tilts[0], last, cache.candidate[0], best);
    Candidate<T, N> next;
    for (int k = 1; k < tilts.count(); ++k) {
        solve_candidate(problem, target, tilts[k], last, cache.candidate[k % cache.candidates], next);
        select_candidate<T, N>(next.cost < best.cost, next, problem.vehicle.n_rotors, best);
    }
}

/// Tilts k, k + 1 … of one vehicle in a register; lanes beyond the last repeat the first of them.
template <class T, class Tilts> OMNIMORPH_FN CandidateLanes<T> side_by_side(const Tilts& tilts, int k, int count) {
    CandidateLanes<T> out(tilts[k]);
    for (int l = 1; l < candidate_lanes<T>; ++l) set_lane(out, l, k + l < count ? tilts[k + l] : lane(out, 0));
    return out;
}

/// The lane of the least number, the first of them.
template <class U> OMNIMORPH_FN int least_lane(const U& x) {
    int least = 0;
    for (int l = 1; l < lane_count<U>; ++l)
        if (lane(x, l) < lane(x, least)) least = l;
    return least;
}

template <class U, class T, int N>
OMNIMORPH_FN void take_lane(const Candidate<U, N>& many, int index, int n, Candidate<T, N>& one) {
    for (int i = 0; i < n; ++i) {
        one.thrusts.x[i] = lane(many.thrusts.x[i], index);
        one.thrusts.active[i] = lane(many.thrusts.active[i], index);
    }
    one.thrusts.kkt_residual = lane(many.thrusts.kkt_residual, index);
    one.cost = lane(many.cost, index);
    one.tilt = lane(many.tilt, index);
}

/// Candidates of one vehicle, as many at a time as a register has lanes.
template <class T, int N>
OMNIMORPH_FN void best_in_lanes(const AllocationProblem<T, N>& problem, const AllocationTarget<T>& target,
                                const CandidateTilts<T>& tilts, const Allocation<T, N>& last,
                                AllocationCache<T, N>& cache, Candidate<T, N>& best) {
    const int count = tilts.count(), n = problem.vehicle.n_rotors;
    Candidate<CandidateLanes<T>, N> next;
    solve_candidate(problem, target, side_by_side<T>(tilts, 0, count), last, cache.candidate[0], next);
    take_lane(next, least_lane(next.cost), n, best);
    for (int k = candidate_lanes<T>; k < count; k += candidate_lanes<T>) {
        solve_candidate(problem, target, side_by_side<T>(tilts, k, count), last, cache.candidate[0], next);
        const int least = least_lane(next.cost);
        if (lane(next.cost, least) < best.cost) take_lane(next, least, n, best);
    }
}

}  // namespace tilt_candidates

/// The best of the candidates from `last` on, which becomes the answer. In the range, the tilt goes by at most ε
/// towards it.
template <class T, int N>
OMNIMORPH_FN void choose_tilt(const TiltCandidates& rule, const AllocationProblem<T, N>& problem, const T& tilt_change,
                              const AllocationTarget<T>& target, Allocation<T, N>& last, AllocationCache<T, N>& cache) {
    const CandidateTilts<T> tilts{rule, last.command.tilt[0], tilt_change, problem.vehicle.angle_min[0],
                                  problem.vehicle.angle_max[0]};
    tilt_candidates::Candidate<T, N> best;
    if constexpr (candidate_lanes<T> == 1) {
        tilt_candidates::best_in_turn(problem, target, tilts, last, cache, best);
    } else {
        tilt_candidates::best_in_lanes(problem, target, tilts, last, cache, best);
    }
    if (rule.span == TiltSpan::range) {
        const T tilt = clamp(best.tilt, tilts[0] - tilt_change, tilts[0] + tilt_change);
        const Mask<T> is_too_far = !(tilt == best.tilt);
        if (any(is_too_far)) {
            tilt_candidates::Candidate<T, N> nearer;
            tilt_candidates::solve_candidate(problem, target, tilt, last, cache.fixed, nearer);
            tilt_candidates::select_candidate(is_too_far, nearer, problem.vehicle.n_rotors, best);
        }
    }
    store_answer(problem, target, best.thrusts, best.cost, best.thrusts.kkt_residual, last);
    last.command.tilt[0] = best.tilt;
}

template <class T, int N>
OMNIMORPH_FN void allocate(const TiltCandidates& rule, const AllocationProblem<T, N>& problem,
                           const PerServo<T>& tilt_change, const Motion<T>& estimate, const Demand<T>& demand,
                           Allocation<T, N>& last, AllocationCache<T, N>& cache) {
    choose_tilt(rule, problem, tilt_change[0], allocation_target(problem, estimate, demand), last, cache);
}

/// The least cost at each of `count` tilts of a single servo of one vehicle (T is a scalar).
template <class T, int N>
OMNIMORPH_FN void cost_over_tilt(const AllocationProblem<T, N>& problem, const Motion<T>& estimate,
                                 const Demand<T>& demand, const Allocation<T, N>& last, const T* tilt, int count,
                                 T* cost) {
    const AllocationTarget<T> target = allocation_target(problem, estimate, demand);
    TiltCache<CandidateLanes<T>, N> cache;
    tilt_candidates::Candidate<CandidateLanes<T>, N> next;
    for (int k = 0; k < count; k += candidate_lanes<T>) {
        const CandidateLanes<T> tilts = tilt_candidates::side_by_side<T>(tilt, k, count);
        tilt_candidates::solve_candidate(problem, target, tilts, last, cache, next);
        for (int l = 0; l < candidate_lanes<T> && k + l < count; ++l) cost[k + l] = lane(next.cost, l);
    }
}

}  // namespace omnimorph
