// Allocation at the tilts of the last command.
#pragma once

#include "thrust_qp.hpp"

namespace omnimorph {

struct FixedTilt {
    static constexpr const char* name = "fixed-tilt";
    static constexpr auto fields() { return field_list(); }
};

/// The best thrusts at the tilts of `last`, which becomes the answer.
template <class T, int N>
OMNIMORPH_FN void hold_tilt(const AllocationProblem<T, N>& problem, const AllocationTarget<T>& target,
                            Allocation<T, N>& last, AllocationCache<T, N>& cache) {
    BoxQpSolution<T, N> solution;
    const T cost = solve_thrusts(problem, target, last.command.tilt, last, cache.fixed, solution);
    store_answer(problem, target, solution, cost, solution.kkt_residual, last);
}

template <class T, int N>
OMNIMORPH_FN void allocate(const FixedTilt&, const AllocationProblem<T, N>& problem, const PerServo<T>&,
                           const Motion<T>& estimate, const Demand<T>& demand, Allocation<T, N>& last,
                           AllocationCache<T, N>& cache) {
    hold_tilt(problem, allocation_target(problem, estimate, demand), last, cache);
}

}  // namespace omnimorph
