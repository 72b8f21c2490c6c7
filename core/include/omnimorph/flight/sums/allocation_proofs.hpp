// What the allocation commanded, and whether it proved its answers.
#pragma once

#include "summed_row.hpp"

namespace omnimorph {

template <class T> struct AllocationProofs {
    T saturated_rows = T(0);    // a thrust was commanded to one of its limits
    T kkt_residual_max = T(0);  // NaN if a residual is none
    T unproven_steps = T(0);    // control steps whose residual is larger than what proves an answer
    T control_steps = T(0), steps_with_residual = T(0);  // in all, and those in which it is a number

    static constexpr auto fields() {
        using S = AllocationProofs;
        return field_list(field("saturated_rows", &S::saturated_rows), field("kkt_residual_max", &S::kkt_residual_max),
                          field("unproven_steps", &S::unproven_steps), field("control_steps", &S::control_steps),
                          field("steps_with_residual", &S::steps_with_residual));
    }

    template <int N> OMNIMORPH_FN void add(const SummedRow<T, N>& row) {
        const Allocation<T, N>& decided = row.x.decided;
        T bounds = T(0);
        for (int i = 0; i < row.model.n_rotors; ++i) bounds += abs(decided.active[i]);
        saturated_rows += row.counted(select(bounds > T(0), T(1), T(0)));
        kkt_residual_max = select(row.counts, max_or_nan(kkt_residual_max, decided.kkt_residual), kkt_residual_max);
        if (!row.is_decided) return;
        const T& residual = decided.kkt_residual;
        unproven_steps += row.counted(select(residual > row.proof, T(1), T(0)));
        control_steps += row.counted(T(1));
        steps_with_residual += row.counted(select(residual == residual, T(1), T(0)));
    }
};

}  // namespace omnimorph
