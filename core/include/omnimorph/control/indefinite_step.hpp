// A step down a box QP whose Hessian may have any sign.
#pragma once

#include "box_qp.hpp"

namespace omnimorph {

namespace indefinite_step {

template <class T> inline constexpr double least_pivot = is_double<T> ? 1e-12 : 1e-5;  // of the scaled Hessian
inline constexpr double beyond_any_bound = 1e4;

/// A direction within the free variables, and how long it is: the whole Newton step where x'Hx/2 + g'x has a minimum
/// over them, otherwise a direction of negative curvature, to be followed until a bound stops it.
template <class T, int M> struct Direction {
    PerVariable<T, M> along;
    T length;
};

/// LDL' of the free variables, up to the first negative pivot. `damped`: a pivot counts by its size.
template <class T, int M>
OMNIMORPH_FN Direction<T, M> direction(const BoxQp<T, M>& qp, const PerVariable<T, M>& active,
                                       const PerVariable<T, M>& gradient, const Mask<T>& damped) {
    Triangle<T, M> K;
    PerVariable<T, M> unused{}, downward;
    box_qp::fix_active(qp, active, K, unused);
    Direction<T, M> out;
    PerVariable<T, M>& along = out.along;
    Mask<T> unbounded = T(0) < T(0);
    for (int j = 0; j < qp.n; ++j) along[j] = select(active[j] == T(0), -gradient[j], T(0));
    for (int j = 0; j < qp.n; ++j) {
        const T pivot = select(damped, abs(K[j][j]), K[j][j]);
        const Mask<T> here = (!unbounded) & (pivot < T(-least_pivot<T>));
        downward[j] = select(here, T(1), T(0));
        unbounded = unbounded | here;
        const T inverse_pivot = select(unbounded, T(0), T(1) / max(pivot, T(least_pivot<T>)));
        for (int i = qp.n - 1; i > j; --i) {  // from the last row on, so that those above are still as they were
            const T factor = K[i][j] * inverse_pivot;
            for (int l = j + 1; l <= i; ++l) K[i][l] -= factor * K[l][j];
            along[i] -= factor * along[j];
            K[i][j] = factor;
        }
        along[j] = along[j] * inverse_pivot;
    }
    T slope = T(0);
    for (int j = qp.n - 1; j >= 0; --j) {
        along[j] = select(unbounded, downward[j], along[j]);
        for (int i = j + 1; i < qp.n; ++i) along[j] -= K[i][j] * along[i];
        slope += gradient[j] * along[j];
    }
    out.length = select(unbounded, select(slope > T(0), T(-beyond_any_bound), T(beyond_any_bound)), T(1));
    return out;
}

}  // namespace indefinite_step

/// A step x to lower x'Hx/2 + g'x within bounds, H of any sign: to the minimum over the variables that are free, and
/// along a direction in which there is none, until a bound stops it; again with that variable held. Those `active` at
/// first stay. A `damped` step takes no such direction, whose first part may lead uphill.
template <class T, int M>
OMNIMORPH_FN void step_down(const BoxQp<T, M>& qp, BoxQpSolution<T, M>& s, const Mask<T>& damped) {
    for (int j = 0; j < qp.n; ++j) s.x[j] = T(0);
    Mask<T> arrived = T(0) < T(0);
    for (int k = 0; k <= qp.n && any(!arrived); ++k) {
        const auto way = indefinite_step::direction(qp, s.active, box_qp::gradient(qp, s.x), damped);
        PerVariable<T, M> target, ratio;
        for (int j = 0; j < qp.n; ++j) target[j] = s.x[j] + way.length * way.along[j];
        const T least = box_qp::ratio_test(qp, s.x, target, ratio);
        for (int j = 0; j < qp.n; ++j) {
            const Mask<T> stopped = (ratio[j] <= least) & !arrived, below = target[j] < s.x[j];
            const T bound = select(below, qp.lower[j], qp.upper[j]);
            const T reached = select(stopped, bound, s.x[j] + least * (target[j] - s.x[j]));
            s.x[j] = select(arrived, s.x[j], reached);
            s.active[j] = select(stopped, select(below, T(-1), T(1)), s.active[j]);
        }
        arrived = arrived | !(least < T(1));
    }
}

}  // namespace omnimorph
