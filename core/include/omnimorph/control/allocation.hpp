// Allocation by whatever rule. This is the one place that knows all rules: a rule is a file of its own with a record of
// settings and a function `allocate`, and a line here.
#pragma once

#include <variant>

#include "fixed_tilt.hpp"
#include "joint_tilt.hpp"
#include "tilt_candidates.hpp"

namespace omnimorph {

template <class T> using AllocationRule = std::variant<FixedTilt, TiltCandidates, JointTilt<T>>;

template <class T, int N> struct AllocationSettings {
    AllocationWeights<T, N> weights;  // of the problem as it is built
    PerServo<T> tilt_change;          // ε: each servo's rate limit times the control period, rad
    AllocationRule<T> rule;

    static constexpr auto fields() {
        using S = AllocationSettings;
        return field_list(field("weights", &S::weights), field("tilt_change", &S::tilt_change),
                          field("rule", &S::rule));
    }
};

/// The answer before a first one: a command, no bound active.
template <class T, int N>
OMNIMORPH_FN Allocation<T, N> first_allocation(const Vehicle<T, N>& vehicle, const Command<T, N>& start) {
    Allocation<T, N> first{start, {}, T(0), T(0), Vec6<T>::zero()};
    for (int i = 0; i < vehicle.n_rotors; ++i) first.active[i] = T(0);
    return first;
}

/// Solve one control step: `last` is the last answer on entry and the new one on return.
template <class T, int N>
OMNIMORPH_FN void allocate(const AllocationSettings<T, N>& settings, const AllocationProblem<T, N>& problem,
                           const Motion<T>& estimate, const Demand<T>& demand, Allocation<T, N>& last,
                           AllocationCache<T, N>& cache) {
    std::visit([&](const auto& rule) { allocate(rule, problem, settings.tilt_change, estimate, demand, last, cache); },
               settings.rule);
}

}  // namespace omnimorph
